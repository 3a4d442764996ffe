// The colour of a live film, premultiplied.

// Only loaded from where `has_host_depth` says that it is one.
@group(0) @binding(7) var host_depth_map: texture_2d<f32>;

// The largest that a half float holds is 65504.
const BRIGHTEST: f32 = 65000.0;

@fragment
fn composite_color(@builtin(position) position: vec4f) -> @location(0) vec4f {
    var limit = 0.0;
    if (params.has_host_depth != 0u) {
        let ndc = textureLoad(host_depth_map, vec2i(position.xy), 0).r;
        limit = view_depth_from_ndc(ndc, params.view_depth_from_ndc, params.clear);
    }
    let uv = position.xy / params.target_size;
    let e = picture(uv, limit);
    if (e.alpha <= 0.0) {
        discard;
    }
    let light = fogged(e.light * params.exposure, e.alpha, uv, e.depth);
    return vec4f(min(light, vec3f(BRIGHTEST)), e.alpha);
}
