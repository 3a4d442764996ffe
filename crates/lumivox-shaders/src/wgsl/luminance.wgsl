// Relative luminance of linear sRGB (ITU-R BT.709).
fn luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}
