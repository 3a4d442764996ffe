//! A scan in a window of one's own, live: drag to turn it, scroll to come closer. `cargo run --release -p lumivox-window`

mod screen;

use std::collections::VecDeque;
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use lumivox_core::camera::Orbit;
use lumivox_core::{CancelToken, Preset, Progress, Scene, framing};
use lumivox_phantom::{AnatomyOptions, anatomy};
use lumivox_renderer::pacing::{Pacer, Pass, UploadPacer};
use lumivox_renderer::{
    HostFrame, LiveSettings, LiveStatus, LiveView, Recording, ResourceId, SceneCache, ViewKind, VoxelStore,
};
use lumivox_wgpu::{Gpu, GpuTime, ReadBack, Submission};
use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

use crate::screen::Screen;

type Fallible<T = ()> = Result<T, Box<dyn Error>>;

/// What the command line asks for.
struct Options {
    /// Ends after so many frames with the scan in them.
    frames: Option<u64>,
    /// Where the last of them goes.
    screenshot: Option<PathBuf>,
    /// Pixels of the window.
    size: [u32; 2],
    /// Milliseconds of a frame that go into tracing.
    budget: f64,
}

impl Options {
    const USAGE: &str = "lumivox-window [--size 960x720] [--budget MS] [--frames N [--screenshot FILE.png]]";

    fn parse(mut arguments: impl Iterator<Item = String>) -> Option<Self> {
        let mut options = Self { frames: None, screenshot: None, size: [960, 720], budget: 8.0 };
        while let Some(argument) = arguments.next() {
            let value = arguments.next()?;
            match argument.as_str() {
                "--frames" => options.frames = Some(value.parse().ok()?),
                "--screenshot" => options.screenshot = Some(value.into()),
                "--budget" => options.budget = value.parse().ok()?,
                "--size" => {
                    let (width, height) = value.split_once('x')?;
                    options.size = [width.parse().ok()?, height.parse().ok()?];
                }
                _ => return None,
            }
        }
        Some(options)
    }
}

fn main() -> Fallible {
    let options = Options::parse(std::env::args().skip(1)).ok_or(Options::USAGE)?;
    let event_loop = EventLoop::with_user_event().build()?;
    let mut app = App { options, proxy: event_loop.create_proxy(), viewer: None, failed: None };
    event_loop.run_app(&mut app)?;
    app.failed.map_or(Ok(()), Err)
}

/// What winit calls. The scan arrives as an event: it is made on a thread of its own.
struct App {
    options: Options,
    proxy: EventLoopProxy<Scene>,
    viewer: Option<Viewer>,
    failed: Option<Box<dyn Error>>,
}

impl ApplicationHandler<Scene> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.viewer.is_none() {
            let opened = Viewer::open(event_loop, &self.options, self.proxy.clone());
            self.failed = opened.map(|viewer| self.viewer = Some(viewer)).err();
        }
        if self.failed.is_some() {
            event_loop.exit();
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, scene: Scene) {
        if let Some(viewer) = &mut self.viewer {
            viewer.show(scene);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(viewer) = &mut self.viewer else { return };
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => viewer.resize(size),
            WindowEvent::CursorMoved { position, .. } => viewer.point(position),
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                viewer.dragging = state == ElementState::Pressed;
            }
            WindowEvent::MouseWheel { delta, .. } => viewer.zoom(match delta {
                MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                MouseScrollDelta::PixelDelta(pixels) => pixels.y / 40.0,
            }),
            WindowEvent::RedrawRequested => match viewer.frame(&self.options) {
                Ok(true) => event_loop.exit(),
                Ok(false) => {}
                Err(error) => {
                    self.failed = Some(error);
                    event_loop.exit();
                }
            },
            _ => {}
        }
    }
}

/// A frame that the GPU may still be at.
struct UnderWay {
    serial: u64,
    submission: Submission,
}

/// The window and everything that is shown in it.
struct Viewer {
    window: Arc<Window>,
    screen: Screen,
    gpu: Gpu,
    cache: SceneCache,
    scene: Option<Scene>,
    live: Option<LiveView>,
    settings: LiveSettings,
    /// What the renderer calls the texture that it draws over.
    color: ResourceId,
    orbit: Option<Orbit>,
    cursor: PhysicalPosition<f64>,
    dragging: bool,
    pacer: Pacer,
    uploads: UploadPacer,
    under_way: VecDeque<UnderWay>,
    /// What the frame before was a picture of: another one starts over.
    traced: Option<(Orbit, u64, [u32; 2])>,
    /// When the frame before began, unless the window rested since.
    began: Option<Instant>,
    frames: u64,
}

