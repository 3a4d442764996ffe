//! What is saved: scans and transfer functions.

mod arguments;
mod numbers;
mod stored;
mod transfer_function;
mod volume;

pub use arguments::{OptionalVolume, Options};
pub use numbers::takes;
pub use transfer_function::LumivoxTransferFunction;
pub use volume::{LumivoxVolume, report_dictionary};
