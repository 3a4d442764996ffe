//! One organ alone: what looks at the airways and at the vessels of the lungs need, whose values the body has elsewhere, too.

use lumivox_core::{
    CancelToken, Cancelled, LabelVolume, Organ, Progress, Volume, Voxels, document::TakenOff,
};
use rayon::prelude::*;

use crate::{class::Class, progress::Steps};

/// What is air, and what the haze of a lung is, in HU.
const AIR_HU: f64 = -1000.0;
const LUNG_HU: f64 = -850.0;

/// What airways become, in HU: as solid as bone.
const CAST_HU: f64 = 600.0;

/// Vessels at the root of a lung that are thicker than twice this are not of it, in mm.
const ROOT_MM: f64 = 4.0;

/// Below the surface of a lung lie voxels that are chest wall in part, so deep in mm.
const PLEURA_MM: f64 = 2.5;

/// The wall of an airway is no thicker than this, in mm.
const WALL_MM: f64 = 2.5;

/// The compact bone of ribs, which blood with contrast agent is not as dense as, in HU; and how far the rest of a rib
/// lies from it, in mm. A closing takes their heads beside the spine in.
const BONE_HU: f64 = 500.0;
const RIB_MM: f64 = 5.0;

/// Whether labels hold enough of what an organ is shown by.
pub fn has_organ(labels: &LabelVolume, organ: Organ) -> bool {
    /// The windpipe of a child is larger.
    const AIRWAYS_MM3: f64 = 1500.0;
    const LUNGS_MM3: f64 = 100_000.0;
    let counts = labels.counts();
    let mm3 = |class: Class| counts[usize::from(class.value())] as f64 * labels.voxel_mm3();
    match organ {
        Organ::Airways => mm3(Class::Airways) >= AIRWAYS_MM3,
        Organ::LungVessels => mm3(Class::Lungs) >= LUNGS_MM3,
        _ => false,
    }
}

