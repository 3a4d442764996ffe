// Reading the light that is kept in volumes. Expects `light_cells` and `light_slots`.

struct KeptLight {
    // Light that is sent on diffusely, over its colour; what arrives for the mirror lobe.
    ratio: vec3f,
    mirror: vec3f,
    is_known: bool,
    // Points of the cells that tell it, as `light_sureness` counts them.
    sureness: f32,
}

// The slot of a block, or NO_SLOT.
fn find_block(place: vec2u) -> u32 {
    let h = block_hash(place, light_slots());
    for (var i = 0u; i < BUCKET; i++) {
        let slot = slot_of(h, i);
        let key = light_cells[key_word(slot)];
        if (key == h.key) {
            return slot;
        }
        if (key == NEVER_TAKEN) {
            break;
        }
    }
    return NO_SLOT;
}

// The one after it in a box, x first; beyond the last along z where there is none.
fn next_in_box(at: vec3u, low: vec3u, high: vec3u) -> vec3u {
    if (at.x < high.x) {
        return vec3u(at.x + 1u, at.yz);
    }
    if (at.y < high.y) {
        return vec3u(low.x, at.y + 1u, at.z);
    }
    return vec3u(low.xy, at.z + 1u);
}

// At a point of the voxel space of the volume of a number, by the cells of one tier around it: linear between their centres, and each as far as it is sure.
fn light_of_tier(v: u32, p: vec3f, tier: u32) -> KeptLight {
    let shift = tier_shift(tier);
    let q = max(p * (CELLS_PER_VOXEL * exp2(-f32(shift))) - 0.5, vec3f(0.0));
    let base = vec3u(q);
    let f = q - vec3f(base);
    let first = base >> vec3u(1u);
    let last = (base + 1u) >> vec3u(1u);
    var kept = KeptLight();
    var weights = 0.0;
    // One loop over the blocks and one over the cells of each, not three of each: Microsoft's FXC takes long for loops within loops.
    var block = first;
    while (block.z <= last.z) {
        let slot = find_block(place_of(block, v, tier));
        if (slot != NO_SLOT) {
            let words = block_word(light_slots(), slot);
            let low = max(base, 2u * block);
            let high = min(base + 1u, 2u * block + 1u);
            var of_block = 0.0;
            var cell = low;
            while (cell.z <= high.z) {
                let near = choose(1.0 - f, f, cell > base);
                let word = light_cells[words + cell_in_block(cell)];
                let weight = near.x * near.y * near.z * light_weight(word);
                kept.ratio += weight * light_ratio(word);
                kept.sureness += weight * light_sureness(word);
                of_block += weight;
                cell = next_in_box(cell, low, high);
            }
            kept.mirror += of_block * unpack_rgb(light_cells[words + BLOCK_MIRROR_READ]);
            weights += of_block;
        }
        block = next_in_box(block, first, last);
    }
    kept.is_known = weights > 1e-6;
    let inverse = 1.0 / max(weights, 1e-6);
    kept.ratio *= inverse;
    kept.mirror *= inverse;
    kept.sureness *= inverse;
    return kept;
}

// The same by the finest of the tiers from `tier` on that knows any.
fn kept_light_at(v: u32, p: vec3f, tier: u32) -> KeptLight {
    var kept = KeptLight();
    var t = tier;
    while (t <= LAST_TIER && !kept.is_known) {
        kept = light_of_tier(v, p, t);
        t += 1u;
    }
    return kept;
}
