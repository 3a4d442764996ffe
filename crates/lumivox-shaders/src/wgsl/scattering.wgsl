// What happens at a collision: the phase function scatters light or, where the gradient says there is a surface, that
// reflects it specularly or diffusely. Expects `instances`.

// A gradient, as a surface's normal on the side of wo; zero where there is none.
fn facing_normal(v: u32, gradient: vec3f, wo: vec3f) -> vec3f {
    let g = world_gradient(v, gradient);
    let size = length(g);
    if (size < 1e-20) {
        return vec3f(0.0);
    }
    let n = g / size;
    return select(-n, n, dot(n, wo) >= 0.0);
}

// The probability that a collision happens at a surface (after Kroes, Post and Botha, "Exposure Render", PLoS ONE
// 7(7), 2012, with a Gaussian fall-off so that noise is no surface).
fn surface_probability(v: u32, gradient: vec3f) -> f32 {
    let per_mm = length(rotate_rows(instances[v].patient_gradient_from_voxel, gradient))
        * instances[v].value_per_texel * instances[v].surface_inverse_gradient;
    return instances[v].surface_strength * (1.0 - exp(-per_mm * per_mm));
}

fn choose_event(
    v: u32,
    gradient: vec3f,
    scattering_albedo: vec3f,
    wo: vec3f,
    rng: ptr<function, Rng>,
) -> Event {
    if (SURFACE && instances[v].surface_strength > 0.0) {
        let normal = facing_normal(v, gradient, wo);
        let is_surface = rng_next(rng) < surface_probability(v, gradient);
        if (is_surface && dot(normal, normal) > 0.0) {
            let cosine = dot(normal, wo);
            // Schlick 1994.
            let f0 = instances[v].surface_specular;
            let fresnel = f0 + (1.0 - f0) * pow(1.0 - clamp(cosine, 0.0, 1.0), 5.0);
            if (rng_next(rng) < fresnel) {
                let mirror = 2.0 * cosine * normal - wo;
                return Event(SPECULAR, mirror, instances[v].surface_lobe_anisotropy, vec3f(1.0));
            }
            return Event(DIFFUSE, normal, 0.0, scattering_albedo);
        }
    }
    return Event(PHASE, -wo, instances[v].anisotropy, scattering_albedo);
}
