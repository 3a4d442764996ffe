// Media that depend on more than the value: with LABELS on labels with looks of their own, with
// FUNCTIONS on those of several transfer functions, with GRADIENTS on the gradient's
// magnitude, with PEELING on the depth below the skin, with CLIP_SHAPES on shapes that clip. A volume's own table holds the
// largest opacity that its values can have: with SHARES, a share of which is a point's, and without, all of it is. Expects
// `instances` and `tables`. The other way is `plain_media.wgsl`.
//
// What a volume's points are besides their values lies behind the transfer functions, from `instances[v].classes` on, in
// pairs of numbers; whole ones are floats, too, for as bits small integers would be denormal and might be lost:
// - nothing; the instance that is its field of depths, -1 where there is none;
// - what is peeled in mm, and one over the border's width;
// - how many clip shapes there are, and one over the width of the surface that a cut leaves, in 1/mm;
// - where the styles by label begin, and where the clip shapes do;
// - how many of the first clip shapes rays are clipped against as a whole; nothing;
// - the styles that cells name by place, from 1: where there are labels, with room for MOST_CELL_LOOKS;
// - the styles by label, STYLE_PAIRS each: scale and bias of the table's coordinate; the first pair of the function and the
//   factor of its opacity; red and green; blue, and whether the colour counts; strength and inverse gradient of the surface;
//   its lobe's anisotropy and its reflectance; how many rows for gradients come after the first, and where their places
//   are; whether it is clipped, and how much of its colour its mirror has;
// - each clip shape: the rows of the map from voxel space to its own, in six pairs; its kind, and 1 or -1 where it is
//   inverted; nothing;
// - places of rows: the gradient per mm, and one over its distance to the one before.

struct Reading {
    texel: f32,     // stored value in [0, 1]
    style: u32,     // of the label that was drawn: its first pair
    share: f32,     // what its factor and peeling leave of the opacity
    gradient: f32,  // per mm, where the style asks for it
}

// At a point of voxel space in a cell, where the stored value is `texel`. Of labels, one is drawn by their shares: what
// depends on it then is that of their mixture in the mean, which is all that tracking needs. Where the cell's class knows what
// would be drawn, or that nothing is taken off, it is not asked for. `drawn` are random bits, which may have decided about light
// at this point: small ones that it may collide, or how far it came.
fn read_medium(v: u32, p: vec3f, cell: Cell, texel: f32, drawn: u32) -> Reading {
    let classes = instances[v].classes;
    let in_common = cell_class(cell);
    let look = in_common & (CLASS_IS_WHOLE - 1u);
    // Where there are no labels, all points are of the first look.
    var style = classes + CLASS_PAIRS;
    var is_full = instances[v].full_looks > 0u;
    if (LABELS) {
        style += (look - 1u) * STYLE_PAIRS;
        is_full = look - 1u < instances[v].full_looks;
        if (look == 0u) {
            style = style_at(v, p, drawn);
        }
    }
    var share = 1.0;
    if (SHARES && !is_full) {
        share = pair_at(style + 1u).y;
    }
    if (SHARES && (CLIP_SHAPES || PEELING) && in_common < CLASS_IS_WHOLE && share > 0.0) {
        share = what_is_left(classes, p, share, pair_at(style + 7u).x > 0.0);
    }
    var gradient = 0.0;
    if (GRADIENTS && share > 0.0 && pair_at(style + 6u).x > 0.0) {
        gradient = gradient_per_mm(v, voxel_gradient(v, p));
    }
    return Reading(texel, style, share, gradient);
}

// What clip shapes and peeling leave of a share.
fn what_is_left(classes: u32, p: vec3f, share: f32, is_clipped: bool) -> f32 {
    if (CLIP_SHAPES && is_clipped && is_cut_away(classes, p)) {
        return 0.0;
    }
    let depth = pair_at(classes).y;
    if (PEELING && depth >= 0.0) {
        return share * left_of_peeling(u32(depth), pair_at(classes + 1u), p);
    }
    return share;
}

