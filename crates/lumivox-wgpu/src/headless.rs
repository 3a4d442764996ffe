//! A whole image without a window: progress, cancel, and what was rendered so far.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use lumivox_core::{PerspectiveCamera, Scene};
use lumivox_renderer::recording::Kernel;
use lumivox_renderer::{
    CellSize, EnvironmentSampling, Film, Recording, RenderError, SceneCache, View, ViewKind, ViewSettings,
    VoxelStore,
};

use crate::error::{GpuError, HeadlessError};
use crate::gpu::Gpu;

/// What to render.
#[derive(Clone, Copy, Debug)]
pub struct RenderRequest {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples per pixel; the image is complete when it has them.
    pub samples: u32,
    /// The image is complete, too, when so much time has gone into it and every pixel has a sample.
    pub time: Option<Duration>,
    /// Chooses the random numbers.
    pub seed: u32,
    /// Whether the film also holds first-hit albedo and normal.
    pub guides: bool,
    /// How paths find the light.
    pub environment_sampling: EnvironmentSampling,
    /// Side of a majorant cell in voxels, where it is not up to [how dense](CellSize::ByDensity) a look is.
    pub cell_size: Option<usize>,
}

impl RenderRequest {
    /// An image of `samples` samples per pixel.
    pub fn new(width: u32, height: u32, samples: u32) -> Self {
        Self {
            width,
            height,
            samples,
            time: None,
            seed: 0,
            guides: false,
            environment_sampling: EnvironmentSampling::Auto,
            cell_size: None,
        }
    }
}

/// How far a render is.
#[derive(Clone, Copy, Debug)]
pub struct RenderProgress {
    /// Samples of the average pixel.
    pub samples: f64,
    /// Samples asked for.
    pub target: u32,
    /// Time since tracing began.
    pub elapsed: Duration,
    /// Time until the image is complete, by what it took so far.
    pub left: Duration,
    /// Relative noise at the last look (see [`Film::noise`]).
    pub noise: Option<f64>,
}

/// How a render ended.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// As asked for.
    Complete,
    /// The progress callback stopped it.
    Stopped,
    /// The GPU failed; the film is the last that came back.
    Failed(GpuError),
}

/// An image, finished or as far as it came.
#[derive(Debug)]
pub struct Rendered {
    /// The sums.
    pub film: Film,
    /// How it ended.
    pub outcome: Outcome,
    /// Time spent on uploads and majorants.
    pub prepare: Duration,
    /// Time spent tracing, read-backs left out.
    pub trace: Duration,
    /// Pixels that lack a path so long that it had not ended when the render was stopped, which makes them darker than
    /// they are. Only where a driver limits the turns of loops.
    pub unfinished: u32,
    /// Of each volume of the scene, voxels along an axis for one on the GPU: 1 but for those that it has no room for.
    pub reductions: Vec<u32>,
}

/// The time one submission may take: short enough for Ctrl-C and a shared desktop, long enough to keep the GPU busy.
const SUBMISSION: Duration = Duration::from_millis(120);

/// The first submission's pixel samples; later ones follow the speed measured.
const FIRST_SUBMISSION: u64 = 1 << 14;

/// Least time between two looks at the film while rendering: each brings back what survives a lost GPU.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// The time that paths under way may take to end once a render is stopped.
const FINISHING: Duration = Duration::from_secs(2);

/// Bytes of voxels that a device which has no room even for them cannot use.
const LEAST_VOXELS: u64 = 16 << 20;

/// Largest part of the time that looking may take.
const LOOK_SHARE: u32 = 20;

