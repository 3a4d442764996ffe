//! Looks that suit a kind of scan at once.
//!
//! CT presets are fixed in Hounsfield units. MR has no fixed scale, so its presets place themselves by the scan's own
//! statistics.

use glam::DAffine3;

use crate::{
    medium::{Medium, SurfaceReflection},
    statistics::ValueStatistics,
    transfer_function::{Ease, TransferFunction},
    volume::{Modality, Volume, Voxels},
};

/// A named look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Preset {
    /// Skeleton, with vessels where contrast makes them as dense.
    CtBone,
    /// The surface of the body, as if alive.
    CtSkin,
    /// Muscle and organs under clear fat, with vessels and bone.
    CtMuscle,
    /// Airways and vessels of the lung in a clear body.
    CtLung,
    /// Contrast-filled vessels before translucent bone.
    CtAngiography,
    /// Skin and brain of a head.
    MrHead,
}

/// A preset of that name does not exist.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no preset '{name}'{} Presets: {}", self.guess(), Preset::names().join(", "))]
pub struct UnknownPreset {
    /// The name asked for.
    pub name: String,
    /// The existing name that may have been meant.
    pub nearest: Option<&'static str>,
}

impl UnknownPreset {
    fn guess(&self) -> String {
        self.nearest.map_or_else(|| ".".to_owned(), |name| format!("; did you mean '{name}'?"))
    }
}

impl Preset {
    /// Every preset.
    pub const ALL: [Preset; 6] = [
        Preset::CtBone,
        Preset::CtSkin,
        Preset::CtMuscle,
        Preset::CtLung,
        Preset::CtAngiography,
        Preset::MrHead,
    ];

