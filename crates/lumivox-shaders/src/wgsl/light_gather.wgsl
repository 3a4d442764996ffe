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

// What a frame's points say of a cell: of the mirror lobe, and how many do; of light, and how many there are; of its colour.
struct Lesson {
    mirror: vec4f,
    light: vec4f,
    color: vec3f,
}

// Takes the cell's list: it is empty for the points that come next.
fn listen(slot: u32, cell: u32) -> Lesson {
    var lesson = Lesson();
    let words = block_word(params.slots, slot);
    let tier = place_tier(vec2u(0u, light_cells[words + BLOCK_PLACE + 1u]));
    var next = light_cells[words + cell];
    if (next > 0u) {
        light_cells[words + cell] = 0u;
    }
    for (var i = 0u; i < MOST_LOOKED_AT && next > 0u; i++) {
        let first = points[2u * next];
        let second = points[2u * next + 1u];
        lesson.light += vec4f(unpack_rgb(first.z), 1.0);
        lesson.color += unpack_rgb(first.w);
        if (second.x != NO_MIRROR) {
            lesson.mirror += vec4f(unpack_rgb(second.x), 1.0);
        }
        let list = tier - place_tier(first.xy);
        next = select(select(second.w, second.z, list == 1u), second.y, list == 0u);
    }
    return lesson;
}

// Points that what a block's cells knew counts for at most. Where light is changing, the fewer the more it is another than what
// the new points say: at the square of what is between them, less what is their own noise, old points are as far from the truth
// as new ones. (As the gain of a Kalman filter. A point's noise is about as large as its light.)
fn most_remembered(words: u32, new_points: Lesson) -> f32 {
    if (params.is_changing == 0u || new_points.light.a <= 0.0) {
        return params.most_points;
    }
    let at = words + BLOCK_TOGETHER;
    let before = params.scale * brightness(unpack_rgb(light_cells[at]), unpack_rgb(light_cells[at + 1u]));
    let now = brightness(new_points.light.rgb, new_points.color);
    let difference = 2.0 * (now - before) / max(now + before, 1e-12);
    let drift = difference * difference - 2.0 / new_points.light.a;
    return min(params.most_points, 1.0 / max(drift, 1e-4));
}

// What a cell knows with its new points.
fn learn(slot: u32, cell: u32, most: f32, lesson: Lesson) -> Lesson {
    let means = block_word(params.slots, slot) + BLOCK_MEANS + 3u * cell;
    let before = bitcast<f32>(light_cells[means + 2u]);
    let kept = min(before * params.kept, most);
    let light = vec4f(kept * params.scale * unpack_rgb(light_cells[means]), kept) + lesson.light;
    let color = kept * unpack_rgb(light_cells[means + 1u]) + lesson.color;
    if (lesson.light.a > 0.0 || (kept > 0.0 && params.scale != 1.0)) {
        light_cells[means] = pack_rgb_by_chance(light.rgb / light.a, chances(slot, cell));
        light_cells[means + 1u] = pack_rgb_by_chance(color / light.a, chances(slot, 8u + cell));
    }
    if (light.a != before) {
        light_cells[means + 2u] = bitcast<u32>(light.a);
    }
    return Lesson(lesson.mirror, light, color);
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
        lesson = listen(slot, cell);
    }
    lights[local_index] = lesson.light;
    colors[local_index] = lesson.color;
    workgroupBarrier();
    let block = local_index - cell;
    var together = Lesson();
    for (var i = 0u; i < 8u; i++) {
        together.light += lights[block + i];
        together.color += colors[block + i];
    }
    workgroupBarrier();
    if (is_taken) {
        lesson = learn(slot, cell, most_remembered(block_word(params.slots, slot), together), lesson);
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
