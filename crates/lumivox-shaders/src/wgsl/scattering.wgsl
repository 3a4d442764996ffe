// What happens at a collision: the phase function scatters light or, where there is a surface, that reflects it
// specularly or diffusely. Expects `instances`.

fn choose_event(v: u32, optics: Optics, wo: vec3f, rng: ptr<function, Rng>) -> Event {
    if (may_reflect(v)) {
        let is_surface = rng_next(rng) < optics.surface;
        if (is_surface && dot(optics.normal, optics.normal) > 0.0) {
            let normal = facing(optics.normal, wo);
            let cosine = dot(normal, wo);
            // Schlick 1994.
            let f0 = instances[v].surface_specular;
            let fresnel = f0 + (1.0 - f0) * pow(1.0 - clamp(cosine, 0.0, 1.0), 5.0);
            if (rng_next(rng) < fresnel) {
                let mirror = 2.0 * cosine * normal - wo;
                return Event(SPECULAR, mirror, instances[v].surface_lobe_anisotropy, vec3f(1.0));
            }
            return Event(DIFFUSE, normal, 0.0, optics.albedo);
        }
    }
    return Event(PHASE, -wo, instances[v].anisotropy, optics.albedo);
}

struct LightChoice {
    direction: vec3f,
    // Light scattered towards wo, weighted, but for the transmittance on its way here.
    arriving: vec3f,
}

// Next-event estimation: a direction towards light that this event can send on.
//
// Of a few candidates from the environment's own distribution, one is resampled in proportion to what it would bring
// (Talbot, Cline and Egbert, "Importance Resampling for Global Illumination", EGSR 2005), so that the one costly
// transmittance is seldom spent on light behind a surface. Their balance-heuristic weights (Veach 1997) are part of
// the integrand, and the same function of the direction as for paths that find the light by themselves: drivers
// round atan2 and acos as they like, so it is the looked-up density in both, not the one drawn from.
fn choose_light(event: Event, rng: ptr<function, Rng>) -> LightChoice {
    var chosen = LightChoice(event.axis, vec3f(0.0));
    var total = 0.0;
    var chosen_weight = 1.0;
    for (var i = 0u; i < ENVIRONMENT_CANDIDATES; i++) {
        take_turn();
        let light = sample_environment(rng);
        let event_density = event_pdf(event, light.direction);
        let pick = rng_next(rng);
        if (light.pdf > 0.0 && event_density > 0.0) {
            let light_density = environment_pdf(light.direction);
            let arriving = environment_radiance(light.direction)
                * (event_density * light_density / ((light_density + event_density) * light.pdf));
            let weight = luminance(arriving);
            total += weight;
            if (weight > 0.0 && pick * total < weight) {
                chosen = LightChoice(light.direction, arriving);
                chosen_weight = weight;
            }
        }
    }
    chosen.arriving *= total / (chosen_weight * f32(ENVIRONMENT_CANDIDATES));
    return chosen;
}
