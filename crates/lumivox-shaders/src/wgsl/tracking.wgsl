// Free flights and transmittance through the volumes, against local majorants.
//
// Delta tracking (Woodcock et al. 1965) and ratio tracking (Novak et al., "Residual Ratio Tracking", 2014) over a
// grid of majorants walked by 3D-DDA (Amanatides and Woo 1987): a cell's majorant bounds the opacity of every point
// in it, so tentative collisions are sampled from a piecewise constant rate and accepted with sigma_t / sigma_maj.

// A ray's walk through one volume's majorant cells.
//
// t counts from where the ray enters the volume: seen from afar, sums of small steps to a large t would lose them.
struct March {
    origin: vec3f,     // where the ray enters, in voxels
    direction: vec3f,  // in voxels per unit of t
    t_enter: f32,      // on the ray
    t: f32,            // from here on
    t_end: f32,
    t_next: vec3f,     // where the ray leaves its cell along each axis
    t_delta: vec3f,    // t from one cell to the next along each axis
    index: i32,        // of the cell
    cell: Cell,        // that the tentative collision lies in
    step: vec3i,       // index steps to the next cell along each axis
    scale: f32,        // extinction per unit of t at opacity 1
}

// Half a unit in the last place of 1, rounded up: 2^-24.
const HALF_UNIT: f32 = 6e-8;

// An empty walk where the ray misses the volume: its t_end is not positive.
fn march_begin(v: u32, origin: vec3f, direction: vec3f, t_max: f32) -> March {
    var m: March;
    m.origin = voxel_from_world(v, origin);
    m.direction = voxel_direction(v, direction);
    // A component of exactly 0 would turn into 0 * infinity; this one leaves the cell after any t that matters.
    let d = choose(m.direction, vec3f(1e-20), abs(m.direction) < vec3f(1e-20));
    let inverse = 1.0 / d;
    let a = (instances[v].clip_low - m.origin) * inverse;
    let b = (instances[v].clip_high - m.origin) * inverse;
    let entry = min(a, b);
    let exit = max(a, b);
    m.t_enter = max(max(entry.x, entry.y), max(entry.z, 0.0));
    m.t_end = min(min(exit.x, exit.y), min(exit.z, t_max)) - m.t_enter;
    if (m.t_end <= 0.0) {
        return m;
    }
    m.origin += m.t_enter * m.direction;
    if (CLIP_SHAPES) {
        let kept = kept_of_ray(v, m.origin, m.direction, m.t_end);
        m.t_enter += kept.x;
        m.t_end = kept.y - kept.x;
        if (m.t_end <= 0.0) {
            return m;
        }
        m.origin += kept.x * m.direction;
    }
    let world_scale = instances[v].world_millimetres;
    let patient_scale = length(transform_rows(instances[v].patient_from_world, direction));
    m.scale = instances[v].density * select(patient_scale, world_scale, world_scale > 0.0);

    let dims = vec3i(instances[v].grid_dims);
    let stride = vec3i(1, dims.x, dims.x * dims.y);
    // Cells part the space between voxel centres, and bricks likewise: the first begins one cell before the first centre.
    let p = m.origin + (instances[v].cell_size - 0.5);
    let cell = clamp(vec3i(floor(p * instances[v].cells_per_voxel)), vec3i(0), dims - 1);
    let forward = d > vec3f(0.0);
    let side = vec3f(cell) + choose(vec3f(0.0), vec3f(1.0), forward);
    m.t_next = (side * instances[v].cell_size - p) * inverse;
    m.t_delta = abs(instances[v].cell_size * inverse);
    // The walk adds up t_next, and every sum may fall short by half a unit in the last place. It ends where the shortest
    // may reach the grid's last face: one step more, and it would read the majorants of another volume.
    let steps = vec3f(choose_int(cell, dims - 1 - cell, forward));
    let faces = (m.t_next + steps * m.t_delta) * (1.0 - (steps + 4.0) * HALF_UNIT);
    m.t_end = min(m.t_end, min(faces.x, min(faces.y, faces.z)));
    // The walk of a ray that is lost at no number, or infinitely far away, would never end. Asked of the bits: compilers
    // may take it that numbers are numbers.
    let sum = faces.x + faces.y + faces.z + m.t_end + m.scale;
    if ((bitcast<u32>(sum) & 0x7f800000u) == 0x7f800000u) {
        m.t_end = 0.0;
    }
    m.index = dot(cell, stride) + i32(instances[v].grid_offset);
    m.step = choose_int(-stride, stride, forward);
    return m;
}

