// What the medium of a volume is at a point: here, and nowhere else, stored values become optical properties. Tracking
// asks for the opacity, shading for the rest. What is read at a point, and which function it goes through, is in
// `plain_media.wgsl` or `classified_media.wgsl`. Its majorants are made by `majorant_grid.wgsl`, its twin is the
// reference's `medium.rs`. Expects `instances` and `tables`.

struct TableAddress {
    entry: u32,
    fraction: f32,
}

fn table_address(scale: f32, bias: f32, texel: f32) -> TableAddress {
    let u = clamp(texel * scale + bias, 0.0, f32(TABLE_SIZE - 1u));
    let entry = min(u32(u), TABLE_SIZE - 2u);
    return TableAddress(entry, u - f32(entry));
}

// Of a transfer function, by its first pair. An entry holds its own and the next one's opacity: one load.
fn opacity_of(function: u32, a: TableAddress) -> f32 {
    let pair = pair_at(function + a.entry);
    return mix(pair.x, pair.y, a.fraction);
}

// The largest opacity that a point of a volume can have, by its value alone: its own where there is nothing else to ask for.
fn most_opacity(v: u32, texel: f32) -> f32 {
    return opacity_of(instances[v].table_offset, table_address(instances[v].table_scale, instances[v].table_bias, texel));
}

// Colours lie behind the opacities, each in two pairs.
fn color_of(function: u32, a: TableAddress) -> vec3f {
    let first = function + TABLE_SIZE + 2u * a.entry;
    let low = vec3f(pair_at(first), pair_at(first + 1u).x);
    let high = vec3f(pair_at(first + 2u), pair_at(first + 3u).x);
    return mix(low, high, a.fraction);
}

// What light meets that collides there.
struct Optics {
    // Of light that is scattered, the share that goes on, by colour.
    albedo: vec3f,
    // The probability that the collision is one with a surface, and the surface's normal, to either side; zero where
    // there is none.
    surface: f32,
    normal: vec3f,
}

// The surface that a cut has left: how likely a collision is with it, and its gradient in voxel space.
struct Cut {
    surface: f32,
    gradient: vec3f,
}

// Whether the medium has surfaces where it was read.
fn may_reflect(v: u32, reading: Reading) -> bool {
    return SURFACE && surface_strength(v, reading) > 0.0;
}

// At a point of the world that was read. The normal is there where the medium has surfaces, and where it is wanted.
fn optics_at(v: u32, position: vec3f, reading: Reading, wants_normal: bool) -> Optics {
    var optics = Optics(instances[v].albedo * color(v, reading), 0.0, vec3f(0.0));
    if (may_reflect(v, reading) || wants_normal) {
        let p = voxel_from_world(v, position);
        var gradient = voxel_gradient(v, p);
        if (may_reflect(v, reading)) {
            optics.surface = surface_probability(v, gradient, reading);
        }
        if (CLIP_SHAPES) {
            let cut = cut_surface(v, p, reading);
            if (cut.surface > optics.surface) {
                optics.surface = cut.surface;
                gradient = cut.gradient;
            }
        }
        optics.normal = normal_of(v, gradient);
    }
    return optics;
}

fn normal_of(v: u32, gradient: vec3f) -> vec3f {
    let g = world_gradient(v, gradient);
    let size = length(g);
    if (size < 1e-20) {
        return vec3f(0.0);
    }
    return g / size;
}

// A normal on the side of wo.
fn facing(normal: vec3f, wo: vec3f) -> vec3f {
    return select(-normal, normal, dot(normal, wo) >= 0.0);
}

// The magnitude in value units per mm of a gradient in voxel space.
fn gradient_per_mm(v: u32, gradient: vec3f) -> f32 {
    return length(transform_rows(instances[v].patient_gradient_from_voxel, gradient)) * instances[v].value_per_texel;
}

// The probability that a collision happens at a surface (after Kroes, Post and Botha, "Exposure Render", PLoS ONE
// 7(7), 2012, with a Gaussian fall-off so that noise is no surface).
fn surface_probability(v: u32, gradient: vec3f, reading: Reading) -> f32 {
    let per_mm = gradient_per_mm(v, gradient) * surface_inverse_gradient(v, reading);
    return surface_strength(v, reading) * (1.0 - exp(-per_mm * per_mm));
}
