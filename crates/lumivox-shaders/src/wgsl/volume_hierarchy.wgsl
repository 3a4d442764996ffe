// Which volumes a ray may meet, where they are many: those whose boxes it passes through, found in a binary hierarchy of
// boxes (Kay and Kajiya, "Ray Tracing Complex Scenes", 1986) and roughly from near to far, so that a collision in a near
// volume spares the ray those behind it.

// Every node halves its volumes, and a GPU's buffers bind fewer than 2^16 transfer functions: the walk cannot overflow.
const SEARCH_DEPTH: u32 = 16u;

struct Search {
    origin: vec3f,
    inverse: vec3f,  // of the direction
    depth: u32,
}

// What is still to be looked at, and where the ray enters it. An invocation has one search at a time, and Microsoft's FXC
// gives up over a loop with arrays in a struct that functions hand on.
var<private> search_indices: array<u32, SEARCH_DEPTH>;
var<private> search_entries: array<f32, SEARCH_DEPTH>;

fn search_begin(origin: vec3f, direction: vec3f) -> Search {
    var s: Search;
    s.origin = origin;
    // A component of exactly 0 would turn into 0 * infinity.
    s.inverse = 1.0 / choose(direction, vec3f(1e-20), abs(direction) < vec3f(1e-20));
    s.depth = 1u;
    // The root, or the one volume that there is.
    search_indices[0] = select(0u, IS_VOLUME, frame.volume_count == 1u);
    search_entries[0] = 0.0;
    return s;
}

const CHILD_PAIRS: u32 = 4u;

fn child_of(node: u32, side: u32) -> Child {
    let first = frame.first_node + CHILD_PAIRS * (2u * node + side);
    let low = words_at(first);
    let high = words_at(first + 2u);
    return Child(bitcast<vec3f>(low.xyz), low.w, bitcast<vec3f>(high.xyz), high.w);
}

// Where the ray enters a child's box; infinitely far away where it does not, or only beyond t_max.
fn box_entry(s: ptr<function, Search>, child: Child, t_max: f32) -> f32 {
    let a = (child.low - (*s).origin) * (*s).inverse;
    let b = (child.high - (*s).origin) * (*s).inverse;
    let near = min(a, b);
    let far = max(a, b);
    let entry = max(max(near.x, near.y), max(near.z, 0.0));
    let exit = min(min(far.x, far.y), far.z);
    return select(1e38, entry, entry <= exit && entry < t_max);
}

// The next volume that the ray may meet before t_max, or NO_VOLUME.
fn search_next(s: ptr<function, Search>, t_max: f32) -> u32 {
    while ((*s).depth > 0u && take_turn()) {
        (*s).depth -= 1u;
        if (search_entries[(*s).depth] >= t_max) {
            continue;
        }
        var index = search_indices[(*s).depth];
        while ((index & IS_VOLUME) == 0u && take_turn()) {
            let child_0 = child_of(index, 0u);
            let child_1 = child_of(index, 1u);
            let entry_0 = box_entry(s, child_0, t_max);
            let entry_1 = box_entry(s, child_1, t_max);
            let second_is_near = entry_1 < entry_0;
            let far_entry = max(entry_0, entry_1);
            if (min(entry_0, entry_1) >= 1e38) {
                break;
            }
            if (far_entry < 1e38) {
                search_indices[(*s).depth] = select(child_1.index, child_0.index, second_is_near);
                search_entries[(*s).depth] = far_entry;
                (*s).depth += 1u;
            }
            index = select(child_0.index, child_1.index, second_is_near);
        }
        if ((index & IS_VOLUME) != 0u) {
            return index & ~IS_VOLUME;
        }
    }
    return NO_VOLUME;
}
