// A pixel on its way through the denoiser of live films.

struct DenoiseParams {
    film_size: vec2u,
    // Pixels between taps.
    step: u32,
    // Whether pixels that outshine their neighbours are held back.
    bounded: u32,
    // Whether light is what the film shows more than the picture of kept light, which has no noise.
    kept_light: u32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

// Two planes: (mean light, alpha), (variance of its luminance, end of its primary rays, samples, mean view depth of the
// first hits).
struct Pixel {
    light: vec3f,
    alpha: f32,
    variance: f32,
    limit: f32,
    samples: f32,
    depth: f32,
}
