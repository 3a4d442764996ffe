// Paths leave nothing behind. The other way is `light_points.wgsl`.

struct PathPoint {
    nothing: u32,
}

fn point_none() -> PathPoint {
    return PathPoint();
}

fn point_begin(path: ptr<function, Path>, v: u32, position: vec3f, depth: f32, event: Event, rng: Rng) -> bool {
    return true;
}

fn point_sent(path: ptr<function, Path>, event: Event, direction: vec3f, light: vec3f) {
}

fn point_onward(path: ptr<function, Path>, event: Event, direction: vec3f) {
}

fn point_end(path: Path) {
}

fn point_words(point: PathPoint, row: u32) -> vec4u {
    return vec4u(0u);
}

fn point_of_words(first: vec4u, second: vec4u) -> PathPoint {
    return PathPoint();
}
