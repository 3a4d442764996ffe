//! How slices of a scan are seen beside its picture.

use serde::{Deserialize, Serialize};

use super::{numbers::Faults, ranges};

/// How slices of the first scan are seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Slices {
    /// The point of the patient (LPS), in mm, that all of them go through.
    #[cfg_attr(test, schemars(transform = ranges::COORDINATE.said()))]
    pub cross: [f64; 3],
    /// The level and the width of what is neither black nor white, in the scan's unit.
    #[cfg_attr(test, schemars(transform = ranges::schema::window))]
    pub window: [f64; 2],
    /// What is seen through more than a plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slab: Option<Slab>,
    /// Where the right and the bottom of a slice lie in the patient that is turned as a person likes; made square to each other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::DIRECTION.said()))]
    pub oblique: Option<[[f64; 3]; 2]>,
}

/// A slice that is thick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Slab {
    /// What of the values along a line through it is seen.
    pub shows: Seen,
    /// Millimetres from its front to its back.
    #[cfg_attr(test, schemars(transform = ranges::THICKNESS.said()))]
    pub thickness: f64,
}

/// What of several values is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Seen {
    /// The largest (MIP).
    Maximum,
    /// The mean.
    Mean,
    /// The smallest (MinIP).
    Minimum,
}

impl Slices {
    /// What a document takes of these: each number that is out of its range is the nearest that is not.
    pub fn clamped(self) -> Self {
        let [level, width] = self.window;
        Self {
            cross: self.cross.map(|coordinate| ranges::COORDINATE.nearest(coordinate)),
            window: [ranges::LEVEL.nearest(level), ranges::WIDTH.nearest(width)],
            slab: self.slab.map(|slab| Slab { thickness: ranges::THICKNESS.nearest(slab.thickness), ..slab }),
            oblique: self
                .oblique
                .map(|axes| axes.map(|axis| axis.map(|part| ranges::DIRECTION.nearest(part)))),
        }
    }

    pub(super) fn check(&self, faults: &mut Faults) {
        faults.numbers("cross", Some(self.cross), ranges::COORDINATE);
        faults.number("window", Some(self.window[0]), ranges::LEVEL);
        faults.number("window", Some(self.window[1]), ranges::WIDTH);
        faults.within(&["slab".into()], |faults| {
            faults.number("thickness", self.slab.map(|slab| slab.thickness), ranges::THICKNESS);
        });
        let directions = self.oblique.unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        directions.into_iter().for_each(|axis| faults.numbers("oblique", Some(axis), ranges::DIRECTION));
        let [right, down] = directions.map(glam::DVec3::from_array);
        let is_plane = right.normalize_or_zero().cross(down.normalize_or_zero()).length() > 1e-6;
        faults.unless(is_plane, "oblique", || "oblique is two directions that lie in one plane alone".into());
    }
}
