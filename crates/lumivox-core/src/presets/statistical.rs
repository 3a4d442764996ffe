//! Looks of scans without a fixed scale, placed by how many voxels have which values.

use crate::{
    background::Background,
    medium::{Medium, SurfaceReflection},
    statistics::ValueStatistics,
    transfer_function::{Ease, OpacityKnot, TransferFunction},
    volume::Volume,
};

use super::{Preset, tf};

/// Where a scan's values lie.
struct Landmarks<'a> {
    /// What most of the scan is, where that lies below the body; else its lowest value.
    lowest: f64,
    /// Up to where a value may be noise of that.
    clear: f64,
    /// Between air and body (Otsu).
    air: f64,
    /// What hardly a voxel exceeds.
    bright: f64,
    /// Of a scan cut out by a mask, the value around it, which lies among its own and is clear.
    hole: Option<[f64; 2]>,
    statistics: &'a ValueStatistics,
}

impl<'a> Landmarks<'a> {
    fn of(volume: &'a Volume) -> Self {
        let statistics = volume.statistics();
        if volume.is_normalised() {
            return Self::of_normalised(statistics);
        }
        let [low, _] = statistics.range;
        let air = statistics.otsu_threshold();
        let background = Background::of(statistics);
        let is_below = background.value + background.noise <= air;
        let (lowest, clear) =
            if is_below { (background.value, background.value + background.noise) } else { (low, low) };
        // Half as far again as from the lowest to the air, whatever the sign of the values.
        let bright = statistics.percentile(0.998).max(air + 0.5 * (air - lowest));
        Self { lowest, clear, air, bright: bright.max(air + f64::MIN_POSITIVE), hole: None, statistics }
    }

    /// Of a scan without air: it begins at its darkest values, and a step around that of the mask is clear.
    fn of_normalised(statistics: &'a ValueStatistics) -> Self {
        /// Values of the scan below and above which there are hardly any.
        const ENDS: [f64; 2] = [0.01, 0.998];
        let around = Background::of(statistics).value;
        let half = 1.5 * statistics.bin_width();
        let others = |p: f64| {
            let bins = || statistics.bins().filter(|(value, _)| (value - around).abs() > half);
            let total: u64 = bins().map(|(_, count)| count).sum();
            let mut below = 0;
            let reached = |(_, count): &(f64, u64)| {
                below += count;
                below as f64 >= p * total as f64
            };
            bins().find(reached).map_or(around, |(value, _)| value)
        };
        let [low, bright] = ENDS.map(others);
        let bright = bright.max(low + half);
        let hole = Some([around - half, around + half]);
        Self { lowest: low, clear: low, air: low, bright, hole, statistics }
    }

    /// 0 where the body begins, 1 at its brightest.
    fn at(&self, t: f64) -> f64 {
        self.air + (self.bright - self.air) * t
    }

    /// A surface where values change by such a part of all within a millimetre.
    fn surface(&self, part_per_mm: f64, roughness: f64) -> SurfaceReflection {
        let gradient_per_mm = (self.bright - self.lowest) * part_per_mm;
        SurfaceReflection {
            strength: 1.0,
            gradient_per_mm,
            roughness,
            specular: 0.035,
            ..SurfaceReflection::OFF
        }
        .sanitized()
    }

    /// Knots in their order, from where nothing is noise any more: those that the scan's statistics put before an earlier one
    /// are moved up to it.
    fn rising<T: Copy>(&self, knots: &[(f64, T)]) -> Vec<(f64, T)> {
        let mut least = self.clear;
        let rise = |&(value, what): &(f64, T)| {
            let value = value.max(least);
            let step = (1e-6 * (self.bright - self.lowest)).max(1e-9 * value.abs()).max(1e-30);
            least = value + step;
            (value, what)
        };
        knots.iter().map(rise).collect()
    }

