//! Looks that suit a kind of scan at once.
//!
//! CT presets are given in Hounsfield units and placed by a scale of air and tissue where a scan has others. MR and PET have
//! no fixed scale, so their presets place themselves by the scan's own statistics.

mod ct;
mod scale;
mod signed;
mod size;
mod statistical;
mod suggest;

use glam::DAffine3;

use crate::{
    medium::{Medium, SurfaceReflection},
    spelling::edit_distance,
    transfer_function::{Ease, TransferFunction},
    volume::{Modality, Volume, Voxels},
};
use scale::HounsfieldScale;
pub use size::size_factor;

/// A named look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Preset {
    /// Skeleton, with vessels where contrast makes them as dense.
    CtBone,
    /// Bone that shows what is inside and behind it.
    CtBoneTranslucent,
    /// The surface of the body, as if alive.
    CtSkin,
    /// Organs and muscle in translucent fat.
    CtSoftTissue,
    /// Muscle and organs under clear fat, with vessels and bone.
    CtMuscle,
    /// Fat, before bone and a trace of muscle.
    CtFat,
    /// Airways and vessels of the lung in a clear body.
    CtLung,
    /// Windpipe and bronchi in a haze of the lungs.
    CtAirways,
    /// Vessels of the lungs in a haze of them.
    CtLungVessels,
    /// Myocardium and contrast-filled chambers and vessels.
    CtCardiac,
    /// Arteries full of contrast, and calcium in them.
    CtCoronary,
    /// Large arteries before bone that hardly shows.
    CtAorta,
    /// Vessels with a little contrast in translucent organs.
    CtLiverVessels,
    /// Contrast-filled vessels before translucent bone.
    CtAngiography,
    /// Enamel, dentine and the densest bone.
    CtTeeth,
    /// Metal, with a trace of bone.
    CtMetal,
    /// Everything at once, as on a radiograph.
    CtXray,
    /// Skin and brain of a head.
    MrHead,
    /// Grey and white matter, where nothing lies before them.
    MrBrain,
    /// The brightest of an MR: vessels of an angiogram.
    MrAngiography,
    /// Fluid, bright in T2, in translucent tissue.
    MrT2,
    /// Both sides of a map around its commonest value, which is clear.
    SignedMap,
    /// Uptake, glowing from dark red to white.
    PetHot,
    /// A body as of grey glass, for a PET in its place.
    Fusion,
    /// Brighter values denser and lighter, whatever the scan.
    Plain,
}

