//! Floor: which images belong together, in which order, and the even grid that they make.

pub(super) mod gaps;
pub(super) mod geometry;
pub(super) mod interleaving;
pub(super) mod label_grid;
pub(super) mod lone_images;
pub(super) mod phases;
pub(super) mod stack;
pub(super) mod stacks;
pub(super) mod storage;
