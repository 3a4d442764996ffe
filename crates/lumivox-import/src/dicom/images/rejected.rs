//! Files that are no usable images, and why.

use std::path::PathBuf;

use crate::{ImportError, report::SkippedFile};

/// A file that is no usable image.
#[derive(Debug)]
pub(crate) struct Rejected {
    pub(crate) path: PathBuf,
    pub(crate) error: ImportError,
    /// SeriesInstanceUID, where its header could be read.
    pub(crate) series_uid: Option<String>,
}

impl Rejected {
    /// A file of which no more is known than why it is of no use.
    pub(crate) fn new(path: PathBuf, error: ImportError) -> Self {
        Self { path, error, series_uid: None }
    }

    /// Whether it is a DICOM file at all.
    pub(crate) fn is_dicom(&self) -> bool {
        !matches!(self.error, ImportError::UnknownFormat { .. } | ImportError::Io { .. })
    }

    /// Whether it is a DICOM file that might be an image, were it whole.
    pub(crate) fn is_damaged(&self) -> bool {
        matches!(self.error, ImportError::Damaged { .. } | ImportError::Truncated { .. })
    }

    /// Whether it may be a slice of a series: one that is damaged, or one of it that is refused for a wrong field.
    pub(crate) fn may_belong_to(&self, series_uid: Option<&str>) -> bool {
        let is_refused = matches!(self.error, ImportError::Field { .. });
        self.is_damaged() || is_refused && self.series_uid.as_deref() == series_uid
    }

    /// The reason as a phrase for the report.
    pub(crate) fn reason(&self) -> String {
        match &self.error {
            ImportError::UnknownFormat { found, .. } => found.clone(),
            ImportError::Unsupported { what, .. } => what.clone(),
            ImportError::Field { field, problem, .. } => format!("{field} {problem}"),
            ImportError::Damaged { problem, .. } => problem.clone(),
            ImportError::Truncated { expected, actual, .. } => {
                format!("cut short: {actual} of {expected} bytes of image data are there")
            }
            ImportError::Io { source, .. } => source.to_string(),
            other => other.to_string(),
        }
    }

    pub(crate) fn skipped(&self) -> SkippedFile {
        SkippedFile { path: self.path.clone(), reason: self.reason() }
    }
}
