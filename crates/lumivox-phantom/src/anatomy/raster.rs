//! From shapes to voxels: partial volume, reconstruction blur, noise.
//!
//! Slabs of slices are filled in parallel. Within a slab, blocks of voxels are visited coarse to fine; for each, the
//! model is pruned to the shapes that reach it (see [`crate::sdf`]), so that air and the inside of large organs cost
//! next to nothing. The partition is fixed by the grid, never by the threads.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use lumivox_core::{CancelToken, Cancelled, Progress, Stage};
use rayon::prelude::*;

use super::{AnatomyOptions, material::Material};
use crate::{
    AIR_HU,
    noise::{gaussian, noise},
    sdf::{Region, Sdf},
    stored,
};

/// A shape filled with a tissue.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    shape: Sdf,
    material: Material,
    open: bool,
}

impl Layer {
    pub(crate) fn new(shape: Sdf, material: Material) -> Self {
        Self { shape, material, open: false }
    }

    /// A layer that may reach the air outside, as airways do.
    pub(crate) fn open(shape: Sdf, material: Material) -> Self {
        Self { shape, material, open: true }
    }

    /// The layer kept inside of `limit`, with edges rounded over `k` mm, unless it is open.
    pub(crate) fn within(mut self, limit: Sdf, k: f32) -> Self {
        if !self.open {
            self.shape = self.shape.and(limit, k);
        }
        self
    }
}

/// Shared fields, and layers that replace what lies under them.
pub(crate) struct Model {
    /// Each may use those before it.
    pub fields: Vec<Sdf>,
    /// Bottom first.
    pub layers: Vec<Layer>,
    /// Seed of the warp that makes the body irregular.
    pub warp_seed: u32,
}

/// A cubic grid of cubic voxels.
#[derive(Clone, Copy)]
pub(crate) struct Grid {
    /// Voxels along each side.
    pub size: usize,
    /// Centre of the first voxel, in mm.
    pub first: Vec3,
    /// Distance of voxel centres, in mm.
    pub spacing: f32,
}

impl Grid {
    fn place(&self, voxel: [usize; 3]) -> Vec3 {
        self.first + Vec3::from_array(voxel.map(|i| i as f32)) * self.spacing
    }
}

/// Slices of one task.
const SLAB: usize = 8;

/// Voxels along the sides of the blocks that the model is pruned to, coarse to fine.
const BLOCK_SIDES: [usize; 3] = [32, 8, 4];

/// Number of shared fields at most.
const MAX_FIELDS: usize = 4;

/// How far the warp moves a point, in mm.
const WARP_MM: f32 = 1.5;

/// Size of the warp's waves, in mm.
const WARP_SIZE: f32 = 70.0;

/// Side weight of the in-plane reconstruction blur `[w, 1 - 2w, w]`.
const BLUR: f32 = 0.11;

/// Samples of the whole grid, x fastest, stored as CT scanners do.
pub(crate) fn rasterise(
    model: &Model,
    grid: Grid,
    options: AnatomyOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Vec<u16>, Cancelled> {
    let plane = grid.size * grid.size;
    let mut samples = vec![0u16; plane * grid.size];
    let done = AtomicU64::new(0);
    let whole = Block::of(model);
    samples.par_chunks_mut(plane * SLAB).enumerate().try_for_each(|(slab, samples)| {
        let mut values = vec![AIR_HU as f32; samples.len()];
        let z0 = slab * SLAB;
        let slices = samples.len() / plane;
        Slab { grid, z0, warp_seed: model.warp_seed, values: &mut values, cancel }.fill(
            &whole,
            [0, 0, z0],
            [grid.size, grid.size, z0 + slices],
            &BLOCK_SIDES,
        )?;
        for (slice, samples) in samples.chunks_mut(plane).enumerate() {
            let values = &mut values[slice * plane..][..plane];
            reconstruct(values, grid, options, (z0 + slice) * plane);
            samples.iter_mut().zip(values).for_each(|(s, v)| *s = stored(f64::from(*v)));
        }
        let slices = slices as u64;
        let done = done.fetch_add(slices, Ordering::Relaxed) + slices;
        progress.report(Stage::Generating, done, grid.size as u64);
        Ok(())
    })?;
    Ok(samples)
}

/// The model in one block: fields and layers that matter there.
struct Block<'a> {
    fields: Vec<Sdf>,
    layers: Vec<(Sdf, &'a Material)>,
}

impl<'a> Block<'a> {
    fn of(model: &'a Model) -> Self {
        Self {
            fields: model.fields.clone(),
            layers: model.layers.iter().map(|l| (l.shape.clone(), &l.material)).collect(),
        }
    }

    /// What of `self` reaches the ball around `center`. `reach` is how far outside of a shape it still shows.
    fn prune(&self, center: Vec3, radius: f32, reach: f32) -> Block<'a> {
        let mut ranges = Vec::with_capacity(self.fields.len());
        let mut fields = Vec::with_capacity(self.fields.len());
        for field in &self.fields {
            let (field, range) = field.prune(&Region { center, radius, fields: &ranges });
            fields.push(field);
            ranges.push(range);
        }
        let region = Region { center, radius, fields: &ranges };
        let mut layers = Vec::new();
        for (shape, material) in &self.layers {
            let (shape, [low, high]) = shape.prune(&region);
            if high < -reach {
                // It covers the block: nothing under it is seen.
                layers.clear();
            }
            if low < reach {
                layers.push((shape, *material));
            }
        }
        Block { fields, layers }
    }

    fn value(&self, p: Vec3, spacing: f32) -> f32 {
        let mut fields = [f32::MAX; MAX_FIELDS];
        for (i, field) in self.fields.iter().enumerate() {
            fields[i] = field.distance(p, &fields);
        }
        let mut hu = AIR_HU as f32;
        for (shape, material) in &self.layers {
            let d = shape.distance(p, &fields);
            let cover = (0.5 - d / spacing).clamp(0.0, 1.0);
            if cover > 0.0 {
                hu += (material.hu(p, (-d).max(0.0)) - hu) * cover;
            }
        }
        hu
    }
}

