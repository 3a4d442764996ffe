//! Looks of scans without a fixed scale, placed by how many voxels have which values.

use crate::{
    medium::{Medium, SurfaceReflection},
    statistics::ValueStatistics,
    volume::Volume,
};

use super::{Preset, tf};

/// Where a scan's values lie.
struct Landmarks {
    lowest: f64,
    /// Between air and body (Otsu).
    air: f64,
    /// What hardly a voxel exceeds.
    bright: f64,
    statistics: ValueStatistics,
}

impl Landmarks {
    fn of(volume: &Volume) -> Self {
        let statistics = ValueStatistics::new(volume, 4096);
        let air = statistics.otsu_threshold();
        let bright = statistics.percentile(0.998).max(air * 1.5).max(air + f64::MIN_POSITIVE);
        Self { lowest: statistics.range[0], air, bright, statistics }
    }

    /// 0 where the body begins, 1 at its brightest.
    fn at(&self, t: f64) -> f64 {
        self.air + (self.bright - self.air) * t
    }

    /// A surface where values change by such a part of all within a millimetre.
    fn surface(&self, part_per_mm: f64, roughness: f64) -> SurfaceReflection {
        let gradient_per_mm = (self.bright - self.lowest) * part_per_mm;
        SurfaceReflection { strength: 1.0, gradient_per_mm, roughness, specular: 0.035 }
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
        ..Medium::new(tf(
            &[(low, 0.0), (marks.air, 0.25), (marks.at(0.4), 0.6), (marks.at(1.0), 1.0)],
            &[
                (low, [0.80, 0.45, 0.32]),
                (marks.air, [0.82, 0.47, 0.34]),
                (marks.at(0.4), [0.88, 0.58, 0.43]),
                (marks.at(1.0), [0.94, 0.79, 0.62]),
            ],
        ))
    }
}

/// Grey matter is darker than white in T1; fluid around it, darker still, is clear.
fn brain(marks: &Landmarks) -> Medium {
    Medium {
        density_scale: 2.0,
        surface: marks.surface(0.10, 0.42),
        ..Medium::new(tf(
            &[(marks.at(-0.1), 0.0), (marks.at(0.12), 0.20), (marks.at(0.35), 0.55), (marks.at(0.8), 0.9)],
            &[
                (marks.at(0.0), [0.78, 0.42, 0.36]),
                (marks.at(0.3), [0.86, 0.60, 0.52]),
                (marks.at(0.6), [0.93, 0.80, 0.70]),
                (marks.at(1.0), [0.97, 0.90, 0.80]),
            ],
        ))
    }
}

/// Vessels are the brightest hundredth of an angiogram, and the rest a haze that says where they are.
fn angiography(marks: &Landmarks) -> Medium {
    let [faint, clear, full] = [0.985, 0.995, 0.9995].map(|p| marks.statistics.percentile(p));
    let full = full.max(clear).max(faint);
    Medium {
        density_scale: 2.5,
        surface: marks.surface(0.10, 0.32),
        ..Medium::new(tf(
            &[(marks.air, 0.0), (marks.at(0.2), 0.002), (faint, 0.004), (clear, 0.35), (full, 1.0)],
            &[(marks.air, [0.75, 0.62, 0.56]), (faint, [0.72, 0.08, 0.05]), (full, [0.86, 0.16, 0.10])],
        ))
    }
}

fn fluid(marks: &Landmarks) -> Medium {
    Medium {
        density_scale: 2.0,
        surface: marks.surface(0.10, 0.38),
        ..Medium::new(tf(
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
        ))
    }
}

/// The colours of a glowing body, as PET is shown. SUV have a scale, on which blood and liver hardly show.
fn uptake(marks: &Landmarks, volume: &Volume) -> Medium {
    /// What is as hot as any tumour.
    const HOT_SUV: f64 = 10.0;
    let is_suv = volume.unit() == "SUV";
    let most = if is_suv { HOT_SUV } else { marks.statistics.percentile(0.9995).max(marks.bright) };
    let low = if is_suv { 0.0 } else { marks.lowest };
    let at = |t: f64| low + (most - low) * t;
    let opacity = match is_suv {
        true => [(at(0.13), 0.0), (at(0.24), 0.004), (at(0.38), 0.04), (at(0.6), 0.4), (at(1.0), 0.9)],
        false => [(at(0.03), 0.0), (at(0.12), 0.006), (at(0.3), 0.06), (at(0.6), 0.35), (at(1.0), 0.9)],
    };
    Medium {
        density_scale: 1.0,
        ..Medium::new(tf(
            &opacity,
            &[
                (at(0.05), [0.30, 0.02, 0.03]),
                (at(0.25), [0.75, 0.06, 0.02]),
                (at(0.45), [0.95, 0.36, 0.03]),
                (at(0.7), [0.99, 0.78, 0.16]),
                (at(1.0), [1.0, 0.98, 0.88]),
            ],
        ))
    }
}

fn plain(marks: &Landmarks) -> Medium {
    let at = |t: f64| marks.lowest + (marks.bright - marks.lowest) * t;
    Medium {
        density_scale: 2.0,
        surface: marks.surface(0.12, 0.45),
        ..Medium::new(tf(
            &[(at(0.06), 0.0), (at(0.5), 0.35), (at(1.0), 1.0)],
            &[(at(0.0), [0.10, 0.10, 0.10]), (at(1.0), [0.96, 0.96, 0.96])],
        ))
    }
}
