// What cells learn of the points that fell into them: means over all of them, older ones included.

@group(0) @binding(1) var<storage, read_write> light_cells: array<u32>;
@group(0) @binding(2) var<storage, read> points: array<vec4u>;

// Of so many that fell into a cell in a frame the first are enough.
const MOST_LOOKED_AT: u32 = 256u;

fn chances(slot: u32, what: u32) -> vec3f {
    return vec3f(pcg4d(vec4u(slot, what, params.frame, 0u)).xyz >> vec3u(8u)) * 0x1p-24f;
}

// Of each cell of a workgroup: light that arrives for the mirror lobe, and points that say so; light, and points; colour.
var<workgroup> mirrored: array<vec4f, 64>;
var<workgroup> lights: array<vec4f, 64>;
var<workgroup> colors: array<vec3f, 64>;

// What a cell learns: all of it, and what its points say of the mirror lobe.
struct Lesson {
    mirror: vec4f,
    light: vec4f,
    color: vec3f,
}

fn learn(slot: u32, cell: u32) -> Lesson {
    let words = block_word(params.slots, slot);
    let tier = place_tier(vec2u(0u, light_cells[words + BLOCK_PLACE + 1u]));
    let means = words + BLOCK_MEANS + 3u * cell;
    let before = bitcast<f32>(light_cells[means + 2u]);
    var count = min(before * params.kept, params.most_points);
    var mirror = vec4f(0.0);
    var next = light_cells[words + cell];
    var light = count * params.scale * unpack_rgb(light_cells[means]);
    var color = count * unpack_rgb(light_cells[means + 1u]);
    if (next > 0u || (count > 0.0 && params.scale != 1.0)) {
        for (var i = 0u; i < MOST_LOOKED_AT && next > 0u; i++) {
            let first = points[2u * next];
            let second = points[2u * next + 1u];
            light += unpack_rgb(first.z);
            color += unpack_rgb(first.w);
            count += 1.0;
            if (second.x != NO_MIRROR) {
                mirror += vec4f(unpack_rgb(second.x), 1.0);
            }
            let list = tier - place_tier(first.xy);
            next = select(select(second.w, second.z, list == 1u), second.y, list == 0u);
        }
        // For the points that come next.
        light_cells[words + cell] = 0u;
        light_cells[means] = pack_rgb_by_chance(light / count, chances(slot, cell));
        light_cells[means + 1u] = pack_rgb_by_chance(color / count, chances(slot, 8u + cell));
    }
    if (count != before) {
        light_cells[means + 2u] = bitcast<u32>(count);
    }
    return Lesson(mirror, vec4f(light, count), color);
}

// One invocation a cell.
@compute @workgroup_size(64)
fn light_gather(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local_index: u32) {
    let slot = (id.y * ROW + id.x) / 8u;
    let cell = id.x % 8u;
    var is_taken = false;
    if (slot < params.slots) {
        is_taken = light_cells[key_word(slot)] > GIVEN_UP;
    }
    var lesson = Lesson();
    if (is_taken) {
        lesson = learn(slot, cell);
    }
    mirrored[local_index] = lesson.mirror;
    lights[local_index] = lesson.light;
    colors[local_index] = lesson.color;
    workgroupBarrier();
    if (!is_taken || cell > 0u) {
        return;
    }
    // The first of a block's tells for all of it.
    let words = block_word(params.slots, slot);
    let at = words + BLOCK_MIRROR;
    let before = min(bitcast<f32>(light_cells[at + 1u]) * params.kept, params.most_mirrored);
    var sum = before * vec4f(params.scale * unpack_rgb(light_cells[at]), 1.0);
    var light = vec4f(0.0);
    var color = vec3f(0.0);
    for (var i = 0u; i < 8u; i++) {
        sum += mirrored[local_index + i];
        light += lights[local_index + i];
        color += colors[local_index + i];
    }
    let inverse = 1.0 / max(light.a, 1e-6);
    light_cells[words + BLOCK_TOGETHER] = pack_rgb_by_chance(inverse * light.rgb, chances(slot, 17u));
    light_cells[words + BLOCK_TOGETHER + 1u] = pack_rgb_by_chance(inverse * color, chances(slot, 18u));
    light_cells[words + BLOCK_TOGETHER + 2u] = bitcast<u32>(light.a);
    light_cells[at] = pack_rgb_by_chance(sum.rgb / max(sum.a, 1e-6), chances(slot, 16u));
    light_cells[at + 1u] = bitcast<u32>(sum.a);
}
