// The smallest and the largest stored value that filters can touch in each cell of a volume, from the voxels in the
// pools. Expects pools and texels.

struct ValueRangeParams {
    // Voxels along each axis.
    dims: vec3u,
    // Voxels along a side of a cell.
    cell_size: u32,
    grid_dims: vec3u,
    // Voxels that a filter touches beyond those on the faces of a cell: none for a linear one, 1 for the cubic one.
    reach: u32,
    bricks: vec3u,
    // Of this dispatch: the first cell, and how many.
    first_cell: u32,
    cell_count: u32,
    // Cells in a row of workgroups: a dispatch has at most 65535 workgroups along an axis.
    row_length: u32,
    // A bit for each pool: whether its values are stored in two parts.
    split_pools: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> params: ValueRangeParams;
@group(0) @binding(1) var<storage, read> pages: array<u32>;
// As 16-bit fractions: smallest in the low, largest in the high half.
@group(0) @binding(2) var<storage, read_write> ranges: array<u32>;

fn page_of(brick: vec3u) -> u32 {
    return pages[(brick.z * params.bricks.y + brick.y) * params.bricks.x + brick.x];
}

@compute @workgroup_size(64)
fn value_ranges(@builtin(global_invocation_id) id: vec3u) {
    let place = id.y * params.row_length + id.x;
    if (place >= params.cell_count) {
        return;
    }
    let index = params.first_cell + place;
    let n = params.grid_dims;
    let cell = vec3u(index % n.x, index / n.x % n.y, index / (n.x * n.y));
    // The points of cell c lie between the centres of the voxels (c - 1) * size and c * size.
    let before = vec3u(params.cell_size + params.reach);
    let begin = max(cell * params.cell_size, before) - before;
    let end = min(cell * params.cell_size + params.reach + 1u, params.dims);
    var low = 1.0;
    var high = 0.0;
    for (var z = begin.z; z < end.z; z++) {
        for (var y = begin.y; y < end.y; y++) {
            for (var x = begin.x; x < end.x; x++) {
                let voxel = vec3u(x, y, z);
                let page = page_of(voxel / BRICK_SIZE);
                let pool = pool_of(page);
                let texel = load_texel(pool, vec3i(brick_origin(page) + voxel % BRICK_SIZE));
                let weight = select(0.0, LOW_BYTE, ((params.split_pools >> pool) & 1u) != 0u);
                let value = stored_value(texel, weight);
                low = min(low, value);
                high = max(high, value);
            }
        }
    }
    // Integers come back as they were; what lies between two, as of half floats, is enclosed.
    let a = u32(floor(low * 65535.0 + 0.01));
    let b = u32(ceil(high * 65535.0 - 0.01));
    ranges[index] = a | (b << 16u);
}
