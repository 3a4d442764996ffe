//! Floor: from the slices of a phase to the voxels of a volume.

pub(super) mod alignment;
pub(super) mod convert;
pub(super) mod label_pixels;
pub(super) mod overshoot;
pub(super) mod pixels;
pub(super) mod resample;
pub(super) mod slices;
pub(super) mod stored;
