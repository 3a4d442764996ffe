// Reading a volume: filters, gradient, spaces. Expects `instances`, `grids`, pools, `linear_sampler` and `frame`.

// Stored value in [0, 1] at a point of voxel space.
fn sample_trilinear(v: u32, p: vec3f) -> f32 {
    let inside = clamp(p, vec3f(0.5), instances[v].dims - 0.5);
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
// chapter 20): along each axis two taps stand for four samples.
fn sample_tricubic(v: u32, p: vec3f) -> f32 {
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
    let h0 = i - 0.5 + w1 / g0;
    let h1 = i + 1.5 + w3 / g1;
    // One by one, not in a loop: half the time, for the taps need not wait for each other.
    let s000 = sample_trilinear(v, h0);
    let s100 = sample_trilinear(v, vec3f(h1.x, h0.yz));
    let s010 = sample_trilinear(v, vec3f(h0.x, h1.y, h0.z));
    let s110 = sample_trilinear(v, vec3f(h1.xy, h0.z));
    let s001 = sample_trilinear(v, vec3f(h0.xy, h1.z));
    let s101 = sample_trilinear(v, vec3f(h1.x, h0.y, h1.z));
    let s011 = sample_trilinear(v, vec3f(h0.x, h1.yz));
    let s111 = sample_trilinear(v, h1);
    let low = g0.y * (g0.x * s000 + g1.x * s100) + g1.y * (g0.x * s010 + g1.x * s110);
    let high = g0.y * (g0.x * s001 + g1.x * s101) + g1.y * (g0.x * s011 + g1.x * s111);
    return g0.z * low + g1.z * high;
}

fn sample_volume(v: u32, p: vec3f) -> f32 {
    if (MIXED_FILTERS) {
        switch instances[v].filter_kind {
            case FILTER_NEAREST: { return sample_nearest(v, p); }
            case FILTER_TRICUBIC: { return sample_tricubic(v, p); }
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
            case FILTER_TRICUBIC: { return sample_tricubic(v, p); }
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
