// What the medium of a volume is at a point: here, and nowhere else, stored values become optical properties. Tracking
// asks for the opacity, shading for the rest. Its majorants are made by `majorant_grid.wgsl`, its twin is the
// reference's `medium.rs`. Expects `instances` and `tables`.

// What is read of a volume at a point: enough to say what the medium is there.
struct Reading {
    texel: f32,  // stored value in [0, 1]
}

// At a point of voxel space in a cell.
fn read_medium(v: u32, p: vec3f, cell: Cell) -> Reading {
    return Reading(sample_in_cell(v, p, cell));
}

struct TableAddress {
    entry: u32,
    fraction: f32,
}

fn table_address(v: u32, texel: f32) -> TableAddress {
    let u = clamp(texel * instances[v].table_scale + instances[v].table_bias, 0.0, f32(TABLE_SIZE - 1u));
    let entry = min(u32(u), TABLE_SIZE - 2u);
    return TableAddress(entry, u - f32(entry));
}

// sigma_t as a share of what it is at opacity 1. An entry holds its own and the next one's opacity: one load.
fn opacity(v: u32, reading: Reading) -> f32 {
    let a = table_address(v, reading.texel);
    let pair = tables[instances[v].table_offset + a.entry];
    return mix(pair.x, pair.y, a.fraction);
}

// Colours lie behind the opacities, each in two pairs.
fn color(v: u32, reading: Reading) -> vec3f {
    let a = table_address(v, reading.texel);
    let first = instances[v].table_offset + TABLE_SIZE + 2u * a.entry;
    let low = vec3f(tables[first], tables[first + 1u].x);
    let high = vec3f(tables[first + 2u], tables[first + 3u].x);
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

// Whether the medium of a volume has surfaces.
fn may_reflect(v: u32) -> bool {
    return SURFACE && instances[v].surface_strength > 0.0;
}

// At a point of the world that was read. The normal is there where the medium has surfaces, and where it is wanted.
fn optics_at(v: u32, position: vec3f, reading: Reading, wants_normal: bool) -> Optics {
    var optics = Optics(instances[v].albedo * color(v, reading), 0.0, vec3f(0.0));
    if (may_reflect(v) || wants_normal) {
        let gradient = voxel_gradient(v, voxel_from_world(v, position));
        optics.normal = normal_of(v, gradient);
        if (may_reflect(v)) {
            optics.surface = surface_probability(v, gradient);
        }
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

// The probability that a collision happens at a surface (after Kroes, Post and Botha, "Exposure Render", PLoS ONE
// 7(7), 2012, with a Gaussian fall-off so that noise is no surface).
fn surface_probability(v: u32, gradient: vec3f) -> f32 {
    let per_mm = length(transform_rows(instances[v].patient_gradient_from_voxel, gradient))
        * instances[v].value_per_texel * instances[v].surface_inverse_gradient;
    return instances[v].surface_strength * (1.0 - exp(-per_mm * per_mm));
}
