//! Which labels a cell of a majorant grid can meet: all that interpolation inside of it touches.
//!
//! Blocks of the label volume are looked at once, on another thread than the frame's where a host prepares scenes; cells
//! then join the sets of the blocks that they reach.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{LabelVolume, UNLABELLED, Volume};
use lumivox_shaders::constants::SET_OF_MANY;
use rayon::prelude::*;

use crate::derived::Derived;

/// Label voxels along a side of a block.
const BLOCK: usize = 4;

/// Labels that a set holds.
const MOST: usize = SET_OF_MANY as usize - 1;

/// How far from a point the label that is drawn for it may lie, in voxels, and a little for rounding.
const REACH: f64 = 1.5 + 0.02;

/// Labels: seven bytes from the lowest, and their number in the highest, or [`SET_OF_MANY`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct LabelSet(u64);

impl LabelSet {
    fn len(self) -> usize {
        (self.0 >> 56) as usize
    }

    fn labels(self) -> impl Iterator<Item = u8> {
        self.0.to_le_bytes().into_iter().take(self.len())
    }

    fn insert(&mut self, label: u8) {
        let count = self.len();
        if count > MOST || self.labels().any(|known| known == label) {
            return;
        }
        if count == MOST {
            self.0 = u64::from(SET_OF_MANY) << 56;
        } else {
            self.0 = (self.0 & !(0xff << 56)) | u64::from(label) << (8 * count) | (count as u64 + 1) << 56;
        }
    }

    fn join(&mut self, other: Self) {
        if *self == other {
        } else if other.len() > MOST {
            *self = other;
        } else {
            other.labels().for_each(|label| self.insert(label));
        }
    }

    /// As the kernel reads it.
    fn words(self) -> [u32; 2] {
        [self.0 as u32, (self.0 >> 32) as u32]
    }
}

/// The sets of all blocks of a label volume, x fastest.
pub(super) struct Blocks {
    counts: [usize; 3],
    sets: Vec<LabelSet>,
}

static BLOCKS: Derived<Volume, (), Blocks> = Derived::new();

/// Looks at all labels, unless somebody did before; and whether nobody had.
pub(super) fn blocks(labels: &LabelVolume) -> (Arc<Blocks>, bool) {
    BLOCKS.get_or(labels.volume(), (), || Blocks::new(labels))
}

/// Whether somebody has.
pub(super) fn are_known(labels: &LabelVolume) -> bool {
    BLOCKS.get(labels.volume(), &()).is_some()
}

impl Blocks {
    fn new(labels: &LabelVolume) -> Self {
        let [nx, ny, nz] = labels.dims();
        let counts = [nx, ny, nz].map(|n| n.div_ceil(BLOCK));
        let mut sets = vec![LabelSet::default(); counts.iter().product()];
        let layer = |(z, layer): (usize, &mut [LabelSet])| {
            for z in z * BLOCK..((z + 1) * BLOCK).min(nz) {
                for y in 0..ny {
                    let row = &labels.voxels()[(z * ny + y) * nx..][..nx];
                    let sets = &mut layer[y / BLOCK * counts[0]..][..counts[0]];
                    for (set, voxels) in sets.iter_mut().zip(row.chunks(BLOCK)) {
                        let mut before = None;
                        for &label in voxels {
                            if before != Some(label) {
                                set.insert(label);
                                before = Some(label);
                            }
                        }
                    }
                }
            }
        };
        sets.par_chunks_mut(counts[0] * counts[1]).enumerate().for_each(layer);
        Self { counts, sets }
    }

    /// Of blocks from `begin` to `end`, both included.
    fn join(&self, begin: [usize; 3], end: [usize; 3], set: &mut LabelSet) {
        for z in begin[2]..=end[2] {
            for y in begin[1]..=end[1] {
                let row = &self.sets[(z * self.counts[1] + y) * self.counts[0]..];
                row[begin[0]..=end[0]].iter().for_each(|other| set.join(*other));
            }
        }
    }
}

/// Of which cells the sets are wanted, and how labels lie to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellLabels {
    /// Voxels of the copy of the scan, along each axis; cells, and voxels along their sides.
    pub dims: [u32; 3],
    pub grid_dims: [u32; 3],
    pub cell_size: u32,
    /// Voxel space of the copy of the labels from that of the copy of the scan, on the GPU.
    pub labels_from_voxel: DAffine3,
    /// Voxels of the labels along an axis for one of their copy.
    pub factor: u32,
}

impl CellLabels {
    /// The sets of all cells, x fastest.
    pub fn sets(&self, labels: &LabelVolume, blocks: &Blocks) -> Vec<[u32; 2]> {
        let [nx, ny, _] = self.grid_dims.map(|n| n as usize);
        let cells: usize = self.grid_dims.iter().map(|&n| n as usize).product();
        let mut sets = vec![[0; 2]; cells];
        sets.par_chunks_mut(nx).enumerate().for_each(|(row, sets)| {
            for (x, set) in sets.iter_mut().enumerate() {
                *set = self.set([x, row % ny, row / ny], labels, blocks).words();
            }
        });
        sets
    }

