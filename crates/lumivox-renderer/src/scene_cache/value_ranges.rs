//! Value ranges over cells of a volume, from which the GPU makes majorants for any transfer function.

use std::sync::Arc;

use lumivox_core::{Filter, Volume, Voxels};
use rayon::prelude::*;

use super::atlas::quantise;
use super::derived::Derived;

/// Fewer cells than this along the longest side are made smaller: tight majorants cost little on small volumes.
const MIN_CELLS: usize = 64;

/// The smallest and largest stored value that filtering inside each cell can touch.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueRangeGrid {
    /// Cells along x, y and z.
    pub dims: [usize; 3],
    /// Voxels along a side of a cell.
    pub cell_size: usize,
    /// Smallest and largest 16-bit fraction of each cell, x fastest.
    pub ranges: Vec<[u16; 2]>,
}

/// Voxels that are looked at in less time than it takes to hand them to another thread and wait for a frame.
const QUICK_VOXELS: usize = 1 << 18;

/// What decides a grid, besides its volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct GridKey {
    /// Whether the volume is filtered wider than linearly.
    pub wide: bool,
    /// Side of a cell in voxels.
    pub cell_size: usize,
}

/// The grids of volumes that scenes share.
static GRIDS: Derived<Volume, GridKey, ValueRangeGrid> = Derived::new();

impl GridKey {
    /// The grid of a volume, and whether that took long because nobody had computed it before.
    pub fn grid(self, volume: &Arc<Volume>) -> (Arc<ValueRangeGrid>, bool) {
        let filter = if self.wide { Filter::Tricubic } else { Filter::Trilinear };
        let (grid, computed) =
            GRIDS.get_or(volume, self, || ValueRangeGrid::new(volume, filter, self.cell_size));
        (grid, computed && takes_long(volume))
    }

    /// Whether [`grid`](Self::grid) takes no longer than a frame has time for.
    pub fn is_known(self, volume: &Arc<Volume>) -> bool {
        !takes_long(volume) || GRIDS.get(volume, &self).is_some()
    }
}

fn takes_long(volume: &Volume) -> bool {
    volume.dims().iter().product::<usize>() > QUICK_VOXELS
}

impl ValueRangeGrid {
    /// The cell size that suits a volume: 8, or 4 where 8 would leave few cells.
    pub fn suitable_cell_size(volume: &Volume) -> usize {
        let longest = volume.dims().into_iter().max().unwrap_or(1);
        if longest < MIN_CELLS * 8 { 4 } else { 8 }
    }

    /// The grid of `volume` for filters no wider than `filter`.
    pub fn new(volume: &Volume, filter: Filter, cell_size: usize) -> Self {
        match volume.voxels() {
            Voxels::U8(v) => Self::build(volume, filter, cell_size, v, |&x| x, |x| u16::from(x) * 257),
            Voxels::U16(v) => Self::build(volume, filter, cell_size, v, |&x| x, |x| x),
            Voxels::F32(v) => {
                let range = volume.stored_range();
                let order = |x: &f32| quantise(*x, range);
                Self::build(volume, filter, cell_size, v, order, |x| x)
            }
        }
    }

    fn build<S: Sync, T: Copy + Ord + Send>(
        volume: &Volume,
        filter: Filter,
        cell_size: usize,
        samples: &[S],
        read: impl Fn(&S) -> T + Sync,
        fraction: impl Fn(T) -> u16 + Sync,
    ) -> Self {
        let n = volume.dims();
        let dims = n.map(|n| n.div_ceil(cell_size));
        // A point of cell c lies in [c * size, (c + 1) * size] of voxel space, where voxel i's centre is i + 0.5. A
        // linear filter touches one voxel beyond either face, the cubic two.
        let reach = match filter {
            Filter::Nearest | Filter::Trilinear => 1,
            Filter::Tricubic => 2,
        };
        let touched = |cell: usize, axis: usize| {
            (cell * cell_size).saturating_sub(reach)..((cell + 1) * cell_size + reach).min(n[axis])
        };
        let ranges = (0..dims[1] * dims[2])
            .into_par_iter()
            .flat_map_iter(|row| {
                let (cy, cz) = (row % dims[1], row / dims[1]);
                let mut ranges: Vec<Option<[T; 2]>> = vec![None; dims[0]];
                for z in touched(cz, 2) {
                    for y in touched(cy, 1) {
                        let line = &samples[(z * n[1] + y) * n[0]..][..n[0]];
                        for (cx, range) in ranges.iter_mut().enumerate() {
                            for sample in &line[touched(cx, 0)] {
                                let x = read(sample);
                                let [low, high] = range.get_or_insert([x, x]);
                                *low = x.min(*low);
                                *high = x.max(*high);
                            }
                        }
                    }
                }
                ranges.into_iter().map(|r| r.expect("a cell touches a voxel").map(&fraction))
            })
            .collect();
        Self { dims, cell_size, ranges }
    }

    /// The ranges as the GPU reads them: smallest in the low, largest in the high half.
    pub(crate) fn packed(&self) -> Vec<u32> {
        self.ranges.iter().map(|r| u32::from(r[0]) | u32::from(r[1]) << 16).collect()
    }
}
