//! Slices onto an even grid: left out, moved up, interpolated.

use lumivox_core::{CancelToken, Cancelled, Voxels};
use rayon::prelude::*;

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

/// Makes one slice for each of `sources`: a slice of `voxels`, or nothing but the sample nearest to `empty` where none
/// was given.
pub(crate) fn leave_gaps(voxels: &Voxels, frame_len: usize, sources: &[(usize, f64)], empty: f64) -> Voxels {
    fn pick<T: Copy>(samples: &[T], len: usize, sources: &[(usize, f64)], empty: T) -> Vec<T> {
        let mut out = vec![empty; len * sources.len()];
        for (out, &(slice, part)) in out.chunks_exact_mut(len).zip(sources) {
            if part == 0.0 {
                out.copy_from_slice(&samples[slice * len..][..len]);
            }
        }
        out
    }
    match voxels {
        Voxels::U8(samples) => Voxels::U8(pick(samples, frame_len, sources, empty.round() as u8)),
        Voxels::U16(samples) => Voxels::U16(pick(samples, frame_len, sources, empty.round() as u16)),
        Voxels::F32(samples) => Voxels::F32(pick(samples, frame_len, sources, empty as f32)),
    }
}

/// Makes one slice for each of `sources`: a slice of `voxels` and the part of the way to the next one.
///
/// # Errors
/// On cancel.
pub(crate) fn interpolate(
    voxels: &Voxels,
    frame_len: usize,
    sources: &[(usize, f64)],
    cancel: &CancelToken,
) -> Result<Voxels, Cancelled> {
    Ok(match voxels {
        Voxels::U8(samples) => Voxels::U8(blend(samples, frame_len, sources, cancel, |a, b, t| {
            (f32::from(a) + (f32::from(b) - f32::from(a)) * t + 0.5) as u8
        })?),
        Voxels::U16(samples) => Voxels::U16(blend(samples, frame_len, sources, cancel, |a, b, t| {
            (f32::from(a) + (f32::from(b) - f32::from(a)) * t + 0.5) as u16
        })?),
        // Weighted, so that no difference can overflow.
        Voxels::F32(samples) => {
            Voxels::F32(blend(samples, frame_len, sources, cancel, |a, b, t| a * (1.0 - t) + b * t)?)
        }
    })
}

fn blend<T: Copy + Default + Send + Sync>(
    samples: &[T],
    frame_len: usize,
    sources: &[(usize, f64)],
    cancel: &CancelToken,
    mix: impl Fn(T, T, f32) -> T + Sync,
) -> Result<Vec<T>, Cancelled> {
    let mut out = vec![T::default(); frame_len * sources.len()];
    out.par_chunks_exact_mut(frame_len).zip(sources).try_for_each(|(out, &(slice, part))| {
        cancel.check()?;
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
        let sources = [(0, 0.0), (0, 0.25), (1, 0.5), (2, 0.0)];
        let even = interpolate(&voxels, 2, &sources, &CancelToken::new()).unwrap();
        assert_eq!(even, Voxels::U16(vec![0, 0, 25, 50, 150, 301, 200, 401]));
    }
}
