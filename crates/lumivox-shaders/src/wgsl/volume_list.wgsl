// Which volumes a ray may meet, where they are few: all of them, one after the other.

struct Search {
    next: u32,
}

fn search_begin(origin: vec3f, direction: vec3f) -> Search {
    return Search(0u);
}

fn search_next(s: ptr<function, Search>, t_max: f32) -> u32 {
    if ((*s).next == frame.volume_count) {
        return NO_VOLUME;
    }
    (*s).next += 1u;
    return (*s).next - 1u;
}
