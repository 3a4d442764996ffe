//! Where to put the camera: around what can be seen, not around the air of the scan.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::{
    camera::Orbit,
    medium::{ExtinctionSpace, Medium},
    scene::{Scene, VolumeInstance},
    volume::Volume,
};

/// Optical depth from which on something is seen: a tenth of the light behind it is taken away.
pub(crate) const SEEN_DEPTH: f64 = 0.105;

/// Of a voxel's extinction, the part of the largest in its volume below which it is nothing.
const NOTHING: f64 = 1e-4;

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

/// The part of a volume that its medium shows, from whichever side, as opposite corners in box coordinates; all of it if
/// nothing is shown.
pub fn visible_box(volume: &Volume, medium: &Medium) -> [DVec3; 2] {
    let extinction = Extinction::of(volume, |voxel| medium.sigma_t_per_mm(volume.value(voxel)));
    let spacing = volume.spacing_mm();
    // Along each axis, a projection shows how far the volume reaches along the two others.
    let shadows = [0, 1, 2].map(|axis| {
        let mut columns = [DVec3::ZERO; 3];
        columns[axis] = DVec3::Z * spacing[axis];
        columns[(axis + 1) % 3] = DVec3::X * spacing[(axis + 1) % 3];
        columns[(axis + 2) % 3] = DVec3::Y * spacing[(axis + 2) % 3];
        Shadow::of(&extinction, DMat3::from_cols(columns[0], columns[1], columns[2]))
    });
    extinction.box_around(volume, |at| {
        let seen = shadows.each_ref().map(|shadow| extinction.is_seen(at, shadow));
        [seen[1] || seen[2], seen[0] || seen[2], seen[0] || seen[1]]
    })
}

/// Extinction of a volume at places some voxels apart.
struct Extinction {
    stride: [usize; 3],
    /// Places along x (fastest), y and z.
    dims: [usize; 3],
    /// Per mm of the volume's own space.
    per_mm: Vec<f32>,
    /// The largest.
    most: f32,
}

impl Extinction {
    fn of(volume: &Volume, per_mm: impl Fn([usize; 3]) -> f64 + Sync) -> Self {
        let stride = strides(volume);
        let dims = [0, 1, 2].map(|axis| volume.dims()[axis].div_ceil(stride[axis]));
        let [nx, ny, nz] = dims;
        let row = |row: usize| {
            let (y, z) = (row % ny * stride[1], row / ny * stride[2]);
            let per_mm = &per_mm;
            (0..nx).map(move |x| per_mm([x * stride[0], y, z]) as f32)
        };
        let per_mm: Vec<f32> = (0..ny * nz).into_par_iter().flat_map_iter(row).collect();
        let most = per_mm.iter().copied().fold(0.0, f32::max);
        Self { stride, dims, per_mm, most }
    }

    /// The extinction at a place, if there is any to speak of.
    fn at(&self, [x, y, z]: [usize; 3]) -> Option<f64> {
        let per_mm = self.per_mm[(z * self.dims[1] + y) * self.dims[0] + x];
        (f64::from(per_mm) > NOTHING * f64::from(self.most)).then_some(per_mm.into())
    }

    /// The voxel of a place.
    fn voxel(&self, at: [usize; 3]) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|axis| (at[axis] * self.stride[axis]) as f64))
    }

    fn is_seen(&self, at: [usize; 3], shadow: &Shadow) -> bool {
        self.at(at).is_some_and(|per_mm| shadow.is_seen(self.voxel(at), per_mm))
    }

    /// The part of a volume, in box coordinates, that places reach to which count along these axes.
    fn box_around(&self, volume: &Volume, counts: impl Fn([usize; 3]) -> [bool; 3] + Sync) -> [DVec3; 2] {
        let dims = volume.dims();
        let stride = self.stride;
        let slice = |z: usize| {
            let mut sums = self.dims.map(|n| vec![0u64; n]);
            for y in 0..self.dims[1] {
                for x in 0..self.dims[0] {
                    let at = [x, y, z];
                    for (axis, counts) in counts(at).into_iter().enumerate() {
                        sums[axis][at[axis]] += u64::from(counts);
                    }
                }
            }
            sums
        };
        let sums = (0..self.dims[2]).into_par_iter().map(slice).reduce(
            || self.dims.map(|n| vec![0; n]),
            |mut a, b| {
                a.iter_mut().flatten().zip(b.into_iter().flatten()).for_each(|(a, b)| *a += b);
                a
            },
        );
        let mut corners = [DVec3::ZERO, DVec3::ONE];
        for axis in 0..3 {
            let total: u64 = sums[axis].iter().sum();
            if total == 0 {
                continue;
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
            let n = dims[axis] as f64;
            let first = beyond(&mut sums[axis].iter()) * stride[axis];
            let last = (self.dims[axis] - beyond(&mut sums[axis].iter().rev()) - 1) * stride[axis] + 1;
            corners[0][axis] = first.saturating_sub(stride[axis]) as f64 / n;
            corners[1][axis] = (last + stride[axis]).min(dims[axis]) as f64 / n;
        }
        corners
    }
}

