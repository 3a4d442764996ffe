// Where the primary rays of a live film end: the view depth of the host's surface at each pixel, 0 where there is none.
// One number a pixel behind the film's two planes, four to an entry; `host_depth` writes them. Behind them, in films that have
// them, are the planes of first-hit albedo and normal: where a film's rays end does not depend on that.

// The entry of a pixel; its own is number `index % 4`.
fn ray_limit_entry(pixels: u32, index: u32) -> u32 {
    return 2u * pixels + index / 4u;
}

// The entry behind those of all pixels.
fn ray_limits_end(pixels: u32) -> u32 {
    return 2u * pixels + (pixels + 3u) / 4u;
}
