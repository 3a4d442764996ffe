// The majorant of every cell of a volume: the largest opacity over the cell's value range.
//
// The range holds the smallest and largest stored value that interpolation inside the cell can touch. The transfer
// table is linear between entries, so its maximum over a range is the maximum of the entries that enclose it: two
// overlapping power-of-two windows of a range-maximum table (Bender and Farach-Colton, "The LCA Problem Revisited",
// 2000), exact for any shape of the transfer function.

struct MajorantParams {
    cell_count: u32,
    range_offset: u32,
    majorant_offset: u32,
    // Cells in a row of workgroups: a dispatch has at most 65535 workgroups along an axis.
    row_length: u32,
    table_scale: f32,
    table_bias: f32,
    padding: vec2u,
}

@group(0) @binding(0) var<uniform> params: MajorantParams;
// Smallest and largest stored value of a cell, as 16-bit fractions: low half, high half.
@group(0) @binding(1) var<storage, read> value_ranges: array<u32>;
// Level k, entry i: the largest opacity of entries i .. i + 2^k.
@group(0) @binding(2) var<storage, read> range_maxima: array<f32>;
@group(0) @binding(3) var<storage, read_write> majorants: array<f32>;

fn table_coordinate(fraction: u32) -> f32 {
    let texel = f32(fraction) / 65535.0;
    return clamp(texel * params.table_scale + params.table_bias, 0.0, f32(TABLE_SIZE - 1u));
}

@compute @workgroup_size(64)
fn majorant_grid(@builtin(global_invocation_id) id: vec3u) {
    let cell = id.y * params.row_length + id.x;
    if (cell >= params.cell_count) {
        return;
    }
    let range = value_ranges[params.range_offset + cell];
    let a_end = table_coordinate(range & 0xffffu);
    let b_end = table_coordinate(range >> 16u);
    // A negative rescale slope swaps the ends. A little more on either side is for rounding, of texture units and of
    // texels scaled to table entries.
    let slack = 0.01 + 1e-6 * abs(params.table_scale);
    let low = u32(max(floor(min(a_end, b_end) - slack), 0.0));
    let high = min(u32(ceil(max(a_end, b_end) + slack)), TABLE_SIZE - 1u);
    let level = firstLeadingBit(high - low + 1u);
    let a = range_maxima[level * TABLE_SIZE + low];
    let b = range_maxima[level * TABLE_SIZE + high + 1u - (1u << level)];
    majorants[params.majorant_offset + cell] = max(a, b);
}
