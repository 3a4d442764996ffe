//! A host's camera, from the matrices that it renders with.

use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

use super::{Camera, Projection};

/// A camera, and how a depth buffer's value tells the depth along its view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HostCamera {
    /// Where it is and what it sees.
    pub camera: Camera,
    /// `[a, b, c, d]`: the depth in metres is `(a z + b) / (c z + d)` where the buffer holds `z`.
    pub view_depth_from_ndc: [f64; 4],
}

impl HostCamera {
    /// The camera of a view. `clip_from_head` is the view's whole projection, eye offset and skew included, in any depth
    /// convention, with the image's first row at y = -1 (hosts that have it at 1 negate the second row);
    /// `world_from_head` places what it starts from, and its scale does not count. `None` if it sees nothing.
    pub fn from_matrices(world_from_head: DAffine3, clip_from_head: DMat4) -> Option<Self> {
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| clip_from_head.row(i));
        let (head_from_camera, projection, view_depth_from_ndc) =
            if w.truncate().length() > 1e-9 { perspective(x, y, z, w) } else { orthographic(x, y, z, w.w) };
        let placed = world_from_head * head_from_camera;
        let world_from_camera = DAffine3::from_mat3_translation(
            DMat3::from_cols(
                placed.matrix3.x_axis.normalize(),
                placed.matrix3.y_axis.normalize(),
                placed.matrix3.z_axis.normalize(),
            ),
            placed.translation,
        );
        let camera = Camera { world_from_camera, projection };
        let usable = camera.is_valid() && view_depth_from_ndc.iter().all(|x| x.is_finite());
        usable.then_some(Self { camera, view_depth_from_ndc })
    }
}

impl Camera {
    /// The camera without the fraction of a pixel by which a host with temporal antialiasing shifts its image, another in
    /// each frame. `size` is the image's, in pixels. Frusta that are off-centre by more are left as they are.
    #[must_use]
    pub fn without_jitter(self, size: [u32; 2]) -> Self {
        let centred = |[left, right, bottom, top]: [f64; 4]| {
            let [width, height] = [(right - left) / 2.0, (top - bottom) / 2.0];
            let [x, y] = [(right + left) / 2.0, (top + bottom) / 2.0];
            let pixel = [width, height].map(|half| 2.0 * half).into_iter().zip(size);
            let within = pixel.zip([x, y]).all(|((side, n), shift)| shift.abs() * f64::from(n) <= side.abs());
            if within { [-width, width, -height, height] } else { [left, right, bottom, top] }
        };
        let projection = match self.projection {
            Projection::Perspective { tangents } => Projection::Perspective { tangents: centred(tangents) },
            Projection::Orthographic { extents } => Projection::Orthographic { extents: centred(extents) },
        };
        Self { projection, ..self }
    }
}

/// The head from the camera, what that sees, and the depth of what a buffer holds.
type Parts = (DAffine3, Projection, [f64; 4]);

/// Rays start where clip x, y and w are all 0: the eye.
fn perspective(x: DVec4, y: DVec4, z: DVec4, w: DVec4) -> Parts {
    let plane_from_head = DMat3::from_cols(x.truncate(), y.truncate(), w.truncate()).transpose();
    let head_from_plane = plane_from_head.inverse();
    let eye = -(head_from_plane * DVec3::new(x.w, y.w, w.w));
    let rotation = facing(head_from_plane.x_axis, -w.truncate());
    let direction = |ndc: [f64; 2]| {
        let d = rotation.transpose() * (head_from_plane * DVec3::new(ndc[0], ndc[1], 1.0));
        d.truncate() / -d.z
    };
    // The buffer's first row is the image's top, at -1.
    let (low, high) = (direction([-1.0, 1.0]), direction([1.0, -1.0]));
    let forward = -rotation.z_axis;
    let view_depth_from_ndc =
        [0.0, z.truncate().dot(eye) + z.w, w.truncate().length(), -z.truncate().dot(forward)];
    let place = DAffine3::from_mat3_translation(rotation, eye);
    let tangents = [low.x, high.x, low.y, high.y];
    (place, Projection::Perspective { tangents }, view_depth_from_ndc)
}

fn orthographic(x: DVec4, y: DVec4, z: DVec4, w: f64) -> Parts {
    let clip_from_head = DMat3::from_cols(x.truncate(), y.truncate(), z.truncate()).transpose() * (1.0 / w);
    let offset = DVec3::new(x.w, y.w, z.w) / w;
    let head_from_clip = clip_from_head.inverse();
    let at = |ndc: [f64; 2]| head_from_clip * (DVec3::new(ndc[0], ndc[1], 0.0) - offset);
    // Nothing but the camera's own axes: a parallel view of a headset there is none.
    let (low, high) = (at([-1.0, 1.0]), at([1.0, -1.0]));
    let view_depth_from_ndc = [-1.0, offset.z, 0.0, clip_from_head.z_axis.z];
    let place = DAffine3::IDENTITY;
    let extents = [low.x, high.x, low.y, high.y];
    (place, Projection::Orthographic { extents }, view_depth_from_ndc)
}

