//! Replays the renderer's recordings on wgpu: headless renders, and any Rust host that has a wgpu device.
//!
//! [`Executor`] is the executor, for a device that the host owns ([`WANTED_FEATURES`] and [`wanted_limits`] say what that
//! should have); [`Gpu`] finds and opens one where nobody does; [`render`] makes a whole image with progress, cancel and
//! what was rendered so far.
//!
//! A host with a frame to keep calls [`Executor::submit`], which waits for nothing: a [`Submission`] tells bytes, faults
//! and the [time on the GPU](GpuTime) when they are there. One that submits its frames itself has a recording put among
//! its own commands by [`Executor::replay_into`].

mod commands;
mod error;
mod executor;
mod filtering;
mod gpu;
mod headless;
mod moving;
mod pipelines;
mod still;
mod submission;
mod textures;
mod timing;

pub use error::{GpuError, HeadlessError};
pub use executor::Executor;
pub use filtering::FilterTest;
pub use gpu::{Gpu, GpuDescription, WANTED_FEATURES, wanted_limits};
pub use headless::{HeadlessRenderer, Outcome, RenderProgress, RenderRequest, Rendered, render};
pub use moving::MovingView;
pub use still::Still;
pub use submission::{ReadBack, Submission};
pub use textures::TextureMaker;
pub use timing::GpuTime;
pub use wgpu;

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
