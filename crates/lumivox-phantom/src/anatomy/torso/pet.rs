//! The torso as a PET sees it, an hour after FDG was given: uptake by organ, and lesions that only it shows.
//!
//! Values are usual ones of adults (Zincirkeser et al., *Standardized uptake values of normal organs on 18F-FDG PET/CT*,
//! J Int Med Res 2007), for a patient who has fasted for a while: the heart takes up less than it can.

use glam::DVec3;
use lumivox_core::{CancelToken, Cancelled, Modality, Progress, Volume, Voxels, WorkStage};
use rayon::prelude::*;

use super::{TorsoOptions, TorsoPart, torso_parts};
use crate::maths;
use crate::noise::gaussian;

/// SUV of a stored 1: 16 bits reach 65.
const SUV_STEP: f64 = 1e-3;

/// Full width at half maximum of what a scanner makes of a point, in mm.
const BLUR_MM: f64 = 6.0;

/// Noise before it is blurred, as a part of the root of an SUV.
const NOISE: f32 = 0.35;

/// What takes up much and is too small, or too like its surroundings, for CT.
pub(super) struct Lesion {
    /// Where, in patient mm.
    pub at: DVec3,
    /// Its radius, in mm.
    pub radius_mm: f64,
    /// Its uptake.
    pub suv: f64,
}

/// A tumour of the right lung, nodes beside the windpipe and at the root of the lung, and metastases in the liver.
pub(super) const LESIONS: [Lesion; 5] = [
    Lesion { at: DVec3::new(-88.0, 25.0, 70.0), radius_mm: 13.0, suv: 14.0 },
    Lesion { at: DVec3::new(-22.0, 22.0, 88.0), radius_mm: 8.0, suv: 10.0 },
    Lesion { at: DVec3::new(-38.0, 26.0, 52.0), radius_mm: 9.0, suv: 11.0 },
    Lesion { at: DVec3::new(-80.0, 5.0, -72.0), radius_mm: 10.0, suv: 9.0 },
    Lesion { at: DVec3::new(-52.0, 40.0, -95.0), radius_mm: 7.0, suv: 8.5 },
];

/// The SUV of a part.
fn uptake(part: TorsoPart) -> f32 {
    use TorsoPart::*;
    match part {
        Padding | OutsideAir | Table | Mattress | Blanket | Metal | AirwayAir | GutGas => 0.0,
        Lung => 0.45,
        Fat => 0.3,
        Skin | Cartilage => 0.5,
        Muscle | AirwayWall => 0.7,
        Gland | SoftTissue | Gallbladder => 0.8,
        Bone => 1.1,
        SpinalCanal => 1.3,
        PulmonaryArtery | PulmonaryVein | Artery | Vein => 1.6,
        Pancreas => 1.5,
        Gut => 1.7,
        Spleen => 1.9,
        Liver => 2.2,
        Myocardium => 7.5,
        Kidney => 8.0,
    }
}

/// The torso of these options as an FDG PET: its voxels are SUV (body weight), on the grid that [`torso`](super::torso) has
/// with as many. Table and blanket take up nothing; noise is that of PET, whatever [`TorsoOptions::noise_hu`] says, unless
/// that is 0.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// As [`torso`](super::torso).
pub fn torso_pet(
    options: TorsoOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    let parts = torso_parts(options, progress, cancel)?;
    let place = options.place();
    let n = options.size;
    let noise = if options.noise_hu > 0.0 { NOISE } else { 0.0 };
    let mut suv = vec![0f32; parts.len()];
    suv.par_chunks_mut(n * n).enumerate().try_for_each(|(z, slice)| {
        cancel.check()?;
        for (i, suv) in slice.iter_mut().enumerate() {
            let index = z * n * n + i;
            let at = place.transform_point3(DVec3::from_array([i % n, i / n, z].map(|k| k as f64)));
            let part = TorsoPart::from_number(parts[index]).unwrap_or(TorsoPart::OutsideAir);
            let lesion = LESIONS.iter().filter(|lesion| lesion.at.distance(at) < lesion.radius_mm);
            let lesion = lesion.map(|lesion| lesion.suv as f32).fold(0.0, f32::max);
            let clean = uptake(part).max(lesion);
            // Reconstruction leaves a little noise where there is nothing.
            *suv = clean + noise * (clean + 0.02).sqrt() * gaussian(options.seed, index as u64);
        }
        Ok::<_, Cancelled>(())
    })?;
    // A Gaussian along each axis.
    let sigma = BLUR_MM / 2.355 / options.spacing();
    for stride in [1, n, n * n] {
        cancel.check()?;
        suv = blurred(&suv, n, stride, sigma);
    }
    progress.report(WorkStage::Generating, 1, 1);
    let stored = suv.into_par_iter().map(|v| (f64::from(v) / SUV_STEP).round().clamp(0.0, 65535.0) as u16);
    let voxels = Voxels::U16(stored.collect());
    let volume = Volume::new([n; 3], voxels, [SUV_STEP, 0.0], place, Modality::Pet);
    Ok(volume.expect("a cube of finite samples").with_unit("SUV"))
}

/// Evened out along the axis whose neighbours lie `stride` apart, by a Gaussian of so many voxels; beyond the cube its
/// last voxel goes on.
fn blurred(from: &[f32], n: usize, stride: usize, sigma: f64) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil().max(1.0) as usize;
    let weight = |i: usize| maths::exp(-0.5 * (i as f64 / sigma.max(1e-6)).powi(2));
    let sum = weight(0) + 2.0 * (1..=reach).map(weight).sum::<f64>();
    let weights: Vec<f32> = (0..=reach).map(|i| (weight(i) / sum) as f32).collect();
    (0..from.len())
        .into_par_iter()
        .map(|index| {
            let place = index / stride % n;
            let at = |k: usize| from[index - place * stride + k * stride];
            let both = |i: usize| at(place.saturating_sub(i)) + at((place + i).min(n - 1));
            weights[0] * from[index] + (1..=reach).map(|i| weights[i] * both(i)).sum::<f32>()
        })
        .collect()
}
