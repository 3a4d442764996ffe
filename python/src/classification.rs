//! Labels' looks, clip shapes and peeling as Python describes them: dataclasses of `lumivox.classification`.

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{self as core, ClipKind, LabelStyle, Labelling};
use pyo3::prelude::*;

use crate::description::{Surface, TransferFunction, Wrapped};
use crate::errors;
use crate::labels::Labels;
use crate::volume::{Rows, affine};

const METRES_PER_MM: f64 = 1e-3;

/// `lumivox.Labels`, of which the native half counts.
#[derive(FromPyObject)]
pub struct Named {
    native: Py<Labels>,
}

/// `lumivox.LabelStyle`.
#[derive(FromPyObject)]
pub struct Style {
    visible: bool,
    color: Option<[f64; 3]>,
    opacity: f64,
    density: Option<f64>,
    transfer_function: Option<TransferFunction>,
    surface: Option<Surface>,
    clipped: bool,
}

impl Style {
    fn build(&self) -> PyResult<LabelStyle> {
        let curve = self.transfer_function.as_ref().map(TransferFunction::build).transpose()?;
        if self.transfer_function.as_ref().is_some_and(TransferFunction::has_gradients) {
            return Err(errors::value("a label's transfer function has no gradients; leave them out"));
        }
        let style = LabelStyle {
            visible: self.visible,
            color: self.color,
            transfer_function: curve,
            density_scale: self.density,
            opacity: self.opacity,
            surface: self.surface.as_ref().map(Surface::build),
            clipped: self.clipped,
        };
        Ok(style.sanitized())
    }
}

/// Labels, and how each looks.
pub fn labelling(labels: &Named, styles: &[(u8, Style)]) -> PyResult<Labelling> {
    let styles = styles.iter().map(|(value, style)| Ok((*value, style.build()?)));
    Ok(Labelling { labels: labels.native.get().shared(), styles: styles.collect::<PyResult<_>>()? })
}

/// `lumivox.Peel`.
#[derive(FromPyObject)]
pub struct Peel {
    depth: Wrapped,
    mm: f64,
}

impl Peel {
    /// What is peeled.
    pub fn build(&self) -> core::Peel {
        core::Peel { depth: self.depth.shared(), mm: self.mm }
    }
}

/// `lumivox.ClipShape`.
#[derive(FromPyObject)]
pub struct ClipShape {
    kind: String,
    from_shape: Rows,
    inverted: bool,
    space: String,
}

impl ClipShape {
    /// The shape of a volume that is placed so; world metres.
    pub fn build(&self, world_from_patient: DAffine3) -> PyResult<core::ClipShape> {
        let kind = match self.kind.as_str() {
            "plane" => ClipKind::Plane,
            "box" => ClipKind::Box,
            "sphere" => ClipKind::Sphere,
            other => {
                return Err(errors::value(format!("clip shape '{other}' is not 'plane', 'box' or 'sphere'")));
            }
        };
        let from_shape = affine(self.from_shape);
        let patient_from_shape = match self.space.as_str() {
            "patient" => from_shape,
            "scene" => {
                let world_from_mm = DAffine3::from_scale(DVec3::splat(METRES_PER_MM));
                world_from_patient.inverse() * world_from_mm * from_shape
            }
            other => return Err(errors::value(format!("space '{other}' is not 'scene' or 'patient'"))),
        };
        Ok(core::ClipShape { kind, patient_from_shape, inverted: self.inverted })
    }
}

/// The rows of a shape's place, `(kind, rows)`: of a plane by point and normal, of a box by corners, of a sphere by centre and
/// radius.
#[pyfunction]
pub fn clip_shape(kind: &str, first: [f64; 3], second: [f64; 3]) -> PyResult<Rows> {
    let (a, b) = (DVec3::from_array(first), DVec3::from_array(second));
    let shape = match kind {
        "plane" => core::ClipShape::plane(a, b),
        "box" => core::ClipShape::aligned_box(a, b),
        _ => core::ClipShape::sphere(a, b.x),
    };
    match shape.is_solid() {
        true => Ok(crate::volume::rows(shape.patient_from_shape)),
        false => Err(errors::value(format!("the {kind} has no inside"))),
    }
}

/// Whether a shape of such rows has an inside.
#[pyfunction]
pub fn is_solid(from_shape: Rows) -> bool {
    let patient_from_shape = affine(from_shape);
    core::ClipShape { kind: ClipKind::Box, patient_from_shape, inverted: false }.is_solid()
}
