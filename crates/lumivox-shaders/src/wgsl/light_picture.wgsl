// A pixel of a picture from the light that is kept: planes of (light, alpha) and of where its ray ends, its view depth and, where
// that was marched, what it saw: (red and green, end, blue and alpha, depth), light as in cells in half floats.

fn marched_pixel(light: vec3f, alpha: f32, end: f32, depth: f32) -> vec4f {
    let half_light = min(light, vec3f(65000.0));
    let first = bitcast<f32>(pack2x16float(half_light.rg));
    return vec4f(first, end, bitcast<f32>(pack2x16float(vec2f(half_light.b, alpha))), depth);
}

fn marched_light(pixel: vec4f) -> vec4f {
    return vec4f(unpack2x16float(bitcast<u32>(pixel.x)), unpack2x16float(bitcast<u32>(pixel.z)));
}
