// How alike two ends of primary rays are, 1 where they are the same; 0 as a depth stands for infinity.
fn likeness(a: f32, b: f32) -> f32 {
    let x = select(a, 1e6, a == 0.0);
    let y = select(b, 1e6, b == 0.0);
    return max(pow(min(x, y) / max(x, y), 24.0), 1e-4);
}

// How much of an opaque volume counts for likeness: what lets a tenth through hides less than half of what is behind it.
const HIDING: f32 = 8.0;

// What of the ends of primary rays tells nothing, for the rays end before in a volume, given the share of those that do.
fn hidden(opacity: f32) -> f32 {
    return pow(clamp(opacity, 0.0, 1.0), HIDING);
}
