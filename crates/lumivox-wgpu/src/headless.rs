//! A whole image without a window: progress, cancel, and what was rendered so far.

use std::num::NonZeroU32;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use lumivox_core::host::Moment;
use lumivox_core::{Filter, PerspectiveCamera, Scene, Volume, VolumeInstance};
use lumivox_renderer::recording::{Kernel, Step};
use lumivox_renderer::{
    CellSize, EnvironmentSampling, Film, NoiseEnd, Recording, RenderError, SceneCache, View, ViewKind,
    ViewSettings, VoxelStore,
};

use crate::error::{GpuError, HeadlessError};
use crate::gpu::Gpu;
use crate::still::Still;

/// What to render.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct RenderRequest {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples per pixel; the image is complete when it has them.
    pub samples: u32,
    /// The first of those samples, if it is not 0: the film then holds `samples - first_sample` of each pixel, and others
    /// may hold those before.
    pub first_sample: u32,
    /// Samples of a pixel that are added up before the film is: see [`ViewSettings::pass_samples`].
    pub pass_samples: Option<NonZeroU32>,
    /// The part of the image that is rendered: its top left pixel, and its size. The film has that size.
    pub window: Option<[[u32; 2]; 2]>,
    /// It ends, too, when so much time has gone into it and every pixel has a sample: [`Outcome::TimeUp`].
    pub time: Option<Duration>,
    /// It ends, too, when the film's noise is no more than that, as [`Film::noise`] measures it. Which samples are looked at
    /// depends on the film alone: the same request gives the same image, however fast a GPU is.
    pub noise: Option<f64>,
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
            first_sample: 0,
            pass_samples: None,
            window: None,
            time: None,
            noise: None,
            seed: 0,
            guides: false,
            environment_sampling: EnvironmentSampling::Auto,
            cell_size: None,
        }
    }

    /// The top left pixel of what is rendered, and its size; none of it lies beyond the image.
    pub(crate) fn part(&self) -> [[u32; 2]; 2] {
        let image = [self.width, self.height];
        let Some([origin, size]) = self.window else { return [[0, 0], image] };
        let origin = [0, 1].map(|axis| origin[axis].min(image[axis]));
        [origin, [0, 1].map(|axis| size[axis].min(image[axis] - origin[axis]))]
    }

    /// The same with changes.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
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
    /// Every pixel has all samples that were asked for.
    Complete,
    /// [`RenderRequest::time`] was over before that.
    TimeUp,
    /// The progress callback stopped it.
    Stopped,
    /// The GPU failed; the film is the last that came back.
    Failed(GpuError),
}

/// An image, finished or as far as it came.
#[derive(Debug)]
#[non_exhaustive]
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
    /// Bytes of voxels, tables and maps that were brought to the GPU for it: what was there already is not among them.
    pub uploaded: u64,
}

/// Bytes of voxels that a device which has no room even for them cannot use.
const LEAST_VOXELS: u64 = 16 << 20;

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
    let mut renderer = HeadlessRenderer::new(gpu);
    let rendered = renderer.render(gpu, scene, camera, request, on_progress);
    renderer.free(gpu);
    rendered
}

/// A volume, and how it is read.
type Read = (Arc<Volume>, Filter);

/// Renders one image after the other on one GPU: voxels, tables and majorants that the next one needs, too, stay there.
///
/// Those of other volumes go first: where voxels lie in a texture decides in which last bits filters round, and an image
/// shall not depend on those before it.
#[derive(Debug)]
pub struct HeadlessRenderer {
    store: VoxelStore,
    pub(crate) cache: SceneCache,
    /// What voxels are there of, labels and depths among them.
    holds: Vec<Read>,
}

impl HeadlessRenderer {
    /// One that holds nothing yet. It is for this GPU alone.
    pub fn new(gpu: &Gpu) -> Self {
        let store = VoxelStore::new(gpu.executor.limits());
        let cache = SceneCache::new(&store);
        Self { store, cache, holds: vec![] }
    }

    /// Renders a scene; `on_progress` is called a few times a second and may stop it.
    ///
    /// # Errors
    /// [`HeadlessError`] when nothing was rendered. A failure later is the [`Rendered::outcome`], with the film so far.
    pub fn render(
        &mut self,
        gpu: &mut Gpu,
        scene: &Scene,
        camera: &PerspectiveCamera,
        request: &RenderRequest,
        on_progress: &mut dyn FnMut(&RenderProgress) -> ControlFlow<()>,
    ) -> Result<Rendered, HeadlessError> {
        let mut still = self.begin(gpu, scene, camera, request)?;
        let mut end = NoiseEnd::at(request.noise.unwrap_or(0.0));
        let most = request.samples.saturating_sub(request.first_sample);
        loop {
            let target = request.first_sample + end.samples(most);
            let outcome = still.trace_to(gpu, self, target, on_progress);
            if !matches!(outcome, Outcome::Complete) || !end.begin_look(most) {
                break;
            }
            end.look(still.film());
            if !end.is_open(most) && end.samples(most) <= still.film().min_samples() {
                break;
            }
        }
        Ok(still.end(gpu))
    }