    /// A medium whose opacity rises from 0 over such knots.
    fn medium(&self, opacity: &[(f64, f64)], color: &[(f64, [f64; 3])]) -> Medium {
        let look = tf(&self.rising(opacity), &self.rising(color));
        let Some([from, to]) = self.hole else { return Medium::new(look) };
        // The curve jumps to 0 and back, and goes on as it did.
        let is_beside = |knot: &OpacityKnot| knot.value < from || knot.value > to;
        let knot = |value, opacity| OpacityKnot { value, opacity, ease: Ease::Linear };
        let mut knots: Vec<_> = look.opacity_knots().iter().copied().filter(is_beside).collect();
        let [before, behind] = [from, to].map(|value| look.opacity(value));
        let hole = [knot(from, before), knot(from, 0.0), knot(to, 0.0), knot(to, behind)];
        let at = knots.partition_point(|knot| knot.value < from);
        knots.splice(at..at, hole);
        let cut = TransferFunction::new(knots, look.color_stops().to_vec());
        Medium::new(cut.expect("a part of a valid curve"))
    }
}

/// The look of a preset that is not about CT.
pub(super) fn medium(preset: Preset, volume: &Volume) -> Medium {
    let marks = Landmarks::of(volume);
    match preset {
        Preset::MrBrain => brain(&marks),
        Preset::MrAngiography => angiography(&marks),
        Preset::MrT2 => fluid(&marks),
        Preset::PetHot => uptake(&marks, volume),
        Preset::Plain => plain(&marks),
        _ => head(&marks),
    }
}

/// Skin and fat are bright in T1, the brain in the middle; air is darker than half of Otsu's threshold.
fn head(marks: &Landmarks) -> Medium {
    let low = marks.lowest + (marks.air - marks.lowest) * 0.45;
    Medium {
        density_scale: 2.0,
        surface: marks.surface(0.08, 0.45),
        ..marks.medium(
            &[(low, 0.0), (marks.air, 0.25), (marks.at(0.4), 0.6), (marks.at(1.0), 1.0)],
            &[
                (low, [0.80, 0.45, 0.32]),
                (marks.air, [0.82, 0.47, 0.34]),
                (marks.at(0.4), [0.88, 0.58, 0.43]),
                (marks.at(1.0), [0.94, 0.79, 0.62]),
            ],
        )
    }
}

/// Grey matter is darker than white in T1; fluid around it, darker still, is clear.
fn brain(marks: &Landmarks) -> Medium {
    Medium {
        density_scale: 2.0,
        surface: marks.surface(0.10, 0.42),
        ..marks.medium(
            &[(marks.at(-0.1), 0.0), (marks.at(0.12), 0.20), (marks.at(0.35), 0.55), (marks.at(0.8), 0.9)],
            &[
                (marks.at(0.0), [0.78, 0.42, 0.36]),
                (marks.at(0.3), [0.86, 0.60, 0.52]),
                (marks.at(0.6), [0.93, 0.80, 0.70]),
                (marks.at(1.0), [0.97, 0.90, 0.80]),
            ],
        )
    }
}

/// Vessels are the brightest hundredth of an angiogram, and the rest a haze that says where they are. Where they are still
/// less, and nothing else is there, they are all that is no background.
fn angiography(marks: &Landmarks) -> Medium {
    let [faint, clear, full] = [0.985, 0.995, 0.9995].map(|p| marks.statistics.percentile(p));
    let [faint, clear, full] = if faint < marks.at(0.2) {
        [marks.at(0.2), clear.max(marks.at(0.4)), full.max(marks.at(1.0))]
    } else {
        [faint, clear, full]
    };
    Medium {
        density_scale: 2.5,
        surface: marks.surface(0.10, 0.32),
        ..marks.medium(
            &[(marks.air, 0.0), (marks.at(0.2), 0.002), (faint, 0.004), (clear, 0.35), (full, 1.0)],
            &[(marks.air, [0.75, 0.62, 0.56]), (faint, [0.72, 0.08, 0.05]), (full, [0.86, 0.16, 0.10])],
        )
    }
}

