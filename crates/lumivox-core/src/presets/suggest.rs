//! Which preset suits a scan when nobody chose one: by modality, by what its file says ([`Subject`](crate::Subject)), and by what its
//! values show.

use std::ops::RangeInclusive;

use glam::DVec3;

use super::{Preset, scale::HounsfieldScale};
use crate::{
    statistics::looks_like_labels,
    subject::{BodyPart, Focus},
    volume::{Modality, Volume},
};

/// Of a slice or a few there is no inside to see through.
const FEW_SLICES: usize = 4;

/// Distance of the places that are looked at, in mm.
const STEP_MM: f64 = 2.0;

/// The most places along an axis.
const MOST_STEPS: usize = 320;

/// The preset that suits a volume.
pub(super) fn suggest(volume: &Volume) -> Preset {
    if volume.dims().into_iter().min() < Some(FEW_SLICES) || looks_like_labels(volume) {
        return Preset::Plain;
    }
    match volume.modality() {
        _ if volume.is_hounsfield() || volume.may_be_hounsfield() => ct(volume),
        Modality::Pet => Preset::PetHot,
        _ if volume.is_signed_map() => Preset::SignedMap,
        _ if volume.is_normalised() => normalised(volume),
        // A CT that lost its scale has air and tissue all the same; maps of iodine, perfusion or dose have one of their own.
        Modality::Ct if volume.unit().is_empty() && !volume.subject().is_other => ct(volume),
        Modality::Ct => Preset::Plain,
        // So has what its file says is something else.
        _ if !volume.unit().is_empty() || volume.subject().is_other => Preset::Plain,
        Modality::Mr | Modality::Other => mr(volume),
    }
}

fn ct(volume: &Volume) -> Preset {
    let subject = volume.subject();
    let content = CtContent::of(volume, HounsfieldScale::of(volume));
    if subject.focus == Some(Focus::Teeth) {
        return Preset::CtTeeth;
    }
    if content.is_bare_bone() {
        return Preset::CtBone;
    }
    if content.is_bare_lung() {
        return Preset::CtLung;
    }
    let part = subject.part.or_else(|| content.part());
    // Agent alone does not make vessels bright: the moment does.
    let bright = match subject.contrast {
        Some(true) => content.blood_ml >= CtContent::FAINT_BLOOD_ML,
        Some(false) => false,
        None => content.bright_blood_ml >= CtContent::BLOOD_ML,
    };
    match (part, subject.focus) {
        (Some(BodyPart::Chest), Some(Focus::Lungs)) => Preset::CtLung,
        (_, Some(Focus::Bone)) => Preset::CtBone,
        // Bone hides most of its vessels: muscles show as many, where these are not what it is about.
        (Some(BodyPart::Head | BodyPart::Neck), Some(Focus::Vessels)) => Preset::CtAngiography,
        (Some(BodyPart::Head | BodyPart::Neck), _) => Preset::CtMuscle,
        // A chest with contrast agent is an atlas of muscles first; the heart is what somebody has to have asked for.
        (Some(BodyPart::Heart), _) if bright => Preset::CtCardiac,
        (Some(BodyPart::Chest), Some(Focus::Vessels)) if bright => Preset::CtCardiac,
        (Some(BodyPart::Abdomen), _) if bright => Preset::CtAorta,
        (Some(BodyPart::Spine | BodyPart::Limb), _) => Preset::CtBone,
        _ => Preset::CtMuscle,
    }
}

fn mr(volume: &Volume) -> Preset {
    /// Bodies and brains fill more of what is scanned, or are thicker than vessels.
    const SPARSE: f64 = 0.06;
    const THICK: f64 = 0.5;
    let subject = volume.subject();
    let statistics = volume.statistics();
    let border = statistics.otsu_threshold();
    let share = statistics.share([border, f64::INFINITY]);
    match (subject.part, subject.focus) {
        (_, Some(Focus::Vessels)) => Preset::MrAngiography,
        // Nothing but vessels is so little of what was scanned.
        _ if share < SPARSE && Places::of(volume).thick_share(border) < THICK => Preset::MrAngiography,
        (_, Some(Focus::BrainAlone)) => Preset::MrBrain,
        _ if !may_be_head(volume, border) => Preset::Plain,
        // Of a coarse scan a skull leaves nothing: only its file could tell that it is stripped.
        (None | Some(BodyPart::Head | BodyPart::Neck), _) if Rim::is_too_coarse(volume) => Preset::MrHead,
        (None | Some(BodyPart::Head | BodyPart::Neck), _) => {
            let rim = Rim::of(volume, border);
            if rim.is_bare_brain() { Preset::MrBrain } else { Preset::MrHead }
        }
        _ => Preset::Plain,
    }
}

