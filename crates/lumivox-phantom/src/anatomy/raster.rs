//! From shapes to voxels: partial volume, reconstruction blur, noise.
//!
//! Slabs of slices are filled in parallel. Within a slab, blocks of voxels are visited coarse to fine; for each, the
//! model is pruned to the shapes that reach it (see [`crate::sdf`]), so that air and the inside of large organs cost
//! next to nothing. The partition is fixed by the grid, never by the threads.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{Mat3, Vec3};
use lumivox_core::{CancelToken, Cancelled, Progress, WorkStage};
use rayon::prelude::*;

use super::material::Material;
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
    rigid: bool,
    part: u8,
}

impl Layer {
    pub(crate) fn new(shape: Sdf, material: Material) -> Self {
        Self { shape, material, open: false, rigid: false, part: 0 }
    }

    /// A layer that may reach the air outside, as airways do.
    pub(crate) fn open(shape: Sdf, material: Material) -> Self {
        Self { open: true, ..Self::new(shape, material) }
    }

    /// The layer as something made, which the warp leaves as it is.
    pub(crate) fn rigid(self) -> Self {
        Self { rigid: true, ..self }
    }

    /// The layer with the number by which [`rasterise_parts`] tells it.
    pub(crate) fn part(self, part: u8) -> Self {
        Self { part, ..self }
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

impl Model {
    /// The same body in a T1-weighted MR ([`Material::in_t1`]).
    pub(crate) fn in_t1(mut self) -> Self {
        self.layers.iter_mut().for_each(|layer| layer.material = layer.material.in_t1());
        self
    }
}

/// How the model is measured.
#[derive(Clone, Copy)]
pub(crate) struct Scan {
    /// Seed of the noise.
    pub seed: u64,
    /// Standard deviation of the noise, in HU.
    pub noise_hu: f64,
    /// What is stored outside of the reconstruction circle, if not air.
    pub padding: Option<f32>,
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
    /// Directions of the rows, the columns and the slices.
    pub axes: Mat3,
}

impl Grid {
    fn place(&self, voxel: [usize; 3]) -> Vec3 {
        self.first + self.axes * (Vec3::from_array(voxel.map(|i| i as f32)) * self.spacing)
    }

    /// How much of a voxel of a slice lies inside of the reconstruction circle.
    fn inside_circle(&self, x: usize, y: usize) -> f32 {
        let middle = (self.size as f32 - 1.0) / 2.0;
        let (dx, dy) = (x as f32 - middle, y as f32 - middle);
        (self.size as f32 / 2.0 - (dx * dx + dy * dy).sqrt()).clamp(0.0, 1.0)
    }
}

/// Slices of one task.
const SLAB: usize = 8;

/// Voxels along the sides of the blocks that the model is pruned to, coarse to fine.
const BLOCK_SIDES: [usize; 6] = [32, 16, 8, 4, 2, 1];

/// Smaller blocks than this, in mm, are not worth the pruning.
const FINEST_BLOCK_MM: f32 = 3.0;

/// Neither are single voxels smaller than this.
const FINEST_VOXEL_MM: f32 = 6.0;

/// Number of shared fields at most.
const MAX_FIELDS: usize = 8;

/// How far the warp moves a point, in mm.
const WARP_MM: f32 = 1.5;

/// The largest stretch of space by the warp: noise has slopes of less than 2.5 along each axis.
const WARP_STRETCH: f32 = 1.75 * 2.5 * WARP_MM / WARP_SIZE;

/// Size of the warp's waves, in mm.
const WARP_SIZE: f32 = 70.0;

/// Side weight of the in-plane reconstruction blur `[w, 1 - 2w, w]`.
const BLUR: f32 = 0.11;

/// Samples of the whole grid, x fastest, stored as CT scanners do.
pub(crate) fn rasterise(
    model: &Model,
    grid: Grid,
    scan: Scan,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Vec<u16>, Cancelled> {
    let plane = grid.size * grid.size;
    let finish = |slab: usize, values: &mut [f32], samples: &mut [u16]| {
        for (slice, samples) in samples.chunks_mut(plane).enumerate() {
            let values = &mut values[slice * plane..][..plane];
            reconstruct(values, grid, scan, (slab * SLAB + slice) * plane);
            samples.iter_mut().zip(values).for_each(|(s, v)| *s = stored(f64::from(*v)));
        }
    };
    let value = |block: &Block, p: Vec3, warped: Vec3| block.value(p, warped, grid.spacing);
    slabs(model, grid, AIR_HU as f32, &value, &finish, progress, cancel)
}

/// The part that each voxel's centre lies in, x fastest; `outside` where there is none, and outside of the circle.
pub(crate) fn rasterise_parts(
    model: &Model,
    grid: Grid,
    outside: [u8; 2],
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Vec<u8>, Cancelled> {
    let finish = |_, values: &mut [u8], parts: &mut [u8]| {
        for (i, (part, value)) in parts.iter_mut().zip(values).enumerate() {
            let i = i % (grid.size * grid.size);
            let inside = grid.inside_circle(i % grid.size, i / grid.size) >= 0.5;
            *part = if inside { *value } else { outside[1] };
        }
    };
    let part = |block: &Block, p: Vec3, warped: Vec3| block.part(p, warped).unwrap_or(outside[0]);
    slabs(model, grid, outside[0], &part, &finish, progress, cancel)
}

/// The part at a place, if there is one.
pub(crate) fn part_at(model: &Model, p: Vec3) -> Option<u8> {
    // A voxel of no size: of the whole model, what reaches the point.
    let warped = warp(p, model.warp_seed);
    let (mut ranges, mut fields) = (Vec::new(), [f32::MAX; MAX_FIELDS]);
    for (i, field) in model.fields.iter().enumerate() {
        let (field, range) = field.prune(&Region { center: warped, radius: 0.0, fields: &ranges });
        fields[i] = field.distance(warped, &fields);
        ranges.push(range);
    }
    let covers = |layer: &&Layer| {
        let center = if layer.rigid { p } else { warped };
        let (shape, _) = layer.shape.prune(&Region { center, radius: 0.0, fields: &ranges });
        shape.distance(center, &fields) < 0.0
    };
    model.layers.iter().rev().find(covers).map(|layer| layer.part)
}

/// What each voxel is, of the model's block, its place, and the place where the warp looks it up.
type Look<'a, T> = &'a (dyn Fn(&Block, Vec3, Vec3) -> T + Sync);

/// Turns what was seen in a slab, by its number, into what is kept of it.
type Finish<'a, T, U> = &'a (dyn Fn(usize, &mut [T], &mut [U]) + Sync);

/// Fills the grid slab by slab; `empty` is where no layer is.
fn slabs<T: Copy + Send + Sync, U: Copy + Default + Send>(
    model: &Model,
    grid: Grid,
    empty: T,
    look: Look<'_, T>,
    finish: Finish<'_, T, U>,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Vec<U>, Cancelled> {
    let plane = grid.size * grid.size;
    let mut kept = vec![U::default(); plane * grid.size];
    let done = AtomicU64::new(0);
    let whole = Block::of(model);
    let finest = |side: usize| if side == 1 { FINEST_VOXEL_MM } else { FINEST_BLOCK_MM };
    let worth = |side: &&usize| **side as f32 * grid.spacing >= finest(**side);
    let sides = &BLOCK_SIDES[..BLOCK_SIDES.iter().take_while(worth).count()];
    kept.par_chunks_mut(plane * SLAB).enumerate().try_for_each(|(slab, kept)| {
        let mut values = vec![empty; kept.len()];
        let z0 = slab * SLAB;
        let slices = kept.len() / plane;
        Slab { grid, z0, warp_seed: model.warp_seed, values: &mut values, look, cancel }.fill(
            &whole,
            [0, 0, z0],
            [grid.size, grid.size, z0 + slices],
            sides,
        )?;
        finish(slab, &mut values, kept);
        let slices = slices as u64;
        let done = done.fetch_add(slices, Ordering::Relaxed) + slices;
        progress.report(WorkStage::Generating, done, grid.size as u64);
        Ok(())
    })?;
    Ok(kept)
}

/// The model in one block: fields and layers that matter there.
struct Block<'a> {
    fields: Vec<Sdf>,
    /// Which fields a layer, or a field that a layer asks, asks for.
    asked: u32,
    layers: Vec<(Sdf, &'a Layer)>,
}

impl<'a> Block<'a> {
    fn of(model: &'a Model) -> Self {
        Self {
            fields: model.fields.clone(),
            asked: u32::MAX,
            layers: model.layers.iter().map(|l| (l.shape.clone(), l)).collect(),
        }
    }

    /// What of `self` reaches the ball around `center`, for what is warped around `warped`. `reach` is how far outside
    /// of a shape it still shows.
    fn prune(&self, center: Vec3, warped: Vec3, radius: f32, reach: f32) -> Block<'a> {
        let mut ranges = Vec::with_capacity(self.fields.len());
        let mut fields = Vec::with_capacity(self.fields.len());
        for field in &self.fields {
            let (field, range) = field.prune(&Region { center: warped, radius, fields: &ranges });
            fields.push(field);
            ranges.push(range);
        }
        let warped = Region { center: warped, radius, fields: &ranges };
        let rigid = Region { center, ..warped };
        let mut layers = Vec::new();
        for (shape, layer) in &self.layers {
            let (mut shape, [low, high]) = shape.prune(if layer.rigid { &rigid } else { &warped });
            if high < -reach {
                // It covers the block: nothing under it is seen, and nobody asks how deep it is.
                layers.clear();
                if !layer.material.has_depth() {
                    shape = Sdf::Full;
                }
            }
            if low < reach {
                layers.push((shape, *layer));
            }
        }
        let mut asked = layers.iter().fold(0, |asked, (shape, _)| asked | shape.fields());
        for (i, field) in fields.iter().enumerate().rev() {
            if asked >> i & 1 == 1 {
                asked |= field.fields();
            }
        }
        Block { fields, asked, layers }
    }

    /// The shared fields at a place, as far as they are asked for.
    fn fields_at(&self, p: Vec3) -> [f32; MAX_FIELDS] {
        let mut fields = [f32::MAX; MAX_FIELDS];
        for (i, field) in self.fields.iter().enumerate() {
            if self.asked >> i & 1 == 1 {
                fields[i] = field.distance(p, &fields);
            }
        }
        fields
    }

    fn value(&self, p: Vec3, warped: Vec3, spacing: f32) -> f32 {
        let fields = self.fields_at(warped);
        let (mut hu, mut seen) = (0.0, 1.0);
        // From the top, as far as something is seen.
        for (shape, layer) in self.layers.iter().rev() {
            let p = if layer.rigid { p } else { warped };
            let d = shape.distance(p, &fields);
            let cover = (0.5 - d / spacing).clamp(0.0, 1.0);
            if cover > 0.0 {
                hu += layer.material.hu(p, (-d).max(0.0)) * cover * seen;
                seen *= 1.0 - cover;
            }
            if seen <= 0.0 {
                break;
            }
        }
        hu + AIR_HU as f32 * seen
    }

    /// The topmost layer's part.
    fn part(&self, p: Vec3, warped: Vec3) -> Option<u8> {
        let fields = self.fields_at(warped);
        let covers = |(shape, layer): &&(Sdf, &Layer)| {
            shape.distance(if layer.rigid { p } else { warped }, &fields) < 0.0
        };
        self.layers.iter().rev().find(covers).map(|(_, layer)| layer.part)
    }
}

/// The voxels of one slab, being filled.
struct Slab<'a, T> {
    grid: Grid,
    /// Its first slice.
    z0: usize,
    warp_seed: u32,
    values: &'a mut [T],
    look: Look<'a, T>,
    cancel: &'a CancelToken,
}

impl<T> Slab<'_, T> {
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
        let center = (first + last) / 2.0;
        // Voxels are looked up where the warp moves them: not much further from each other than they are.
        let warped = warp(center, self.warp_seed);
        let radius = (1.0 + WARP_STRETCH) * (last - first).length() / 2.0;
        let block = block.prune(center, warped, radius, 0.5 * self.grid.spacing);
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
        let size = self.grid.size;
        let warps = block.layers.iter().any(|(_, layer)| !layer.rigid);
        for z in low[2]..high[2] {
            for y in low[1]..high[1] {
                for x in low[0]..high[0] {
                    let p = self.grid.place([x, y, z]);
                    let warped = if warps { warp(p, self.warp_seed) } else { p };
                    self.values[((z - self.z0) * size + y) * size + x] = (self.look)(block, p, warped);
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
fn reconstruct(values: &mut [f32], grid: Grid, scan: Scan, first_index: usize) {
    let n = grid.size;
    // The blur also tempers the noise, and gives it the grain of a reconstruction.
    let gain = 2.0 * BLUR * BLUR + (1.0 - 2.0 * BLUR) * (1.0 - 2.0 * BLUR);
    let noise_hu = scan.noise_hu as f32 / gain;
    if noise_hu > 0.0 {
        for (i, value) in values.iter_mut().enumerate() {
            *value += noise_hu * gaussian(scan.seed, (first_index + i) as u64);
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
    for (i, value) in values.iter_mut().enumerate() {
        let inside = grid.inside_circle(i % n, i / n);
        *value = match scan.padding {
            // Padding is not measured: nothing mixes with it.
            Some(padding) if inside < 0.5 => padding,
            Some(_) => *value,
            None => AIR_HU as f32 + (*value - AIR_HU as f32) * inside,
        };
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
            let block = whole.prune(center, center, 9.0, 0.5).prune(center, center, 6.0, 0.5);
            for j in 0..8 {
                let offset = Vec3::from_array(std::array::from_fn(|c| unit(7000 * i + 3 * j + c as u64)));
                let p = center + offset * 6.0;
                worst = worst.max((block.value(p, p, 1.0) - whole.value(p, p, 1.0)).abs());
            }
        }
        assert!(worst < 1.0, "differs by {worst} HU");
    }
}
