//! Files to volumes: DICOM, NIfTI, NRRD, MetaImage and RAW, with progress, cancel and a report.
//!
//! [`load`] recognises a format from the content of what it is given, never from the name alone. It is the second
//! stop of the walk: files -> [`load`] -> [`Volume`].
//!
//! Nothing a file says is believed before it is checked: sizes against what is there, numbers for being finite.

mod error;
mod format;
mod metaimage;
mod nifti;
mod nrrd;
mod payload;
mod raw;
mod report;
mod sample;
mod scan;
mod text_header;

use std::path::{Path, PathBuf};

pub use error::ImportError;
use lumivox_core::{CancelToken, Progress, Volume};
pub use raw::{RawDescription, RawDescriptionError, load_raw};
pub use report::{ImportReport, SeriesSummary, SkippedFile};
pub use sample::{SampleType, UnknownSampleType};

/// What to load when there is a choice.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ImportOptions {
    /// A DICOM SeriesInstanceUID, series number, or 1-based position in [`ImportReport::series`]; `None` takes the
    /// series with the most voxels.
    pub series: Option<String>,
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
