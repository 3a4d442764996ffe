// Up to MAX_POOLS pools: WGSL has no arrays of textures.

@group(0) @binding(POOL_BINDING + 0u) var pool_0: texture_3d<f32>;
@group(0) @binding(POOL_BINDING + 1u) var pool_1: texture_3d<f32>;
@group(0) @binding(POOL_BINDING + 2u) var pool_2: texture_3d<f32>;
@group(0) @binding(POOL_BINDING + 3u) var pool_3: texture_3d<f32>;

fn load_texel(index: u32, texel: vec3i) -> vec2f {
    switch index {
        case 1u: { return textureLoad(pool_1, texel, 0).rg; }
        case 2u: { return textureLoad(pool_2, texel, 0).rg; }
        case 3u: { return textureLoad(pool_3, texel, 0).rg; }
        default: { return textureLoad(pool_0, texel, 0).rg; }
    }
}