// A label by the shares that a cubic B-spline gives those around: the nearest voxel to a point that is moved by the sum of
// three uniform numbers along each axis. Each number has eight bits. The outer voxels go on beyond the grid for what is in it.
fn style_at(v: u32, p: vec3f, drawn: u32) -> u32 {
    let classes = instances[v].classes;
    let labels = instances[v].labels;
    if (labels == NO_VOLUME) {
        return u32(pair_at(classes + 3u).x);
    }
    let styles = classes + CLASS_PAIRS + MOST_CELL_LOOKS * STYLE_PAIRS;
    // Of three products of the number that decided about light here, for hashes cost more: `tests/drawn_labels.rs` says how
    // evenly these sums are spread.
    let bits = drawn * FIRST_DRAW;
    let moved = three_bytes(bits) + three_bytes(bits * SECOND_DRAW).yzx + three_bytes(bits * THIRD_DRAW).zxy;
    let field = labels & ~LABELS_LIE_ON_VOXELS;
    var here = p;
    if (field == labels) {
        here = voxel_from_world(field, p);
    }
    let dims = instances[field].dims;
    let is_beyond = any(here < vec3f(0.0)) || any(here >= dims);
    // In whole 512ths of a voxel, the last bits of floats from 2^14 to 2^15: cards convert few numbers at a time. Each of the
    // three bytes stands for the middle of its step, and is half a voxel too much.
    let from_corner = bitcast<vec3u>(here + (PLACE_ZERO - 1.5 + 3.0 / 512.0)) + 2u * moved;
    let inside = clamp(from_corner, vec3u(bitcast<u32>(PLACE_ZERO)), bitcast<vec3u>(dims + PLACE_ZERO) - 1u);
    let at = (inside >> vec3u(9u)) & vec3u(0x1fffu);
    let texel = load_voxel(cell_at(field, at), vec3i(at));
    // Likewise, in whole ones.
    let label = bitcast<u32>(texel * instances[field].table_scale + (instances[field].table_bias + 0x1p23f)) & 255u;
    return styles + select(label, 0u, is_beyond) * STYLE_PAIRS;
}

fn three_bytes(bits: u32) -> vec3u {
    return (vec3u(bits) >> vec3u(8u, 16u, 24u)) & vec3u(255u);
}

fn left_of_peeling(field: u32, peel: vec2f, p: vec3f) -> f32 {
    let texel = sample_trilinear(field, voxel_from_world(field, p));
    let depth = texel * instances[field].table_scale + instances[field].table_bias;
    return clamp((depth - peel.x) * peel.y + 0.5, 0.0, 1.0);
}

// Counts the turns of a short loop: a turn counts for three of them, see `limited_turns.wgsl`.
fn take_part_of_turn(i: u32) {
    if (i % 3u == 0u) {
        take_turn();
    }
}

// How far inside of what a clip shape keeps a point is, in units of the shape's own, and how that grows in voxel space.
fn clip_level(shape: u32, p: vec3f) -> vec4f {
    let z = vec4f(pair_at(shape + 4u), pair_at(shape + 5u));
    let kind = u32(pair_at(shape + 6u).x);
    // Of planes the other rows are of no interest, and most shapes are planes.
    if (kind == CLIP_PLANE) {
        return pair_at(shape + 6u).y * vec4f(z.xyz, dot(z, vec4f(p, 1.0)));
    }
    let x = vec4f(pair_at(shape), pair_at(shape + 1u));
    let y = vec4f(pair_at(shape + 2u), pair_at(shape + 3u));
    let q = vec3f(dot(x, vec4f(p, 1.0)), dot(y, vec4f(p, 1.0)), dot(z, vec4f(p, 1.0)));
    var level = q.z;
    var slope = vec3f(0.0, 0.0, 1.0);
    if (kind == CLIP_BOX) {
        let size = abs(q);
        let along_x = size.x >= size.y && size.x >= size.z;
        let along_y = !along_x && size.y >= size.z;
        let along = vec3f(f32(along_x), f32(along_y), f32(!along_x && !along_y));
        level = 1.0 - dot(size, along);
        slope = choose(along, -along, q > vec3f(0.0));
    } else if (kind == CLIP_SPHERE) {
        level = 1.0 - length(q);
        slope = -q / max(length(q), 1e-20);
    }
    return pair_at(shape + 6u).y * vec4f(slope.x * x.xyz + slope.y * y.xyz + slope.z * z.xyz, level);
}

