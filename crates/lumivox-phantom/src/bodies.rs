//! Simple bodies whose every value is known.

use glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{Modality, Volume, Voxels};

use crate::{INTERCEPT, MAX_HU, stored};

/// Hounsfield units of air.
pub const AIR_HU: f64 = -1000.0;

/// Voxels of air around a body.
const MARGIN: usize = 3;

/// The test cube: `n` voxels of 1 mm along each side, 3071 HU in the centre, falling linearly with the distance from it
/// to -1024 HU in the corners.
///
/// # Panics
/// When `n` is 0.
pub fn cube(n: usize) -> Volume {
    let center = (n as f64 - 1.0) / 2.0;
    let to_corner = (3.0 * center * center).sqrt().max(f64::MIN_POSITIVE);
    volume([n; 3], DVec3::ONE, |p| MAX_HU - (MAX_HU - INTERCEPT) * p.length() / to_corner)
}

/// A box of one value in air.
///
/// Its faces lie half-way between voxel centres, so its size is `size_mm` rounded to whole voxels of `voxel_mm`
/// (at least one); three voxels of air surround it. It is centred in the volume, and the volume on the patient origin.
///
/// # Panics
/// When a size is not positive.
pub fn homogeneous_box(hu: f64, size_mm: [f64; 3], voxel_mm: f64) -> Volume {
    assert!(voxel_mm > 0.0 && size_mm.iter().all(|s| *s > 0.0), "sizes are positive");
    let inside = size_mm.map(|s| ((s / voxel_mm).round() as usize).max(1));
    let half = DVec3::from_array(inside.map(|n| n as f64 / 2.0)) * voxel_mm;
    volume(inside.map(|n| n + 2 * MARGIN), DVec3::splat(voxel_mm), |p| {
        if p.abs().cmplt(half).all() { hu } else { AIR_HU }
    })
}

/// A slab of one value in air, `thickness_mm` from front to back (along y) and ten times as wide and high.
///
/// # Panics
/// When a size is not positive.
pub fn slab(hu: f64, thickness_mm: f64, voxel_mm: f64) -> Volume {
    homogeneous_box(hu, [10.0 * thickness_mm, thickness_mm, 10.0 * thickness_mm], voxel_mm)
}

/// A ball of one value in air; voxels that its surface cuts hold the mix that a scanner would measure.
///
/// # Panics
/// When a size is not positive.
pub fn sphere(hu: f64, radius_mm: f64, voxel_mm: f64) -> Volume {
    assert!(voxel_mm > 0.0 && radius_mm > 0.0, "sizes are positive");
    let n = 2 * ((radius_mm / voxel_mm).ceil() as usize + MARGIN) + 1;
    volume([n; 3], DVec3::splat(voxel_mm), |p| {
        let inside = ((radius_mm - p.length()) / voxel_mm + 0.5).clamp(0.0, 1.0);
        AIR_HU + (hu - AIR_HU) * inside
    })
}

/// One value everywhere, up to the volume's faces: for exact transmittances, because no edge is blurred by a filter.
///
/// # Panics
/// When a side has no voxel, or the spacing is not positive.
pub fn solid(hu: f64, dims: [usize; 3], spacing_mm: [f64; 3]) -> Volume {
    assert!(spacing_mm.iter().all(|s| *s > 0.0), "a spacing is positive");
    volume(dims, DVec3::from_array(spacing_mm), |_| hu)
}

/// A CT volume centred on the patient origin, from its value at a place in mm.
fn volume(dims: [usize; 3], spacing: DVec3, hu: impl Fn(DVec3) -> f64) -> Volume {
    let last = DVec3::from_array(dims.map(|n| n as f64 - 1.0));
    let place = DAffine3::from_mat3_translation(DMat3::from_diagonal(spacing), -last * spacing / 2.0);
    let samples = (0..dims[2])
        .flat_map(|z| (0..dims[1]).map(move |y| (y, z)))
        .flat_map(|(y, z)| (0..dims[0]).map(move |x| [x, y, z]))
        .map(|index| {
            let index = DVec3::from_array(index.map(|i| i as f64));
            stored(hu(place.transform_point3(index)))
        })
        .collect();
    Volume::new(dims, Voxels::U16(samples), [1.0, INTERCEPT], place, Modality::Ct)
        .expect("dims and spacing are positive")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cube_falls_from_the_centre_to_the_corners() {
        let cube = cube(33);
        assert_eq!(cube.value([16; 3]), 3071.0);
        for corner in [[0, 0, 0], [32, 0, 32], [32, 32, 32]] {
            assert_eq!(cube.value(corner), -1024.0);
        }
        // Half-way along a diagonal.
        assert!((cube.value([8; 3]) - 1023.5).abs() <= 0.5);
        let face = 3071.0 - 4095.0 / 3f64.sqrt();
        assert!((cube.value([16, 0, 16]) - face).abs() <= 0.5);
        assert!(cube.center_mm().length() < 1e-9);
        assert_eq!(super::cube(1).value([0; 3]), 3071.0);
    }

    #[test]
    fn a_box_has_its_size_and_its_value() {
        let body = homogeneous_box(500.0, [10.0, 20.0, 5.0], 0.5);
        assert_eq!(body.dims(), [26, 46, 16]);
        let [x, y, z] = body.dims();
        let mut inside = 0;
        for i in 0..x * y * z {
            let value = body.value([i % x, i / x % y, i / (x * y)]);
            assert!(value == 500.0 || value == AIR_HU);
            inside += usize::from(value == 500.0);
        }
        assert_eq!(inside as f64 * 0.125, 1000.0, "its volume in cubic mm");
        assert_eq!(body.value([0, 20, 8]), AIR_HU);
    }

    #[test]
    fn a_slab_is_thin_from_front_to_back() {
        let slab = slab(0.0, 4.0, 1.0);
        assert_eq!(slab.dims(), [46, 10, 46]);
        assert_eq!(slab.value([23, 5, 23]), 0.0);
        assert_eq!(slab.value([23, 1, 23]), AIR_HU);
    }

    #[test]
    fn a_sphere_has_its_volume() {
        let ball = sphere(1000.0, 12.0, 1.0);
        let sum: f64 = (0..ball.voxel_count())
            .map(|i| (ball.voxels().get(i) + INTERCEPT - AIR_HU) / (1000.0 - AIR_HU))
            .sum();
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 12f64.powi(3);
        assert!((sum / exact - 1.0).abs() < 0.01, "{sum} against {exact}");
    }

    #[test]
    fn a_solid_is_solid() {
        let solid = solid(40.0, [2, 3, 4], [1.0, 2.0, 3.0]);
        assert_eq!(solid.value_range(), [40.0, 40.0]);
        assert_eq!(solid.size_mm(), DVec3::new(2.0, 6.0, 12.0));
    }
}
