//! What is saved: scans, their labels, and transfer functions.

mod arguments;
mod derived;
mod labels;
mod numbers;
mod phantom;
mod stored;
mod transfer_function;
mod volume;

pub use arguments::{OptionalVolume, Options};
pub use derived::{Derived, Part};
pub use labels::LumivoxLabels;
pub use numbers::takes;
pub use transfer_function::LumivoxTransferFunction;
pub use volume::{LumivoxVolume, report_dictionary};