/// The optical depth of a volume behind each pixel of a parallel projection.
struct Shadow {
    /// The picture's plane from voxels, in pixels.
    pixels_from_voxel: [DVec3; 2],
    low: [f64; 2],
    size: [usize; 2],
    depth: Vec<f32>,
    /// The largest extinction behind each.
    most: Vec<f32>,
    /// From which depth on a pixel is seen.
    seen: f32,
}

impl Shadow {
    /// `view_from_voxel`: to mm of the volume's own space, z along the view.
    fn of(extinction: &Extinction, view_from_voxel: DMat3) -> Self {
        /// Pixels are so much larger than steps between places, so that there are places behind each.
        const STEPS: f64 = 2.0;
        let stride = DVec3::from_array(extinction.stride.map(|n| n as f64));
        let step = view_from_voxel * DMat3::from_diagonal(stride);
        let across = [step.x_axis, step.y_axis, step.z_axis].map(|step| step.truncate().length());
        let pixel = STEPS * across.into_iter().fold(f64::MIN_POSITIVE, f64::max);
        let rows = (view_from_voxel * (1.0 / pixel)).transpose();
        let pixels_from_voxel = [rows.x_axis, rows.y_axis];
        let corner = |i: usize| {
            extinction.voxel([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { extinction.dims[axis] } else { 0 }))
        };
        let reach = |row: DVec3| {
            let ends = (0..8).map(|i| row.dot(corner(i)));
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        };
        let reaches = pixels_from_voxel.map(reach);
        let size = reaches.map(|[low, high]| (high - low) as usize + 1);
        let low = reaches.map(|[low, _]| low);
        let depth = vec![0.0; size[0] * size[1]];
        let mut shadow = Self { pixels_from_voxel, low, size, most: depth.clone(), depth, seen: 0.0 };
        let depth_per_extinction = step.determinant().abs() / (pixel * pixel);
        let [nx, ny, nz] = extinction.dims;
        for at in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))) {
            if let Some(per_mm) = extinction.at(at) {
                let depth = per_mm * depth_per_extinction;
                // Shared by the nearest four pixels, so that none lies between places by chance.
                let [x, y] = shadow.place(extinction.voxel(at)).map(|at| at - 0.5);
                for (column, share_x) in
                    [(x.floor(), 1.0 - x.rem_euclid(1.0)), (x.floor() + 1.0, x.rem_euclid(1.0))]
                {
                    for (row, share_y) in
                        [(y.floor(), 1.0 - y.rem_euclid(1.0)), (y.floor() + 1.0, y.rem_euclid(1.0))]
                    {
                        let pixel = shadow.pixel([column, row]);
                        shadow.depth[pixel] += (depth * share_x * share_y) as f32;
                        shadow.most[pixel] = shadow.most[pixel].max(per_mm as f32);
                    }
                }
            }
        }
        // Where nothing is seen well, what is seen best.
        let deepest = shadow.depth.iter().copied().fold(0.0, f32::max);
        shadow.seen = (SEEN_DEPTH as f32).min(deepest / 2.0);
        shadow
    }

    /// Where a voxel lies in the picture, in pixels.
    fn place(&self, voxel: DVec3) -> [f64; 2] {
        [0, 1].map(|axis| self.pixels_from_voxel[axis].dot(voxel) - self.low[axis])
    }

    /// The pixel at a place, or the nearest.
    fn pixel(&self, place: [f64; 2]) -> usize {
        let [x, y] = [0, 1].map(|axis| (place[axis].max(0.0) as usize).min(self.size[axis] - 1));
        y * self.size[0] + x
    }

    /// Whether a voxel of such an extinction is a part of what is seen: of a pixel that is, and no haze before or behind it.
    fn is_seen(&self, voxel: DVec3, per_mm: f64) -> bool {
        /// Of the largest extinction behind a pixel, what is none.
        const HAZE: f64 = 0.05;
        let pixel = self.pixel(self.place(voxel));
        let (depth, most) = (self.depth[pixel], self.most[pixel]);
        depth > 0.0 && depth >= self.seen && per_mm >= HAZE * f64::from(most)
    }
}

