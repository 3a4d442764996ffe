//! The way to the GPU: everything above this file is plain data, everything below is `lumivox-wgpu`.

use std::{ops::ControlFlow, time::Duration};

use lumivox_core::{CancelToken, PerspectiveCamera, Scene};
use lumivox_renderer::{DisplaySettings, Film};
use lumivox_wgpu::{Gpu, GpuDescription, GpuError, HeadlessError, Outcome, RenderRequest};

use crate::{
    exit::{Exit, Failure},
    output::Picture,
    progress::Reporter,
};

/// What came out, finished or as far as it came.
#[derive(Debug)]
pub struct Traced {
    film: Film,
    /// Samples of the pixel that has the fewest.
    pub samples: u32,
    /// Why it is not finished, if it is not.
    pub cut_short: Option<Failure>,
}

impl Traced {
    /// Takes the noise off, for a little bias.
    pub fn denoise(&mut self) {
        self.film = self.film.denoised();
    }

    /// The picture so far.
    pub fn picture(&self, display: &DisplaySettings, scene: &Scene, camera: &PerspectiveCamera) -> Picture {
        let [width, height] = self.film.size();
        let rgba = display.pixels(&self.film, &scene.environment, camera).into_flattened();
        Picture { width, height, rgba }
    }
}

/// Traces until done or cancelled, and keeps what there is in both cases.
///
/// # Errors
/// [`Exit::Gpu`] when there is no usable GPU, or it was lost before anything came back; [`Exit::Failure`] when the
/// scene does not fit it; [`Exit::Interrupted`] when nothing was rendered yet.
pub fn trace(
    scene: &Scene,
    camera: &PerspectiveCamera,
    request: &RenderRequest,
    gpu: Option<&str>,
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<Traced, Failure> {
    let mut gpu = Gpu::open(gpu).map_err(gpu_failure)?;
    reporter.say(&format!("tracing on {}", describe(&gpu.description)));
    let mut line = reporter.tracing();
    let rendered = lumivox_wgpu::render(&mut gpu, scene, camera, request, &mut |progress| {
        line.update(progress);
        if cancel.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .map_err(|error| match error {
        HeadlessError::Gpu(error) => gpu_failure(error),
        error => Failure::other(error.to_string()),
    })?;
    line.finish();

    let samples = rendered.film.min_samples();
    let cut_short = match rendered.outcome {
        Outcome::Complete => None,
        Outcome::Stopped => Some(Failure::new(Exit::Interrupted, "Stopped early.")),
        Outcome::Failed(error) => Some(gpu_failure(error)),
    };
    match cut_short {
        Some(failure) if is_blank(&rendered.film) => {
            Err(Failure { message: format!("{} Nothing was rendered yet.", failure.message), ..failure })
        }
        cut_short => {
            reporter.say(&summary(&rendered.film, samples, rendered.prepare, rendered.trace));
            Ok(Traced { film: rendered.film, samples, cut_short })
        }
    }
}

fn is_blank(film: &Film) -> bool {
    let [width, height] = film.size();
    (0..width as usize * height as usize).all(|pixel| film.samples(pixel) == 0.0)
}

fn summary(film: &Film, samples: u32, prepare: Duration, trace: Duration) -> String {
    let mut text = format!(
        "prepared in {:.2} s, {samples} samples in {:.2} s: {:.2} ms per sample",
        prepare.as_secs_f64(),
        trace.as_secs_f64(),
        trace.as_secs_f64() * 1e3 / f64::from(samples.max(1)),
    );
    if let Some(noise) = film.noise() {
        text += &format!(", noise {:.1}%", noise * 100.0);
    }
    text
}

/// `NVIDIA H200 (Vulkan, 580.1)`.
pub fn describe(gpu: &GpuDescription) -> String {
    let kind = if gpu.software { ", software" } else { "" };
    format!("{} ({}, {}{kind})", gpu.name, gpu.backend, gpu.driver)
}

fn gpu_failure(error: GpuError) -> Failure {
    let hint = match error {
        GpuError::NoAdapter | GpuError::Unsuitable { .. } => "\n'lumivox doctor' says what to install.",
        GpuError::Lost(_) => "\nTry a smaller --size or fewer --bounces.",
        _ => "",
    };
    Failure::new(Exit::Gpu, format!("{error}{hint}"))
}
