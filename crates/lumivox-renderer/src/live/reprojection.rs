//! Where a point of an image was in the image before.

use lumivox_core::glam::{DMat4, DVec4};
use lumivox_core::{Camera, Projection};

/// From `(x d, y d, d, 1)` of a point at depth `d` in an image of `now` to the same in one of `before`; of parallel rays from
/// `(x, y, d, 1)`. x and y are in \[-1, 1\], y downwards. `None` where one of them sees in parallel and the other does not.
pub(super) fn before_from_now(before: &Camera, now: &Camera) -> Option<DMat4> {
    if is_parallel(before) != is_parallel(now) {
        return None;
    }
    let [world_from_before, world_from_now] = [before, now].map(|it| DMat4::from(it.world_from_camera));
    Some(
        camera_from_image(before).inverse()
            * world_from_before.inverse()
            * world_from_now
            * camera_from_image(now),
    )
}

pub(super) fn is_parallel(camera: &Camera) -> bool {
    matches!(camera.projection, Projection::Orthographic { .. })
}

fn camera_from_image(camera: &Camera) -> DMat4 {
    let (Projection::Perspective { tangents: edges } | Projection::Orthographic { extents: edges }) =
        camera.projection;
    let [left, right, bottom, top] = edges;
    let centre = DVec4::new((right + left) / 2.0, (top + bottom) / 2.0, 0.0, 0.0);
    let (by_depth, alone) = match is_parallel(camera) {
        true => (DVec4::ZERO, centre),
        false => (centre, DVec4::ZERO),
    };
    DMat4::from_cols(
        DVec4::X * ((right - left) / 2.0),
        DVec4::NEG_Y * ((top - bottom) / 2.0),
        by_depth - DVec4::Z,
        alone + DVec4::W,
    )
}

#[cfg(test)]
mod tests {
    use lumivox_core::glam::{DAffine3, DVec3};

    use super::*;

    #[test]
    fn a_point_is_found_where_it_was() {
        let place = |angle: f64, way: [f64; 3]| {
            DAffine3::from_rotation_y(angle) * DAffine3::from_translation(way.into())
        };
        let edges = [[-0.5, 0.7, -0.3, 0.4], [-0.6, 0.5, -0.2, 0.5]];
        let point = DVec3::new(0.1, -0.2, -2.0);
        for parallel in [false, true] {
            let camera = |i: usize, angle, way| Camera {
                world_from_camera: place(angle, way),
                projection: match parallel {
                    true => Projection::Orthographic { extents: edges[i] },
                    false => Projection::Perspective { tangents: edges[i] },
                },
            };
            let cameras = [camera(0, 0.1, [0.0, 0.1, 0.3]), camera(1, -0.2, [0.2, 0.0, 0.0])];
            let seen = |i: usize| {
                let p = cameras[i].world_from_camera.inverse().transform_point3(point);
                let scale = if parallel { 1.0 } else { -p.z };
                let [left, right, bottom, top] = edges[i];
                let x = 2.0 * (p.x / scale - left) / (right - left) - 1.0;
                let y = 1.0 - 2.0 * (p.y / scale - bottom) / (top - bottom);
                DVec4::new(x * scale, y * scale, -p.z, 1.0)
            };
            let map = before_from_now(&cameras[0], &cameras[1]).unwrap();
            assert!((map * seen(1) - seen(0)).length() < 1e-12, "{} {}", map * seen(1), seen(0));
        }
    }
}