    /// The points of cell c lie between the centres of the voxels (c - 1) * size and c * size, and within the volume.
    fn set(&self, cell: [usize; 3], labels: &LabelVolume, blocks: &Blocks) -> LabelSet {
        let size = f64::from(self.cell_size);
        let last = DVec3::from_array(self.dims.map(f64::from));
        let high = DVec3::from_array(cell.map(|c| c as f64 * size + 0.5));
        let (low, high) = ((high - size).clamp(DVec3::ZERO, last), high.clamp(DVec3::ZERO, last));
        let center = self.labels_from_voxel.transform_point3((low + high) / 2.0);
        let m = self.labels_from_voxel.matrix3;
        let half = (high - low) / 2.0;
        let around = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z + REACH;
        let mut set = LabelSet::default();
        let (mut begin, mut end) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            let n = labels.dims()[axis];
            let copied = n.div_ceil(self.factor as usize) as f64;
            let (low, high) = (center[axis] - around[axis], center[axis] + around[axis]);
            if low < 0.0 || high >= copied {
                set.insert(UNLABELLED);
            }
            if high < 0.0 || low >= copied {
                return set;
            }
            // Voxels of the labels that voxels of their copy may have been taken from.
            let factor = self.factor as usize;
            begin[axis] = low.max(0.0) as usize * factor / BLOCK;
            end[axis] = ((high.min(copied - 1.0) as usize * factor + factor - 1).min(n - 1)) / BLOCK;
        }
        blocks.join(begin, end, &mut set);
        set
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumivox_core::Label;

    #[test]
    fn sets_hold_each_label_once_until_they_are_many() {
        let mut set = LabelSet::default();
        [3, 200, 3, 0, 0].into_iter().for_each(|label| set.insert(label));
        assert_eq!(set.labels().collect::<Vec<_>>(), [3, 200, 0]);
        assert_eq!(set.words(), [3 | 200 << 8, 3 << 24]);
        let mut many = set;
        (10..14).for_each(|label| many.insert(label));
        assert_eq!(many.len(), 7);
        many.insert(200);
        assert_eq!(many.len(), 7);
        many.insert(14);
        assert_eq!(many.words(), [0, SET_OF_MANY << 24]);
        set.join(many);
        assert_eq!(set, many);
        many.insert(1);
        assert_eq!(set, many);
    }

    /// Labels that differ from voxel to voxel, on a turned and coarser grid: whatever is drawn in a cell is in its set.
    #[test]
    fn every_label_that_can_be_drawn_in_a_cell_is_in_its_set() {
        let mut state = 1u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        let dims = [13, 9, 11];
        let voxels = (0..13 * 9 * 11).map(|_| if uniform() < 0.9 { 1 } else { (uniform() * 9.0) as u8 });
        let named = (1..9).map(|value| Label { value, name: value.to_string(), color: [0.0; 3] }).collect();
        let labels = LabelVolume::new(dims, voxels.collect(), DAffine3::IDENTITY, named).unwrap();
        let blocks = Blocks::new(&labels);
        for factor in [1, 2, 3] {
            let turned = DAffine3::from_rotation_z(0.4) * DAffine3::from_rotation_x(-0.3);
            let labels_from_voxel = DAffine3::from_scale(DVec3::splat(1.0 / f64::from(factor)))
                * DAffine3::from_translation(DVec3::new(1.0, -2.0, 0.5))
                * turned
                * DAffine3::from_scale(DVec3::splat(0.6));
            let cells =
                CellLabels { dims: [20; 3], grid_dims: [6; 3], cell_size: 4, labels_from_voxel, factor };
            let sets = cells.sets(&labels, &blocks);
            for _ in 0..20000 {
                let p = DVec3::new(uniform(), uniform(), uniform()) * 20.0;
                let cell = ((p + 3.5) / 4.0).floor().to_array().map(|c| c as usize);
                let here = labels_from_voxel.transform_point3(p);
                let copied = DVec3::from_array(dims.map(|n| n.div_ceil(factor as usize) as f64));
                let is_inside = here.cmpge(DVec3::ZERO).all() && here.cmplt(copied).all();
                let moved = here + DVec3::new(uniform(), uniform(), uniform()) * 3.0 - 1.5;
                let moved = moved.clamp(DVec3::ZERO, copied - 0.5);
                let label = if is_inside {
                    let at = |axis: usize| crate::store::picked(moved[axis] as usize, factor, dims[axis]);
                    labels.value([at(0), at(1), at(2)])
                } else {
                    UNLABELLED
                };
                let [low, high] = sets[(cell[2] * 6 + cell[1]) * 6 + cell[0]];
                let set = LabelSet(u64::from(high) << 32 | u64::from(low));
                assert!(set.len() > MOST || set.labels().any(|known| known == label), "{p} {label}");
            }
        }
    }
}
