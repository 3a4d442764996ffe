// The host's depth buffer to the ends of primary rays. Where it changed, something moved in front of or inside the
// volume: the pixel starts over, and only that pixel.

struct HostDepthParams {
    // View depth is (x * ndc + y) / (z * ndc + w).
    view_depth_from_ndc: vec4f,
    film_size: vec2u,
    // The buffer's value where nothing was drawn.
    clear: f32,
    // Whether the host's camera jitters by subpixels, so that depth flickers at edges though nothing moves.
    jittered: u32,
    // View depth of the farthest point of all volumes.
    farthest: f32,
    // Whether the film has guides.
    guides: u32,
    padding_x: u32,
    padding_y: u32,
}

@group(0) @binding(0) var<uniform> params: HostDepthParams;
@group(0) @binding(1) var host_depth_map: texture_2d<f32>;
// Number by number: a write to a part of a vector may touch all of it, and neighbours share the entries of `ray_limits`.
@group(0) @binding(2) var<storage, read_write> film: array<f32>;
// Pixels that started over.
@group(0) @binding(3) var<storage, read_write> restarts: array<atomic<u32>>;

// Relative change of depth that counts as none: rounding, not motion.
const TOLERANCE: f32 = 1e-4;

fn view_depth(at: vec2i) -> f32 {
    let last = vec2i(textureDimensions(host_depth_map)) - 1;
    return view_depth_from_ndc(
        textureLoad(host_depth_map, clamp(at, vec2i(0), last), 0).r, params.view_depth_from_ndc, params.clear,
        params.farthest);
}

fn unchanged(before: f32, now: f32, at: vec2i) -> bool {
    if (before == now) {
        return true;
    }
    if (params.jittered == 0u) {
        return before > 0.0 && now > 0.0 && abs(now - before) <= TOLERANCE * before;
    }
    // Under jitter any depth of the neighbourhood may show up here.
    var nearest = select(now, 1e30, now == 0.0);
    var farthest = now;
    var open = now == 0.0;
    for (var i = 0; i < 9; i++) {
        let d = view_depth(at + vec2i(i % 3, i / 3) - 1);
        open = open || d == 0.0;
        nearest = select(nearest, min(nearest, d), d > 0.0);
        farthest = max(farthest, d);
    }
    if (before == 0.0) {
        return open;
    }
    return before >= nearest * (1.0 - 10.0 * TOLERANCE) && (open || before <= farthest * (1.0 + 10.0 * TOLERANCE));
}

@compute @workgroup_size(8, 8)
fn host_depth(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= params.film_size)) {
        return;
    }
    let uv = (vec2f(id.xy) + 0.5) / vec2f(params.film_size);
    let at = vec2i(uv * vec2f(textureDimensions(host_depth_map)));
    let index = id.y * params.film_size.x + id.x;
    let now = view_depth(at);
    let plane = params.film_size.x * params.film_size.y;
    let moments = 4u * (plane + index);
    let limit = 4u * ray_limit_entry(plane, index) + index % 4u;
    // Or a path of one, put aside.
    let has_samples = film[moments + 2u] > 0.0 || film[moments + 3u] > 0.0;
    // What is left of another image, whose camera was elsewhere, is nothing to compare with.
    if (has_samples && unchanged(film[limit], now, at)) {
        return;
    }
    film[limit] = now;
    if (has_samples) {
        for (var i = 0u; i < 4u; i++) {
            film[4u * index + i] = 0.0;
            film[moments + i] = 0.0;
        }
        for (var i = 0u; i < 4u * params.guides; i++) {
            let guide = 4u * (ray_limits_end(plane) + index) + i;
            film[guide] = 0.0;
            film[guide + 4u * plane] = 0.0;
        }
        atomicAdd(&restarts[0], 1u);
    }
}
