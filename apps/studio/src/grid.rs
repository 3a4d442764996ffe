//! A scan in fewer voxels: which of its own each is made of, and what it is made.

use lumivox_core::Volume;
use lumivox_core::glam::{DAffine3, DVec3};
use rayon::prelude::*;

/// A scan's grid, with so many of its voxels along each axis made one.
pub(crate) struct Grid {
    whole: [usize; 3],
    factor: [usize; 3],
    /// Voxels along each axis.
    pub dims: [usize; 3],
    /// Where they lie.
    pub patient_from_voxel: DAffine3,
}

impl Grid {
    /// Of as many voxels a side at most.
    pub fn of(volume: &Volume, side: usize) -> Self {
        let whole = volume.dims();
        let factor = whole.map(|n| n.div_ceil(side.max(1)));
        let scale = DVec3::from_array(factor.map(|n| n as f64));
        Self {
            whole,
            factor,
            dims: [0, 1, 2].map(|axis| whole[axis].div_ceil(factor[axis])),
            patient_from_voxel: volume.patient_from_voxel()
                * DAffine3::from_translation(0.5 * (scale - 1.0))
                * DAffine3::from_scale(scale),
        }
    }

    /// Whether its voxels are the scan's own.
    pub fn is_whole(&self) -> bool {
        self.factor == [1; 3]
    }

    /// How many voxels it has.
    pub fn count(&self) -> usize {
        self.dims.iter().product()
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.dims;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// The scan's voxels that one of these is made of; of so many along each axis at most.
    pub fn within(&self, index: usize, most: usize) -> impl Iterator<Item = [usize; 3]> + use<> {
        let at = self.place(index);
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let first = at[axis] * self.factor[axis];
            (first..(first + self.factor[axis]).min(self.whole[axis]))
                .step_by(self.factor[axis].div_ceil(most))
        });
        z.flat_map(move |z| {
            let x = x.clone();
            y.clone().flat_map(move |y| x.clone().map(move |x| [x, y, z]))
        })
    }

    /// Those next to one of these, and itself.
    fn around(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let (at, [nx, ny, _]) = (self.place(index), self.dims);
        let [x, y, z] = [0, 1, 2].map(|axis| at[axis].saturating_sub(1)..(at[axis] + 2).min(self.dims[axis]));
        z.flat_map(move |z| {
            let x = x.clone();
            y.clone().flat_map(move |y| x.clone().map(move |x| (z * ny + y) * nx + x))
        })
    }

    /// Fractions along the scan's axes, along those of this grid: it ends where its last voxel does.
    pub fn fractions(&self, corner: [f64; 3]) -> [f64; 3] {
        let of = |axis: usize| self.whole[axis] as f64 / (self.dims[axis] * self.factor[axis]) as f64;
        [0, 1, 2].map(|axis| if corner[axis] < 1.0 { corner[axis] * of(axis) } else { 1.0 })
    }

    /// What a function of the patient's points says at each voxel.
    pub fn map<T: Send>(&self, of: impl Fn(DVec3) -> T + Sync) -> Vec<T> {
        let point = |index| DVec3::from_array(self.place(index).map(|i| i as f64));
        let all = (0..self.count()).into_par_iter();
        all.map(|index| of(self.patient_from_voxel.transform_point3(point(index)))).collect()
    }

    /// Means of those of the scan's voxels that are `kept`; where there are none, of what is kept beside, so that the border is of
    /// matter that is there, else the least value.
    pub fn means(&self, volume: &Volume, kept: impl Fn([usize; 3]) -> bool + Sync) -> Vec<f64> {
        let mean = |index: usize| {
            let kept = self.within(index, usize::MAX).filter(|voxel| kept(*voxel));
            let (sum, count) =
                kept.fold((0.0, 0), |(sum, count), voxel| (sum + volume.value(voxel), count + 1));
            (count > 0).then(|| sum / f64::from(count))
        };
        let means: Vec<Option<f64>> = (0..self.count()).into_par_iter().map(mean).collect();
        let [least, _] = volume.value_range();
        let filled = |index: usize| {
            means[index].unwrap_or_else(|| {
                let beside: Vec<f64> = self.around(index).filter_map(|other| means[other]).collect();
                let sum: f64 = beside.iter().sum();
                if beside.is_empty() { least } else { sum / beside.len() as f64 }
            })
        };
        (0..self.count()).into_par_iter().map(filled).collect()
    }
}
