// What this host draws itself: something behind the scan, and the picture on the screen.

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
}

// One triangle that covers everything.
@vertex
fn triangle(@builtin(vertex_index) index: u32) -> Corner {
    let uv = vec2f(f32(index % 2u), f32(index / 2u)) * 2.0;
    return Corner(vec4f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, 0.0, 1.0), uv);
}

// A wall with a soft light on it, scene-linear. An engine draws its meshes here.
@fragment
fn backdrop(corner: Corner) -> @location(0) vec4f {
    let light = exp(-4.0 * dot(corner.uv - vec2f(0.5, 0.45), corner.uv - vec2f(0.5, 0.45)));
    return vec4f(mix(vec3f(0.004, 0.005, 0.008), vec3f(0.050, 0.058, 0.074), light), 1.0);
}

@group(0) @binding(0) var picture: texture_2d<f32>;

// Highlights roll off as on photographic film. The target encodes sRGB.
@fragment
fn tone_map(corner: Corner) -> @location(0) vec4f {
    let color = textureLoad(picture, vec2u(corner.position.xy), 0).rgb;
    return vec4f(1.0 - exp(-1.5 * color), 1.0);
}
