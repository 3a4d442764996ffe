// A picture from the light that is kept in volumes: rays are marched, and what the medium sends on is looked up.
//
// Through one volume in small steps, which has no noise (`light_steps.wgsl`). Where there are several, that may overlap: by a
// few first collisions of a pixel, which any number of volumes has (`light_collisions.wgsl`). A kernel for each: for one
// that does both, Microsoft's FXC takes half as long again as for the two, and much longer where media are classified.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
@group(0) @binding(2) var<storage, read> tables: array<vec2u>;
@group(0) @binding(3) var<storage, read> grids: array<Cell>;
@group(0) @binding(4) var linear_sampler: sampler;
@group(0) @binding(5) var<storage, read> light_cells: array<u32>;
// Of which it is asked where rays end.
@group(0) @binding(6) var<storage, read> film: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> picture: array<vec4u>;

fn light_slots() -> u32 {
    return frame.light_slots;
}

fn take_turn() -> bool {
    return true;
}

struct Seen {
    light: vec3f,
    alpha: f32,
    // Times alpha, these three.
    depth: f32,
    color: vec3f,
    sureness: f32,
}

fn seen_times(x: f32, seen: Seen) -> Seen {
    return Seen(x * seen.light, x * seen.alpha, x * seen.depth, x * seen.color, x * seen.sureness);
}

// What is sent on, in which colour, and of how many points that is known.
struct Sent {
    light: vec3f,
    color: vec3f,
    sureness: f32,
}

// What is sent on towards the eye at a point of a volume that was read.
fn sent_light(v: u32, position: vec3f, direction: vec3f, reading: Reading) -> Sent {
    let event = event_at(v, optics_at(v, position, reading, false), reading, -direction);
    let depth = dot(position - frame.camera_position, frame.view_axis);
    let kept = kept_light_at(instances[v].light_number, voxel_from_world(v, position), tier_seen(v, depth));
    let diffuse = diffuse_color(event);
    let mirror = mirror_tint(event);
    return Sent(diffuse * kept.ratio + mirror * kept.mirror, diffuse + mirror, kept.sureness);
}

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn light_march(@builtin(global_invocation_id) id: vec3u) {
    // Software Vulkan (Mesa 26 with LLVM 21) loses the address of a buffer that it first meets in a loop whose invocations go different
    // ways, and crashes: it meets this one here. No count of slots is so large.
    let counted = light_cells[0];
    let at = frame.march_first + frame.march_stride * id.xy;
    if (any(at >= frame.film_size)) {
        return;
    }
    if (counted == NO_SLOT) {
        return;
    }
    let plane = frame.film_size.x * frame.film_size.y;
    let index = at.y * frame.film_size.x + at.x;
    let end = film[ray_limit_entry(plane, index)][index % 4u];
    let seen = see(at, end);
    let tint = encode_tint(seen.color, seen.alpha);
    let ratio = pack_rgb(seen.light / tint_of(tint).rgb);
    let whole = 1.0 / max(seen.alpha, 1e-6);
    picture[index] = vec4u(ratio, 0u, 0u, bitcast<u32>(whole * seen.sureness));
    picture[plane + index] = vec4u(ratio, bitcast<u32>(end), tint, bitcast<u32>(whole * seen.depth));
}
