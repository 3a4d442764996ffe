//! Godot's camera, as the core sees it.

use godot::prelude::{Projection, Transform3D};
use lumivox_core::Camera;
use lumivox_core::glam::{DAffine3, DMat3, DVec3, DVec4};

use crate::convert;

/// A camera, and how a depth buffer's value tells the depth along its view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HostCamera {
    /// Where it is and what it sees.
    pub camera: Camera,
    /// `[a, b, c, d]`: the depth in metres is `(a z + b) / (c z + d)` where the buffer holds `z`.
    pub view_depth_from_ndc: [f64; 4],
}

/// The camera of a view. `clip_from_head` is the view's whole projection (y downwards, any depth convention), eye
/// offset and skew included; `world_from_head` places what it starts from. `None` if it sees nothing.
pub fn host_camera(world_from_head: Transform3D, clip_from_head: Projection) -> Option<HostCamera> {
    let world_from_head = convert::affine(world_from_head);
    let columns = clip_from_head.cols;
    let row = |i: usize| {
        let [a, b, c, d] = columns.map(|column| f64::from([column.x, column.y, column.z, column.w][i]));
        DVec4::new(a, b, c, d)
    };
    let [x, y, z, w] = [row(0), row(1), row(2), row(3)];
    let host =
        if w.truncate().length() > 1e-9 { perspective(x, y, z, w) } else { orthographic(x, y, z, w.w) };
    let (head_from_camera, edges, view_depth_from_ndc, parallel) = host;
    let [left, right, bottom, top] = edges;
    let projection = if parallel {
        lumivox_core::Projection::Orthographic { extents: [left, right, bottom, top] }
    } else {
        lumivox_core::Projection::Perspective { tangents: [left, right, bottom, top] }
    };
    // The node's scale is none of the camera's.
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
    usable.then_some(HostCamera { camera, view_depth_from_ndc })
}

/// The camera without the fraction of a pixel by which a host with temporal antialiasing shifts its image, another in
/// each frame. `size` is the image's, in pixels. Frusta that are off-centre by more are left as they are.
pub fn without_jitter(camera: Camera, size: [u32; 2]) -> Camera {
    let centred = |[left, right, bottom, top]: [f64; 4]| {
        let [width, height] = [(right - left) / 2.0, (top - bottom) / 2.0];
        let [x, y] = [(right + left) / 2.0, (top + bottom) / 2.0];
        let pixel = [width, height].map(|half| 2.0 * half).into_iter().zip(size);
        let within = pixel.zip([x, y]).all(|((side, n), shift)| shift.abs() * f64::from(n) <= side);
        if within { [-width, width, -height, height] } else { [left, right, bottom, top] }
    };
    let projection = match camera.projection {
        lumivox_core::Projection::Perspective { tangents } => {
            lumivox_core::Projection::Perspective { tangents: centred(tangents) }
        }
        lumivox_core::Projection::Orthographic { extents } => {
            lumivox_core::Projection::Orthographic { extents: centred(extents) }
        }
    };
    Camera { projection, ..camera }
}

type Parts = (DAffine3, [f64; 4], [f64; 4], bool);

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
    (place, [low.x, high.x, low.y, high.y], view_depth_from_ndc, false)
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
    (place, [low.x, high.x, low.y, high.y], view_depth_from_ndc, true)
}

/// The rotation whose columns are to the right, up and backwards.
fn facing(right: DVec3, back: DVec3) -> DMat3 {
    let back = back.normalize();
    let right = (right - back * right.dot(back)).normalize();
    DMat3::from_cols(right, back.cross(right), back)
}

#[cfg(test)]
mod tests {
    use godot::prelude::{Basis, Vector3, Vector4};

    use super::*;

    /// What Godot makes of a frustum: y downwards, depth 1 at `near` and 0 at `far`.
    fn frustum([left, right, bottom, top]: [f64; 4], near: f64, far: f64) -> Projection {
        let column = |a: f64, b: f64, c: f64, d: f64| Vector4::new(a as f32, b as f32, c as f32, d as f32);
        Projection {
            cols: [
                column(2.0 / (right - left), 0.0, 0.0, 0.0),
                column(0.0, -2.0 / (top - bottom), 0.0, 0.0),
                column(
                    (right + left) / (right - left),
                    -(top + bottom) / (top - bottom),
                    near / (far - near),
                    -1.0,
                ),
                column(0.0, 0.0, far * near / (far - near), 0.0),
            ],
        }
    }

