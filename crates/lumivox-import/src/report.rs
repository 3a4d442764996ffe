//! What an import found and did, for people and programs.

use std::path::PathBuf;

/// One series (or file) that could be loaded.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct SeriesSummary {
    /// SeriesInstanceUID, or the file's name where there is none.
    pub id: String,
    /// DICOM's SeriesNumber.
    pub number: Option<i64>,
    /// What it is, without a word about the patient: `CT, 275 slices, 512 x 512`.
    pub description: String,
    /// Files that make it up.
    pub files: usize,
}

/// A file that was left out, and why.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SkippedFile {
    /// The file.
    pub path: PathBuf,
    /// Why, as a phrase: `not an image`, `a localizer`.
    pub reason: String,
}

/// What an import found and did.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ImportReport {
    /// The format's name: `DICOM`, `NIfTI`, `NRRD`, `MetaImage`, `RAW`.
    pub format: String,
    /// What could have been loaded; the best first.
    pub series: Vec<SeriesSummary>,
    /// Which of `series` was.
    pub chosen: usize,
    /// Sentences worth telling: `gantry tilt 18.5 degrees, kept as shear`, `1 of 176 slices is missing`.
    pub notes: Vec<String>,
    /// What was left out.
    pub skipped: Vec<SkippedFile>,
}