/// Of a scan that was normalised and cut out: brains are, mostly.
fn normalised(volume: &Volume) -> Preset {
    let is_other = !volume.unit().is_empty() || volume.subject().is_other;
    let may_be_brain = matches!(volume.subject().part, None | Some(BodyPart::Head | BodyPart::Neck));
    let is_brain = !is_other && may_be_brain && SCANNED_MM.contains(&volume.size_mm().max_element());
    if is_brain && volume.modality() != Modality::Ct { Preset::MrBrain } else { Preset::Plain }
}

/// What is scanned for a head, or with one, in mm.
const SCANNED_MM: RangeInclusive<f64> = 70.0..=700.0;

/// Whether a scan is as large as one of a head. What nothing says to be an MR has to be as round, too: microscopes,
/// ultrasound, fossils and weather make volumes as well.
fn may_be_head(volume: &Volume, border: f64) -> bool {
    SCANNED_MM.contains(&volume.size_mm().max_element())
        && (volume.modality() == Modality::Mr || Rim::of(volume, border).is_of_head())
}

/// A grid of places in a volume, some [`STEP_MM`] apart.
struct Places<'a> {
    volume: &'a Volume,
    /// Voxels from one to the next along each axis.
    stride: [usize; 3],
    dims: [usize; 3],
}

impl<'a> Places<'a> {
    fn of(volume: &'a Volume) -> Self {
        let spacing = volume.spacing_mm().to_array();
        let stride: [usize; 3] = std::array::from_fn(|axis| {
            let n = volume.dims()[axis];
            ((STEP_MM / spacing[axis]).round() as usize).max(n.div_ceil(MOST_STEPS)).clamp(1, n)
        });
        let dims = std::array::from_fn(|axis| volume.dims()[axis].div_ceil(stride[axis]));
        Self { volume, stride, dims }
    }

    fn value(&self, at: [usize; 3]) -> f64 {
        self.volume.value(std::array::from_fn(|axis| at[axis] * self.stride[axis]))
    }

    /// What each stands for, in ml.
    fn ml(&self) -> f64 {
        let step = self.volume.patient_from_voxel().matrix3.determinant().abs();
        step * self.stride.iter().product::<usize>() as f64 / 1000.0
    }

    /// Of the places above `border`, the share all of whose neighbours are, too.
    fn thick_share(&self, border: f64) -> f64 {
        let (mut above, mut thick) = (0u64, 0u64);
        for at in self.all().filter(|at| self.value(*at) > border) {
            let is_above = |axis: usize, up: bool| {
                let mut beside = at;
                beside[axis] = if up { at[axis] + 1 } else { at[axis].wrapping_sub(1) };
                beside[axis] < self.dims[axis] && self.value(beside) > border
            };
            above += 1;
            thick += u64::from((0..3).all(|axis| is_above(axis, false) && is_above(axis, true)));
        }
        thick as f64 / above.max(1) as f64
    }

    fn all(&self) -> impl Iterator<Item = [usize; 3]> {
        let [nx, ny, nz] = self.dims;
        (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
    }
}

/// What the values of a CT show.
#[derive(Clone, Copy, Debug, Default)]
struct CtContent {
    lungs_ml: f64,
    soft_ml: f64,
    bone_ml: f64,
    /// What is as even as blood, and as bright as it is with contrast agent.
    blood_ml: f64,
    /// The part of it that is brighter than the inside of any vertebra.
    bright_blood_ml: f64,
    /// Extent of what is no air, in mm.
    extent_mm: DVec3,
}

impl CtContent {
    /// What is air in part, as lungs are: less dense than fat, denser than air and foam.
    const LUNG: [f64; 2] = [-900.0, -600.0];
    /// Lungs of a child are larger.
    const LUNGS_ML: f64 = 350.0;
    /// Bones have no so large parts that are so even.
    const BLOOD_ML: f64 = 12.0;
    /// Vertebrae are as bright as faint blood.
    const FAINT_BLOOD_ML: f64 = 40.0;
    /// Neighbours in blood differ less.
    const EVEN: f64 = 70.0;
    const BLOOD: [f64; 2] = [160.0, 650.0];
    const BRIGHT: f64 = 230.0;
    /// A head is narrower.
    const HEAD_MM: f64 = 290.0;

