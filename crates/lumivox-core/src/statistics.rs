//! What values a volume holds: range, histogram, percentiles.
//!
//! Presets for modalities without a fixed scale (MR) place themselves by these numbers; `lumivox info` prints them.

use rayon::prelude::*;

use crate::volume::{Modality, Volume, VolumeError, Voxels};

/// Samples that one task looks at; large enough to make scheduling cheap.
const CHUNK: usize = 1 << 18;

/// Smallest and largest stored sample; an error names the first sample that is not finite.
pub(crate) fn stored_range(voxels: &Voxels) -> Result<[f64; 2], VolumeError> {
    fn fold<T: Copy + PartialOrd + Send + Sync>(v: &[T]) -> [T; 2] {
        v.par_chunks(CHUNK)
            .map(|chunk| {
                let mut range = [chunk[0]; 2];
                for &x in chunk {
                    range[0] = if x < range[0] { x } else { range[0] };
                    range[1] = if x > range[1] { x } else { range[1] };
                }
                range
            })
            .reduce_with(|a, b| {
                [if b[0] < a[0] { b[0] } else { a[0] }, if b[1] > a[1] { b[1] } else { a[1] }]
            })
            .expect("a volume has samples")
    }
    Ok(match voxels {
        Voxels::U8(v) => fold(v).map(f64::from),
        Voxels::U16(v) => fold(v).map(f64::from),
        Voxels::F32(v) => {
            if let Some(bad) = v.par_iter().position_first(|x| !x.is_finite()) {
                return Err(VolumeError::NotFinite(bad));
            }
            fold(v).map(f64::from)
        }
    })
}

/// A histogram of a volume's physical values.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueStatistics {
    /// The physical values that the bins reach from and to: the smallest and the largest, but for those few of
    /// [`ValueStatistics::fine`] that lie far from all others.
    pub range: [f64; 2],
    /// Voxel counts of equal-width bins over `range`.
    pub histogram: Vec<u64>,
}

impl ValueStatistics {
    /// Counts every voxel of `volume` into `bins` bins.
    pub fn new(volume: &Volume, bins: usize) -> Self {
        Self::within(volume, volume.value_range(), bins)
    }

    /// Counts the voxels of `volume` whose values lie in a range into `bins` bins of it.
    pub fn within(volume: &Volume, range: [f64; 2], bins: usize) -> Self {
        Self::count(volume, range, bins, |value| (range[0]..=range[1]).contains(&value))
    }

    /// Counts the voxels whose values are to be counted into `bins` bins of a range, those beyond it into its first and last.
    fn count(volume: &Volume, range: [f64; 2], bins: usize, is_counted: impl Fn(f64) -> bool + Sync) -> Self {
        let bins = bins.max(1);
        let scale = if range[1] > range[0] { bins as f64 / (range[1] - range[0]) } else { 0.0 };
        let bin = |stored: f64| {
            let value = stored * volume.slope() + volume.intercept();
            is_counted(value).then(|| (((value - range[0]) * scale) as usize).min(bins - 1))
        };
        let count = |indices: std::ops::Range<usize>| {
            let mut counts = vec![0u64; bins];
            for i in indices {
                if let Some(bin) = bin(volume.voxels().get(i)) {
                    counts[bin] += 1;
                }
            }
            counts
        };
        let n = volume.voxel_count();
        let histogram = (0..n.div_ceil(CHUNK))
            .into_par_iter()
            .map(|c| count(c * CHUNK..((c + 1) * CHUNK).min(n)))
            .reduce(
                || vec![0; bins],
                |mut a, b| {
                    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                    a
                },
            );
        Self { range, histogram }
    }

    /// As [`Self::new`], of a number of bins that suits: one for each step of integers, if these are not too many. A few voxels
    /// that lie far from all others (hot pixels, metal) do not take the bins from these: they are counted in the first and last.
    pub fn fine(volume: &Volume) -> Self {
        /// Each time the bins are that much finer: no range of floats takes more.
        const MOST_ROUNDS: usize = 16;
        let all = Self::of_range(volume, volume.value_range());
        let mut statistics = all.clone();
        for _ in 0..MOST_ROUNDS {
            let Some(range) = statistics.crowded() else { return statistics };
            statistics = Self::of_range(volume, range);
        }
        // All but the far ones have one value: these are what there is to see.
        all
    }

    /// Counts all voxels into a suitable number of bins of a range.
    fn of_range(volume: &Volume, range: [f64; 2]) -> Self {
        const BINS: usize = 4096;
        let is_float = matches!(volume.voxels(), Voxels::F32(_));
        let steps = ((range[1] - range[0]) / volume.slope().abs()).round();
        let bins = if !is_float && steps < BINS as f64 { steps as usize + 1 } else { BINS };
        Self::count(volume, range, bins, |_| true)
    }