impl Viewer {
    fn open(event_loop: &ActiveEventLoop, options: &Options, proxy: EventLoopProxy<Scene>) -> Fallible<Self> {
        let [width, height] = options.size;
        let attributes = Window::default_attributes()
            .with_title("Lumivox")
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(event_loop.create_window(attributes)?);
        let (screen, mut gpu) = pollster::block_on(Screen::open(window.clone()))?;
        let color = ResourceId::external();
        gpu.executor.lend_texture(color, &screen.color);
        // One store for each device: scenes share the voxels in it.
        let store = VoxelStore::new(gpu.executor.limits());
        let cache = SceneCache::new(&store);
        let maker = gpu.executor.texture_maker();
        std::thread::spawn(move || {
            let scene = load();
            // What would take an update long is computed and made here.
            if let Some(work) = SceneCache::new(&store).preparation(&scene) {
                work.run_with(|order| maker.make(order));
            }
            // Nobody is there any more where the window was closed.
            let _ = proxy.send_event(scene);
        });
        window.request_redraw();
        let [width, height] = screen.size();
        let settings = LiveSettings { denoise: true, ..LiveSettings::new(width, height) };
        Ok(Self {
            window,
            screen,
            gpu,
            cache,
            scene: None,
            live: None,
            settings,
            color,
            orbit: None,
            cursor: PhysicalPosition::default(),
            dragging: false,
            pacer: Pacer::new(),
            uploads: UploadPacer::new(),
            under_way: VecDeque::new(),
            traced: None,
            began: None,
            frames: 0,
        })
    }

    /// The scan is there. Its kernels are made on threads of their own until a frame can have them.
    fn show(&mut self, scene: Scene) {
        let kernels = self.cache.kernels(&scene, ViewKind::Live);
        self.gpu.executor.prepare(kernels.iter().copied());
        self.gpu.executor.prepare_draws(kernels, Screen::COLOR_FORMAT, 1);
        self.orbit = Some(framing::frame(&scene, 0.45, 0.08, 0.5, self.screen.aspect()));
        self.scene = Some(scene);
        self.window.request_redraw();
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        if size.width == 0 || size.height == 0 {
            return;
        }
        self.screen.resize(self.gpu.executor.device(), [size.width, size.height]);
        self.gpu.executor.lend_texture(self.color, &self.screen.color);
        self.settings.size = [size.width, size.height];
        self.window.request_redraw();
    }

    fn point(&mut self, to: PhysicalPosition<f64>) {
        let from = std::mem::replace(&mut self.cursor, to);
        let Some(orbit) = self.orbit.as_mut().filter(|_| self.dragging) else { return };
        orbit.azimuth -= (to.x - from.x) * 0.008;
        orbit.elevation = (orbit.elevation + (to.y - from.y) * 0.008).clamp(-1.5, 1.5);
        self.window.request_redraw();
    }

    fn zoom(&mut self, lines: f64) {
        if let Some(orbit) = &mut self.orbit {
            orbit.distance *= 0.9_f64.powf(lines);
            self.window.request_redraw();
        }
    }

    /// Draws one frame. True when it was the last that was asked for.
    fn frame(&mut self, options: &Options) -> Fallible<bool> {
        let took = self.began.replace(Instant::now()).map(|began| began.elapsed().as_secs_f64() * 1e3);
        self.take_what_came_back()?;
        let Some(surface) = self.screen.next(self.gpu.executor.device())? else {
            self.window.request_redraw();
            return Ok(false);
        };
        self.screen.draw_backdrop(&self.gpu);
        // Not known after a rest.
        took.iter().for_each(|took| self.pacer.interval(*took));
        let status = match self.update(took.unwrap_or(0.0))? {
            true => Some(self.trace(options.budget)?),
            false => None,
        };
        self.screen.draw_picture(&self.gpu, &surface);
        self.frames += u64::from(status.is_some());
        let is_last = options.frames.is_some_and(|frames| self.frames >= frames);
        if let Some(file) = options.screenshot.as_ref().filter(|_| is_last) {
            self.screen.save(&self.gpu, &surface, file)?;
        }
        self.window.pre_present_notify();
        surface.present();
        // A finished picture costs nothing more; until then every frame adds to it.
        let is_done = status.is_some_and(|status| status.converged && !status.awaits_feedback);
        if is_done && self.cache.is_settled() && options.frames.is_none() {
            self.began = None;
        } else {
            self.window.request_redraw();
        }
        Ok(is_last)
    }

