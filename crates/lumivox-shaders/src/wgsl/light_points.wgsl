// What paths leave behind for the light that is kept (`light_cells.wgsl`): of each that collides a point, with the light that
// the matter there sends on to who sees it. Expects `frame` and `instances`.
//
// Light that is sent on diffusely, by the phase function or by a surface, is told apart from what a surface mirrors: the one is
// nearly the same for all who look, the other is not. Of that it is told what arrives, weighted by the mirror lobe.

//
// A point is there from its collision on, and its record is where it adds up: registers are what path tracers are short of.

struct LightPoints {
    // As many as were begun; those there was no room for are among them.
    count: atomic<u32>,
    padding: array<u32, 7>,
    // Two entries each: (place, light sent on diffusely, its colour), (what arrives for the mirror lobe or NO_MIRROR, the next
    // point of three lists). Until a path has ended: (place, of light from the way on what is sent on diffusely, colour), (what
    // arrived for the mirror lobe at the collision, how much the mirror lobe makes of light from the way on, light sent on
    // diffusely at the collision, 0).
    records: array<vec4u>,
}

@group(0) @binding(POINTS_BINDING) var<storage, read_write> points: LightPoints;

struct PathPoint {
    // Of its first entry, or NO_POINT.
    record: u32,
}

const NO_POINT: u32 = 0xffffffffu;

// Of a point that was taken back, for its path was put aside.
const NOWHERE: vec2u = vec2u(0xffffffffu);

fn point_none() -> PathPoint {
    return PathPoint(NO_POINT);
}

// Room for one more.
fn point_new(first: vec4u, second: vec4u) -> PathPoint {
    let record = 2u * atomicAdd(&points.count, 1u);
    if (record + 1u >= arrayLength(&points.records)) {
        return point_none();
    }
    points.records[record] = first;
    points.records[record + 1u] = second;
    return PathPoint(record);
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
    if (v >= MOST_LIT_VOLUMES || f32(rng.key.y >> 8u) * 0x1p-24f >= frame.point_share) {
        return false;
    }
    let voxel = clamp(voxel_from_world(v, position), vec3f(0.0), instances[v].dims - 1.0);
    let place = place_of(vec3u(voxel * CELLS_PER_VOXEL), v, tier_seen(v, depth));
    let mirrors = SURFACE && event.phase < 1.0;
    (*path).point = point_new(
        vec4u(place, 0u, pack_rgb(diffuse_color(event))), vec4u(select(NO_MIRROR, 0u, mirrors), 0u, 0u, 0u));
    return (*path).point.record != NO_POINT;
}

// Light that arrives at the collision from a direction.
fn point_sent(point: PathPoint, event: Event, direction: vec3f, light: vec3f) {
    let shares = light_shares(event, direction);
    let scaled = frame.light_scale * light;
    let second = points.records[point.record + 1u];
    points.records[point.record + 1u].z = pack_rgb(unpack_rgb(second.z) + shares.diffuse * scaled);
    if (second.x != NO_MIRROR) {
        points.records[point.record + 1u].x = pack_rgb(unpack_rgb(second.x) + shares.mirror * scaled);
    }
}

// The way on from the collision.
fn point_onward(point: PathPoint, event: Event, direction: vec3f) {
    let shares = light_shares(event, direction);
    points.records[point.record].z = pack_rgb(shares.diffuse);
    points.records[point.record + 1u].y = pack_rgb(shares.mirror);
}

// The path has ended, with so much light from the way on.
fn point_end(point: PathPoint, light: vec3f) {
    if (point.record == NO_POINT) {
        return;
    }
    let scaled = frame.light_scale * light;
    let of_way = points.records[point.record].z;
    let second = points.records[point.record + 1u];
    points.records[point.record].z = pack_rgb(unpack_rgb(second.z) + unpack_rgb(of_way) * scaled);
    var mirror = NO_MIRROR;
    if (second.x != NO_MIRROR) {
        mirror = pack_rgb(unpack_rgb(second.x) + unpack_rgb(second.y) * scaled);
    }
    points.records[point.record + 1u] = vec4u(mirror, 0u, 0u, 0u);
}

// Takes a point back, for its path will be gone on with later: two rows of words that are put aside with it. Of what the
// path did since it was `remembered`, nothing counts.
fn point_put_aside(point: PathPoint, remembered: PathPoint) -> array<vec4u, 2> {
    var words = array<vec4u, 2>(vec4u(NOWHERE, 0u, 0u), vec4u(0u));
    if (remembered.record != NO_POINT) {
        words = array<vec4u, 2>(points.records[remembered.record], points.records[remembered.record + 1u]);
    }
    if (point.record != NO_POINT) {
        points.records[point.record] = vec4u(NOWHERE, 0u, 0u);
    }
    return words;
}

fn point_taken_up(first: vec4u, second: vec4u) -> PathPoint {
    if (all(first.xy == NOWHERE)) {
        return point_none();
    }
    return point_new(first, second);
}
