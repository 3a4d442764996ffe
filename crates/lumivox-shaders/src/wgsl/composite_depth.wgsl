// The depth of what a live view shows, for all that the host draws later: transparent things, depth of field, fog.

@group(0) @binding(1) var<storage, read> picture_depth: array<f32>;

@fragment
fn composite_depth(@builtin(position) position: vec4f) -> @builtin(frag_depth) f32 {
    let depth = picture_depth[pixel_at(position)];
    if (depth < 0.0) {
        discard;
    }
    return depth;
}
