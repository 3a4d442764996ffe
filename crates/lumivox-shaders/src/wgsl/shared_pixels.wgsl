// Several invocations may share the samples of a pixel: where there are few pixels, one each keeps no large GPU busy, and
// what takes longest is one invocation's paths. Where there are many, the other way, `unshared_pixels.wgsl`, is 5 to 9%
// faster. Expects `frame`.

var<workgroup> shared_sums: array<array<vec4f, 2>, WORKGROUP_X * WORKGROUP_Y>;

// Invocations in a row that share a pixel: a power of two, WORKGROUP_X at most.
fn sharers() -> u32 {
    return frame.sharers;
}

// The sums of all that share a pixel, for the first of them. Every invocation of the workgroup has to call it.
fn gather(own: Sums, local_index: u32) -> Sums {
    shared_sums[local_index] = array(own.light, own.moments);
    workgroupBarrier();
    var all = own;
    for (var i = 1u; i < frame.sharers; i++) {
        // Only the first's result counts; the others must not look beyond the end.
        let other = min(local_index + i, WORKGROUP_X * WORKGROUP_Y - 1u);
        all.light += shared_sums[other][0];
        all.moments += shared_sums[other][1];
    }
    return all;
}
