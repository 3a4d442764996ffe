// The picture of a live view, for what is drawn over the host's.

struct CompositeParams {
    // Pixels of a row of the picture.
    width: u32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

@group(0) @binding(0) var<uniform> params: CompositeParams;

fn pixel_at(position: vec4f) -> u32 {
    let at = vec2u(position.xy);
    return at.y * params.width + at.x;
}
