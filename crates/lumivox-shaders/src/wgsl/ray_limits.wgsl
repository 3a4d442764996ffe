// Where the primary rays of a live film end: the view depth of the host's surface at each pixel, 0 where there is none.
// One number a pixel behind the film's two planes, four to an entry; `host_depth` writes them.

// The entry of a pixel; its own is number `index % 4`.
fn ray_limit_entry(pixels: u32, index: u32) -> u32 {
    return 2u * pixels + index / 4u;
}
