// The depth of what a live film shows, for all that the host draws later: transparent things, depth of field, fog.

// What is more transparent than this has no depth: what lies behind it is seen better than it is itself.
const LEAST_ALPHA: f32 = 0.5;

@fragment
fn composite_depth(@builtin(position) position: vec4f) -> @builtin(frag_depth) f32 {
    let uv = position.xy / params.target_size;
    let last = vec2i(params.fine_size) - 1;
    let at = vec2u(clamp(vec2i(uv * vec2f(params.fine_size)), vec2i(0), last));
    let e = picture(uv, film_limit(false, at));
    if (e.alpha < LEAST_ALPHA || e.depth <= 0.0) {
        discard;
    }
    let map = params.ndc_from_view_depth;
    return clamp((map.x * e.depth + map.y) / (map.z * e.depth + map.w), 0.0, 1.0);
}
