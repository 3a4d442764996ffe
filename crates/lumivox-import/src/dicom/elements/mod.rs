//! Floor: the elements of a file, as the data set that they make, and the values in it. What a value is for is no matter here.

pub(super) mod attributes;
pub(super) mod charset;
pub(super) mod data_set;
pub(super) mod gzip;
pub(super) mod values;
