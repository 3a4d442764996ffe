// Points to the cells that they lie in: each becomes the head of a list, in a block of three tiers each.

@group(0) @binding(1) var<storage, read_write> light_cells: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read_write> points: array<vec4u>;

// The slot of a block, taken for it if it has none; NO_SLOT where there is no room.
fn find_or_take(place: vec2u) -> u32 {
    let h = block_hash(place, params.slots);
    var free = NO_SLOT;
    for (var i = 0u; i < BUCKET; i++) {
        let key = atomicLoad(&light_cells[key_word(slot_of(h, i))]);
        if (key == h.key) {
            return slot_of(h, i);
        }
        if (key <= GIVEN_UP && free == NO_SLOT) {
            free = i;
        }
        if (key == NEVER_TAKEN) {
            break;
        }
    }
    // Slots are taken in their order, and given up between frames alone: whoever else takes one for the same block meets
    // this one first.
    for (var i = free; i < BUCKET; i++) {
        let slot = slot_of(h, i);
        var key = atomicLoad(&light_cells[key_word(slot)]);
        // It fails for no reason at times, and is tried again: else the next slot would be taken for the same block.
        while (key <= GIVEN_UP) {
            let tried = atomicCompareExchangeWeak(&light_cells[key_word(slot)], key, h.key);
            if (tried.exchanged) {
                let words = block_word(params.slots, slot) + BLOCK_PLACE;
                atomicStore(&light_cells[words], place.x);
                atomicStore(&light_cells[words + 1u], place.y);
                return slot;
            }
            key = tried.old_value;
        }
        if (key == h.key) {
            return slot;
        }
    }
    return NO_SLOT;
}

@compute @workgroup_size(64)
fn light_insert(@builtin(global_invocation_id) id: vec3u) {
    let index = id.y * ROW + id.x;
    if (index >= min(points[0].x, params.points)) {
        return;
    }
    let record = 2u + 2u * index;
    let place = points[record].xy;
    let voxel = place_coordinates(place);
    var next = vec3u(0u);
    let chance = f32(pcg4d(vec4u(index, params.frame, place)).x >> 8u) * 0x1p-24f;
    for (var i = 0u; i < 3u; i++) {
        let tier = place_tier(place) + i;
        // Coarse cells see many: a part of them will do.
        let share = select(select(params.coarsest_share, params.coarse_share, i == 1u), 1.0, i == 0u);
        if (tier > LAST_TIER || chance >= share) {
            break;
        }
        let cell = voxel >> vec3u(tier_shift(tier));
        let slot = find_or_take(place_of(cell >> vec3u(1u), place_volume(place), tier));
        if (slot != NO_SLOT) {
            atomicStore(&light_cells[stamp_word(params.slots, slot)], params.frame);
            let head = block_word(params.slots, slot) + cell_in_block(cell);
            let before = atomicExchange(&light_cells[head], index + 1u);
            // A vector's component by a number that is not known beforehand is beyond Godot 4.6's SPIR-V optimiser.
            next = vec3u(select(next.x, before, i == 0u), select(next.y, before, i == 1u), select(next.z, before, i == 2u));
        }
    }
    points[record + 1u] = vec4u(points[record + 1u].x, next);
}
