// How alike two ends of primary rays are, 1 where they are the same; 0 as a depth stands for infinity.
fn likeness(a: f32, b: f32) -> f32 {
    let x = select(a, 1e6, a == 0.0);
    let y = select(b, 1e6, b == 0.0);
    return max(pow(min(x, y) / max(x, y), 24.0), 1e-4);
}
