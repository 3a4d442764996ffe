//! How far what a view shows moves from frame to frame, for hosts that want to know.

use lumivox_core::Camera;
use lumivox_core::glam::DMat4;

use super::passes::VelocityPass;
use super::reprojection::{self, Seen};
use super::{HostFrame, LiveView};
use crate::scene_cache::SceneCache;

impl LiveView {
    /// What tells it, in a frame in which the host lends a texture for that; `before` is what the frame before showed.
    pub(super) fn velocity(
        &mut self,
        before: Option<Seen>,
        host: &HostFrame,
        camera: &Camera,
        cache: &SceneCache,
    ) -> Option<VelocityPass> {
        let (Some(target), Some(host_depth)) = (host.velocity, host.depth) else {
            return None;
        };
        let now = Seen { camera: *camera, volumes: cache.places() };
        let before_from_now = match &before {
            Some(before) => reprojection::before_from_now(before, &now),
            // It stands still until there is a frame before.
            None => Some(DMat4::IDENTITY),
        };
        self.seen = Some(now);
        Some(VelocityPass {
            depth: self.picture.depth,
            host_depth,
            before_from_now: before_from_now?,
            is_parallel: reprojection::is_parallel(camera),
            target,
        })
    }
}
