//! The look of a map that goes to both sides of its background: red above, blue below, and clear between.

use crate::{
    background::Background,
    medium::{Medium, SurfaceReflection},
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
    let [usual, most] = background.deviations(statistics).unwrap_or([0.0; 2]);
    // Of a volume that is the same everywhere there is no other voxel.
    let least = (high - low).max(1e-6 * background.value.abs()).max(1e-30);
    let most = if most > 0.0 { most } else { least };
    let threshold = threshold(usual, most).max(background.noise.min(0.9 * most));
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
    let surface =
        SurfaceReflection { strength: 0.8, gradient_per_mm: 0.15 * most, roughness: 0.4, specular: 0.04 }
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

/// From which difference on something is seen, of values that differ by the `usual` or less as often as by more, and of which
/// hardly one differs by more than the `most`.
fn threshold(usual: f64, most: f64) -> f64 {
    /// Half of what is normally distributed differs by less than this times its standard deviation.
    const HALF: f64 = 0.6745;
    /// What differs by more standard deviations than this is no noise.
    const SIGMAS: f64 = 4.0;
    let sigma = usual / HALF;
    match most > 3.5 * sigma {
        // Peaks in noise, as statistics have them: these alone.
        true => (SIGMAS * sigma).clamp(0.15 * most, 0.5 * most),
        // All of it is signal: a normalised scan, say.
        false => 0.15 * most,
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
