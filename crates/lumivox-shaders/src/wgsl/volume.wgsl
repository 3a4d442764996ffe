// Reading a volume: filters, gradient, spaces. Expects `instances`, `grids`, pools, `linear_sampler` and `frame`.

// Stored value in [0, 1] at a point of voxel space.
fn sample_trilinear(v: u32, p: vec3f) -> f32 {
    let inside = within(v, p);
    return filter_brick(cell_at(v, vec3u(inside - 0.5)), inside);
}

fn sample_nearest(v: u32, p: vec3f) -> f32 {
    let inside = clamp(p, vec3f(0.0), instances[v].dims - 1.0);
    return load_brick(cell_at(v, vec3u(inside)), inside);
}

// The voxel around a point of voxel space in the brick that a cell lies in. A brick reaches half a voxel further than its
// cells, and what lies beyond the volume repeats the last voxel: a rounding leads to no other brick.
fn load_brick(cell: Cell, p: vec3f) -> f32 {
    return load_texel(cell_pool(cell), vec3i(p) + cell_texel_from_voxel(cell));
}

// One of the cells in the brick that holds a voxel.
fn cell_at(v: u32, voxel: vec3u) -> Cell {
    let n = instances[v].grid_dims;
    let cell = voxel / BRICK_SIZE * instances[v].cells_per_brick + 1u;
    return grids[instances[v].grid_offset + (cell.z * n.y + cell.y) * n.x + cell.x];
}

// At a point of voxel space in the brick that a cell lies in, which it may miss by a rounding: texture units, too, round
// coordinates, to 1/256 of a texel, up, down or to the nearest. A quarter of that is added so that the neighbours in the
// pool do not leak in, however they do it.
fn filter_brick(cell: Cell, p: vec3f) -> f32 {
    // Below the centre of the first voxel lies nothing.
    let texel = max(p, vec3f(0.5)) + (1.0 / 1024.0) + vec3f(cell_texel_from_voxel(cell));
    return sample_pool(cell_pool(cell), texel * frame.inverse_pool_sizes[cell_pool(cell)].xyz);
}

// Cubic B-spline from eight trilinear taps (Sigg and Hadwiger, "Fast Third-Order Texture Filtering", GPU Gems 2,
// chapter 20): along each axis two taps stand for four samples. At a point in a cell.
fn sample_tricubic(v: u32, p: vec3f, cell: Cell) -> f32 {
    let x = p - 0.5;
    let i = floor(x);
    let f = x - i;
    let f2 = f * f;
    let f3 = f2 * f;
    let w0 = (1.0 - 3.0 * f + 3.0 * f2 - f3) / 6.0;
    let w1 = (4.0 - 6.0 * f2 + 3.0 * f3) / 6.0;
    let w3 = f3 / 6.0;
    let g1 = 1.0 - w0 - w1;
    let g0 = w0 + w1;
    // Texel centres i - 1, i, i + 1, i + 2 lie at i - 0.5 ... i + 2.5; each tap between its two, by their weights.
    let h0 = within(v, i - 0.5 + w1 / g0);
    let h1 = within(v, i + 1.5 + w3 / g1);
    let b = bricks_around(v, i, h0, h1, cell);
    // One by one, not in a loop: half the time, for the taps need not wait for each other.
    let s000 = filter_brick(b.c000, h0);
    let s100 = filter_brick(b.c100, vec3f(h1.x, h0.yz));
    let s010 = filter_brick(b.c010, vec3f(h0.x, h1.y, h0.z));
    let s110 = filter_brick(b.c110, vec3f(h1.xy, h0.z));
    let s001 = filter_brick(b.c001, vec3f(h0.xy, h1.z));
    let s101 = filter_brick(b.c101, vec3f(h1.x, h0.y, h1.z));
    let s011 = filter_brick(b.c011, vec3f(h0.x, h1.yz));
    let s111 = filter_brick(b.c111, h1);
    let low = g0.y * (g0.x * s000 + g1.x * s100) + g1.y * (g0.x * s010 + g1.x * s110);
    let high = g0.y * (g0.x * s001 + g1.x * s101) + g1.y * (g0.x * s011 + g1.x * s111);
    return g0.z * low + g1.z * high;
}

