// The path tracer: one invocation follows one pixel's paths, sample after sample.
//
// The two loops of the textbook (over samples, over bounces) are one here: an invocation whose path has ended starts
// its next sample at once instead of waiting for its neighbours' longest path.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
@group(0) @binding(2) var<storage, read> opacity_table: array<vec2f>;
@group(0) @binding(3) var<storage, read> color_table: array<vec4f>;
@group(0) @binding(4) var<storage, read> majorants: array<f32>;
@group(0) @binding(5) var atlas: texture_3d<f32>;
@group(0) @binding(6) var atlas_sampler: sampler;
@group(0) @binding(7) var environment_map: texture_2d<f32>;
@group(0) @binding(8) var<storage, read> environment_importance: array<ImportanceCell>;
@group(0) @binding(9) var<storage, read> lights: array<Light>;
// Planes of sums over samples: (radiance, alpha), (view depth, squared luminance, number of samples, 0) and, with
// GUIDES, (first-hit albedo, 0), (first-hit normal, 0).
@group(0) @binding(10) var<storage, read_write> film: array<vec4f>;

// What the samples of one pixel add up to; planes of the film.
struct Sums {
    light: vec4f,
    moments: vec4f,
    albedo: vec3f,
    normal: vec3f,
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
        pixel.y = pixel.y / WORKGROUP_Y * frame.group_stride % frame.group_count * WORKGROUP_Y + pixel.y % WORKGROUP_Y;
    }
    var sums = Sums();
    if (row_is_wanted && all(pixel < frame.film_size)) {
        sums = trace(pixel, sharer);
    }
    sums = gather(sums, local_index);
    if (sums.moments.z == 0.0 || sharer > 0u) {
        return;
    }
    let plane = frame.film_size.x * frame.film_size.y;
    let index = pixel.y * frame.film_size.x + pixel.x;
    film[index] += sums.light;
    film[plane + index] += sums.moments;
    if (GUIDES) {
        film[2u * plane + index] += vec4f(sums.albedo, 0.0);
        film[3u * plane + index] += vec4f(sums.normal, 0.0);
    }
}

// The samples of a pixel, from the sharer's first one in steps of as many as share it.
fn trace(pixel: vec2u, sharer: u32) -> Sums {
    let image_pixel = pixel + frame.film_origin;
    let plane = frame.film_size.x * frame.film_size.y;
    let index = pixel.y * frame.film_size.x + pixel.x;
    var sums = Sums();
    var sample_index = frame.sample_begin;
    var sample_end = frame.sample_end;
    var view_limit = 0.0;
    if (LIVE) {
        // Pixels start over one by one where the host's depth changes: each counts for itself.
        sample_index = u32(film[plane + index].z);
        sample_end = min(sample_index + sample_end - frame.sample_begin, frame.sample_limit);
        sample_index += sharer;
        if (sample_index >= sample_end) {
            return sums;
        }
        view_limit = live_limit(index);
    }
    var alive = false;
    var rng = Rng(vec2u(0u), 0u);
    var origin = vec3f(0.0);
    var direction = vec3f(0.0);
    var t_max = 1e30;
    var throughput = vec3f(1.0);
    var radiance = vec3f(0.0);
    var bounces = 0u;
    var pdf = 0.0;

    loop {
        if (!alive) {
            if (sample_index >= sample_end) {
                break;
            }
            rng = rng_new(image_pixel, sample_index, frame.seed);
            sample_index += sharers();
            sums.moments.z += 1.0;
            let ray = camera_ray(image_pixel, rng_next2(&rng));
            origin = ray.origin;
            direction = ray.direction;
            t_max = select(1e30, view_limit / dot(direction, frame.view_axis), LIVE && view_limit > 0.0);
            throughput = vec3f(1.0);
            radiance = vec3f(0.0);
            bounces = 0u;
            alive = true;
        }

        let hit = next_collision(origin, direction, t_max, &rng);
        if (hit.volume == NO_VOLUME) {
            // What the camera sees without a collision is the background: the display pass adds it.
            if (bounces > 0u) {
                var weight = 1.0;
                if (ENVIRONMENT_SAMPLING) {
                    weight = pdf / (pdf + environment_pdf(direction));
                }
                radiance += throughput * weight * environment_radiance(direction);
            }
            alive = false;
        } else {
            let v = hit.volume;
            bounces += 1u;
            t_max = 1e30;
            origin += hit.t * direction;
            let scattering_albedo = instances[v].albedo * color(v, hit.texel);
            var gradient = vec3f(0.0);
            if ((SURFACE && instances[v].surface_strength > 0.0) || (GUIDES && bounces == 1u)) {
                gradient = voxel_gradient(v, voxel_from_world(v, origin));
            }
            if (bounces == 1u) {
                sums.light.w += 1.0;
                sums.moments.x += dot(origin - frame.camera_position, frame.view_axis);
                if (GUIDES) {
                    sums.albedo += scattering_albedo;
                    sums.normal += facing_normal(v, gradient, -direction);
                }
            }
            if (bounces > instances[v].max_bounces) {
                alive = false;
            } else {
                let event = choose_event(v, gradient, scattering_albedo, -direction, &rng);
                throughput *= event.weight;
                // Russian roulette: what survives is weighted up by what did not.
                let brightest = max(throughput.r, max(throughput.g, throughput.b));
                if (brightest <= 0.0) {
                    alive = false;
                } else if (bounces >= frame.roulette_start && brightest < 1.0) {
                    if (rng_next(&rng) >= brightest) {
                        alive = false;
                    } else {
                        throughput /= brightest;
                    }
                }
                if (alive) {
                    if (ENVIRONMENT_SAMPLING) {
                        let light = choose_light(event, &rng);
                        if (luminance(light.arriving) > 0.0) {
                            radiance += throughput * light.arriving
                                * transmittance(origin, light.direction, 1e30, &rng);
                        }
                    }
                    if (LIGHTS) {
                        let arrival = choose_arrival(event, instances[v].layers, origin, &rng);
                        if (luminance(arrival.irradiance) > 0.0) {
                            radiance += throughput * arrival.irradiance
                                * transmittance(origin, arrival.direction, arrival.distance, &rng);
                        }
                    }
                    direction = event_sample(event, rng_next2(&rng));
                    if (ENVIRONMENT_SAMPLING) {
                        pdf = event_pdf(event, direction);
                    }
                }
            }
        }
        if (!alive) {
            sums.light += vec4f(radiance, 0.0);
            let l = luminance(radiance);
            sums.moments.y += l * l;
        }
    }
    return sums;
}
