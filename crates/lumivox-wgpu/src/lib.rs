//! Replays the renderer's recordings on wgpu: headless renders, and any Rust host that has a wgpu device.
//!
//! [`Executor`] is the executor, for a device that the host owns; [`Gpu`] finds and opens one where nobody does;
//! [`render`] makes a whole image with progress, cancel and what was rendered so far.

mod error;
mod executor;
mod gpu;
mod headless;
mod pipelines;
mod textures;

pub use error::{GpuError, HeadlessError};
pub use executor::{Executor, ReadBack};
pub use gpu::{Gpu, GpuDescription};
pub use headless::{Outcome, RenderProgress, RenderRequest, Rendered, render};
pub use textures::TextureMaker;
pub use wgpu;