// Whether a shape cuts a point away, of those that rays are not clipped against.
fn is_cut_away(classes: u32, p: vec3f) -> bool {
    let first = u32(pair_at(classes + 3u).y);
    for (var i = u32(pair_at(classes + 4u).x); i < u32(pair_at(classes + 2u).x); i++) {
        take_part_of_turn(i);
        if (clip_level(first + i * SHAPE_PAIRS, p).w < 0.0) {
            return true;
        }
    }
    return false;
}

// The part of a ray in voxel space, from 0 to `t_end`, that is kept by the shapes that keep one part of any ray and cut all
// labels. Nothing of it where the second is not beyond the first.
fn kept_of_ray(v: u32, p: vec3f, direction: vec3f, t_end: f32) -> vec2f {
    let classes = instances[v].classes;
    let first = u32(pair_at(classes + 3u).y);
    var kept = vec2f(0.0, t_end);
    for (var i = 0u; i < u32(pair_at(classes + 4u).x); i++) {
        take_part_of_turn(i);
        let of_shape = kept_by_shape(first + i * SHAPE_PAIRS, p, direction);
        kept = vec2f(max(kept.x, of_shape.x), min(kept.y, of_shape.y));
    }
    return kept;
}

fn kept_by_shape(shape: u32, p: vec3f, direction: vec3f) -> vec2f {
    let z = vec4f(pair_at(shape + 4u), pair_at(shape + 5u));
    let kind = u32(pair_at(shape + 6u).x);
    if (kind == CLIP_PLANE) {
        let slope = dot(z.xyz, direction);
        let along_z = select(slope, 1e-20, abs(slope) < 1e-20);
        let crosses = -dot(z, vec4f(p, 1.0)) * (1.0 / along_z);
        if (along_z > 0.0) {
            return vec2f(crosses, 1e30);
        }
        return vec2f(-1e30, crosses);
    }
    let x = vec4f(pair_at(shape), pair_at(shape + 1u));
    let y = vec4f(pair_at(shape + 2u), pair_at(shape + 3u));
    let q = vec3f(dot(x, vec4f(p, 1.0)), dot(y, vec4f(p, 1.0)), dot(z, vec4f(p, 1.0)));
    let d = vec3f(dot(x.xyz, direction), dot(y.xyz, direction), dot(z.xyz, direction));
    // A component of exactly 0 would turn into 0 * infinity.
    let inverse = 1.0 / choose(d, vec3f(1e-20), abs(d) < vec3f(1e-20));
    if (kind == CLIP_BOX) {
        let a = (-1.0 - q) * inverse;
        let b = (1.0 - q) * inverse;
        let entry = min(a, b);
        let exit = max(a, b);
        return vec2f(max(entry.x, max(entry.y, entry.z)), min(exit.x, min(exit.y, exit.z)));
    }
    // A sphere.
    let along = max(dot(d, d), 1e-30);
    let nearest = -dot(q, d) / along;
    let from_center = q + nearest * d;
    let inside = 1.0 - dot(from_center, from_center);
    if (inside <= 0.0) {
        return vec2f(1.0, 0.0);
    }
    let half_way = sqrt(inside / along);
    return vec2f(nearest - half_way, nearest + half_way);
}

