// Reading a volume: filters, gradient, spaces. Expects `instances`, `grids`, pools, texels, `linear_sampler` and `frame`.

// Stored value in [0, 1] at a point of voxel space.
fn sample_trilinear(v: u32, p: vec3f) -> f32 {
    let inside = within(v, p);
    return filter_brick(cell_at(v, vec3u(inside - 0.5)), inside);
}

fn sample_nearest(v: u32, p: vec3f) -> f32 {
    let voxel = vec3u(clamp(p, vec3f(0.0), instances[v].dims - 1.0));
    return load_voxel(cell_at(v, voxel), vec3i(voxel));
}

// A voxel in the brick that a cell lies in. A brick reaches half a voxel further than its cells, and what lies beyond the
// volume repeats the last voxel: a rounding leads to no other brick.
fn load_voxel(cell: Cell, voxel: vec3i) -> f32 {
    let pool = cell_pool(cell);
    return stored_value(load_texel(pool, voxel + cell_texel_from_voxel(cell)), frame.inverse_pool_sizes[pool].w);
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
    let pool = cell_pool(cell);
    let from_texels = frame.inverse_pool_sizes[pool];
    return stored_value(sample_pool(pool, texel * from_texels.xyz), from_texels.w);
}

// The taps of a cubic B-spline along each axis (Sigg and Hadwiger, "Fast Third-Order Texture Filtering", GPU Gems 2,
// chapter 20): two linear ones stand for four samples.
struct Taps {
    low: vec3f,
    high: vec3f,
    // Of the value, the weight of the farther tap; of the slope, that of the difference.
    weight: vec3f,
}

// Texel centres i - 1, i, i + 1, i + 2 lie at i - 0.5 ... i + 2.5; each tap lies between its two, by their weights.
fn value_taps(v: u32, i: vec3f, f: vec3f) -> Taps {
    let f2 = f * f;
    let f3 = f2 * f;
    let w0 = (1.0 - 3.0 * f + 3.0 * f2 - f3) / 6.0;
    let w1 = (4.0 - 6.0 * f2 + 3.0 * f3) / 6.0;
    let g1 = 1.0 - w0 - w1;
    return Taps(within(v, i - 0.5 + w1 / (w0 + w1)), within(v, i + 1.5 + f3 / 6.0 / g1), g1);
}

// The derivatives of the weights: of the near two at most 0, of the far two at least, and equal in sum.
fn slope_taps(v: u32, i: vec3f, f: vec3f) -> Taps {
    let f2 = f * f;
    let slope = 0.5 + f - f2;
    return Taps(within(v, i - 0.5 + (2.0 * f - 1.5 * f2) / slope), within(v, i + 1.5 + 0.5 * f2 / slope), slope);
}

// A spline's eight taps: along x, y and z at `low` and `high`.
struct Eight {
    s000: f32,
    s100: f32,
    s010: f32,
    s110: f32,
    s001: f32,
    s101: f32,
    s011: f32,
    s111: f32,
}

// One by one, not in a loop: half the time, for the taps need not wait for each other.
fn eight_taps(b: Bricks, low: vec3f, high: vec3f) -> Eight {
    return Eight(
        filter_brick(b.c000, low),
        filter_brick(b.c100, vec3f(high.x, low.yz)),
        filter_brick(b.c010, vec3f(low.x, high.y, low.z)),
        filter_brick(b.c110, vec3f(high.xy, low.z)),
        filter_brick(b.c001, vec3f(low.xy, high.z)),
        filter_brick(b.c101, vec3f(high.x, low.y, high.z)),
        filter_brick(b.c011, vec3f(low.x, high.yz)),
        filter_brick(b.c111, high),
    );
}

// Cubic B-spline at a point in a cell.
fn sample_tricubic(v: u32, p: vec3f, cell: Cell) -> f32 {
    let i = floor(p - 0.5);
    let t = value_taps(v, i, p - 0.5 - i);
    let s = eight_taps(bricks_around(v, i, cell), t.low, t.high);
    let g0 = 1.0 - t.weight;
    let g1 = t.weight;
    let low = g0.y * (g0.x * s.s000 + g1.x * s.s100) + g1.y * (g0.x * s.s010 + g1.x * s.s110);
    let high = g0.y * (g0.x * s.s001 + g1.x * s.s101) + g1.y * (g0.x * s.s011 + g1.x * s.s111);
    return g0.z * low + g1.z * high;
}

