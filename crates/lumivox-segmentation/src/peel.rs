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

/// In depths that are peeled, what parts are thin, and what are thick.
const THIN: f32 = 1.5;
const THICK: f32 = 2.5;

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

/// As [`peel`], for the millimetres that skin has: thin parts, such as ears, keep their inner sheet. For scans whose
/// [`skin_is_dense`].
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

/// Values as dense as muscle, in HU.
const DENSE_HU: f64 = -20.0;

/// Skin is no thicker than this, in mm.
const SKIN_MM: f64 = 2.5;

/// Skin is dense where this share of it is.
const DENSE_SHARE: f64 = 0.45;

/// Whether the skin of a CT is as dense as muscle, and hides it: less than half of it is where the scan is coarse, for air
/// and fat thin it out there, and where it is thin itself.
///
/// # Panics
/// When the labels are of another grid than the scan's.
pub fn skin_is_dense(volume: &Volume, labels: &LabelVolume) -> bool {
    assert_eq!(volume.dims(), labels.dims(), "labels of another grid");
    let nx = volume.dims()[0];
    let voxels = ((SKIN_MM / volume.spacing_mm().x).ceil() as usize).max(1);
    let [air, body] = [Class::Air, Class::Body].map(Class::value);
    let hu = |at: usize| volume.voxels().get(at) * volume.slope() + volume.intercept();
    // Along each row, from the air into the body.
    let row = |(row, labels): (usize, &[u8])| {
        let (mut all, mut dense) = (0u64, 0u64);
        let mut look = |inner: &mut dyn Iterator<Item = usize>| {
            let mut most = f64::NEG_INFINITY;
            let mut count = 0;
            for x in inner.take(voxels) {
                if labels[x] != body {
                    return;
                }
                most = most.max(hu(row * nx + x));
                count += 1;
            }
            if count == voxels {
                all += 1;
                dense += u64::from(most > DENSE_HU);
            }
        };
        for x in 1..nx {
            match (labels[x - 1], labels[x]) {
                (before, behind) if before == air && behind == body => look(&mut (x..nx)),
                (before, behind) if before == body && behind == air => look(&mut (0..x).rev()),
                _ => {}
            }
        }
        (all, dense)
    };
    let counts = labels.voxels().par_chunks(nx).enumerate().map(row);
    let (all, dense) = counts.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    dense as f64 > DENSE_SHARE * all as f64
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
    let smooth = SmoothDepth::new(&volume, &depth, cancel)?;
    let thickness = spares_thin.then(|| Thickness::new(&volume, &depth, cancel)).transpose()?;
    let peeling = Peeling {
        dims: labels.dims(),
        labels: labels.voxels(),
        depths: depth.steps(),
        smooth,
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

/// Voxels of the finest axis that each of two running means of depths takes in, on either side.
const SMOOTHING: f64 = 2.0;

/// Stored depths count in these parts of a step.
const PARTS_OF_STEP: u32 = 64;

/// Depths without the stairs of the voxels that they were measured from: means by triangles, which two running means are.
struct SmoothDepth {
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
    fn new(volume: &Volume, depth: &DepthField, cancel: &CancelToken) -> Result<Self, Cancelled> {
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
                // What lies in no body is 0, and so is its surroundings' mean: most slices are mostly air.
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

    /// The smooth depth of a voxel, in mm.
    fn mm(&self, [x, y, z]: [usize; 3]) -> f32 {
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
    fn below_plane(&self, mm: f32) -> [f32; 2] {
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
    smooth: SmoothDepth,
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
                // As far as smoothing reaches.
                if depth >= self.mm + 2.0 * self.smooth.reach as f32 * self.smooth.voxel_mm {
                    return 1.0;
                }
                let thickness = self.thickness.as_ref().map_or(f32::INFINITY, |all| all.at(voxel));
                let mm = self.mm.min(SKIN_OF_THIN * thickness);
                let sharp = ((depth - mm) / self.width + 0.5).clamp(0.0, 1.0);
                // Of thin parts smoothing would leave too little.
                let thick = ((thickness / self.mm - THIN) / (THICK - THIN)).clamp(0.0, 1.0);
                if thick == 0.0 || mm <= 0.0 {
                    return sharp;
                }
                let [surface, slope] = self.smooth.below_plane(mm);
                let soft = ((self.smooth.mm(voxel) - surface) / (slope * self.width) + 0.5).clamp(0.0, 1.0);
                sharp + (soft - sharp) * thick
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
