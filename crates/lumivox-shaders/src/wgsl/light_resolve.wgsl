// What cells have learnt to what is read of them: each as far as it can be trusted, the rest from the cells around it, twice
// and four times as large. One tier after the other, from the coarsest on.

@group(0) @binding(1) var<storage, read_write> light_cells: array<u32>;

fn light_slots() -> u32 {
    return params.slots;
}

fn trust(points: f32) -> f32 {
    return points / (points + params.trusted_points);
}

// Sums over the points of all cells of a block.
struct Together {
    light: vec3f,
    color: vec3f,
    points: f32,
}

fn together(slot: u32) -> Together {
    let words = block_word(params.slots, slot) + BLOCK_TOGETHER;
    let points = bitcast<f32>(light_cells[words + 2u]);
    return Together(points * unpack_rgb(light_cells[words]), points * unpack_rgb(light_cells[words + 1u]), points);
}

@compute @workgroup_size(64)
fn light_resolve(@builtin(global_invocation_id) id: vec3u) {
    let slot = id.x;
    if (slot >= params.slots || light_cells[key_word(slot)] <= GIVEN_UP) {
        return;
    }
    let words = block_word(params.slots, slot);
    let place = vec2u(light_cells[words + BLOCK_PLACE], light_cells[words + BLOCK_PLACE + 1u]);
    if (place_tier(place) != params.tier) {
        return;
    }
    let own = together(slot);
    var ratio = own.light / max(own.color, vec3f(1e-6));
    let mirrored = bitcast<f32>(light_cells[words + BLOCK_MIRROR + 1u]);
    var mirror = unpack_rgb(light_cells[words + BLOCK_MIRROR]);
    if (params.tier < LAST_TIER) {
        let centre = vec3f((2u * place_coordinates(place) + 1u) << vec3u(tier_shift(params.tier))) / CELLS_PER_VOXEL;
        let around = light_of_tier(place_volume(place), centre, params.tier + 1u);
        if (around.is_known) {
            ratio = mix(around.ratio, ratio, trust(own.points));
            mirror = mix(around.mirror, mirror, trust(mirrored));
        }
    }
    light_cells[words + BLOCK_MIRROR_READ] = pack_rgb(mirror);
    for (var cell = 0u; cell < 8u; cell++) {
        let means = words + BLOCK_MEANS + 3u * cell;
        let count = bitcast<f32>(light_cells[means + 2u]);
        let own = unpack_rgb(light_cells[means]) / max(unpack_rgb(light_cells[means + 1u]), vec3f(1e-6));
        light_cells[words + cell] = encode_light(mix(ratio, own, trust(count)), count);
    }
}
