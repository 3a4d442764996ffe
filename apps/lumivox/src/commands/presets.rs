//! `lumivox presets`: the looks there are.

use lumivox_core::Preset;

use crate::{exit::Failure, output};

/// Lists every preset with what it shows.
pub fn run() -> Result<(), Failure> {
    let width = Preset::names().iter().map(|name| name.len()).max().unwrap_or(0);
    let lines = Preset::ALL.map(|preset| format!("{:width$}  {}\n", preset.name(), preset.description()));
    output::print(&lines.concat())
}
