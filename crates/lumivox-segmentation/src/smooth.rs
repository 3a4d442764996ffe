//! Depths below the skin without the stairs of the voxels that they were measured from.

use lumivox_core::{CancelToken, Cancelled, Volume};
use rayon::prelude::*;

use crate::distance::{DEPTH_STEP_MM, DepthField};

/// Voxels of the finest axis that each of two running means of depths takes in, on either side.
const SMOOTHING: f64 = 2.0;

/// Stored depths count in these parts of a step.
const PARTS_OF_STEP: u32 = 64;

/// Depths without the stairs of the voxels that they were measured from: means by triangles, which two running means are.
pub struct SmoothDepth {
    dims: [usize; 3],
    /// Smooth along x and y.
    parts: Vec<u16>,
    /// Reach of a running mean along z.
    reach_z: usize,
    /// Along the finest axis.
    reach: usize,
    voxel_mm: f32,
}

impl SmoothDepth {
    pub fn new(volume: &Volume, depth: &DepthField, cancel: &CancelToken) -> Result<Self, Cancelled> {
        let dims = depth.dims();
        let [nx, ny, _] = dims;
        let spacing = volume.spacing_mm();
        let finest = spacing.min_element();
        // Thick slices are not smoothed across.
        let [rx, ry, rz] = spacing.to_array().map(|mm| (SMOOTHING * finest / mm).round() as usize);
        let mut parts = vec![0u16; depth.steps().len()];
        parts.par_chunks_mut(nx * ny).zip(depth.steps().par_chunks(nx * ny)).try_for_each_init(
            || vec![0u16; nx * ny],
            |scratch, (parts, steps)| {
                cancel.check()?;
                let slice = |y: usize| y * nx..(y + 1) * nx;
                for (part, &step) in parts.iter_mut().zip(steps) {
                    *part = u16::from(step) * PARTS_OF_STEP as u16;
                }
                for _ in 0..2 {
                    for y in 0..ny {
                        running_mean(&parts[slice(y)], &mut scratch[slice(y)], rx);
                    }
                    for y in 0..ny {
                        let to = &mut parts[slice(y)];
                        let rows = (0..2 * ry + 1).map(|k| (y + k).saturating_sub(ry).min(ny - 1));
                        let mut sums = vec![0u32; nx];
                        for row in rows {
                            sums.iter_mut()
                                .zip(&scratch[slice(row)])
                                .for_each(|(sum, &part)| *sum += u32::from(part));
                        }
                        let count = 2 * ry as u32 + 1;
                        to.iter_mut()
                            .zip(&sums)
                            .for_each(|(to, &sum)| *to = ((sum + count / 2) / count) as u16);
                    }
                }
                Ok(())
            },
        )?;
        Ok(Self { dims, parts, reach_z: rz, reach: SMOOTHING as usize, voxel_mm: finest as f32 })
    }

    /// How far from a voxel depths still count, along the finest axis, in mm.
    pub fn reach_mm(&self) -> f32 {
        2.0 * self.reach as f32 * self.voxel_mm
    }

    /// The smooth depth of a voxel, in mm.
    pub fn mm(&self, [x, y, z]: [usize; 3]) -> f32 {
        let [nx, ny, nz] = self.dims;
        let reach = self.reach_z;
        let at = y * nx + x;
        let (mut sum, mut weights) = (0, 0);
        for (k, weight) in triangle(reach) {
            let z = (z + k).saturating_sub(2 * reach).min(nz - 1);
            sum += weight * u32::from(self.parts[z * nx * ny + at]);
            weights += weight;
        }
        sum as f32 / weights as f32 / PARTS_OF_STEP as f32 * DEPTH_STEP_MM
    }

    /// What becomes of a depth below a plane, and how fast it changes there: outside, depths are 0, which raises means.
    pub fn below_plane(&self, mm: f32) -> [f32; 2] {
        let (mut sum, mut slope, mut weights) = (0.0, 0.0, 0.0);
        for (k, weight) in triangle(self.reach) {
            let at = mm + (k as f32 - 2.0 * self.reach as f32) * self.voxel_mm;
            sum += weight as f32 * at.max(0.0);
            slope += if at > 0.0 { weight as f32 } else { 0.0 };
            weights += weight as f32;
        }
        [sum / weights, slope / weights]
    }
}

/// Places and weights of two running means after each other, of a reach each.
fn triangle(reach: usize) -> impl Iterator<Item = (usize, u32)> {
    (0..=4 * reach).map(move |k| (k, (k.min(4 * reach - k) + 1) as u32))
}

/// Means of as many values on either side; the ends go on as they are.
fn running_mean(from: &[u16], to: &mut [u16], reach: usize) {
    let last = from.len() - 1;
    let count = 2 * reach as u32 + 1;
    let at = |i: usize| u32::from(from[i.saturating_sub(reach).min(last)]);
    let mut sum: u32 = (0..2 * reach + 1).map(at).sum();
    for (i, to) in to.iter_mut().enumerate() {
        *to = ((sum + count / 2) / count) as u16;
        sum = sum + at(i + 2 * reach + 1) - at(i);
    }
}
