// All bricks lie in one pool: for drivers in software, which run every branch of a choice for all invocations.

@group(0) @binding(POOL_BINDING) var pool: texture_3d<f32>;

fn load_texel(index: u32, texel: vec3i) -> vec2f {
    return textureLoad(pool, texel, 0).rg;
}
