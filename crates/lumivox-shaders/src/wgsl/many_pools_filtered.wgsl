// Filtered texels of one of many pools. Expects `linear_sampler`.

fn sample_pool(index: u32, at: vec3f) -> vec2f {
    switch index {
        case 1u: { return textureSampleLevel(pool_1, linear_sampler, at, 0.0).rg; }
        case 2u: { return textureSampleLevel(pool_2, linear_sampler, at, 0.0).rg; }
        case 3u: { return textureSampleLevel(pool_3, linear_sampler, at, 0.0).rg; }
        default: { return textureSampleLevel(pool_0, linear_sampler, at, 0.0).rg; }
    }
}