    /// The name people type.
    pub fn name(self) -> &'static str {
        match self {
            Preset::CtBone => "ct-bone",
            Preset::CtSkin => "ct-skin",
            Preset::CtMuscle => "ct-muscle",
            Preset::CtLung => "ct-lung",
            Preset::CtAngiography => "ct-angiography",
            Preset::MrHead => "mr-head",
        }
    }

    /// One line on what it shows.
    pub fn description(self) -> &'static str {
        match self {
            Preset::CtBone => "the skeleton, white and crisp",
            Preset::CtSkin => "skin and soft tissue",
            Preset::CtMuscle => "muscle, organs and vessels under clear fat, with bone",
            Preset::CtLung => "airways and vessels of the lung in a clear body",
            Preset::CtAngiography => "contrast-filled vessels before translucent bone",
            Preset::MrHead => "a head from MR, placed by the scan's own statistics",
        }
    }

    /// All names.
    pub fn names() -> Vec<&'static str> {
        Self::ALL.iter().map(|p| p.name()).collect()
    }

    /// The preset of a name, in any case, with `_` or a space for `-`.
    ///
    /// # Errors
    /// [`UnknownPreset`] with the nearest name.
    pub fn from_name(name: &str) -> Result<Self, UnknownPreset> {
        let wanted = name.trim().to_lowercase().replace(['_', ' '], "-");
        if let Some(preset) = Self::ALL.into_iter().find(|p| p.name() == wanted) {
            return Ok(preset);
        }
        /// So many wrong letters are a slip of the fingers.
        const SLIPS: usize = 2;
        let is_part = |known: &str| wanted.len() > 2 && known.contains(&wanted);
        let nearest = Self::ALL
            .into_iter()
            .map(|preset| (edit_distance(&wanted, preset.name()), preset.name()))
            .filter(|(distance, known)| *distance <= SLIPS || is_part(known))
            .min()
            .map(|(_, known)| known);
        Err(UnknownPreset { name: name.to_owned(), nearest })
    }

    /// The preset that suits a volume when nobody chose one.
    pub fn default_for(volume: &Volume) -> Self {
        match volume.modality() {
            _ if volume.is_hounsfield() => Preset::CtMuscle,
            // Maps of iodine, perfusion or dose have a scale of their own.
            _ if !volume.unit().is_empty() => Preset::MrHead,
            Modality::Ct | Modality::Mr => Preset::MrHead,
            Modality::Pet | Modality::Other => {
                let [min, max] = volume.value_range();
                if min <= -500.0 && max >= 300.0 { Preset::CtMuscle } else { Preset::MrHead }
            }
        }
    }

    /// The look where there is no scan yet; `None` for those that place themselves by a scan's values.
    pub fn medium_without_scan(self) -> Option<Medium> {
        let any = Volume::new([1; 3], Voxels::U8(vec![0]), [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct);
        any.ok().filter(|_| self != Preset::MrHead).map(|any| self.medium(&any))
    }

    /// The look, placed for `volume`.
    pub fn medium(self, volume: &Volume) -> Medium {
        let surface = |gradient_per_mm: f64, roughness: f64, specular: f64| SurfaceReflection {
            strength: 1.0,
            gradient_per_mm,
            roughness,
            specular,
        };
        match self {
            Preset::CtBone => Medium {
                density_scale: 3.0,
                surface: surface(150.0, 0.45, 0.04),
                ..Medium::new(tf(
                    &[(120.0, 0.0), (220.0, 0.08), (330.0, 0.45), (700.0, 1.0)],
                    &[
                        (120.0, [0.55, 0.13, 0.08]),
                        (220.0, [0.78, 0.42, 0.26]),
                        (330.0, [0.91, 0.76, 0.56]),
                        (700.0, [0.96, 0.90, 0.78]),
                        (1500.0, [0.99, 0.97, 0.92]),
                    ],
                ))
            },
            Preset::CtSkin => Medium {
                density_scale: 2.5,
                surface: surface(120.0, 0.42, 0.035),
                ..Medium::new(tf(
                    &[(-600.0, 0.0), (-280.0, 0.35), (-50.0, 0.6), (200.0, 0.9), (500.0, 1.0)],
                    &[
                        (-600.0, [0.82, 0.47, 0.33]),
                        (-250.0, [0.83, 0.47, 0.33]),
                        (-50.0, [0.82, 0.38, 0.25]),
                        (60.0, [0.62, 0.12, 0.08]),
                        (300.0, [0.94, 0.80, 0.62]),
                        (1000.0, [0.99, 0.95, 0.88]),
                    ],
                ))
            },
            Preset::CtMuscle => Medium {
                density_scale: 2.0,
                surface: surface(110.0, 0.40, 0.04),
                ..Medium::new(tf(
                    &[(0.0, 0.0), (25.0, 0.05), (60.0, 0.28), (140.0, 0.40), (260.0, 0.55), (600.0, 1.0)],
                    &[
                        (-40.0, [0.86, 0.58, 0.34]),
                        (10.0, [0.76, 0.24, 0.15]),
                        (60.0, [0.62, 0.10, 0.065]),
                        (130.0, [0.72, 0.13, 0.08]),
                        (220.0, [0.88, 0.46, 0.31]),
                        (350.0, [0.93, 0.80, 0.62]),
                        (800.0, [0.99, 0.95, 0.87]),
                    ],
                ))
            },
            Preset::CtLung => Medium {
                density_scale: 1.0,
                surface: surface(220.0, 0.45, 0.04),
                ..Medium::new(tf(
                    &[
                        (-930.0, 0.0),
                        (-830.0, 0.003),
                        (-700.0, 0.014),
                        (-560.0, 0.10),
                        (-400.0, 0.22),
                        (-250.0, 0.05),
                        (-150.0, 0.0),
                        (150.0, 0.0),
                        (250.0, 0.015),
                        (500.0, 0.08),
                        (1200.0, 0.25),
                    ],
                    &[
                        (-850.0, [0.35, 0.62, 0.92]),
                        (-650.0, [0.88, 0.52, 0.46]),
                        (-350.0, [0.90, 0.30, 0.22]),
                        (60.0, [0.80, 0.40, 0.32]),
                        (250.0, [0.93, 0.82, 0.64]),
                        (900.0, [0.99, 0.95, 0.88]),
                    ],
                ))
            },
            Preset::CtAngiography => Medium {
                density_scale: 2.5,
                surface: surface(140.0, 0.32, 0.05),
                ..Medium::new(tf(
                    &[(110.0, 0.0), (160.0, 0.12), (260.0, 0.55), (450.0, 0.6), (700.0, 0.75), (1200.0, 1.0)],
                    &[
                        (110.0, [0.70, 0.07, 0.045]),
                        (220.0, [0.78, 0.06, 0.04]),
                        (330.0, [0.84, 0.13, 0.08]),
                        (520.0, [0.93, 0.76, 0.57]),
                        (900.0, [0.99, 0.95, 0.87]),
                    ],
                ))
            },
            Preset::MrHead => mr_head(volume),
        }
    }
}

