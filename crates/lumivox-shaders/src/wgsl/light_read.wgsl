// Reading the light that is kept in volumes. Expects `light_cells` and `light_slots`.

struct KeptLight {
    // Light that is sent on diffusely, over its colour; what arrives for the mirror lobe.
    ratio: vec3f,
    mirror: vec3f,
    is_known: bool,
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
    for (var z = first.z; z <= last.z; z++) {
        for (var y = first.y; y <= last.y; y++) {
            for (var x = first.x; x <= last.x; x++) {
                let block = vec3u(x, y, z);
                let slot = find_block(place_of(block, v, tier));
                if (slot == NO_SLOT) {
                    continue;
                }
                let words = block_word(light_slots(), slot);
                let low = max(base, 2u * block);
                let high = min(base + 1u, 2u * block + 1u);
                var of_block = 0.0;
                for (var cz = low.z; cz <= high.z; cz++) {
                    for (var cy = low.y; cy <= high.y; cy++) {
                        for (var cx = low.x; cx <= high.x; cx++) {
                            let cell = vec3u(cx, cy, cz);
                            let near = choose(1.0 - f, f, cell > base);
                            let word = light_cells[words + cell_in_block(cell)];
                            let weight = near.x * near.y * near.z * light_weight(word);
                            kept.ratio += weight * light_ratio(word);
                            of_block += weight;
                        }
                    }
                }
                kept.mirror += of_block * unpack_rgb(light_cells[words + BLOCK_MIRROR_READ]);
                weights += of_block;
            }
        }
    }
    kept.is_known = weights > 1e-6;
    let inverse = 1.0 / max(weights, 1e-6);
    kept.ratio *= inverse;
    kept.mirror *= inverse;
    return kept;
}

// The same by the finest of the tiers from `tier` on that knows any.
fn kept_light_at(v: u32, p: vec3f, tier: u32) -> KeptLight {
    for (var t = tier; t < LAST_TIER; t++) {
        let kept = light_of_tier(v, p, t);
        if (kept.is_known) {
            return kept;
        }
    }
    return light_of_tier(v, p, LAST_TIER);
}
