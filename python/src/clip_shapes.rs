//! Clip shapes by what people say of them.

use lumivox_core::glam::DVec3;
use lumivox_core::{ClipKind, ClipShape};
use pyo3::prelude::*;

use crate::errors;
use crate::volume::{Rows, affine, rows};

/// The rows of a shape's place, `(kind, rows)`: of a plane by point and normal, of a box by corners, of a sphere by centre and
/// radius.
#[pyfunction]
pub fn clip_shape(kind: &str, first: [f64; 3], second: [f64; 3]) -> PyResult<Rows> {
    let (a, b) = (DVec3::from_array(first), DVec3::from_array(second));
    let shape = match kind {
        "plane" => ClipShape::plane(a, b),
        "box" => ClipShape::aligned_box(a, b),
        _ => ClipShape::sphere(a, b.x),
    };
    match shape.is_solid() {
        true => Ok(rows(shape.patient_from_shape)),
        false => Err(errors::value(format!("the {kind} has no inside"))),
    }
}

/// Whether a shape of such rows has an inside.
#[pyfunction]
pub fn is_solid(from_shape: Rows) -> bool {
    let patient_from_shape = affine(from_shape);
    ClipShape { kind: ClipKind::Box, patient_from_shape, inverted: false }.is_solid()
}
