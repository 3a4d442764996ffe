//! The patient without the skin, or what lies deeper.

use std::sync::atomic::{AtomicUsize, Ordering};

use lumivox_core::{CancelToken, Cancelled, LabelVolume, Progress, Volume, Voxels, document::TakenOff};
use rayon::prelude::*;

use crate::{
    alone::air_value,
    class::Class,
    distance::{DEPTH_STEP_MM, DepthField},
    progress::Steps,
    smooth::SmoothDepth,
    thickness::Thickness,
};

/// The share of the work that measuring depths is.
const MEASURING: f64 = 0.7;

/// Of parts thinner than the skin on both sides of them, this share of the depth is skin: an ear keeps its cartilage.
const SKIN_OF_THIN: f32 = 0.4;

/// In depths that are peeled, what parts are thin, and what are thick.
const THIN: f32 = 1.5;
const THICK: f32 = 2.5;

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

/// Values as dense as muscle, in HU: bone and plastic are no skin.
const DENSE_HU: std::ops::Range<f64> = -20.0..200.0;

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
                dense += u64::from(DENSE_HU.contains(&most));
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
    let taken = if spares_thin { TakenOff::Skin(mm) } else { TakenOff::Depth(mm) };
    Ok(volume.with_source_changed(|scan| scan.taken_off = Some(taken)))
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
                if depth >= self.mm + self.smooth.reach_mm() {
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
