//! Depth below the skin as a volume, for what peels while it is looked at.

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{CancelToken, Cancelled, LabelVolume, Modality, Progress, Volume, Voxels};
use rayon::prelude::*;

use crate::{distance::DEPTH_STEP_MM, progress::Steps, smooth::SmoothDepth};

/// The share of the work that measuring depths is.
const MEASURING: f64 = 0.7;

/// Depths are kept at about this spacing: they are smooth.
const SPACING_MM: f64 = 1.2;

/// Stored units per mm.
const UNITS_PER_MM: f64 = 256.0;

/// How deep below the body's outer surface, in mm, by the labels that [`segment`](crate::segment) found: smooth, so that what
/// is peeled by it has no stairs, and on a grid of its own, of about 1.2 mm or the scan's voxels. 0 outside of the body;
/// depths of [`DepthField::MOST_MM`](crate::DepthField::MOST_MM) and more are not told apart. What
/// [`Peel::depth`](lumivox_core::Peel) wants.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// When the labels are of another grid than the scan's.
pub fn skin_depth(
    volume: &Volume,
    labels: &LabelVolume,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    let steps = Steps::first(progress, MEASURING);
    let depth = crate::depths(volume, labels, &steps, cancel)?;
    let smooth = SmoothDepth::new(volume, &depth, cancel)?;
    let from_smooth = Straight::new(&smooth);
    let strides = volume.spacing_mm().to_array().map(|mm| ((SPACING_MM / mm).round() as usize).max(1));
    let dims: [usize; 3] = std::array::from_fn(|axis| volume.dims()[axis].div_ceil(strides[axis]));
    let [nx, ny, _] = dims;
    let mut samples = vec![0u16; dims.iter().product()];
    samples.par_chunks_mut(nx * ny).enumerate().try_for_each(|(z, layer)| {
        cancel.check()?;
        for (i, sample) in layer.iter_mut().enumerate() {
            let at = [i % nx * strides[0], i / nx * strides[1], z * strides[2]];
            // Outside, smoothing leaves what is not there.
            let mm = if depth.mm(at) > 0.0 { from_smooth.mm(smooth.mm(at)) } else { 0.0 };
            *sample = (f64::from(mm) * UNITS_PER_MM).round() as u16;
        }
        Ok(())
    })?;
    steps.report_rest(1.0);
    let place = volume.patient_from_voxel()
        * DAffine3::from_scale(DVec3::from_array(strides.map(|stride| stride as f64)));
    let rescale = [1.0 / UNITS_PER_MM, 0.0];
    let made = Volume::new(dims, Voxels::U16(samples), rescale, place, Modality::Other);
    Ok(made.expect("a grid of whole voxels of the scan's").with_unit("mm"))
}

/// What smoothing makes of depths below a plane, the other way round.
struct Straight {
    /// Smoothed depths of multiples of [`DEPTH_STEP_MM`].
    smoothed: Vec<f32>,
}

impl Straight {
    fn new(smooth: &SmoothDepth) -> Self {
        let steps = (smooth.reach_mm() / DEPTH_STEP_MM).ceil() as usize + 1;
        Self { smoothed: (0..=steps).map(|i| smooth.below_plane(i as f32 * DEPTH_STEP_MM)[0]).collect() }
    }

    fn mm(&self, smoothed: f32) -> f32 {
        let next = self.smoothed.partition_point(|depth| *depth <= smoothed);
        if next == self.smoothed.len() {
            // Deeper than smoothing reaches, means of planes are the depths themselves.
            return smoothed;
        }
        let Some(before) = next.checked_sub(1) else { return 0.0 };
        let [low, high] = [self.smoothed[before], self.smoothed[next]];
        (before as f32 + (smoothed - low) / (high - low)) * DEPTH_STEP_MM
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Class, depth_below_skin};

    /// A block of body in air: depths below its faces are distances from them.
    #[test]
    fn depths_are_straight_smooth_and_zero_outside() {
        let dims = [40, 36, 48];
        let class = |i: usize| {
            let at = [i % 40, i / 40 % 36, i / 1440];
            let inside = (0..3).all(|axis| (8..dims[axis] - 8).contains(&at[axis]));
            if inside { Class::Body } else { Class::Air }
        };
        let labels: Vec<u8> = (0..dims.iter().product()).map(|i| class(i).value()).collect();
        let place = DAffine3::from_scale(DVec3::splat(0.6));
        let table = Class::ALL.map(Class::label).to_vec();
        let labels = LabelVolume::new(dims, labels, place, table).unwrap();
        let voxels = Voxels::U8(vec![0; dims.iter().product()]);
        let volume = Volume::new(dims, voxels, [1.0, 0.0], place, Modality::Ct).unwrap();
        let cancel = CancelToken::new();
        let depth = skin_depth(&volume, &labels, Progress::SILENT, &cancel).unwrap();
        assert_eq!(depth.dims(), [20, 18, 24]);
        assert_eq!(depth.value([2, 9, 12]), 0.0);
        let exact = depth_below_skin(&volume, &labels, Progress::SILENT, &cancel).unwrap();
        // As far as the ridge between two faces, which smoothing rounds off.
        for x in 4..8 {
            let found = depth.value([x, 9, 12]);
            let wanted = f64::from(exact.mm([2 * x, 18, 24]));
            assert!((found - wanted).abs() < 0.35, "{x}: {found} {wanted}");
        }
        let stopped = CancelToken::new();
        stopped.cancel();
        assert!(skin_depth(&volume, &labels, Progress::SILENT, &stopped).is_err());
    }
}