    fn of(volume: &Volume, scale: HounsfieldScale) -> Self {
        let places = Places::of(volume);
        let hounsfield = |at: [usize; 3]| scale.hounsfield(places.value(at));
        let (dims, ml) = (places.dims, places.ml());
        let mut content = Self::default();
        let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
        for at in places.all() {
            let value = hounsfield(at);
            let is_inside = (0..3).all(|axis| at[axis] > 0 && at[axis] + 1 < dims[axis]);
            let beside = |axis: usize, up: bool| {
                let mut beside = at;
                beside[axis] = if up { at[axis] + 1 } else { at[axis] - 1 };
                hounsfield(beside)
            };
            let all_beside = |test: &dyn Fn(f64) -> bool| {
                is_inside && (0..3).all(|axis| test(beside(axis, false)) && test(beside(axis, true)))
            };
            match value {
                // The rims of everything have such values, too: inside of lungs, all around are like it.
                v if v < Self::LUNG[1] => {
                    let is_lung = |v: f64| (Self::LUNG[0]..Self::LUNG[1] + 200.0).contains(&v);
                    content.lungs_ml += if is_lung(v) && all_beside(&is_lung) { ml } else { 0.0 };
                    continue;
                }
                v if v < -200.0 => continue,
                v if v < 150.0 => content.soft_ml += ml,
                v => {
                    content.bone_ml += if v > 300.0 { ml } else { 0.0 };
                    let is_even = |beside: f64| (beside - v).abs() < Self::EVEN;
                    if (Self::BLOOD[0]..Self::BLOOD[1]).contains(&v) && all_beside(&is_even) {
                        content.blood_ml += ml;
                        content.bright_blood_ml += if v >= Self::BRIGHT { ml } else { 0.0 };
                    }
                }
            }
            for axis in 0..3 {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
        }
        let spacing = volume.spacing_mm().to_array();
        let extent = |axis: usize| {
            (high[axis] + 1).saturating_sub(low[axis]) as f64 * places.stride[axis] as f64 * spacing[axis]
        };
        content.extent_mm = DVec3::new(extent(0), extent(1), extent(2));
        content
    }

    /// Whether it is bone without flesh.
    fn is_bare_bone(&self) -> bool {
        self.bone_ml > 50.0 && self.soft_ml < 1.5 * self.bone_ml
    }

    /// Whether it is lungs that were cut out of their body.
    fn is_bare_lung(&self) -> bool {
        self.lungs_ml > 50.0 && self.soft_ml < 0.35 * self.lungs_ml
    }

    fn part(&self) -> Option<BodyPart> {
        if self.lungs_ml >= Self::LUNGS_ML {
            return Some(BodyPart::Chest);
        }
        let is_narrow = self.extent_mm.max_element() <= Self::HEAD_MM;
        // No other part has so much bone.
        (is_narrow && self.bone_ml > 0.08 * self.soft_ml).then_some(BodyPart::Head)
    }
}

/// What lies below the surface of a head in MR, as rays to its middle see it.
#[derive(Clone, Copy, Debug, Default)]
struct Rim {
    rays: u32,
    /// Mean distance of the surface from the middle, in mm.
    radius_mm: f64,
    /// Of the rays, the ones that cross a dark layer as thick as a skull, below a bright one.
    with_skull: u32,
}

impl Rim {
    /// Directions, even over a sphere.
    const RAYS: u32 = 400;
    /// Where bone begins and ends below the surface, in mm.
    const DEPTH_MM: f64 = 26.0;
    /// Thinner layers may be furrows.
    const SKULL_MM: f64 = 3.0;
    /// A brain is so large.
    const RADIUS_MM: RangeInclusive<f64> = 35.0..=100.0;
    /// Rays through air, nose and neck tell nothing.
    const LEAST: u32 = 60;

    /// Whether no layer as thick as a skull can be dark, along rays within slices either.
    fn is_too_coarse(volume: &Volume) -> bool {
        let mut spacing = volume.spacing_mm().to_array();
        spacing.sort_by(f64::total_cmp);
        spacing[1] > Self::SKULL_MM
    }