    /// Begins an image that is rendered little by little, by [`Still::trace_to`]; [`Still::end`] ends it.
    ///
    /// # Errors
    /// [`HeadlessError`] when it cannot be rendered.
    pub fn begin(
        &mut self,
        gpu: &mut Gpu,
        scene: &Scene,
        camera: &PerspectiveCamera,
        request: &RenderRequest,
    ) -> Result<Still, HeadlessError> {
        let sees = camera.vertical_fov > 0.0 && camera.vertical_fov < std::f64::consts::PI;
        if !sees || !camera.world_from_camera.is_finite() {
            return Err(RenderError::Camera.into());
        }
        let begin = Moment::now();
        let wanted: Vec<_> = scene.volumes.iter().flat_map(voxels).collect();
        let holds = |(held, wanted): (&Read, &Read)| Arc::ptr_eq(&held.0, &wanted.0) && held.1 == wanted.1;
        if self.holds.len() != wanted.len() || !self.holds.iter().zip(&wanted).all(holds) {
            std::mem::replace(self, Self::new(gpu)).free(gpu);
            self.holds = wanted;
        }
        self.set_up(request);
        // While voxels are looked at and uploaded.
        let kernels = self.cache.kernels(scene, ViewKind::Still { guides: request.guides });
        gpu.executor.prepare(kernels.into_iter().filter(|kernel| *kernel != Kernel::Display));
        let mut recording = Recording::new();
        let views = loop {
            self.cache.update(scene, &mut recording)?;
            let views = windows(request, &self.cache, &mut recording)?;
            match gpu.executor.execute(&recording).and_then(|_| gpu.executor.wait()) {
                Ok(()) => break views,
                // What there is no room for comes reduced.
                Err(GpuError::OutOfMemory(_)) if self.store.bytes() > LEAST_VOXELS => {
                    gpu.executor.discard(&recording);
                    self.store.refused(&recording);
                    recording = Recording::new();
                    self.cache = SceneCache::new(&self.store);
                    self.set_up(request);
                }
                Err(error) => {
                    gpu.executor.discard(&recording);
                    return Err(gpu.cause(error).into());
                }
            }
        };
        let factor = |volume| self.store.resolution(volume).map_or(1, |resolution| resolution.factor);
        let reductions = scene.volumes.iter().map(|instance| factor(&instance.volume)).collect();
        let uploaded = recording.steps.iter().map(|step| match step {
            Step::WriteBuffer { data, .. } | Step::WriteTexture { data, .. } => data.bytes().len() as u64,
            _ => 0,
        });
        Ok(Still::new(views, *camera, *request, reductions, uploaded.sum(), begin.elapsed()))
    }

    /// Frees what is on the GPU.
    pub fn free(self, gpu: &mut Gpu) {
        let mut recording = Recording::new();
        self.cache.free(&mut recording);
        self.store.free(&mut recording);
        // A device that is gone has freed everything already.
        let _ = gpu.executor.execute(&recording);
    }

    fn set_up(&mut self, request: &RenderRequest) {
        self.cache.set_environment_sampling(request.environment_sampling);
        self.cache.set_cell_size(request.cell_size.map_or(CellSize::ByDensity, CellSize::Of));
    }
}

/// The volumes that an instance reads, with the filter of each.
fn voxels(instance: &VolumeInstance) -> impl Iterator<Item = Read> {
    let labels =
        instance.labels.as_ref().map(|labelling| (labelling.labels.volume().clone(), Filter::Nearest));
    let depth = instance.peel.as_ref().map(|peel| (peel.depth.clone(), Filter::Trilinear));
    [(instance.volume.clone(), instance.medium.filter)].into_iter().chain(labels).chain(depth)
}

/// Views that together hold what is rendered of the image, each small enough for the device: bands of rows, and of columns
/// where a row alone is too long.
fn windows(
    request: &RenderRequest,
    cache: &SceneCache,
    recording: &mut Recording,
) -> Result<Vec<View>, HeadlessError> {
    let whole = ViewSettings::new(request.width, request.height).with(|it| {
        it.seed = request.seed;
        it.guides = request.guides;
        it.first_sample = request.first_sample;
        it.pass_samples = request.pass_samples;
    });
    let [origin, part] = request.part();
    let pixels = cache.limits().max_storage_binding / whole.bytes_per_pixel(cache.limits());
    let width = u64::from(part[0].max(1)).min(pixels).max(1);
    let height = (pixels / width).clamp(1, u64::from(part[1].max(1)));
    let mut views = vec![];
    let (width, height) = (width as u32, height as u32);
    for y in (0..part[1].max(1)).step_by(height as usize) {
        for x in (0..part[0].max(1)).step_by(width as usize) {
            let size = [width.min(part[0].saturating_sub(x)), height.min(part[1].saturating_sub(y))];
            let window_origin = [origin[0] + x, origin[1] + y];
            let settings = whole.with(|it| {
                it.window_origin = window_origin;
                it.window_size = size;
            });
            views.push(View::new(settings, cache, recording)?);
        }
    }
    Ok(views)
}
