// The engine's lights. No path hits them, so next-event estimation is all there is, and needs no weights.
//
// Expects `tables`, `frame` and `LIGHTS`.

struct Light {
    // In the world; unused where light comes from afar.
    position: vec3f,
    kind: u32,
    // Irradiance, or intensity.
    color: vec3f,
    // Radius of the disc in world units, or 1 - cos(angular radius); 0 for light without size.
    size: f32,
    // Where light travels to.
    axis: vec3f,
    // It reaches the instances whose mask shares a bit.
    layers: u32,
    // Falloff: max(1 - (d * inverse_range)^4, 0)^2 * d^-decay; where the decay is negative, `Falloff::Relative`.
    inverse_range: f32,
    decay: f32,
    // 1 / (1 - cos(half angle)) of a spot, and the exponent towards its edge; where that is negative, `Cone::Between`, and
    // it is the slope there.
    inverse_cone: f32,
    cone_attenuation: f32,
}

const LIGHT_PAIRS: u32 = 8u;

fn light_at(i: u32) -> Light {
    let first = frame.first_light + LIGHT_PAIRS * i;
    let a = words_at(first);
    let b = words_at(first + 2u);
    let c = words_at(first + 4u);
    let d = bitcast<vec4f>(words_at(first + 6u));
    return Light(
        bitcast<vec3f>(a.xyz), a.w, bitcast<vec3f>(b.xyz), bitcast<f32>(b.w), bitcast<vec3f>(c.xyz), c.w, d.x, d.y, d.z, d.w,
    );
}

// What arrives at a point from one place on a light, across the beam, but for the transmittance on its way.
fn light_arrival(light: Light, point: vec3f, rng: ptr<function, Rng>) -> Arrival {
    let size = light.size;
    if (light.kind == LIGHT_DIRECTIONAL) {
        var direction = -light.axis;
        if (size > 0.0) {
            direction = to_world(direction, sample_cone(size, rng_next2(rng)));
        }
        return Arrival(direction, 1e30, light.color);
    }
    var way = light.position - point;
    var distance = length(way);
    let d = max(distance, max(size, MIN_LIGHT_DISTANCE));
    let nearness = d * light.inverse_range;
    let window = max(1.0 - nearness * nearness * nearness * nearness, 0.0);
    var factor = window * window * pow(d, -light.decay);
    if (light.decay < 0.0) {
        factor = clamp(5.0 - 5.0 * nearness, 0.0, 1.0) / (1.0 + 25.0 * nearness * nearness);
    }
    if (light.kind == LIGHT_SPOT) {
        // 1 - cos(a) is half the squared difference of the unit vectors, to all digits for narrow cones.
        let difference = light.axis + way / max(distance, 1e-20);
        let rim = clamp(0.5 * dot(difference, difference) * light.inverse_cone, 1e-4, 1.0);
        let attenuation = light.cone_attenuation;
        let ramp = min((rim - 1.0) * attenuation, 1.0);
        factor *= select(1.0 - pow(rim, max(attenuation, 0.0)), ramp * ramp, attenuation < 0.0);
    }
    if (factor > 0.0 && size > 0.0) {
        way = sample_disc(way, size, rng_next2(rng));
        distance = length(way);
    }
    return Arrival(way / max(distance, 1e-20), distance, light.color * max(factor, 0.0));
}

// Of all lights one, resampled in proportion to what it would bring unshadowed (Talbot, Cline and Egbert, "Importance
// Resampling for Global Illumination", EGSR 2005; the reservoir is Chao's, Biometrika 69(3), 1982): one shadow ray
// for any number of lights.
fn choose_arrival(event: Event, layers: u32, point: vec3f, rng: ptr<function, Rng>) -> Arrival {
    var chosen = Arrival(event.onward, 0.0, vec3f(0.0));
    var total = 0.0;
    var chosen_weight = 1.0;
    for (var i = 0u; i < frame.light_count && take_turn(); i++) {
        let light = light_at(i);
        // A light of other layers draws no number: it must not change an image.
        if ((light.layers & layers) == 0u) {
            continue;
        }
        var arrival = light_arrival(light, point, rng);
        let densities = event_densities(event, arrival.direction);
        arrival.light *= event_weight(event, densities) * densities.x;
        let weight = luminance(arrival.light);
        if (weight > 0.0) {
            total += weight;
            if (rng_next(rng) * total < weight) {
                chosen = arrival;
                chosen_weight = weight;
            }
        }
    }
    chosen.light *= total / chosen_weight;
    return chosen;
}
