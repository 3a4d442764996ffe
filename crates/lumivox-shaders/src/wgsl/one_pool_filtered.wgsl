// Filtered texels of the only pool. Expects `linear_sampler`.

fn sample_pool(index: u32, at: vec3f) -> vec2f {
    return textureSampleLevel(pool, linear_sampler, at, 0.0).rg;
}
