//! What cuts a scan open, and what its voxels are.

use std::path::PathBuf;

use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};

use super::{
    color::Color,
    look::{Reflection, Surface, surface},
    numbers::{Faults, METRES_PER_MM, Rows, affine, rows},
    ranges,
};
use crate::{
    classification::{ClipKind, ClipShape, LabelStyle},
    lasso::{Lasso, MOST_LASSO_POINTS},
    medium::SurfaceReflection,
    presets::Preset,
    transfer_function::TransferFunction,
    volume::Volume,
};

/// A shape that cuts a scan open.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// A plane keeps where its z is 0 and more, a box from -1 to 1 along its axes, a sphere within 1.
    pub kind: ClipKind,
    /// Its own space to that of `space`, in mm.
    #[cfg_attr(test, schemars(transform = ranges::COORDINATE.said()))]
    pub from_shape: Rows,
    /// The space that it lies in.
    #[serde(default)]
    pub space: Space,
    /// Whether what is outside of it is kept.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub inverted: bool,
}

/// A space that shapes lie in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Space {
    /// The patient's: LPS.
    #[default]
    Patient,
    /// The scene's: x to the right, y up, z to the viewer.
    World,
}

impl Shape {
    /// A shape of a volume, as it lies in the patient.
    pub fn of(shape: &ClipShape) -> Self {
        let ClipShape { kind, patient_from_shape, inverted } = *shape;
        Self { kind, from_shape: rows(patient_from_shape), space: Space::Patient, inverted }
    }

    /// The shape for a volume that is placed so; world metres from the patient's millimetres.
    pub fn placed(&self, world_from_patient: DAffine3) -> ClipShape {
        let own = affine(self.from_shape);
        let patient_from_shape = match self.space {
            Space::Patient => own,
            Space::World => {
                world_from_patient.inverse() * DAffine3::from_scale(DVec3::splat(METRES_PER_MM)) * own
            }
        };
        ClipShape { kind: self.kind, patient_from_shape, inverted: self.inverted }
    }

    pub(super) fn check(&self, faults: &mut Faults) {
        faults.matrix("from_shape", Some(&self.from_shape));
    }
}

/// Looks for what is wrong with a lasso.
pub(super) fn check_lasso(lasso: &Lasso, faults: &mut Faults) {
    faults.matrix("from_picture", Some(&lasso.from_picture));
    let count = lasso.points.len();
    faults.unless((3..=MOST_LASSO_POINTS).contains(&count), "points", || {
        format!("there are {count} points, where 3 to {MOST_LASSO_POINTS} are needed")
    });
    for number in lasso.points.as_flattened() {
        faults.number("points", Some(*number), ranges::COORDINATE);
    }
}

/// Which of a scan's voxels are what, and how each looks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Labels {
    /// A DICOM SEG, NIfTI, NRRD or MetaImage file, or several that are one map; without any, what is found in the scan itself.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(test, schemars(inner(length(min = 1))))]
    pub files: Vec<PathBuf>,
    /// A file that names labels by their numbers, besides their own names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<PathBuf>,
    /// What was read, so that another map in its place is told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub content: Option<String>,
    /// How labels look, in turn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub styles: Vec<Style>,
}

/// How a label looks; what is not said is as it was.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Style {
    /// The label's name, else its number in the file (`#2` where a name is a number), or `*` for all.
    pub label: String,
    /// Whether it is there at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub visible: Option<bool>,
    /// Its colour in place of the transfer function's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
    /// A preset whose opacity, colour, density and reflection it takes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
    /// Its transfer function.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer_function: Option<TransferFunction>,
    /// Factor on its extinction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::DENSITY.said()))]
    pub density: Option<f64>,
    /// Multiplies its opacity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::FRACTION.said()))]
    pub opacity: Option<f64>,
    /// Its surface reflection.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
    /// Whether clip shapes cut it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clipped: Option<bool>,
}

impl Style {
    /// What a style says of a label.
    pub fn of(label: String, style: &LabelStyle) -> Self {
        Self {
            label,
            visible: Some(style.visible),
            color: style.color.map(Color::Rgb),
            preset: None,
            transfer_function: style.transfer_function.clone(),
            density: style.density_scale,
            opacity: Some(style.opacity),
            surface: style.surface.map(|surface| Surface::Is(Reflection::of(surface))),
            clipped: Some(style.clipped),
        }
    }

    /// Changes the style of a label that has a colour of its own, in a scan whose look has such surfaces.
    pub fn apply(
        &self,
        own_color: Option<[f64; 3]>,
        volume: &Volume,
        surfaces: SurfaceReflection,
        style: &mut LabelStyle,
    ) {
        if let Some(preset) = self.preset {
            let medium = preset.medium(volume);
            style.transfer_function = Some(medium.transfer_function);
            style.density_scale = Some(medium.density_scale);
            style.surface = Some(medium.surface);
        }
        if let Some(function) = &self.transfer_function {
            style.transfer_function = Some(function.clone());
        }
        match self.color {
            Some(Color::Own(true)) => style.color = own_color,
            Some(Color::Own(false)) => style.color = None,
            Some(Color::Rgb(color)) => style.color = Some(color),
            None => {}
        }
        match self.surface {
            Some(Surface::Is(reflection)) => {
                style.surface = Some(reflection.over(style.surface.unwrap_or(surfaces)));
            }
            Some(Surface::Switched(false)) => style.surface = Some(SurfaceReflection::OFF),
            Some(Surface::Switched(true)) => style.surface = None,
            None => {}
        }
        style.visible = self.visible.unwrap_or(style.visible);
        style.density_scale = self.density.or(style.density_scale);
        style.opacity = self.opacity.unwrap_or(style.opacity);
        style.clipped = self.clipped.unwrap_or(style.clipped);
    }
}

impl Labels {
    pub(super) fn check(&self, faults: &mut Faults) {
        faults.files("files", &self.files);
        for (index, style) in self.styles.iter().enumerate() {
            faults.within(&["styles".into(), index.into()], |faults| {
                faults.number("density", style.density, ranges::DENSITY);
                faults.number("opacity", style.opacity, ranges::FRACTION);
                if let Some(Color::Rgb(color)) = style.color {
                    faults.numbers("color", Some(color), ranges::FRACTION);
                }
                if let Some(Surface::Is(reflection)) = style.surface {
                    surface(faults, reflection);
                }
            });
        }
    }
}