    fn of(volume: &Volume, border: f64) -> Self {
        let places = Places::of(volume);
        let (mut sum, mut count) = (DVec3::ZERO, 0.0f64);
        for at in places.all().filter(|at| places.value(*at) > border) {
            sum += DVec3::from_array(std::array::from_fn(|axis| (at[axis] * places.stride[axis]) as f64));
            count += 1.0;
        }
        let centre = sum / count.max(1.0);
        let spacing = volume.spacing_mm();
        let value = |place: DVec3| {
            let at: [i64; 3] = std::array::from_fn(|axis| place[axis].round() as i64);
            let dims = volume.dims();
            let inside = (0..3).all(|axis| (0..dims[axis] as i64).contains(&at[axis]));
            inside.then(|| volume.value(at.map(|i| i as usize)))
        };
        const STEP: f64 = 0.7;
        let mut rim = Self::default();
        for ray in 0..Self::RAYS {
            // Fibonacci's sphere.
            let z = 1.0 - 2.0 * (f64::from(ray) + 0.5) / f64::from(Self::RAYS);
            let turn = f64::from(ray) * std::f64::consts::PI * (3.0 - 5f64.sqrt());
            let radius = (1.0 - z * z).sqrt();
            let direction = DVec3::new(radius * turn.cos(), radius * turn.sin(), z) * STEP / spacing;
            let along: Vec<f64> =
                (0..500).map_while(|step| value(centre + direction * f64::from(step))).collect();
            let Some(surface) = along.iter().rposition(|value| *value > border) else { continue };
            // The field of view cuts the body there.
            if surface + 3 >= along.len() {
                continue;
            }
            let deepest = surface.saturating_sub((Self::DEPTH_MM / STEP) as usize);
            rim.rays += 1;
            rim.radius_mm += surface as f64 * STEP;
            let mut dark = 0.0;
            for value in along[deepest..surface].iter().rev() {
                dark = if *value < border { dark + STEP } else { 0.0 };
                if dark >= Self::SKULL_MM {
                    rim.with_skull += 1;
                    break;
                }
            }
        }
        rim.radius_mm /= f64::from(rim.rays.max(1));
        rim
    }

    /// Whether it has the size of a head, or of a brain, on most sides.
    fn is_of_head(&self) -> bool {
        const RADIUS_MM: RangeInclusive<f64> = 40.0..=140.0;
        RADIUS_MM.contains(&self.radius_mm) && self.rays >= Self::LEAST
    }

