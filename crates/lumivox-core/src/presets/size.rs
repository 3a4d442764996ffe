//! Extinction of what is not as large as a body.

use crate::volume::Volume;

/// Parts of a body that are scanned alone, and whole ones, by the longest edge of what is scanned, in mm.
const SMALLEST_MM: f64 = 50.0;
const LARGEST_MM: f64 = 2500.0;

/// What looks are made for, in mm: what is smaller, or larger, comes to look as large.
const SMALL_AS_MM: f64 = 200.0;
const LARGE_AS_MM: f64 = 300.0;

/// By how much more than written down a preset's extinction has to be in a volume, so that it looks as a body does: 1 for all
/// that may be one. What is seen under a microscope is no ghost then, and weather no wall.
pub fn size_factor(volume: &Volume) -> f64 {
    let size = volume.size_mm().max_element();
    let looks_as = if size < SMALLEST_MM {
        SMALL_AS_MM + (SMALLEST_MM - SMALL_AS_MM) * (size / SMALLEST_MM)
    } else if size > LARGEST_MM {
        (LARGEST_MM * LARGEST_MM / size).max(LARGE_AS_MM)
    } else {
        size
    };
    looks_as / size
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};

    use super::*;
    use crate::{
        presets::Preset,
        volume::{Modality, Voxels},
    };

    fn volume(voxel_mm: f64) -> Volume {
        let voxels = Voxels::U8((0..32 * 32 * 32).map(|i| (i * 7 % 251) as u8).collect());
        let place = DAffine3::from_scale(DVec3::splat(voxel_mm));
        Volume::new([32; 3], voxels, [1.0, 0.0], place, Modality::Other).unwrap()
    }

    #[test]
    fn bodies_are_physical_and_all_else_looks_as_large_as_one() {
        for voxel_mm in [2.0, 10.0, 70.0] {
            assert_eq!(size_factor(&volume(voxel_mm)), 1.0, "{voxel_mm}");
        }
        let depth = |voxel_mm: f64| {
            let volume = volume(voxel_mm);
            Preset::Plain.medium(&volume).density_scale * volume.size_mm().x
        };
        for voxel_mm in [4e-6, 5e-3, 35e-3, 500.0, 1e5] {
            let depth = depth(voxel_mm);
            assert!((380.0..=800.0).contains(&depth), "{depth} at {voxel_mm} mm");
            // What is denser than it may be is cut off in silence.
            let medium = Preset::Plain.medium(&volume(voxel_mm));
            assert_eq!(medium.clone().sanitized(), medium);
            assert_eq!(medium.density_scale_in(&volume(voxel_mm)), medium.density_scale);
        }
        // It grows without a jump.
        let sizes: Vec<f64> = (0..400).map(|i| 1e-3 * 1.05f64.powi(i)).take_while(|mm| *mm < 1e4).collect();
        assert!(sizes.windows(2).all(|pair| depth(pair[1]) / depth(pair[0]) < 1.06));
    }

    #[test]
    fn surfaces_are_as_crisp_at_any_size() {
        let [small, body] =
            [5e-3, 5.0].map(|mm| Preset::Plain.medium(&volume(mm)).surface.gradient_per_mm * mm);
        // A voxel changes as much, over as much of what it looks like.
        assert!((small / body - 200.0 / 160.0).abs() < 0.02, "{small} {body}");
    }
}
