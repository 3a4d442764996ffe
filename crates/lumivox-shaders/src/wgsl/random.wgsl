// Random numbers as a pure function of (pixel, sample, seed, dimension), so that an image does not depend on tiling,
// order or frame budget. The stream is keyed by pcg4d (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT
// 9(3), 2020); each dimension is hashed by the multiply-xorshift rounds of Wellons' lowbias32 (hash-prospector, 2018).
// Half of the key is added to the dimension; by that alone, streams whose sums meet would be shifted copies of one
// another, so the other half goes in between the rounds.

struct Rng {
    key: vec2u,
    dimension: u32,
}

fn pcg4d(input: vec4u) -> vec4u {
    var v = input * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> vec4u(16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

fn rng_new(pixel: vec2u, sample_index: u32, seed: u32) -> Rng {
    return Rng(pcg4d(vec4u(pixel, sample_index, seed)).xy, 0u);
}

// 32 random bits.
fn rng_bits(rng: ptr<function, Rng>) -> u32 {
    var h = (*rng).dimension * 0x9e3779b9u + (*rng).key.x;
    (*rng).dimension += 1u;
    h = (h ^ (h >> 16u)) * 0x7feb352du;
    h = (h ^ (h >> 15u) ^ (*rng).key.y) * 0x846ca68bu;
    return h ^ (h >> 16u);
}

fn rng_next(rng: ptr<function, Rng>) -> f32 {
    return uniform_of(rng_bits(rng));
}

// Uniform in [0, 1), a multiple of 2^-24.
fn uniform_of(bits: u32) -> f32 {
    return f32(bits >> 8u) * 0x1p-24f;
}

fn rng_next2(rng: ptr<function, Rng>) -> vec2f {
    let x = rng_next(rng);
    return vec2f(x, rng_next(rng));
}
