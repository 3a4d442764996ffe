// Bricks of voxels in pools: 3D textures, each of one format. Expects `POOL_BINDING`, the first of as many bindings as
// there are pools; how one of them is chosen is in `one_pool.wgsl` and `many_pools.wgsl`.
//
// A brick holds BRICK_SIZE voxels along each axis and one more, the first beyond it. What lies beyond the volume repeats
// the last voxel. Its page says where it is: PAGE_BITS for its place along each axis in bricks, x lowest, then the pool.

// The brick's first texel.
fn brick_origin(page: u32) -> vec3u {
    let mask = vec3u((1u << PAGE_BITS) - 1u);
    return ((vec3u(page) >> vec3u(0u, PAGE_BITS, 2u * PAGE_BITS)) & mask) * BRICK_TEXELS;
}

fn pool_of(page: u32) -> u32 {
    return page >> (3u * PAGE_BITS);
}
