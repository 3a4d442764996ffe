//! The way to the GPU: devices, and what renders on one.

use std::mem::ManuallyDrop;
use std::ops::ControlFlow;
use std::sync::mpsc::Sender;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use lumivox_core::CancelToken;
use lumivox_core::host::Moment;
use lumivox_wgpu::{Gpu, GpuDescription, HeadlessRenderer, MovingView, Outcome, RenderProgress, Rendered};
use pyo3::prelude::*;

use crate::description::{Camera, Request, Scene};
use crate::ending;
use crate::errors;
use crate::film::Film;
use crate::fork;
use crate::wait;

/// Mesa's device-select layer asks the Wayland server which GPU is the desktop's, and complains on stderr where there
/// is no desktop. Nothing is lost by leaving it out there.
pub fn quiet_mesa() {
    if cfg!(target_os = "linux") && std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: it is the importing thread, with the interpreter's lock, that reads and writes variables, too.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// `(name, driver, API, whether it computes on the CPU, what it lacks)` of every device, the most capable first.
type Device = (String, String, String, bool, Option<String>);

fn device(gpu: GpuDescription) -> Device {
    (gpu.name, gpu.driver, gpu.backend, gpu.software, gpu.unsuitable)
}

/// Every device, the most capable first.
#[pyfunction]
pub fn gpus(py: Python<'_>) -> PyResult<Vec<Device>> {
    fork::use_gpus()?;
    Ok(ending::detach(py, Gpu::list).into_iter().map(device).collect())
}

/// Which device: by place in the list, or by a part of its name.
#[derive(FromPyObject)]
enum Which {
    Index(usize),
    Name(String),
}

/// `(samples of the average pixel, samples asked for, seconds, seconds left, noise)`.
type Told = (f64, u32, f64, f64, Option<f64>);

/// A GPU, and what stays on it between images.
struct Opened {
    gpu: ManuallyDrop<Gpu>,
    renderer: Option<HeadlessRenderer>,
    /// The process that opened it.
    process: u32,
}

impl Drop for Opened {
    fn drop(&mut self) {
        let renderer = self.renderer.take();
        if self.process != fork::process() {
            // A child's copy of what its parent uses: nothing of it may be freed here.
            std::mem::forget(renderer);
            return;
        }
        if let Some(renderer) = renderer {
            renderer.free(&mut self.gpu);
        }
        // SAFETY: it is used no more.
        unsafe { ManuallyDrop::drop(&mut self.gpu) };
    }
}

/// Renders on one GPU; voxels stay there between images.
#[pyclass(frozen, module = "lumivox._native")]
pub struct Renderer {
    opened: Mutex<Opened>,
    description: GpuDescription,
}

/// What a render brought: the film, how it ended ("complete", "time", "stopped" or a failure's words), seconds of preparation and
/// tracing, pixels with unfinished paths, reductions of the volumes, and bytes brought to the GPU.
type Brought = (Film, String, f64, f64, u32, Vec<u32>, u64);

/// What there is of an image under way: the film, how it ended, seconds of tracing, pixels with unfinished paths, and
/// reductions of the volumes.
type Traced = (Film, String, f64, u32, Vec<u32>);

fn brought(rendered: Rendered) -> Brought {
    let outcome = ended(&rendered.outcome);
    let [prepare, trace] = [rendered.prepare, rendered.trace].map(|time| time.as_secs_f64());
    let Rendered { film, unfinished, reductions, uploaded, .. } = rendered;
    (Film(film), outcome, prepare, trace, unfinished, reductions, uploaded)
}

/// How a render ended, in a word, or in a failure's words.
fn ended(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Complete => "complete".to_owned(),
        Outcome::TimeUp => "time".to_owned(),
        Outcome::Stopped => "stopped".to_owned(),
        Outcome::Failed(error) => error.to_string(),
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn told(progress: &RenderProgress) -> Told {
    let [elapsed, left] = [progress.elapsed, progress.left].map(|time| time.as_secs_f64());
    (progress.samples, progress.target, elapsed, left, progress.noise)
}

/// What goes on between a GPU's work and whoever waits for it.
fn watcher<'a>(
    sender: &'a Sender<Told>,
    cancel: &'a CancelToken,
) -> impl FnMut(&RenderProgress) -> ControlFlow<()> + 'a {
    move |progress| {
        let _ = sender.send(told(progress));
        if cancel.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Hears progress: a callable that returns `False` stops the render and keeps what there is.
fn hear(
    told: Option<Py<PyAny>>,
    cancel: &CancelToken,
) -> impl Fn(Python<'_>, Told) -> PyResult<()> + Send + use<> {
    let cancel = cancel.clone();
    move |py, progress| {
        let Some(told) = &told else { return Ok(()) };
        if matches!(told.call1(py, progress)?.extract::<bool>(py), Ok(false)) {
            cancel.cancel();
        }
        Ok(())
    }
}

#[pymethods]
impl Renderer {
    /// Opens a GPU: by index, by a part of its name, or the most capable.
    #[new]
    fn new(py: Python<'_>, gpu: Option<Which>) -> PyResult<Self> {
        fork::use_gpus()?;
        let opened = ending::detach(py, || match &gpu {
            Some(Which::Index(index)) => Gpu::open_at(*index),
            Some(Which::Name(name)) => Gpu::open(Some(name)),
            None => Gpu::open(None),
        });
        let gpu = opened.map_err(errors::gpu)?;
        let renderer = Some(HeadlessRenderer::new(&gpu));
        let description = gpu.description.clone();
        let opened = Opened { gpu: ManuallyDrop::new(gpu), renderer, process: fork::process() };
        Ok(Self { description, opened: Mutex::new(opened) })
    }

    /// What it is.
    #[getter]
    fn device(&self) -> Device {
        device(self.description.clone())
    }

    /// Renders an image. `progress` is called with what is told of it, and stops it by returning `False`.
    fn render(
        &self,
        py: Python<'_>,
        scene: Scene,
        camera: Camera,
        request: Request,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Brought> {
        fork::use_gpus()?;
        let (scene, camera, request) = (scene.build()?, camera.build(), request.build()?);
        let cancel = CancelToken::new();
        let work = |sender: Sender<Told>| {
            let mut opened = lock(&self.opened);
            let Opened { gpu, renderer, .. } = &mut *opened;
            let renderer = renderer.as_mut().expect("it is there until it is dropped");
            renderer.render(gpu, &scene, &camera, &request, &mut watcher(&sender, &cancel))
        };
        let rendered = wait::wait(py, &cancel, work, hear(progress, &cancel))?;
        rendered.map(brought).map_err(errors::headless)
    }

    /// Begins an image that is rendered little by little.
    fn begin(
        slf: Py<Self>,
        py: Python<'_>,
        scene: Scene,
        camera: Camera,
        request: Request,
    ) -> PyResult<Still> {
        fork::use_gpus()?;
        let (scene, camera, request) = (scene.build()?, camera.build(), request.build()?);
        let began = ending::detach(py, || {
            let mut opened = lock(&slf.get().opened);
            let Opened { gpu, .. } = &mut *opened;
            // One of its own: others may render other scenes meanwhile.
            let mut renderer = HeadlessRenderer::new(gpu);
            let still = renderer.begin(gpu, &scene, &camera, &request);
            still.map(|still| (renderer, still))
        });
        let under_way = began.map_err(errors::headless)?;
        Ok(Still { renderer: slf, under_way: Mutex::new(Some(under_way)) })
    }
}

/// An image that is rendered little by little.
#[pyclass(frozen, module = "lumivox._native")]
pub struct Still {
    renderer: Py<Renderer>,
    under_way: Mutex<Option<(HeadlessRenderer, lumivox_wgpu::Still)>>,
}

#[pymethods]
impl Still {
    /// Traces until every pixel has so many samples; returns what there is.
    fn trace_to(&self, py: Python<'_>, samples: u32, progress: Option<Py<PyAny>>) -> PyResult<Traced> {
        fork::use_gpus()?;
        let cancel = CancelToken::new();
        let work = |sender: Sender<Told>| {
            let mut opened = lock(&self.renderer.get().opened);
            let mut under_way = lock(&self.under_way);
            let (renderer, still) = under_way.as_mut()?;
            let outcome =
                still.trace_to(&mut opened.gpu, renderer, samples, &mut watcher(&sender, &cancel)).clone();
            let (film, reductions) = (Film(still.film().clone()), still.reductions().to_vec());
            Some((film, outcome, seconds(still.trace_time()), still.unfinished(), reductions))
        };
        match wait::wait(py, &cancel, work, hear(progress, &cancel))? {
            None => Err(errors::value("the image was ended")),
            Some((_, Outcome::Failed(error), ..)) => Err(errors::gpu(error)),
            Some((film, outcome, time, unfinished, reductions)) => {
                Ok((film, ended(&outcome), time, unfinished, reductions))
            }
        }
    }

    /// Frees what it has on the GPU.
    fn end(&self, py: Python<'_>) {
        if fork::use_gpus().is_err() {
            return;
        }
        ending::detach(py, || {
            let Some((renderer, still)) = lock(&self.under_way).take() else { return };
            let mut opened = lock(&self.renderer.get().opened);
            still.end(&mut opened.gpu);
            renderer.free(&mut opened.gpu);
        });
    }
}

/// A scene that moves, of whose light the GPU keeps what it has learnt.
#[pyclass(frozen, module = "lumivox._native")]
pub struct Moving {
    renderer: Py<Renderer>,
    view: Mutex<Option<MovingView>>,
}

#[pymethods]
impl Moving {
    #[new]
    fn new(renderer: Py<Renderer>) -> Self {
        Self { renderer, view: Mutex::new(None) }
    }

    /// What is seen of a scene, and the seconds that took; nothing where the GPU has no room for its light.
    fn picture(
        &self,
        py: Python<'_>,
        scene: Scene,
        camera: Camera,
        size: [u32; 2],
    ) -> PyResult<Option<(Film, f64)>> {
        fork::use_gpus()?;
        let (scene, camera) = (scene.build()?, camera.build());
        let pictured = ending::detach(py, || {
            let begin = Moment::now();
            let mut opened = lock(&self.renderer.get().opened);
            let mut view = lock(&self.view);
            let view = view.get_or_insert_with(|| MovingView::new(&opened.gpu));
            let film = view.picture(&mut opened.gpu, &scene, &camera, size)?;
            Ok(film.map(|film| (Film(film), begin.elapsed().as_secs_f64())))
        });
        pictured.map_err(errors::headless)
    }

    /// Frees what it has on the GPU.
    fn end(&self, py: Python<'_>) {
        if fork::use_gpus().is_err() {
            return;
        }
        ending::detach(py, || {
            let Some(view) = lock(&self.view).take() else { return };
            view.free(&mut lock(&self.renderer.get().opened).gpu);
        });
    }
}

fn seconds(time: Duration) -> f64 {
    time.as_secs_f64()
}