fn fluid(marks: &Landmarks) -> Medium {
    Medium {
        density_scale: 2.0,
        surface: marks.surface(0.10, 0.38),
        ..marks.medium(
            &[
                (marks.at(-0.2), 0.0),
                (marks.at(0.1), 0.03),
                (marks.at(0.4), 0.10),
                (marks.at(0.65), 0.4),
                (marks.at(1.0), 0.9),
            ],
            &[
                (marks.at(0.0), [0.80, 0.50, 0.42]),
                (marks.at(0.4), [0.86, 0.68, 0.60]),
                (marks.at(0.65), [0.55, 0.72, 0.88]),
                (marks.at(1.0), [0.78, 0.90, 0.98]),
            ],
        )
    }
}

/// The colours of a glowing body, as PET is shown. SUV have a scale, on which blood and liver hardly show. Without it the body
/// has one: a bladder that is a hundred times as hot says nothing of the rest.
fn uptake(marks: &Landmarks, volume: &Volume) -> Medium {
    /// What is as hot as any tumour.
    const HOT_SUV: f64 = 10.0;
    let is_suv = volume.unit() == "SUV";
    let hottest = || marks.statistics.percentile(0.9995).max(marks.bright);
    let (low, most) = match is_suv {
        true => (0.0, HOT_SUV),
        false => match usual_uptake(volume) {
            Some([air, body]) => (air, (air + HOT_SUV * (body - air)).min(hottest())),
            None => (marks.lowest, hottest()),
        },
    };
    let at = |t: f64| low + (most - low) * t;
    let opacity = match is_suv {
        true => [(at(0.13), 0.0), (at(0.24), 0.004), (at(0.38), 0.04), (at(0.6), 0.4), (at(1.0), 0.9)],
        false => [(at(0.03), 0.0), (at(0.12), 0.006), (at(0.3), 0.06), (at(0.6), 0.35), (at(1.0), 0.9)],
    };
    let color = [
        (at(0.05), [0.30, 0.02, 0.03]),
        (at(0.25), [0.75, 0.06, 0.02]),
        (at(0.45), [0.95, 0.36, 0.03]),
        (at(0.7), [0.99, 0.78, 0.16]),
        (at(1.0), [1.0, 0.98, 0.88]),
    ];
    match is_suv {
        true => Medium::new(tf(&opacity, &color)),
        // What is hot may stretch the histogram so far that its noise says nothing.
        false if marks.clear > at(0.12) => Landmarks { clear: low, ..*marks }.medium(&opacity, &color),
        false => marks.medium(&opacity, &color),
    }
}

/// The mean values of air and of a body, whose mean uptake is an SUV of 1 by definition; `None` where no body stands out from the
/// air.
fn usual_uptake(volume: &Volume) -> Option<[f64; 2]> {
    /// All but what is hottest, which would hide the body in the histogram's first bins.
    const NEARLY_ALL: f64 = 0.99;
    /// A body fills more of what was scanned, and is so much hotter than air.
    const LEAST_SHARE: f64 = 0.02;
    const HOTTER: f64 = 4.0;
    let mut statistics = volume.statistics().clone();
    // The range of nearly all, to within a bin: finer ones, until the bins are fine enough.
    for _ in 0..4 {
        let [low, _] = statistics.range;
        statistics = ValueStatistics::within(volume, [low, statistics.percentile(NEARLY_ALL)], 4096);
    }
    let border = statistics.otsu_threshold();
    let mean = |is_in: &dyn Fn(f64) -> bool| {
        let bins = || statistics.bins().filter(|(value, _)| is_in(*value));
        let count: u64 = bins().map(|(_, count)| count).sum();
        let sum: f64 = bins().map(|(value, count)| (value - statistics.range[0]) * count as f64).sum();
        (count > 0).then(|| sum / count as f64)
    };
    let (air, body) = (mean(&|value| value < border)?, mean(&|value| value >= border)?);
    let is_body = statistics.share([border, f64::INFINITY]) >= LEAST_SHARE && body >= HOTTER * air;
    is_body.then(|| [air, body].map(|above| statistics.range[0] + above))
}

