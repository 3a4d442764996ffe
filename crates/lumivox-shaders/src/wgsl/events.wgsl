// What happens at a collision: the phase function scatters light or, where there is a surface, that reflects it
// specularly or diffusely. Expects `instances`.

fn event_at(v: u32, optics: Optics, reading: Reading, wo: vec3f) -> Event {
    var event = event_of_phase(-wo, instances[v].anisotropy, optics.albedo);
    if (may_reflect(v, reading) && dot(optics.normal, optics.normal) > 0.0) {
        event.normal = facing(optics.normal, wo);
        let cosine = dot(event.normal, wo);
        // Schlick 1994.
        let f0 = surface_specular(v, reading);
        let fresnel = f0 + (1.0 - f0) * pow(1.0 - clamp(cosine, 0.0, 1.0), 5.0);
        event.phase = 1.0 - optics.surface;
        event.specular = optics.surface * fresnel;
        event.white = event.specular * (1.0 - surface_metallic(v, reading));
        event.mirror = 2.0 * cosine * event.normal - wo;
        event.lobe_anisotropy = surface_lobe_anisotropy(v, reading);
    }
    return event;
}