// The surface that the nearest clip shape leaves.
fn cut_surface(v: u32, p: vec3f, reading: Reading) -> Cut {
    let classes = instances[v].classes;
    let count = u32(pair_at(classes + 2u).x);
    let first = u32(pair_at(classes + 3u).y);
    var nearest = 1e30;
    var cut = Cut(0.0, vec3f(0.0));
    if (pair_at(reading.style + 7u).x > 0.0) {
        for (var i = 0u; i < count; i++) {
            take_part_of_turn(i);
            let level = clip_level(first + i * SHAPE_PAIRS, p);
            let per_mm = length(transform_rows(instances[v].patient_gradient_from_voxel, level.xyz));
            let distance = level.w / max(per_mm, 1e-20);
            if (distance < nearest) {
                nearest = distance;
                let widths = distance * pair_at(classes + 2u).y;
                cut = Cut(pair_at(reading.style + 4u).x * exp(-widths * widths), level.xyz);
            }
        }
    }
    return cut;
}

// The row of a function for a gradient, by how many there are and where their places are, and how far it is to the next.
fn gradient_row(rows: vec2f, gradient: f32) -> vec2f {
    var before = 0.0;
    for (var i = 0u; i < u32(rows.x); i++) {
        take_part_of_turn(i);
        let place = pair_at(u32(rows.y) + i);
        if (gradient < place.x) {
            return vec2f(f32(i), (gradient - before) * place.y);
        }
        before = place.x;
    }
    return vec2f(rows.x, 0.0);
}

fn opacity(v: u32, reading: Reading) -> f32 {
    if (reading.share <= 0.0) {
        return 0.0;
    }
    if (!FUNCTIONS) {
        return reading.share * most_opacity(v, reading.texel);
    }
    let coordinate = pair_at(reading.style);
    let function = u32(pair_at(reading.style + 1u).x);
    let address = table_address(coordinate.x, coordinate.y, reading.texel);
    if (!GRADIENTS || pair_at(reading.style + 6u).x <= 0.0) {
        return reading.share * opacity_of(function, address);
    }
    let row = gradient_row(pair_at(reading.style + 6u), reading.gradient);
    let first = function + u32(row.x) * TABLE_PAIRS;
    var of_value = opacity_of(first, address);
    if (row.y > 0.0) {
        of_value = mix(of_value, opacity_of(first + TABLE_PAIRS, address), row.y);
    }
    return reading.share * of_value;
}

// The same, where the largest opacity of the value is known.
fn opacity_within(most: f32, v: u32, reading: Reading) -> f32 {
    if (FUNCTIONS) {
        return opacity(v, reading);
    }
    return reading.share * most;
}

fn color(v: u32, reading: Reading) -> vec3f {
    let own = pair_at(reading.style + 3u);
    if (own.y > 0.0) {
        return vec3f(pair_at(reading.style + 2u), own.x);
    }
    let address = table_address(pair_at(reading.style).x, pair_at(reading.style).y, reading.texel);
    let function = u32(pair_at(reading.style + 1u).x);
    if (!GRADIENTS) {
        return color_of(function, address);
    }
    let row = gradient_row(pair_at(reading.style + 6u), reading.gradient);
    let first = function + u32(row.x) * TABLE_PAIRS;
    let of_value = color_of(first, address);
    if (row.y > 0.0) {
        return mix(of_value, color_of(first + TABLE_PAIRS, address), row.y);
    }
    return of_value;
}

fn surface_strength(v: u32, reading: Reading) -> f32 {
    return pair_at(reading.style + 4u).x;
}

fn surface_inverse_gradient(v: u32, reading: Reading) -> f32 {
    return pair_at(reading.style + 4u).y;
}

fn surface_lobe_anisotropy(v: u32, reading: Reading) -> f32 {
    return pair_at(reading.style + 5u).x;
}

fn surface_specular(v: u32, reading: Reading) -> f32 {
    return pair_at(reading.style + 5u).y;
}

fn surface_metallic(v: u32, reading: Reading) -> f32 {
    return pair_at(reading.style + 7u).y;
}
