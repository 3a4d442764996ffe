//! A texture full of bricks: which are taken, and how it moves to a larger one.

use lumivox_shaders::constants::BRICK_TEXELS;

use super::texture_ahead::TextureAhead;
use super::{SPARSE, SPARSE_BYTES, TEXELS};
use crate::recording::{Recording, ResourceId, Step, TextureFormat};

/// One of the textures.
#[derive(Clone, Debug)]
pub(super) struct Pool {
    pub format: TextureFormat,
    /// What kernels read.
    pub texture: ResourceId,
    /// Bricks along each axis of the texture.
    pub texture_size: [u32; 3],
    /// The larger texture that takes its place once all is copied; nothing is written until then.
    pub successor: Option<Successor>,
    /// Bricks along each axis, those of the successor if there is one.
    pub size: [u32; 3],
    /// Which are taken, x fastest.
    pub taken: Vec<bool>,
    pub taken_count: usize,
}

/// The texture of a pool that grows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Successor {
    pub texture: ResourceId,
    /// Layers of texels that are there.
    copied: u32,
}

impl Pool {
    /// In a texture that was made ahead, if one suits.
    pub fn new(
        format: TextureFormat,
        size: [u32; 3],
        ahead: &mut Vec<TextureAhead>,
        recording: &mut Recording,
    ) -> Self {
        let texels = size.map(|n| n * BRICK_TEXELS);
        let made = ahead.iter().position(|ahead| ahead.suits(format, texels));
        let texture = match made.map(|index| ahead.remove(index)) {
            Some(ahead) => ahead.create(recording),
            None => recording.create_texture("voxels", format, texels),
        };
        let taken = vec![false; volume(size)];
        Self { format, texture, texture_size: size, successor: None, size, taken, taken_count: 0 }
    }

    /// Begins to move to a larger texture; pages stay what they are.
    pub fn grow(&mut self, size: [u32; 3], ahead: &mut Vec<TextureAhead>, recording: &mut Recording) {
        let larger = Self::new(self.format, size, ahead, recording);
        let before = self.successor.replace(Successor { texture: larger.texture, copied: 0 });
        recording.free(before.map(|successor| successor.texture));
        self.take_size(size);
    }

    /// Changes the bricks that there are; those that are taken stay.
    pub fn take_size(&mut self, size: [u32; 3]) {
        let places: Vec<[u32; 3]> =
            (0..self.capacity()).filter(|index| self.taken[*index]).map(|index| self.place(index)).collect();
        self.size = size;
        self.taken = vec![false; volume(size)];
        for place in places {
            let index = self.index(place);
            self.taken[index] = true;
        }
    }

    /// Copies what fits into the budget, a layer at least; moves once all is copied.
    pub fn move_on(&mut self, budget: &mut u64, recording: &mut Recording) {
        let Some(successor) = &mut self.successor else { return };
        let [width, height, depth] = self.texture_size.map(|n| n * BRICK_TEXELS);
        let layer = u64::from(width) * u64::from(height) * self.format.bytes_per_texel() as u64;
        let rest = if self.taken_count > 0 { depth - successor.copied } else { 0 };
        let layers = u64::from(rest).min((*budget / layer).max(1)) as u32;
        if layers > 0 {
            recording.push(Step::CopyTexture {
                from: self.texture,
                to: successor.texture,
                origin: [0, 0, successor.copied],
                size: [width, height, layers],
            });
            *budget = budget.saturating_sub(u64::from(layers) * layer);
        }
        successor.copied += layers;
        if layers == rest {
            recording.push(Step::Free { id: self.texture });
            (self.texture, self.texture_size) = (successor.texture, self.size);
            self.successor = None;
        }
    }

    /// Stays in its texture after all. Nothing lies beyond it any more.
    pub fn stay(&mut self) -> Option<Successor> {
        self.take_size(self.texture_size);
        self.successor.take()
    }

    pub fn free_textures(self, recording: &mut Recording) {
        recording.push(Step::Free { id: self.texture });
        recording.free(self.successor.map(|successor| successor.texture));
    }

    pub fn capacity(&self) -> usize {
        self.taken.len()
    }

    pub fn free(&self) -> usize {
        self.capacity() - self.taken_count
    }

    pub fn bytes(&self) -> u64 {
        self.capacity() as u64 * TEXELS * self.format.bytes_per_texel() as u64
    }

    /// Of the texture that a larger one takes the place of.
    pub fn passing_bytes(&self) -> u64 {
        let bytes = volume(self.texture_size) as u64 * TEXELS * self.format.bytes_per_texel() as u64;
        if self.successor.is_some() { bytes } else { 0 }
    }

    /// Whether it is worth the while of its last volumes to leave it, though so many bricks more are expected.
    pub fn is_sparse(&self, expected: usize) -> bool {
        let used = self.bytes() / self.capacity() as u64 * (self.taken_count + expected) as u64;
        // One that is empty is free for all.
        self.taken_count > 0
            && used * SPARSE < self.bytes()
            && self.bytes().saturating_sub(used) > SPARSE_BYTES
    }

    pub fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        ((z * self.size[1] + y) * self.size[0] + x) as usize
    }

    pub fn place(&self, index: usize) -> [u32; 3] {
        let [nx, ny, _] = self.size.map(|n| n as usize);
        [index % nx, index / nx % ny, index / (nx * ny)].map(|n| n as u32)
    }
}

pub(super) fn volume(size: [u32; 3]) -> usize {
    size.iter().map(|&n| n as usize).product()
}

/// The size of a pool of at least so many bricks that begins as wide and high as `size`, or wider and higher where it
/// would be too deep.
pub(super) fn shape(size: [u32; 3], bricks: usize, max_side: u32) -> Option<[u32; 3]> {
    let [mut width, mut height, depth] = size;
    let layers = |width: u32, height: u32| bricks.div_ceil(width as usize * height as usize) as u32;
    while layers(width, height) > max_side && height < max_side {
        height += 1;
    }
    while layers(width, height) > max_side && width < max_side {
        width += 1;
    }
    let layers = layers(width, height).max(depth);
    (layers <= max_side).then_some([width, height, layers])
}
