// A cell of a majorant grid: its majorant, and where the voxels around it lie. The two are read together, for the point of
// a tentative collision is looked up next.
//
// An empty cell's majorant is 0, and in its place stands how many cells it is to the nearest that is not empty, counted
// along the axis where that is most: a number of its own, smaller than the bits of any majorant.
//
// The first word holds the upper half of the majorant's bits, then 13 bits for z and three for the pool; the second six for
// the class, 13 for y and 13 for x. A voxel's texel in its pool is its index and x, y, z, all with a sign: volumes of up to
// MAX_BRICKS bricks along an axis can be told so.
//
// The class says what all points of a cell have in common besides: CLASS_IS_WHOLE where no clip shape and no peeling takes
// anything off, and below it the place, from 1, of the look that all of them have, or 0 where they may have several. Most
// cells are whole, and of one look: their points are read as those of a volume without labels and cuts are.

struct Cell {
    words: vec2u,
}

fn cell_new(majorant: f32, of_class: u32, pool: u32, texel_from_voxel: vec3i) -> Cell {
    // Rounded up: a majorant that is a little loose is one still. The least is the least normal number, or the bits would
    // mean a distance.
    let rounded = max((bitcast<u32>(majorant) + 0xffffu) & 0xffff0000u, 0x00800000u);
    let bits = select(0u, rounded, majorant > 0.0);
    let d = vec3u(texel_from_voxel);
    return Cell(vec2u(bits | ((d.z & 0x1fffu) << 3u) | pool, (of_class << 26u) | ((d.y & 0x1fffu) << 13u) | (d.x & 0x1fffu)));
}

fn cell_majorant(cell: Cell) -> f32 {
    return select(bitcast<f32>(cell.words.x & 0xffff0000u), 0.0, cell.words.x < (MAX_EMPTY_DISTANCE + 1u) << 16u);
}

// All cells that are nearer than so many are empty. More than MAX_EMPTY_DISTANCE where the cell itself is not.
fn cell_empty_distance(cell: Cell) -> u32 {
    return cell.words.x >> 16u;
}

// Whether its neighbours are empty, too: one comparison, as a walk makes it at every cell.
fn cell_is_far_from_any(cell: Cell) -> bool {
    return cell.words.x - (2u << 16u) < (MAX_EMPTY_DISTANCE - 1u) << 16u;
}

fn cell_empty(cell: Cell, distance: u32) -> Cell {
    return Cell(vec2u((distance << 16u) | (cell.words.x & 0xffffu), cell.words.y));
}

fn cell_pool(cell: Cell) -> u32 {
    return cell.words.x & (MAX_POOLS - 1u);
}

fn cell_class(cell: Cell) -> u32 {
    return cell.words.y >> 26u;
}

fn cell_texel_from_voxel(cell: Cell) -> vec3i {
    let words = vec2i(cell.words);
    return vec3i((words.y << 19u) >> 19u, (words.y << 6u) >> 19u, (words.x << 16u) >> 19u);
}
