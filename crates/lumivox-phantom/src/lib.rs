//! Procedural scans: bodies of known values for tests of the physics, and CTs of a head and a torso, MRs of a
//! head, and a PET of the torso, to look at.
//!
//! The first stop of the walk, like the importer: it makes a [`Volume`](lumivox_core::Volume). Everything is a pure
//! function of its arguments, on any number of threads. [`write_dicom_series`] turns a volume into the files that a
//! scanner would have sent, so that the way through the importer can be walked without a patient.

mod anatomy;
mod bodies;
mod dicom_series;
mod grove;
mod loft;
mod maths;
mod noise;
mod sdf;

pub use anatomy::{
    AnatomyOptions, FIELD_OF_VIEW_MM, MrPart, anatomy, anatomy_mr,
    torso::{
        Arms, Metal, TORSO_FIELD_OF_VIEW_MM, TorsoOptions, TorsoPart, TorsoTruth, torso, torso_parts,
        torso_pet,
    },
};
pub use bodies::{AIR_HU, cube, homogeneous_box, slab, solid, sphere};
pub use dicom_series::{SeriesDescription, WriteError, write_dicom_series};

/// The physical value of a stored 0, as CT scanners use it.
const INTERCEPT: f64 = -1024.0;

/// The largest value of a 12-bit scanner.
const MAX_HU: f64 = 3071.0;

/// The sample that stores a value in Hounsfield units.
fn stored(hu: f64) -> u16 {
    (hu.clamp(INTERCEPT, MAX_HU) - INTERCEPT).round() as u16
}

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