/// An organ that a look can show alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[derive(serde::Serialize, serde::Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Organ {
    /// Windpipe and bronchi.
    Airways,
    /// Vessels within the lungs.
    LungVessels,
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
    pub const ALL: [Preset; 25] = [
        Preset::CtBone,
        Preset::CtBoneTranslucent,
        Preset::CtSkin,
        Preset::CtSoftTissue,
        Preset::CtMuscle,
        Preset::CtFat,
        Preset::CtLung,
        Preset::CtAirways,
        Preset::CtLungVessels,
        Preset::CtCardiac,
        Preset::CtCoronary,
        Preset::CtAorta,
        Preset::CtLiverVessels,
        Preset::CtAngiography,
        Preset::CtTeeth,
        Preset::CtMetal,
        Preset::CtXray,
        Preset::MrHead,
        Preset::MrBrain,
        Preset::MrAngiography,
        Preset::MrT2,
        Preset::SignedMap,
        Preset::PetHot,
        Preset::Fusion,
        Preset::Plain,
    ];

    /// The name people type.
    pub fn name(self) -> &'static str {
        match self {
            Preset::CtBone => "ct-bone",
            Preset::CtBoneTranslucent => "ct-bone-translucent",
            Preset::CtSkin => "ct-skin",
            Preset::CtSoftTissue => "ct-soft-tissue",
            Preset::CtMuscle => "ct-muscle",
            Preset::CtFat => "ct-fat",
            Preset::CtLung => "ct-lung",
            Preset::CtAirways => "ct-airways",
            Preset::CtLungVessels => "ct-lung-vessels",
            Preset::CtCardiac => "ct-cardiac",
            Preset::CtCoronary => "ct-coronary",
            Preset::CtAorta => "ct-aorta",
            Preset::CtLiverVessels => "ct-liver-vessels",
            Preset::CtAngiography => "ct-angiography",
            Preset::CtTeeth => "ct-teeth",
            Preset::CtMetal => "ct-metal",
            Preset::CtXray => "ct-xray",
            Preset::MrHead => "mr-head",
            Preset::MrBrain => "mr-brain",
            Preset::MrAngiography => "mr-angiography",
            Preset::MrT2 => "mr-t2",
            Preset::SignedMap => "signed-map",
            Preset::PetHot => "pet-hot",
            Preset::Fusion => "fusion",
            Preset::Plain => "plain",
        }
    }

    /// The presets that suit several scans of one place at once, in their order: a PET glows in a CT or else an MR, and of a
    /// signed map its peaks alone are seen in the anatomy. `None` where they are no such pair.
    pub fn fusion_of(volumes: &[&Volume]) -> Option<Vec<Self>> {
        let [a, b] = volumes else { return None };
        match (a.modality(), b.modality()) {
            (Modality::Ct | Modality::Mr, Modality::Pet) => Some(vec![Self::Fusion, Self::PetHot]),
            (Modality::Pet, Modality::Ct | Modality::Mr) => Some(vec![Self::PetHot, Self::Fusion]),
            _ => match [a, b].map(|volume| Self::default_for(volume) == Self::SignedMap) {
                [false, true] => Some(vec![Self::Fusion, Self::SignedMap]),
                [true, false] => Some(vec![Self::SignedMap, Self::Fusion]),
                _ => None,
            },
        }
    }

    /// How much of the skin is to be taken off a scan before this look shows what it is for, in mm, where skin is as dense
    /// as muscle. `lumivox_segmentation::skin_is_dense` tells, and `peel_skin` does it.
    pub fn peel_mm(self) -> f64 {
        match self {
            Preset::CtMuscle => 2.5,
            _ => 0.0,
        }
    }

    /// What is to be shown alone before this look shows what it is for, since the body has its values elsewhere, too.
    /// `lumivox_segmentation::organ_alone` does it.
    pub fn organ(self) -> Option<Organ> {
        match self {
            Preset::CtAirways => Some(Organ::Airways),
            Preset::CtLungVessels => Some(Organ::LungVessels),
            _ => None,
        }
    }

    /// One line on what it shows.
    pub fn description(self) -> &'static str {
        match self {
            Preset::CtBone => "the skeleton, white and crisp",
            Preset::CtBoneTranslucent => "the skeleton as of glass",
            Preset::CtSkin => "skin and soft tissue",
            Preset::CtSoftTissue => "organs and muscle in translucent fat",
            Preset::CtMuscle => "muscle, organs and vessels under clear fat, with bone",
            Preset::CtFat => "fat, with bone and a trace of muscle",
            Preset::CtLung => "airways and vessels of the lung in a clear body",
            Preset::CtAirways => "windpipe and bronchi in a haze of the lungs",
            Preset::CtLungVessels => "vessels of the lungs in a haze of them",
            Preset::CtCardiac => "the heart and great vessels, filled with contrast",
            Preset::CtCoronary => "arteries full of contrast alone, as of the heart",
            Preset::CtAorta => "the aorta and its branches before faint bone",
            Preset::CtLiverVessels => "vessels with contrast in translucent organs",
            Preset::CtAngiography => "contrast-filled vessels before translucent bone",
            Preset::CtTeeth => "teeth and the densest bone",
            Preset::CtMetal => "implants and other metal, with a trace of bone",
            Preset::CtXray => "everything at once, as on a radiograph",
            Preset::MrHead => "a head from MR, placed by the scan's own statistics",
            Preset::MrBrain => "grey and white matter, where nothing lies before them",
            Preset::MrAngiography => "what is brightest in an MR: vessels of an angiogram",
            Preset::MrT2 => "fluid in translucent tissue, as T2 shows it",
            Preset::SignedMap => {
                "what lies far above (red) and below (blue) a map's commonest value, which is clear"
            }
            Preset::PetHot => "uptake, from dark red to white",
            Preset::Fusion => "a CT or MR as of grey glass, for a PET (pet-hot) that is seen in it",
            Preset::Plain => "brighter values denser and lighter, whatever the scan",
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

    /// The preset that suits a volume when nobody chose one: by modality, by what its file says of it
    /// ([`Volume::subject`]) and by what its values show (lungs, vessels with contrast agent, a bare brain).
    pub fn default_for(volume: &Volume) -> Self {
        suggest::suggest(volume)
    }

    /// The look where there is no scan yet; `None` for those that place themselves by a scan's values.
    pub fn medium_without_scan(self) -> Option<Medium> {
        let any = Volume::new([1; 3], Voxels::U8(vec![0]), [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct);
        // It is no body by its size, but what comes will be one.
        any.ok().filter(|_| ct::look(self).is_some()).map(|any| self.body_sized(&any))
    }

    /// The look, placed for `volume`; its extinction, where that is no body by its size, by [`size_factor`].
    pub fn medium(self, volume: &Volume) -> Medium {
        let mut medium = self.body_sized(volume);
        let factor = size_factor(volume);
        medium.density_scale *= factor;
        medium.surface.gradient_per_mm *= factor;
        medium
    }

    fn body_sized(self, volume: &Volume) -> Medium {
        match (ct::look(self), self) {
            (Some(look), _) => HounsfieldScale::of(volume).medium(&look),
            (None, Self::SignedMap) => signed::medium(volume),
            (None, _) => statistical::medium(self, volume),
        }
    }
}

/// A look as it is written down: values in units of whoever places it.
struct Look {
    density_scale: f64,
    surface: SurfaceReflection,
    opacity: &'static [(f64, f64)],
    color: &'static [(f64, [f64; 3])],
}

/// Of presets: matte ones have a roughness of about .45, wet ones less.
const fn surface(gradient_per_mm: f64, roughness: f64, specular: f64) -> SurfaceReflection {
    SurfaceReflection { strength: 1.0, gradient_per_mm, roughness, specular, ..SurfaceReflection::OFF }
}

fn tf(opacity: &[(f64, f64)], color: &[(f64, [f64; 3])]) -> TransferFunction {
    TransferFunction::from_points(Ease::InOut, opacity, color).expect("presets are valid")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{subject::Subject, volume::Voxels};
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
        let samples = Voxels::U16([0, 3000].repeat(32));
        let ct = Volume::new([4; 3], samples, [1.0, -1000.0], id, Modality::Ct).unwrap();
        assert_eq!(Preset::default_for(&ct), Preset::CtMuscle);
        let is_other = Subject { is_other: true, ..Subject::default() };
        for unit in ["mg/ml", ""] {
            let map = ct.clone().with_unit(unit).with_subject(is_other);
            assert_eq!((Preset::default_for(&map), map.unit()), (Preset::Plain, unit));
        }
        // One that is no map has lost its scale, and is placed by its air and tissue.
        assert_ne!(Preset::default_for(&ct.with_unit("")), Preset::Plain);
    }

    #[test]
    fn looks_without_a_scan_are_those_of_a_body() {
        let place = DAffine3::from_scale(glam::DVec3::splat(50.0));
        let body = Voxels::U16([0, 1040, 2000, 500].repeat(16));
        let body = Volume::new([4; 3], body, [1.0, -1000.0], place, Modality::Ct).unwrap();
        for preset in Preset::ALL {
            let without = preset.medium_without_scan();
            assert_eq!(without.is_some(), ct::look(preset).is_some(), "{}", preset.name());
            assert!(without.is_none_or(|medium| medium == preset.medium(&body)), "{}", preset.name());
        }
    }

    #[test]
    fn what_is_no_scan_of_a_body_gets_no_look_of_a_head() {
        let new = |dims: [usize; 3], modality| {
            let samples = Voxels::U8((0..dims.iter().product::<usize>()).map(|i| i as u8).collect());
            let place = DAffine3::from_scale(glam::DVec3::splat(25.0));
            Volume::new(dims, samples, [1.0, 0.0], place, modality).unwrap()
        };
        assert_eq!(Preset::default_for(&new([8; 3], Modality::Mr)), Preset::MrHead);
        assert_eq!(Preset::default_for(&new([8; 3], Modality::Pet)), Preset::PetHot);
        assert_eq!(Preset::default_for(&new([16, 16, 1], Modality::Mr)), Preset::Plain);
        assert_eq!(Preset::default_for(&new([16, 16, 3], Modality::Ct)), Preset::Plain);
    }

    #[test]
    fn every_preset_shows_something_and_survives_a_constant_volume() {
        let id = DAffine3::IDENTITY;
        let flat = Volume::new([2; 3], Voxels::U16(vec![5; 8]), [1.0, 0.0], id, Modality::Mr).unwrap();
        for preset in Preset::ALL {
            let medium = preset.medium(&flat);
            assert!(!medium.transfer_function.is_transparent(), "{}", preset.name());
            assert_eq!(medium.clone().sanitized(), medium, "{} is within its ranges", preset.name());
            // A mask in which nothing is set hides nothing.
            let is_placed = ct::look(preset).is_none();
            assert!(!is_placed || medium.transfer_function.opacity(5.0) == 0.0, "{}", preset.name());
        }
    }
}
