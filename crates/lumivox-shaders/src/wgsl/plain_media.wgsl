// Media that depend on the value alone. Expects `instances` and `tables`. The other way is `classified_media.wgsl`.

// What is read of a volume at a point: enough to say what the medium is there.
struct Reading {
    texel: f32,  // stored value in [0, 1]
}

// At a point of voxel space in a cell, where the stored value is `texel`.
fn read_medium(v: u32, p: vec3f, cell: Cell, texel: f32, drawn: u32) -> Reading {
    return Reading(texel);
}

// sigma_t as a share of what it is at opacity 1.
fn opacity(v: u32, reading: Reading) -> f32 {
    return most_opacity(v, reading.texel);
}

// The same, where that is known.
fn opacity_within(most: f32, v: u32, reading: Reading) -> f32 {
    return most;
}

fn color(v: u32, reading: Reading) -> vec3f {
    return color_of(instances[v].table_offset, table_address(instances[v].table_scale, instances[v].table_bias, reading.texel));
}

fn surface_strength(v: u32, reading: Reading) -> f32 {
    return instances[v].surface_strength;
}

fn surface_inverse_gradient(v: u32, reading: Reading) -> f32 {
    return instances[v].surface_inverse_gradient;
}

fn surface_lobe_anisotropy(v: u32, reading: Reading) -> f32 {
    return instances[v].surface_lobe_anisotropy;
}

fn surface_specular(v: u32, reading: Reading) -> f32 {
    return instances[v].surface_specular;
}

fn surface_metallic(v: u32, reading: Reading) -> f32 {
    return instances[v].surface_metallic;
}

// Nothing is cut.
fn cut_surface(v: u32, p: vec3f, reading: Reading) -> Cut {
    return Cut(0.0, vec3f(0.0));
}

// All of it.
fn kept_of_ray(v: u32, p: vec3f, direction: vec3f, t_end: f32) -> vec2f {
    return vec2f(0.0, t_end);
}
