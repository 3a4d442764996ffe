// Tracing without a host: nothing ends primary rays.

fn live_limit(index: u32) -> f32 {
    return 0.0;
}

// Where the planes of guides begin.
fn guides_begin(pixels: u32) -> u32 {
    return 2u * pixels;
}