fn plain(marks: &Landmarks) -> Medium {
    let at = |t: f64| marks.lowest + (marks.bright - marks.lowest) * t;
    Medium {
        density_scale: 2.0,
        surface: marks.surface(0.12, 0.45),
        ..marks.medium(
            &[(at(0.06), 0.0), (at(0.5), 0.35), (at(1.0), 1.0)],
            &[(at(0.0), [0.10, 0.10, 0.10]), (at(1.0), [0.96, 0.96, 0.96])],
        )
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::volume::{Modality, Voxels};

    /// Presets that place themselves by statistics, and whose opacity rises.
    const RISING: [Preset; 6] =
        [Preset::MrHead, Preset::MrBrain, Preset::MrAngiography, Preset::MrT2, Preset::PetHot, Preset::Plain];

    /// Random numbers that are the same each time (splitmix64).
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut x = self.0;
            x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        }

        /// A scan of background and up to four tissues, each with its own share and width, from sparse to full.
        fn scan(&mut self) -> Volume {
            let scale = 10f64.powf(self.next() * 8.0 - 4.0);
            let offset = if self.next() < 0.5 { 0.0 } else { (self.next() - 0.5) * 4.0 * scale };
            let share_of_air = 1.0 - 10f64.powf(-4.0 * self.next());
            let noise = if self.next() < 0.5 { 0.0 } else { 0.1 * self.next() * scale };
            let tissues: Vec<[f64; 2]> =
                (0..1 + (4.0 * self.next()) as usize).map(|_| [self.next(), 0.2 * self.next()]).collect();
            let values = (0..4000).map(|_| {
                let value = if self.next() < share_of_air {
                    noise * self.next()
                } else {
                    let [middle, width] = tissues[(self.next() * tissues.len() as f64) as usize];
                    (middle + width * (self.next() - 0.5)) * scale
                };
                (value + offset) as f32
            });
            let voxels = Voxels::F32(values.collect());
            Volume::new([20, 20, 10], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Mr).unwrap()
        }
    }

    #[test]
    fn looks_rise_from_a_clear_background_whatever_the_histogram() {
        let mut random = Random(34);
        for round in 0..400 {
            let volume = random.scan();
            let background = Background::of(volume.statistics());
            let [low, high] = volume.value_range();
            for preset in RISING {
                let look = medium(preset, &volume).transfer_function;
                let knots = look.opacity_knots();
                let told = || format!("{} of scan {round}: {knots:?}", preset.name());
                assert_eq!(knots[0].opacity, 0.0, "{}", told());
                assert_eq!(look.opacity(low), 0.0, "{}", told());
                assert!(
                    knots
                        .windows(2)
                        .all(|pair| pair[0].value < pair[1].value && pair[0].opacity <= pair[1].opacity),
                    "{}",
                    told()
                );
                // What is mostly there is the background, where anything is above it.
                let below = background.value + background.noise <= volume.statistics().otsu_threshold();
                let is_background = background.share > 0.6 && below && high > low;
                assert!(!is_background || look.opacity(background.value) == 0.0, "{}", told());
            }
        }
    }

    #[test]
    fn a_body_is_seen_beside_one_hot_organ() {
        // Air, a body with a liver, and one voxel of a thousand a thousand times as hot.
        let value = |hot: f32| {
            move |i: usize| match i % 1000 {
                0 => hot,
                1..50 => 2000.0 + (i * 7 % 400) as f32,
                50..300 => 800.0 + (i * 7 % 400) as f32,
                _ => (i * 7 % 60) as f32,
            }
        };
        let scan = |hot: f32| {
            let voxels = Voxels::F32((0..100_000).map(value(hot)).collect());
            let volume = Volume::new([100, 100, 10], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Pet);
            medium(Preset::PetHot, &volume.unwrap()).transfer_function
        };
        let look = scan(1e6);
        assert_eq!(look.opacity(60.0), 0.0, "air");
        // Seen through 200 mm of it.
        assert!(200.0 * look.opacity(1000.0) > 0.3, "{:?}", look.opacity_knots());
        assert!(look.opacity(2200.0) > 2.0 * look.opacity(1000.0) && look.opacity(1e6) == 0.9);
        // The same body, without it, looks the same.
        assert!((scan(12_000.0).opacity(2200.0) / look.opacity(2200.0) - 1.0).abs() < 0.3);
    }

    #[test]
    fn a_normalised_scan_is_a_brain_on_a_clear_ground() {
        // A ball of grey matter around white, about a mean of 0, and 0 around it, in voxels of 2 mm.
        let value = |i: usize| {
            let at =
                [i % 64, i / 64 % 64, i / 4096].map(|n| (n as f64 - 31.5).powi(2)).iter().sum::<f64>().sqrt();
            let noise = 0.5 * ((i * 7919 % 101) as f32 / 100.0 - 0.5);
            match at {
                r if r < 20.0 => 0.9 + noise,
                r if r < 26.0 => -0.9 + noise,
                _ => 0.0,
            }
        };
        let place = DAffine3::from_scale(glam::DVec3::splat(2.0));
        for scale in [1.0, 0.3] {
            let voxels = Voxels::F32((0..64 * 64 * 64).map(|i| scale * value(i)).collect());
            let volume = Volume::new([64; 3], voxels, [1.0, 0.0], place, Modality::Other).unwrap();
            assert_eq!(Preset::default_for(&volume), Preset::MrBrain, "{scale}");
            for preset in RISING {
                let look = preset.medium(&volume).transfer_function;
                assert_eq!(look.opacity(0.0), 0.0, "{}", preset.name());
                let told = || format!("{} of {scale}: {:?}", preset.name(), look.opacity_knots());
                assert!(
                    look.opacity(0.9 * f64::from(scale)) > 0.1 || preset == Preset::MrAngiography,
                    "{}",
                    told()
                );
            }
            let look = medium(Preset::MrBrain, &volume).transfer_function;
            assert!(look.opacity(-0.8 * f64::from(scale)) > 0.05, "{:?}", look.opacity_knots());
        }
    }

    #[test]
    fn a_few_hot_voxels_change_no_look() {
        let brain =
            |i: usize| if i.is_multiple_of(3) { 300.0 + (i * 37 % 600) as f32 } else { (i % 9) as f32 };
        let scan = |hot: usize| {
            let mut values: Vec<f32> = (0..60_000).map(brain).collect();
            (0..hot).for_each(|i| values[9000 * i] = 1e6);
            Volume::new([100, 100, 6], Voxels::F32(values), [1.0, 0.0], DAffine3::IDENTITY, Modality::Mr)
                .unwrap()
        };
        for preset in RISING {
            let [clean, hot] = [0, 5].map(|hot| medium(preset, &scan(hot)).transfer_function);
            for value in [0.0, 300.0, 500.0, 700.0, 900.0] {
                let change = (clean.opacity(value) - hot.opacity(value)).abs();
                assert!(change < 0.05, "{} at {value}: {:?}", preset.name(), hot.opacity_knots());
            }
        }
    }

    #[test]
    fn sparse_vessels_stand_in_clear_ground() {
        // One voxel of a hundred, fading out as filters of vessels do.
        let vessel = |i: usize| match i % 100 {
            0 => 0.3 + 0.7 * (i % 700) as f32 / 700.0,
            1..4 => 1e-3 * (i % 7) as f32,
            _ => 0.0,
        };
        let voxels = Voxels::F32((0..40_000).map(vessel).collect());
        let volume = Volume::new([40, 40, 25], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other);
        let look = medium(Preset::MrAngiography, &volume.unwrap()).transfer_function;
        assert_eq!([0.0, 0.006].map(|value| look.opacity(value)), [0.0; 2]);
        assert!(look.opacity(0.8) > 0.5);
    }
}
