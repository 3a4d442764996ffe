// A frame of points begins: blocks that were not met for long, or whose volume is gone, make room, and lists of points are empty.

@group(0) @binding(1) var<storage, read_write> light_cells: array<atomic<u32>>;

// Frames after which a block that no point fell into is given up, by how full the slots are.
fn longest_rest(taken: u32) -> u32 {
    let full = f32(taken) / f32(params.slots);
    if (full > 0.9) {
        return 8u;
    }
    return select(select(600u, 120u, full > 0.6), 30u, full > 0.75);
}

@compute @workgroup_size(64)
fn light_begin(@builtin(global_invocation_id) id: vec3u) {
    let slot = id.x;
    // Three counts take turns: one is of the frame before, one of this, one is emptied for the next.
    if (slot == 0u) {
        atomicStore(&light_cells[(params.frame + 1u) % 3u], 0u);
    }
    if (slot >= params.slots || atomicLoad(&light_cells[key_word(slot)]) <= GIVEN_UP) {
        return;
    }
    let rest = params.frame - atomicLoad(&light_cells[stamp_word(params.slots, slot)]);
    let words = block_word(params.slots, slot);
    var gone = rest > longest_rest(atomicLoad(&light_cells[(params.frame + 2u) % 3u]));
    if (params.forgets != 0u) {
        let v = place_volume(vec2u(0u, atomicLoad(&light_cells[words + BLOCK_PLACE + 1u])));
        gone |= ((atomicLoad(&light_cells[LIGHT_GONE + v / 32u]) >> (v % 32u)) & 1u) != 0u;
    }
    for (var i = 0u; i < select(BLOCK_MEANS, BLOCK_WORDS, gone); i++) {
        atomicStore(&light_cells[words + i], 0u);
    }
    if (gone) {
        atomicStore(&light_cells[key_word(slot)], GIVEN_UP);
    } else {
        atomicAdd(&light_cells[params.frame % 3u], 1u);
    }
}
