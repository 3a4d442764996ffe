//! Where to put the camera: around what can be seen, not around the air of the scan.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::{camera::Orbit, medium::Medium, scene::Scene, scene::VolumeInstance, volume::Volume};

/// Opacity under which a voxel does not count as seen.
const VISIBLE_OPACITY: f64 = 0.05;

/// Fraction of the seen voxels that may lie outside the box on each side: noise and table edges do not steer the
/// camera.
const OUTLIERS: f64 = 0.002;

/// Voxels looked at along each axis, at most.
const LOOKS: usize = 128;

/// Room left around what is seen, as a fraction of the camera's distance.
const MARGIN: f64 = 0.04;

fn strides(volume: &Volume) -> [usize; 3] {
    volume.dims().map(|n| n.div_ceil(LOOKS))
}

/// The part of a volume that its medium shows, as opposite corners in box coordinates; all of it if nothing is shown.
pub fn visible_box(volume: &Volume, medium: &Medium) -> [DVec3; 2] {
    box_around(volume, |voxel| medium.transfer_function.opacity(volume.value(voxel)) > VISIBLE_OPACITY)
}

/// The part of a volume whose voxels are `visible`.
fn box_around(volume: &Volume, visible: impl Fn([usize; 3]) -> bool + Sync) -> [DVec3; 2] {
    let dims = volume.dims();
    let stride = strides(volume);
    let counts = (0..dims[2].div_ceil(stride[2]))
        .into_par_iter()
        .map(|slice| {
            let z = slice * stride[2];
            let mut counts = dims.map(|n| vec![0u64; n]);
            for y in (0..dims[1]).step_by(stride[1]) {
                for x in (0..dims[0]).step_by(stride[0]) {
                    if visible([x, y, z]) {
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

/// An orbit at `azimuth` and `elevation` (radians) that fits everything the scene shows into the image, centred.
pub fn frame(scene: &Scene, azimuth: f64, elevation: f64, vertical_fov: f64, aspect: f64) -> Orbit {
    let seen: Vec<Seen> = scene.volumes.iter().map(Seen::new).collect();
    let mut orbit = Orbit { target: DVec3::ZERO, azimuth, elevation, distance: 1.0, vertical_fov };
    let bounds = seen.iter().map(Seen::bounds).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let Some([low, high]) = bounds else { return orbit };
    orbit.target = (low + high) / 2.0;
    let camera_from_world = orbit.camera().world_from_camera.matrix3.transpose();
    let slope = [(vertical_fov / 2.0).tan() * aspect, (vertical_fov / 2.0).tan()];
    // A point at p, seen from a distance d, is inside the image's right edge if p.x - shift <= slope * (d - p.z): how
    // far each edge reaches, d and shift aside. The shift that makes opposite edges equal lets d be the smallest.
    let mut reaches = [[f64::NEG_INFINITY; 2]; 2];
    for seen in &seen {
        let around = reach(camera_from_world * seen.half_edges);
        for &point in &seen.points {
            let p = camera_from_world * (point - orbit.target);
            for axis in 0..2 {
                let depth = slope[axis] * (p.z + around.z) + around[axis];
                reaches[axis][0] = reaches[axis][0].max(depth + p[axis]);
                reaches[axis][1] = reaches[axis][1].max(depth - p[axis]);
            }
        }
    }
    let mut shift = DVec3::ZERO;
    let mut distance = 1e-6f64;
    for axis in 0..2 {
        let [forth, back] = reaches[axis];
        shift[axis] = (forth - back) / 2.0;
        distance = distance.max((forth + back) / (2.0 * slope[axis]));
    }
    orbit.target += camera_from_world.transpose() * shift;
    orbit.distance = distance * (1.0 + MARGIN);
    orbit
}

/// What a volume shows, in world space: points with the same parallelepiped around each.
struct Seen {
    points: Vec<DVec3>,
    /// Half the edges of the parallelepiped.
    half_edges: DMat3,
}

impl Seen {
    /// The first and the last voxel that is seen in each row: nothing that is seen lies outside their convex hull.
    fn new(instance: &VolumeInstance) -> Self {
        let volume = &*instance.volume;
        let visible = instance.opacities();
        let visible = |voxel| visible(voxel) > VISIBLE_OPACITY;
        let [low, high] = box_around(volume, visible);
        let low = low.max(instance.clip_box[0]);
        let high = high.min(instance.clip_box[1]).max(low);
        let stride = strides(volume);
        let range = |axis: usize| {
            let n = volume.dims()[axis];
            let first = ((low[axis] * n as f64) as usize).min(n - 1);
            let end = ((high[axis] * n as f64).ceil() as usize).clamp(first + 1, n);
            first..end
        };
        let world_from_voxel = instance.world_from_patient * volume.patient_from_voxel();
        let point = |voxel: [usize; 3]| {
            world_from_voxel.transform_point3(DVec3::from_array(voxel.map(|index| index as f64)))
        };
        let ends_of_row = |y: usize, z: usize| {
            let mut row = range(0).step_by(stride[0]).map(move |x| [x, y, z]);
            let first = row.find(|&voxel| visible(voxel));
            let last = row.rev().find(|&voxel| visible(voxel));
            [first, last].into_iter().flatten()
        };
        let points: Vec<DVec3> = range(2)
            .into_par_iter()
            .step_by(stride[2])
            .flat_map_iter(|z| range(1).step_by(stride[1]).flat_map(move |y| ends_of_row(y, z)))
            .map(point)
            .collect();
        if points.is_empty() {
            let world_from_box = instance.world_from_box();
            let corner = |i: usize| DVec3::from_array([0, 1, 2].map(|axis| [low, high][i >> axis & 1][axis]));
            let points = (0..8).map(|i| world_from_box.transform_point3(corner(i))).collect();
            return Self { points, half_edges: DMat3::ZERO };
        }
        // A voxel reaches half its size from its centre; what was stepped over may be seen as well.
        let half_edges = DVec3::from_array(stride.map(|n| n as f64 - 0.5));
        Self { points, half_edges: world_from_voxel.matrix3 * DMat3::from_diagonal(half_edges) }
    }

    /// Opposite corners of the box around everything, along the world's axes.
    fn bounds(&self) -> [DVec3; 2] {
        let low = self.points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = self.points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let reach = reach(self.half_edges);
        [low - reach, high + reach]
    }
}

/// How far a parallelepiped reaches from its centre along each axis.
fn reach(half_edges: DMat3) -> DVec3 {
    half_edges.x_axis.abs() + half_edges.y_axis.abs() + half_edges.z_axis.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Modality, TransferFunction, Voxels};
    use glam::DAffine3;
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

    /// A body that fills its box, of odd proportions and turned.
    fn full_box(opacity: f64) -> Scene {
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.8, 0.5, 3.0),
            glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.4),
            DVec3::new(50.0, -20.0, 700.0),
        );
        let dims = [40, 150, 10];
        let voxels = Voxels::U8(vec![200; dims.iter().product()]);
        let volume = Volume::new(dims, voxels, [1.0, 0.0], place, Modality::Other).unwrap();
        let points = [(0.0, opacity)];
        let tf = TransferFunction::from_points(crate::Ease::Linear, &points, &[(0.0, [1.0; 3])]).unwrap();
        Scene::with_volume(Arc::new(volume), Medium::new(tf))
    }

    #[test]
    fn the_corners_of_a_full_box_are_in_the_image_and_it_fills_the_image() {
        // Nothing that is seen: the whole box is framed just as well.
        for (opacity, clip) in [(1.0, DVec3::ONE), (0.0, DVec3::ONE), (1.0, DVec3::new(0.5, 0.3, 0.9))] {
            let mut scene = full_box(opacity);
            scene.volumes[0].clip_box[1] = clip;
            let world_from_box = scene.volumes[0].world_from_box();
            for (azimuth, elevation) in [(0.0, 0.0), (0.6, 0.3), (1.57, 0.0), (2.5, -1.0), (4.0, 1.5)] {
                for (aspect, fov) in [(1.0, 0.5), (4.0, 0.5), (0.25, 0.5), (1.5, 1.6)] {
                    let camera = frame(&scene, azimuth, elevation, fov, aspect).camera();
                    let half = (fov / 2.0).tan();
                    let mut reached = 0.0f64;
                    for corner in 0..8 {
                        let bit = |axis: usize| f64::from(corner >> axis & 1);
                        let corner = clip * DVec3::new(bit(0), bit(1), bit(2));
                        let world = world_from_box.transform_point3(corner);
                        let p = camera.world_from_camera.inverse().transform_point3(world);
                        assert!(p.z < 0.0, "behind the camera");
                        reached = reached.max(p.y.abs() / -p.z / half).max(p.x.abs() / -p.z / half / aspect);
                    }
                    assert!(
                        reached < 1.0 && reached > 0.7,
                        "{reached} at {azimuth}, {elevation}, aspect {aspect}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_round_body_fills_the_image_as_well() {
        let n = 64;
        let voxel = |i: usize| {
            let p = DVec3::from_array([i % n, i / n % n, i / n / n].map(|x| x as f64 + 0.5 - n as f64 / 2.0));
            if p.length() < 30.0 { 200 } else { 0 }
        };
        let voxels = Voxels::U8((0..n * n * n).map(voxel).collect());
        let volume = Volume::new([n; 3], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap();
        let tf = TransferFunction::from_points(
            crate::Ease::Linear,
            &[(0.0, 0.0), (200.0, 1.0)],
            &[(0.0, [1.0; 3])],
        )
        .unwrap();
        let scene = Scene::with_volume(Arc::new(volume), Medium::new(tf));
        for azimuth in [0.0, 0.8] {
            let orbit = frame(&scene, azimuth, 0.6, 0.5, 1.0);
            let fills = (0.030 / orbit.distance).asin() / 0.25;
            assert!(fills > 0.85 && fills < 1.0, "{fills}");
        }
    }
}