/// The voxels of one slab, being filled.
struct Slab<'a> {
    grid: Grid,
    /// Its first slice.
    z0: usize,
    warp_seed: u32,
    values: &'a mut [f32],
    cancel: &'a CancelToken,
}

impl Slab<'_> {
    /// Fills the voxels from `low` up to `high` (x, y, z) with what of `block` reaches them, block by smaller block.
    fn fill(
        &mut self,
        block: &Block,
        low: [usize; 3],
        high: [usize; 3],
        sides: &[usize],
    ) -> Result<(), Cancelled> {
        self.cancel.check()?;
        let first = self.grid.place(low);
        let last = self.grid.place(high.map(|i| i - 1));
        // Voxels are looked up where the warp moves them.
        let radius = (last - first).length() / 2.0 + 2.0 * WARP_MM;
        let block = block.prune((first + last) / 2.0, radius, 0.5 * self.grid.spacing);
        if block.layers.is_empty() {
            return Ok(());
        }
        let [side, finer @ ..] = sides else {
            self.evaluate(&block, low, high);
            return Ok(());
        };
        let starts = |axis: usize| (low[axis]..high[axis]).step_by(*side);
        for z in starts(2) {
            for y in starts(1) {
                for x in starts(0) {
                    let corner = [x, y, z];
                    let end = std::array::from_fn(|a| (corner[a] + side).min(high[a]));
                    self.fill(&block, corner, end, finer)?;
                }
            }
        }
        Ok(())
    }

    fn evaluate(&mut self, block: &Block, low: [usize; 3], high: [usize; 3]) {
        let Grid { size, spacing, .. } = self.grid;
        for z in low[2]..high[2] {
            for y in low[1]..high[1] {
                for x in low[0]..high[0] {
                    let p = warp(self.grid.place([x, y, z]), self.warp_seed);
                    self.values[((z - self.z0) * size + y) * size + x] = block.value(p, spacing);
                }
            }
        }
    }
}

/// Moves space a little, so that no two sides are equal.
fn warp(p: Vec3, seed: u32) -> Vec3 {
    let q = p / WARP_SIZE;
    p + WARP_MM * Vec3::new(noise(q, seed), noise(q, seed ^ 0x51), noise(q, seed ^ 0xa7))
}

/// Turns one ideal slice into a measured one: noise, the blur of the reconstruction, and air outside its circle.
fn reconstruct(values: &mut [f32], grid: Grid, options: AnatomyOptions, first_index: usize) {
    let n = grid.size;
    // The blur also tempers the noise, and gives it the grain of a reconstruction.
    let gain = 2.0 * BLUR * BLUR + (1.0 - 2.0 * BLUR) * (1.0 - 2.0 * BLUR);
    let noise_hu = options.noise_hu as f32 / gain;
    if noise_hu > 0.0 {
        for (i, value) in values.iter_mut().enumerate() {
            *value += noise_hu * gaussian(options.seed, (first_index + i) as u64);
        }
    }
    let blur = |a: f32, b: f32, c: f32| BLUR * (a + c) + (1.0 - 2.0 * BLUR) * b;
    for row in values.chunks_mut(n) {
        let mut before = row[0];
        for x in 0..n {
            let here = row[x];
            row[x] = blur(before, here, row[(x + 1).min(n - 1)]);
            before = here;
        }
    }
    let mut before = values[..n].to_vec();
    for y in 0..n {
        for x in 0..n {
            let here = values[y * n + x];
            values[y * n + x] = blur(before[x], here, values[(y + 1).min(n - 1) * n + x]);
            before[x] = here;
        }
    }
    let middle = (n as f32 - 1.0) / 2.0;
    for (i, value) in values.iter_mut().enumerate() {
        let (dx, dy) = ((i % n) as f32 - middle, (i / n) as f32 - middle);
        let inside = (n as f32 / 2.0 - (dx * dx + dy * dy).sqrt()).clamp(0.0, 1.0);
        *value = AIR_HU as f32 + (*value - AIR_HU as f32) * inside;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::hash64;

    #[test]
    fn pruning_a_block_does_not_change_its_voxels() {
        let model = super::super::model(1);
        let whole = Block::of(&model);
        let unit = |i: u64| (hash64(i) >> 40) as f32 / (1 << 24) as f32 - 0.5;
        let mut worst = 0.0f32;
        for i in 0..400 {
            let center =
                Vec3::new(unit(7 * i) * 150.0, unit(7 * i + 1) * 220.0, unit(7 * i + 2) * 300.0 - 20.0);
            let block = whole.prune(center, 9.0, 0.5).prune(center, 6.0, 0.5);
            for j in 0..8 {
                let offset = Vec3::from_array(std::array::from_fn(|c| unit(7000 * i + 3 * j + c as u64)));
                let p = center + offset * 6.0;
                worst = worst.max((block.value(p, 1.0) - whole.value(p, 1.0)).abs());
            }
        }
        assert!(worst < 1.0, "differs by {worst} HU");
    }
}
