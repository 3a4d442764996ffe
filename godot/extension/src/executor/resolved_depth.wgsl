// The depth of what a live view shows, stored where the engine has resolved its multisampled depth: that is not drawn to.

@group(0) @binding(0) var<storage, read> picture_depth: array<f32>;
@group(0) @binding(1) var resolved: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn resolved_depth(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(resolved);
    if (any(id.xy >= size)) {
        return;
    }
    let depth = picture_depth[id.y * size.x + id.x];
    // As `composite_depth`: less than 0 where nothing hides what is behind.
    if (depth >= 0.0) {
        textureStore(resolved, id.xy, vec4f(depth, 0.0, 0.0, 0.0));
    }
}