    /// The range of nearly all voxels, where that is but a small part of the whole.
    fn crowded(&self) -> Option<[f64; 2]> {
        /// The share of voxels at each end that may be far from all others.
        const FAR: f64 = 1e-4;
        const PART: usize = 16;
        let total: u64 = self.histogram.iter().sum();
        let spare = (FAR * total as f64) as u64;
        let beyond = |counts: &mut dyn Iterator<Item = &u64>| {
            let mut sum = 0;
            counts
                .take_while(|count| {
                    sum += **count;
                    sum <= spare
                })
                .count()
        };
        let first = beyond(&mut self.histogram.iter());
        let last = self.histogram.len() - beyond(&mut self.histogram.iter().rev());
        // A scan of few integers has no finer bins.
        let is_part = last.saturating_sub(first) * PART < self.histogram.len();
        let value = |bin: usize| self.range[0] + bin as f64 * self.bin_width();
        let range = [value(first), value(last)];
        (is_part && range[0] < range[1]).then_some(range)
    }

    /// The width of a bin; 0 where all values are the same.
    pub fn bin_width(&self) -> f64 {
        (self.range[1] - self.range[0]) / self.histogram.len() as f64
    }

    /// The value in the middle of each bin, and how many voxels have it.
    pub fn bins(&self) -> impl Iterator<Item = (f64, u64)> {
        let width = self.bin_width();
        let value = move |i: usize| self.range[0] + (i as f64 + 0.5) * width;
        self.histogram.iter().enumerate().map(move |(i, &count)| (value(i), count))
    }

    /// The fraction of the voxels, 0 to 1, whose values lie within these, to within a bin.
    pub fn share(&self, [low, high]: [f64; 2]) -> f64 {
        let total: u64 = self.histogram.iter().sum();
        let within: u64 = self.bins().filter(|(value, _)| (low..=high).contains(value)).map(|(_, n)| n).sum();
        within as f64 / total.max(1) as f64
    }

    /// The value below which a fraction `p` (0 to 1) of the voxels lies, to within a bin.
    pub fn percentile(&self, p: f64) -> f64 {
        let total: u64 = self.histogram.iter().sum();
        let target = p.clamp(0.0, 1.0) * total as f64;
        let width = self.bin_width();
        let mut below = 0.0;
        for (i, &count) in self.histogram.iter().enumerate() {
            let count = count as f64;
            if count > 0.0 && below + count >= target {
                return self.range[0] + width * (i as f64 + (target - below) / count);
            }
            below += count;
        }
        self.range[1]
    }

    /// Otsu's threshold (IEEE Trans. SMC 9, 1979): the value that best parts the voxels into two classes. For a scan
    /// in air it lies between the air and the body.
    pub fn otsu_threshold(&self) -> f64 {
        let total: f64 = self.histogram.iter().map(|&c| c as f64).sum();
        let sum: f64 = self.histogram.iter().enumerate().map(|(i, &c)| i as f64 * c as f64).sum();
        let (mut weight, mut partial, mut best) = (0.0, 0.0, -1.0);
        // Where no voxel lies between the classes, every bin of the gap is as good: take its middle.
        let mut best_bins = [0, 0];
        for (i, &count) in self.histogram.iter().enumerate() {
            weight += count as f64;
            partial += i as f64 * count as f64;
            if weight <= 0.0 || weight >= total {
                continue;
            }
            let gap = partial / weight - (sum - partial) / (total - weight);
            let between = weight * (total - weight) * gap * gap;
            if between > best {
                (best, best_bins) = (between, [i, i]);
            } else if between == best {
                best_bins[1] = i;
            }
        }
        self.range[0] + self.bin_width() * ((best_bins[0] + best_bins[1]) as f64 / 2.0 + 1.0)
    }
}