    fn depth([a, b, c, d]: [f64; 4], z: f64) -> f64 {
        (a * z + b) / (c * z + d)
    }

    #[test]
    fn an_off_centre_frustum_keeps_its_edges_and_depths() {
        let edges = [-0.5, 0.75, -0.25, 0.5];
        let head = Transform3D::new(Basis::IDENTITY, Vector3::new(1.0, 2.0, 3.0));
        let host = host_camera(head, frustum(edges, 0.125, 64.0)).unwrap();
        let lumivox_core::Projection::Perspective { tangents } = host.camera.projection else { panic!() };
        for (a, b) in tangents.into_iter().zip(edges) {
            assert!((a - b).abs() < 1e-6, "{tangents:?}");
        }
        assert!(host.camera.world_from_camera.translation.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-6);
        assert!((depth(host.view_depth_from_ndc, 1.0) - 0.125).abs() < 1e-6);
        assert!((depth(host.view_depth_from_ndc, 0.0) - 64.0).abs() < 1e-2);
    }

    #[test]
    fn an_eye_beside_the_head_is_where_rays_start() {
        let eye = DVec3::new(0.03125, 0.0, -0.0625);
        let mut clip = frustum([-1.0, 1.0, -1.0, 1.0], 0.125, 64.0);
        let [x, y, z, w] = clip.cols;
        clip.cols[3] = w - x * eye.x as f32 - y * eye.y as f32 - z * eye.z as f32;
        let host = host_camera(Transform3D::IDENTITY, clip).unwrap();
        assert!(host.camera.world_from_camera.translation.distance(eye) < 1e-5);
        assert!((depth(host.view_depth_from_ndc, 1.0) - 0.125).abs() < 1e-5);
    }

    #[test]
    fn a_parallel_camera_keeps_its_extents_and_depths() {
        let column = Vector4::new;
        // 4 m by 2 m, depths from 1 m to 9 m.
        let clip = Projection {
            cols: [
                column(0.5, 0.0, 0.0, 0.0),
                column(0.0, -1.0, 0.0, 0.0),
                column(0.0, 0.0, 0.125, 0.0),
                column(0.0, 0.0, 1.125, 1.0),
            ],
        };
        let host = host_camera(Transform3D::IDENTITY, clip).unwrap();
        let extents = [-2.0, 2.0, -1.0, 1.0];
        assert_eq!(host.camera.projection, lumivox_core::Projection::Orthographic { extents });
        assert!((depth(host.view_depth_from_ndc, 1.0) - 1.0).abs() < 1e-6);
        assert!((depth(host.view_depth_from_ndc, 0.0) - 9.0).abs() < 1e-6);
    }

    #[test]
    fn jitter_is_taken_out_and_a_lens_shift_is_not() {
        let camera = |edges| host_camera(Transform3D::IDENTITY, frustum(edges, 0.125, 64.0)).unwrap().camera;
        let still = without_jitter(camera([-1.0, 1.0, -0.5, 0.5]), [200, 100]);
        let jittered = without_jitter(camera([-1.004, 0.996, -0.497, 0.503]), [200, 100]);
        let edges = |camera: Camera| match camera.projection {
            lumivox_core::Projection::Perspective { tangents } => tangents,
            other => panic!("{other:?}"),
        };
        for (a, b) in edges(still).into_iter().zip(edges(jittered)) {
            assert!((a - b).abs() < 1e-6);
        }
        let shifted = camera([-1.2, 0.8, -0.5, 0.5]);
        assert_eq!(without_jitter(shifted, [200, 100]), shifted);
    }

    #[test]
    fn a_flat_frustum_sees_nothing() {
        let flat = Projection { cols: [Vector4::ZERO; 4] };
        assert_eq!(host_camera(Transform3D::IDENTITY, flat), None);
    }
}
