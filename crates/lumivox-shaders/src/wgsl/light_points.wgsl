// What paths leave behind for the light that is kept (`light_cells.wgsl`): of each that collides a point, with the light that
// the matter there sends on to who sees it. Expects `frame` and `instances`.
//
// Light that is sent on diffusely, by the phase function or by a surface, is told apart from what a surface mirrors: the one is
// nearly the same for all who look, the other is not. Of that it is told what arrives, weighted by the mirror lobe.

struct LightPoints {
    // As many as were left; those there was no room for are among them.
    count: atomic<u32>,
    // For how many there is room. (The buffer's length tells that, too, but not every host's compiler takes the question.)
    capacity: u32,
    padding: array<u32, 6>,
    // Two entries each: (place, light sent on diffusely, its colour), (what arrives for the mirror lobe or NO_MIRROR, the next
    // point of three lists).
    records: array<vec4u>,
}

@group(0) @binding(POINTS_BINDING) var<storage, read_write> points: LightPoints;

struct PathPoint {
    place: vec2u,
    color: u32,
    // Of light that arrived at the collision: what is sent on diffusely, and what arrived for the mirror lobe or NO_MIRROR.
    diffuse: u32,
    mirror: u32,
    // The same of light from the way on, as a share of it.
    diffuse_share: u32,
    mirror_share: u32,
}

// Of a path that has met nothing that light is kept of.
const NOWHERE: vec2u = vec2u(0xffffffffu);

fn point_none() -> PathPoint {
    var point = PathPoint();
    point.place = NOWHERE;
    point.mirror = NO_MIRROR;
    return point;
}

// Of all that is sent on from a direction: x the density of what is diffuse, y that of the mirror lobe by itself.
fn lobes_of(event: Event, direction: vec3f) -> vec2f {
    let phase = henyey_greenstein(dot(event.onward, direction), event.anisotropy);
    if (SURFACE && event.phase < 1.0) {
        let cosine = max(dot(event.normal, direction), 0.0);
        let diffuse = event.phase * phase + event_diffuse(event) * cosine / PI;
        return vec2f(diffuse, henyey_greenstein(dot(event.mirror, direction), event.lobe_anisotropy));
    }
    return vec2f(phase, 0.0);
}

struct LightShares {
    diffuse: vec3f,
    mirror: vec3f,
}

fn light_shares(event: Event, direction: vec3f) -> LightShares {
    let lobes = lobes_of(event, direction);
    let diffuse = event.albedo * lobes.x;
    let all = max(diffuse + mirror_tint(event) * lobes.y, vec3f(1e-20));
    return LightShares(diffuse / all, vec3f(lobes.y) / all);
}

// The point of a path's first collision. Returns whether there is one: a path without has nothing to tell.
fn point_begin(path: ptr<function, Path>, v: u32, position: vec3f, depth: f32, event: Event, rng: Rng) -> bool {
    // By a part of the path's key, which says nothing of where it goes.
    if (f32(rng.key.y >> 8u) * 0x1p-24f >= frame.point_share) {
        return false;
    }
    let voxel = clamp(voxel_from_world(v, position), vec3f(0.0), instances[v].dims - 1.0);
    let number = instances[v].light_number;
    (*path).point.place = place_of(vec3u(voxel * CELLS_PER_VOXEL), number, tier_seen(v, depth));
    (*path).point.color = pack_rgb(diffuse_color(event));
    if (SURFACE && event.phase < 1.0) {
        (*path).point.mirror = 0u;
    }
    return true;
}

// Light that arrives at the first collision from a direction.
fn point_sent(path: ptr<function, Path>, event: Event, direction: vec3f, light: vec3f) {
    let shares = light_shares(event, direction);
    let scaled = frame.light_scale * light;
    (*path).point.diffuse = pack_rgb(unpack_rgb((*path).point.diffuse) + shares.diffuse * scaled);
    if ((*path).point.mirror != NO_MIRROR) {
        (*path).point.mirror = pack_rgb(unpack_rgb((*path).point.mirror) + shares.mirror * scaled);
    }
}

// The way on from the first collision.
fn point_onward(path: ptr<function, Path>, event: Event, direction: vec3f) {
    let shares = light_shares(event, direction);
    (*path).point.diffuse_share = pack_rgb(shares.diffuse);
    (*path).point.mirror_share = pack_rgb(shares.mirror);
}

// The path has ended.
fn point_end(path: Path) {
    let point = path.point;
    if (all(point.place == NOWHERE)) {
        return;
    }
    let index = atomicAdd(&points.count, 1u);
    if (index >= points.capacity) {
        return;
    }
    let later = frame.light_scale * path.radiance;
    var mirror = NO_MIRROR;
    if (point.mirror != NO_MIRROR) {
        mirror = pack_rgb(unpack_rgb(point.mirror) + unpack_rgb(point.mirror_share) * later);
    }
    let diffuse = unpack_rgb(point.diffuse) + unpack_rgb(point.diffuse_share) * later;
    points.records[2u * index] = vec4u(point.place, pack_rgb(diffuse), point.color);
    points.records[2u * index + 1u] = vec4u(mirror, 0u, 0u, 0u);
}

// The point as it is put aside with its path.
fn point_words(point: PathPoint, row: u32) -> vec4u {
    switch row {
        case 0u: { return vec4u(point.place, point.color, point.diffuse); }
        default: { return vec4u(point.mirror, point.diffuse_share, point.mirror_share, 0u); }
    }
}

fn point_of_words(first: vec4u, second: vec4u) -> PathPoint {
    return PathPoint(first.xy, first.z, first.w, second.x, second.y, second.z);
}
