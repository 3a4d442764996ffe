//! One image under way: its views, and how they fill.

use std::ops::ControlFlow;
use std::time::Duration;

use lumivox_core::PerspectiveCamera;
use lumivox_core::host::Moment;
use lumivox_renderer::{Film, Recording, SceneCache, View};

use crate::error::GpuError;
use crate::gpu::Gpu;
use crate::headless::{HeadlessRenderer, Outcome, RenderProgress, RenderRequest, Rendered};

/// The time one submission may take: short enough for Ctrl-C and a shared desktop, long enough to keep the GPU busy.
const SUBMISSION: Duration = Duration::from_millis(120);

/// The first submission's pixel samples; later ones follow the speed measured.
const FIRST_SUBMISSION: u64 = 1 << 14;

/// Least time between two looks at the film while rendering: each brings back what survives a lost GPU.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// The time that paths under way may take to end once a render is stopped.
const FINISHING: Duration = Duration::from_secs(2);

/// Largest part of the time that looking may take.
const LOOK_SHARE: u32 = 20;

/// An image that is rendered little by little; [`HeadlessRenderer::begin`] begins it.
#[derive(Debug)]
pub struct Still {
    views: Vec<View>,
    camera: PerspectiveCamera,
    request: RenderRequest,
    film: Film,
    tracing: Tracing,
    outcome: Outcome,
    unfinished: u32,
    reductions: Vec<u32>,
    uploaded: u64,
    prepare: Duration,
}

impl Still {
    pub(crate) fn new(
        views: Vec<View>,
        camera: PerspectiveCamera,
        request: RenderRequest,
        reductions: Vec<u32>,
        uploaded: u64,
        prepare: Duration,
    ) -> Self {
        let [_, [width, height]] = request.part();
        let tracing = Tracing {
            begin: Moment::now(),
            trace: Duration::ZERO,
            pixel_samples: 0,
            budget: FIRST_SUBMISSION,
            last_look: Moment::now(),
            look_took: Duration::ZERO,
            noise: None,
            stopped: None,
            is_unread: vec![false; views.len()],
        };
        Self {
            film: Film::new(width, height, request.guides),
            views,
            camera,
            request,
            tracing,
            outcome: Outcome::Stopped,
            unfinished: 0,
            reductions,
            uploaded,
            prepare,
        }
    }

    /// Traces until every pixel has the samples up to the `target`-th, or the request's time is over, and reads the film;
    /// `on_progress` is called a few times a second and may stop it. `renderer` is the one that began it, which must not have
    /// begun another image of another scene since.
    pub fn trace_to(
        &mut self,
        gpu: &mut Gpu,
        renderer: &HeadlessRenderer,
        target: u32,
        on_progress: &mut dyn FnMut(&RenderProgress) -> ControlFlow<()>,
    ) -> &Outcome {
        let Self { views, camera, request, film, tracing, .. } = self;
        let cache = &renderer.cache;
        let target = target.min(request.samples);
        tracing.stopped = None;
        let run = tracing.run(gpu, cache, views, camera, request, target, film, on_progress);
        let mut outcome = run.unwrap_or_else(|error| Outcome::Failed(gpu.cause(error)));
        self.unfinished = 0;
        for (index, view) in views.iter_mut().enumerate() {
            if !matches!(outcome, Outcome::Failed(_)) {
                match tracing.finish_paths(gpu, cache, (index, view), request, on_progress) {
                    Ok(put_aside) => self.unfinished += put_aside,
                    Err(error) => outcome = Outcome::Failed(gpu.cause(error)),
                }
            }
        }
        if self.unfinished > 0 && matches!(outcome, Outcome::Complete) {
            // All samples were begun, and somebody stopped it before their paths had ended.
            outcome = Outcome::Stopped;
        }
        // Even after a failure: the device may still be there, only its memory full.
        if let Err(error) = tracing.read_film(gpu, views, request, film, &mut |_| ())
            && !matches!(outcome, Outcome::Failed(_))
        {
            outcome = Outcome::Failed(gpu.cause(error));
        }
        self.outcome = outcome;
        &self.outcome
    }

