// What the first two channels of a texel of a pool say, where pools may hold numbers of 16 bits in two of 8: a stored value in
// [0, 1]. Such a number is (256 high + low) / 257; as filters are linear, that holds for what is filtered, too. Of other pools
// the second channel weighs nothing.

fn stored_value(texel: vec2f, second: f32) -> f32 {
    return mix(texel.r, texel.g, second);
}