    fn is_bare_brain(&self) -> bool {
        let is_of_size = Self::RADIUS_MM.contains(&self.radius_mm);
        is_of_size && self.rays >= Self::LEAST && f64::from(self.with_skull) < 0.3 * f64::from(self.rays)
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::{subject::Subject, volume::Voxels};

    /// A scan of 2 mm voxels, by their distance from the middle in mm.
    fn scan(dims: [usize; 3], modality: Modality, value: impl Fn(DVec3) -> f64) -> Volume {
        let [nx, ny, nz] = dims;
        let middle = DVec3::from_array(dims.map(|n| n as f64)) - 1.0;
        let at = |i: usize| {
            let place = [i % nx, i / nx % ny, i / (nx * ny)].map(|i| 2.0 * i as f64);
            (value(DVec3::from_array(place) - middle) + 1024.0) as u16
        };
        let voxels = Voxels::U16((0..nx * ny * nz).map(at).collect());
        let place = DAffine3::from_scale(DVec3::splat(2.0));
        Volume::new(dims, voxels, [1.0, -1024.0], place, modality).unwrap()
    }

    fn is_in(at: DVec3, middle: [f64; 3], half: [f64; 3]) -> bool {
        ((at - DVec3::from_array(middle)) / DVec3::from_array(half)).length() < 1.0
    }

    /// A body with lungs, and blood so bright.
    fn chest(blood: f64) -> Volume {
        scan([170, 120, 100], Modality::Ct, move |at| match () {
            () if is_in(at, [0.0, 0.0, 0.0], [26.0, 30.0, 40.0]) => blood,
            () if is_in(at, [75.0, 0.0, 0.0], [45.0, 70.0, 85.0]) => -850.0,
            () if is_in(at, [-75.0, 0.0, 0.0], [45.0, 70.0, 85.0]) => -850.0,
            () if is_in(at, [0.0, 0.0, 0.0], [160.0, 110.0, 900.0]) => 40.0,
            () => -1000.0,
        })
    }

    /// Brain, fluid, skull and scalp of a head, outside of which is air.
    fn head([air, brain, skull, scalp]: [f64; 4], modality: Modality) -> Volume {
        // No two voxels of a scan are alike.
        let noise = |at: DVec3| (at.x * 3.0 + at.y * 5.0 + at.z * 7.0).abs() % 16.0;
        scan([100, 100, 100], modality, move |at| match at.length() {
            r if r < 72.0 => brain + noise(at),
            r if r < 80.0 => skull + noise(at),
            r if r < 88.0 => scalp + noise(at),
            _ => air,
        })
    }

    fn subject(text: &str) -> Subject {
        Subject::of_texts([text])
    }

    #[test]
    fn lungs_and_blood_are_found_in_a_ct() {
        assert_eq!(suggest(&chest(40.0)), Preset::CtMuscle);
        assert_eq!(
            CtContent::of(&chest(40.0), HounsfieldScale::of(&chest(40.0))).part(),
            Some(BodyPart::Chest)
        );
        // Contrast agent alone does not ask for the heart.
        assert_eq!(suggest(&chest(350.0)), Preset::CtMuscle);
        assert_eq!(suggest(&chest(350.0).with_subject(subject("heart"))), Preset::CtCardiac);
        assert_eq!(suggest(&chest(350.0).with_subject(subject("CTA thorax"))), Preset::CtCardiac);
        // Of faint blood the file has to say that there is an agent.
        assert_eq!(suggest(&chest(180.0).with_subject(subject("heart"))), Preset::CtMuscle);
        assert_eq!(suggest(&chest(180.0).with_subject(subject("heart arterial"))), Preset::CtCardiac);
        assert_eq!(suggest(&chest(40.0).with_subject(subject("heart arterial"))), Preset::CtMuscle);
        assert_eq!(suggest(&chest(350.0).with_subject(subject("thorax native"))), Preset::CtMuscle);
        assert_eq!(suggest(&chest(40.0).with_subject(subject("thorax lung"))), Preset::CtLung);
        assert_eq!(suggest(&chest(350.0).with_subject(subject("abdomen"))), Preset::CtAorta);
    }

    #[test]
    fn a_lung_that_was_cut_out_is_shown_as_one() {
        let lung = |outside: f64| {
            scan([60, 80, 90], Modality::Ct, move |at| match () {
                () if !is_in(at, [0.0, 0.0, 0.0], [45.0, 70.0, 80.0]) => outside,
                // Vessels.
                () if (at.x / 20.0).fract().abs() < 0.2 && (at.y / 20.0).fract().abs() < 0.3 => 40.0,
                () => -850.0,
            })
        };
        assert_eq!([-1024.0, -1000.0].map(|outside| suggest(&lung(outside))), [Preset::CtLung; 2]);
        // In its body it is a chest.
        assert_eq!(suggest(&lung(40.0)), Preset::CtMuscle);
    }

    #[test]
    fn heads_and_bones_are_found_in_a_ct() {
        let ct = head([-1000.0, 40.0, 1000.0, 40.0], Modality::Ct);
        assert_eq!(CtContent::of(&ct, HounsfieldScale::of(&ct)).part(), Some(BodyPart::Head));
        assert_eq!(suggest(&ct), Preset::CtMuscle);
        for (words, preset) in [
            ("CTA head", Preset::CtAngiography),
            ("dental", Preset::CtTeeth),
            ("head bone", Preset::CtBone),
            ("c-spine", Preset::CtBone),
            ("knee", Preset::CtBone),
        ] {
            assert_eq!(suggest(&ct.clone().with_subject(subject(words))), preset, "{words}");
        }
        let bare = head([-1000.0, -1000.0, 1000.0, -1000.0], Modality::Ct);
        assert_eq!(suggest(&bare), Preset::CtBone);
        // Of which nothing says what it is.
        let unknown = ct.with_modality(Modality::Other);
        assert_eq!(suggest(&unknown), Preset::CtMuscle);
    }

    #[test]
    fn a_bare_brain_is_told_from_a_head_in_mr() {
        for modality in [Modality::Mr, Modality::Other] {
            assert_eq!(suggest(&head([5.0, 400.0, 20.0, 800.0], modality)), Preset::MrHead);
            let brain = head([0.0, 400.0, 0.0, 0.0], modality).with_unit("");
            assert_eq!(suggest(&brain.with_subject(subject("brain"))), Preset::MrBrain);
        }
        let head = head([5.0, 400.0, 20.0, 800.0], Modality::Mr);
        assert_eq!(suggest(&head.clone().with_subject(subject("TOF"))), Preset::MrAngiography);
        assert_eq!(suggest(&head.with_subject(subject("knee"))), Preset::Plain, "no head");
    }

    #[test]
    fn not_all_that_is_scanned_is_a_head() {
        let noise = |at: DVec3| (at.x * 3.0 + at.y * 5.0 + at.z * 7.0).abs() % 16.0;
        let ball = |at: DVec3| noise(at) + if at.length() < 80.0 { 400.0 } else { 0.0 };
        let of_size = |mm: f64| {
            let scan = scan([100, 100, 100], Modality::Other, ball).with_unit("");
            let place = DAffine3::from_scale(DVec3::splat(mm));
            Volume::new(scan.dims(), scan.voxels().clone(), [1.0, -1024.0], place, Modality::Other).unwrap()
        };
        assert_eq!(suggest(&of_size(2.0)), Preset::MrBrain);
        // A cell, a fossil, weather.
        for mm in [1e-3, 0.05, 1e4] {
            assert_eq!(suggest(&of_size(mm)), Preset::Plain, "voxels of {mm} mm");
            assert_eq!(suggest(&of_size(mm).with_modality(Modality::Mr)), Preset::Plain, "voxels of {mm} mm");
        }
        // A sector of ultrasound reaches to the edge of its box; a sheet of rock is not round.
        let sheet = |at: DVec3| noise(at) + if at.y.abs() < 12.0 { 400.0 } else { 0.0 };
        assert_eq!(suggest(&scan([100, 100, 100], Modality::Other, sheet)), Preset::Plain);
    }

    #[test]
    fn a_coarse_head_is_a_head_and_a_dose_none() {
        let skull = |at: DVec3| match at.length() {
            r if r < 72.0 => 400.0,
            // What voxels of 5 mm leave of a thin skull.
            r if r < 77.0 => 300.0,
            r if r < 84.0 => 800.0,
            _ => 5.0,
        } + (at.x * 3.0 + at.y * 5.0 + at.z * 7.0).abs() % 16.0;
        let fine = scan([90, 90, 90], Modality::Mr, skull);
        let coarse = |mm: [f64; 3]| {
            let place = DAffine3::from_scale(DVec3::from_array(mm));
            Volume::new(fine.dims(), fine.voxels().clone(), [1.0, -1024.0], place, fine.modality()).unwrap()
        };
        assert_eq!((suggest(&fine), suggest(&coarse([5.0; 3]))), (Preset::MrBrain, Preset::MrHead));
        // Thick slices show a skull, within each.
        assert!(
            Rim::is_too_coarse(&coarse([2.0, 5.0, 5.0])) && !Rim::is_too_coarse(&coarse([2.0, 2.0, 5.0]))
        );
        let subject = Subject { is_other: true, ..Default::default() };
        assert_eq!(suggest(&fine.with_modality(Modality::Other).with_subject(subject)), Preset::Plain);
    }

    #[test]
    fn what_is_little_but_bright_is_an_angiogram() {
        let vessels =
            |at: DVec3| if at.x.abs() < 5.0 && at.y.abs() < 5.0 { 500.0 } else { at.x.abs() / 50.0 };
        assert_eq!(suggest(&scan([100, 100, 100], Modality::Mr, vessels)), Preset::MrAngiography);
        // A brain in a wide field of view is no more, but thick.
        let brain = |at: DVec3| {
            let body = if at.length() < 60.0 { 400.0 } else { 0.0 };
            body + (at.x * 3.0 + at.y * 5.0 + at.z * 7.0).abs() % 16.0
        };
        assert_eq!(suggest(&scan([130, 130, 130], Modality::Mr, brain)), Preset::MrBrain);
    }

    #[test]
    fn label_maps_get_no_look_of_a_head() {
        let blocks = |at: DVec3| if at.length() < 60.0 { 2.0 + (at.x / 30.0).floor() } else { 0.0 };
        let map = scan([80, 80, 80], Modality::Other, blocks);
        let map = map.edit(|voxels| {
            if let Voxels::U16(all) = voxels {
                all.iter_mut().for_each(|v| *v -= 1024)
            }
        });
        let voxels = map.unwrap().voxels().clone();
        let map = Volume::new([80; 3], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap();
        assert_eq!(suggest(&map), Preset::Plain);
        // The same values, of an MR.
        assert_ne!(suggest(&map.with_modality(Modality::Mr)), Preset::Plain);
    }
}