/// Renders a scene; `on_progress` is called a few times a second and may stop it.
///
/// # Errors
/// [`HeadlessError`] when nothing was rendered. A failure later is the [`Rendered::outcome`], with the film so far.
pub fn render(
    gpu: &mut Gpu,
    scene: &Scene,
    camera: &PerspectiveCamera,
    request: &RenderRequest,
    on_progress: &mut dyn FnMut(&RenderProgress) -> ControlFlow<()>,
) -> Result<Rendered, HeadlessError> {
    let sees = camera.vertical_fov > 0.0 && camera.vertical_fov < std::f64::consts::PI;
    if !sees || !camera.world_from_camera.is_finite() {
        return Err(RenderError::Camera.into());
    }
    let begin = Instant::now();
    let store = VoxelStore::new(gpu.executor.limits());
    let mut cache = another(&store, request);
    // While voxels are looked at and uploaded.
    let kernels = cache.kernels(scene, ViewKind::Still { guides: request.guides });
    gpu.executor.prepare(kernels.into_iter().filter(|kernel| *kernel != Kernel::Display));
    let mut recording = Recording::new();
    let mut views = loop {
        cache.update(scene, &mut recording)?;
        let views = windows(request, &cache, &mut recording)?;
        match gpu.executor.execute(&recording).and_then(|_| gpu.executor.wait()) {
            Ok(()) => break views,
            // What there is no room for comes reduced.
            Err(GpuError::OutOfMemory(_)) if store.bytes() > LEAST_VOXELS => {
                gpu.executor.discard(&recording);
                store.refused(&recording);
                recording = Recording::new();
                cache = another(&store, request);
            }
            Err(error) => {
                gpu.executor.discard(&recording);
                return Err(gpu.cause(error).into());
            }
        }
    };
    drop(recording);
    let factor = |volume| store.resolution(volume).map_or(1, |resolution| resolution.factor);
    let reductions = scene.volumes.iter().map(|instance| factor(&instance.volume)).collect();
    let prepare = begin.elapsed();

    let mut film = Film::new(request.width, request.height, request.guides);
    let mut tracing = Tracing {
        begin: Instant::now(),
        trace: Duration::ZERO,
        pixel_samples: 0,
        budget: FIRST_SUBMISSION,
        last_look: Instant::now(),
        look_took: Duration::ZERO,
        noise: None,
        stopped: None,
    };
    let run = tracing.run(gpu, &cache, &mut views, camera, request, &mut film, on_progress);
    let mut outcome = run.unwrap_or_else(|error| Outcome::Failed(gpu.cause(error)));
    let mut unfinished = 0;
    for view in &mut views {
        if !matches!(outcome, Outcome::Failed(_)) {
            match tracing.finish_paths(gpu, &cache, view, request, on_progress) {
                Ok(put_aside) => unfinished += put_aside,
                Err(error) => outcome = Outcome::Failed(gpu.cause(error)),
            }
        }
    }
    // Even after a failure: the device may still be there, only its memory full.
    if let Err(error) = read_film(gpu, &views, &mut film)
        && !matches!(outcome, Outcome::Failed(_))
    {
        outcome = Outcome::Failed(gpu.cause(error));
    }
    let mut recording = Recording::new();
    views.into_iter().for_each(|view| view.free(&mut recording));
    cache.free(&mut recording);
    store.free(&mut recording);
    // A device that is gone has freed everything already.
    let _ = gpu.executor.execute(&recording);
    Ok(Rendered { film, outcome, prepare, trace: tracing.trace, unfinished, reductions })
}

/// An empty cache for a request.
fn another(store: &VoxelStore, request: &RenderRequest) -> SceneCache {
    let mut cache = SceneCache::new(store);
    cache.set_environment_sampling(request.environment_sampling);
    cache.set_cell_size(request.cell_size.map_or(CellSize::ByDensity, CellSize::Of));
    cache
}

