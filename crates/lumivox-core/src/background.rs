//! What most of a scan is: the value of nothing, on one side of which, or on both, lies what was measured.

use crate::statistics::ValueStatistics;

/// Standard deviations within which a value is the background's noise.
const NOISE_SIGMAS: f64 = 4.0;

/// The commonest value of a scan, and how far its noise reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background {
    /// The commonest value, to within half a bin of the statistics.
    pub value: f64,
    /// Values that differ by less are noise of it.
    pub noise: f64,
    /// The fraction of the voxels within that noise, 0 to 1.
    pub share: f64,
}

/// What lies on one side of a background.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Side {
    /// The fraction of the voxels beyond the noise.
    share: f64,
    /// How far all but the outermost hundredth of them go.
    reach: f64,
}

impl Background {
    /// By the highest peak of a histogram, at the finest resolution at which it holds about as much as at any.
    pub fn of(statistics: &ValueStatistics) -> Self {
        /// In fewer bins all peaks are one.
        const FEWEST_BINS: usize = 64;
        /// How much more a peak has to hold to be another than that of finer bins.
        const MORE: f64 = 1.25;
        let counts = &statistics.histogram;
        let mut best = Self::in_bins(counts, statistics, 1);
        let mut merged = 2;
        while counts.len() / merged >= FEWEST_BINS {
            let sums: Vec<u64> = counts.chunks(merged).map(|bins| bins.iter().sum()).collect();
            let coarser = Self::in_bins(&sums, statistics, merged);
            if coarser.share > MORE * best.share {
                best = coarser;
            }
            merged *= 2;
        }
        best
    }

    /// The highest peak of counts, each of so many bins.
    fn in_bins(counts: &[u64], statistics: &ValueStatistics, merged: usize) -> Self {
        let most = counts.iter().copied().max().unwrap_or(0);
        // Of peaks alike, the lowest.
        let peak = counts.iter().position(|count| *count == most).unwrap_or(0);
        // A normal distribution falls to this at one standard deviation.
        let is_high = |count: &&u64| **count as f64 > (-0.5f64).exp() * most as f64;
        let above = counts[peak..].iter().take_while(is_high).count();
        let below = counts[..=peak].iter().rev().take_while(is_high).count();
        let width = statistics.bin_width() * merged as f64;
        // Of a peak that other values lean on, the free side tells how wide it is.
        let sigma = (above.min(below) as f64 - 0.5) * width;
        let value = statistics.range[0] + (peak as f64 + 0.5) * width;
        let noise = if above.min(below) <= 1 { width } else { NOISE_SIGMAS * sigma };
        Self { value, noise, share: statistics.share([value - noise, value + noise]) }
    }

    /// Whether a scan shows what lies below its background, alone or besides what lies above: maps around 0 of statistics,
    /// differences, susceptibility or deformation, and dark vessels.
    pub fn is_within(&self, statistics: &ValueStatistics) -> bool {
        /// So much of a scan is its background.
        const MOST: f64 = 0.5;
        /// Enough where that is 0, in a range that goes to both sides.
        const ENOUGH: f64 = 0.2;
        /// Fewer voxels are specks, or ringing at edges.
        const LEAST: f64 = 5e-4;
        /// Of what lies above.
        const PART: f64 = 0.1;
        /// Noise, however it was measured, does not reach so many times as far.
        const FAR: f64 = 3.5;
        let [low, high] = statistics.range;
        let is_zero = low < 0.0 && high > 0.0 && self.value.abs() <= self.noise;
        let is_background = self.share >= if is_zero { ENOUGH } else { MOST };
        let [below, above] = self.sides(statistics);
        is_background
            && below.share >= LEAST.max(PART * above.share)
            && below.reach >= (PART * above.reach).max(FAR * self.noise)
    }

