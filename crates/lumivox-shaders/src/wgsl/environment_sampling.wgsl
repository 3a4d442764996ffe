// Importance sampling of the environment, by luminance times sin(theta). Expects `tables` and `frame`.

// A cell by the alias method (Walker 1977; Vose 1991). The buffer of tables begins with these.
struct ImportanceCell {
    // Below it the cell itself is drawn, else its alias.
    threshold: f32,
    alias_index: u32,
    // Probability density over the map's unit square, and that of the alias.
    density: f32,
    alias_density: f32,
}

const IMPORTANCE_PAIRS: u32 = 2u;

fn importance_cell(index: u32) -> ImportanceCell {
    let words = words_at(IMPORTANCE_PAIRS * index);
    return ImportanceCell(bitcast<f32>(words.x), words.y, bitcast<f32>(words.z), bitcast<f32>(words.w));
}

// From a density over the map's unit square to one over solid angle: d(omega) = 2 pi^2 sin(theta) du dv.
fn solid_angle_density(density: f32, v: f32) -> f32 {
    return density / (2.0 * PI * PI * max(sin(v * PI), 1e-6));
}

fn environment_pdf(direction: vec3f) -> f32 {
    let uv = environment_uv(direction);
    let size = frame.importance_size;
    let cell = min(vec2u(uv * vec2f(size)), size - 1u);
    return solid_angle_density(pair_at(IMPORTANCE_PAIRS * (cell.y * size.x + cell.x) + 1u).x, uv.y);
}

struct EnvironmentSample {
    direction: vec3f,
    pdf: f32,  // over solid angle
}

fn sample_environment(rng: ptr<function, Rng>) -> EnvironmentSample {
    let size = frame.importance_size;
    let count = size.x * size.y;
    var index = min(u32(rng_next(rng) * f32(count)), count - 1u);
    let cell = importance_cell(index);
    var density = cell.density;
    if (rng_next(rng) >= cell.threshold) {
        index = cell.alias_index;
        density = cell.alias_density;
    }
    let uv = (vec2f(f32(index % size.x), f32(index / size.x)) + rng_next2(rng)) / vec2f(size);
    let phi = (uv.x - 0.5) * 2.0 * PI;
    let theta = uv.y * PI;
    let d = vec3f(sin(phi) * sin(theta), cos(theta), -cos(phi) * sin(theta));
    let r = frame.environment_rotation;
    let direction = vec3f(d.x * r.x + d.z * r.y, d.y, d.z * r.x - d.x * r.y);
    return EnvironmentSample(direction, solid_angle_density(density, uv.y));
}
