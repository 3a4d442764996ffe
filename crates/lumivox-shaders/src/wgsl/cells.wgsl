// A cell of a majorant grid: its majorant, and where the voxels around it lie. The two are read together, for the point of
// a tentative collision is looked up next.
//
// The first word holds the upper half of the majorant's bits, then 13 bits for z and three for the pool; the second 16 for
// y and 16 for x. A voxel's texel in its pool is its index and x, y, z, all with a sign: volumes of up to MAX_BRICKS bricks
// along an axis can be told so.

struct Cell {
    words: vec2u,
}

fn cell_new(majorant: f32, pool: u32, texel_from_voxel: vec3i) -> Cell {
    // Rounded up: a majorant that is a little loose is one still.
    let bits = (bitcast<u32>(majorant) + 0xffffu) & 0xffff0000u;
    let d = vec3u(texel_from_voxel);
    return Cell(vec2u(bits | ((d.z & 0x1fffu) << 3u) | pool, (d.y << 16u) | (d.x & 0xffffu)));
}

fn cell_majorant(cell: Cell) -> f32 {
    return bitcast<f32>(cell.words.x & 0xffff0000u);
}

fn cell_pool(cell: Cell) -> u32 {
    return cell.words.x & (MAX_POOLS - 1u);
}

fn cell_texel_from_voxel(cell: Cell) -> vec3i {
    let words = vec2i(cell.words);
    return vec3i((words.y << 16u) >> 16u, words.y >> 16u, (words.x << 16u) >> 19u);
}
