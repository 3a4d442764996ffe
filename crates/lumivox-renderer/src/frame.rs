//! Scene and camera as the kernels want them.

use lumivox_core::glam::DVec3;
use lumivox_core::{Camera, Projection};
use lumivox_shaders::layout::Frame;

use crate::scene_cache::SceneCache;

/// The part of a frame's parameters that scene and camera decide.
pub(crate) fn of(cache: &SceneCache, camera: &Camera) -> Frame {
    let (Projection::Perspective { tangents: edges } | Projection::Orthographic { extents: edges }) =
        camera.projection;
    let [left, right, bottom, top] = edges;
    let orthographic = matches!(camera.projection, Projection::Orthographic { .. });
    let half = DVec3::new((right - left) / 2.0, (top - bottom) / 2.0, 0.0);
    let centre = DVec3::new((right + left) / 2.0, (top + bottom) / 2.0, 0.0);
    // The centre of the image moves the origin of parallel rays, and the direction of others.
    let (origin, forward) =
        if orthographic { (centre, DVec3::NEG_Z) } else { (DVec3::ZERO, centre + DVec3::NEG_Z) };
    let axis = |v: DVec3| camera.world_from_camera.transform_vector3(v).as_vec3().to_array();
    let position = camera.world_from_camera.transform_point3(origin);
    let mut frame = Frame {
        camera_position: (position - cache.origin()).as_vec3().to_array(),
        camera_right: axis(DVec3::X * half.x),
        camera_up: axis(DVec3::Y * half.y),
        camera_forward: axis(forward),
        view_axis: axis(DVec3::NEG_Z),
        orthographic: u32::from(orthographic),
        ..Default::default()
    };
    cache.fill_frame(&mut frame);
    frame
}
