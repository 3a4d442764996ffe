// One triangle that covers what is drawn to.

struct CompositeParams {
    // Pixels of a row of the picture.
    width: u32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

@group(0) @binding(0) var<uniform> params: CompositeParams;

@vertex
fn fullscreen(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32(vertex & 1u), f32(vertex >> 1u));
    return vec4f(corner * 4.0 - 1.0, 0.0, 1.0);
}

fn pixel_at(position: vec4f) -> u32 {
    let at = vec2u(position.xy);
    return at.y * params.width + at.x;
}
