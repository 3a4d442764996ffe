//! The passes that make a frame of a live view. Each is plain data: which images it takes, and what else it needs to know.
//! None knows of another, so that each can be recorded alone, and another can take its place.
//!
//! What of a frame is done in which order is said in one place, `LiveView::plan_frame`.

mod clear;
mod count;
mod denoise;
mod draw;
mod fade;
mod host_depth;
mod light;
mod picture;
mod read;
mod trace;
mod velocity;

use std::fmt::Debug;

use lumivox_shaders::Kernel;

pub use self::clear::ClearPass;
pub use self::count::CountPass;
pub use self::denoise::DenoisePass;
pub use self::draw::DrawPass;
pub use self::fade::FadePass;
pub use self::host_depth::HostDepthPass;
pub use self::light::{LightCellsPass, LightFill, LightPicturePass, LightResources, LightSmoothPass};
pub use self::picture::{PictureFilms, PicturePass, ShownFilm};
pub use self::read::ReadPass;
pub use self::trace::{PathSettings, Share, TracePass};
pub use self::velocity::VelocityPass;
use super::images::Image;
use crate::recording::{Recording, ResourceId, Step};

/// What a pass does with an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Access {
    /// It only reads it.
    Read,
    /// It reads it, and writes a part of it.
    Change,
    /// It makes it anew, whatever it was. In a frame no image is made twice, nor used before it is made.
    Make,
}

/// An image that a pass uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Use {
    /// Which one.
    pub image: Image,
    /// What for.
    pub access: Access,
}

impl Use {
    fn read(image: Image) -> Self {
        Self { image, access: Access::Read }
    }

    fn change(image: Image) -> Self {
        Self { image, access: Access::Change }
    }

    fn make(image: Image) -> Self {
        Self { image, access: Access::Make }
    }
}

/// A pass of a frame.
pub trait FramePass: Debug {
    /// Its name, among those of all kinds of passes.
    fn name(&self) -> &'static str;

    /// All images of the view that its steps bind. The host's own textures are none of them.
    fn uses(&self) -> Vec<Use>;

    /// Records its steps.
    fn record(&self, recording: &mut Recording);
}

/// One invocation for each pixel.
fn dispatch(
    kernel: Kernel,
    params: &impl bytemuck::NoUninit,
    resources: Vec<ResourceId>,
    size: [u32; 2],
    recording: &mut Recording,
) {
    let [x, y] = kernel.workgroup_size();
    recording.push(Step::Dispatch {
        kernel,
        uniforms: vec![bytemuck::bytes_of(params).to_vec()],
        resources,
        workgroups: [size[0].div_ceil(x), size[1].div_ceil(y)],
    });
}
