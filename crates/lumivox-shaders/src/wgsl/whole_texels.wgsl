// What a texel of a pool says, where each is a number in its first channel: a stored value in [0, 1].

fn stored_value(texel: vec2f, second: f32) -> f32 {
    return texel.r;
}
