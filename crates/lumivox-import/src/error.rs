//! Why a scan could not be read, and what to do about it.

use std::path::{Path, PathBuf};

use lumivox_core::{Cancelled, VolumeError};

/// Why a scan could not be read. Every message names the file, what is wrong and what to do; none holds a patient's
/// name or number.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The file or folder cannot be opened or read.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// No reader knows this content.
    #[error("{path}: {found}. Lumivox reads DICOM, NIfTI, NRRD, MetaImage, MGH, NumPy's arrays, stacks of TIFF and PNG, OME-Zarr, and RAW with a description", path = path.display())]
    UnknownFormat {
        /// The file or folder.
        path: PathBuf,
        /// What was found instead.
        found: String,
    },
    /// A header field is missing, damaged or impossible.
    #[error("{path}: {field} {problem}. {remedy}", path = path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The field by its format's own name, with its tag for DICOM: `PixelSpacing (0028,0030)`.
        field: String,
        /// What is wrong with it, as a verb phrase: `is missing`, `is 0\0, not two positive lengths in mm`.
        problem: String,
        /// What the user can do, a sentence.
        remedy: String,
    },
    /// The header promises more data than there is.
    #[error("{path}: holds {actual} bytes of image data where its header promises {expected}. The file is cut short; copy or export it again", path = path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Bytes promised.
        expected: u64,
        /// Bytes there.
        actual: u64,
    },
    /// The file's structure is broken.
    #[error("{path}: {problem}. The file is damaged or cut short; copy or export it again", path = path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, as a verb phrase: `ends in the middle of its header`.
        problem: String,
    },
    /// The content is understood, but cannot be shown as a volume.
    #[error("{path}: {what}. {remedy}", path = path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: String,
        /// What the user can do, a sentence.
        remedy: String,
    },
    /// A DICOM folder holds no series of images.
    #[error("{path}: {}. {detail}", none_of(*files), path = path.display())]
    NoSeries {
        /// The folder.
        path: PathBuf,
        /// Files looked at.
        files: usize,
        /// The commonest reason, a sentence.
        detail: String,
    },
    /// The series asked for is not there.
    #[error("{path}: there is no series '{wanted}'. It has: {available}", path = path.display())]
    NoSuchSeries {
        /// The folder.
        path: PathBuf,
        /// What was asked for.
        wanted: String,
        /// What is there.
        available: String,
    },
    /// The number asked for is that of several series.
    #[error("{path}: several series have the number '{wanted}': {candidates}. Name one by its place in the list", path = path.display())]
    AmbiguousSeries {
        /// The folder.
        path: PathBuf,
        /// What was asked for.
        wanted: String,
        /// The series of that number, each with its place in the list of all.
        candidates: String,
    },
    /// The phase asked for is not there.
    #[error("{path}: there is no phase {wanted}; it has {phases}", path = path.display())]
    NoSuchPhase {
        /// The folder.
        path: PathBuf,
        /// What was asked for, counted from 1.
        wanted: usize,
        /// How many there are.
        phases: usize,
    },
    /// The parts do not make a volume.
    #[error("{path}: {source}. Correct the header, or export the scan again", path = path.display())]
    Volume {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: VolumeError,
    },
    /// The user stopped it.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl ImportError {
    /// An [`ImportError::Io`] about `path`, for `map_err`.
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Io { path: path.to_owned(), source }
    }
}

/// What to do about a folder without files.
pub(crate) const CHOOSE_FOLDER: &str = "Choose the folder that holds the scan";

/// That none of so many files is an image.
fn none_of(files: usize) -> String {
    match files {
        0 => "it holds no file".to_owned(),
        1 => "its one file is no image that makes up a volume".to_owned(),
        n => format!("none of its {n} files is an image that makes up a volume"),
    }
}
