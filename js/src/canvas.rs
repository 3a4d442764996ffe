//! A scene on a canvas, a frame at a time.

use lumivox_browser::{best_texels, pace};
use lumivox_core::document::{Entry, Scan as Written, SceneDocument, View};
use lumivox_core::{PerspectiveCamera, Preset, Scene};
use lumivox_scene::{Part, assemble};
use lumivox_viewport::{Button, Gesture, Held, Picture, Profile, Viewport, center_of, orbit_of, pick};
use wasm_bindgen::prelude::*;

use crate::scan::Scan;
use crate::screen::Screen;
use crate::wrong;

/// How far a picture is.
#[wasm_bindgen]
#[derive(Clone, Copy)]
pub struct Told {
    /// Samples that every pixel has.
    pub samples: u32,
    /// The part of the picture's samples that is traced, 0 to 1.
    pub part: f32,
    /// Whether something of the scene is seen.
    #[wasm_bindgen(js_name = isShown)]
    pub is_shown: bool,
    /// Whether there is nothing more to do until something changes.
    pub rests: bool,
}

/// What is shown.
struct Shown {
    document: SceneDocument,
    parts: Vec<Part>,
    scene: Scene,
    camera: PerspectiveCamera,
    /// Whether nobody said from where: all of it is to fit, whatever the canvas' shape.
    is_framed: bool,
}

/// A view of scans on a canvas.
#[wasm_bindgen]
pub struct Canvas {
    screen: Screen,
    viewport: Viewport,
    shown: Option<Shown>,
    /// Another one with every change of the scene.
    version: u64,
    samples: u32,
    profile: Profile,
}

#[wasm_bindgen]
impl Canvas {
    /// On a page's canvas or a Worker's `OffscreenCanvas`. `software` says that a processor does the work of a GPU.
    ///
    /// # Errors
    /// Why there is no picture.
    pub async fn open(canvas: JsValue, software: bool) -> Result<Canvas, JsError> {
        let (screen, gpu) = Screen::open(canvas).await?;
        let fine_texels = best_texels(gpu.executor.device(), gpu.executor.queue()).await.map_err(wrong)?;
        let mut viewport = Viewport::new(gpu, screen.size());
        viewport.store_as(fine_texels);
        *viewport.pace_mut() = pace(software);
        Ok(Self { screen, viewport, shown: None, version: 0, samples: 512, profile: Profile::OHIF })
    }

    /// Shows scans as they are given, in a scene document whose volumes they are, one after the other; what it names is not looked for.
    /// One without volumes shows them as suits them.
    ///
    /// # Errors
    /// What of the document is wrong, by line and column.
    pub fn show(&mut self, document: &str, scans: Vec<Scan>) -> Result<(), JsError> {
        self.follow(document, scans.iter().map(Scan::part).collect())
    }

    /// Shows the same scans by another document.
    ///
    /// # Errors
    /// What of the document is wrong, by line and column.
    pub fn change(&mut self, document: &str) -> Result<(), JsError> {
        let shown = self.shown.as_ref().ok_or_else(|| wrong("nothing is shown yet"))?;
        self.follow(document, shown.parts.clone())
    }

    /// Shows nothing any more, and frees the device's memory.
    ///
    /// # Errors
    /// When the device failed.
    pub fn clear(&mut self) -> Result<(), JsError> {
        self.shown = None;
        self.viewport.forget().map_err(wrong)
    }

    /// What is shown as a scene document, with the camera as it stands; empty where nothing is.
    ///
    /// # Errors
    /// Never.
    #[wasm_bindgen(getter)]
    pub fn scene(&self) -> Result<String, JsError> {
        let Some(shown) = &self.shown else { return Ok(String::new()) };
        let mut document = shown.document.clone();
        if !shown.is_framed {
            document.camera = View::of(&shown.camera);
        }
        document.to_json().map_err(wrong)
    }

    /// Gives the canvas so many pixels.
    pub fn resize(&mut self, width: u32, height: u32) {
        self.screen.resize(self.viewport.gpu().executor.device(), [width, height]);
        self.viewport.resize(self.screen.size());
        let aspect = self.aspect();
        if let Some(shown) = self.shown.as_mut().filter(|shown| shown.is_framed)
            && let Some(camera) = shown.document.camera.camera(&shown.scene, aspect)
        {
            shown.camera = camera;
        }
    }

    /// Samples of a pixel at which the picture is done.
    #[wasm_bindgen(setter)]
    pub fn set_samples(&mut self, samples: u32) {
        self.samples = samples.max(1);
    }

    /// Which mouse people are used to: `ohif` or `slicer`.
    ///
    /// # Errors
    /// Where it is neither.
    #[wasm_bindgen(setter)]
    pub fn set_mouse(&mut self, name: &str) -> Result<(), JsError> {
        self.profile = match name {
            "ohif" => Profile::OHIF,
            "slicer" => Profile::SLICER,
            _ => return Err(wrong(format!("mouse is 'ohif' or 'slicer', not '{name}'"))),
        };
        Ok(())
    }

