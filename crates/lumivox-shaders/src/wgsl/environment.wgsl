// Light from afar: an equirectangular map, and one colour besides. Expects `environment_map` and `frame`.

fn environment_uv(direction: vec3f) -> vec2f {
    let r = frame.environment_rotation;
    let d = vec3f(direction.x * r.x - direction.z * r.y, direction.y, direction.x * r.y + direction.z * r.x);
    // atan2 of (0, 0), straight up or down, is no number on some drivers; every column is the same there.
    let at_pole = abs(d.x) + abs(d.z) < 1e-12;
    let phi = atan2(select(d.x, 0.0, at_pole), select(-d.z, 1.0, at_pole));
    return vec2f(phi / (2.0 * PI) + 0.5, acos(clamp(d.y, -1.0, 1.0)) / PI);
}

fn environment_texel(x: i32, y: i32) -> vec3f {
    let size = vec2i(frame.environment_size);
    let column = select(x, select(x - size.x, x + size.x, x < 0), x < 0 || x >= size.x);
    return textureLoad(environment_map, vec2i(column, clamp(y, 0, size.y - 1)), 0).rgb;
}

fn environment_radiance(direction: vec3f) -> vec3f {
    let p = environment_uv(direction) * vec2f(frame.environment_size) - 0.5;
    let i = vec2i(floor(p));
    let f = p - floor(p);
    let top = mix(environment_texel(i.x, i.y), environment_texel(i.x + 1, i.y), f.x);
    let bottom = mix(environment_texel(i.x, i.y + 1), environment_texel(i.x + 1, i.y + 1), f.x);
    return mix(top, bottom, f.y) * frame.environment_strength + frame.ambient;
}
