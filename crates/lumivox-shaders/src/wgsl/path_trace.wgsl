// The path tracer: one invocation follows one pixel's paths, sample after sample.
//
// The two loops of the textbook (over samples, over bounces) are one here: an invocation whose path has ended starts
// its next sample at once instead of waiting for its neighbours' longest path. A sample counts when its path has ended,
// never before: whatever cuts an invocation short takes no light from the mean.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
// Transfer functions, what media are classified by, boxes around volumes, lights: see `tables.wgsl`.
@group(0) @binding(2) var<storage, read> tables: array<vec2u>;
// The cells of one volume after the other.
@group(0) @binding(3) var<storage, read> grids: array<Cell>;
@group(0) @binding(4) var linear_sampler: sampler;
@group(0) @binding(5) var environment_map: texture_2d<f32>;
// Planes of sums over samples: (radiance, alpha), (view depth, squared luminance, number of samples, state of the path
// that is put aside); with LIVE, where rays end (`ray_limits.wgsl`); with GUIDES, (first-hit albedo, 0), (first-hit normal, 0).
@group(0) @binding(6) var<storage, read_write> film: array<vec4f>;

// Roulette ends more paths than those that lost their light: what comes late costs more time than it saves noise. Not where
// paths find the light by themselves, for what they find there is the same for all.
const LATE_SURVIVAL: f32 = select(1.0, 0.8, ENVIRONMENT_SAMPLING);

// What the samples of one pixel add up to; planes of the film.
struct Sums {
    light: vec4f,
    moments: vec4f,
    albedo: vec3f,
    normal: vec3f,
}

// One sample's path: where it goes on, and what it has brought so far.
struct Path {
    origin: vec3f,
    direction: vec3f,
    throughput: vec3f,
    radiance: vec3f,
    bounces: u32,
    // Of the direction, where it was chosen at an event.
    pdf: f32,
    // Of the first collision.
    depth: f32,
    albedo: vec3f,
    normal: vec3f,
    point: PathPoint,
}

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn path_trace(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) local_index: u32,
) {
    let sharer = id.x % sharers();
    var pixel = vec2u(id.x / sharers(), id.y + frame.row_begin);
    let row_is_wanted = pixel.y < frame.row_end;
    if (LIVE) {
        let group_count = (frame.film_size.y + WORKGROUP_Y - 1u) / WORKGROUP_Y;
        pixel.y = pixel.y / WORKGROUP_Y * frame.group_stride % group_count * WORKGROUP_Y + pixel.y % WORKGROUP_Y;
    }
    let plane = frame.film_size.x * frame.film_size.y;
    let index = pixel.y * frame.film_size.x + pixel.x;
    var sums = Sums();
    let is_of_film = row_is_wanted && all(pixel < frame.film_size);
    if (is_of_film) {
        let counts = film[plane + index].zw;
        if (is_wanted(counts.x) && has_turn(counts.y, local_index)) {
            sums = trace(pixel, sharer);
        }
    }
    sums = gather(sums, sharer, index, is_of_film);
    if (all(sums.moments.zw == vec2f(0.0)) || sharer > 0u) {
        return;
    }
    if (!POINTS) {
        film[index] += sums.light;
    }
    film[plane + index] = vec4f(film[plane + index].xyz + sums.moments.xyz, sums.moments.w);
    if (GUIDES) {
        let guides = guides_begin(plane);
        film[guides + index] += vec4f(sums.albedo, 0.0);
        film[guides + plane + index] += vec4f(sums.normal, 0.0);
    }
}

// Whether a pixel that has so many samples is one of those that the dispatch is for.
fn is_wanted(samples: f32) -> bool {
    return !LIVE || frame.only_below == 0u || samples < f32(frame.only_below);
}

// The samples of a pixel, from the sharer's first one in steps of as many as share it.
fn trace(pixel: vec2u, sharer: u32) -> Sums {
    let image_pixel = pixel + frame.film_origin;
    let plane = frame.film_size.x * frame.film_size.y;
    let index = pixel.y * frame.film_size.x + pixel.x;
    // Pixels start over one by one where a host's depth changes, and paths that are long take many dispatches: each
    // pixel counts for itself.
    let moments = film[plane + index];
    var sample_index = u32(moments.z) + sharer;
    var sample_end = min(u32(moments.z) + frame.samples, frame.sample_limit);
    var rng = rng_new(image_pixel, sample_index, frame.seed);
    var path = Path();
    var alive = take_up(moments.w, index, image_pixel, &path, &rng);
    if (alive) {
        sample_end = max(sample_end, sample_index + 1u);
    }
    var view_limit = 0.0;
    if (LIVE) {
        view_limit = live_limit(index);
    }
    var sums = Sums();
    loop {
        if (!alive) {
            if (sample_index >= sample_end) {
                break;
            }
            rng = rng_new(image_pixel, sample_index, frame.seed);
            path = path_begin(image_pixel, &rng);
        }
        remember(path, rng);
        alive = path_goes_on(&path, &rng, view_limit);
        if (turns_are_spent()) {
            sums.moments.w = put_aside(index);
            break;
        }
        if (!alive) {
            sample_index += sharers();
            if (POINTS) {
                // The film counts them. What they have seen goes elsewhere.
                sums.moments.z += 1.0;
                point_end(path);
                continue;
            }
            let l = luminance(path.radiance);
            sums.light += vec4f(path.radiance, select(0.0, 1.0, path.bounces > 0u));
            sums.moments += vec4f(path.depth, l * l, 1.0, 0.0);
            if (GUIDES) {
                sums.albedo += path.albedo;
                sums.normal += path.normal;
            }
        }
    }
    return sums;
}

