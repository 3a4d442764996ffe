//! Where an array lies in the patient, for files that do not say.

use lumivox_core::glam::{DAffine3, DMat3};

use crate::{ImportOptions, axes::PatientAxes, lengths::SPACING_MM};

/// Distances between voxels along x, y and z, as files give them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Spacing {
    Mm([f64; 3]),
    /// In a unit that is not said, or is no length.
    OfUnknownUnit([f64; 3]),
}

impl Spacing {
    /// In mm: of an unknown unit the numbers themselves, which keep a scan's proportions; says so. `None` where they say nothing.
    pub(crate) fn mm(self, options: &ImportOptions, notes: &mut Vec<String>) -> Option<[f64; 3]> {
        match self {
            Self::Mm(lengths) => Some(lengths),
            Self::OfUnknownUnit([x, y, z]) if x == y && y == z => None,
            Self::OfUnknownUnit(lengths) if !lengths.iter().all(|length| SPACING_MM.contains(length)) => None,
            Self::OfUnknownUnit(lengths) => {
                if options.spacing_mm.is_none() {
                    let [x, y, z] = lengths;
                    notes.push(format!(
                        "the distances between voxels, {x} x {y} x {z}, have no known unit: taken as mm (the option spacing says them)"
                    ));
                }
                Some(lengths)
            }
        }
    }
}

/// LPS millimetres from voxel indices, for a grid whose axes are `space` (0 for x, 1 for y, 2 for z): as the options say,
/// else with `own` distances between voxels (of x, y and z); says what is not known.
pub(crate) fn placement(
    options: &ImportOptions,
    space: &[usize; 3],
    own: Option<[f64; 3]>,
    notes: &mut Vec<String>,
) -> DAffine3 {
    let spacing = options.spacing_mm.or(own);
    if spacing.is_none() {
        notes.push(
            "the distance between voxels is not given: taken as 1 mm (the option spacing says it)".to_owned(),
        );
    }
    if options.axes.is_none() {
        notes.push("no orientation is given: taken as LPS (the option axes says it)".to_owned());
    }
    let placed = options.axes.unwrap_or(PatientAxes::LPS).placement(spacing.unwrap_or([1.0; 3]));
    let columns = [placed.matrix3.x_axis, placed.matrix3.y_axis, placed.matrix3.z_axis];
    DAffine3::from_mat3(DMat3::from_cols(columns[space[0]], columns[space[1]], columns[space[2]]))
}