/// The rotation whose columns are to the right, up and backwards.
fn facing(right: DVec3, back: DVec3) -> DMat3 {
    let back = back.normalize();
    let right = (right - back * right.dot(back)).normalize();
    DMat3::from_cols(right, back.cross(right), back)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y downwards, depth 1 at `near` and 0 at `far`.
    fn frustum([left, right, bottom, top]: [f64; 4], near: f64, far: f64) -> DMat4 {
        DMat4::from_cols(
            DVec4::new(2.0 / (right - left), 0.0, 0.0, 0.0),
            DVec4::new(0.0, -2.0 / (top - bottom), 0.0, 0.0),
            DVec4::new(
                (right + left) / (right - left),
                -(top + bottom) / (top - bottom),
                near / (far - near),
                -1.0,
            ),
            DVec4::new(0.0, 0.0, far * near / (far - near), 0.0),
        )
    }

    fn depth([a, b, c, d]: [f64; 4], z: f64) -> f64 {
        (a * z + b) / (c * z + d)
    }

    fn tangents(camera: Camera) -> [f64; 4] {
        match camera.projection {
            Projection::Perspective { tangents } => tangents,
            other => panic!("{other:?}"),
        }
    }

    fn assert_near(a: [f64; 4], b: [f64; 4]) {
        assert!(a.into_iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} is not {b:?}");
    }

    #[test]
    fn rows_may_run_upwards() {
        let edges = [-0.5, 0.75, -0.25, 0.5];
        let mut upwards = frustum(edges, 0.1, 10.0);
        upwards = DMat4::from_diagonal(DVec4::new(1.0, -1.0, 1.0, 1.0)) * upwards;
        let host = HostCamera::from_matrices(DAffine3::IDENTITY, upwards).unwrap();
        assert_near(tangents(host.camera), [-0.5, 0.75, 0.5, -0.25]);
        // The same rays, the last row's first.
        let plain = HostCamera::from_matrices(DAffine3::IDENTITY, frustum(edges, 0.1, 10.0)).unwrap();
        let (a, b) = (host.camera.ray([0.3, 0.2]), plain.camera.ray([0.3, 0.8]));
        assert!(a.direction.distance(b.direction) < 1e-12 && a.origin == b.origin);
        // And a shift by part of a pixel is still one.
        let shifted = frustum([-0.5, 0.51, -0.5, 0.51], 0.1, 10.0);
        let shifted = DMat4::from_diagonal(DVec4::new(1.0, -1.0, 1.0, 1.0)) * shifted;
        let camera = HostCamera::from_matrices(DAffine3::IDENTITY, shifted).unwrap().camera;
        assert_near(tangents(camera.without_jitter([40, 40])), [-0.505, 0.505, 0.505, -0.505]);
    }

    #[test]
    fn an_off_centre_frustum_keeps_its_edges_and_depths() {
        let edges = [-0.5, 0.75, -0.25, 0.5];
        let place = DVec3::new(1.0, 2.0, 3.0);
        // Three times as large: a node's scale is none of the camera's.
        let head = DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(3.0)), place);
        let host = HostCamera::from_matrices(head, frustum(edges, 0.125, 64.0)).unwrap();
        assert_near(tangents(host.camera), edges);
        assert!(host.camera.world_from_camera.abs_diff_eq(DAffine3::from_translation(place), 1e-9));
        assert!((depth(host.view_depth_from_ndc, 1.0) - 0.125).abs() < 1e-9);
        assert!((depth(host.view_depth_from_ndc, 0.0) - 64.0).abs() < 1e-6);
    }

    #[test]
    fn an_eye_beside_the_head_is_where_rays_start() {
        let eye = DVec3::new(0.03125, 0.0, -0.0625);
        let clip = frustum([-1.0, 1.0, -1.0, 1.0], 0.125, 64.0) * DMat4::from_translation(-eye);
        let host = HostCamera::from_matrices(DAffine3::IDENTITY, clip).unwrap();
        assert!(host.camera.world_from_camera.translation.distance(eye) < 1e-9);
        assert!((depth(host.view_depth_from_ndc, 1.0) - 0.125).abs() < 1e-9);
    }

    #[test]
    fn a_parallel_camera_keeps_its_extents_and_depths() {
        // 4 m by 2 m, depths from 1 m to 9 m.
        let clip = DMat4::from_cols(
            DVec4::new(0.5, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -1.0, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 0.125, 0.0),
            DVec4::new(0.0, 0.0, 1.125, 1.0),
        );
        let host = HostCamera::from_matrices(DAffine3::IDENTITY, clip).unwrap();
        let extents = [-2.0, 2.0, -1.0, 1.0];
        assert_eq!(host.camera.projection, Projection::Orthographic { extents });
        assert!((depth(host.view_depth_from_ndc, 1.0) - 1.0).abs() < 1e-9);
        assert!((depth(host.view_depth_from_ndc, 0.0) - 9.0).abs() < 1e-9);
    }

    #[test]
    fn jitter_is_taken_out_and_a_lens_shift_is_not() {
        let camera = |edges| {
            HostCamera::from_matrices(DAffine3::IDENTITY, frustum(edges, 0.125, 64.0)).unwrap().camera
        };
        let still = camera([-1.0, 1.0, -0.5, 0.5]).without_jitter([200, 100]);
        let jittered = camera([-1.004, 0.996, -0.497, 0.503]).without_jitter([200, 100]);
        assert_near(tangents(still), tangents(jittered));
        let shifted = camera([-1.2, 0.8, -0.5, 0.5]);
        assert_eq!(shifted.without_jitter([200, 100]), shifted);
    }

    #[test]
    fn a_flat_frustum_sees_nothing() {
        assert_eq!(HostCamera::from_matrices(DAffine3::IDENTITY, DMat4::ZERO), None);
    }
}
