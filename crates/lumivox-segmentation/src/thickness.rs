//! How thick the body is from place to place.

use lumivox_core::{CancelToken, Cancelled, Volume};
use rayon::prelude::*;

use crate::{
    distance::{DEPTH_STEP_MM, DepthField},
    grid::Grid,
};

/// A part is as thick as the body within so many cells of its place is deep.
const REACH_CELLS: usize = 2;

/// How deep the body is around each place, on cells of the scan's own axes.
pub struct Thickness {
    dims: [usize; 3],
    /// Voxels of a cell.
    factors: [usize; 3],
    /// In mm.
    deepest: Vec<f32>,
}

impl Thickness {
    pub fn new(volume: &Volume, depth: &DepthField, cancel: &CancelToken) -> Result<Self, Cancelled> {
        let factors = Grid::new(volume).factors;
        let voxels = volume.dims();
        let dims = [0, 1, 2].map(|axis| voxels[axis].div_ceil(factors[axis]));
        let mut deepest = vec![0f32; dims.iter().product()];
        let slices = deepest
            .par_chunks_mut(dims[0] * dims[1])
            .zip(depth.steps().par_chunks(voxels[0] * voxels[1] * factors[2]));
        slices.try_for_each(|(cells, steps)| {
            cancel.check()?;
            for (row, steps) in steps.chunks_exact(voxels[0]).enumerate() {
                let cells = &mut cells[row % voxels[1] / factors[1] * dims[0]..][..dims[0]];
                for (cell, steps) in cells.iter_mut().zip(steps.chunks(factors[0])) {
                    let most = steps.iter().copied().max().unwrap_or(0);
                    *cell = cell.max(f32::from(most) * DEPTH_STEP_MM);
                }
            }
            Ok(())
        })?;
        let mut strides = [1, dims[0], dims[0] * dims[1]].into_iter().zip(dims);
        strides.try_for_each(|(stride, n)| {
            cancel.check()?;
            let before = deepest.clone();
            deepest.par_iter_mut().enumerate().for_each(|(i, cell)| {
                let at = i / stride % n;
                for near in at.saturating_sub(REACH_CELLS)..(at + REACH_CELLS + 1).min(n) {
                    *cell = cell.max(before[i + near * stride - at * stride]);
                }
            });
            Ok(())
        })?;
        Ok(Self { dims, factors, deepest })
    }

    /// At a voxel, trilinear between cells: no edges where cells meet.
    pub fn at(&self, voxel: [usize; 3]) -> f32 {
        let mut cell = [0usize; 3];
        let mut part = [0f32; 3];
        for axis in 0..3 {
            let place = (voxel[axis] as f32 + 0.5) / self.factors[axis] as f32 - 0.5;
            let place = place.clamp(0.0, (self.dims[axis] - 1) as f32);
            cell[axis] = (place as usize).min(self.dims[axis].saturating_sub(2));
            part[axis] = place - cell[axis] as f32;
        }
        let mut sum = 0.0;
        for corner in 0..8usize {
            let bit = |axis: usize| corner >> axis & 1;
            let weight: f32 =
                (0..3).map(|axis| if bit(axis) == 1 { part[axis] } else { 1.0 - part[axis] }).product();
            if weight > 0.0 {
                let [x, y, z] = [0, 1, 2].map(|axis| cell[axis] + bit(axis));
                sum += weight * self.deepest[(z * self.dims[1] + y) * self.dims[0] + x];
            }
        }
        sum
    }
}
