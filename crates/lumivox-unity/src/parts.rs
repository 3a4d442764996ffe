//! What of a scan is seen in place of the patient: all that was scanned, or one organ.

use lumivox_core::{CancelToken, Organ, Progress, Volume};
use lumivox_segmentation::find_organ;
use std::sync::Arc;

use crate::border::Outcome;
use crate::volume::LumivoxVolume;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The table, clothes and cables too.
    Everything,
    /// One organ.
    Organ(Organ),
}

impl Part {
    /// The part that a number of the border means.
    pub fn from_number(number: u32) -> Outcome<Self> {
        match number {
            1 => Ok(Self::Everything),
            2 => Ok(Self::Organ(Organ::Airways)),
            3 => Ok(Self::Organ(Organ::LungVessels)),
            _ => Err(format!("a scan has the parts 1 to 3, not {number}")),
        }
    }

    /// The number that the border has for it; 0 for an organ that it has none for.
    pub fn number(self) -> u32 {
        match self {
            Self::Everything => 1,
            Self::Organ(Organ::Airways) => 2,
            Self::Organ(Organ::LungVessels) => 3,
            Self::Organ(_) => 0,
        }
    }
}

/// A part of a scan, ready to be shown; none where there is no such part, or it is not found for sure.
pub fn find(
    scan: &LumivoxVolume,
    part: Part,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Outcome<Option<LumivoxVolume>> {
    let found: Option<Volume> = match part {
        Part::Everything => {
            let around = scan.surroundings();
            let whole = around.map(|around| around.put_back(scan.volume())).transpose();
            whole.map_err(|error| error.to_string())?
        }
        Part::Organ(organ) => {
            let found = find_organ(scan.volume(), organ, progress, cancel);
            found.map_err(|error| error.to_string())?
        }
    };
    Ok(found.map(|volume| {
        let volume = Arc::new(volume);
        // On this thread: the frame that shows it first would wait otherwise.
        lumivox_renderer::prepare_volume(&volume);
        LumivoxVolume::of_another(volume)
    }))
}
