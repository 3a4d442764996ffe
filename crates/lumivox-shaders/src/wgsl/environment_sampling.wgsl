// Importance sampling of the environment, by luminance times sin(theta). Expects `environment_importance` and `frame`.

struct ImportanceCell {
    // Alias method (Walker 1977; Vose 1991): below the threshold the cell itself, else the alias.
    threshold: f32,
    alias_index: u32,
    // Probability density over the map's unit square.
    density: f32,
    padding: f32,
}

// From a density over the map's unit square to one over solid angle: d(omega) = 2 pi^2 sin(theta) du dv.
fn solid_angle_density(density: f32, v: f32) -> f32 {
    return density / (2.0 * PI * PI * max(sin(v * PI), 1e-6));
}

fn environment_pdf(direction: vec3f) -> f32 {
    let uv = environment_uv(direction);
    let size = frame.importance_size;
    let cell = min(vec2u(uv * vec2f(size)), size - 1u);
    return solid_angle_density(environment_importance[cell.y * size.x + cell.x].density, uv.y);
}

struct EnvironmentSample {
    direction: vec3f,
    pdf: f32,  // over solid angle
}

fn sample_environment(rng: ptr<function, Rng>) -> EnvironmentSample {
    let size = frame.importance_size;
    let count = size.x * size.y;
    var index = min(u32(rng_next(rng) * f32(count)), count - 1u);
    if (rng_next(rng) >= environment_importance[index].threshold) {
        index = environment_importance[index].alias_index;
    }
    let uv = (vec2f(f32(index % size.x), f32(index / size.x)) + rng_next2(rng)) / vec2f(size);
    let phi = (uv.x - 0.5) * 2.0 * PI;
    let theta = uv.y * PI;
    let d = vec3f(sin(phi) * sin(theta), cos(theta), -cos(phi) * sin(theta));
    let r = frame.environment_rotation;
    let direction = vec3f(d.x * r.x + d.z * r.y, d.y, d.z * r.x - d.x * r.y);
    return EnvironmentSample(direction, solid_angle_density(environment_importance[index].density, uv.y));
}
