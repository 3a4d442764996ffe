// A live film as means and the variance of their luminance: what the wavelet passes of `denoise_wavelet` start from.

@group(0) @binding(0) var<uniform> params: DenoiseParams;
@group(0) @binding(1) var<storage, read> film: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> pixels: array<vec4f>;
// Only read where `kept_light` says that it is one.
@group(0) @binding(3) var<storage, read> kept_picture: array<vec4f>;

// Samples from which a pixel's own variance is to be trusted more than its neighbourhood's.
const TRUSTED_SAMPLES: f32 = 8.0;

struct Moments {
    light: vec4f,
    // Of the mean's luminance; negative where nothing is known.
    variance: f32,
    samples: f32,
}

fn moments(at: vec2i) -> Moments {
    let p = vec2u(clamp(at, vec2i(0), vec2i(params.film_size) - 1));
    let index = p.y * params.film_size.x + p.x;
    let sums = film[params.film_size.x * params.film_size.y + index];
    let n = sums.z;
    var m = Moments(vec4f(0.0), -1.0, n);
    if (n > 0.0) {
        m.light = film[index] / n;
        let mean = luminance(m.light.rgb);
        if (n > 1.0) {
            m.variance = max(sums.y / n - mean * mean, 0.0) / (n - 1.0);
        }
        if (params.kept_light != 0u) {
            m.light -= vec4f(kept_picture[index].rgb, 0.0);
        }
    }
    return m;
}

// Twice the third largest luminance of a neighbourhood. Of a coarse film no pixel is shown brighter: one bright path
// among a few is a square that flashes, and a highlight of fewer pixels comes with the fine film.
fn bound_of(at: vec2i) -> f32 {
    if (params.bounded == 0u) {
        // Its square is finite.
        return 1e15;
    }
    var first = 0.0;
    var second = 0.0;
    var third = 0.0;
    for (var i = 0; i < 25; i++) {
        let m = moments(at + vec2i(i % 5, i / 5) - 2);
        let l = luminance(m.light.rgb);
        third = max(third, min(second, l));
        second = max(second, min(first, l));
        first = max(first, l);
    }
    return 2.0 * third;
}

@compute @workgroup_size(8, 8)
fn denoise_prepare(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= params.film_size)) {
        return;
    }
    let centre = moments(vec2i(id.xy));
    // Few samples say little of their own variance, and none at all where all of them missed a rare bright event:
    // neighbours see the same kind of light (Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017).
    let bound = bound_of(vec2i(id.xy));
    var sum = 0.0;
    var squares = 0.0;
    var within = 0.0;
    var known = 0.0;
    var taps = 0.0;
    for (var i = 0; i < 25; i++) {
        let m = moments(vec2i(id.xy) + vec2i(i % 5, i / 5) - 2);
        if (m.samples > 0.0) {
            let l = min(luminance(m.light.rgb), bound);
            sum += l;
            squares += l * l;
            taps += 1.0;
        }
        if (m.variance >= 0.0) {
            within += min(m.variance, bound * bound);
            known += 1.0;
        }
    }
    let mean = sum / max(taps, 1.0);
    let between = max(squares / max(taps, 1.0) - mean * mean, 0.0);
    let around = select(between, within / max(known, 1.0), known > 0.0);
    let trust = clamp((centre.samples - 1.0) / (TRUSTED_SAMPLES - 1.0), 0.0, 1.0);
    let untrusted = max(around, select(0.0, between, centre.samples < 4.0));
    let trusted = max(min(centre.variance, bound * bound), 0.5 * around);
    let variance = mix(untrusted, trusted, trust);

    let index = id.y * params.film_size.x + id.x;
    let scale = min(bound / max(luminance(centre.light.rgb), 1e-30), 1.0);
    pixels[index] = vec4f(centre.light.rgb * scale, centre.light.a);
    let plane = params.film_size.x * params.film_size.y;
    let limit = film[ray_limit_entry(plane, index)][index % 4u];
    let depth = film[plane + index].x / max(film[index].a, 1.0);
    pixels[plane + index] = vec4f(variance, limit, centre.samples, depth);
}
