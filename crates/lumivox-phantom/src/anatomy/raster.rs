//! From shapes to voxels: partial volume, reconstruction blur, noise.
//!
//! Slabs of slices are filled in parallel. Within a slab, blocks of voxels are visited coarse to fine; for each, the
//! model is pruned to the shapes that reach it (see [`crate::sdf`]), so that air and the inside of large organs cost
//! next to nothing. The partition is fixed by the grid, never by the threads.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{UVec3, Vec3};
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

    /// The layer kept inside of `limit`, unless it is open.
    pub(crate) fn within(mut self, limit: Sdf) -> Self {
        if !self.open {
            self.shape = self.shape.and(limit, 0.8);
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
    fn place(&self, voxel: UVec3) -> Vec3 {
        self.first + voxel.as_vec3() * self.spacing
    }
}

/// Slices of one task, and voxels along the side of a fine block.
const FINE: usize = 8;

/// Voxels across a coarse block.
const COARSE: usize = 32;

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
    samples.par_chunks_mut(plane * FINE).enumerate().try_for_each(|(slab, samples)| {
        let mut values = vec![AIR_HU as f32; samples.len()];
        fill_slab(model, grid, slab * FINE, &mut values, cancel)?;
        let offset = slab * FINE * plane;
        for (slice, samples) in samples.chunks_mut(plane).enumerate() {
            let values = &mut values[slice * plane..][..plane];
            reconstruct(values, grid, options, offset + slice * plane);
            samples.iter_mut().zip(values).for_each(|(s, v)| *s = stored(f64::from(*v)));
        }
        let slices = (samples.len() / plane) as u64;
        progress.report(
            Stage::Generating,
            done.fetch_add(slices, Ordering::Relaxed) + slices,
            grid.size as u64,
        );
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

/// The values of up to [`FINE`] slices from `z0` on.
fn fill_slab(model: &Model, grid: Grid, z0: usize, values: &mut [f32], cancel: &CancelToken) -> Result<(), Cancelled> {
    let n = grid.size;
    let slices = values.len() / (n * n);
    let all = Block {
        fields: model.fields.clone(),
        layers: model.layers.iter().map(|l| (l.shape.clone(), &l.material)).collect(),
    };
    let reach = 0.5 * grid.spacing;
    let ball = |low: [usize; 3], high: [usize; 3]| {
        let corner = |c: [usize; 3]| grid.place(UVec3::from_array(c.map(|i| i as u32)));
        let (low, high) = (corner(low), corner(high.map(|i| i - 1)));
        ((low + high) / 2.0, (high - low).length() / 2.0 + 2.0 * WARP_MM)
    };
    for y0 in (0..n).step_by(COARSE) {
        for x0 in (0..n).step_by(COARSE) {
            cancel.check()?;
            let (x1, y1) = ((x0 + COARSE).min(n), (y0 + COARSE).min(n));
            let (center, radius) = ball([x0, y0, z0], [x1, y1, z0 + slices]);
            let coarse = all.prune(center, radius, reach);
            if coarse.layers.is_empty() {
                continue;
            }
            for y0 in (y0..y1).step_by(FINE) {
                for x0 in (x0..x1).step_by(FINE) {
                    let (x1, y1) = ((x0 + FINE).min(x1), (y0 + FINE).min(y1));
                    let (center, radius) = ball([x0, y0, z0], [x1, y1, z0 + slices]);
                    let fine = coarse.prune(center, radius, reach);
                    if fine.layers.is_empty() {
                        continue;
                    }
                    for z in 0..slices {
                        for y in y0..y1 {
                            for x in x0..x1 {
                                let p = grid.place(UVec3::new(x as u32, y as u32, (z0 + z) as u32));
                                values[(z * n + y) * n + x] =
                                    fine.value(warp(p, model.warp_seed), grid.spacing);
                            }
                        }
                    }
                }
            }
        }
    }
    Ok(())
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
