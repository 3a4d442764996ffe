// Tracing into a host's image: rays end at what the host has drawn. Expects `film` and `ray_limits`.

fn live_limit(index: u32) -> f32 {
    return film[ray_limit_entry(frame.film_size.x * frame.film_size.y, index)][index % 4u];
}

// Where the planes of guides begin.
fn guides_begin(pixels: u32) -> u32 {
    return ray_limits_end(pixels);
}
