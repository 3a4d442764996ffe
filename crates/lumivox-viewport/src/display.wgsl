// Scene-linear colour, alpha premultiplied, to what the screen shows. Follows `tone_map_wgsl` of lumivox-shaders.

struct Display {
    // Through the middle of the image, to its right edge and to its top, as directions in the world.
    forward: vec4f,
    right: vec4f,
    up: vec4f,
    // What stands behind: an sRGB colour as the screen shows it.
    behind: vec4f,
    exposure_scale: f32,
    inverse_gamma: f32,
    tone_operator: u32,
    // 0 a chequerboard, for nothing; 1 the colour; 2 the environment.
    backdrop: u32,
    // Sine and cosine.
    rotation: vec2f,
    strength: f32,
    padding: f32,
}

@group(0) @binding(0) var<uniform> shown: Display;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var surroundings: texture_2d<f32>;

// One triangle that covers everything.
@vertex
fn triangle(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let uv = vec2f(f32(index % 2u), f32(index / 2u)) * 2.0;
    return vec4f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, 0.0, 1.0);
}

fn srgb_decode(c: vec3f) -> vec3f {
    return choose(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

fn texel(x: i32, y: i32) -> vec3f {
    let size = vec2i(textureDimensions(surroundings));
    return textureLoad(surroundings, vec2i((x + size.x) % size.x, clamp(y, 0, size.y - 1)), 0).rgb;
}

// As lumivox-core's `Environment::radiance`.
fn light_from(direction: vec3f) -> vec3f {
    let r = shown.rotation;
    let d = vec3f(direction.x * r.y - direction.z * r.x, direction.y, direction.x * r.x + direction.z * r.y);
    let uv = vec2f(atan2(d.x, -d.z) / 6.283185307 + 0.5, acos(clamp(d.y, -1.0, 1.0)) / 3.141592654);
    let p = uv * vec2f(textureDimensions(surroundings)) - 0.5;
    let i = vec2i(floor(p));
    let f = fract(p);
    let top = mix(texel(i.x, i.y), texel(i.x + 1, i.y), f.x);
    let bottom = mix(texel(i.x, i.y + 1), texel(i.x + 1, i.y + 1), f.x);
    return mix(top, bottom, f.y) * shown.strength;
}

@fragment
fn display(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at = vec2u(position.xy);
    let color = textureLoad(picture, at, 0);
    if (shown.backdrop == 2u) {
        let ndc = position.xy / vec2f(textureDimensions(picture)) * 2.0 - 1.0;
        let direction = normalize(shown.forward.xyz + ndc.x * shown.right.xyz - ndc.y * shown.up.xyz);
        let light = color.rgb + (1.0 - color.a) * light_from(direction);
        return vec4f(tone_map(light * shown.exposure_scale, shown.tone_operator, shown.inverse_gamma), 1.0);
    }
    // The tone map is not linear: it is of the volume's own colour, and what stands behind is put there afterwards.
    let own = select(vec3f(0.0), color.rgb / max(color.a, 1e-6), color.a > 0.0);
    let mapped = tone_map(own * shown.exposure_scale, shown.tone_operator, shown.inverse_gamma);
    var behind = shown.behind.rgb;
    if (shown.backdrop == 0u) {
        behind = vec3f(select(0.30, 0.36, ((at.x / 12u + at.y / 12u) & 1u) == 0u));
    }
    let blended = color.a * srgb_decode(mapped) + (1.0 - color.a) * srgb_decode(behind);
    return vec4f(srgb_encode(blended), 1.0);
}