// Where filters find what lies at a point beyond the outermost voxels' centres.
fn within(v: u32, p: vec3f) -> vec3f {
    return clamp(p, vec3f(0.5), instances[v].dims - 0.5);
}

// Cells in the bricks that a cubic filter's taps lie in; the digits are x, y and z, 1 for the farther tap.
struct Bricks {
    c000: Cell,
    c100: Cell,
    c010: Cell,
    c110: Cell,
    c001: Cell,
    c101: Cell,
    c011: Cell,
    c111: Cell,
}

// Of taps at `h0` and `h1` from voxels i - 1 and i + 1 on, of a point in a cell. Five times in six all of them lie in the
// cell's brick. Where voxel i is a brick's first or last they may not, and that is also where a rounding can make a point
// out to be in the next brick.
fn bricks_around(v: u32, i: vec3f, h0: vec3f, h1: vec3f, cell: Cell) -> Bricks {
    var b = Bricks(cell, cell, cell, cell, cell, cell, cell, cell);
    let from_last = (vec3i(i) + 1) & vec3i(i32(BRICK_SIZE) - 1);
    if (any(from_last < vec3i(2))) {
        let low = vec3u(h0 - 0.5);
        let high = vec3u(h1 - 0.5);
        b.c000 = cell_at(v, low);
        b.c100 = cell_at(v, vec3u(high.x, low.yz));
        b.c010 = cell_at(v, vec3u(low.x, high.y, low.z));
        b.c110 = cell_at(v, vec3u(high.xy, low.z));
        b.c001 = cell_at(v, vec3u(low.xy, high.z));
        b.c101 = cell_at(v, vec3u(high.x, low.y, high.z));
        b.c011 = cell_at(v, vec3u(low.x, high.yz));
        b.c111 = cell_at(v, high);
    }
    return b;
}

fn sample_volume(v: u32, p: vec3f) -> f32 {
    if (MIXED_FILTERS) {
        switch instances[v].filter_kind {
            case FILTER_NEAREST: { return sample_nearest(v, p); }
            case FILTER_TRICUBIC: { return sample_tricubic(v, p, cell_at(v, vec3u(within(v, p) - 0.5))); }
            default: {}
        }
    }
    return sample_trilinear(v, p);
}

// The same at a point in a cell.
fn sample_in_cell(v: u32, p: vec3f, cell: Cell) -> f32 {
    if (MIXED_FILTERS) {
        switch instances[v].filter_kind {
            case FILTER_NEAREST: { return load_brick(cell, p); }
            case FILTER_TRICUBIC: { return sample_tricubic(v, p, cell); }
            default: {}
        }
    }
    return filter_brick(cell, p);
}

// Central differences over one voxel to each side, per voxel, in stored units.
fn voxel_gradient(v: u32, p: vec3f) -> vec3f {
    let e = vec3f(1.0, 0.0, 0.0);
    return 0.5 * vec3f(
        sample_volume(v, p + e.xyy) - sample_volume(v, p - e.xyy),
        sample_volume(v, p + e.yxy) - sample_volume(v, p - e.yxy),
        sample_volume(v, p + e.yyx) - sample_volume(v, p - e.yyx),
    );
}

fn transform_rows(rows: array<vec4f, 3>, d: vec3f) -> vec3f {
    return vec3f(dot(rows[0].xyz, d), dot(rows[1].xyz, d), dot(rows[2].xyz, d));
}

fn voxel_from_world(v: u32, p: vec3f) -> vec3f {
    let h = vec4f(p, 1.0);
    return vec3f(
        dot(instances[v].voxel_from_world[0], h),
        dot(instances[v].voxel_from_world[1], h),
        dot(instances[v].voxel_from_world[2], h),
    );
}

fn voxel_direction(v: u32, d: vec3f) -> vec3f {
    return transform_rows(instances[v].voxel_from_world, d);
}

// Gradients transform with the transposed map: they are covectors.
fn world_gradient(v: u32, g: vec3f) -> vec3f {
    return instances[v].voxel_from_world[0].xyz * g.x
        + instances[v].voxel_from_world[1].xyz * g.y
        + instances[v].voxel_from_world[2].xyz * g.z;
}
