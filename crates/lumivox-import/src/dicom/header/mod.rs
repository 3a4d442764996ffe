//! Floor: what a header says of the whole file: how its samples are stored, in which unit, of what and in which words.

pub(super) mod frame_counts;
pub(super) mod modality_lut;
pub(super) mod names;
pub(super) mod palette;
pub(super) mod pixel_format;
pub(super) mod refusal;
pub(super) mod segments;
pub(super) mod structures;
pub(super) mod subject;
pub(super) mod units;
pub(super) mod words;
