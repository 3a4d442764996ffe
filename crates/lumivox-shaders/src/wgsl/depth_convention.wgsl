// From the host's depth buffer to distances along the view; 0 stands for nothing there, or nothing that ends a ray: what
// lies farther than all volumes is as good as none.

fn view_depth_from_ndc(ndc: f32, map: vec4f, clear: f32, farthest: f32) -> f32 {
    if (ndc == clear) {
        return 0.0;
    }
    let depth = (map.x * ndc + map.y) / (map.z * ndc + map.w);
    return select(0.0, depth, depth > 0.0 && depth < farthest);
}
