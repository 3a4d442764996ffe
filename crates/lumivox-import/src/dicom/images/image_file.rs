//! A file as images, each with its place.

use lumivox_core::{Modality, Subject};

use crate::{
    ImportError,
    dicom::{
        bytes::source::Source,
        frames::frame::Frame,
        header::{
            frame_counts::Truncated,
            pixel_format::PixelFormat,
            segments::Segmentation,
            units::{self, Unit},
        },
    },
};

/// A file that holds images.
#[derive(Clone, Debug)]
pub(crate) struct ImageFile {
    pub(crate) source: Source,
    pub(crate) series_uid: Option<String>,
    pub(crate) series_number: Option<i64>,
    pub(crate) modality: Modality,
    /// DICOM's code for the modality: `CT`; `other` for an unknown one, empty where there is none.
    pub(crate) modality_code: &'static str,
    pub(crate) is_localizer: bool,
    pub(crate) frame_of_reference: Option<String>,
    /// A number that stands for the patient, so that nobody's own one is kept.
    pub(crate) patient: u64,
    /// SOPInstanceUID.
    pub(crate) instance_uid: Option<String>,
    /// What tells the series from others, in words that are no names: what it is called, how it is weighted or filtered,
    /// when it was made. Some are empty.
    pub(crate) labels: [String; 3],
    /// ConvolutionKernel: images of several make several volumes.
    pub(crate) kernel: Option<String>,
    /// What values are measured in; empty where that is not known.
    pub(crate) unit: Unit,
    /// What it is of, as far as the header says.
    pub(crate) subject: Subject,
    /// What it is where it is no image, but labels.
    pub(crate) segmentation: Option<Segmentation>,
    pub(crate) format: PixelFormat,
    pub(crate) frames: Vec<Frame>,
    /// How many of them have pixels, as far as the header and the file's size tell; the others mark their places.
    pub(crate) whole: usize,
    /// What the header promises of pixel data and what is there, in bytes, where that is not even one frame. Its place
    /// is known all the same.
    pub(crate) truncated: Option<Truncated>,
    /// Whether its frames, if there are several, are moments of one place.
    pub(crate) is_film: bool,
    /// Sentences about liberties taken.
    pub(crate) notes: Vec<String>,
}

impl ImageFile {
    /// Whether values are Hounsfield units of a CT, of which padding is air.
    pub(crate) fn is_hounsfield(&self) -> bool {
        self.modality == Modality::Ct && self.unit == units::HOUNSFIELD
    }

    /// Whether the pixels of a frame are there, as far as is known before they are read.
    pub(crate) fn has(&self, frame: usize) -> bool {
        frame < self.whole
    }

    /// Whether frames are missing at the end of the file and marked by nothing, so that it is not known what they showed.
    pub(crate) fn is_cut_short(&self) -> bool {
        self.frames.len() < self.format.frames * self.format.slices_in_frame()
    }

    /// The error about pixel data that end before their first frame does.
    pub(crate) fn truncation(&self) -> Option<ImportError> {
        let Truncated { expected, actual } = self.truncated?;
        Some(ImportError::Truncated { path: self.source.path(), expected, actual })
    }
}

/// One image: a frame of a file, by position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slice {
    pub(crate) file: usize,
    pub(crate) frame: usize,
}
