//! The way to the GPU: everything above this file is plain data, everything below is an executor.

use std::time::Duration;

use lumivox_core::{CancelToken, PerspectiveCamera, Scene};
use lumivox_renderer::DisplaySettings;

use crate::{
    args::Size,
    exit::{Exit, Failure},
    output::Picture,
    progress::TracingStatus,
};

/// What to trace.
#[derive(Debug)]
pub struct Request {
    /// Volumes and light.
    pub scene: Scene,
    /// From where.
    pub camera: PerspectiveCamera,
    /// Pixels.
    pub size: Size,
    /// When to stop.
    pub stop: Stop,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Radiance to pixels.
    pub display: DisplaySettings,
    /// A part of the name of the GPU to take.
    pub gpu: Option<String>,
}

/// When tracing ends.
#[derive(Clone, Copy, Debug)]
pub enum Stop {
    /// After so many paths per pixel.
    Samples(u32),
    /// After so long, but not before the first sample.
    Time(Duration),
}

/// What came out; possibly fewer samples than asked for, if it was cancelled.
#[derive(Debug)]
pub struct Traced {
    /// The picture so far.
    pub picture: Picture,
    /// Samples per pixel in it.
    pub samples: u32,
}

/// A GPU, or a CPU that acts as one.
#[derive(Clone, Debug)]
pub struct Adapter {
    /// Its maker's name for it.
    pub name: String,
    /// Kind, API and driver, for people.
    pub detail: String,
    /// Whether it is a CPU.
    pub software: bool,
}

/// What can render here, the one taken by default first.
pub fn adapters() -> Result<Vec<Adapter>, Failure> {
    Err(not_built())
}

/// Traces until done or cancelled, and keeps what there is in both cases. `say` gets lines for the user, such as the
/// name of the GPU.
///
/// # Errors
/// [`Exit::Gpu`] when there is no usable GPU, or it was lost before the first sample.
pub fn trace(
    request: &Request,
    say: &dyn Fn(&str),
    progress: &mut dyn FnMut(TracingStatus),
    cancel: &CancelToken,
) -> Result<Traced, Failure> {
    let _ = (request, say, progress, cancel);
    Err(not_built())
}

fn not_built() -> Failure {
    Failure::new(Exit::Gpu, "this build has no GPU executor")
}
