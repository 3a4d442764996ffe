//! One image: where it lies, what its values are, and what tells it from others at its place.

use lumivox_core::glam::{DVec2, DVec3};

use crate::dicom::header::units::Unit;

/// What tells images of one place apart: phases, echoes, diffusion weightings. Numbers are in millionths, so that they
/// compare. Never used to order slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct PhaseKey {
    pub(crate) temporal_position: i64,
    pub(crate) b_value: i64,
    pub(crate) echo: i64,
    /// In milliseconds.
    pub(crate) trigger_time: i64,
    /// A number that stands for the contrast agent; 0 where there is none.
    pub(crate) contrast: i64,
    pub(crate) acquisition: i64,
    /// Of the day or the series, in seconds.
    pub(crate) time: i64,
    pub(crate) instance: i64,
}

/// One number of a key, with its name for people.
pub(crate) type Field = (&'static str, fn(&PhaseKey) -> i64);

/// What parts images even where no two lie at one place: never do two of these make one volume.
pub(crate) const STRONG: [Field; 5] = [
    ("temporal position", |key| key.temporal_position),
    ("b-value", |key| key.b_value),
    ("echo", |key| key.echo),
    ("trigger time", |key| key.trigger_time),
    ("contrast agent", |key| key.contrast),
];

/// What parts images of one place only, since it may change within a volume too.
pub(crate) const WEAK: [Field; 3] = [
    ("acquisition", |key| key.acquisition),
    ("time", |key| key.time),
    ("instance number", |key| key.instance),
];

/// A unit, and the slope and intercept that lead to it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RealWorld {
    /// Of radioactivity and uptake as Units (0054,1001) spells it: `BQML` and `GML`. Empty for plain numbers.
    pub(crate) unit: Unit,
    pub(crate) rescale: [f64; 2],
}

/// What a file says of the unit that rescaled values have.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum RescaleType {
    #[default]
    Absent,
    Known(Unit),
    /// It is said to be unspecified, or called by a name that stands for nothing.
    Unknown,
}

impl RescaleType {
    pub(crate) fn known(&self) -> Option<Unit> {
        match self {
            Self::Known(unit) => Some(unit.clone()),
            _ => None,
        }
    }
}

/// One image of a file.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// Centre of the first pixel, in LPS millimetres; `None` where the file does not say.
    pub(crate) position: Option<DVec3>,
    /// Unit direction of growing column index.
    pub(crate) row_direction: DVec3,
    /// Unit direction of growing row index.
    pub(crate) column_direction: DVec3,
    /// Whether the file says these two; else they are those of an axial slice.
    pub(crate) is_oriented: bool,
    /// Distance of neighbouring columns (x) and rows (y), in mm.
    pub(crate) spacing_mm: DVec2,
    /// Distance to the next slice by the header's word, else the larger side of a pixel. It is the step where places tell
    /// none (single slices, frames that are stacked), the first guess at that of labels, which leave slices out, and
    /// decides between one volume and two scans at half a step; else places count alone.
    pub(crate) thickness_mm: f64,
    /// Slope and intercept.
    pub(crate) rescale: [f64; 2],
    pub(crate) rescale_type: RescaleType,
    /// What makes real world values of stored ones.
    pub(crate) real_world: Option<RealWorld>,
    /// What it shows, in words beyond its series': images of different kinds never make one volume.
    pub(crate) kind: String,
    /// What parts kinds of one place that no word tells apart ([`ge_collapse`](crate::dicom::frames::kinds::ge_collapse)).
    pub(crate) collapse: i16,
    /// Whether it is a map of numbers around 0 beside the pictures of an MR.
    pub(crate) is_signed_map: bool,
    /// AcquisitionContrast of an enhanced MR image.
    pub(crate) contrast: Option<String>,
    pub(crate) phase: PhaseKey,
    /// The segment that a frame of a segmentation shows.
    pub(crate) segment: Option<u16>,
}

/// Puts the mapping to real world values in the place of the rescale.
pub(crate) fn take_real_world(frames: &mut [Frame]) {
    for frame in frames {
        frame.rescale = frame.real_world.as_ref().map_or(frame.rescale, |real| real.rescale);
    }
}
