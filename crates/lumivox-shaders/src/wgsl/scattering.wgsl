// Next-event estimation: light that a collision is asked about, and not found by. Expects `frame`.

// What next-event estimation has found.
struct Arrival {
    direction: vec3f,  // towards the light
    distance: f32,
    // Scattered towards wo, weighted, but for the transmittance on its way here.
    light: vec3f,
}

// Candidates of next-event estimation. What light does to the first collision is most of what is seen.
const FIRST_CANDIDATES: u32 = 8u;
const LATER_CANDIDATES: u32 = 4u;

// For how many samples of the environment next-event estimation counts at the collision that is a path's `bounces`th, where
// its light is weighed against what paths find by themselves. Later, light seldom gets through, and both are as good.
fn light_samples(bounces: u32) -> f32 {
    return select(1.0, 2.0, bounces == 1u);
}

// Next-event estimation: a direction towards light that this event can send on.
//
// Of a few candidates from the environment's own distribution, one is resampled (Talbot, Cline and Egbert, "Importance
// Resampling for Global Illumination", EGSR 2005), so that the one costly transmittance is seldom spent on light behind a
// surface: in proportion to what it would bring, were every cell of the importance grid of one colour. What it really
// brings is looked up for the chosen one alone. Its weight by the balance heuristic (Veach 1997) is part of the integrand,
// and the same function of the direction as for paths that find the light by themselves: drivers round atan2 and acos as
// they like, so it is the looked-up density in both, not the one drawn from. In it, this estimate counts for several samples
// of the environment, for being chosen of several makes it better than one: weights that add up to 1 are all the heuristic
// needs.
fn choose_light(event: Event, bounces: u32, rng: ptr<function, Rng>) -> Arrival {
    let samples = light_samples(bounces);
    let candidates = select(LATER_CANDIDATES, FIRST_CANDIDATES, bounces == 1u);
    var direction = event.onward;
    var total = 0.0;
    var densities = vec2f(0.0);
    var light_density = 0.0;
    for (var i = 0u; i < candidates; i++) {
        take_turn();
        let light = sample_environment(rng);
        let of_event = event_densities(event, light.direction);
        let pick = rng_next(rng);
        // A cell's light is as its density, by which the candidate is divided again.
        let weight = of_event.x * light.pdf / max(of_event.x + samples * light.pdf, 1e-30);
        total += weight;
        if (weight > 0.0 && pick * total < weight) {
            direction = light.direction;
            densities = of_event;
            light_density = light.pdf;
        }
    }
    if (total <= 0.0) {
        return Arrival(direction, 1e30, vec3f(0.0));
    }
    let looked_up = environment_pdf(direction);
    let integrand = event_weight(event, densities) * environment_radiance(direction)
        * (samples * looked_up / (samples * looked_up + densities.x));
    let chance = light_density * light_density / (samples * light_density + densities.x);
    return Arrival(direction, 1e30, integrand * (total / (chance * f32(candidates))));
}