// Its gradient per voxel: along each axis, the derivative of the weights there and the weights along the others.
fn tricubic_gradient(v: u32, p: vec3f) -> vec3f {
    let i = floor(p - 0.5);
    let f = p - 0.5 - i;
    let t = value_taps(v, i, f);
    let d = slope_taps(v, i, f);
    let b = bricks_around(v, i, cell_at(v, vec3u(within(v, p) - 0.5)));
    let g0 = 1.0 - t.weight;
    let g1 = t.weight;
    let x = eight_taps(b, vec3f(d.low.x, t.low.yz), vec3f(d.high.x, t.high.yz));
    let y = eight_taps(b, vec3f(t.low.x, d.low.y, t.low.z), vec3f(t.high.x, d.high.y, t.high.z));
    let z = eight_taps(b, vec3f(t.low.xy, d.low.z), vec3f(t.high.xy, d.high.z));
    return d.weight * vec3f(
        g0.z * (g0.y * (x.s100 - x.s000) + g1.y * (x.s110 - x.s010))
            + g1.z * (g0.y * (x.s101 - x.s001) + g1.y * (x.s111 - x.s011)),
        g0.z * (g0.x * (y.s010 - y.s000) + g1.x * (y.s110 - y.s100))
            + g1.z * (g0.x * (y.s011 - y.s001) + g1.x * (y.s111 - y.s101)),
        g0.y * (g0.x * (z.s001 - z.s000) + g1.x * (z.s101 - z.s100))
            + g1.y * (g0.x * (z.s011 - z.s010) + g1.x * (z.s111 - z.s110)),
    );
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

// Whether one of the voxels i - 1 to i + 2 may lie in another brick than i: where that is a brick's first or last, one time
// in six, and that is also where a rounding can make a point out to be in the next brick.
fn may_leave_brick(i: vec3f) -> bool {
    let from_last = (vec3i(i) + 1) & vec3i(i32(BRICK_SIZE) - 1);
    return any(from_last < vec3i(2));
}

// Of taps from voxels i - 1 and i + 1 on, of a point in a cell.
fn bricks_around(v: u32, i: vec3f, cell: Cell) -> Bricks {
    var b = Bricks(cell, cell, cell, cell, cell, cell, cell, cell);
    if (may_leave_brick(i)) {
        let low = vec3u(max(i - 1.0, vec3f(0.0)));
        let high = vec3u(min(i + 1.0, instances[v].dims - 1.0));
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
            case FILTER_NEAREST: { return load_voxel(cell, vec3i(p)); }
            case FILTER_TRICUBIC: { return sample_tricubic(v, p, cell); }
            default: {}
        }
    }
    return filter_brick(cell, p);
}

// Per voxel, in stored units: of the cubic filter its derivative, of others central differences over one voxel to each
// side, for theirs jump.
fn voxel_gradient(v: u32, p: vec3f) -> vec3f {
    if (MIXED_FILTERS) {
        switch instances[v].filter_kind {
            case FILTER_NEAREST: { return nearest_gradient(v, p); }
            case FILTER_TRICUBIC: { return tricubic_gradient(v, p); }
            default: {}
        }
    }
    return trilinear_gradient(v, p);
}

fn nearest_gradient(v: u32, p: vec3f) -> vec3f {
    let e = vec3f(1.0, 0.0, 0.0);
    return 0.5 * vec3f(
        sample_nearest(v, p + e.xyy) - sample_nearest(v, p - e.xyy),
        sample_nearest(v, p + e.yxy) - sample_nearest(v, p - e.yxy),
        sample_nearest(v, p + e.yyx) - sample_nearest(v, p - e.yyx),
    );
}

fn trilinear_gradient(v: u32, p: vec3f) -> vec3f {
    let at = within(v, p);
    let low = within(v, p - 1.0);
    let high = within(v, p + 1.0);
    let cell = cell_at(v, vec3u(at - 0.5));
    var x0 = cell;
    var x1 = cell;
    var y0 = cell;
    var y1 = cell;
    var z0 = cell;
    var z1 = cell;
    if (may_leave_brick(floor(p - 0.5))) {
        let voxel = vec3u(at - 0.5);
        let begin = vec3u(low - 0.5);
        let end = vec3u(high - 0.5);
        x0 = cell_at(v, vec3u(begin.x, voxel.yz));
        x1 = cell_at(v, vec3u(end.x, voxel.yz));
        y0 = cell_at(v, vec3u(voxel.x, begin.y, voxel.z));
        y1 = cell_at(v, vec3u(voxel.x, end.y, voxel.z));
        z0 = cell_at(v, vec3u(voxel.xy, begin.z));
        z1 = cell_at(v, vec3u(voxel.xy, end.z));
    }
    return 0.5 * vec3f(
        filter_brick(x1, vec3f(high.x, at.yz)) - filter_brick(x0, vec3f(low.x, at.yz)),
        filter_brick(y1, vec3f(at.x, high.y, at.z)) - filter_brick(y0, vec3f(at.x, low.y, at.z)),
        filter_brick(z1, vec3f(at.xy, high.z)) - filter_brick(z0, vec3f(at.xy, low.z)),
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