/// Azimuth and elevation (radians) from which a volume that is hardly more than a plane is seen from its front, as radiologists
/// look at it: from the patient's feet, left or face. `None` for whatever has an inside.
pub fn front(instance: &VolumeInstance) -> Option<[f64; 2]> {
    /// Slices of a plane, at most, and the part of its width that they are thick, at most.
    const FEW_SLICES: usize = 3;
    const THIN: f64 = 0.2;
    let volume = &*instance.volume;
    let (dims, size) = (volume.dims(), volume.size_mm().to_array());
    let axis = (0..3).min_by(|&a, &b| size[a].total_cmp(&size[b]))?;
    let others = [size[(axis + 1) % 3], size[(axis + 2) % 3]];
    if dims[axis] > FEW_SLICES || size[axis] > THIN * others[0].min(others[1]) {
        return None;
    }
    let world_from_voxel = instance.world_from_patient.matrix3 * volume.patient_from_voxel().matrix3;
    let edges = [world_from_voxel.col((axis + 1) % 3), world_from_voxel.col((axis + 2) % 3)];
    let normal = edges[0].cross(edges[1]).try_normalize()?;
    // World: +x is the patient's left, +y the head, +z the face.
    let along = normal.abs();
    let is_reversed = match () {
        () if along.y >= along.x.max(along.z) - 1e-9 => normal.y > 0.0,
        () if along.x > along.z => normal.x < 0.0,
        () => normal.z < 0.0,
    };
    let out = if is_reversed { -normal } else { normal };
    let is_upright = along.y > 1.0 - 1e-9;
    Some([if is_upright { 0.0 } else { out.x.atan2(out.z) }, out.y.clamp(-1.0, 1.0).asin()])
}

