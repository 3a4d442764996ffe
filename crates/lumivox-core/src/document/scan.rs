//! Where voxels are, and what was done to them.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{numbers::Faults, ranges};
use crate::{presets::Organ, volume::Modality};

/// Where a scan's voxels are, how they are read, and what of them is shown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(transform = ranges::schema::requires_files))]
#[serde(deny_unknown_fields)]
pub struct Scan {
    /// Files or a folder, with `/` between names; relative ones as seen from the document's folder.
    #[serde(default)]
    #[cfg_attr(test, schemars(length(min = 1), inner(length(min = 1))))]
    pub files: Vec<PathBuf>,
    /// Which series of several: its UID (`UID#2` for the second with that in common), its place in the list from 1, or a number that no
    /// other has; of pictures the channel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub series: Option<String>,
    /// Which phase of several, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::PHASE.said()))]
    pub phase: Option<u32>,
    /// What was read, so that another scan in its place is told: the hash of geometry and values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub content: Option<String>,
    /// Whether missing slices stay empty.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub leave_gaps: bool,
    /// Whether damaged slices are filled in, as missing ones are.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fill_damaged: bool,
    /// Layout of a RAW scan, as of the command's `--raw`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raw: Option<String>,
    /// Distances between voxels in mm, for files that do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::SPACING.said()))]
    pub spacing: Option<[f64; 3]>,
    /// Where x, y and z of such files grow to: `LPS`, `RAS`, ...
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<String>,
    /// Axes of an array, as its shape lists them: `zyx`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layout: Option<String>,
    /// Units per stored one, in place of what the file says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::SLOPE.said(), transform = ranges::schema::not_zero))]
    pub slope: Option<f64>,
    /// The value of a stored 0, in place of what the file says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::INTERCEPT.said()))]
    pub intercept: Option<f64>,
    /// What made it, in place of what the file says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modality: Option<Modality>,
    /// What values are measured in, in place of what the file says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// What of a CT is kept.
    #[serde(default)]
    pub keep: Keep,
    /// What was taken off the patient; by default what the preset hides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub taken_off: Option<TakenOff>,
}

/// What of a CT is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Keep {
    /// The patient alone, where that can be told for sure.
    #[default]
    Patient,
    /// All that was scanned.
    Everything,
}

/// What was taken off the patient.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TakenOff {
    /// Nothing.
    Nothing,
    /// So many millimetres of skin; thin parts, such as ears, stay.
    Skin(#[cfg_attr(test, schemars(transform = ranges::PEEL.said()))] f64),
    /// All that lies less than so many millimetres below the skin.
    Depth(#[cfg_attr(test, schemars(transform = ranges::PEEL.said()))] f64),
    /// All but an organ.
    AllBut(Organ),
}

impl Scan {
    /// Files, read as they are when nothing is said.
    pub fn of_files(files: Vec<PathBuf>) -> Self {
        Self { files, ..Self::default() }
    }

    pub(super) fn check(&self, faults: &mut Faults) {
        faults.files("files", &self.files);
        let phase = self.phase.map(f64::from);
        faults.unless(phase.is_none_or(|phase| ranges::PHASE.holds(phase)), "phase", || {
            "phases count from 1".into()
        });
        faults.number("slope", self.slope, ranges::SLOPE);
        faults.unless(self.slope.is_none_or(f64::is_normal), "slope", || "slope must not be 0".into());
        faults.number("intercept", self.intercept, ranges::INTERCEPT);
        faults.numbers("spacing", self.spacing, ranges::SPACING);
        faults.within(&["taken_off".into()], |faults| match self.taken_off {
            Some(TakenOff::Skin(mm)) => faults.number("skin", Some(mm), ranges::PEEL),
            Some(TakenOff::Depth(mm)) => faults.number("depth", Some(mm), ranges::PEEL),
            Some(TakenOff::Nothing | TakenOff::AllBut(_)) | None => {}
        });
    }
}