    /// Bytes, faults and times of frames before, in their order and as far as they are there: nothing is waited for.
    fn take_what_came_back(&mut self) -> Fallible {
        self.gpu.check()?;
        while let Some(UnderWay { serial, submission }) = self.under_way.front_mut() {
            if let Some(told) = submission.poll_check() {
                told?;
            }
            while let Some(bytes) = submission.read_backs.first_mut().and_then(ReadBack::poll) {
                submission.read_backs.remove(0);
                if let Some(live) = &mut self.live {
                    live.feedback(&bytes?);
                }
            }
            // 0 where the device tells no times: then the frame rate paces.
            let time = submission.time.as_mut().map_or(Some(0.0), GpuTime::poll);
            let (true, Some(milliseconds)) = (submission.read_backs.is_empty(), time) else { break };
            self.pacer.measured(*serial, milliseconds);
            self.under_way.pop_front();
        }
        Ok(())
    }

    /// Brings the scene to the GPU, as much of it as a frame has time for. False while there is nothing to show.
    fn update(&mut self, frame_milliseconds: f64) -> Fallible<bool> {
        let Some(scene) = &self.scene else { return Ok(false) };
        let kernels = self.cache.kernels(scene, ViewKind::Live);
        let executor = &mut self.gpu.executor;
        if !executor.is_prepared(kernels.iter().copied())
            || !executor.is_prepared_to_draw(kernels, Screen::COLOR_FORMAT, 1)
        {
            return Ok(false);
        }
        if self.live.is_some() && self.cache.is_settled() {
            return Ok(true);
        }
        let (began, granted) = (Instant::now(), self.uploads.budget(frame_milliseconds.min(500.0)));
        let mut recording = Recording::new();
        let mut left = granted;
        self.cache.update_within(scene, &mut left, &mut recording)?;
        if self.live.is_none() {
            self.live = Some(LiveView::new(&self.settings, &self.cache, &mut recording)?);
        }
        if let Some(told) = executor.submit(&recording)?.poll_check() {
            // A host with much to show would tell the store, `VoxelStore::refused`, and have volumes come reduced.
            told?;
        }
        self.uploads.measured(granted - left, granted, began.elapsed().as_secs_f64() * 1e3);
        Ok(true)
    }

    /// Traces for so long, and draws what there is over the screen's colour.
    fn trace(&mut self, milliseconds: f64) -> Fallible<LiveStatus> {
        let (Some(live), Some(orbit)) = (&mut self.live, self.orbit) else { return Err("no scene".into()) };
        let shows = Some((orbit, self.cache.version(), self.settings.size));
        let is_another = std::mem::replace(&mut self.traced, shows) != shows;
        let pass = if is_another { Pass::Moving } else { Pass::Still };
        let budget = self.pacer.budget(pass, milliseconds);
        // With `depth` rays would end at the host's meshes, and with `depth_target` later ones meet the scan.
        let host = HostFrame { color_target: self.color, depth: None, depth_target: None, fog: None };
        let camera = orbit.camera().with_aspect(self.screen.aspect());
        let mut recording = Recording::new();
        let status =
            live.record_frame(&self.cache, &camera, &self.settings, &host, budget, &mut recording)?;
        let submission = self.gpu.executor.submit(&recording)?;
        let serial = self.frames;
        self.pacer.recorded(serial, pass, status.pixel_samples, budget, milliseconds);
        self.under_way.push_back(UnderWay { serial, submission });
        self.window.set_title(&format!(
            "Lumivox: {} samples, {:.1} ms on {}",
            status.samples,
            self.pacer.milliseconds(),
            self.gpu.description.name
        ));
        Ok(status)
    }
}

/// A head, as its CT would be, under the light of a studio.
fn load() -> Scene {
    let options = AnatomyOptions { size: 160, ..Default::default() };
    let volume = Arc::new(anatomy(options, Progress::SILENT, &CancelToken::new()).expect("nobody cancels"));
    Scene::with_volume(volume.clone(), Preset::CtMuscle.medium(&volume))
}
