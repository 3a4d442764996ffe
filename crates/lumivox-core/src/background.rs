//! What most of a scan is: the value of nothing, on one side of which, or on both, lies what was measured.

use std::ops::RangeInclusive;

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

    /// How far voxels differ from the background's own value, those that have it left out.
    pub fn deviations(&self, statistics: &ValueStatistics) -> Deviations {
        let least = statistics.bin_width();
        let mut others: Vec<(f64, u64)> = statistics
            .bins()
            .map(|(value, count)| ((value - self.value).abs(), count))
            .filter(|(deviation, count)| *deviation > least && *count > 0)
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0));
        Deviations(others)
    }

    /// Whether what is no background is a scan that was normalised within a mask and not a map around the background: so many
    /// voxels that they are a body, of which the background's value is no usual one.
    pub fn is_of_a_mask(&self, statistics: &ValueStatistics) -> bool {
        /// A mask has one value, in at least this and at most that share of the voxels.
        const OUTSIDE: RangeInclusive<f64> = 0.1..=0.95;
        /// Standard deviations around a value whose voxels are counted for it.
        const NEAR: f64 = 0.25;
        /// Of a map the background's value is about as usual as any; of a scan that was made to have a mean of 0 and a standard
        /// deviation of 1, that is but the mean of its tissues.
        const USUAL: f64 = 0.6;
        const USUAL_IF_NORMALISED: f64 = 0.9;
        const EXACT: f64 = 0.01;
        let width = statistics.bin_width();
        let is_it = |value: f64| (value - self.value).abs() <= width;
        let others: Vec<(f64, f64)> = statistics
            .bins()
            .filter(|(value, _)| !is_it(*value))
            .map(|(value, n)| (value, n as f64))
            .collect();
        let total: f64 = others.iter().map(|(_, n)| n).sum();
        let all: u64 = statistics.histogram.iter().sum();
        if width <= 0.0 || !OUTSIDE.contains(&(1.0 - total / (all as f64).max(1.0))) {
            return false;
        }
        let mean = others.iter().map(|(value, n)| value * n).sum::<f64>() / total;
        let variance = others.iter().map(|(value, n)| (value - mean).powi(2) * n).sum::<f64>() / total;
        let sigma = variance.sqrt();
        if sigma < 16.0 * width {
            return false;
        }
        let near = |middle: f64| {
            let is_near = |value: f64| (value - middle).abs() <= NEAR * sigma;
            others.iter().filter(|(value, _)| is_near(*value)).map(|(_, n)| n).sum::<f64>()
        };
        let most =
            (-12..=12).map(|step| near(self.value + NEAR * sigma * f64::from(step))).fold(0.0, f64::max);
        let is_normalised = mean.abs() <= EXACT && (sigma - 1.0).abs() <= EXACT && is_it(0.0);
        near(self.value) < most * if is_normalised { USUAL_IF_NORMALISED } else { USUAL }
    }
}

/// How far voxels differ from a background, the least first, and how many do.
#[derive(Clone, Debug)]
pub struct Deviations(Vec<(f64, u64)>);

impl Deviations {
    /// How many voxels these are.
    pub fn count(&self) -> u64 {
        self.0.iter().map(|(_, count)| count).sum()
    }

    /// Those of more than this.
    pub fn beyond(&self, least: f64) -> Self {
        Self(self.0.iter().copied().filter(|(deviation, _)| *deviation > least).collect())
    }

    /// By how much a fraction (0 to 1) of the voxels differ at most; `None` where there are none.
    pub fn quantile(&self, p: f64) -> Option<f64> {
        let total = self.count();
        let mut below = 0;
        let reached = |(_, count): &&(f64, u64)| {
            below += count;
            below as f64 >= p * total as f64
        };
        self.0.iter().find(reached).map(|(deviation, _)| *deviation)
    }

    /// The standard deviation of their bulk, were that normally distributed: peaks beyond it do not count. `None` where there
    /// are none.
    pub fn sigma(&self) -> Option<f64> {
        /// Half of what is normally distributed differs by less than this times its standard deviation.
        const HALF: f64 = 0.6745;
        /// What differs by more is none of the bulk.
        const CLIP: f64 = 3.5;
        const ROUNDS: usize = 16;
        let mut sigma = self.quantile(0.5)? / HALF;
        for _ in 0..ROUNDS {
            let most = CLIP * sigma;
            let bulk = Self(self.0.iter().copied().filter(|(deviation, _)| *deviation <= most).collect());
            let next = bulk.quantile(0.5)? / HALF;
            if next >= sigma {
                break;
            }
            sigma = next;
        }
        Some(sigma)
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
    fn a_scan_normalised_within_a_mask_is_no_map() {
        let is_of_a_mask = |value: &dyn Fn(usize) -> f64| {
            let statistics = statistics((0..40_000).map(|i| value(i) as f32).collect());
            Background::of(&statistics).is_of_a_mask(&statistics)
        };
        // Grey and white matter, and a little fluid, about their mean; the same from -1 to 1.
        let brain = |i: usize| match i % 20 {
            0 => -2.0 + 0.4 * noise(i),
            1..11 => -0.65 + 0.3 * noise(i),
            _ => 0.95 + 0.3 * noise(i),
        };
        assert!(is_of_a_mask(&|i| if i.is_multiple_of(3) { brain(i / 3) } else { 0.0 }));
        assert!(is_of_a_mask(&|i| if i.is_multiple_of(3) { brain(i / 3) / 3.0 } else { 0.0 }));
        // Statistics, with peaks or without; displacements to both sides; no mask.
        assert!(!is_of_a_mask(&|i| if i.is_multiple_of(3) { noise(i) } else { 0.0 }));
        assert!(!is_of_a_mask(&|i| match i % 60 {
            0 => 8.0 + noise(i),
            1..20 => noise(i),
            _ => 0.0,
        }));
        assert!(!is_of_a_mask(&|i| if i.is_multiple_of(3) { (i % 1999) as f64 / 1000.0 - 1.0 } else { 0.0 }));
        assert!(!is_of_a_mask(&|i| brain(i)));
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
        let deviations = background.deviations(&statistics);
        assert_eq!(deviations.quantile(0.99).map(f64::round), Some(50.0));
        assert!((deviations.sigma().unwrap() - 1.0).abs() < 0.1, "{:?}", deviations.sigma());
    }
}
