//! The picture over the host's own.

use lumivox_shaders::{Kernel, layout};

use super::{FramePass, Use};
use crate::live::images::{Image, PixelFormat};
use crate::recording::{Recording, ResourceId, Step};

/// Draws an image of the picture onto a texture of the host's that is as large.
#[derive(Clone, Copy, Debug)]
pub struct DrawPass {
    /// One of four floats is blended over a colour, one of a float written into a depth.
    pub image: Image,
    /// The host's texture.
    pub target: ResourceId,
}

impl FramePass for DrawPass {
    fn name(&self) -> &'static str {
        "draw"
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::read(self.image)]
    }

    fn record(&self, recording: &mut Recording) {
        let kernel = match self.image.format {
            PixelFormat::FourFloats => Kernel::CompositeColor,
            PixelFormat::Float => Kernel::CompositeDepth,
        };
        let params = layout::CompositeParams { width: self.image.size[0], ..Default::default() };
        let uniforms = vec![bytemuck::bytes_of(&params).to_vec()];
        let resources = vec![self.image.buffer];
        recording.push(Step::Draw { kernel, uniforms, resources, target: self.target });
    }
}
