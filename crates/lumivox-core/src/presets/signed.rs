//! The look of a map that goes to both sides of its background: red above, blue below, and clear between.

use crate::{
    background::Background,
    medium::{Medium, SurfaceReflection},
    statistics::ValueStatistics,
    volume::Volume,
};

use super::tf;

/// From the threshold to the strongest: rising opacity, and colours of both sides.
const OPACITY: [(f64, f64); 3] = [(0.0, 0.0), (0.3, 0.35), (1.0, 1.0)];
const ABOVE: [[f64; 3]; 3] = [[0.62, 0.04, 0.02], [0.92, 0.22, 0.03], [1.0, 0.82, 0.20]];
const BELOW: [[f64; 3]; 3] = [[0.03, 0.08, 0.55], [0.05, 0.32, 0.90], [0.35, 0.88, 1.0]];

/// The look, placed by how far voxels that are no background differ from it.
pub(super) fn medium(volume: &Volume) -> Medium {
    let statistics = volume.statistics();
    let background = Background::of(statistics);
    let [low, high] = statistics.range;
    // Of a volume that is the same everywhere there is no other voxel.
    let least = (high - low).max(1e-6 * background.value.abs()).max(1e-30);
    let Seen { threshold, most } = Seen::of(&background, statistics).unwrap_or(Seen::all(least));
    let at = |side: f64, t: f64| background.value + side * (threshold + (most - threshold) * t);
    let opacity = |side: f64| OPACITY.map(|(t, opacity)| (at(side, t), opacity));
    let color = |side: f64, colors: [[f64; 3]; 3]| {
        OPACITY
            .map(|(t, _)| t)
            .into_iter()
            .zip(colors)
            .map(|(t, color)| (at(side, t), color))
            .collect::<Vec<_>>()
    };
    let surface = SurfaceReflection {
        strength: 0.8,
        gradient_per_mm: 0.15 * most,
        roughness: 0.4,
        specular: 0.04,
        ..SurfaceReflection::OFF
    }
    .sanitized();
    Medium {
        density_scale: 2.0,
        surface,
        ..Medium::new(tf(
            &[opacity(-1.0), opacity(1.0)].concat(),
            &[color(-1.0, BELOW), color(1.0, ABOVE)].concat(),
        ))
    }
}

/// The differences from the background that are seen.
struct Seen {
    /// The least of them.
    threshold: f64,
    /// What hardly a voxel exceeds.
    most: f64,
}

impl Seen {
    /// Of differences that reach so far and are signal, however small.
    fn all(most: f64) -> Self {
        Self { threshold: 0.15 * most, most }
    }

