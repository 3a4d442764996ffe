//! What is saved: scans and transfer functions.

mod arguments;
mod histogram;
mod numbers;
mod stored;
mod transfer_function;
mod volume;

pub use arguments::{OptionalVolume, Options};
pub use numbers::takes;
pub use transfer_function::{LumivoxTransferFunction, no_scan};
pub use volume::{LumivoxVolume, import_options, report_dictionary};
