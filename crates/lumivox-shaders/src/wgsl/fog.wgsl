// An engine's fog over what a film shows; `Fog` in lumivox-renderer is its twin, and says what the numbers are.

// Premultiplied light that is seen at a view depth, at a point of the target in [0, 1].
fn fogged(light: vec3f, alpha: f32, uv: vec2f, depth: f32) -> vec3f {
    if (params.fog_kind == FOG_NONE) {
        return light;
    }
    let edges = params.camera_edges;
    let across = vec2f(mix(edges.x, edges.y, uv.x), mix(edges.w, edges.z, uv.y));
    let seen = vec3f(across * select(depth, 1.0, params.camera_parallel != 0u), -depth);
    return mix(light, params.fog_color * alpha, fog_amount(seen));
}

// At a point in the camera's frame.
fn fog_amount(seen: vec3f) -> f32 {
    let distance = length(seen);
    let by_distance = params.fog_distance;
    var amount = 0.0;
    if (params.fog_kind == FOG_EXPONENTIAL) {
        amount = 1.0 - exp(-distance * by_distance.x);
    } else if (params.fog_kind == FOG_BETWEEN) {
        let t = smoothstep(by_distance.x, by_distance.y, distance);
        amount = select(0.0, pow(t, by_distance.z), t > 0.0) * by_distance.w;
    } else if (params.fog_kind == FOG_LINEAR_IN_DEPTH) {
        amount = clamp((-seen.z - by_distance.x) / (by_distance.y - by_distance.x), 0.0, 1.0);
    } else if (params.fog_kind == FOG_EXPONENTIAL_IN_DEPTH) {
        amount = 1.0 - exp(seen.z * by_distance.x);
    } else if (params.fog_kind == FOG_EXPONENTIAL_SQUARED_IN_DEPTH) {
        amount = 1.0 - exp(-(seen.z * by_distance.x) * (seen.z * by_distance.x));
    }
    let height = dot(params.world_height.xyz, seen) + params.world_height.w;
    let by_height = 1.0 - exp(min(0.0, (height - params.fog_height.x) * params.fog_height.y));
    return clamp(max(amount, by_height), 0.0, 1.0);
}
