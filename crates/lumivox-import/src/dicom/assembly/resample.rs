//! Slices onto an even grid: left out, moved up, interpolated.

use lumivox_core::{CancelToken, Cancelled, Voxels};
use rayon::prelude::*;

use crate::dicom::{assembly::convert::join, series::gaps::GridSource};

/// Drops the slices whose flag is false.
pub(crate) fn keep_slices(voxels: Voxels, frame_len: usize, keep: &[bool]) -> Voxels {
    fn compact<T: Copy>(mut samples: Vec<T>, frame_len: usize, keep: &[bool]) -> Vec<T> {
        let mut kept = 0;
        for (slice, _) in keep.iter().enumerate().filter(|(_, keep)| **keep) {
            samples.copy_within(slice * frame_len..(slice + 1) * frame_len, kept * frame_len);
            kept += 1;
        }
        samples.truncate(kept * frame_len);
        samples
    }
    match voxels {
        Voxels::U8(samples) => Voxels::U8(compact(samples, frame_len, keep)),
        Voxels::U16(samples) => Voxels::U16(compact(samples, frame_len, keep)),
        Voxels::F32(samples) => Voxels::F32(compact(samples, frame_len, keep)),
    }
}

/// Sets all samples of the slices whose flag is true to the one nearest to `empty`.
pub(crate) fn clear(mut voxels: Voxels, frame_len: usize, damaged: &[bool], empty: f64) -> Voxels {
    fn fill<T: Copy>(samples: &mut [T], frame_len: usize, damaged: &[bool], empty: T) {
        let slices = samples.chunks_exact_mut(frame_len).zip(damaged);
        slices.filter(|(_, damaged)| **damaged).for_each(|(slice, _)| slice.fill(empty));
    }
    match &mut voxels {
        Voxels::U8(samples) => fill(samples, frame_len, damaged, empty.round() as u8),
        Voxels::U16(samples) => fill(samples, frame_len, damaged, empty.round() as u16),
        Voxels::F32(samples) => fill(samples, frame_len, damaged, empty as f32),
    }
    voxels
}

/// The lowest and the highest sample of the slices whose flag is false.
pub(crate) fn measured_range(voxels: &Voxels, frame_len: usize, damaged: &[bool]) -> Option<[f64; 2]> {
    let whole = (0..damaged.len()).filter(|&slice| !damaged[slice]);
    let samples = whole.flat_map(|slice| slice * frame_len..(slice + 1) * frame_len);
    samples.map(|i| [voxels.get(i); 2]).reduce(join)
}

/// Makes one slice for each of `sources`: a slice of `voxels` and the part of the way to the next one, or nothing but
/// the sample nearest to `empty`.
///
/// # Errors
/// On cancel.
pub(crate) fn resample(
    voxels: &Voxels,
    frame_len: usize,
    sources: &[GridSource],
    empty: f64,
    cancel: &CancelToken,
) -> Result<Voxels, Cancelled> {
    Ok(match voxels {
        Voxels::U8(samples) => {
            let mix = |a, b, t| (f32::from(a) + (f32::from(b) - f32::from(a)) * t + 0.5) as u8;
            Voxels::U8(blend(samples, frame_len, sources, empty.round() as u8, cancel, mix)?)
        }
        Voxels::U16(samples) => {
            let mix = |a, b, t| (f32::from(a) + (f32::from(b) - f32::from(a)) * t + 0.5) as u16;
            Voxels::U16(blend(samples, frame_len, sources, empty.round() as u16, cancel, mix)?)
        }
        Voxels::F32(samples) => {
            // Weighted, so that no difference can overflow.
            let mix = |a, b, t| a * (1.0 - t) + b * t;
            Voxels::F32(blend(samples, frame_len, sources, empty as f32, cancel, mix)?)
        }
    })
}

fn blend<T: Copy + Send + Sync>(
    samples: &[T],
    frame_len: usize,
    sources: &[GridSource],
    empty: T,
    cancel: &CancelToken,
    mix: impl Fn(T, T, f32) -> T + Sync,
) -> Result<Vec<T>, Cancelled> {
    let mut out = vec![empty; frame_len * sources.len()];
    out.par_chunks_exact_mut(frame_len).zip(sources).try_for_each(|(out, source)| {
        cancel.check()?;
        let Some((slice, part)) = *source else { return Ok(()) };
        let lower = &samples[slice * frame_len..][..frame_len];
        if part == 0.0 {
            out.copy_from_slice(lower);
        } else {
            let upper = &samples[(slice + 1) * frame_len..][..frame_len];
            for ((out, &a), &b) in out.iter_mut().zip(lower).zip(upper) {
                *out = mix(a, b, part as f32);
            }
        }
        Ok(())
    })?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_are_kept_and_interpolated() {
        let voxels = Voxels::U16(vec![0, 0, 100, 200, 9, 9, 200, 401]);
        let voxels = keep_slices(voxels, 2, &[true, true, false, true]);
        assert_eq!(voxels, Voxels::U16(vec![0, 0, 100, 200, 200, 401]));
        let sources = [Some((0, 0.0)), Some((0, 0.25)), Some((1, 0.5)), None, Some((2, 0.0))];
        let even = resample(&voxels, 2, &sources, 7.0, &CancelToken::new()).unwrap();
        assert_eq!(even, Voxels::U16(vec![0, 0, 25, 50, 150, 301, 7, 7, 200, 401]));
        let cleared = clear(voxels.clone(), 2, &[false, true, false], 7.0);
        assert_eq!(cleared, Voxels::U16(vec![0, 0, 7, 7, 200, 401]));
        assert_eq!(measured_range(&voxels, 2, &[true, false, false]), Some([100.0, 401.0]));
        assert_eq!(measured_range(&voxels, 2, &[true; 3]), None);
    }
}