    /// Brings the picture further, and shows it.
    ///
    /// # Errors
    /// Why nothing is shown.
    pub fn frame(&mut self) -> Result<Told, JsError> {
        let Some(shown) = &self.shown else {
            return Ok(Told { samples: 0, part: 0.0, is_shown: false, rests: true });
        };
        let progress = self.viewport.frame(&Picture {
            scene: &shown.scene,
            version: self.version,
            camera: &shown.camera,
            display: &shown.document.display,
            samples: self.samples,
            seed: shown.document.film.seed,
        });
        let progress = progress.map_err(wrong)?;
        self.screen.show(self.viewport.gpu(), self.viewport.texture())?;
        Ok(Told {
            samples: progress.samples,
            part: progress.part,
            is_shown: progress.is_shown,
            rests: progress.rests,
        })
    }

    /// Drags with a button of a mouse, as the browser counts them: to the right and down, in heights of the view. Whether that does
    /// something.
    pub fn drag(&mut self, button: i16, shift: bool, command: bool, right: f64, down: f64) -> bool {
        let button = match button {
            0 => Button::Primary,
            1 => Button::Middle,
            2 => Button::Secondary,
            _ => return false,
        };
        let gesture = self.profile.gesture(button, Held { shift, command });
        gesture.is_some_and(|gesture| self.turn(|orbit| gesture.apply(orbit, [right, down])))
    }

    /// Turns the wheel, away from the hand: closer.
    pub fn wheel(&mut self, notches: f64) -> bool {
        self.turn(|orbit| Gesture::wheel(orbit, notches))
    }

    /// Two fingers: moved to the right and down in heights of the view, parted by a factor, turned in radians clockwise.
    pub fn fingers(&mut self, right: f64, down: f64, zoom: f64, turned: f64) -> bool {
        self.turn(|orbit| Gesture::fingers(orbit, [right, down], zoom, turned))
    }

    /// The camera around all there is to see: degrees around the vertical and above the horizon, and how many times closer than
    /// where everything fits.
    pub fn look(&mut self, azimuth: Option<f64>, elevation: Option<f64>, zoom: Option<f64>) {
        let aspect = self.aspect();
        if let Some(shown) = &mut self.shown {
            let fov = shown.document.camera.fov;
            let view = View { azimuth, elevation, zoom, fov, ..View::default() };
            if let Some(camera) = view.camera(&shown.scene, aspect) {
                (shown.document.camera, shown.camera, shown.is_framed) = (view, camera, true);
            }
        }
    }

    /// What is seen at a point, `(0, 0)` the top left and `(1, 1)` the bottom right corner: JSON; empty where hardly anything is.
    ///
    /// # Errors
    /// Never.
    pub fn pick(&self, x: f64, y: f64) -> Result<String, JsError> {
        let Some(shown) = &self.shown else { return Ok(String::new()) };
        let camera = shown.camera.with_aspect(self.aspect());
        let Some(picked) = pick(&shown.scene, &camera, [x, y]) else { return Ok(String::new()) };
        let told = serde_json::json!({
            "volume": picked.volume,
            "value": picked.value,
            "voxel": picked.voxel,
            "patient": picked.patient_mm.to_array(),
        });
        Ok(told.to_string())
    }

    /// The GPU's name, as far as the browser tells it.
    #[wasm_bindgen(getter)]
    pub fn gpu(&self) -> String {
        self.viewport.gpu().description.name.clone()
    }
}

impl Canvas {
    fn aspect(&self) -> f64 {
        let [width, height] = self.viewport.size();
        f64::from(width) / f64::from(height)
    }

    /// Changes the camera by what it turns around.
    fn turn(&mut self, change: impl FnOnce(&mut lumivox_core::Orbit)) -> bool {
        let Some(shown) = &mut self.shown else { return false };
        let mut orbit = orbit_of(&shown.camera, center_of(&shown.scene));
        change(&mut orbit);
        (shown.camera, shown.is_framed) = (orbit.camera(), false);
        true
    }

    /// Shows parts as a document says.
    fn follow(&mut self, document: &str, mut parts: Vec<Part>) -> Result<(), JsError> {
        let mut document = SceneDocument::parse_described(document).map_err(wrong)?;
        if document.volumes.is_empty() {
            document.volumes = parts.iter().map(|_| Entry::new(Written::default())).collect();
        }
        if document.volumes.len() != parts.len() {
            let (named, given) = (document.volumes.len(), parts.len());
            return Err(wrong(format!(
                "the scene has {named} volumes, and {given} scans were given for them"
            )));
        }
        for (entry, part) in document.volumes.iter_mut().zip(&mut parts) {
            if let Some(peel) = &mut part.peel {
                peel.mm = entry.peel.unwrap_or(0.0);
            }
            if entry.look.preset.is_none() && entry.look.transfer_function.is_none() {
                entry.look.preset = Some(Preset::default_for(&part.volume));
            }
        }
        if let Some(file) = document.environment.file() {
            let why = format!("the light {} is a file, which is not looked for here", file.display());
            return Err(wrong(why));
        }
        let scene = assemble(&document, parts.clone(), None).map_err(wrong)?;
        let camera = document.camera.camera(&scene, self.aspect());
        let camera = camera.ok_or_else(|| wrong("the camera is the point looked at"))?;
        let is_framed = document.camera.world_from_camera.is_none();
        let is_other = self.shown.as_ref().is_none_or(|shown| !scene.is_same(&shown.scene));
        self.version += u64::from(is_other);
        self.shown = Some(Shown { document, parts, scene, camera, is_framed });
        Ok(())
    }
}