    /// The sums so far.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// See [`Rendered::unfinished`].
    pub fn unfinished(&self) -> u32 {
        self.unfinished
    }

    /// See [`Rendered::reductions`].
    pub fn reductions(&self) -> &[u32] {
        &self.reductions
    }

    /// Time spent tracing, read-backs left out.
    pub fn trace_time(&self) -> Duration {
        self.tracing.trace
    }

    /// Frees what the image has on the GPU, and gives what was rendered.
    pub fn end(self, gpu: &mut Gpu) -> Rendered {
        let mut recording = Recording::new();
        self.views.into_iter().for_each(|view| view.free(&mut recording));
        // A device that is gone has freed everything already.
        let _ = gpu.executor.execute(&recording);
        Rendered {
            film: self.film,
            outcome: self.outcome,
            prepare: self.prepare,
            trace: self.tracing.trace,
            unfinished: self.unfinished,
            reductions: self.reductions,
            uploaded: self.uploaded,
        }
    }
}

#[derive(Debug)]
struct Tracing {
    begin: Moment,
    trace: Duration,
    pixel_samples: u64,
    budget: u64,
    last_look: Moment,
    look_took: Duration,
    noise: Option<f64>,
    /// When the callback said so.
    stopped: Option<Moment>,
    /// Which windows have something that the film does not have yet.
    is_unread: Vec<bool>,
}

impl Tracing {
    #[expect(clippy::too_many_arguments, reason = "the loop's whole state, used once")]
    fn run(
        &mut self,
        gpu: &mut Gpu,
        cache: &SceneCache,
        views: &mut [View],
        camera: &PerspectiveCamera,
        request: &RenderRequest,
        target: u32,
        film: &mut Film,
        on_progress: &mut dyn FnMut(&RenderProgress) -> ControlFlow<()>,
    ) -> Result<Outcome, GpuError> {
        loop {
            let submitted = Moment::now();
            let mut recording = Recording::new();
            // The window that is furthest behind is next, so that an unfinished image is evenly unfinished.
            let (index, behind) = (views.iter_mut().enumerate())
                .min_by_key(|(_, view)| view.samples())
                .expect("an image has a window");
            let samples = behind.samples();
            let recorded = behind.record_samples(cache, camera, target, self.budget, &mut recording);
            if recorded == 0 {
                return Ok(Outcome::Complete);
            }
            self.is_unread[index] = true;
            gpu.executor.execute(&recording)?;
            gpu.executor.wait()?;
            gpu.check()?;
            let took = submitted.elapsed();
            self.trace += took;
            self.pixel_samples += recorded;
            self.adapt(recorded, took);

            // Else the film would fall behind where paths are put aside, and to stop would take as long as to catch up.
            let is_behind = cache.limits().loop_turns.is_some() && behind.samples() > samples;
            if is_behind {
                self.finish_paths(gpu, cache, (index, behind), request, on_progress)?;
            }
            self.tell(request, on_progress);
            if self.stopped.is_some() {
                return Ok(Outcome::Stopped);
            }
            // An image of which parts were never traced is none: the first sample is always finished.
            let begun = views.iter().all(|v| v.samples() > request.first_sample);
            if begun && request.time.is_some_and(|limit| self.begin.elapsed() >= limit) {
                let whole = views.iter().all(|view| view.samples() >= target);
                return Ok(if whole { Outcome::Complete } else { Outcome::TimeUp });
            }
            if self.last_look.elapsed() >= LOOK_EVERY.max(self.look_took * LOOK_SHARE) {
                let looked = Moment::now();
                // Who stops it meanwhile waits for no look: the film is read at the end.
                self.read_film(gpu, views, request, film, &mut |it| it.tell(request, on_progress))?;
                self.noise = film.noise();
                self.look_took = looked.elapsed();
                self.last_look = Moment::now();
            }
        }
    }

