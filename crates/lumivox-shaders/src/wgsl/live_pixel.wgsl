// A pixel on its way through the denoiser of live films.

struct DenoiseParams {
    film_size: vec2u,
    // Pixels between taps.
    step: u32,
    // Whether pixels that outshine their neighbours are held back.
    bounded: u32,
}

// Two planes: (mean light, alpha), (variance of its luminance, end of its primary rays, samples, 0).
struct Pixel {
    light: vec3f,
    alpha: f32,
    variance: f32,
    limit: f32,
    samples: f32,
}

// How alike two ends of primary rays are, 1 where they are the same; 0 as a depth stands for infinity.
fn likeness(a: f32, b: f32) -> f32 {
    let x = select(a, 1e6, a == 0.0);
    let y = select(b, 1e6, b == 0.0);
    return max(pow(min(x, y) / max(x, y), 24.0), 1e-4);
}
