//! How large the cells are whose majorants bound a volume.

use lumivox_core::medium::SIGMA_UNIT_PER_MM;
use lumivox_core::{ExtinctionSpace, Medium, Volume};

use crate::store::MAX_CELL_SIZE;

/// Voxels along a side of a majorant cell. Small cells bound tighter, and there are more of them to walk through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CellSize {
    /// 8, or 4 in small volumes.
    #[default]
    BySize,
    /// 4, too, where a look is dense wherever it shows something: rays end in the first cells, and tight ones save them
    /// tentative collisions before that. For stills: some of the voxels are looked at with every update.
    ByDensity,
    /// 1 to 16, the next power of two.
    Of(usize),
}

/// Of looks as dense as this, the cells are small.
const DENSE: f64 = 2.0;

const SMALL: u32 = 4;

/// Voxels of a usual cell, which [`DENSE`] is about.
const USUAL: f64 = 8.0;

/// Voxels looked at along each axis, at most.
const LOOKS: usize = 48;

impl CellSize {
    /// In voxels, where it is not up to the volume's size.
    pub(super) fn voxels(self, volume: &Volume, medium: &Medium) -> Option<u32> {
        match self {
            CellSize::BySize => None,
            CellSize::ByDensity => (depth_of_cell(volume, medium) >= DENSE).then_some(SMALL),
            CellSize::Of(voxels) => Some(voxels.clamp(1, MAX_CELL_SIZE as usize) as u32),
        }
    }
}

/// The optical depth of a usual cell, where the medium shows something; 0 where that cannot be told.
fn depth_of_cell(volume: &Volume, medium: &Medium) -> f64 {
    if medium.extinction_space == ExtinctionSpace::World {
        return 0.0;
    }
    let dims = volume.dims();
    let stride = dims.map(|n| n.div_ceil(LOOKS));
    let (mut sum, mut seen) = (0.0, 0u32);
    for z in (0..dims[2]).step_by(stride[2]) {
        for y in (0..dims[1]).step_by(stride[1]) {
            for x in (0..dims[0]).step_by(stride[0]) {
                let opacity = medium.transfer_function.opacity(volume.value([x, y, z]));
                sum += opacity;
                seen += u32::from(opacity > 0.0);
            }
        }
    }
    let mean = sum / f64::from(seen.max(1));
    mean * medium.density_scale * SIGMA_UNIT_PER_MM * volume.spacing_mm().min_element() * USUAL
}

#[cfg(test)]
mod tests {
    use lumivox_core::{
        Ease, Modality, TransferFunction, Voxels,
        glam::{DAffine3, DVec3},
    };

    use super::*;

    /// 32 voxels a side, the half of them of 1000 HU.
    fn half(spacing_mm: f64) -> Volume {
        let samples = (0..32usize.pow(3)).map(|i| if i % 32 < 16 { 0 } else { 2000 }).collect();
        let place = DAffine3::from_scale(DVec3::splat(spacing_mm));
        Volume::new([32; 3], Voxels::U16(samples), [1.0, -1000.0], place, Modality::Ct).unwrap()
    }

    fn look(opacity: f64, density_scale: f64) -> Medium {
        let transfer_function =
            TransferFunction::from_points(Ease::Linear, &[(0.0, 0.0), (1000.0, opacity)], &[(0.0, [1.0; 3])])
                .unwrap();
        Medium { density_scale, ..Medium::new(transfer_function) }
    }

    #[test]
    fn cells_are_small_where_what_shows_is_dense() {
        let by_density =
            |spacing_mm: f64, medium: &Medium| CellSize::ByDensity.voxels(&half(spacing_mm), medium);
        // The optical depth of 8 voxels of what shows, not of the air around it.
        let dense = DENSE / (SIGMA_UNIT_PER_MM * USUAL);
        assert_eq!(by_density(1.0, &look(1.0, 1.01 * dense)), Some(SMALL));
        assert_eq!(by_density(1.0, &look(1.0, 0.99 * dense)), None);
        // Voxels half as large, or opacity half as much, need twice the density.
        assert_eq!(by_density(0.5, &look(1.0, 1.01 * dense)), None);
        assert_eq!(by_density(0.5, &look(1.0, 2.02 * dense)), Some(SMALL));
        assert_eq!(by_density(1.0, &look(0.5, 2.02 * dense)), Some(SMALL));
        // Nothing shows.
        assert_eq!(by_density(1.0, &look(0.0, 1e3)), None);
        // How large a voxel is there, only the placement knows.
        let world = Medium { extinction_space: ExtinctionSpace::World, ..look(1.0, 1e3) };
        assert_eq!(by_density(1.0, &world), None);
    }

    #[test]
    fn what_was_asked_for_is_taken_within_its_bounds() {
        let (volume, medium) = (half(1.0), look(1.0, 1e3));
        assert_eq!(CellSize::BySize.voxels(&volume, &medium), None);
        assert_eq!(CellSize::Of(2).voxels(&volume, &medium), Some(2));
        assert_eq!(CellSize::Of(0).voxels(&volume, &medium), Some(1));
        assert_eq!(CellSize::Of(99).voxels(&volume, &medium), Some(MAX_CELL_SIZE));
    }
}
