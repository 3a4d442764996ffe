//! What a segmentation found, and how sure it is of that, for people and programs.

use std::fmt;

use crate::class::Class;

/// Below this confidence nothing is told apart: all of the scan stays visible.
pub const LEAST_CONFIDENCE: f64 = 0.3;

/// One kind of thing that was found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Finding {
    /// What it is.
    pub class: Class,
    /// Its voxels.
    pub voxels: u64,
    /// Its size in mm^3.
    pub volume_mm3: f64,
}

impl Finding {
    /// How large it is, for people: `1.2 l`, `340 ml`, `12 mm^3`.
    pub fn size(&self) -> String {
        match self.volume_mm3 {
            mm3 if mm3 >= 1e6 => format!("{:.1} l", mm3 / 1e6),
            mm3 if mm3 >= 1e4 => format!("{:.0} ml", mm3 / 1e3),
            mm3 if mm3 >= 1e3 => format!("{:.1} ml", mm3 / 1e3),
            mm3 => format!("{mm3:.0} mm^3"),
        }
    }
}

/// What was found, and how sure that is.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SegmentationReport {
    /// What has voxels, by label.
    pub findings: Vec<Finding>,
    /// How far to trust it: 0 (not at all: everything is labelled as body) to 1.
    pub confidence: f64,
    /// Why the confidence is not 1, and what else is worth knowing, as sentences.
    pub notes: Vec<String>,
}

impl SegmentationReport {
    /// Whether it is sure enough to hide anything by ([`LEAST_CONFIDENCE`]).
    pub fn is_sure(&self) -> bool {
        self.confidence >= LEAST_CONFIDENCE
    }

    /// The size of what was found of a class, in mm^3; 0 where there is none.
    pub fn volume_mm3(&self, class: Class) -> f64 {
        self.findings.iter().find(|finding| finding.class == class).map_or(0.0, |found| found.volume_mm3)
    }
}

impl fmt::Display for SegmentationReport {
    /// One line for each finding, one for the confidence, one for each note.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for finding in &self.findings {
            writeln!(f, "{}: {}", finding.class.name(), finding.size())?;
        }
        let sure = match self.confidence {
            c if c >= 0.8 => "sure",
            c if c >= 0.5 => "fairly sure",
            c if c >= LEAST_CONFIDENCE => "unsure",
            _ => "no idea: everything stays visible",
        };
        write!(f, "confidence {:.2} ({sure})", self.confidence)?;
        self.notes.iter().try_for_each(|note| write!(f, "\n{note}"))
    }
}
