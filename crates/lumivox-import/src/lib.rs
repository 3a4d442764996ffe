//! Files to volumes: DICOM, NIfTI, NRRD, MetaImage, MGH, RAW, arrays of NumPy, stacks of pictures and OME-Zarr, with progress,
//! cancel and a report.
//!
//! [`load`] recognises a format from the content of what it is given, never from the name alone. It is the second
//! stop of the walk: files -> [`load`] -> [`Volume`].
//!
//! Nothing a file says is believed before it is checked: sizes against what is there, numbers for being finite.

mod axes;
#[cfg(feature = "codec-worker")]
mod broken_pipe;
mod claims;
#[cfg(feature = "codec-worker")]
mod codec_worker;
#[cfg(not(feature = "codec-worker"))]
#[path = "codecs_here.rs"]
mod codec_worker;
mod dicom;
mod environment_file;
mod error;
mod format;
mod labels;
mod layout;
mod lengths;
mod luminance;
mod memory;
mod metaimage;
mod mgh;
mod nifti;
mod npy;
mod nrrd;
mod payload;
mod pictures;
mod radiance;
mod raw;
mod report;
mod sample;
mod samples;
mod single;
mod sizes;
mod source;
mod study;
mod text_header;
mod transfer_function_file;
mod values;
mod written_samples;
mod zarr;

pub use axes::{PatientAxes, UnknownAxes};
#[cfg(feature = "codec-worker")]
pub use codec_worker::{CodecWorker, serve_codecs, set_codec_worker};
pub use environment_file::{load_environment, save_environment};
pub use error::ImportError;
pub use labels::{ImportedLabels, LabelOptions, default_label_color, load_label_files, load_labels};
pub use layout::{ArrayLayout, UnknownLayout, UnknownSpacing, parse_spacing};
use lumivox_core::{Modality, Volume};
pub use memory::{MemoryImport, MemoryScan, load_memory};
pub use raw::{RawDescription, RawDescriptionError, load_raw};
pub use report::{ImportReport, SeriesSummary, SkippedFile, Thumbnail};
pub use sample::{SampleType, UnknownSampleType};
pub use source::WrongScan;
pub use study::{Study, load, scan};
pub use transfer_function_file::{
    load_transfer_function, load_transfer_function_2d, save_transfer_function, save_transfer_function_2d,
};
pub use values::modality_of_word;

/// What to load when there is a choice.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ImportOptions {
    /// A 1-based position in [`ImportReport::series`], else a DICOM SeriesInstanceUID, else a series number that no
    /// other series has; `None` takes the first, which is the best.
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

/// A scan and what became of its files.
#[derive(Debug)]
#[non_exhaustive]
pub struct Imported {
    /// The scan.
    pub volume: Volume,
    /// How it was read.
    pub report: ImportReport,
}

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
