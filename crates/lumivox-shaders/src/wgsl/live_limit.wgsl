// Where primary rays end: at what the host has drawn.

// View depth of the host's surface at each pixel of the film, 0 where there is none; `host_depth` writes it.
@group(0) @binding(11) var<storage, read> ray_limits: array<f32>;

fn live_limit(index: u32) -> f32 {
    return ray_limits[index];
}
