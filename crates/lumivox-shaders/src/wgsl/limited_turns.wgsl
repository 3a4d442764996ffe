// Paths in pieces, for drivers that end an invocation after so many turns of all its loops together, without a word.
//
// An invocation counts its turns. When they are spent, what its loops found since the path's last event is worth
// nothing: the path is put aside as it was at that event, and the next dispatch takes it up there, with the same random
// numbers. Expects `frame`, `GUIDES`, `POINTS` and `CLASSES`.

// What is put aside of each pixel, in planes: (origin, random dimension), (direction, pdf), (throughput, bounces),
// (radiance, depth) and, with GUIDES, (albedo, 0), (normal, 0), or, with POINTS, two of the point that it leaves. As bits: small integers are no floats to be copied.
@group(0) @binding(PATHS_BINDING) var<storage, read_write> paths: array<vec4u>;

var<private> turns_left: i32;
var<private> remembered: Path;
var<private> remembered_dimension: u32;
var<private> turns_at_event: i32;

// What a turn counts. The driver counts the turns that end loops, too, which kernels do not: with classified media, whose
// every point has short loops of its own, there are more than twice as many as those that are taken.
const TURN: i32 = select(1, 3, CLASSES);

// Counts a turn of a loop. False when there are none left: the loop has to end.
fn take_turn() -> bool {
    turns_left -= TURN;
    return turns_left >= 0;
}

fn turns_are_spent() -> bool {
    return turns_left < 0;
}

// Whether this dispatch is for a pixel in such a state. A starved one waits for a dispatch in which its invocation is
// the only one of those that the driver runs together, and has the turns of all of them.
fn has_turn(state: f32, local_index: u32) -> bool {
    turns_left = i32(frame.turn_limit);
    if (frame.lone_invocation == NONE_IS_ALONE) {
        return state < PATH_STARVED;
    }
    return state == PATH_STARVED && local_index % TOGETHER == frame.lone_invocation;
}

// Goes on with the path that was put aside, if there is one.
fn take_up(
    state: f32,
    index: u32,
    image_pixel: vec2u,
    path: ptr<function, Path>,
    rng: ptr<function, Rng>,
) -> bool {
    if (state == PATH_NONE) {
        return false;
    }
    *path = path_begin(image_pixel, rng);
    let plane = frame.film_size.x * frame.film_size.y;
    (*path).bounces = paths[2u * plane + index].w;
    if ((*path).bounces > 0u) {
        (*rng).dimension = paths[index].w;
        (*path).origin = bitcast<vec3f>(paths[index].xyz);
        (*path).direction = bitcast<vec3f>(paths[plane + index].xyz);
        (*path).pdf = bitcast<f32>(paths[plane + index].w);
        (*path).throughput = bitcast<vec3f>(paths[2u * plane + index].xyz);
        (*path).radiance = bitcast<vec3f>(paths[3u * plane + index].xyz);
        (*path).depth = bitcast<f32>(paths[3u * plane + index].w);
        if (GUIDES) {
            (*path).albedo = bitcast<vec3f>(paths[4u * plane + index].xyz);
            (*path).normal = bitcast<vec3f>(paths[5u * plane + index].xyz);
        }
        if (POINTS) {
            (*path).point = point_of_words(paths[4u * plane + index], paths[5u * plane + index]);
        }
    }
    return true;
}

// The path as it is before its next event.
fn remember(path: Path, rng: Rng) {
    remembered = path;
    remembered_dimension = rng.dimension;
    turns_at_event = turns_left;
    turns_left -= TURN;
}

// Puts the path aside as it was remembered; returns its state.
fn put_aside(index: u32) -> f32 {
    let plane = frame.film_size.x * frame.film_size.y;
    paths[index] = vec4u(bitcast<vec3u>(remembered.origin), remembered_dimension);
    paths[plane + index] = vec4u(bitcast<vec3u>(remembered.direction), bitcast<u32>(remembered.pdf));
    paths[2u * plane + index] = vec4u(bitcast<vec3u>(remembered.throughput), remembered.bounces);
    paths[3u * plane + index] = vec4u(bitcast<vec3u>(remembered.radiance), bitcast<u32>(remembered.depth));
    if (GUIDES) {
        paths[4u * plane + index] = vec4u(bitcast<vec3u>(remembered.albedo), 0u);
        paths[5u * plane + index] = vec4u(bitcast<vec3u>(remembered.normal), 0u);
    }
    if (POINTS) {
        for (var row = 0u; row < 2u; row++) {
            paths[(4u + row) * plane + index] = point_words(remembered.point, row);
        }
    }
    if (turns_at_event < i32(frame.turn_limit)) {
        return PATH_ASIDE;
    }
    return select(PATH_STUCK, PATH_STARVED, frame.lone_invocation == NONE_IS_ALONE);
}