/// Skin and fat are bright in T1, the brain in the middle; air is darker than half of Otsu's threshold.
fn mr_head(volume: &Volume) -> Medium {
    let stats = ValueStatistics::new(volume, 4096);
    let air = stats.otsu_threshold();
    let bright = stats.percentile(0.998).max(air * 1.5).max(air + f64::MIN_POSITIVE);
    let at = |t: f64| air + (bright - air) * t;
    let low = stats.range[0] + (air - stats.range[0]) * 0.45;
    Medium {
        density_scale: 2.0,
        surface: SurfaceReflection {
            strength: 1.0,
            gradient_per_mm: (bright - stats.range[0]) * 0.08,
            roughness: 0.45,
            specular: 0.035,
        },
        ..Medium::new(tf(
            &[(low, 0.0), (air, 0.25), (at(0.4), 0.6), (at(1.0), 1.0)],
            &[
                (low, [0.80, 0.45, 0.32]),
                (air, [0.82, 0.47, 0.34]),
                (at(0.4), [0.88, 0.58, 0.43]),
                (at(1.0), [0.94, 0.79, 0.62]),
            ],
        ))
    }
}

fn tf(opacity: &[(f64, f64)], color: &[(f64, [f64; 3])]) -> TransferFunction {
    TransferFunction::from_points(Ease::InOut, opacity, color).expect("presets are valid")
}

/// Levenshtein's distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, &cb) in b.iter().enumerate() {
            let replace = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Voxels;
    use glam::DAffine3;

    #[test]
    fn an_unknown_name_gets_the_nearest() {
        assert_eq!(Preset::from_name("CT_bone"), Ok(Preset::CtBone));
        let nearest = |name| Preset::from_name(name).unwrap_err().nearest;
        assert_eq!(nearest("ct-bome"), Some("ct-bone"));
        assert_eq!(nearest("head"), Some("mr-head"));
        assert_eq!(["fancy", "x", ""].map(nearest), [None; 3]);
        let told = |name| Preset::from_name(name).unwrap_err().to_string();
        assert!(
            told("ct-bome").starts_with("there is no preset 'ct-bome'; did you mean 'ct-bone'? Presets: ")
        );
        assert!(told("fancy").starts_with("there is no preset 'fancy'. Presets: ct-bone, "));
    }

    #[test]
    fn only_hounsfield_units_get_a_look_of_ct() {
        let id = DAffine3::IDENTITY;
        let samples = Voxels::U16(vec![0, 3000]);
        let ct = Volume::new([2, 1, 1], samples, [1.0, -1000.0], id, Modality::Ct).unwrap();
        assert_eq!(Preset::default_for(&ct), Preset::CtMuscle);
        for unit in ["mg/ml", ""] {
            let map = ct.clone().with_unit(unit);
            assert_eq!((Preset::default_for(&map), map.unit()), (Preset::MrHead, unit));
        }
    }

    #[test]
    fn every_preset_shows_something_and_survives_a_constant_volume() {
        let id = DAffine3::IDENTITY;
        let flat = Volume::new([2; 3], Voxels::U16(vec![5; 8]), [1.0, 0.0], id, Modality::Mr).unwrap();
        for preset in Preset::ALL {
            let medium = preset.medium(&flat);
            assert!(!medium.transfer_function.is_transparent(), "{}", preset.name());
            assert_eq!(medium.clone().sanitized(), medium, "{} is within its ranges", preset.name());
        }
    }
}
