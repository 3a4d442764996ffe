// The picture of a live view over the host's: `light + (1 - alpha) * host`, by premultiplied blending.

@group(0) @binding(1) var<storage, read> picture_color: array<vec4f>;

@fragment
fn composite_color(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let color = picture_color[pixel_at(position)];
    if (color.a <= 0.0) {
        discard;
    }
    return color;
}
