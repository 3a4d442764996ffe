// How far what a live view shows has moved since the frame before: for hosts that find a pixel's past by it, as temporal antialiasing
// and upscaling do.

struct VelocityParams {
    // From (x d, y d, d, 1) of a point at view depth d to the same in the frame before; of parallel rays from (x, y, d, 1). x and y
    // are in [-1, 1], y downwards.
    before_from_now: mat4x4f,
    // View depth is (x * ndc + y) / (z * ndc + w).
    view_depth_from_ndc: vec4f,
    // Of the host's numbers, what a step of 1 along x and along y is.
    scale: vec2f,
    picture_size: vec2u,
    // Whether x and y of what is seen grow with its depth, or do not.
    camera_parallel: u32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

@group(0) @binding(0) var<uniform> params: VelocityParams;
@group(0) @binding(1) var<storage, read> picture_depth: array<f32>;

@fragment
fn composite_velocity(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at = vec2u(position.xy);
    let ndc = picture_depth[at.y * params.picture_size.x + at.x];
    if (ndc < 0.0) {
        discard;
    }
    let map = params.view_depth_from_ndc;
    let depth = (map.x * ndc + map.y) / (map.z * ndc + map.w);
    let place = 2.0 * position.xy / vec2f(params.picture_size) - 1.0;
    let is_parallel = params.camera_parallel != 0u;
    let before = params.before_from_now * vec4f(place * select(depth, 1.0, is_parallel), depth, 1.0);
    if (before.z <= 0.0) {
        // It was behind the eye.
        discard;
    }
    let was = before.xy / select(before.z, 1.0, is_parallel);
    return vec4f((was - place) * params.scale, 0.0, 0.0);
}
