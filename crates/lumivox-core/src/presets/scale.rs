//! Where the values of a CT lie that is not in Hounsfield units: eight bits of one, or one whose rescale was lost.

use crate::{
    medium::{Medium, SurfaceReflection},
    statistics::ValueStatistics,
    volume::Volume,
};

use super::{Look, tf};

/// An affine map from Hounsfield units to a volume's values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HounsfieldScale {
    slope: f64,
    intercept: f64,
}

/// Soft tissue, which most of a body is.
const TISSUE: f64 = 40.0;
const AIR: f64 = -1000.0;

impl HounsfieldScale {
    const IDENTITY: Self = Self { slope: 1.0, intercept: 0.0 };

    /// By the unit, else by the peaks of air and of soft tissue where there are two.
    pub fn of(volume: &Volume) -> Self {
        if volume.is_hounsfield() || volume.may_be_hounsfield() {
            return Self::IDENTITY;
        }
        let statistics = ValueStatistics::new(volume, 1024);
        let [low, high] = statistics.range;
        let width = (high - low) / statistics.histogram.len() as f64;
        let border = ((statistics.otsu_threshold() - low) / width) as usize;
        let (below, above) = statistics.histogram.split_at(border.min(statistics.histogram.len()));
        let peak = |counts: &[u64], first: usize| {
            let (place, _) = counts.iter().enumerate().max_by_key(|(_, count)| **count)?;
            Some(low + ((first + place) as f64 + 0.5) * width)
        };
        match (peak(below, 0), peak(above, below.len())) {
            (Some(air), Some(tissue)) if tissue > air => {
                let slope = (tissue - air) / (TISSUE - AIR);
                Self { slope, intercept: air - AIR * slope }
            }
            _ => Self::IDENTITY,
        }
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
    use crate::volume::{Modality, Voxels};

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
        assert!((value(AIR) - 10.0).abs() < 0.5 && (value(TISSUE) - 114.0).abs() < 0.5);
    }

    #[test]
    fn one_that_is_flat_is_taken_as_it_is() {
        let scale = HounsfieldScale::of(&ct(vec![7; 100]));
        assert_eq!(scale, HounsfieldScale::IDENTITY);
    }
}
