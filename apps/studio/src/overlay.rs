//! Structures over slices: each label in its colour.

use eframe::egui::Color32;
use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{LabelVolume, Labelling, UNLABELLED};
use std::sync::Arc;

/// The share of a label's colour over a slice.
const SHARE: f32 = 0.42;

/// What is left of the brightness of what lassos cut away.
const LEFT_OF_CUT: f32 = 0.35;

/// What fills more of a label map than that is no structure, but the body or the air around: it is tinted only if somebody gives it a
/// colour.
const LARGE: f64 = 0.1;

/// How much of a label map each label is.
pub struct Sizes {
    labels: Arc<LabelVolume>,
    whole: Arc<LabelVolume>,
    counts: [u64; 256],
}

impl Sizes {
    /// Counts all voxels.
    pub fn of(labels: &Arc<LabelVolume>) -> Self {
        // However much of them is cut away.
        let whole = labels.cut_away().and_then(|cut| cut.before.clone()).unwrap_or_else(|| labels.clone());
        Self { counts: whole.counts(), whole, labels: labels.clone() }
    }

    /// Whether they are those of a label map.
    pub fn are_of(&self, labels: &Arc<LabelVolume>) -> bool {
        Arc::ptr_eq(&self.labels, labels)
    }

    /// The volume of a label.
    pub fn millilitres(&self, value: u8) -> f64 {
        self.counts[usize::from(value)] as f64 * self.whole.voxel_mm3() / 1e3
    }

    fn share(&self, value: u8) -> f64 {
        self.counts[usize::from(value)] as f64 / self.whole.volume().voxel_count() as f64
    }
}

/// A label map, and the colours in which it lies over slices.
pub struct Overlay {
    labels: Arc<LabelVolume>,
    voxel_from_patient: DAffine3,
    /// By the label's value; what is not to be seen has none.
    colors: [Option<Color32>; 256],
    /// The label of what lassos cut away.
    cut: Option<u8>,
}

impl Overlay {
    /// Of labels that are visible, in their colours.
    pub fn new(labelling: &Labelling, sizes: &Sizes) -> Self {
        let labels = labelling.labels.clone();
        let color = |value: usize| {
            let value = value as u8;
            let label = labels.label(value).filter(|_| value != UNLABELLED)?;
            let style = labelling.style(value);
            let own = (sizes.share(value) <= LARGE).then_some(label.color);
            style.color.or(own).filter(|_| style.visible).map(shown)
        };
        let colors = std::array::from_fn(color);
        let cut = labels.cut_away().map(|cut| cut.value);
        Self { voxel_from_patient: labels.patient_from_voxel().inverse(), colors, cut, labels }
    }

    /// The label that lies at a point of the patient.
    pub fn value_at(&self, point: DVec3) -> Option<u8> {
        let at = self.voxel_from_patient.transform_point3(point).round();
        let dims = self.labels.dims();
        let is_inside = (0..3).all(|axis| at[axis] >= 0.0 && at[axis] < dims[axis] as f64);
        is_inside.then(|| self.labels.value(at.to_array().map(|x| x as usize)))
    }

    /// Whether a label is seen.
    pub fn shows(&self, value: u8) -> bool {
        self.colors[usize::from(value)].is_some()
    }

    /// What a label that is seen is called, and its colour.
    pub fn named(&self, value: u8) -> Option<(String, Color32)> {
        let color = self.colors[usize::from(value)]?;
        Some((self.labels.label(value)?.name.clone(), color))
    }

    /// A pixel with the structure that lies at a point of the patient.
    pub fn over(&self, pixel: Color32, point: DVec3) -> Color32 {
        let value = self.value_at(point).unwrap_or(UNLABELLED);
        if Some(value) == self.cut {
            return Color32::from_gray((f32::from(pixel.r()) * LEFT_OF_CUT) as u8);
        }
        let Some(color) = self.colors[usize::from(value)] else { return pixel };
        let mixed = |own: u8, over: u8| (f32::from(own) * (1.0 - SHARE) + f32::from(over) * SHARE) as u8;
        Color32::from_rgb(
            mixed(pixel.r(), color.r()),
            mixed(pixel.g(), color.g()),
            mixed(pixel.b(), color.b()),
        )
    }
}

/// A linear colour as screens show it.
pub fn shown(color: [f64; 3]) -> Color32 {
    let [r, g, b] = color.map(|c| c as f32);
    eframe::egui::Rgba::from_rgb(r, g, b).into()
}
