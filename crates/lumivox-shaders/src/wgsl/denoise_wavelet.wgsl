// One pass of an edge-avoiding wavelet transform (Dammertz et al., "Edge-Avoiding A-Trous Wavelet Transform for fast
// Global Illumination Filtering", HPG 2010), its edges guided by the variance of the film itself, as in Schied et al.,
// HPG 2017: what differs by more than noise is kept. As samples come in, noise and with it the filter's reach vanish:
// biased, and consistent.

@group(0) @binding(0) var<uniform> params: DenoiseParams;
@group(0) @binding(1) var<storage, read> before: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> pixels: array<vec4f>;

// Standard deviations of noise that pass for the same light, and the same alpha. Of a coarse film, whose variance is
// mostly that of what its pixels show, fewer.
const DEVIATIONS: f32 = 4.0;
const COARSE_DEVIATIONS: f32 = 2.0;

fn load(at: vec2u) -> Pixel {
    let index = at.y * params.film_size.x + at.x;
    let light = before[index];
    let rest = before[params.film_size.x * params.film_size.y + index];
    return Pixel(light.rgb, light.a, rest.x, rest.y, rest.z, rest.w);
}

// The B3 spline's taps from the middle.
fn spline(i: i32) -> f32 {
    return select(select(0.0625, 0.25, abs(i) == 1), 0.375, i == 0);
}

// How alike what two pixels see can be, with what the host has behind it: what a volume hides from both counts for
// nothing.
fn alike(a: Pixel, b: Pixel) -> f32 {
    let a_is_nearer = a.limit > 0.0 && (b.limit == 0.0 || a.limit < b.limit);
    var opacity = min(a.alpha, b.alpha);
    if ((a_is_nearer && b.depth > a.limit) || (!a_is_nearer && b.limit > 0.0 && a.depth > b.limit)) {
        // The nearer surface hides it.
        opacity = 0.0;
    }
    return mix(likeness(a.limit, b.limit), 1.0, hidden(opacity));
}

@compute @workgroup_size(8, 8)
fn denoise_wavelet(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= params.film_size)) {
        return;
    }
    let centre = load(id.xy);
    let brightness = luminance(centre.light);
    let deviations = select(DEVIATIONS, COARSE_DEVIATIONS, params.bounded != 0u);
    let light_noise = deviations * sqrt(centre.variance) + 1e-6;
    // The variance of a fraction, with a hit and a miss more than there were (Agresti and Coull 1998): never 0.
    let a = (centre.alpha * centre.samples + 1.0) / (centre.samples + 2.0);
    let alpha_noise = deviations * sqrt(a * (1.0 - a) / (centre.samples + 2.0));

    var light = vec4f(0.0);
    var variance = 0.0;
    var weights = 0.0;
    for (var i = 0; i < 25; i++) {
        let offset = vec2i(i % 5, i / 5) - 2;
        let at = vec2i(id.xy) + offset * i32(params.step);
        if (any(at < vec2i(0)) || any(at >= vec2i(params.film_size))) {
            continue;
        }
        let tap = load(vec2u(at));
        if (tap.samples == 0.0) {
            continue;
        }
        let differs = abs(luminance(tap.light) - brightness) / light_noise
            + abs(tap.alpha - centre.alpha) / alpha_noise;
        var w = spline(offset.x) * spline(offset.y);
        if (centre.samples > 0.0) {
            w *= exp(-differs) * alike(tap, centre);
        }
        light += w * vec4f(tap.light, tap.alpha);
        variance += w * w * tap.variance;
        weights += w;
    }
    let index = id.y * params.film_size.x + id.x;
    let w = max(weights, 1e-12);
    pixels[index] = light / w;
    pixels[params.film_size.x * params.film_size.y + index] =
        vec4f(variance / (w * w), centre.limit, centre.samples, centre.depth);
}