// Walks on until `depth` of majorant optical depth is spent. Returns the majorant at the tentative collision at
// `m.t`, or 0 where the ray leaves the volume first.
fn march_to_tentative(m: ptr<function, March>, depth: f32) -> f32 {
    var rest = depth;
    while ((*m).t < (*m).t_end && take_turn()) {
        let cell = grids[(*m).index];
        if (cell_is_far_from_any(cell)) {
            march_through_nothing(m, f32(cell_empty_distance(cell) - 1u));
            continue;
        }
        let majorant = cell_majorant(cell) * (*m).scale;
        let t_exit = min(min((*m).t_next.x, (*m).t_next.y), min((*m).t_next.z, (*m).t_end));
        let available = majorant * (t_exit - (*m).t);
        if (rest < available) {
            // Or what lies deep in a medium that is dense beyond rounding would be met again and again.
            (*m).t += max(rest / majorant, (*m).t * (2.0 * HALF_UNIT));
            (*m).cell = cell;
            return majorant;
        }
        rest -= max(available, 0.0);
        (*m).t = max((*m).t, t_exit);
        // Exactly one axis steps, or the ray could cut a corner through a cell whose majorant it never read.
        if ((*m).t_next.x <= (*m).t_next.y && (*m).t_next.x <= (*m).t_next.z) {
            (*m).index += (*m).step.x;
            (*m).t_next.x += (*m).t_delta.x;
        } else if ((*m).t_next.y <= (*m).t_next.z) {
            (*m).index += (*m).step.y;
            (*m).t_next.y += (*m).t_delta.y;
        } else {
            (*m).index += (*m).step.z;
            (*m).t_next.z += (*m).t_delta.z;
        }
    }
    return 0.0;
}

// Walks out of the cells around this one, `reach` of them to every side, all of which are empty.
fn march_through_nothing(m: ptr<function, March>, reach: f32) {
    let leaves = (*m).t_next + reach * (*m).t_delta;
    let t = min(min(leaves.x, leaves.y), leaves.z);
    if (t >= (*m).t_end) {
        (*m).t = (*m).t_end;
        return;
    }
    // Faces that are passed until then along each axis. By a rounding rather one less than one more: a face that is left
    // is passed at once by the next step, in one that is too many a cell would be passed that nobody has read.
    let passed = clamp(floor((t - (*m).t_next) / (*m).t_delta - 1e-3) + 1.0, vec3f(0.0), vec3f(reach));
    (*m).t_next += passed * (*m).t_delta;
    let cells = vec3i(passed) * (*m).step;
    (*m).index += cells.x + cells.y + cells.z;
    (*m).t = max((*m).t, t);
}

// What ends a free flight.
const ESCAPE: u32 = 0u;     // nothing: the ray leaves all volumes, or reaches its end
const IN_VOLUME: u32 = 1u;  // a collision with a volume's medium

struct Collision {
    kind: u32,
    t: f32,
    // Where it is in a volume: which, and what was read there.
    volume: u32,
    reading: Reading,
}

// The first collision along a ray. Media are independent Poisson processes: a free flight is sampled in each volume,
// and the nearest collision wins.
fn next_collision(origin: vec3f, direction: vec3f, t_max: f32, rng: ptr<function, Rng>) -> Collision {
    var nearest = Collision(ESCAPE, t_max, 0u, Reading());
    var search = search_begin(origin, direction);
    loop {
        let v = search_next(&search, nearest.t);
        if (v == NO_VOLUME || !take_turn()) {
            break;
        }
        var m = march_begin(v, origin, direction, nearest.t);
        if (m.t_end <= 0.0) {
            continue;
        }
        loop {
            let majorant = march_to_tentative(&m, -log(1.0 - rng_next(rng)));
            if (majorant == 0.0 || !take_turn()) {
                break;
            }
            let p = m.origin + m.t * m.direction;
            let texel = sample_in_cell(v, p, m.cell);
            let drawn = rng_bits(rng);
            let threshold = uniform_of(drawn) * majorant;
            // Most of them are none, whatever the point's class is: it is asked for afterwards.
            let most = most_opacity(v, texel);
            if (threshold < most * m.scale) {
                let reading = read_medium(v, p, m.cell, texel, drawn);
                if (!SHARES || threshold < opacity_within(most, v, reading) * m.scale) {
                    nearest = Collision(IN_VOLUME, m.t_enter + m.t, v, reading);
                    break;
                }
            }
        }
    }
    return nearest;
}

// Below this, Russian roulette decides whether a transmittance is worth walking on for: at 1, all would be 0 or 1.
const LITTLE_TRANSMITTANCE: f32 = 0.6;

// An unbiased estimate of the transmittance to t_max. Transmittances of several volumes multiply.
fn transmittance(origin: vec3f, direction: vec3f, t_max: f32, rng: ptr<function, Rng>) -> f32 {
    var product = 1.0;
    var search = search_begin(origin, direction);
    loop {
        let v = search_next(&search, t_max);
        if (v == NO_VOLUME || !take_turn()) {
            break;
        }
        var m = march_begin(v, origin, direction, t_max);
        if (m.t_end <= 0.0) {
            continue;
        }
        loop {
            let drawn = rng_bits(rng);
            let majorant = march_to_tentative(&m, -log(1.0 - uniform_of(drawn)));
            if (majorant == 0.0 || !take_turn()) {
                break;
            }
            let p = m.origin + m.t * m.direction;
            let texel = sample_in_cell(v, p, m.cell);
            var of_point = most_opacity(v, texel);
            if (SHARES && of_point > 0.0 && instances[v].takes_shares > 0u) {
                of_point = opacity_within(of_point, v, read_medium(v, p, m.cell, texel, drawn));
            }
            let sigma_t = of_point * m.scale;
            product *= max(1.0 - sigma_t / majorant, 0.0);
            if (product < LITTLE_TRANSMITTANCE) {
                if (rng_next(rng) * LITTLE_TRANSMITTANCE >= product) {
                    return 0.0;
                }
                product = LITTLE_TRANSMITTANCE;
            }
        }
    }
    return product;
}
