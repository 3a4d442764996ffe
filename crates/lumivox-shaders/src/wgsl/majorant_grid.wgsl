// The majorant of every cell of a volume, the largest opacity over the cell's value range, and beside it where the
// voxels are that the cell lies between. Expects `pools` and `cells`.
//
// The range holds the smallest and largest stored value that interpolation inside the cell can touch. The transfer
// table is linear between entries, so its maximum over a range is the maximum of the entries that enclose it: two
// overlapping power-of-two windows of a range-maximum table (Bender and Farach-Colton, "The LCA Problem Revisited",
// 2000), exact for any shape of the transfer function. Where there are labels, it is the largest of those that interpolation
// inside the cell can touch, each with the factor of its style. What clip shapes and peeling take off a whole cell is not
// counted, and what all points of a cell have in common is told by its class: both hold for the box around the cell, by
// interval arithmetic.

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
    shape_count: u32,
    // Whether something is peeled, by ranges of depths.
    has_depth: u32,
    grid_dims: vec3u,
    // Voxels along a side of a cell.
    cell_size: f32,
    bricks: vec3u,
    // What is peeled.
    peel_mm: f32,
    // Voxels along each axis.
    dims: vec3f,
    // One over the width of its border, in mm.
    peel_inverse_width: f32,
    // Rows of the map from voxel space to that of the depths.
    depth_from_voxel: array<vec4f, 3>,
    depth_grid_dims: vec3u,
    depth_cell_size: f32,
    // A stored depth times this, and this more, is one in mm.
    depth_scale: f32,
    depth_bias: f32,
    // Of the first shapes, those that rays are clipped against as a whole: its points are not.
    shapes_of_rays: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> params: MajorantParams;
// Smallest and largest stored value of a cell, as 16-bit fractions: low half, high half.
@group(0) @binding(1) var<storage, read> value_ranges: array<u32>;
// Level k, entry i: the largest opacity of entries i .. i + 2^k.
@group(0) @binding(2) var<storage, read> range_maxima: array<f32>;
@group(0) @binding(3) var<storage, read> pages: array<u32>;
// By label, CELL_STYLE_ROWS each: scale and bias of the table's coordinate, the first entry of its maxima, and the factor of
// the opacity; the place of its look among those that cells can name, or 0, whether shapes clip it, nothing. Then of each clip
// shape, CELL_SHAPE_ROWS: the rows of the map from voxel space to its own; its kind, 1 or -1 where it is inverted, nothing.
@group(0) @binding(4) var<storage, read> looks: array<vec4f>;
// Of each cell: seven labels, a byte each, then their number; SET_OF_MANY where they are more.
@group(0) @binding(5) var<storage, read> label_sets: array<vec2u>;
// Of the depths' own cells, as `value_ranges`.
@group(0) @binding(6) var<storage, read> depth_ranges: array<u32>;
@group(0) @binding(7) var<storage, read_write> grids: array<Cell>;

// A box in voxel space that holds all points of a cell, and a little more, for walks come to its faces by sums.
struct Around {
    center: vec3f,
    half_size: vec3f,
}

// The points of a cell lie between the centres of the voxels before and at its last, and within the volume.
fn around(cell: vec3u) -> Around {
    let end = vec3f(cell) * params.cell_size + 0.5;
    let low = clamp(end - params.cell_size, vec3f(0.0), params.dims);
    let high = clamp(end, vec3f(0.0), params.dims);
    return Around((low + high) / 2.0, (high - low) / 2.0 + 0.02);
}

// Where an affine map sends a box: the middle of its image, and how far that reaches along each axis.
fn image_of(box: Around, x: vec4f, y: vec4f, z: vec4f) -> Around {
    let middle = vec4f(box.center, 1.0);
    let half_size = box.half_size;
    return Around(
        vec3f(dot(x, middle), dot(y, middle), dot(z, middle)),
        vec3f(dot(abs(x.xyz), half_size), dot(abs(y.xyz), half_size), dot(abs(z.xyz), half_size)),
    );
}

// What a shape's level is at least and at most in a box: see `clip_level`.
fn level_range(shape: u32, box: Around) -> vec2f {
    let image = image_of(box, looks[shape], looks[shape + 1u], looks[shape + 2u]);
    let kind = u32(looks[shape + 3u].x);
    let far = abs(image.center) + image.half_size;
    let near = max(abs(image.center) - image.half_size, vec3f(0.0));
    var range = image.center.z + vec2f(-image.half_size.z, image.half_size.z);
    if (kind == CLIP_BOX) {
        range = 1.0 - vec2f(max(far.x, max(far.y, far.z)), max(near.x, max(near.y, near.z)));
    } else if (kind == CLIP_SPHERE) {
        range = 1.0 - vec2f(length(far), length(near));
    }
    return select(range, -range.yx, looks[shape + 3u].y < 0.0);
}

