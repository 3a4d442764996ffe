//! The patient without the skin, or what lies deeper.

use std::sync::atomic::{AtomicUsize, Ordering};

use lumivox_core::{CancelToken, Cancelled, LabelVolume, Progress, Volume, Voxels};
use rayon::prelude::*;

use crate::{
    alone::air_value,
    class::Class,
    distance::{DEPTH_STEP_MM, DepthField},
    progress::Steps,
};

/// The share of the work that measuring depths is.
const MEASURING: f64 = 0.7;

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
    let steps = Steps::first(progress, MEASURING);
    let depth = crate::depths(&volume, labels, &steps, cancel)?;
    // Of each label and depth, the share of a voxel that is left.
    let width = volume.spacing_mm().min_element().max(f64::from(DEPTH_STEP_MM));
    let mm = mm.min(f64::from(DepthField::MOST_MM));
    let left: Vec<f64> = (0..=255u8)
        .map(|step| ((f64::from(step) * f64::from(DEPTH_STEP_MM) - mm) / width + 0.5).clamp(0.0, 1.0))
        .collect();
    let share = |label: u8, depth: u8| match Class::of(label) {
        Some(Class::Air) => 0.0,
        Some(class) if class.is_patient() => left[usize::from(depth)],
        _ => 1.0,
    };
    let air = (air_value(&volume, labels) - volume.intercept()) / volume.slope();
    let mut result = Ok(());
    let volume = volume
        .edit(|voxels| {
            let work = Peeling { labels: labels.voxels(), depths: depth.steps(), share: &share, air };
            let step = |part: f64| steps.report_rest(0.95 * part);
            let chunk = labels.dims()[0] * labels.dims()[1];
            result = match voxels {
                Voxels::U8(all) => work.run(all, chunk, |v| v.round() as u8, cancel, &step),
                Voxels::U16(all) => work.run(all, chunk, |v| v.round() as u16, cancel, &step),
                Voxels::F32(all) => work.run(all, chunk, |v| v as f32, cancel, &step),
            };
        })
        .expect("values between those of a volume make one");
    result?;
    steps.report_rest(1.0);
    Ok(volume)
}

struct Peeling<'a> {
    labels: &'a [u8],
    depths: &'a [u8],
    share: &'a (dyn Fn(u8, u8) -> f64 + Sync),
    /// As it is stored.
    air: f64,
}

impl Peeling<'_> {
    fn run<T: Copy + Into<f64> + Send>(
        &self,
        samples: &mut [T],
        chunk: usize,
        from_f64: impl Fn(f64) -> T + Sync,
        cancel: &CancelToken,
        step: &(dyn Fn(f64) + Sync),
    ) -> Result<(), Cancelled> {
        let (done, count) = (AtomicUsize::new(0), samples.len() / chunk);
        let known = self.labels.par_chunks(chunk).zip(self.depths.par_chunks(chunk));
        samples.par_chunks_mut(chunk).zip(known).try_for_each(|(samples, (labels, depths))| {
            cancel.check()?;
            for ((sample, &label), &depth) in samples.iter_mut().zip(labels).zip(depths) {
                let share = (self.share)(label, depth);
                if share < 1.0 {
                    *sample = from_f64(self.air + ((*sample).into() - self.air) * share);
                }
            }
            step((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count as f64);
            Ok(())
        })
    }
}
