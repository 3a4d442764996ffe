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

fn point_sent(point: PathPoint, event: Event, direction: vec3f, light: vec3f) {
}

fn point_onward(point: PathPoint, event: Event, direction: vec3f) {
}

fn point_end(point: PathPoint, light: vec3f) {
}

fn point_put_aside(point: PathPoint, remembered: PathPoint) -> array<vec4u, 2> {
    return array<vec4u, 2>();
}

fn point_taken_up(first: vec4u, second: vec4u) -> PathPoint {
    return PathPoint();
}
