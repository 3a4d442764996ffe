//! A scan in a window of one's own, live: drag to turn it, scroll to come closer, press S to save the view as a scene file.
//! `cargo run --release -p lumivox-window [SCENE or SCAN]`
//!
//! `show.rs` is the manual for hosts: what an engine does with each of its frames. `screen.rs` stands for the rest of an engine,
//! `scene.rs` opens and saves what is shown.

mod scene;
mod screen;
mod show;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use lumivox_core::camera::Orbit;
use lumivox_renderer::{LiveSettings, SceneCache};
use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop, EventLoopProxy};
use winit::keyboard::Key;
use winit::window::{Window, WindowId};

use crate::scene::Opened;
use crate::screen::Screen;
use crate::show::{Picture, Show};

type Fallible<T = ()> = Result<T, Box<dyn Error>>;

/// What the command line asks for.
struct Options {
    /// A scene document, or a scan.
    path: Option<PathBuf>,
    /// Ends after so many frames with the scan in them.
    frames: Option<u64>,
    /// Where the last of them goes.
    screenshot: Option<PathBuf>,
    /// Where the view is saved: when S is pressed, and with the last frame where that was asked for.
    save: Option<PathBuf>,
    /// Pixels of the window.
    size: [u32; 2],
    /// Milliseconds of a frame that go into tracing.
    budget: f64,
    /// Whether light is kept in the scan, for what moves.
    kept_light: bool,
}

impl Options {
    const USAGE: &str = "lumivox-window [SCENE.lumivox | SCAN] [--save FILE.lumivox] [--size 960x720] [--budget MS] \
                         [--kept-light on|off] [--frames N [--screenshot FILE.png]]";