/// Whether a volume is a label map by its looks: nothing says what made it, its values are few integers from 0 on, and
/// mostly those of their neighbours, as no scan's are. Rows all over the volume are looked at.
pub fn looks_like_labels(volume: &Volume) -> bool {
    /// Rows that tell.
    const ROWS: usize = 4096;
    /// More numbers are those of a scan.
    const MOST: usize = 256;
    /// The least share of voxels with a label that have their neighbour's, where there are several labels.
    const ALIKE: f64 = 0.6;
    let integers = !matches!(volume.voxels(), Voxels::F32(_));
    let [low, high] = volume.value_range();
    let plain = volume.slope() == 1.0 && volume.intercept().fract() == 0.0 && low >= 0.0 && high > low;
    if volume.modality() != Modality::Other || !volume.unit().is_empty() || !integers || !plain {
        return false;
    }
    let [nx, ny, nz] = volume.dims();
    let rows = ny * nz;
    let mut seen = std::collections::BTreeSet::new();
    let (mut labelled, mut alike) = (0u64, 0u64);
    for row in (0..rows).step_by(rows.div_ceil(ROWS)) {
        let mut before = None;
        for x in 0..nx {
            let stored = volume.voxels().get(row * nx + x) as u32;
            // What most of a scan is: air, or no label.
            if f64::from(stored) + volume.intercept() == low {
                before = None;
                continue;
            }
            if before != Some(stored) && seen.insert(stored) && seen.len() > MOST {
                return false;
            }
            labelled += u64::from(before.is_some());
            alike += u64::from(before == Some(stored));
            before = Some(stored);
        }
    }
    !seen.is_empty() && (seen.len() == 1 || labelled > 0 && alike as f64 >= ALIKE * labelled as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Modality;
    use glam::DAffine3;

    fn volume(samples: Vec<u16>) -> Volume {
        let n = samples.len();
        let id = DAffine3::IDENTITY;
        Volume::new([n, 1, 1], Voxels::U16(samples), [1.0, -10.0], id, Modality::Other).unwrap()
    }

    #[test]
    fn percentiles_of_a_ramp_are_its_values() {
        let stats = ValueStatistics::new(&volume((0..=1000).collect()), 1000);
        for p in [0.0, 0.25, 0.5, 0.99, 1.0] {
            assert!((stats.percentile(p) - (p * 1000.0 - 10.0)).abs() < 2.0, "{p}: {}", stats.percentile(p));
        }
        assert_eq!(stats.histogram.iter().sum::<u64>(), 1001);
    }

    #[test]
    fn a_few_far_voxels_do_not_take_the_bins_of_all_others() {
        let brain =
            |i: usize| if i.is_multiple_of(3) { 300.0 + (i * 37 % 600) as f32 } else { (i % 9) as f32 };
        let scan = |far: &[f32]| {
            let mut values: Vec<f32> = (0..60_000).map(brain).collect();
            far.iter().enumerate().for_each(|(i, far)| values[7000 * i] = *far);
            let voxels = Voxels::F32(values);
            Volume::new([100, 100, 6], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Mr).unwrap()
        };
        let clean = ValueStatistics::fine(&scan(&[]));
        for far in [&[1e6; 5][..], &[-1e5, 1e30, 2e9], &[-1e9]] {
            let statistics = ValueStatistics::fine(&scan(far));
            assert_eq!(statistics.histogram.iter().sum::<u64>(), 60_000, "{far:?}");
            for p in [0.01, 0.5, 0.75, 0.99] {
                let [found, right] = [&statistics, &clean].map(|statistics| statistics.percentile(p));
                assert!((found - right).abs() < 5.0, "{far:?}, {p}: {found}, not {right}");
            }
            let [found, right] = [&statistics, &clean].map(ValueStatistics::otsu_threshold);
            assert!((found - right).abs() < 30.0, "{far:?}: {found}, not {right}");
        }
        // Integers, that have a bin each.
        let mut samples: Vec<u16> = (0..60_000).map(|i| brain(i) as u16).collect();
        samples[5] = 65_000;
        let statistics = ValueStatistics::fine(&volume(samples));
        assert!((statistics.percentile(0.99) - 870.0).abs() < 30.0, "{}", statistics.percentile(0.99));
        // What is rare is all that there is.
        let mut lesion = vec![0.0; 60_000];
        lesion[..5].copy_from_slice(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        let volume =
            Volume::new([100, 100, 6], Voxels::F32(lesion), [1.0, 0.0], DAffine3::IDENTITY, Modality::Mr);
        assert_eq!(ValueStatistics::fine(&volume.unwrap()).range, [0.0, 5.0]);
    }

    #[test]
    fn otsu_parts_air_from_body() {
        let samples = (0..900).map(|i| i % 20).chain((0..300).map(|i| 500 + i % 50)).collect();
        let threshold = ValueStatistics::new(&volume(samples), 256).otsu_threshold();
        assert!((10.0..490.0).contains(&threshold), "{threshold}");
    }

    #[test]
    fn a_constant_volume_has_statistics() {
        let stats = ValueStatistics::new(&volume(vec![7; 50]), 16);
        assert_eq!(stats.percentile(0.5), -3.0);
        assert_eq!(stats.histogram[0], 50);
    }

    #[test]
    fn label_maps_are_told_from_scans() {
        let new = |values: &dyn Fn(usize, usize) -> u16, modality| {
            let voxels = Voxels::U16((0..64 * 64 * 8).map(|i| values(i % 64, i / 64 % 64)).collect());
            Volume::new([64, 64, 8], voxels, [1.0, 0.0], glam::DAffine3::IDENTITY, modality).unwrap()
        };
        let blocks = |x: usize, y: usize| if y < 9 { 0 } else { 1000 * (x / 16 + y / 20) as u16 };
        assert!(looks_like_labels(&new(&blocks, Modality::Other)));
        assert!(!looks_like_labels(&new(&blocks, Modality::Ct)), "its file says what it is");
        let mask = |x: usize, y: usize| u16::from((x + y).is_multiple_of(3));
        assert!(looks_like_labels(&new(&mask, Modality::Other)), "vessels of one voxel");
        // A scan of 8 bits: a smooth body with noise in air.
        let scan = |x: usize, y: usize| if y < 9 { 0 } else { (100 + (x * 7 + y * 13) % 40) as u16 };
        assert!(!looks_like_labels(&new(&scan, Modality::Other)));
        assert!(!looks_like_labels(&new(&|_, _| 0, Modality::Other)), "nothing");
        let shifted = new(&blocks, Modality::Other).edit(|_| {}).unwrap();
        assert!(looks_like_labels(&shifted));
        assert!(!looks_like_labels(&shifted.with_unit("Gy")));
    }
}
