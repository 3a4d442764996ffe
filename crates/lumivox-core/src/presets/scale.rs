//! Where the values of a CT lie that is not in Hounsfield units: eight bits of one, or one whose rescale was lost.

use crate::{
    calibration::CtPeaks,
    medium::{Medium, SurfaceReflection},
    volume::Volume,
};

use super::{Look, tf};

/// An affine map from Hounsfield units to a volume's values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HounsfieldScale {
    slope: f64,
    intercept: f64,
}

impl HounsfieldScale {
    const IDENTITY: Self = Self { slope: 1.0, intercept: 0.0 };

    /// By the unit, else by the peaks of air and of soft tissue where there are two.
    pub fn of(volume: &Volume) -> Self {
        if volume.is_hounsfield() || volume.may_be_hounsfield() {
            return Self::IDENTITY;
        }
        CtPeaks::of(volume.statistics()).map_or(Self::IDENTITY, |peaks| {
            let [slope, intercept] = peaks.values_from_hounsfield();
            Self { slope, intercept }
        })
    }

    /// A value of the volume's in Hounsfield units.
    pub fn hounsfield(self, value: f64) -> f64 {
        (value - self.intercept) / self.slope
    }

    /// A look in Hounsfield units, over the volume's values.
    pub fn medium(self, look: &Look) -> Medium {
        let value = |hounsfield: f64| hounsfield * self.slope + self.intercept;
        let opacity: Vec<_> = look.opacity.iter().map(|&(hu, opacity)| (value(hu), opacity)).collect();
        let color: Vec<_> = look.color.iter().map(|&(hu, color)| (value(hu), color)).collect();
        let surface =
            SurfaceReflection { gradient_per_mm: look.surface.gradient_per_mm * self.slope, ..look.surface };
        Medium { density_scale: look.density_scale, surface, ..Medium::new(tf(&opacity, &color)) }
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::{
        calibration::{AIR_HU, TISSUE_HU},
        volume::{Modality, Voxels},
    };

    fn ct(samples: Vec<u8>) -> Volume {
        let dims = [samples.len(), 1, 1];
        Volume::new(dims, Voxels::U8(samples), [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct)
            .unwrap()
            .with_unit("")
    }

    #[test]
    fn eight_bits_of_a_ct_are_placed_by_air_and_tissue() {
        // Air at 10, tissue at 114: a tenth of a unit for each Hounsfield unit.
        let samples = [vec![10; 500], vec![114; 300], vec![200; 20], vec![255], vec![0]].concat();
        let scale = HounsfieldScale::of(&ct(samples));
        let value = |hu: f64| hu * scale.slope + scale.intercept;
        assert!((value(AIR_HU) - 10.0).abs() < 1.0 && (value(TISSUE_HU) - 114.0).abs() < 1.0);
    }

    #[test]
    fn one_that_is_flat_is_taken_as_it_is() {
        let scale = HounsfieldScale::of(&ct(vec![7; 100]));
        assert_eq!(scale, HounsfieldScale::IDENTITY);
    }
}
