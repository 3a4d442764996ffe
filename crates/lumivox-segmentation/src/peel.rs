//! The patient without the skin, or what lies deeper.

use std::sync::atomic::{AtomicUsize, Ordering};

use lumivox_core::{CancelToken, Cancelled, LabelVolume, Progress, Volume, Voxels};
use rayon::prelude::*;

use crate::{
    alone::air_value,
    class::Class,
    distance::{DEPTH_STEP_MM, DepthField},
    grid::Grid,
    progress::Steps,
};

/// The share of the work that measuring depths is.
const MEASURING: f64 = 0.7;

/// Of parts thinner than the skin on both sides of them, this share of the depth is skin: an ear keeps its cartilage.
const SKIN_OF_THIN: f32 = 0.4;

/// A part is as thick as the body within so many cells of its place is deep.
const REACH_CELLS: usize = 2;

/// Makes all air that lies less than `mm` below the body's surface, and outside it; by the labels that
/// [`segment`](crate::segment) or [`patient_alone`](crate::patient_alone) found in the scan. Things stay. What is left has
/// a smooth surface: voxels that the new one goes through are air in part. Where the field of view cuts the body there
/// is no surface, and nothing is peeled. At most [`DepthField::MOST_MM`] can be told apart from more.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// When the labels are of another grid than the scan's.
pub fn peel(
    volume: Volume,
    labels: &LabelVolume,
    mm: f64,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    peel_to(volume, labels, mm, false, progress, cancel)
}

/// As [`peel`], for the millimetres that skin has: thin parts, such as ears, keep their inner sheet.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// When the labels are of another grid than the scan's.
pub fn peel_skin(
    volume: Volume,
    labels: &LabelVolume,
    mm: f64,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    peel_to(volume, labels, mm, true, progress, cancel)
}

fn peel_to(
    volume: Volume,
    labels: &LabelVolume,
    mm: f64,
    spares_thin: bool,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    let steps = Steps::first(progress, MEASURING);
    let depth = crate::depths(&volume, labels, &steps, cancel)?;
    let thickness = spares_thin.then(|| Thickness::new(&volume, &depth, cancel)).transpose()?;
    let peeling = Peeling {
        dims: labels.dims(),
        labels: labels.voxels(),
        depths: depth.steps(),
        thickness,
        mm: mm.min(f64::from(DepthField::MOST_MM)) as f32,
        width: (volume.spacing_mm().min_element() as f32).max(DEPTH_STEP_MM),
        air: (air_value(&volume, labels) - volume.intercept()) / volume.slope(),
    };
    let step = |part: f64| steps.report_rest(0.95 * part);
    let mut result = Ok(());
    let volume = volume
        .edit(|voxels| {
            result = match voxels {
                Voxels::U8(all) => peeling.run(all, |v| v.round() as u8, cancel, &step),
                Voxels::U16(all) => peeling.run(all, |v| v.round() as u16, cancel, &step),
                Voxels::F32(all) => peeling.run(all, |v| v as f32, cancel, &step),
            };
        })
        .expect("values between those of a volume make one");
    result?;
    steps.report_rest(1.0);
    Ok(volume)
}

/// How deep the body is around each place, on cells of the scan's own axes.
struct Thickness {
    dims: [usize; 3],
    /// Voxels of a cell.
    factors: [usize; 3],
    /// In mm.
    deepest: Vec<f32>,
}

impl Thickness {
    fn new(volume: &Volume, depth: &DepthField, cancel: &CancelToken) -> Result<Self, Cancelled> {
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
    fn at(&self, voxel: [usize; 3]) -> f32 {
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

/// A scan that is peeled.
struct Peeling<'a> {
    dims: [usize; 3],
    labels: &'a [u8],
    depths: &'a [u8],
    /// Where thin parts are spared.
    thickness: Option<Thickness>,
    mm: f32,
    /// What the new surface is blurred over, in mm.
    width: f32,
    /// As it is stored.
    air: f64,
}

impl Peeling<'_> {
    /// The share of a voxel that is left.
    fn left(&self, voxel: [usize; 3], label: u8, depth: u8) -> f32 {
        match Class::of(label) {
            Some(Class::Air) => 0.0,
            Some(class) if class.is_patient() => {
                let depth = f32::from(depth) * DEPTH_STEP_MM;
                if depth >= self.mm + 0.5 * self.width {
                    return 1.0;
                }
                let skin = |thickness: &Thickness| self.mm.min(SKIN_OF_THIN * thickness.at(voxel));
                let mm = self.thickness.as_ref().map_or(self.mm, skin);
                ((depth - mm) / self.width + 0.5).clamp(0.0, 1.0)
            }
            _ => 1.0,
        }
    }

    fn run<T: Copy + Into<f64> + Send>(
        &self,
        samples: &mut [T],
        from_f64: impl Fn(f64) -> T + Sync,
        cancel: &CancelToken,
        step: &(dyn Fn(f64) + Sync),
    ) -> Result<(), Cancelled> {
        let [nx, ny, nz] = self.dims;
        let done = AtomicUsize::new(0);
        let known = self.labels.par_chunks(nx * ny).zip(self.depths.par_chunks(nx * ny));
        samples.par_chunks_mut(nx * ny).zip(known).enumerate().try_for_each(
            |(z, (samples, (labels, depths)))| {
                cancel.check()?;
                for (i, (sample, (&label, &depth))) in
                    samples.iter_mut().zip(labels.iter().zip(depths)).enumerate()
                {
                    let left = self.left([i % nx, i / nx, z], label, depth);
                    if left < 1.0 {
                        *sample = from_f64(self.air + ((*sample).into() - self.air) * f64::from(left));
                    }
                }
                step((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / nz as f64);
                Ok(())
            },
        )
    }
}