/// Views that together hold the image, each small enough for the device: bands of rows, and of columns where a row
/// alone is too long.
fn windows(
    request: &RenderRequest,
    cache: &SceneCache,
    recording: &mut Recording,
) -> Result<Vec<View>, HeadlessError> {
    let whole = ViewSettings {
        seed: request.seed,
        guides: request.guides,
        ..ViewSettings::new(request.width, request.height)
    };
    let pixels = cache.limits().max_storage_binding / whole.bytes_per_pixel(cache.limits());
    let width = u64::from(request.width.max(1)).min(pixels).max(1);
    let height = (pixels / width).clamp(1, u64::from(request.height.max(1)));
    let mut views = vec![];
    let (width, height) = (width as u32, height as u32);
    for y in (0..request.height.max(1)).step_by(height as usize) {
        for x in (0..request.width.max(1)).step_by(width as usize) {
            let size =
                [width.min(request.width.saturating_sub(x)), height.min(request.height.saturating_sub(y))];
            let settings = ViewSettings { window_origin: [x, y], window_size: size, ..whole };
            views.push(View::new(settings, cache, recording)?);
        }
    }
    Ok(views)
}

fn read_film(gpu: &mut Gpu, views: &[View], film: &mut Film) -> Result<(), GpuError> {
    for view in views {
        let mut recording = Recording::new();
        view.record_read_film(&mut recording);
        for read_back in gpu.executor.execute(&recording)? {
            let bytes = read_back.wait()?;
            film.insert(view.settings().window_origin, view.settings().window_size, &bytes);
        }
    }
    gpu.check()
}

struct Tracing {
    begin: Instant,
    trace: Duration,
    pixel_samples: u64,
    budget: u64,
    last_look: Instant,
    look_took: Duration,
    noise: Option<f64>,
    /// When the callback said so.
    stopped: Option<Instant>,
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
        film: &mut Film,
        on_progress: &mut dyn FnMut(&RenderProgress) -> ControlFlow<()>,
    ) -> Result<Outcome, GpuError> {
        loop {
            let submitted = Instant::now();
            let mut recording = Recording::new();
            // The window that is furthest behind is next, so that an unfinished image is evenly unfinished.
            let behind = views.iter_mut().min_by_key(|v| v.samples()).expect("an image has a window");
            let samples = behind.samples();
            let recorded = behind.record_samples(cache, camera, request.samples, self.budget, &mut recording);
            if recorded == 0 {
                return Ok(Outcome::Complete);
            }
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
                self.finish_paths(gpu, cache, behind, request, on_progress)?;
            }
            self.tell(request, on_progress);
            if self.stopped.is_some() {
                return Ok(Outcome::Stopped);
            }
            // An image of which parts were never traced is none: the first sample is always finished.
            let begun = views.iter().all(|v| v.samples() > 0);
            if begun && request.time.is_some_and(|limit| self.begin.elapsed() >= limit) {
                return Ok(Outcome::Complete);
            }
            if self.last_look.elapsed() >= LOOK_EVERY.max(self.look_took * LOOK_SHARE) {
                let looked = Instant::now();
                read_film(gpu, views, film)?;
                self.noise = film.noise();
                self.look_took = looked.elapsed();
                self.last_look = Instant::now();
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
        view: &mut View,
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
            // One after the other, so that they can be stopped in between.
            for step in recording.steps {
                let begin = Instant::now();
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
            self.stopped.get_or_insert_with(Instant::now);
        }
    }

    /// Aims the next submission at its time; at most doubles, for the first ones tell little.
    fn adapt(&mut self, recorded: u64, took: Duration) {
        let per_second = recorded as f64 / took.as_secs_f64().max(1e-6);
        let wanted = (per_second * SUBMISSION.as_secs_f64()) as u64;
        self.budget = wanted.clamp(1024, self.budget.max(recorded) * 2);
    }

    fn progress(&self, request: &RenderRequest) -> RenderProgress {
        let pixels = f64::from(request.width) * f64::from(request.height);
        let samples = self.pixel_samples as f64 / pixels;
        let elapsed = self.begin.elapsed();
        let by_samples = elapsed.as_secs_f64() / samples.max(1e-9) * (f64::from(request.samples) - samples);
        let by_time = request.time.map_or(f64::INFINITY, |t| t.saturating_sub(elapsed).as_secs_f64());
        RenderProgress {
            samples,
            target: request.samples,
            elapsed,
            left: Duration::from_secs_f64(by_samples.clamp(0.0, 1e9).min(by_time)),
            noise: self.noise,
        }
    }
}
