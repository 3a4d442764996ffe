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

// Where the ray enters a child's box; infinitely far away where it does not, or only beyond t_max.
fn box_entry(s: ptr<function, Search>, node: u32, side: u32, t_max: f32) -> f32 {
    let a = (nodes[node].children[side].low - (*s).origin) * (*s).inverse;
    let b = (nodes[node].children[side].high - (*s).origin) * (*s).inverse;
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
            let entry_0 = box_entry(s, index, 0u, t_max);
            let entry_1 = box_entry(s, index, 1u, t_max);
            let near = select(0u, 1u, entry_1 < entry_0);
            let far_entry = max(entry_0, entry_1);
            if (min(entry_0, entry_1) >= 1e38) {
                break;
            }
            if (far_entry < 1e38) {
                search_indices[(*s).depth] = nodes[index].children[1u - near].index;
                search_entries[(*s).depth] = far_entry;
                (*s).depth += 1u;
            }
            index = nodes[index].children[near].index;
        }
        if ((index & IS_VOLUME) != 0u) {
            return index & ~IS_VOLUME;
        }
    }
    return NO_VOLUME;
}
