//! How far what is seen has moved, into the host's own velocity.

use lumivox_core::glam::DMat4;
use lumivox_shaders::{Kernel, layout};

use super::{FramePass, Use};
use crate::live::images::Image;
use crate::live::{HostDepth, HostVelocity};
use crate::recording::{Recording, Step};

/// Draws how far what is seen has moved since the frame before onto a texture of the host's that is as large. What no volume hides stays
/// as the host has it.
#[derive(Clone, Copy, Debug)]
pub struct VelocityPass {
    /// The picture's depth.
    pub depth: Image,
    /// How the host writes depth.
    pub host_depth: HostDepth,
    /// Where in the image of the frame before a point of this one was: from `(x d, y d, d, 1)` at depth `d` to the same; of parallel
    /// rays from `(x, y, d, 1)`. x and y are in \[-1, 1\], y downwards.
    pub before_from_now: DMat4,
    /// Whether rays are parallel.
    pub is_parallel: bool,
    /// The host's texture, and its numbers.
    pub target: HostVelocity,
}

impl FramePass for VelocityPass {
    fn name(&self) -> &'static str {
        "velocity"
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::read(self.depth)]
    }

    fn record(&self, recording: &mut Recording) {
        let params = layout::VelocityParams {
            before_from_now: self.before_from_now.to_cols_array_2d().map(|column| column.map(|x| x as f32)),
            view_depth_from_ndc: self.host_depth.view_depth_from_ndc.map(|x| x as f32),
            scale: self.target.scale.map(|x| x as f32),
            picture_size: self.depth.size,
            camera_parallel: u32::from(self.is_parallel),
            ..Default::default()
        };
        recording.push(Step::Draw {
            kernel: Kernel::CompositeVelocity,
            uniforms: vec![bytemuck::bytes_of(&params).to_vec()],
            resources: vec![self.depth.buffer],
            target: self.target.texture,
        });
    }
}
