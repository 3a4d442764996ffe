//! Floor: what a header says frame by frame: place, kind, phase, and what makes values of its samples.

pub(super) mod frame;
pub(super) mod kinds;
pub(super) mod label_frames;
pub(super) mod mosaic;
pub(super) mod multi_frame;
pub(super) mod quantity;
pub(super) mod read;
pub(super) mod scope;
pub(super) mod uptake;
