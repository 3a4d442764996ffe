//! Floor: files as images with places, as they are found in folders and archives, and those that are none.

pub(super) mod image_file;
pub(super) mod read;
pub(super) mod rejected;
pub(super) mod scan;
pub(super) mod siblings;
