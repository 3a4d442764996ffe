//! What is to be loaded, and what is said in place of the files.

use lumivox_core::Modality;

use crate::{axes::PatientAxes, layout::ArrayLayout, raw_description::RawDescription};

/// What to load when there is a choice.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ImportOptions {
    /// A 1-based position in [`ImportReport::series`](crate::ImportReport::series), else an [id](crate::SeriesSummary::id) there, as a DICOM
    /// SeriesInstanceUID, else a series number that no other series has; `None` takes the first, which is the best.
    pub series: Option<String>,
    /// Which phase of a series with several, counted from 1; `None` takes the first that is whole.
    pub phase: Option<usize>,
    /// Whether slices that are missing, or lie between uneven ones, stay empty, as damaged ones do: air in a CT, else the
    /// lowest value. By default they are filled in from both neighbours' values; either way the report says how many.
    pub leave_gaps: bool,
    /// Whether slices that are there but damaged (cut short, corrupt, fatal to their decoder) are filled in as missing
    /// ones are. By default they stay empty, for what they showed is not known; [`Self::leave_gaps`] wins over this.
    pub fill_damaged: bool,
    /// Whether a header (`.mhd`, `.nhdr`) may name data files anywhere, through links too. By default they lie beside it
    /// or below it: a header that somebody sent must not choose which files of this computer are read.
    pub allow_outside_data: bool,
    /// What the bytes of a file mean that no other reader knows.
    pub raw: Option<RawDescription>,
    /// Distances between voxels along x, y and z in mm, for files that do not say or say it wrongly: arrays of NumPy, stacks
    /// of pictures, OME-Zarr. By default those of the file, else 1 mm.
    pub spacing_mm: Option<[f64; 3]>,
    /// Where x, y and z of such files grow to in the patient; LPS by default, which is told.
    pub axes: Option<PatientAxes>,
    /// What the axes of an array are, as its shape lists them; by default `zyx`, or `tzyx` where there are four.
    pub layout: Option<ArrayLayout>,
    /// Physical units per stored unit, in place of what the file says; not 0.
    pub slope: Option<f64>,
    /// The physical value of a stored 0, in place of what the file says.
    pub intercept: Option<f64>,
    /// What made the scan, in place of what the file says.
    pub modality: Option<Modality>,
    /// What values are measured in, in place of what the file says; `HU` for a CT whose values are Hounsfield units.
    pub unit: Option<String>,
}
