//! Where air and tissue lie in a CT, and whether its values can be the Hounsfield units that its file says they are.

use crate::{statistics::ValueStatistics, volume::Volume};

/// Soft tissue, which most of a body is, in Hounsfield units.
pub const TISSUE_HU: f64 = 40.0;
/// Air, in Hounsfield units.
pub const AIR_HU: f64 = -1000.0;

/// The commonest values of air and of soft tissue in a CT, in its own unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CtPeaks {
    /// Of air.
    pub air: f64,
    /// Of soft tissue, which is denser.
    pub tissue: f64,
}

impl CtPeaks {
    /// By the peaks below and above the threshold that best parts the values in two; `None` where there are no two.
    pub fn of(statistics: &ValueStatistics) -> Option<Self> {
        Self::and_lowest(statistics).map(|(peaks, _)| peaks)
    }

    /// The peaks, and the lowest value that was measured: where the field of view is round, scanners write one lower value
    /// around it.
    fn and_lowest(statistics: &ValueStatistics) -> Option<(Self, f64)> {
        /// Of the distance from the lowest to tissue: what is near.
        const NEAR: f64 = 0.05;
        /// Nearly all that is near to the lowest has that very value, and so much is air.
        const ALL: f64 = 0.8;
        const MUCH: f64 = 0.04;
        let border = statistics.otsu_threshold();
        let peak = |is_in: &dyn Fn(f64) -> bool| {
            let most = statistics.bins().filter(|(value, _)| is_in(*value)).map(|(_, count)| count).max()?;
            let highest = statistics.bins().find(|(value, count)| is_in(*value) && *count == most);
            highest.filter(|(_, count)| *count > 0).map(|(value, _)| value)
        };
        let [low, _] = statistics.range;
        let tissue = peak(&|value| value >= border)?;
        let near = NEAR * (tissue - low);
        let is_one_value = statistics.share([low, low + statistics.bin_width()])
            >= ALL * statistics.share([low, low + near]);
        let air_above = peak(&|value| value > low + near && value < border);
        let inside =
            air_above.filter(|air| is_one_value && statistics.share([air - near, air + near]) >= MUCH);
        let (air, lowest) = match inside {
            Some(air) => (air, low + near),
            None => (peak(&|value| value < border)?, low),
        };
        (tissue > air).then_some((Self { air, tissue }, lowest))
    }

    /// Slope and intercept that make its values of Hounsfield units.
    pub fn values_from_hounsfield(self) -> [f64; 2] {
        let slope = (self.tissue - self.air) / (TISSUE_HU - AIR_HU);
        [slope, self.air - AIR_HU * slope]
    }
}

/// Whether values go on below air as they do in it, as those of phases and of noise do, which are no Hounsfield units. What
/// scanners write around a round field of view is one value.
pub fn goes_below_air(volume: &Volume) -> bool {
    /// Air by any scanner, in Hounsfield units.
    const AIR: [f64; 2] = [-1150.0, -850.0];
    /// Streaks at metal are fewer.
    const SOME: f64 = 0.01;
    let statistics = volume.statistics();
    let [low, _] = statistics.range;
    let first = low + statistics.bin_width();
    low < AIR[0] && statistics.share([first, AIR[0]]) > statistics.share(AIR).max(SOME)
}

