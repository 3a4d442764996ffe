// Whole paths: loops run as long as they have to, and no path is put aside. The other way is `limited_turns.wgsl`.

fn take_turn() -> bool {
    return true;
}

fn turns_are_spent() -> bool {
    return false;
}

fn has_turn(state: f32, local_index: u32) -> bool {
    return true;
}

fn take_up(
    state: f32,
    index: u32,
    image_pixel: vec2u,
    path: ptr<function, Path>,
    rng: ptr<function, Rng>,
) -> bool {
    return false;
}

fn remember(path: Path, rng: Rng) {
}

fn put_aside(index: u32) -> f32 {
    return 0.0;
}
