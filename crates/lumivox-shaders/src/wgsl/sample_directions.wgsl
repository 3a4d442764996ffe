// For the tests: draws directions from one sampler and writes them with their density.

struct SampleParams {
    axis: vec3f,
    // 0 environment; about the axis: 1 Henyey-Greenstein, 2 cosine-weighted, 3 cone, 4 towards a disc at distance 1, 5 all
    // lobes of an event, a fifth of them Henyey-Greenstein along x, three tenths mirroring towards y, half diffuse.
    sampler: u32,
    // Or the cone's height, or the disc's radius.
    anisotropy: f32,
    count: u32,
    padding: vec2u,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> params: SampleParams;
@group(0) @binding(2) var environment_map: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> tables: array<vec2u>;
// Direction, and its density over solid angle.
@group(0) @binding(4) var<storage, read_write> directions: array<vec4f>;

@compute @workgroup_size(64)
fn sample_directions(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.count) {
        return;
    }
    var rng = rng_new(vec2u(id.x, 0u), 0u, frame.seed);
    if (params.sampler == 0u) {
        let light = sample_environment(&rng);
        directions[id.x] = vec4f(light.direction, environment_pdf(light.direction));
        return;
    }
    if (params.sampler == 3u) {
        let cone = to_world(params.axis, sample_cone(params.anisotropy, rng_next2(&rng)));
        directions[id.x] = vec4f(cone, 1.0 / (2.0 * PI * params.anisotropy));
        return;
    }
    if (params.sampler == 4u) {
        let way = sample_disc(params.axis, params.anisotropy, rng_next2(&rng));
        let area = PI * params.anisotropy * params.anisotropy;
        // Over solid angle: distance^2 / cosine over the area, the cosine being 1 / distance.
        directions[id.x] = vec4f(normalize(way), dot(way, way) * length(way) / area);
        return;
    }
    var event = event_of_phase(params.axis, params.anisotropy, vec3f(1.0));
    if (params.sampler == 2u) {
        event.phase = 0.0;
        event.diffuse = 1.0;
    }
    if (params.sampler == 5u) {
        event = Event(
            0.2, vec3f(1.0, 0.0, 0.0), 0.3, vec3f(1.0), 0.0, 0.3, 0.5, vec3f(0.0, 1.0, 0.0), params.axis, params.anisotropy,
        );
    }
    let pick = rng_next(&rng);
    let wi = event_sample(event, pick, rng_next2(&rng));
    directions[id.x] = vec4f(wi, event_pdf(event, wi));
}
