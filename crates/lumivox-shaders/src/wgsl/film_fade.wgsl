// What a live film keeps where the scene's light has changed a little: its samples count less than before, in fractions of
// samples, and what they brought is as many times as bright as is known.

struct FilmFadeParams {
    film_size: vec2u,
    // The part of its samples that a pixel keeps, one at least.
    kept: f32,
    // How many times as bright their light has become.
    scale: f32,
    // Whether the film has guides. They are sums over hits: fewer count.
    guides: u32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

@group(0) @binding(0) var<uniform> params: FilmFadeParams;
// As `path_trace` writes it.
@group(0) @binding(1) var<storage, read_write> film: array<vec4f>;

@compute @workgroup_size(8, 8)
fn film_fade(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= params.film_size)) {
        return;
    }
    let plane = params.film_size.x * params.film_size.y;
    let index = id.y * params.film_size.x + id.x;
    let moments = film[plane + index];
    let samples = moments.z;
    if (samples == 0.0) {
        return;
    }
    let left = max(samples * params.kept, 1.0);
    let kept = left / samples;
    let sum = film[index];
    film[index] = kept * vec4f(params.scale * sum.rgb, sum.a);
    film[plane + index] = vec4f(kept * vec2f(moments.x, params.scale * params.scale * moments.y), left, moments.w);
    if (params.guides != 0u) {
        let guides = ray_limits_end(plane) + index;
        film[guides] *= kept;
        film[guides + plane] *= kept;
    }
}
