//! Counts of a volume's values over any range, quick enough to follow a mouse.

use crate::statistics::ValueStatistics;
use crate::volume::Volume;

/// Bins of the counts that are kept; every count over a range is summed from them.
const FINE_BINS: usize = 1 << 16;

/// A volume's values, counted finely once.
#[derive(Clone, Debug)]
pub struct Histogram(ValueStatistics);

impl Histogram {
    /// Counts every voxel.
    pub fn new(volume: &Volume) -> Self {
        // A bin per step of an integer scan: no step is then split unevenly between bins.
        let [low, high] = volume.value_range();
        let steps = ((high - low) / volume.slope().abs()).round();
        let bins = if (1.0..FINE_BINS as f64).contains(&steps) { steps as usize + 1 } else { FINE_BINS };
        Self(ValueStatistics::new(volume, bins))
    }

    /// Voxels in each of `bins` equal parts of `low..=high`; what lies outside is not counted.
    pub fn counts(&self, bins: usize, [low, high]: [f64; 2]) -> Vec<f32> {
        let mut counts = vec![0u64; bins];
        let [first, last] = self.0.range;
        // The middle of a fine bin stands for its values; where bins are steps, the first and last are exact.
        let fine = self.0.histogram.len();
        let step = if fine > 1 { (last - first) / (fine - 1) as f64 } else { 0.0 };
        for (i, &count) in self.0.histogram.iter().enumerate() {
            let value = first + i as f64 * step;
            if (low..=high).contains(&value) && high > low {
                let bin = (((value - low) / (high - low)) * bins as f64) as usize;
                counts[bin.min(bins - 1)] += count;
            }
        }
        counts.into_iter().map(|n| n as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::volume::{Modality, Voxels};

    #[test]
    fn every_value_is_counted_where_it_belongs() {
        let samples = vec![0u16, 1, 1, 2, 2, 2, 100, 100];
        let volume =
            Volume::new([8, 1, 1], Voxels::U16(samples), [2.0, -50.0], DAffine3::IDENTITY, Modality::Ct)
                .unwrap();
        let histogram = Histogram::new(&volume);
        assert_eq!(histogram.counts(3, [-51.0, -45.0]), [1.0, 2.0, 3.0]);
        assert_eq!(histogram.counts(2, [-50.0, 150.0]), [6.0, 2.0]);
        assert_eq!(histogram.counts(4, [200.0, 300.0]), [0.0; 4]);
        assert_eq!(histogram.counts(1, [5.0, 5.0]), [0.0]);
    }
}
