// Pipelines that cover a whole target: what a test put into a scene, and copies from texture to texture.

@group(0) @binding(0) var<storage, read> pixels: array<f32>;
@group(0) @binding(1) var source: texture_2d<f32>;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let at = vec2(f32(index / 2u) * 2.0, f32(index % 2u) * 2.0);
    return Corner(vec4(at * 2.0 - 1.0, 0.0, 1.0), vec2(at.x, 1.0 - at.y));
}

struct Filled {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

// The pixels follow the target's width, which takes four words.
fn first(at: vec4<f32>) -> u32 {
    return 4u + 5u * (u32(at.y) * bitcast<u32>(pixels[0]) + u32(at.x));
}

fn color_from(start: u32) -> vec4<f32> {
    return vec4(pixels[start], pixels[start + 1u], pixels[start + 2u], pixels[start + 3u]);
}

@fragment fn fill(corner: Corner) -> Filled {
    let start = first(corner.position);
    return Filled(color_from(start), pixels[start + 4u]);
}

@fragment fn fill_color(corner: Corner) -> @location(0) vec4<f32> {
    return color_from(first(corner.position));
}

@fragment fn fill_depth(corner: Corner) -> @builtin(frag_depth) f32 {
    return pixels[first(corner.position) + 4u];
}

fn texel(uv: vec2<f32>) -> vec4<f32> {
    let size = vec2<i32>(textureDimensions(source));
    return textureLoad(source, clamp(vec2<i32>(uv * vec2<f32>(size)), vec2(0), size - 1), 0);
}

@fragment fn copied(corner: Corner) -> @location(0) vec4<f32> {
    return texel(corner.uv);
}

@fragment fn flipped(corner: Corner) -> @location(0) vec4<f32> {
    return texel(vec2(corner.uv.x, 1.0 - corner.uv.y));
}
