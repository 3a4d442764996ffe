// Light that is kept in volumes, where primary rays collide: what the matter there sends on.
//
// Space is a volume's own, in voxels. A cell of tier t has a side of 4^t voxels; a block is two cells along each axis and what
// is known of them together, so that every tier knows two sizes. Blocks are found by a hash of their place: of BUCKET slots
// that it may be in, each holds 32 bits of another hash of it, the key, or NEVER_TAKEN or GIVEN_UP. They are looked through from one on that the hash says, and not
// beyond one that was never taken.
//
// The buffer, in words: a header, of which the first three hold how many slots are taken, in turns, and the last 128 a bit for
// the number of each volume that is gone; the keys; the frames in which
// blocks were last filled; the blocks. A block, in words:
//   0-7    its cells as they are read (`encode_light`); while a frame's points are sorted in, the first of a list of them
//   8-31   what its cells have learnt, three words each: the mean light sent on, the mean of its colour, and of how many points
//   32-33  the mean light that arrives for the mirror lobe, of all its cells, and of how many points
//   34     the same as it is read
//   35-36  where it is (`place_of`)
//   37-39  as of a cell, of all its cells together

const LIGHT_HEADER: u32 = 144u;
const LIGHT_GONE: u32 = 16u;
const BUCKET: u32 = 16u;
const BLOCK_WORDS: u32 = 40u;
const BLOCK_MEANS: u32 = 8u;
const BLOCK_MIRROR: u32 = 32u;
const BLOCK_MIRROR_READ: u32 = 34u;
const BLOCK_PLACE: u32 = 35u;
const BLOCK_TOGETHER: u32 = 37u;
const NO_SLOT: u32 = 0xffffffffu;
// Keys of slots without a block.
const NEVER_TAKEN: u32 = 0u;
const GIVEN_UP: u32 = 1u;

// Cells along a voxel, of the finest tier: light in dense matter changes within a voxel.
const CELLS_PER_VOXEL: f32 = 1.0;

// No finer and no coarser cells than these.
const LAST_TIER: u32 = 4u;

fn key_word(slot: u32) -> u32 {
    return LIGHT_HEADER + slot;
}

fn stamp_word(slots: u32, slot: u32) -> u32 {
    return LIGHT_HEADER + slots + slot;
}

fn block_word(slots: u32, slot: u32) -> u32 {
    return LIGHT_HEADER + 2u * slots + slot * BLOCK_WORDS;
}

// Where a voxel is, of which volume by its number, and the finest tier that it is of interest in.
fn place_of(voxel: vec3u, v: u32, tier: u32) -> vec2u {
    return vec2u(voxel.x | (voxel.y << 16u), voxel.z | (v << 16u) | (tier << 28u));
}

fn place_coordinates(place: vec2u) -> vec3u {
    return vec3u(place.x & 0xffffu, place.x >> 16u, place.y & 0xffffu);
}

fn place_volume(place: vec2u) -> u32 {
    return (place.y >> 16u) & 0xfffu;
}

fn place_tier(place: vec2u) -> u32 {
    return place.y >> 28u;
}

// Where a block may be: the first slot of its bucket, its key, and the slot that is looked at first.
struct BlockHash {
    bucket: u32,
    key: u32,
    first: u32,
}

fn block_hash(place: vec2u, slots: u32) -> BlockHash {
    let h = pcg4d(vec4u(place, 0x68bc21ebu, 0x02e5be93u));
    return BlockHash(h.x % (slots / BUCKET) * BUCKET, max(h.y, GIVEN_UP + 1u), h.z);
}

fn slot_of(h: BlockHash, i: u32) -> u32 {
    return h.bucket + (h.first + i) % BUCKET;
}

// A point tells no mirror lobe's light, for there was none.
const NO_MIRROR: u32 = 0xffffffffu;

// Side of a tier's cells, in voxels, as a power of two.
fn tier_shift(tier: u32) -> u32 {
    return 2u * tier;
}

// The tier whose cells are as large as what a pixel sees of a volume, in voxels.
fn tier_of_footprint(voxels: f32) -> u32 {
    let cells = voxels * CELLS_PER_VOXEL;
    return u32(cells > 2.0) + u32(cells > 8.0);
}

// Red, green and blue with a common exponent (as OpenGL's EXT_texture_shared_exponent has it): 9 bits each.
fn pack_rgb(color: vec3f) -> u32 {
    return pack_rgb_by_chance(color, vec3f(0.5));
}

// The same, rounded up or down by chance: means that are rounded to the nearest stand still.
fn pack_rgb_by_chance(color: vec3f, chances: vec3f) -> u32 {
    let c = clamp(color, vec3f(0.0), vec3f(65408.0));
    let most = max(max(c.r, c.g), max(c.b, 1.6e-5));
    // One more than the exponent of the largest; of its bits, for drivers round log2 as they like. A mantissa that rounds
    // up to 512 takes the next one.
    var exponent = i32((bitcast<u32>(most) >> 23u) & 0xffu) - 126;
    if (most * exp2(f32(9 - exponent)) >= 511.0) {
        exponent += 1;
    }
    let m = vec3u(c * exp2(f32(9 - exponent)) + chances);
    return m.r | (m.g << 9u) | (m.b << 18u) | (u32(exponent + 15) << 27u);
}

fn unpack_rgb(word: u32) -> vec3f {
    let m = vec3u(word, word >> 9u, word >> 18u) & vec3u(0x1ffu);
    return vec3f(m) * exp2(f32(i32(word >> 27u) - 24));
}

// What is read of a cell: light over colour, in 8 bits each with a common exponent of five, and how sure that is, in eighths.
fn encode_light(ratio: vec3f, points: f32) -> u32 {
    let word = pack_rgb(ratio);
    let m = min((vec3u(word, word >> 9u, word >> 18u) & vec3u(0x1ffu)) + 1u, vec3u(511u)) >> vec3u(1u);
    let sure = u32(points > 0.0) + u32(points > 1.0) + u32(points > 2.0) + u32(points > 4.0) + u32(points > 8.0)
        + u32(points > 16.0) + u32(points > 32.0);
    return m.r | (m.g << 8u) | (m.b << 16u) | ((word >> 27u) << 24u) | (sure << 29u);
}

fn light_ratio(word: u32) -> vec3f {
    let m = vec3u(word, word >> 8u, word >> 16u) & vec3u(0xffu);
    return vec3f(m) * exp2(f32(i32((word >> 24u) & 0x1fu) - 23));
}

// By how much a cell counts beside its neighbours: hardly less where no point fell, for what is read of it is then what is known
// of the cells around it. By its points it must not be: brighter cells have more of them.
fn light_weight(word: u32) -> f32 {
    return select(0.3, 1.0, (word >> 29u) > 0u);
}

// How many points a cell has, as a power of two: 0 for none, 1 for one, 7 for more than 32.
fn light_sureness(word: u32) -> f32 {
    return f32(word >> 29u);
}

// Light over colour, as one number.
fn brightness(light: vec3f, color: vec3f) -> f32 {
    let weights = vec3f(0.2126, 0.7152, 0.0722);
    return dot(weights, light) / max(dot(weights, color), 1e-6);
}

// The place of a cell in its block.
fn cell_in_block(cell: vec3u) -> u32 {
    return (cell.x & 1u) | ((cell.y & 1u) << 1u) | ((cell.z & 1u) << 2u);
}