    fn parse(mut arguments: impl Iterator<Item = String>) -> Option<Self> {
        let mut options = Self {
            path: None,
            frames: None,
            screenshot: None,
            save: None,
            size: [960, 720],
            budget: 8.0,
            kept_light: true,
        };
        while let Some(argument) = arguments.next() {
            if !argument.starts_with('-') && options.path.is_none() {
                options.path = Some(argument.into());
                continue;
            }
            let value = arguments.next()?;
            match argument.as_str() {
                "--frames" => options.frames = Some(value.parse().ok()?),
                "--screenshot" => options.screenshot = Some(value.into()),
                "--save" => options.save = Some(value.into()),
                "--budget" => options.budget = value.parse().ok()?,
                "--kept-light" => {
                    options.kept_light = match value.as_str() {
                        "on" => true,
                        "off" => false,
                        _ => return None,
                    };
                }
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

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Fallible {
    let options = Options::parse(std::env::args().skip(1)).ok_or(format!("usage: {}", Options::USAGE))?;
    let event_loop = EventLoop::with_user_event().build()?;
    let mut app = App { options, proxy: event_loop.create_proxy(), viewer: None, failed: None };
    event_loop.run_app(&mut app)?;
    app.failed.map_or(Ok(()), Err)
}

/// What was opened, or why nothing was.
type Arrival = Result<Opened, String>;

/// What winit calls. The scene arrives as an event: it is opened on a thread of its own.
struct App {
    options: Options,
    proxy: EventLoopProxy<Arrival>,
    viewer: Option<Viewer>,
    failed: Option<Box<dyn Error>>,
}

impl App {
    fn fail(&mut self, event_loop: &ActiveEventLoop, error: Box<dyn Error>) {
        self.failed = Some(error);
        event_loop.exit();
    }
}

impl ApplicationHandler<Arrival> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.viewer.is_none() {
            match Viewer::open(event_loop, &self.options, self.proxy.clone()) {
                Ok(viewer) => self.viewer = Some(viewer),
                Err(error) => self.fail(event_loop, error),
            }
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, arrival: Arrival) {
        match (arrival, &mut self.viewer) {
            (Ok(opened), Some(viewer)) => viewer.show(opened),
            (Ok(_), None) => {}
            (Err(error), _) => self.fail(event_loop, error.into()),
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
            WindowEvent::KeyboardInput {
                event:
                    KeyEvent {
                        logical_key: Key::Character(key), state: ElementState::Pressed, repeat: false, ..
                    },
                ..
            } if key.eq_ignore_ascii_case("s") => viewer.save(&self.options),
            WindowEvent::RedrawRequested => match viewer.frame(&self.options) {
                Ok(true) => event_loop.exit(),
                Ok(false) => {}
                Err(error) => self.fail(event_loop, error),
            },
            _ => {}
        }
    }
}

/// The window and everything that is shown in it.
struct Viewer {
    window: Arc<Window>,
    screen: Screen,
    show: Show,
    opened: Option<Opened>,
    /// Once the camera was moved.
    orbit: Option<Orbit>,
    cursor: PhysicalPosition<f64>,
    dragging: bool,
    frames: u64,
}

impl Viewer {
    fn open(
        event_loop: &ActiveEventLoop,
        options: &Options,
        proxy: EventLoopProxy<Arrival>,
    ) -> Fallible<Self> {
        let [width, height] = options.size;
        let attributes = Window::default_attributes()
            .with_title("Lumivox")
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(event_loop.create_window(attributes)?);
        let (screen, gpu) = pollster::block_on(Screen::open(window.clone()))?;
        let maker = gpu.executor.texture_maker();
        let show = Show::new(gpu);
        let (store, path) = (show.store().clone(), options.path.clone());
        std::thread::spawn(move || {
            let arrival = Opened::read(path.as_deref());
            // What would take an update long is computed and made here.
            let work =
                arrival.as_ref().ok().and_then(|opened| SceneCache::new(&store).preparation(&opened.scene));
            if let Some(work) = work {
                work.run_with(|order| maker.make(order));
            }
            // Nobody is there any more where the window was closed.
            let _ = proxy.send_event(arrival);
        });
        window.request_redraw();
        Ok(Self {
            window,
            screen,
            show,
            opened: None,
            orbit: None,
            cursor: PhysicalPosition::default(),
            dragging: false,
            frames: 0,
        })
    }

    fn show(&mut self, opened: Opened) {
        self.opened = Some(opened);
        self.window.request_redraw();
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        if size.width == 0 || size.height == 0 {
            return;
        }
        self.screen.resize(self.show.gpu.executor.device(), [size.width, size.height]);
        self.window.request_redraw();
    }

    fn point(&mut self, to: PhysicalPosition<f64>) {
        let from = std::mem::replace(&mut self.cursor, to);
        if self.dragging {
            self.turn(|orbit| {
                orbit.azimuth -= (to.x - from.x) * 0.008;
                orbit.elevation = (orbit.elevation + (to.y - from.y) * 0.008).clamp(-1.5, 1.5);
            });
        }
    }

    fn zoom(&mut self, lines: f64) {
        self.turn(|orbit| orbit.distance *= 0.9_f64.powf(lines));
    }

    fn turn(&mut self, change: impl FnOnce(&mut Orbit)) {
        let Some(opened) = &mut self.opened else { return };
        let orbit = self.orbit.get_or_insert_with(|| opened.orbit());
        change(orbit);
        opened.camera = orbit.camera();
        self.window.request_redraw();
    }

    /// Saves the view. Nothing is lost where that fails.
    fn save(&self, options: &Options) {
        let file = options.save.clone().unwrap_or_else(|| "view.lumivox".into());
        let Some(opened) = &self.opened else { return };
        match opened.save(&file, self.screen.size()) {
            Ok(()) => println!("{} holds the view", file.display()),
            Err(error) => eprintln!("{}: {error}", file.display()),
        }
    }

    /// Draws one frame. True when it was the last that was asked for.
    fn frame(&mut self, options: &Options) -> Fallible<bool> {
        let Some(surface) = self.screen.next(self.show.gpu.executor.device())? else {
            self.window.request_redraw();
            return Ok(false);
        };
        self.screen.draw_backdrop(&self.show.gpu);
        let [width, height] = self.screen.size();
        let shown = match &self.opened {
            Some(Opened { scene, camera, .. }) => self.show.frame(&Picture {
                scene,
                version: 1,
                camera: camera.with_aspect(self.screen.aspect()),
                settings: LiveSettings::new(width, height).with(|it| {
                    it.denoise = true;
                    it.kept_light = options.kept_light;
                }),
                color: &self.screen.color,
                budget: options.budget,
            })?,
            None => None,
        };
        self.screen.draw_picture(&self.show.gpu, &surface);
        self.frames += u64::from(shown.is_some());
        let is_last = options.frames.is_some_and(|frames| self.frames >= frames);
        if is_last && let Some(file) = &options.screenshot {
            self.screen.save(&self.show.gpu, &surface, file)?;
        }
        if is_last && let (Some(file), Some(opened)) = (&options.save, &self.opened) {
            opened.save(file, [width, height])?;
        }
        self.window.pre_present_notify();
        surface.present();
        if let Some(progress) = shown {
            let (samples, took) = (progress.live.samples, self.show.milliseconds());
            let gpu = &self.show.gpu.description.name;
            self.window.set_title(&format!("Lumivox: {samples} samples, {took:.1} ms on {gpu}"));
        }
        // A finished picture costs nothing more; until then every frame adds to it.
        let is_done = shown.is_some_and(|progress| progress.is_converged && !progress.live.awaits_feedback);
        if !is_done || options.frames.is_some() {
            self.window.request_redraw();
        }
        Ok(is_last)
    }
}
