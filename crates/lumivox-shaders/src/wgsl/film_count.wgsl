// What a film really holds: hosts compare it with what they asked for.

struct FilmCountParams {
    pixels: u32,
    // Invocations of the dispatch: each counts every n-th pixel, of n of them.
    invocations: u32,
    // Samples that were asked for.
    target_samples: u32,
    padding: u32,
}

struct FilmCount {
    // Samples that every pixel has.
    samples: atomic<u32>,
    // Pixels that have fewer than were asked for.
    short: atomic<u32>,
    // Pixels by the state of the path that is put aside.
    aside: atomic<u32>,
    starved: atomic<u32>,
    stuck: atomic<u32>,
}

@group(0) @binding(0) var<uniform> params: FilmCountParams;
// As `path_trace` writes it.
@group(0) @binding(1) var<storage, read> film: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> count: FilmCount;

@compute @workgroup_size(64)
fn film_count(@builtin(global_invocation_id) id: vec3u) {
    var samples = 0xffffffffu;
    var short = 0u;
    var aside = 0u;
    var starved = 0u;
    var stuck = 0u;
    for (var pixel = id.x; pixel < params.pixels; pixel += params.invocations) {
        let moments = film[params.pixels + pixel];
        samples = min(samples, u32(moments.z));
        short += u32(u32(moments.z) < params.target_samples);
        aside += u32(moments.w == PATH_ASIDE);
        starved += u32(moments.w == PATH_STARVED);
        stuck += u32(moments.w == PATH_STUCK);
    }
    atomicMin(&count.samples, samples);
    atomicAdd(&count.short, short);
    atomicAdd(&count.aside, aside);
    atomicAdd(&count.starved, starved);
    atomicAdd(&count.stuck, stuck);
}
