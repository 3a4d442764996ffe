// What is seen of the light that is kept in the only volume there is: in small steps through it.

// Steps through a voxel: so many at least, so many at most, and in between as many as let none be deeper than this. Where
// matter is dense, light changes within a fraction of a voxel.
const FEWEST_STEPS: f32 = 2.0;
const MOST_STEPS: f32 = 8.0;
const DEEPEST_STEP: f32 = 0.5;
// What lets less than this pass lets nothing pass.
const OPAQUE: f32 = 0.004;
// What is less of a pixel is not looked up.
const INVISIBLE: f32 = 0.002;
// Of a pixel, what is looked up together.
const LOOKED_UP_AT_ONCE: f32 = 0.1;

// At a pixel whose ray ends at a view depth; nowhere where that is 0.
fn see(pixel: vec2u, t_end: f32) -> Seen {
    let ray = camera_ray(pixel, vec2f(0.5));
    var rng = rng_new(pixel, 0u, frame.seed);
    var t_max = 1e30;
    if (t_end > 0.0) {
        t_max = t_end / dot(ray.direction, frame.view_axis);
    }
    return see_volume(0u, ray.origin, ray.direction, t_max, &rng);
}

// What of a ray was not looked up yet: how much of the pixel it is; where and of what value in the mean, times that; and what was
// read where it is most.
struct Pending {
    share: f32,
    t: f32,
    texel: f32,
    most: f32,
    read: Reading,
}

// Along a ray through one volume. A loop of steps within one of looks at the light, which cost many times as much: so the rays
// of a subgroup look together.
fn see_volume(v: u32, origin: vec3f, direction: vec3f, t_max: f32, rng: ptr<function, Rng>) -> Seen {
    var seen = Seen();
    var m = march_begin(v, origin, direction, t_max);
    let voxels = length(m.direction);
    var transmitted = 1.0;
    var cell = Cell();
    // Where the cell ends that steps are in, and their length; of no cell yet.
    var t_exit = m.t;
    var h = 0.0;
    var is_between = true;
    loop {
        var pending = Pending();
        var t_begin = m.t;
        while (m.t < m.t_end && transmitted > OPAQUE) {
            if (is_between) {
                cell = grids[m.index];
                if (cell_is_far_from_any(cell)) {
                    march_through_nothing(&m, f32(cell_empty_distance(cell) - 1u));
                    // What lies before a gap is not looked up with what lies behind it: that would be within the gap.
                    if (pending.share > INVISIBLE) {
                        break;
                    }
                    continue;
                }
                t_exit = min(min(m.t_next.x, m.t_next.y), min(m.t_next.z, m.t_end));
                let of_depth = cell_majorant(cell) * m.scale / (DEEPEST_STEP * max(voxels, 1e-20));
                let of_voxel = clamp(of_depth, FEWEST_STEPS, MOST_STEPS);
                h = (t_exit - m.t) / min(ceil((t_exit - m.t) * voxels * of_voxel), 256.0);
                is_between = false;
            }
            if (cell_majorant(cell) > 0.0 && m.t < t_exit) {
                let t = m.t + 0.5 * h;
                let texel = sample_in_cell(v, m.origin + t * m.direction, cell);
                var sigma_t = most_opacity(v, texel) * m.scale;
                var reading = Reading();
                if (sigma_t > 0.0) {
                    var drawn = 0u;
                    if (LABELS) {
                        drawn = rng_bits(rng);
                    }
                    reading = read_medium(v, m.origin + t * m.direction, cell, texel, drawn);
                    if (SHARES) {
                        sigma_t = opacity(v, reading) * m.scale;
                    }
                }
                let share = transmitted * (1.0 - exp(-sigma_t * h));
                transmitted -= share;
                if (pending.share <= 0.0) {
                    t_begin = m.t;
                }
                pending.share += share;
                pending.t += share * t;
                pending.texel += share * texel;
                if (share > pending.most) {
                    pending.most = share;
                    pending.read = reading;
                }
                m.t += h;
                // What remains is less than what steps are rounded by.
                if (m.t < t_exit - 0.5 * h) {
                    if (is_worth_a_look(pending.share, (m.t - t_begin) * voxels)) {
                        break;
                    }
                    continue;
                }
            }
            m.t = t_exit;
            is_between = true;
            if (m.t_next.x <= m.t_next.y && m.t_next.x <= m.t_next.z) {
                m.index += m.step.x;
                m.t_next.x += m.t_delta.x;
            } else if (m.t_next.y <= m.t_next.z) {
                m.index += m.step.y;
                m.t_next.y += m.t_delta.y;
            } else {
                m.index += m.step.z;
                m.t_next.z += m.t_delta.z;
            }
            if (is_worth_a_look(pending.share, (m.t - t_begin) * voxels)) {
                break;
            }
        }
        if (pending.share <= 0.0) {
            break;
        }
        var reading = pending.read;
        reading.texel = pending.texel / pending.share;
        let position = origin + (m.t_enter + pending.t / pending.share) * direction;
        let sent = sent_light(v, position, direction, reading);
        seen.light += pending.share * sent.light;
        seen.color += pending.share * sent.color;
        seen.sureness += pending.share * sent.sureness;
        seen.depth += pending.share * dot(position - frame.camera_position, frame.view_axis);
    }
    seen.alpha = 1.0 - transmitted;
    if (transmitted <= OPAQUE) {
        // What is left is as what was seen.
        seen = seen_times(1.0 / max(seen.alpha, 1e-6), seen);
        seen.alpha = 1.0;
    }
    return seen;
}

// Where so much of the pixel was passed, along so many voxels.
fn is_worth_a_look(share: f32, extent: f32) -> bool {
    return share >= LOOKED_UP_AT_ONCE || (extent >= 1.0 && share > INVISIBLE);
}