    /// Has what was recorded of a view counted, and what the film lacks of it traced: paths that take many dispatches
    /// are followed to their ends, for without the long ones an image would be too dark. Returns how many were not, for
    /// who stopped the render waits no longer.
    fn finish_paths(
        &mut self,
        gpu: &mut Gpu,
        cache: &SceneCache,
        (index, view): (usize, &mut View),
        request: &RenderRequest,
        on_progress: &mut dyn FnMut(&RenderProgress) -> ControlFlow<()>,
    ) -> Result<u32, GpuError> {
        loop {
            let mut recording = Recording::new();
            view.record_count(&mut recording);
            let mut put_aside = 0;
            for read_back in gpu.executor.execute(&recording)? {
                let count = view.counted(&read_back.wait()?).map_err(GpuError::Samples)?;
                put_aside = count.aside + count.starved;
            }
            let mut recording = Recording::new();
            if self.is_late() || !view.record_missing(cache, &mut recording) {
                return Ok(put_aside);
            }
            self.is_unread[index] = true;
            // One after the other, so that they can be stopped in between.
            for step in recording.steps {
                let begin = Moment::now();
                let executed = gpu.executor.execute(&Recording { steps: vec![step] });
                let waited = executed.and_then(|_| gpu.executor.wait()).and_then(|()| gpu.check());
                self.trace += begin.elapsed();
                waited?;
                self.tell(request, on_progress);
                if self.is_late() {
                    break;
                }
            }
        }
    }

    /// Brings what windows have into the film; `tell` is called between them, and may stop the render.
    fn read_film(
        &mut self,
        gpu: &mut Gpu,
        views: &[View],
        request: &RenderRequest,
        film: &mut Film,
        tell: &mut dyn FnMut(&mut Self),
    ) -> Result<(), GpuError> {
        let [origin, _] = request.part();
        let was_stopped = self.stopped.is_some();
        for (index, view) in views.iter().enumerate() {
            if !self.is_unread[index] {
                continue;
            }
            let mut recording = Recording::new();
            view.record_read_film(&mut recording);
            let settings = view.settings();
            let at = [0, 1].map(|axis| settings.window_origin[axis] - origin[axis]);
            for read_back in gpu.executor.execute(&recording)? {
                let bytes = read_back.wait()?;
                film.insert_samples(at, settings.window_size, &bytes, request.first_sample);
            }
            self.is_unread[index] = false;
            tell(self);
            if self.stopped.is_some() && !was_stopped {
                break;
            }
        }
        gpu.check()
    }

    fn is_late(&self) -> bool {
        self.stopped.is_some_and(|at| at.elapsed() >= FINISHING)
    }

    /// Tells how far the render is, and notes when it shall end.
    fn tell(
        &mut self,
        request: &RenderRequest,
        on_progress: &mut dyn FnMut(&RenderProgress) -> ControlFlow<()>,
    ) {
        if on_progress(&self.progress(request)).is_break() {
            self.stopped.get_or_insert_with(Moment::now);
        }
    }

    /// Aims the next submission at its time; at most doubles, for the first ones tell little.
    fn adapt(&mut self, recorded: u64, took: Duration) {
        let per_second = recorded as f64 / took.as_secs_f64().max(1e-6);
        let wanted = (per_second * SUBMISSION.as_secs_f64()) as u64;
        self.budget = wanted.clamp(1024, self.budget.max(recorded) * 2);
    }

    fn progress(&self, request: &RenderRequest) -> RenderProgress {
        let [_, [width, height]] = request.part();
        let pixels = f64::from(width) * f64::from(height);
        let samples = self.pixel_samples as f64 / pixels;
        let target = request.samples.saturating_sub(request.first_sample);
        let elapsed = self.begin.elapsed();
        let by_samples = elapsed.as_secs_f64() / samples.max(1e-9) * (f64::from(target) - samples);
        let by_time = request.time.map_or(f64::INFINITY, |t| t.saturating_sub(elapsed).as_secs_f64());
        RenderProgress {
            samples,
            target,
            elapsed,
            left: Duration::from_secs_f64(by_samples.clamp(0.0, 1e9).min(by_time)),
            noise: self.noise,
        }
    }
}
