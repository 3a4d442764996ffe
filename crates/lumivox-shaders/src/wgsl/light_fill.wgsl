// A picture from the light that is kept: its pixels between those whose rays were marched.
//
// From the picture before, if it is of the same scene: what is seen does not change where the camera moves, so pixels are
// looked for where they were, by their depth (as temporal upsampling does: Yang et al., "A Survey of Temporal Antialiasing
// Techniques", Eurographics 2020), and held to what is marched around them (Salvi, "An Excursion in Temporal Supersampling", GDC
// 2016). Where there is none, from that alone, in the manner of joint bilateral upsampling (Kopf et al., SIGGRAPH 2007): what lies
// behind another surface of the host does not leak over its edges.

struct LightFillParams {
    // Columns of the map from (x, y, 1) * depth and 1 in this image to those in the image before; of parallel rays x and y alone
    // are not multiplied. Both are in [-1, 1], y downwards.
    before_from_now: array<vec4f, 4>,
    film_size: vec2u,
    // The first pixel whose ray was marched, and how far the next ones are.
    first: vec2u,
    stride: u32,
    has_before: u32,
    camera_parallel: u32,
    // Whether this one is kept for the next.
    keeps: u32,
    // What light is multiplied by in cells.
    light_scale: f32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

@group(0) @binding(0) var<uniform> params: LightFillParams;
// Of which it is asked where rays end.
@group(0) @binding(1) var<storage, read> film: array<vec4f>;
// Planes as `light_march` writes them.
@group(0) @binding(2) var<storage, read_write> picture: array<vec4u>;
// The picture before, and this one for the next: light as in cells with a common exponent; depth in a half float without its
// sign, the root of alpha in nine bits, and in eight more about where the ray ends (`end_code`).
@group(0) @binding(3) var<storage, read> before: array<vec2u>;
@group(0) @binding(4) var<storage, read_write> kept: array<vec2u>;

// Depths that differ by less than this part are of the same matter.
const SAME_DEPTH: f32 = 0.01;
// Standard deviations of what is marched around a pixel that it may be from the mean.
const DEVIATIONS: f32 = 1.0;

struct Sight {
    // And alpha.
    light: vec4f,
    depth: f32,
    // How much of it is known, 0 to 1.
    known: f32,
}

// The entry of the picture's second plane that was marched for a place in their grid.
fn marched_entry(place: vec2i) -> u32 {
    let beyond = params.film_size - 1u - params.first;
    let last = vec2u(beyond.x / params.stride, beyond.y / params.stride);
    let at = params.first + params.stride * min(vec2u(max(place, vec2i(0))), last);
    return params.film_size.x * params.film_size.y + at.y * params.film_size.x + at.x;
}

// Where a ray ends, to a twelfth of an octave; 0 where it does not.
fn end_code(end: f32) -> u32 {
    return select(0u, u32(clamp(round(12.0 * log2(max(end, 1e-6))) + 128.0, 1.0, 255.0)), end > 0.0);
}

// What was seen before at a point of that picture, in pixels: linear between those whose rays ended where this one's does, or
// before in a volume. Of others nothing is known: a mesh was there, and is not now.
fn seen_before(p: vec2f, end: f32) -> Sight {
    let corner = vec2i(floor(p));
    let part = p - floor(p);
    let code = i32(end_code(end));
    var sum = Sight();
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let tap = vec2i(i & 1, i >> 1u);
        let at = vec2u(clamp(corner + tap, vec2i(0), vec2i(params.film_size) - 1));
        let word = before[at.y * params.film_size.x + at.x];
        let root = f32((word.y >> 15u) & 0x1ffu) / 511.0;
        let light = vec4f(unpack_rgb(word.x), root * root);
        let ended = i32(word.y >> 24u);
        let alike = select(0.0, 1.0, abs(ended - code) <= 1 && (ended == 0) == (code == 0));
        let near = 1.0 - abs(vec2f(tap) - part);
        let weight = near.x * near.y * max(alike, hidden(light.a));
        sum.light += weight * light;
        sum.depth += weight * light.a * unpack2x16float(word.y & 0x7fffu).x;
        weights += weight;
    }
    sum.depth /= max(sum.light.a, 1e-9);
    sum.light /= max(weights, 1e-9);
    sum.known = weights;
    return sum;
}