/// Where air and tissue lie in a CT whose values are said to be Hounsfield units and surely are none: an offset or a factor
/// was lost, or the scanner (as those of a cone beam) never had them. `None` for whatever can be Hounsfield units, and
/// for anything else.
pub fn uncalibrated(volume: &Volume) -> Option<CtPeaks> {
    /// Of fewer voxels nothing can be said for sure.
    const LEAST_VOXELS: usize = 4096;
    /// Air, and all that is soft, by any scanner that is calibrated.
    const AIR: [f64; 2] = [-1150.0, -850.0];
    const SOFT: [f64; 2] = [-250.0, 250.0];
    /// Shares of the voxels that a scan has of the two, and its peaks of their own neighbourhoods.
    const SOME: f64 = 0.02;
    const MUCH: f64 = 0.05;
    const FAT: [f64; 2] = [-160.0, -40.0];
    /// Fat and muscle, or tissue and bone, are no farther apart.
    const FAR: f64 = 400.0;
    /// Air that a scanner shows at less is a little off, and no other unit.
    const OFF_AIR: f64 = -700.0;
    /// How far apart air and tissue lie where only an offset was lost.
    const APART_HU: std::ops::RangeInclusive<f64> = 940.0..=1140.0;
    if !volume.is_hounsfield() || volume.voxel_count() < LEAST_VOXELS {
        return None;
    }
    let statistics = volume.statistics();
    let [low, high] = statistics.range;
    let (peaks, lowest) = CtPeaks::and_lowest(statistics)?;
    let apart = peaks.tissue - peaks.air;
    let around = |value: f64| statistics.share([value - 0.1 * apart, value + 0.1 * apart]);
    let has_two_peaks = around(peaks.air) >= MUCH && around(peaks.tissue) >= SOME;
    // Nothing is much less dense than air.
    let begins_at_air = statistics.share([lowest, peaks.air - 0.3 * apart]) < SOME;
    if !has_two_peaks || !begins_at_air {
        return None;
    }
    let has_air = statistics.share(AIR) >= SOME;
    let has_soft = statistics.share(SOFT) >= SOME;
    // A part of a body, without air: muscle is the lower peak, bone the upper, and fat lies below both.
    let is_inside = (peaks.air - TISSUE_HU).abs() < 60.0
        && statistics.share(FAT) >= SOME
        && !(APART_HU.contains(&apart) && around(peaks.tissue) >= 0.1);
    let is_shifted = !has_air && peaks.air > OFF_AIR && apart >= FAR && !is_inside;
    // No scan of a body is without noise, or fat, below water.
    let is_positive = low >= 0.0 && high <= 255.0 && apart >= 20.0;
    let is_stretched = peaks.air < 1.5 * AIR[0] && !(has_air && has_soft);
    (is_shifted || is_positive || is_stretched).then_some(peaks)
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::volume::{Modality, Voxels};

    /// A body of fat, muscle and a little bone in air, as `value` makes of Hounsfield units.
    fn body(share_of_air: usize, value: impl Fn(f64) -> f64) -> Volume {
        let hounsfield = |i: usize| {
            let noise = (i * 7919 % 41) as f64 - 20.0;
            match i * 31 % 100 {
                part if part < share_of_air => -1000.0 + noise,
                part if part.is_multiple_of(5) => -100.0 + noise,
                part if part.is_multiple_of(7) => 700.0 + 10.0 * noise,
                _ => 50.0 + noise,
            }
        };
        let voxels = Voxels::F32((0..20_000).map(|i| value(hounsfield(i)) as f32).collect());
        Volume::new([200, 100, 1], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct).unwrap()
    }

    #[test]
    fn lost_offsets_and_factors_are_found() {
        type Change = fn(f64) -> f64;
        let changes: [(Change, [f64; 2]); 5] = [
            (|hu| hu + 1024.0, [1.0, 1024.0]),
            (|hu| 7.0 * hu, [7.0, 0.0]),
            (|hu| 7.0 * (hu + 1000.0), [7.0, 7000.0]),
            // A cone beam with air at 180.
            (|hu| 180.0 + 0.9 * (hu + 1000.0), [0.9, 1080.0]),
            (|hu| ((hu + 1000.0) / 8.0).clamp(0.0, 255.0).round(), [0.125, 125.0]),
        ];
        for (change, expected) in changes {
            let [slope, intercept] = uncalibrated(&body(60, change)).unwrap().values_from_hounsfield();
            let [true_slope, true_intercept] = expected;
            assert!((slope / true_slope - 1.0).abs() < 0.06, "{slope} for {expected:?}");
            assert!((intercept - true_intercept).abs() < 60.0 * true_slope, "{intercept} for {expected:?}");
        }
    }

    #[test]
    fn what_lies_around_a_round_field_of_view_is_no_air() {
        // A cone beam, around whose field of view there is nothing but zeros.
        let inside = body(40, |hu| 180.0 + 0.5 * (hu + 1000.0));
        let voxels = Voxels::F32(
            (0..20_000usize)
                .map(|i| if i.is_multiple_of(2) { 0.0 } else { inside.voxels().get(i) as f32 })
                .collect(),
        );
        let whole = Volume::new(inside.dims(), voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct).unwrap();
        let peaks = uncalibrated(&whole).unwrap();
        assert!((peaks.air - 180.0).abs() < 15.0 && (peaks.tissue - 705.0).abs() < 15.0, "{peaks:?}");
    }

    #[test]
    fn hounsfield_units_are_believed() {
        for share_of_air in [90, 60, 10, 0] {
            assert_eq!(uncalibrated(&body(share_of_air, |hu| hu)), None, "{share_of_air} % of air");
        }
        // Windowed for a network, without air around; air that is a little off; what is no CT.
        assert_eq!(uncalibrated(&body(60, |hu| hu.clamp(-160.0, 240.0))), None);
        assert_eq!(uncalibrated(&body(60, |hu| hu.max(-1024.0) + 30.0)), None);
        assert_eq!(uncalibrated(&body(60, |hu| if hu < -500.0 { hu + 180.0 } else { hu })), None);
        assert_eq!(uncalibrated(&body(60, |hu| hu + 1024.0).with_modality(Modality::Mr)), None);
        assert_eq!(uncalibrated(&body(60, |hu| hu + 1024.0).with_unit("mg/ml")), None);
    }
}
