// Several invocations may share the samples of a pixel: where there are few pixels, one each keeps no large GPU busy, and
// what takes longest is one invocation's paths. Expects `frame` and `film`.

// Invocations in a row that share a pixel: a power of two, WORKGROUP_X at most.
fn sharers() -> u32 {
    return frame.sharers;
}

// The sums of all that share a pixel, for the first of them. Every invocation of the workgroup has to call it, with whether its
// pixel is one of the film. The others' go through the film, one after the other, and the first puts back what was there: a
// kernel with memory of the workgroup is 4 to 8% slower on an H100 even where nobody shares, this one 4% at most.
fn gather(own: Sums, sharer: u32, index: u32, is_of_film: bool) -> Sums {
    var all = own;
    if (frame.sharers == 1u) {
        return all;
    }
    let plane = frame.film_size.x * frame.film_size.y;
    let is_first = is_of_film && sharer == 0u;
    var light = vec4f(0.0);
    var moments = vec4f(0.0);
    if (is_first) {
        light = film[index];
        moments = film[plane + index];
    }
    for (var i = 1u; i < frame.sharers; i++) {
        storageBarrier();
        if (is_of_film && sharer == i) {
            film[index] = own.light;
            film[plane + index] = own.moments;
        }
        storageBarrier();
        if (is_first) {
            all.light += film[index];
            all.moments += film[plane + index];
        }
    }
    if (is_first) {
        film[index] = light;
        film[plane + index] = moments;
    }
    return all;
}