fn keep(index: u32, light: vec4f, depth: f32, end: f32) {
    if (params.keeps != 0u) {
        let root = u32(511.0 * sqrt(clamp(light.a, 0.0, 1.0)) + 0.5);
        let half_depth = pack2x16float(vec2f(clamp(depth, 0.0, 65000.0), 0.0));
        let more = half_depth | (root << 15u) | (end_code(end) << 24u);
        kept[index] = vec2u(pack_rgb(light.rgb), more);
    }
}

// Where a pixel was, of what lies at a depth; z is its depth there.
fn place_before(uv: vec2f, depth: f32) -> vec3f {
    let scale = select(depth, 1.0, params.camera_parallel != 0u);
    let map = params.before_from_now;
    let there = map[0] * (uv.x * scale) + map[1] * (uv.y * scale) + map[2] * depth + map[3];
    return vec3f(there.xy / select(there.z, 1.0, params.camera_parallel != 0u), there.z);
}

@compute @workgroup_size(8, 8)
fn light_fill(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= params.film_size)) {
        return;
    }
    let offset = vec2i(id.xy) - vec2i(params.first);
    let plane = params.film_size.x * params.film_size.y;
    let index = id.y * params.film_size.x + id.x;
    let beyond = vec2u(offset);
    if (all(offset >= vec2i(0)) && beyond.x % params.stride == 0u && beyond.y % params.stride == 0u) {
        let own = picture[plane + index];
        let light = marched_light(own);
        picture[index] = bitcast<vec4u>(vec4f(light.rgb / params.light_scale, light.a));
        keep(index, light, seen_depth(own), ray_end(own));
        return;
    }
    let limit = film[ray_limit_entry(plane, index)][index % 4u];
    // Mean, deviation and depth of what was marched around it.
    let q = vec2f(offset) / f32(params.stride);
    var seen = vec4f(0.0);
    var squares = vec4f(0.0);
    var depth = 0.0;
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let tap = vec2i(floor(q)) + vec2i(i & 1, i >> 1u);
        let marched = picture[marched_entry(tap)];
        var light = marched_light(marched);
        let alike = likeness(ray_end(marched), limit);
        // Of what an opaque volume hides, it is no matter where it ends.
        let counts = max(alike, hidden(light.a));
        if (limit > 0.0 && seen_depth(marched) > limit) {
            // What a ray met that passed by the pixel's surface is hidden behind that.
            light = vec4f(0.0);
        }
        let near = 1.0 - abs(vec2f(tap) - q);
        let weight = (near.x * near.y + 1e-4) * counts;
        seen += weight * light;
        squares += weight * light * light;
        depth += weight * light.a * seen_depth(marched);
        weights += weight;
    }
    depth /= max(seen.a, 1e-9);
    seen /= weights;
    let spread = DEVIATIONS * sqrt(max(squares / weights - seen * seen, vec4f(0.0)));
    if (params.has_before != 0u && seen.a > 0.0) {
        // By the depth of the nearest one: the mean of two surfaces is in neither.
        let its_depth = seen_depth(picture[marched_entry(vec2i(floor(q + 0.5)))]);
        let deep = select(depth, its_depth, its_depth > 0.0);
        let uv = (vec2f(id.xy) + 0.5) / vec2f(params.film_size) * 2.0 - 1.0;
        let place = place_before(uv, deep);
        if (place.z > 0.0 && all(abs(place.xy) < vec2f(1.0))) {
            let was = seen_before((0.5 * place.xy + 0.5) * vec2f(params.film_size) - 0.5, limit);
            // As far as other matter was seen there, or nothing is known.
            let moved = smoothstep(SAME_DEPTH, 2.0 * SAME_DEPTH, abs(was.depth - place.z) / place.z);
            let other = 1.0 - (1.0 - was.light.a * moved) * smoothstep(0.0, 0.5, was.known);
            // Light is of what alpha tells: it follows where that is held back.
            let alpha = clamp(was.light.a, seen.a - spread.a, seen.a + spread.a);
            let follows = select(1.0, alpha / was.light.a, was.light.a > 1e-3);
            let held = clamp(follows * was.light.rgb, seen.rgb - spread.rgb, seen.rgb + spread.rgb);
            seen = mix(vec4f(held, alpha), seen, other);
            depth = mix(deep + was.depth - place.z, depth, other);
        }
    }
    picture[index] = bitcast<vec4u>(vec4f(seen.rgb / params.light_scale, seen.a));
    picture[plane + index] = bitcast<vec4u>(vec4f(0.0, limit, 0.0, depth));
    keep(index, seen, depth, limit);
}
