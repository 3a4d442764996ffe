//! Stored samples as texels.

use lumivox_core::{Volume, Voxels};

/// How a stored texel in [0, 1] becomes a physical value: `texel * per_texel + at_zero`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TexelScale {
    pub per_texel: f64,
    pub at_zero: f64,
}

impl TexelScale {
    pub fn of(volume: &Volume) -> Self {
        let (slope, intercept) = (volume.slope(), volume.intercept());
        match volume.voxels() {
            Voxels::U8(_) => Self { per_texel: slope * 255.0, at_zero: intercept },
            Voxels::U16(_) => Self { per_texel: slope * 65535.0, at_zero: intercept },
            // Floats are quantised to 16 bits over their range: an error of at most 1/131070 of it.
            Voxels::F32(_) => {
                let [min, max] = volume.stored_range();
                Self { per_texel: slope * (max - min), at_zero: intercept + slope * min }
            }
        }
    }
}

/// Sends floats to 16-bit fractions of the range of stored values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quantiser {
    min: f64,
    scale: f64,
}

impl Quantiser {
    pub fn of(volume: &Volume) -> Self {
        let [min, max] = volume.stored_range();
        Self { min, scale: if max > min { 65535.0 / (max - min) } else { 0.0 } }
    }

    pub fn fraction(self, x: f32) -> u16 {
        ((f64::from(x) - self.min) * self.scale).round() as u16
    }
}
