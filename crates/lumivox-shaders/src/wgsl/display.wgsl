// The film to pixels: average, background, exposure, tone map. CPU twin: lumivox-renderer's `display.rs`.

struct DisplayParams {
    // Linear RGB behind the volumes.
    background: vec3f,
    // 0 transparent, 1 the colour, 2 the environment.
    background_kind: u32,
    exposure_scale: f32,
    tone_operator: u32,
    inverse_gamma: f32,
    padding: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> params: DisplayParams;
@group(0) @binding(2) var<storage, read> film: array<vec4f>;
@group(0) @binding(3) var environment_map: texture_2d<f32>;
// Eight bits a channel, red lowest, alpha not premultiplied.
@group(0) @binding(4) var<storage, read_write> pixels: array<u32>;

@compute @workgroup_size(8, 8)
fn display(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= frame.film_size)) {
        return;
    }
    let index = id.y * frame.film_size.x + id.x;
    let samples = film[frame.film_size.x * frame.film_size.y + index].z;
    let mean = film[index] / max(samples, 1.0);
    var light = mean.rgb;
    var alpha = 1.0;
    if (params.background_kind == BACKGROUND_TRANSPARENT) {
        // The tone map is not linear: apply it to the volume's own colour, not to its blend with black.
        alpha = mean.a;
        light = select(vec3f(0.0), light / max(alpha, 1e-6), alpha > 0.0);
    } else {
        var behind = params.background;
        if (params.background_kind == BACKGROUND_ENVIRONMENT) {
            behind = environment_radiance(camera_ray(id.xy + frame.film_origin, vec2f(0.5)).direction);
        }
        light += (1.0 - mean.a) * behind;
    }
    let mapped = tone_map(light * params.exposure_scale, params.tone_operator, params.inverse_gamma);
    pixels[index] = pack4x8unorm(vec4f(mapped, alpha));
}