    /// `None` where all is background.
    fn of(background: &Background, statistics: &ValueStatistics) -> Option<Self> {
        /// The share of what is normally distributed that differs by more than [`Self::PEAK`] standard deviations; several times as
        /// much are peaks in noise.
        const TAIL: f64 = 4.7e-4;
        const PEAK: f64 = 3.5;
        const RICH: f64 = 3.0;
        /// Where there are no such, hardly a voxel of noise differs by so many.
        const RARE: f64 = 4.5;
        /// A hundredth of what is normally distributed differs by more than 2.6 of them; of what is spread evenly, as displacements
        /// or a normalised scan, none.
        const NORMAL: f64 = 2.2;
        /// The strongest is that much more than the least: else noise alone would be painted as strong.
        const SPAN: f64 = 1.6;
        let deviations = background.deviations(statistics);
        let sigma = deviations.sigma()?;
        let beyond = deviations.beyond(background.noise);
        let reach = if beyond.count() > 0 { &beyond } else { &deviations }.quantile(0.99)?;
        if deviations.quantile(0.99)? < NORMAL * sigma {
            let all = Self::all(reach);
            return Some(Self {
                threshold: all.threshold.max(background.noise.min(0.9 * reach)),
                most: reach,
            });
        }
        let peaks = deviations.beyond(PEAK * sigma);
        let is_rich = peaks.count() as f64 > RICH * TAIL * deviations.count() as f64;
        let strongest = peaks.quantile(0.99).unwrap_or(0.0);
        let least = if is_rich { PEAK } else { RARE } * sigma;
        let threshold = least.max(0.15 * strongest).max(background.noise.min(0.9 * strongest));
        Some(Self { threshold, most: strongest.max(SPAN * threshold) })
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::{
        presets::Preset,
        volume::{Modality, Voxels},
    };

    fn map(value: impl Fn(usize) -> f32) -> Volume {
        let voxels = Voxels::F32((0..32 * 32 * 32).map(value).collect());
        Volume::new([32; 3], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap()
    }

    #[test]
    fn the_commonest_value_is_clear_and_both_sides_have_their_colour() {
        for zero in [0.0f32, 1.0, -7.5] {
            let volume = map(|i| {
                zero + match i % 100 {
                    0 => 5.0,
                    1 => -4.0,
                    2..6 => ((i * 31 % 21) as f32 - 10.0) * 0.08,
                    _ => 0.0,
                }
            });
            assert_eq!(Preset::default_for(&volume), Preset::SignedMap, "around {zero}");
            let look = Preset::SignedMap.medium(&volume).transfer_function;
            let zero = f64::from(zero);
            assert_eq!([-0.8, 0.0, 0.8].map(|noise| look.opacity(zero + noise)), [0.0; 3], "around {zero}");
            assert!(look.opacity(zero + 5.0) > 0.9 && look.opacity(zero - 4.0) > 0.5);
            let ([red, _, blue], [other_red, _, other_blue]) =
                (look.color(zero + 4.0), look.color(zero - 4.0));
            assert!(red > 2.0 * blue && other_blue > 2.0 * other_red);
        }
    }

    /// Normal noise of a standard deviation of 1, in one voxel of four, as in a brain in its box.
    fn noise(i: usize) -> f32 {
        // splitmix64
        let uniform = |k: usize| {
            let mut x = (12 * i as u64 + k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        };
        if i.is_multiple_of(4) { ((0..12).map(uniform).sum::<f64>() - 6.0) as f32 } else { 0.0 }
    }

    #[test]
    fn noise_is_clear_however_few_the_peaks_are() {
        // Of the brain's 8192 voxels.
        for (peaks, name) in [(0, "null"), (25, "small"), (600, "large")] {
            let volume = map(|i| {
                let peak = if i.is_multiple_of(4) && i / 4 < peaks { 8.0 } else { 0.0 };
                noise(i) + peak * if i.is_multiple_of(8) { 1.0 } else { -1.0 }
            });
            assert_eq!(Preset::default_for(&volume), Preset::SignedMap, "{name}");
            let look = Preset::SignedMap.medium(&volume).transfer_function;
            let noise = [-3.0, -2.0, 0.5, 2.0, 3.0].map(|noise| look.opacity(noise));
            assert_eq!(noise, [0.0; 5], "{name}: {:?}", look.opacity_knots());
            if peaks > 0 {
                assert!(
                    look.opacity(8.0) > 0.3 && look.opacity(-8.0) > 0.3,
                    "{name}: {:?}",
                    look.opacity_knots()
                );
            } else {
                assert!(look.opacity(4.0) == 0.0, "{name}: {:?}", look.opacity_knots());
            }
        }
    }

    #[test]
    fn over_its_anatomy_a_map_shows_its_peaks_alone() {
        let signed = map(|i| if i.is_multiple_of(50) { (i % 13) as f32 - 6.0 } else { 0.0 });
        let brain = map(|i| if i % 9 < 4 { 300.0 + (i % 90) as f32 } else { (i % 5) as f32 });
        let pair = |a: &Volume, b: &Volume| Preset::fusion_of(&[a, b]);
        assert_eq!(pair(&brain, &signed), Some(vec![Preset::Fusion, Preset::SignedMap]));
        assert_eq!(pair(&signed, &brain), Some(vec![Preset::SignedMap, Preset::Fusion]));
        assert_eq!((pair(&brain, &brain), pair(&signed, &signed)), (None, None));
    }
}
