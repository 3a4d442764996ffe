//! What comes of files: one program, for each would be linked with all decoders. Those that measure themselves, or call
//! themselves, are programs of their own beside it.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/field.rs"]
mod field;
#[path = "../common/writer.rs"]
mod writer;

mod data_files;
mod dicom_bad;
mod dicom_cancel;
mod dicom_foreign;
mod dicom_frames;
mod dicom_jpeg_xl;
mod dicom_kinds;
mod dicom_labels;
mod dicom_lost_frames;
mod dicom_odd;
mod dicom_overshoot;
mod dicom_places;
mod dicom_properties;
mod dicom_real;
mod dicom_series;
mod dicom_synthetic;
mod dicom_units;
mod dicom_uptake;
mod dicom_words;
mod hostile;
mod label_files;
mod many_labels;
mod single_files;
mod single_scan;
