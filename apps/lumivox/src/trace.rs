//! The way to the GPU: everything above this file is plain data, everything below is `lumivox-wgpu`.

use std::{
    ops::{ControlFlow, Range},
    time::{Duration, Instant},
};

use lumivox_core::{CancelToken, PerspectiveCamera, Scene};
use lumivox_renderer::{DisplaySettings, Film};
use lumivox_wgpu::{Gpu, GpuDescription, GpuError, HeadlessError, Outcome, RenderRequest};

use crate::{
    exit::{Exit, Failure},
    output::Picture,
    progress::{Reporter, human_duration},
};

/// How many times the time limit a first sample of every pixel may take, and a little more.
const LATE: u32 = 2;
const GRACE: Duration = Duration::from_secs(1);

/// What came out, finished or as far as it came.
#[derive(Debug)]
pub struct Traced {
    film: Film,
    /// Samples of the pixel that has the fewest.
    pub samples: u32,
    /// The fraction of the pixels that have any.
    pub begun: f64,
    /// Whether its time was over before it had all samples.
    pub time_up: bool,
    /// Why it is not finished, if it is not.
    pub cut_short: Option<Failure>,
}

impl Traced {
    /// What [`Film::noise`] says.
    pub fn noise(&self) -> Option<f64> {
        self.film.noise()
    }

    /// `64 samples`; of a picture of which parts are missing, `12% of the picture`.
    pub fn reached(&self) -> String {
        match self.samples {
            0 => format!("{:.0}% of the picture", (self.begun * 100.0).clamp(1.0, 99.0)),
            1 => "1 sample".into(),
            samples => format!("{samples} samples"),
        }
    }

    /// Takes the noise off, for a little bias; says whether there was time to.
    pub fn denoise(&mut self, has_time: &(dyn Fn() -> bool + Sync)) -> bool {
        let Some(denoised) = self.film.denoised_while(has_time) else { return false };
        self.film = denoised;
        true
    }

    /// The picture so far.
    pub fn picture(&self, display: &DisplaySettings, scene: &Scene, camera: &PerspectiveCamera) -> Picture {
        let [width, height] = self.film.size();
        let rgba = display.pixels(&self.film, &scene.environment, camera).into_flattened();
        Picture { width, height, rgba }
    }
}

/// Opens the GPU whose name contains `name`, or the fastest kind.
///
/// # Errors
/// [`Exit::Gpu`] when there is none that can be used.
pub fn open(name: Option<&str>) -> Result<Gpu, Failure> {
    Gpu::open(name).map_err(gpu_failure)
}

/// Traces until done or cancelled, and keeps what there is in both cases.
///
/// # Errors
/// [`Exit::Gpu`] when the GPU was lost before anything came back; [`Exit::Failure`] when the scene does not fit it;
/// [`Exit::Interrupted`] when nothing was rendered yet.
pub fn trace(
    scene: &Scene,
    camera: &PerspectiveCamera,
    request: &RenderRequest,
    gpu: &mut Gpu,
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<Traced, Failure> {
    reporter.say(&format!("tracing on {}", describe(&gpu.description)));
    let mut line = reporter.tracing();
    // A first sample of every pixel may take longer than there is time, but not for ever.
    let mut begin = None;
    let mut is_late = false;
    let rendered = lumivox_wgpu::render(gpu, scene, camera, request, &mut |progress| {
        line.update(progress);
        let elapsed = begin.get_or_insert_with(Instant::now).elapsed();
        is_late |= request.time.is_some_and(|limit| elapsed > LATE * limit + GRACE);
        if is_late || cancel.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .map_err(|error| match error {
        HeadlessError::Gpu(error) => gpu_failure(error),
        error => Failure::other(error.to_string()),
    })?;
    line.finish();

    let samples = rendered.film.min_samples();
    let time_up = matches!(rendered.outcome, Outcome::TimeUp);
    let cut_short = match rendered.outcome {
        Outcome::Complete | Outcome::TimeUp => None,
        Outcome::Stopped if is_late && samples > 0 => None,
        Outcome::Stopped if is_late && !cancel.is_cancelled() => Some(Failure::other(
            "The time was over before every pixel had a sample. A smaller --size, fewer --bounces, a lower --density or more \
             --time help.",
        )),
        Outcome::Stopped => Some(Failure::new(Exit::Interrupted, "Stopped early.")),
        Outcome::Failed(error) => Some(gpu_failure(error)),
    };
    let begun = begun(&rendered.film);
    match cut_short {
        Some(failure) if begun == 0.0 => {
            Err(Failure { message: format!("{} Nothing was rendered yet.", failure.message), ..failure })
        }
        cut_short => {
            let (film, trace) = (rendered.film, rendered.trace);
            let traced = Traced { film, samples, begun, time_up, cut_short };
            reporter.say(&summary(&traced, rendered.prepare, trace));
            if samples == 1 && request.time.is_some_and(|limit| trace > limit + Duration::from_millis(500)) {
                reporter.say(&format!("note: needed {} for one sample per pixel", human_duration(trace)));
            }
            if rendered.unfinished > 0 {
                let pixels = rendered.unfinished;
                reporter.say(&format!(
                    "note: {pixels} pixels are darker than they should be: their longest paths had not ended"
                ));
            }
            let coarsest = rendered.reductions.into_iter().max().unwrap_or(1);
            if coarsest > 1 {
                reporter.say(&format!(
                    "note: the GPU has no room for all voxels: the scan was rendered at 1/{coarsest} of its resolution"
                ));
            }
            if begun == 1.0 && pixels(&traced.film).all(|pixel| traced.film.alpha(pixel) == 0.0) {
                reporter.say("note: no ray met the scan: check --eye, --clip, --clip-shape, --label, the transfer function");
            }
            Ok(traced)
        }
    }
}

/// What a cluster traced.
///
/// # Errors
/// [`Exit::Interrupted`] when it was stopped before anything came back.
pub fn traced_elsewhere(film: Film, complete: bool) -> Result<Traced, Failure> {
    let (samples, begun) = (film.min_samples(), begun(&film));
    let cut_short = (!complete).then(|| Failure::new(Exit::Interrupted, "Stopped early."));
    match cut_short {
        Some(failure) if begun == 0.0 => {
            Err(Failure { message: format!("{} Nothing was rendered yet.", failure.message), ..failure })
        }
        cut_short => Ok(Traced { film, samples, begun, time_up: false, cut_short }),
    }
}

fn pixels(film: &Film) -> Range<usize> {
    let [width, height] = film.size();
    0..width as usize * height as usize
}

fn begun(film: &Film) -> f64 {
    let begun = pixels(film).filter(|&pixel| film.samples(pixel) > 0.0).count();
    begun as f64 / pixels(film).len().max(1) as f64
}

fn summary(traced: &Traced, prepare: Duration, trace: Duration) -> String {
    let [prepare, trace] = [prepare, trace].map(|duration| duration.as_secs_f64());
    let mut text = format!("prepared in {prepare:.2} s, {} in {trace:.2} s", traced.reached());
    if traced.samples > 0 {
        text += &format!(": {:.2} ms per sample", trace * 1e3 / f64::from(traced.samples));
    }
    let film = &traced.film;
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
