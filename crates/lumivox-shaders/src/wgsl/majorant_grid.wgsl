// The majorant of every cell of a volume, the largest opacity over the cell's value range, and beside it where the
// voxels are that the cell lies between. Expects `pools` and `cells`.
//
// The range holds the smallest and largest stored value that interpolation inside the cell can touch. The transfer
// table is linear between entries, so its maximum over a range is the maximum of the entries that enclose it: two
// overlapping power-of-two windows of a range-maximum table (Bender and Farach-Colton, "The LCA Problem Revisited",
// 2000), exact for any shape of the transfer function. Where there are labels, it is the largest of those that interpolation
// inside the cell can touch, each with the factor of its style.

struct MajorantParams {
    cell_count: u32,
    majorant_offset: u32,
    // Cells in a row of workgroups: a dispatch has at most 65535 workgroups along an axis.
    row_length: u32,
    // Along a side of a brick.
    cells_per_brick: u32,
    style_count: u32,
    // Whether cells have sets of labels; else, all are of the first style.
    has_labels: u32,
    padding: vec2u,
    grid_dims: vec3u,
    more_padding: u32,
    bricks: vec3u,
    last_padding: u32,
}

@group(0) @binding(0) var<uniform> params: MajorantParams;
// Smallest and largest stored value of a cell, as 16-bit fractions: low half, high half.
@group(0) @binding(1) var<storage, read> value_ranges: array<u32>;
// Level k, entry i: the largest opacity of entries i .. i + 2^k.
@group(0) @binding(2) var<storage, read> range_maxima: array<f32>;
@group(0) @binding(3) var<storage, read> pages: array<u32>;
// By label: scale and bias of the table's coordinate, the first entry of its maxima, and the factor of the opacity.
@group(0) @binding(4) var<storage, read> styles: array<vec4f>;
// Of each cell: seven labels, a byte each, then their number; SET_OF_MANY where they are more.
@group(0) @binding(5) var<storage, read> label_sets: array<vec2u>;
@group(0) @binding(6) var<storage, read_write> grids: array<Cell>;

fn table_coordinate(style: vec4f, fraction: u32) -> f32 {
    let texel = f32(fraction) / 65535.0;
    return clamp(texel * style.x + style.y, 0.0, f32(TABLE_SIZE - 1u));
}

// The largest opacity of a style over a range of stored values.
fn largest(style: vec4f, range: u32) -> f32 {
    if (style.w <= 0.0) {
        return 0.0;
    }
    let a_end = table_coordinate(style, range & 0xffffu);
    let b_end = table_coordinate(style, range >> 16u);
    // A negative rescale slope swaps the ends. A little more on either side is for rounding, of texture units and of
    // texels scaled to table entries.
    let slack = 0.01 + 1e-6 * abs(style.x);
    let low = u32(max(floor(min(a_end, b_end) - slack), 0.0));
    let high = min(u32(ceil(max(a_end, b_end) + slack)), TABLE_SIZE - 1u);
    let level = firstLeadingBit(high - low + 1u);
    let first = u32(style.z) + level * TABLE_SIZE;
    return style.w * max(range_maxima[first + low], range_maxima[first + high + 1u - (1u << level)]);
}

fn largest_of_labels(labels: vec2u, range: u32) -> f32 {
    var most = 0.0;
    let count = labels.y >> 24u;
    if (count == SET_OF_MANY) {
        for (var i = 0u; i < params.style_count; i++) {
            most = max(most, largest(styles[i], range));
        }
        return most;
    }
    for (var i = 0u; i < count; i++) {
        let word = select(labels.x, labels.y, i >= 4u);
        most = max(most, largest(styles[(word >> (8u * (i % 4u))) & 255u], range));
    }
    return most;
}

@compute @workgroup_size(64)
fn majorant_grid(@builtin(global_invocation_id) id: vec3u) {
    let cell = id.y * params.row_length + id.x;
    if (cell >= params.cell_count) {
        return;
    }
    let range = value_ranges[cell];
    var most = 0.0;
    if (params.has_labels > 0u) {
        most = largest_of_labels(label_sets[cell], range);
    } else {
        most = largest(styles[0], range);
    }
    let brick = brick_of(cell);
    let page = pages[(brick.z * params.bricks.y + brick.y) * params.bricks.x + brick.x];
    let texel_from_voxel = vec3i(brick_origin(page)) - vec3i(brick * BRICK_SIZE);
    grids[params.majorant_offset + cell] = cell_new(most, pool_of(page), texel_from_voxel);
}

fn brick_of(index: u32) -> vec3u {
    let n = params.grid_dims;
    let cell = vec3u(index % n.x, index / n.x % n.y, index / (n.x * n.y));
    // The first cells, before the first voxels, belong to their neighbours' bricks.
    return (max(cell, vec3u(1u)) - 1u) / params.cells_per_brick;
}
