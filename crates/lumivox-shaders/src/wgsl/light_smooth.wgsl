// A picture from the light that is kept: where cells have few points, what was marched is averaged over the pixels around it that
// see the same surface.
//
// An a-trous filter (Dammertz et al., "Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering", HPG 2010) of
// light over colour: colours, depths and alpha have no noise, and stay as sharp as they are. A pixel takes part as far as it lies
// in the plane of the one in the middle, is turned alike, and is of a like colour. The more points cells have, the fewer
// passes a pixel takes. At 1920 x 1080, three by three taps as far as 32 pixels do what five by five as far as 16 do.

struct LightSmoothParams {
    film_size: vec2u,
    // The first pixel whose ray was marched, and how far the next ones are.
    first: vec2u,
    stride: u32,
    // Marched pixels from tap to tap; 0 for the pass that finds how depths grow from pixel to pixel.
    step: u32,
    // Whether light over colour lies in y of the first plane, and goes to x, or the other way round.
    flips: u32,
    is_last: u32,
    // Pixels that are surer than this stay as they are.
    sure: f32,
    // Metres that a pixel sees at depth 1, or at any depth of a parallel camera.
    pixel_size: f32,
    camera_parallel: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> params: LightSmoothParams;
// Planes as `light_march` writes them. Of the first one: light over colour, twice; how depths grow along x and y, from marched
// pixel to marched pixel, over what is between those, in half floats; how sure it is.
@group(0) @binding(1) var<storage, read_write> picture: array<vec4u>;

// Distances from the plane of a pixel, in sizes of a step, that count for little; colours that do; and how much turned.
const OFF_PLANE: f32 = 2.0;
const OTHER_COLOR: f32 = 0.05;
const TURNED: f32 = 128.0;
// Over how much of sureness the filter comes in.
const COMES_IN: f32 = 1.5;

fn marched_count() -> vec2i {
    return vec2i((params.film_size - params.first + params.stride - 1u) / params.stride);
}

// Its entry in the first plane.
fn entry_of(place: vec2i) -> u32 {
    let at = params.first + params.stride * vec2u(clamp(place, vec2i(0), marched_count() - 1));
    return at.y * params.film_size.x + at.x;
}

fn second_plane() -> u32 {
    return params.film_size.x * params.film_size.y;
}

// How the depth grows to the next pixel: by the side where it grows less, for beyond an edge is something else.
fn slope(before: f32, here: f32, after: f32) -> f32 {
    let back = select(1e9, here - before, before > 0.0);
    let on = select(1e9, after - here, after > 0.0);
    let less = select(on, back, abs(back) < abs(on));
    return select(0.0, less, abs(less) < 1e9);
}

// 0 where nothing is seen, or nothing was marched.
fn depth_at(place: vec2i) -> f32 {
    if (any(place < vec2i(0)) || any(place >= marched_count())) {
        return 0.0;
    }
    return seen_depth(picture[second_plane() + entry_of(place)]);
}

fn find_slopes(place: vec2i) {
    let here = depth_at(place);
    let along_x = slope(depth_at(place - vec2i(1, 0)), here, depth_at(place + vec2i(1, 0)));
    let along_y = slope(depth_at(place - vec2i(0, 1)), here, depth_at(place + vec2i(0, 1)));
    let slopes = clamp(vec2f(along_x, along_y) / max(spacing(here), 1e-12), vec2f(-1e4), vec2f(1e4));
    picture[entry_of(place)].z = pack2x16float(slopes);
}

// Metres between marched pixels at a depth.
fn spacing(depth: f32) -> f32 {
    return f32(params.stride) * params.pixel_size * select(depth, 1.0, params.camera_parallel != 0u);
}

fn normal(slopes: vec2f) -> vec3f {
    return normalize(vec3f(-slopes, 1.0));
}

fn ratio_of(first: vec4u) -> vec3f {
    return unpack_rgb(select(first.x, first.y, params.flips != 0u));
}

@compute @workgroup_size(8, 8)
fn light_smooth(@builtin(global_invocation_id) id: vec3u) {
    let place = vec2i(id.xy);
    if (any(place >= marched_count())) {
        return;
    }
    if (params.step == 0u) {
        find_slopes(place);
        return;
    }
    let entry = entry_of(place);
    let own = picture[entry];
    let seen = picture[second_plane() + entry];
    let tint = tint_of(seen.z);
    var ratio = ratio_of(own);
    let part = clamp((params.sure - bitcast<f32>(own.w)) / COMES_IN, 0.0, 1.0);
    if (part > 0.0 && tint.a > 0.0) {
        let slopes = unpack2x16float(own.z);
        let size = spacing(seen_depth(seen));
        let turned = normal(slopes);
        let color = tint.rgb / tint.a;
        var sum = vec3f(0.0);
        var weights = vec3f(0.0);
        for (var i = 0; i < 9; i++) {
            let tap = vec2i(i % 3 - 1, i / 3 - 1);
            let offset = i32(params.step) * tap;
            let there = place + offset;
            if (any(there < vec2i(0)) || any(there >= marched_count())) {
                continue;
            }
            let other = entry_of(there);
            let its = picture[other];
            let its_sight = picture[second_plane() + other];
            let its_tint = tint_of(its_sight.z);
            if (its_tint.a <= 0.0) {
                continue;
            }
            let off = abs(seen_depth(its_sight) - seen_depth(seen) - size * dot(slopes, vec2f(offset)));
            let alike = max(dot(turned, normal(unpack2x16float(its.z))), 0.0);
            let difference = its_tint.rgb / its_tint.a - color;
            let near = 2.0 - abs(vec2f(tap));
            let weight = near.x * near.y * pow(alike, TURNED)
                * exp(-off / max(OFF_PLANE * f32(min(params.step, 4u)) * size, 1e-12) - dot(difference, difference) / (OTHER_COLOR * OTHER_COLOR));
            sum += weight * its_tint.rgb * ratio_of(its);
            weights += weight * its_tint.rgb;
        }
        ratio = mix(ratio, sum / max(weights, vec3f(1e-9)), part);
    }
    let word = pack_rgb(ratio);
    if (params.is_last != 0u) {
        picture[second_plane() + entry].x = word;
    } else if (params.flips != 0u) {
        picture[entry].x = word;
    } else {
        picture[entry].y = word;
    }
}
