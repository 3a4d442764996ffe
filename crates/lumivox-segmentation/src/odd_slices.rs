//! Slices that are unlike both of their neighbours, which are like each other: damaged ones. What is followed from slice to slice,
//! as air and lungs are, goes astray in them.

use lumivox_core::Volume;
use rayon::prelude::*;

use crate::grid::HU_RANGE;

/// Points along either axis of a slice at which slices are compared.
const POINTS: usize = 64;

/// How many times as far a slice is from its neighbours as they are from each other, though it lies between them.
const FACTOR: f32 = 3.0;

/// And so far at least, in HU on average.
const LEAST_HU: f32 = 60.0;

/// The positions of such slices across an axis of the scan.
pub fn odd_slices(volume: &Volume, axis: usize) -> Vec<usize> {
    let dims = volume.dims();
    let strides = [1, dims[0], dims[0] * dims[1]];
    let across: Vec<Vec<usize>> = (0..3)
        .filter(|&other| other != axis)
        .map(|other| {
            let step = dims[other].div_ceil(POINTS);
            (0..dims[other]).step_by(step).map(|i| i * strides[other]).collect()
        })
        .collect();
    let voxels = volume.voxels();
    let [low, high] = HU_RANGE;
    let slice = |k: usize| -> Vec<f32> {
        let points = across[1].iter().flat_map(|b| across[0].iter().map(move |a| a + b));
        let value = |i: usize| voxels.get(i + k * strides[axis]) * volume.slope() + volume.intercept();
        points.map(|i| value(i).clamp(low, high) as f32).collect()
    };
    let slices: Vec<Vec<f32>> = (0..dims[axis]).into_par_iter().map(slice).collect();
    let distance = |a: usize, b: usize| {
        let sum: f32 = slices[a].iter().zip(&slices[b]).map(|(a, b)| (a - b).abs()).sum();
        sum / slices[a].len() as f32
    };
    let is_odd = |k: &usize| {
        let nearer = distance(*k, k - 1).min(distance(*k, k + 1));
        nearer > LEAST_HU && nearer > FACTOR * distance(k - 1, k + 1)
    };
    (1..dims[axis].saturating_sub(1)).into_par_iter().filter(is_odd).collect()
}

#[cfg(test)]
mod tests {
    use lumivox_core::{Modality, Voxels, glam::DAffine3};

    use super::*;

    #[test]
    fn a_slice_of_another_kind_is_odd_and_steps_are_not() {
        let made = |value: &dyn Fn([usize; 3]) -> f32| {
            let at = |i: usize| value([i % 8, i / 8 % 9, i / 72]);
            let voxels = Voxels::F32((0..8 * 9 * 10).map(at).collect());
            Volume::new([8, 9, 10], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct).unwrap()
        };
        let body = |[x, _, _]: [usize; 3]| if x > 3 { 40.0 } else { -1000.0 };
        let damaged = made(&|at| if at[2] == 4 { 0.0 } else { body(at) });
        assert_eq!((odd_slices(&damaged, 2), odd_slices(&damaged, 0)), (vec![4], vec![]));
        let ends = made(&|at| if at[2] < 5 { body(at) } else { -1000.0 });
        assert!(odd_slices(&ends, 2).is_empty());
        let first = made(&|at| if at[2] == 0 { 0.0 } else { body(at) });
        assert!(odd_slices(&first, 2).is_empty());
    }
}
