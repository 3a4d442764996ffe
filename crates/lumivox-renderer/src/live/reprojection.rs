//! Where a point of an image was in the image before.

use std::collections::HashMap;

use lumivox_core::glam::{DAffine3, DMat4, DVec4};
use lumivox_core::{Camera, Projection};

use crate::scene_cache::Numbered;

/// What an image shows: from where, and which volumes where in the world.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub camera: Camera,
    pub volumes: Vec<(Numbered, DAffine3)>,
}

/// How much two volumes' ways may differ that were moved as one, in their own millimetres.
const AS_ONE: f64 = 1e-4;

/// From `(x d, y d, d, 1)` of a point at depth `d` in an image of `now` to the same in the one `before`; of parallel rays from
/// `(x, y, d, 1)`. x and y are in \[-1, 1\], y downwards. `None` where one of them sees in parallel and the other does not.
pub(super) fn before_from_now(before: &Seen, now: &Seen) -> Option<DMat4> {
    if is_parallel(&before.camera) != is_parallel(&now.camera) {
        return None;
    }
    let [camera_from_before, camera_from_now] = [before, now].map(|it| camera_from_image(&it.camera));
    let [world_from_before, world_from_now] =
        [before, now].map(|it| DMat4::from(it.camera.world_from_camera));
    Some(
        camera_from_before.inverse()
            * world_from_before.inverse()
            * DMat4::from(moved_back(before, now))
            * world_from_now
            * camera_from_now,
    )
}

/// From where volumes are now to where they were, if all that there were have moved as one; else as if none had: what did is found
/// elsewhere than it was looked for, and known by its depth to be something else.
fn moved_back(before: &Seen, now: &Seen) -> DAffine3 {
    let was: HashMap<_, _> = before.volumes.iter().copied().collect();
    let mut places = now.volumes.iter().filter_map(|(volume, is)| Some((*was.get(volume)?, *is)));
    let Some((was, is)) = places.next() else { return DAffine3::IDENTITY };
    let way = was * is.inverse();
    let is_same =
        |(was, is): (DAffine3, DAffine3)| (way * is).abs_diff_eq(was, AS_ONE * was.matrix3.x_axis.length());
    if way.is_finite() && places.all(is_same) { way } else { DAffine3::IDENTITY }
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
    use lumivox_core::glam::DVec3;

    use super::*;
    use crate::ids;

    fn camera(parallel: bool, place: DAffine3, edges: [f64; 4]) -> Camera {
        let projection = match parallel {
            true => Projection::Orthographic { extents: edges },
            false => Projection::Perspective { tangents: edges },
        };
        Camera { world_from_camera: place, projection }
    }

    fn place(angle: f64, way: [f64; 3]) -> DAffine3 {
        DAffine3::from_rotation_y(angle) * DAffine3::from_translation(way.into())
    }

    /// A point of the world in an image, as maps take it.
    fn shown(camera: &Camera, point: DVec3) -> DVec4 {
        let p = camera.world_from_camera.inverse().transform_point3(point);
        let (scale, edges) = match camera.projection {
            Projection::Orthographic { extents } => (1.0, extents),
            Projection::Perspective { tangents } => (-p.z, tangents),
        };
        let [left, right, bottom, top] = edges;
        let x = 2.0 * (p.x / scale - left) / (right - left) - 1.0;
        let y = 1.0 - 2.0 * (p.y / scale - bottom) / (top - bottom);
        DVec4::new(x * scale, y * scale, -p.z, 1.0)
    }

    const EDGES: [[f64; 4]; 2] = [[-0.5, 0.7, -0.3, 0.4], [-0.6, 0.5, -0.2, 0.5]];
    const POINT: DVec3 = DVec3::new(0.1, -0.2, -2.0);

    #[test]
    fn a_point_is_found_where_it_was() {
        for parallel in [false, true] {
            let seen = |i: usize, place| Seen { camera: camera(parallel, place, EDGES[i]), volumes: vec![] };
            let images = [seen(0, place(0.1, [0.0, 0.1, 0.3])), seen(1, place(-0.2, [0.2, 0.0, 0.0]))];
            let map = before_from_now(&images[0], &images[1]).unwrap();
            let [was, is] = [0, 1].map(|i| shown(&images[i].camera, POINT));
            assert!((map * is - was).length() < 1e-12, "{} {was}", map * is);
        }
        let [one, other] = [false, true].map(|parallel| Seen {
            camera: camera(parallel, place(0.0, [0.0; 3]), EDGES[0]),
            volumes: vec![],
        });
        assert!(before_from_now(&one, &other).is_none());
    }

    #[test]
    fn what_moved_is_found_where_it_was_before_it_did() {
        let ids = [7, 3, 5].map(|number| (number, ids::next()));
        let millimetres = DAffine3::from_scale(DVec3::splat(1e-3));
        // Far from the world's origin, too.
        for far in [0.0, 1e4] {
            let stood = |i: usize| place(0.3 * i as f64, [0.1 * i as f64, far, 0.0]) * millimetres;
            let way = DAffine3::from_translation(DVec3::new(0.05, far, 0.1))
                * DAffine3::from_rotation_z(0.2)
                * DAffine3::from_translation(DVec3::new(0.0, -far, 0.0));
            let point = POINT + DVec3::Y * far;
            let seen = |i: usize, volumes| Seen {
                camera: camera(false, place(0.1 * i as f64, [0.0, far, 0.3]), EDGES[i]),
                volumes,
            };
            // Another one has come, and one is gone.
            let before = seen(0, vec![(ids[0], stood(0)), (ids[1], stood(1))]);
            let now = seen(1, vec![(ids[2], stood(2)), (ids[1], way * stood(1)), (ids[0], way * stood(0))]);
            let map = before_from_now(&before, &now).unwrap();
            let [was, is] = [shown(&before.camera, point), shown(&now.camera, way.transform_point3(point))];
            assert!((map * is - was).length() < 1e-6, "{} {was}", map * is);
            // Not as one: what stands is found.
            let now = seen(1, vec![(ids[1], way * stood(1)), (ids[0], stood(0))]);
            let map = before_from_now(&before, &now).unwrap();
            let is = shown(&now.camera, point);
            assert!((map * is - was).length() < 1e-6, "{} {was}", map * is);
        }
    }
}
