// A picture from the light that is kept, in two planes. In the end they are of (light, alpha), and of where a pixel's ray ends, y,
// and its view depth, w. Until then pixels whose rays were marched are told there by light over colour: the second plane holds
// that, and colour and alpha, as x and z; the first what is smoothed of it (`light_smooth.wgsl`). Words, for as floats what is
// packed may be no number.

// Colour and alpha, in 7 bits for the root of each part of the colour and 11 for alpha. No colour is black, for light is
// divided by it.
fn encode_tint(color: vec3f, alpha: f32) -> u32 {
    let root = vec3u(clamp(127.0 * sqrt(color + DARKEST * alpha) + 0.5, vec3f(1.0), vec3f(127.0)));
    return root.r | (root.g << 7u) | (root.b << 14u) | (u32(clamp(alpha, 0.0, 1.0) * 2047.0 + 0.5) << 21u);
}

// Of what is as good as black, noise would be divided by next to nothing.
const DARKEST: f32 = 0.02;

fn tint_of(word: u32) -> vec4f {
    let root = vec3f((vec3u(word) >> vec3u(0u, 7u, 14u)) & vec3u(127u)) / 127.0;
    return vec4f(root * root, f32(word >> 21u) / 2047.0);
}

// What a marched ray saw, by its entry of the second plane: light as in cells, and alpha.
fn marched_light(entry: vec4u) -> vec4f {
    let tint = tint_of(entry.z);
    return vec4f(unpack_rgb(entry.x) * tint.rgb, tint.a) * select(0.0, 1.0, tint.a > 0.0);
}

fn ray_end(entry: vec4u) -> f32 {
    return bitcast<f32>(entry.y);
}

fn seen_depth(entry: vec4u) -> f32 {
    return bitcast<f32>(entry.w);
}
