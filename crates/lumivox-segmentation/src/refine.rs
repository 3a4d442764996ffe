//! From cells to voxels: cells say what is near, each voxel's own value says on which side of a surface it lies.

use lumivox_core::{CancelToken, Cancelled, Volume};
use rayon::prelude::*;

use crate::{
    airways::VoxelSet,
    class::Class,
    grid::{Grid, Values},
};

/// How far a solid or airy class reaches into cells that have none of their own, in cells.
const REACH: usize = 2;

/// What the voxels of a cell can be.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct Choice {
    /// Voxels below the first of two values.
    pub airy: u8,
    /// Voxels between them.
    pub dense: u8,
    /// Voxels above the second.
    pub hard: u8,
    /// Whether the first value is the lower one of two.
    pub faint: bool,
}

impl Choice {
    /// Air, or something in it.
    pub fn two(airy: u8, dense: u8) -> Self {
        Self { airy, dense, hard: dense, faint: false }
    }
}

/// Spreads classes into cells without one, a cell at a time; the smallest value wins.
pub fn spread(grid: &Grid, mut class: Vec<u8>) -> Vec<u8> {
    for _ in 0..REACH {
        let before = class.clone();
        class.par_iter_mut().enumerate().filter(|(_, class)| **class == 0).for_each(|(i, class)| {
            let mut nearest = u8::MAX;
            grid.neighbours(i, |next| nearest = nearest.min(before[next].wrapping_sub(1)));
            *class = nearest.wrapping_add(1);
        });
    }
    class
}

/// Spreads classes into all cells without one that touch one, at a corner even; the smallest value wins. No further: thin
/// sheets a little off the skin are not the skin's.
pub fn spread_to_touching(grid: &Grid, before: &[u8]) -> Vec<u8> {
    let [nx, ny, nz] = grid.dims;
    let around = |at: usize, n: usize| at.saturating_sub(1)..(at + 2).min(n);
    let mut class = before.to_vec();
    class.par_iter_mut().enumerate().filter(|(_, class)| **class == 0).for_each(|(i, class)| {
        let [x, y, z] = grid.cell(i);
        let mut nearest = u8::MAX;
        for z in around(z, nz) {
            for y in around(y, ny) {
                let row = grid.index([0, y, z]);
                for &near in &before[row..row + nx][around(x, nx)] {
                    nearest = nearest.min(near.wrapping_sub(1));
                }
            }
        }
        *class = nearest.wrapping_add(1);
    });
    class
}

/// Labels every voxel: by the class of its cell where the choice is one, else by the side of the values that its own is
/// on: that of a faint surface or that of an ordinary one, and that of hard things.
pub fn label(
    volume: &Volume,
    grid: &Grid,
    choices: &[Choice],
    [faint, surface, hard]: [f32; 3],
    airways: Option<&VoxelSet>,
    cancel: &CancelToken,
    step: &(dyn Fn(f64) + Sync),
) -> Result<Vec<u8>, Cancelled> {
    let [nx, ny, nz] = volume.dims();
    let values = Values::new(volume);
    let strides = grid.strides_of_scan();
    let mut labels = vec![0u8; nx * ny * nz];
    let done = std::sync::atomic::AtomicUsize::new(0);
    labels.par_chunks_mut(nx * ny).enumerate().try_for_each_init(
        || vec![0f32; nx],
        |row, (z, slice)| {
            cancel.check()?;
            for (y, labels) in slice.chunks_exact_mut(nx).enumerate() {
                let first = y / grid.factors[1] * strides[1] + z / grid.factors[2] * strides[2];
                values.read((z * ny + y) * nx, row);
                for (cell, (labels, values)) in
                    labels.chunks_mut(grid.factors[0]).zip(row.chunks(grid.factors[0])).enumerate()
                {
                    let choice = choices[first + cell * strides[0]];
                    let surface = if choice.faint { faint } else { surface };
                    for (label, &value) in labels.iter_mut().zip(values) {
                        let solid = if value > hard { choice.hard } else { choice.dense };
                        *label = if value > surface { solid } else { choice.airy };
                    }
                }
            }
            let finished = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            step(finished as f64 / nz as f64);
            Ok(())
        },
    )?;
    for &voxel in airways.map_or(&[][..], VoxelSet::members) {
        labels[voxel as usize] = Class::Airways.value();
    }
    Ok(labels)
}