/// An orbit at `azimuth` and `elevation` (radians) that fits everything the scene shows into the image, centred.
pub fn frame(scene: &Scene, azimuth: f64, elevation: f64, vertical_fov: f64, aspect: f64) -> Orbit {
    let mut orbit = Orbit { target: DVec3::ZERO, azimuth, elevation, distance: 1.0, vertical_fov };
    let camera_from_world = orbit.camera().world_from_camera.matrix3.transpose();
    let seen: Vec<Seen> =
        scene.volumes.iter().map(|instance| Seen::new(instance, camera_from_world)).collect();
    let bounds = seen.iter().map(Seen::bounds).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let Some([low, high]) = bounds else { return orbit };
    orbit.target = (low + high) / 2.0;
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
    let mut distance = 1e-12f64;
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
    fn new(instance: &VolumeInstance, camera_from_world: DMat3) -> Self {
        let volume = &*instance.volume;
        let world_from_patient = instance.world_from_patient;
        let metres_per_mm = world_from_patient.matrix3.determinant().abs().cbrt();
        let mm = match instance.medium.extinction_space {
            ExtinctionSpace::Volume => 1.0,
            ExtinctionSpace::World => 1000.0 * metres_per_mm,
        };
        let world_from_voxel = world_from_patient * volume.patient_from_voxel();
        let clip =
            instance.clip_box.map(|corner| corner * DVec3::from_array(volume.dims().map(|n| n as f64)));
        let extinctions = instance.extinctions();
        let extinction = Extinction::of(volume, |voxel| {
            let at = DVec3::from_array(voxel.map(|i| i as f64)) + 0.5;
            let is_kept = at.cmpge(clip[0]).all() && at.cmple(clip[1]).all();
            if is_kept { mm * extinctions(voxel) } else { 0.0 }
        });
        let scale = if metres_per_mm > 0.0 { 1.0 / metres_per_mm } else { 1.0 };
        let shadow = Shadow::of(&extinction, camera_from_world * world_from_voxel.matrix3 * scale);
        let [low, high] = extinction.box_around(volume, |at| [extinction.is_seen(at, &shadow); 3]);
        let low = low.max(instance.clip_box[0]);
        let high = high.min(instance.clip_box[1]).max(low);
        let stride = extinction.stride;
        let range = |axis: usize| {
            let n = extinction.dims[axis];
            let places = volume.dims()[axis] as f64 / stride[axis] as f64;
            let first = ((low[axis] * places) as usize).min(n - 1);
            let end = ((high[axis] * places).ceil() as usize).clamp(first + 1, n);
            first..end
        };
        let ends_of_row = |y: usize, z: usize| {
            let mut row = range(0).map(move |x| [x, y, z]);
            let first = row.find(|&at| extinction.is_seen(at, &shadow));
            let last = row.rev().find(|&at| extinction.is_seen(at, &shadow));
            [first, last].into_iter().flatten()
        };
        let points: Vec<DVec3> = range(2)
            .into_par_iter()
            .flat_map_iter(|z| range(1).flat_map(move |y| ends_of_row(y, z)))
            .map(|at| world_from_voxel.transform_point3(extinction.voxel(at)))
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

    /// A ball of so many voxels of 1 mm in a box that is three times as wide, of `inside` in `outside`.
    fn ball(inside: f64, outside: f64, density_scale: f64) -> Scene {
        let n = 60;
        let voxel = |i: usize| {
            let p = DVec3::from_array([i % n, i / n % n, i / n / n].map(|x| x as f64 + 0.5 - n as f64 / 2.0));
            if p.length() < 10.0 { 200 } else { 0 }
        };
        let voxels = Voxels::U8((0..n * n * n).map(voxel).collect());
        let volume = Volume::new([n; 3], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap();
        let points = [(0.0, outside), (200.0, inside)];
        let tf = TransferFunction::from_points(crate::Ease::Linear, &points, &[(0.0, [1.0; 3])]).unwrap();
        Scene::with_volume(Arc::new(volume), Medium { density_scale, ..Medium::new(tf) })
    }

    #[test]
    fn what_is_seen_is_told_by_how_deep_it_is() {
        let distance = |scene: &Scene| frame(scene, 0.3, 0.2, 0.5, 1.0).distance;
        let solid = distance(&ball(1.0, 0.0, 1.0));
        // A hundredth of the opacity, as deep by its density, or by its own 20 mm.
        for scene in [ball(0.01, 0.0, 100.0), ball(0.02, 0.0, 1.0), ball(0.03, 0.0, 1.0)] {
            assert!((distance(&scene) / solid - 1.0).abs() < 0.1, "{} {solid}", distance(&scene));
        }
        // A function that is faint everywhere shows its densest part, not the box.
        assert!((distance(&ball(1e-4, 0.0, 1.0)) / solid - 1.0).abs() < 0.15);
        // A haze too thin to see is not framed, and one that is deep is.
        assert!((distance(&ball(1.0, 5e-4, 1.0)) / solid - 1.0).abs() < 0.15);
        assert!(distance(&ball(1.0, 0.01, 1.0)) > 2.0 * solid);
        // What is clipped away neither.
        let mut clipped = ball(1.0, 0.01, 1.0);
        clipped.volumes[0].clip_box = [DVec3::splat(1.0 / 3.0), DVec3::splat(2.0 / 3.0)];
        assert!(distance(&clipped) < 1.5 * solid);
    }

    #[test]
    fn planes_are_seen_from_their_front() {
        use std::f64::consts::FRAC_PI_2;
        let plane = |columns: [DVec3; 3], dims: [usize; 3]| {
            let place = DAffine3::from_mat3(DMat3::from_cols(columns[0], columns[1], columns[2]));
            let voxels = Voxels::U8(vec![9; dims.iter().product()]);
            let volume = Volume::new(dims, voxels, [1.0, 0.0], place, Modality::Mr).unwrap();
            let tf = TransferFunction::constant(1.0, [1.0; 3]);
            front(&VolumeInstance::centered(Arc::new(volume), Medium::new(tf)))
        };
        let near = |found: Option<[f64; 2]>, expected: [f64; 2]| {
            let found = found.expect("it is a plane");
            assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-6), "{found:?} {expected:?}");
        };
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        near(plane([x, y, z * 5.0], [64, 64, 1]), [0.0, -FRAC_PI_2]);
        near(plane([x, y, z * -5.0], [64, 64, 1]), [0.0, -FRAC_PI_2]);
        near(plane([y, -z, x * 5.0], [64, 64, 1]), [FRAC_PI_2, 0.0]);
        near(plane([x, -z, y * 5.0], [64, 64, 1]), [0.0, 0.0]);
        let tilted = (y - z).normalize();
        near(plane([x, tilted, x.cross(tilted)], [64, 64, 2]), [0.0, -FRAC_PI_2 / 2.0]);
        assert_eq!(plane([x, y, z], [64, 64, 32]), None);
        assert_eq!(plane([x, y, z * 30.0], [64, 64, 3]), None, "as deep as wide");
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
