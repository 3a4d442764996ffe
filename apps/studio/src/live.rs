//! The path-traced view as a picture of the interface's.

use std::time::Duration;

use eframe::egui::TextureId;
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use lumivox_core::PerspectiveCamera;
use lumivox_core::document::{Display, View};
use lumivox_core::host::Moment;
use lumivox_viewport::{Picture, PictureProgress, Viewport};
use lumivox_wgpu::Gpu;

use crate::session::Session;

/// Samples at which the view rests.
const SAMPLES: u32 = 512;

/// The view, and the interface's name of its texture.
pub struct Live {
    viewport: Viewport,
    texture: TextureId,
    state: RenderState,
    samples: u32,
    most_pixels: u32,
    /// The version of the scene that kernels are made for already, and since when.
    prepared: Option<(u64, Moment)>,
    /// How long it is waited for what is shown of a scan before all of it is drawn.
    patience: Option<Duration>,
    /// From where a scan that is still coming is seen, by its version and the view's size: to find that takes a while.
    meanwhile: Option<(u64, [u32; 2], PerspectiveCamera)>,
}

/// So long it is waited for what is shown of a scan before all that was scanned is drawn meanwhile.
const PATIENCE: Duration = Duration::from_millis(1500);

impl Live {
    /// A view on the interface's own device. Until a scan is open it costs next to nothing.
    pub fn new(state: &RenderState) -> Self {
        let gpu = Gpu::of_device(state.device.clone(), state.queue.clone());
        // A processor that does the work of a GPU has enough to do with looking for it.
        let patience = (!gpu.description.software).then_some(PATIENCE);
        let viewport = Viewport::new(gpu, [1, 1]);
        let view = viewport.texture().create_view(&Default::default());
        let texture =
            state.renderer.write().register_native_texture(&state.device, &view, wgpu::FilterMode::Linear);
        Self {
            viewport,
            texture,
            state: state.clone(),
            samples: SAMPLES,
            most_pixels: u32::MAX,
            prepared: None,
            patience,
            meanwhile: None,
        }
    }

    /// The interface's name of the texture.
    pub fn texture(&self) -> TextureId {
        self.texture
    }

    /// The GPU's name.
    pub fn gpu_name(&self) -> &str {
        &self.viewport.gpu().description.name
    }

    /// The device and painter that it shares with the interface, for tests of what is seen.
    pub fn render_state(&self) -> &RenderState {
        &self.state
    }

    /// Rests earlier or later than usual.
    pub fn set_samples(&mut self, samples: u32) {
        self.samples = samples;
    }

    /// Draws so many pixels at most, which the view stretches: where a processor draws them.
    pub fn set_most_pixels(&mut self, most: u32) {
        self.most_pixels = most;
    }

    /// What the view has drawn, without the interface: for comparisons.
    pub fn viewport(&self) -> &Viewport {
        &self.viewport
    }

    /// The view, to set its pace.
    pub fn viewport_mut(&mut self) -> &mut Viewport {
        &mut self.viewport
    }

    /// Says how long it is waited for what is shown of a scan before all that was scanned is drawn meanwhile: without an end where there is none.
    pub fn set_patience(&mut self, patience: Option<Duration>) {
        self.patience = patience;
    }

    /// Makes what a session's scene is drawn with, once, while it is looked for what is shown of it. Whether that takes so long that all of the
    /// scan is to be drawn.
    pub fn prepare(&mut self, session: &Session) -> bool {
        let (scene, version) = session.scene();
        match self.prepared {
            Some((prepared, since)) if prepared == version => {
                self.patience.is_some_and(|patience| since.elapsed() >= patience)
            }
            _ => {
                self.viewport.prepare(scene);
                self.prepared = Some((version, Moment::now()));
                false
            }
        }
    }

    /// Draws a session's scene in so many pixels, as far as a frame has time for.
    ///
    /// # Errors
    /// Why nothing is shown.
    pub fn draw(&mut self, session: &Session, size: [u32; 2]) -> Result<PictureProgress, String> {
        let pixels = size.map(f64::from).iter().product::<f64>();
        let share = (f64::from(self.most_pixels) / pixels).sqrt().min(1.0);
        if self.viewport.resize(size.map(|n| (f64::from(n) * share).ceil() as u32)) {
            let view = self.viewport.texture().create_view(&Default::default());
            self.state.renderer.write().update_egui_texture_from_wgpu_texture(
                &self.state.device,
                &view,
                wgpu::FilterMode::Linear,
                self.texture,
            );
        }
        let (scene, version) = session.scene();
        let known = self
            .meanwhile
            .filter(|(of, in_view, _)| session.fits_meanwhile() && (*of, *in_view) == (version, size));
        if known.is_none() {
            let aspect = f64::from(size[0]) / f64::from(size[1]);
            let fits = session.fits_meanwhile().then(|| View::default().camera(scene, aspect));
            self.meanwhile = fits.flatten().map(|camera| (version, size, camera));
        }
        let document = session.document();
        let display: &Display = &document.display;
        let picture = Picture {
            scene,
            version,
            camera: self.meanwhile.as_ref().map_or(session.camera(), |(_, _, camera)| camera),
            display,
            samples: self.samples,
            seed: document.film.seed,
        };
        self.viewport.frame(&picture).map_err(|error| error.to_string())
    }

    /// Frees what is on the device of the scan before.
    pub fn forget(&mut self) {
        // A device that fails says so with the next frame.
        let _ = self.viewport.forget();
    }
}