/// One organ of a CT alone, or `None` where it is not found for sure: [`segment`](crate::segment), [`has_organ`] and
/// [`organ_alone`] in one, for hosts that show a look of [`Preset::organ`](lumivox_core::Preset::organ).
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
pub fn find_organ(
    volume: &Volume,
    organ: Organ,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Option<Volume>, Cancelled> {
    /// The share of the work that finding is.
    const FINDING: f64 = 0.8;
    let steps = Steps::first(progress, FINDING);
    let (labels, report) = crate::labels_of(volume, &steps, cancel)?;
    if !report.is_sure() || !has_organ(&labels, organ) {
        steps.report_rest(1.0);
        return Ok(None);
    }
    alone(volume.clone(), &labels, organ, &|part| steps.report_rest(part), cancel).map(Some)
}

/// One organ of a CT, by the labels that [`segment`](crate::segment) or [`patient_alone`](crate::patient_alone) found in
/// it, in a haze of the lungs; all else is air. Airways become a cast, as dense as bone; vessels of the lungs keep their
/// values.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// When the labels are of another grid than the scan's.
pub fn organ_alone(
    volume: Volume,
    labels: &LabelVolume,
    organ: Organ,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    let steps = Steps::new(progress);
    alone(volume, labels, organ, &|part| steps.report(0.0, 1.0, part), cancel)
}

fn alone(
    volume: Volume,
    labels: &LabelVolume,
    organ: Organ,
    done: &dyn Fn(f64),
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    assert_eq!(volume.dims(), labels.dims(), "labels of another grid");
    let voxels = |mm: f64| volume.spacing_mm().to_array().map(|spacing| (mm / spacing).round() as usize);
    let of = |classes: &[Class]| -> Vec<u8> {
        let is_in =
            |&label: &u8| if classes.iter().any(|class| class.value() == label) { u8::MAX } else { 0 };
        labels.voxels().par_iter().map(is_in).collect()
    };
    let dims = labels.dims();
    let spread = |mask: Vec<u8>, mm: f64| spread(&mask, dims, voxels(mm), cancel);
    let airways = of(&[Class::Airways]);
    let lungs = of(&[Class::Lungs, Class::Airways]);
    done(0.1);
    let shares = match organ {
        Organ::Airways => airways,
        _ => {
            // A closing takes the vessels at the root in; what is near its border goes.
            let outside = inverted(spread(lungs.clone(), ROOT_MM)?);
            let outside = spread(outside, ROOT_MM + PLEURA_MM)?;
            done(0.5);
            let walls = spread(airways, WALL_MM)?;
            let bone = (BONE_HU - volume.intercept()) / volume.slope();
            let is_bone = |at: usize| {
                let stored = volume.voxels().get(at);
                // Slopes may be negative.
                if (stored > bone) == (volume.slope() > 0.0) { u8::MAX } else { 0 }
            };
            let ribs = spread((0..volume.voxel_count()).into_par_iter().map(is_bone).collect(), RIB_MM)?;
            let is_in = |((&outside, &wall), &rib): ((&u8, &u8), &u8)| match outside | wall | rib {
                0 => u8::MAX,
                _ => 0,
            };
            outside.par_iter().zip(&walls).zip(&ribs).map(is_in).collect()
        }
    };
    done(0.7);
    let shares = smoothed(&smoothed(&shares, dims, cancel)?, dims, cancel)?;
    done(0.9);
    let (slope, intercept) = (volume.slope(), volume.intercept());
    let [low, high] = volume.value_range();
    let value = |stored: f64, at: usize| {
        let hu = stored * slope + intercept;
        let haze = if lungs[at] == 0 { AIR_HU } else { LUNG_HU };
        let own = if organ == Organ::Airways { CAST_HU } else { hu.max(haze) };
        let share = f64::from(shares[at]) / f64::from(u8::MAX);
        ((haze + (own - haze) * share).clamp(low, high) - intercept) / slope
    };
    let volume = volume.edit(|voxels| match voxels {
        Voxels::U8(all) => {
            all.par_iter_mut().enumerate().for_each(|(at, v)| *v = value(f64::from(*v), at).round() as u8)
        }
        Voxels::U16(all) => {
            all.par_iter_mut().enumerate().for_each(|(at, v)| *v = value(f64::from(*v), at).round() as u16);
        }
        Voxels::F32(all) => {
            all.par_iter_mut().enumerate().for_each(|(at, v)| *v = value(f64::from(*v), at) as f32);
        }
    });
    done(1.0);
    let volume = volume.expect("values within those of a volume make one");
    Ok(volume.with_source_changed(|scan| scan.taken_off = Some(TakenOff::AllBut(organ))))
}

fn inverted(mut mask: Vec<u8>) -> Vec<u8> {
    mask.par_iter_mut().for_each(|voxel| *voxel = !*voxel);
    mask
}

/// A mask, and all that is no more than `reach` voxels away from it along each axis.
fn spread(
    mask: &[u8],
    dims: [usize; 3],
    reach: [usize; 3],
    cancel: &CancelToken,
) -> Result<Vec<u8>, Cancelled> {
    let along = |from: &[u8], axis: usize| {
        combined(from, dims, axis, reach[axis], cancel, |into, from| {
            into.iter_mut().zip(from).for_each(|(into, from)| *into |= from);
        })
    };
    along(&along(&along(mask, 0)?, 1)?, 2)
}

/// Shares of a mask, evened out with the neighbours' by weights of 1, 2 and 1 along each axis.
fn smoothed(shares: &[u8], dims: [usize; 3], cancel: &CancelToken) -> Result<Vec<u8>, Cancelled> {
    let mut shares = shares.to_vec();
    let [nx, ny, nz] = dims;
    for stride in [(1, nx), (nx, ny), (nx * ny, nz)] {
        let (stride, n) = stride;
        cancel.check()?;
        let before = shares.clone();
        shares.par_iter_mut().enumerate().for_each(|(at, share)| {
            let place = at / stride % n;
            let own = before[at];
            let low = if place > 0 { before[at - stride] } else { own };
            let high = if place + 1 < n { before[at + stride] } else { own };
            if low != own || high != own {
                *share = ((u16::from(low) + 2 * u16::from(own) + u16::from(high) + 2) / 4) as u8;
            }
        });
    }
    Ok(shares)
}

/// What `combine` makes of each row with those up to `reach` before and behind it along an axis.
fn combined(
    from: &[u8],
    [nx, ny, nz]: [usize; 3],
    axis: usize,
    reach: usize,
    cancel: &CancelToken,
    combine: impl Fn(&mut [u8], &[u8]) + Sync,
) -> Result<Vec<u8>, Cancelled> {
    let mut all = from.to_vec();
    if reach == 0 {
        return Ok(all);
    }
    let slice_len = nx * ny;
    all.par_chunks_mut(slice_len).enumerate().try_for_each(|(z, slice)| {
        cancel.check()?;
        for (y, row) in slice.chunks_exact_mut(nx).enumerate() {
            let at = z * slice_len + y * nx;
            match axis {
                0 => {
                    let own = &from[at..at + nx];
                    for shift in 1..=reach.min(nx - 1) {
                        combine(&mut row[shift..], &own[..nx - shift]);
                        combine(&mut row[..nx - shift], &own[shift..]);
                    }
                }
                1 => {
                    for near in y.saturating_sub(reach)..(y + reach + 1).min(ny) {
                        combine(row, &from[z * slice_len + near * nx..][..nx]);
                    }
                }
                _ => {
                    for near in z.saturating_sub(reach)..(z + reach + 1).min(nz) {
                        combine(row, &from[near * slice_len + y * nx..][..nx]);
                    }
                }
            }
        }
        Ok(())
    })?;
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_spread_as_far_as_they_are_told() {
        let dims = [7, 6, 5];
        let mut mask = vec![0; 7 * 6 * 5];
        mask[(2 * 6 + 3) * 7 + 2] = u8::MAX;
        let spread = spread(&mask, dims, [2, 1, 0], &CancelToken::new()).unwrap();
        for (at, &voxel) in spread.iter().enumerate() {
            let [x, y, z] = [at % 7, at / 7 % 6, at / 42];
            assert_eq!(voxel > 0, x <= 4 && (2..=4).contains(&y) && z == 2, "{x} {y} {z}");
        }
        let cancel = CancelToken::new();
        cancel.cancel();
        assert!(super::spread(&mask, dims, [1; 3], &cancel).is_err());
    }

    #[test]
    fn evening_out_keeps_what_is_even() {
        let even = smoothed(&[200; 27], [3; 3], &CancelToken::new()).unwrap();
        assert_eq!(even, [200; 27]);
        let mut one = vec![0; 27];
        one[13] = 255;
        let one = smoothed(&one, [3; 3], &CancelToken::new()).unwrap();
        assert_eq!([one[13], one[12], one[0]], [32, 16, 4]);
    }
}
