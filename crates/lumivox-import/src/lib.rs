//! Files to volumes: DICOM, NIfTI, NRRD, MetaImage, MGH, RAW, arrays of NumPy, stacks of pictures and OME-Zarr, with progress,
//! cancel and a report.
//!
//! [`load`] recognises a format from the content of what it is given, never from the name alone. It is the second
//! stop of the walk: files -> [`load`] -> [`Volume`](lumivox_core::Volume).
//!
//! Nothing a file says is believed before it is checked: sizes against what is there, numbers for being finite.

mod axes;
#[cfg(feature = "codec-worker")]
mod broken_pipe;
mod choice;
mod claims;
mod codec;
#[cfg(feature = "codec-worker")]
mod codec_worker;
#[cfg(not(feature = "codec-worker"))]
#[path = "codecs_here.rs"]
mod codec_worker;
mod colors;
mod dicom;
mod environment_file;
mod error;
pub mod files;
mod format;
mod labels;
mod layout;
mod lengths;
mod luminance;
mod memory;
mod metaimage;
mod mgh;
mod modality;
mod nifti;
mod npy;
mod nrrd;
mod options;
mod panorama;
mod payload;
mod pictures;
mod placement;
mod radiance;
mod raw;
mod raw_description;
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
pub use choice::would_be_a_slice;
#[cfg(feature = "codec-worker")]
pub use codec_worker::{CodecWorker, serve_codecs, set_codec_worker};
pub use environment_file::{load_environment, save_environment};
pub use error::ImportError;
pub use files::{Content, FileKind, Files, MemoryFiles, set_files};
pub use labels::{ImportedLabels, LabelOptions, default_label_color, load_label_files, load_labels};
pub use layout::{ArrayLayout, UnknownLayout, UnknownSpacing, parse_spacing};
pub use memory::{MemoryImport, MemoryScan, load_memory};
pub use modality::modality_of_word;
pub use options::ImportOptions;
pub use raw::load_raw;
pub use raw_description::{RawDescription, RawDescriptionError};
pub use report::{ImportReport, Imported, SeriesSummary, SkippedFile, Thumbnail};
pub use sample::{SampleType, UnknownSampleType};
pub use source::WrongScan;
pub use study::{Study, load, scan};
pub use transfer_function_file::{
    load_transfer_function, load_transfer_function_2d, save_transfer_function, save_transfer_function_2d,
};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