    fn sides(&self, statistics: &ValueStatistics) -> [Side; 2] {
        /// Of the voxels on a side, those that do not count for its reach.
        const OUTERMOST: f64 = 0.01;
        let [low, high] = statistics.range;
        let below = statistics.share([low, self.value - self.noise]);
        let above = statistics.share([self.value + self.noise, high]);
        let reach = |p: f64| (statistics.percentile(p) - self.value).abs();
        [
            Side { share: below, reach: if below > 0.0 { reach(OUTERMOST * below) } else { 0.0 } },
            Side { share: above, reach: if above > 0.0 { reach(1.0 - OUTERMOST * above) } else { 0.0 } },
        ]
    }

    /// How far voxels that are no background differ from it: half of them by less than the first number, all but a
    /// hundredth by less than the second. `None` where there are no others.
    pub fn deviations(&self, statistics: &ValueStatistics) -> Option<[f64; 2]> {
        let mut others: Vec<(f64, u64)> = statistics
            .bins()
            .map(|(value, count)| ((value - self.value).abs(), count))
            .filter(|(deviation, count)| *deviation > self.noise && *count > 0)
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: u64 = others.iter().map(|(_, count)| count).sum();
        let at = |p: f64| {
            let mut below = 0;
            let reached = |(_, count): &&(f64, u64)| {
                below += count;
                below as f64 >= p * total as f64
            };
            others.iter().find(reached).map(|(deviation, _)| *deviation)
        };
        Some([at(0.5)?, at(0.99)?])
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::volume::{Modality, Volume, Voxels};

    /// Normal noise of a standard deviation of 1, from a fixed seed.
    fn noise(i: usize) -> f64 {
        let uniform = |k: u64| {
            let mut x = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(k << 32);
            x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (x >> 11) as f64 / (1u64 << 53) as f64
        };
        (-2.0 * uniform(1).max(1e-12).ln()).sqrt() * (std::f64::consts::TAU * uniform(2)).cos()
    }

    fn statistics(values: Vec<f32>) -> ValueStatistics {
        let dims = [values.len(), 1, 1];
        let volume =
            Volume::new(dims, Voxels::F32(values), [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap();
        volume.statistics().clone()
    }

    fn is_signed(value: impl Fn(usize) -> f64) -> bool {
        let statistics = statistics((0..40_000).map(|i| value(i) as f32).collect());
        Background::of(&statistics).is_within(&statistics)
    }

    #[test]
    fn maps_around_their_background_are_told_from_scans_in_air() {
        // Statistics within a mask, a normalised brain in zeros, log-Jacobians, determinants about 1.
        assert!(is_signed(|i| if i.is_multiple_of(20) { 2.0 * noise(i) } else { 0.0 }));
        assert!(is_signed(|i| if i.is_multiple_of(2) { noise(i) } else { 0.0 }));
        assert!(is_signed(|i| if i.is_multiple_of(4) { (0.2 * noise(i)).exp() } else { 1.0 }));
        // Dark vessels in a noisy background that is not 0.
        assert!(is_signed(|i| if i.is_multiple_of(50) { 40.0 } else { 128.0 + 4.0 * noise(i) }));
        // A cube in noise around 0; a scan whose air is as noisy; ringing of a filter.
        assert!(!is_signed(|i| if i.is_multiple_of(10) { 1.0 } else { 0.05 * noise(i) }));
        assert!(!is_signed(|i| if i.is_multiple_of(3) {
            400.0 + 90.0 * noise(i)
        } else {
            (9.0 * noise(i)).abs()
        }));
        assert!(!is_signed(|i| match i % 100 {
            0 => -20.0,
            1..50 => 300.0 + 50.0 * noise(i),
            _ => 0.0,
        }));
        // What fills its box has no background.
        assert!(!is_signed(|i| 100.0 + 30.0 * noise(i)));
    }

    #[test]
    fn the_noise_of_a_background_is_measured() {
        let statistics = statistics(
            (0..40_000usize).map(|i| if i.is_multiple_of(10) { 50.0 } else { noise(i) } as f32).collect(),
        );
        let background = Background::of(&statistics);
        assert!(background.value.abs() < 0.5, "{background:?}");
        assert!((2.5..6.0).contains(&background.noise), "{background:?}");
        assert!((background.share - 0.9).abs() < 0.02, "{background:?}");
        assert_eq!(background.deviations(&statistics).map(|[_, most]| most.round()), Some(50.0));
    }
}
