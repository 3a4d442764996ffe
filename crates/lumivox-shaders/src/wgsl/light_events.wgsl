// What is kept of a collision's light, as whoever writes it and whoever reads it have it. Expects `frame` and `instances`.

// What of light is sent on diffusely, by the phase function or by a surface, and in which colour.
fn diffuse_color(event: Event) -> vec3f {
    return event.albedo * (event.phase + event_diffuse(event));
}

// What mirrors, and in which colour.
fn mirror_tint(event: Event) -> vec3f {
    return event.albedo * (event.specular - event.white) + event.white;
}

// The finest tier of interest where a volume is seen at a view depth: that of cells as large as what a pixel sees.
fn tier_seen(v: u32, depth: f32) -> u32 {
    let size = frame.pixel_size * select(depth, 1.0, frame.orthographic != 0u);
    return tier_of_footprint(size * length(voxel_direction(v, frame.view_axis)));
}
