//! Where to put the camera: around what can be seen, not around the air of the scan.

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use crate::{camera::Orbit, medium::Medium, scene::Scene, scene::VolumeInstance, volume::Volume};

/// Opacity under which a voxel does not count as seen.
const VISIBLE_OPACITY: f64 = 0.05;

/// Fraction of the seen voxels that may lie outside the box on each side: noise and table edges do not steer the
/// camera.
const OUTLIERS: f64 = 0.002;

/// The part of a volume that its medium shows, as opposite corners in box coordinates; all of it if nothing is shown.
pub fn visible_box(volume: &Volume, medium: &Medium) -> [DVec3; 2] {
    let dims = volume.dims();
    let stride = dims.map(|n| (n / 128).max(1));
    let visible = |value: f64| medium.transfer_function.opacity(value) > VISIBLE_OPACITY;
    let counts = (0..dims[2].div_ceil(stride[2]))
        .into_par_iter()
        .map(|slice| {
            let z = slice * stride[2];
            let mut counts = dims.map(|n| vec![0u64; n]);
            for y in (0..dims[1]).step_by(stride[1]) {
                for x in (0..dims[0]).step_by(stride[0]) {
                    if visible(volume.value([x, y, z])) {
                        counts[0][x] += 1;
                        counts[1][y] += 1;
                        counts[2][z] += 1;
                    }
                }
            }
            counts
        })
        .reduce(
            || dims.map(|n| vec![0; n]),
            |mut a, b| {
                a.iter_mut().flatten().zip(b.into_iter().flatten()).for_each(|(a, b)| *a += b);
                a
            },
        );
    let total: u64 = counts[0].iter().sum();
    if total == 0 {
        return [DVec3::ZERO, DVec3::ONE];
    }
    let allowed = (total as f64 * OUTLIERS) as u64;
    let beyond = |counts: &mut dyn Iterator<Item = &u64>| {
        let mut sum = 0;
        counts
            .take_while(|&&c| {
                sum += c;
                sum <= allowed
            })
            .count()
    };
    let mut corners = [DVec3::ZERO, DVec3::ONE];
    for axis in 0..3 {
        let n = dims[axis] as f64;
        let first = beyond(&mut counts[axis].iter());
        let last = dims[axis] - beyond(&mut counts[axis].iter().rev());
        corners[0][axis] = (first.saturating_sub(stride[axis])) as f64 / n;
        corners[1][axis] = (last + stride[axis]).min(dims[axis]) as f64 / n;
    }
    corners
}

/// An orbit at `azimuth` and `elevation` (radians) that fits everything the scene shows into the image.
pub fn frame(scene: &Scene, azimuth: f64, elevation: f64, vertical_fov: f64, aspect: f64) -> Orbit {
    let corners: Vec<DVec3> = scene.volumes.iter().flat_map(visible_corners).collect();
    let mut orbit = Orbit { target: DVec3::ZERO, azimuth, elevation, distance: 1.0, vertical_fov };
    if corners.is_empty() {
        return orbit;
    }
    let low = corners.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = corners.iter().copied().reduce(DVec3::max).unwrap_or_default();
    orbit.target = (low + high) / 2.0;
    // A rounded body does not fill the corners of its box: frame the box drawn in a little.
    const ROUNDNESS: f64 = 0.93;
    let camera_from_world =
        DAffine3 { translation: DVec3::ZERO, ..orbit.camera().world_from_camera }.inverse();
    let half = (vertical_fov / 2.0).tan();
    orbit.distance = corners
        .iter()
        .map(|&corner| {
            let p = camera_from_world.transform_vector3((corner - orbit.target) * ROUNDNESS);
            p.z + p.y.abs().max(p.x.abs() / aspect) / half
        })
        .fold(1e-6, f64::max)
        * 1.04;
    orbit
}

fn visible_corners(instance: &VolumeInstance) -> [DVec3; 8] {
    let [low, high] = visible_box(&instance.volume, &instance.medium);
    let low = low.max(instance.clip_box[0]);
    let high = high.min(instance.clip_box[1]).max(low);
    let world_from_box = instance.world_from_box();
    std::array::from_fn(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        world_from_box.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Modality, TransferFunction, Voxels};
    use std::sync::Arc;

    #[test]
    fn the_camera_looks_at_what_is_seen_and_sees_all_of_it() {
        let mut samples = vec![0u8; 20 * 20 * 20];
        for z in 12..18 {
            for y in 2..6 {
                for x in 8..11 {
                    samples[(z * 20 + y) * 20 + x] = 200;
                }
            }
        }
        let id = DAffine3::IDENTITY;
        let volume = Volume::new([20; 3], Voxels::U8(samples), [1.0, 0.0], id, Modality::Other).unwrap();
        let tf = TransferFunction::from_points(
            crate::Ease::Linear,
            &[(100.0, 0.0), (150.0, 1.0)],
            &[(0.0, [1.0; 3])],
        )
        .unwrap();
        let medium = Medium::new(tf);
        let [low, high] = visible_box(&volume, &medium);
        assert_eq!(low * 20.0, DVec3::new(7.0, 1.0, 11.0));
        assert_eq!(high * 20.0, DVec3::new(12.0, 7.0, 19.0));
        let scene = Scene::with_volume(Arc::new(volume), medium);
        let orbit = frame(&scene, 0.0, 0.0, 0.6, 1.5);
        // Voxel z 12..18 of 20 lies above the centre: the camera looks there.
        assert!(orbit.target.y > 0.003, "{}", orbit.target);
        assert!(orbit.distance > 0.008 && orbit.distance < 0.05, "{}", orbit.distance);
    }
}