fn path_begin(image_pixel: vec2u, rng: ptr<function, Rng>) -> Path {
    var path = Path();
    let ray = camera_ray(image_pixel, rng_next2(rng));
    path.origin = ray.origin;
    path.direction = ray.direction;
    path.throughput = vec3f(1.0);
    path.point = point_none();
    return path;
}

// The path's next collision and what happens there. Returns whether it goes on. `view_limit` is the view depth at which
// the camera's rays end, or 0.
fn path_goes_on(path: ptr<function, Path>, rng: ptr<function, Rng>, view_limit: f32) -> bool {
    let direction = (*path).direction;
    var t_max = 1e30;
    if (LIVE && view_limit > 0.0 && (*path).bounces == 0u) {
        t_max = view_limit / dot(direction, frame.view_axis);
    }
    let hit = next_collision((*path).origin, direction, t_max, rng);
    if (hit.kind == ESCAPE) {
        // What the camera sees without a collision is the background: the display pass adds it.
        if ((*path).bounces > 0u) {
            var weight = 1.0;
            if (ENVIRONMENT_SAMPLING) {
                let of_light = light_samples((*path).bounces) * environment_pdf(direction);
                weight = (*path).pdf / ((*path).pdf + of_light);
            }
            (*path).radiance += (*path).throughput * weight * environment_radiance(direction);
        }
        return false;
    }
    let v = hit.volume;
    let position = (*path).origin + hit.t * direction;
    (*path).origin = position;
    (*path).bounces += 1u;
    let optics = optics_at(v, position, hit.reading, GUIDES && (*path).bounces == 1u);
    if ((*path).bounces == 1u) {
        (*path).depth = dot(position - frame.camera_position, frame.view_axis);
        if (GUIDES) {
            (*path).albedo = optics.albedo;
            (*path).normal = facing(optics.normal, -direction);
        }
    }
    if ((*path).bounces > instances[v].max_bounces) {
        return false;
    }
    let event = event_at(v, optics, hit.reading, -direction);
    if (POINTS && (*path).bounces == 1u && !point_begin(path, v, position, (*path).depth, event, *rng)) {
        return false;
    }
    // Russian roulette by what is sent on: what survives is weighted up by what did not.
    let sent_on = (*path).throughput * event_total(event);
    let brightest = max(sent_on.r, max(sent_on.g, sent_on.b));
    if (brightest <= 0.0) {
        return false;
    }
    let survival = brightest * LATE_SURVIVAL;
    if ((*path).bounces >= frame.roulette_start && survival < 1.0) {
        if (rng_next(rng) >= survival) {
            return false;
        }
        (*path).throughput /= survival;
    }
    // From the environment, then from a light. A loop: with one way of a shadow ray instead of two, kernels for both are 1.4
    // to 1.9 times as fast on an H200, and FXC is done in half the time.
    var shadow_rays = 1u;
    if (POINTS && (*path).bounces == 1u) {
        shadow_rays = frame.point_rays;
    }
    for (var source = select(shadow_rays, 0u, ENVIRONMENT_SAMPLING); source < shadow_rays * select(1u, 2u, LIGHTS); source++) {
        take_turn();
        var arrival: Arrival;
        if (ENVIRONMENT_SAMPLING && source < shadow_rays) {
            arrival = choose_light(event, (*path).bounces, rng);
        } else if (LIGHTS) {
            arrival = choose_arrival(event, instances[v].layers, position, rng);
        }
        if (luminance(arrival.light) > 0.0) {
            let light = (*path).throughput * arrival.light
                * transmittance(position, arrival.direction, arrival.distance, rng);
            // Of a point, what arrives at the first collision is told apart from light of the way on.
            if (POINTS && (*path).bounces == 1u) {
                point_sent(path, event, arrival.direction, light / f32(shadow_rays));
            } else {
                (*path).radiance += light;
            }
        }
    }
    var pick = 0.0;
    if (SURFACE && event.phase < 1.0) {
        pick = rng_next(rng);
    }
    (*path).direction = event_sample(event, pick, rng_next2(rng));
    let densities = event_densities(event, (*path).direction);
    (*path).throughput *= event_weight(event, densities);
    (*path).pdf = densities.x;
    if (POINTS && (*path).bounces == 1u) {
        point_onward(path, event, (*path).direction);
    }
    return true;
}
