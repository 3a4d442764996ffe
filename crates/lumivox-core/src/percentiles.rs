//! Percentiles that are exact: values that voxels really have.

use rayon::prelude::*;

use crate::volume::{Volume, Voxels};

/// Samples that one task looks at.
const CHUNK: usize = 1 << 18;
/// Numbers that half of a sample's bits make.
const HALF: usize = 1 << 16;

impl Volume {
    /// The physical values at or below which fractions (0 to 1) of the voxels lie: of each the smallest that a voxel has.
    pub fn percentiles(&self, fractions: &[f64]) -> Vec<f64> {
        let count = self.voxel_count() as u64;
        let of_stored = |fraction: f64| {
            let rank = (fraction.clamp(0.0, 1.0) * count as f64).ceil() as u64;
            let rank = rank.clamp(1, count) - 1;
            // Of a scale that turns values around, the highest sample is the lowest.
            if self.slope() < 0.0 { count - 1 - rank } else { rank }
        };
        let ranks: Vec<u64> = fractions.iter().map(|fraction| of_stored(*fraction)).collect();
        let stored: Vec<f64> = match self.voxels() {
            Voxels::U8(samples) => whole(&ranks, samples, |sample| sample.into()),
            Voxels::U16(samples) => whole(&ranks, samples, |sample| sample.into()),
            Voxels::F32(samples) => floats(&ranks, samples),
        };
        stored.into_iter().map(|stored| stored * self.slope() + self.intercept()).collect()
    }
}

/// The samples of these ranks.
fn whole<T: Copy + Sync>(ranks: &[u64], samples: &[T], number: impl Fn(T) -> usize + Sync) -> Vec<f64> {
    let counts = counts(samples, |sample| Some(number(sample)));
    ranks.iter().map(|rank| at(&counts, *rank).0 as f64).collect()
}

/// As [`whole`]: by the upper half of their bits, then by the lower of those that have the same upper one.
fn floats(ranks: &[u64], samples: &[f32]) -> Vec<f64> {
    let uppers = counts(samples, |sample| Some((ordered(sample) >> 16) as usize));
    let mut last: Option<(usize, Vec<u64>)> = None;
    ranks
        .iter()
        .map(|rank| {
            let (upper, rest) = at(&uppers, *rank);
            let lowers = match last.take() {
                Some((own, lowers)) if own == upper => lowers,
                _ => counts(samples, |sample| {
                    let bits = ordered(sample) as usize;
                    (bits >> 16 == upper).then_some(bits % HALF)
                }),
            };
            let (lower, _) = at(&lowers, rest);
            last = Some((upper, lowers));
            f64::from(float((upper << 16 | lower) as u32))
        })
        .collect()
}

fn counts<T: Copy + Sync>(samples: &[T], number: impl Fn(T) -> Option<usize> + Sync) -> Vec<u64> {
    let of_chunk = |chunk: &[T]| {
        let mut counts = vec![0u64; HALF];
        chunk.iter().filter_map(|sample| number(*sample)).for_each(|number| counts[number] += 1);
        counts
    };
    let sum = |mut a: Vec<u64>, b: Vec<u64>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    samples.par_chunks(CHUNK).map(of_chunk).reduce(|| vec![0; HALF], sum)
}

/// The number of a rank, and its rank among those that are the same.
fn at(counts: &[u64], mut rank: u64) -> (usize, u64) {
    for (number, count) in counts.iter().enumerate() {
        if rank < *count {
            return (number, rank);
        }
        rank -= count;
    }
    (counts.len() - 1, 0)
}

/// Bits that are in the order of their floats.
fn ordered(sample: f32) -> u32 {
    let bits = sample.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

fn float(ordered: u32) -> f32 {
    f32::from_bits(if ordered >> 31 == 1 { ordered & !(1 << 31) } else { !ordered })
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::volume::Modality;

    fn percentiles(voxels: Voxels, rescale: [f64; 2], fractions: &[f64]) -> Vec<f64> {
        let dims = [voxels.len(), 1, 1];
        let volume = Volume::new(dims, voxels, rescale, DAffine3::IDENTITY, Modality::Other);
        volume.unwrap().percentiles(fractions)
    }

    #[test]
    fn percentiles_are_values_that_occur() {
        let mask = |i: usize| u8::from(i.is_multiple_of(4));
        let of = [0.0, 0.25, 0.5, 0.75, 0.76, 1.0];
        let right = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0];
        assert_eq!(percentiles(Voxels::U8((0..1000).map(mask).collect()), [1.0, 0.0], &of), right);
        let floats = (0..1000).map(|i| mask(i).into()).collect();
        assert_eq!(percentiles(Voxels::F32(floats), [1.0, 0.0], &of), right);
        let turned = (0..1000).map(mask).collect();
        assert_eq!(percentiles(Voxels::U8(turned), [-1.0, 1.0], &[0.25, 0.26]), [0.0, 1.0]);
        // Both signs, and one far from all others.
        let mut values: Vec<f32> = (0..999).map(|i| (i * 37 % 999) as f32 / 8.0 - 50.0).collect();
        values.push(1e30);
        let found = percentiles(Voxels::F32(values.clone()), [1.0, 0.0], &of);
        values.sort_by(f32::total_cmp);
        assert_eq!(found, [0, 249, 499, 749, 759, 999].map(|rank| f64::from(values[rank])));
    }
}