// What is taken off a cell.
struct TakenOff {
    // Whether shapes clip all of it.
    is_cut: bool,
    // Whether nothing has to be asked for at its points.
    is_whole: bool,
    // What peeling leaves of the opacity at most.
    left: f32,
}

fn taken_off(box: Around) -> TakenOff {
    var taken = TakenOff(false, true, 1.0);
    for (var i = 0u; i < params.shape_count; i++) {
        let range = level_range(CELL_STYLE_ROWS * params.style_count + CELL_SHAPE_ROWS * i, box);
        taken.is_cut = taken.is_cut || range.y < 0.0;
        taken.is_whole = taken.is_whole && (i < params.shapes_of_rays || range.x >= 0.0);
    }
    if (params.has_depth > 0u) {
        let depths = depths_in(box) * params.depth_scale + params.depth_bias;
        // A little to either side is for the rounding of texture units.
        let least = (min(depths.x, depths.y) - params.peel_mm) * params.peel_inverse_width + 0.49;
        let most = (max(depths.x, depths.y) - params.peel_mm) * params.peel_inverse_width + 0.51;
        taken.left = clamp(most, 0.0, 1.0);
        taken.is_whole = taken.is_whole && least >= 1.0;
    }
    return taken;
}

// The smallest and the largest stored depth that can be read in a box.
fn depths_in(box: Around) -> vec2f {
    let image = image_of(box, params.depth_from_voxel[0], params.depth_from_voxel[1], params.depth_from_voxel[2]);
    let last = vec3f(params.depth_grid_dims - 1u);
    let shift = params.depth_cell_size - 0.5;
    let begin = vec3u(clamp(floor((image.center - image.half_size + shift) / params.depth_cell_size), vec3f(0.0), last));
    let end = vec3u(clamp(floor((image.center + image.half_size + shift) / params.depth_cell_size), vec3f(0.0), last));
    var range = vec2f(65535.0, 0.0);
    for (var z = begin.z; z <= end.z; z++) {
        for (var y = begin.y; y <= end.y; y++) {
            for (var x = begin.x; x <= end.x; x++) {
                let words = depth_ranges[(z * params.depth_grid_dims.y + y) * params.depth_grid_dims.x + x];
                range = vec2f(min(range.x, f32(words & 0xffffu)), max(range.y, f32(words >> 16u)));
            }
        }
    }
    return range / 65535.0;
}

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

// What labels of a cell have in common.
struct OfLabels {
    majorant: f32,
    // The place of their look, or 0.
    look: u32,
}

fn with_label(all: OfLabels, label: u32, range: u32, is_cut: bool) -> OfLabels {
    let more = looks[CELL_STYLE_ROWS * label + 1u];
    let is_off = is_cut && more.y > 0.0;
    let own = select(largest(looks[CELL_STYLE_ROWS * label], range), 0.0, is_off);
    return OfLabels(max(all.majorant, own), select(0u, all.look, all.look == u32(more.x)));
}

fn of_labels(labels: vec2u, range: u32, is_cut: bool) -> OfLabels {
    let count = labels.y >> 24u;
    let is_many = count == SET_OF_MANY;
    var all = OfLabels(0.0, u32(looks[CELL_STYLE_ROWS * select(labels.x & 255u, 0u, is_many) + 1u].x));
    for (var i = 0u; i < select(count, params.style_count, is_many); i++) {
        let word = select(labels.x, labels.y, i >= 4u);
        let label = select((word >> (8u * (i % 4u))) & 255u, i, is_many);
        all = with_label(all, label, range, is_cut);
    }
    return all;
}

@compute @workgroup_size(64)
fn majorant_grid(@builtin(global_invocation_id) id: vec3u) {
    let index = id.y * params.row_length + id.x;
    if (index >= params.cell_count) {
        return;
    }
    let n = params.grid_dims;
    let cell = vec3u(index % n.x, index / n.x % n.y, index / (n.x * n.y));
    let taken = taken_off(around(cell));
    // The first label alone: one in the set, and a byte of 0.
    var labels = vec2u(0u, 1u << 24u);
    if (params.has_labels > 0u) {
        labels = label_sets[index];
    }
    let all = of_labels(labels, value_ranges[index], taken.is_cut);
    let in_common = all.look | select(0u, CLASS_IS_WHOLE, taken.is_whole);
    let brick = brick_of(cell);
    let page = pages[(brick.z * params.bricks.y + brick.y) * params.bricks.x + brick.x];
    let texel_from_voxel = vec3i(brick_origin(page)) - vec3i(brick * BRICK_SIZE);
    grids[params.majorant_offset + index] = cell_new(all.majorant * taken.left, in_common, pool_of(page), texel_from_voxel);
}

fn brick_of(cell: vec3u) -> vec3u {
    // The first cells, before the first voxels, belong to their neighbours' bricks.
    return (max(cell, vec3u(1u)) - 1u) / params.cells_per_brick;
}
