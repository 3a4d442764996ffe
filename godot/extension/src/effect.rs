//! How volumes are drawn into a viewport.

use godot::classes::compositor_effect::EffectCallbackType;
use godot::classes::rendering_server::CompositorEffectCallbackType;
use godot::classes::{CompositorEffect, ICompositorEffect, RenderingServer};
use godot::prelude::*;
use lumivox_core::document::{Display, Film};

use crate::render::Settings;
use crate::server::Lumivox;

/// Samples of an image that nobody said anything of.
const DEFAULT_SAMPLES: i64 = 512;

/// The most that are counted.
const MOST_SAMPLES: i64 = 65_536;

/// Draws the [LumivoxVolume3D]s of a scene, in the [Compositor] of a [WorldEnvironment] or a [Camera3D]. Scenes
/// without one are drawn with these defaults; add it to change them. Of several, the first that is enabled draws.
///
/// While the camera moves the image is made of the light that is kept in the volumes ([member kept_light]) and answers at once;
/// at rest it converges to [member target_samples] per pixel, or to [member target_noise], as much in each frame as fits into
/// [member frame_budget_ms].
///
/// Where [member CompositorEffect.enabled] is off, no volumes are drawn, and nothing is kept of their image: for
/// [method Lumivox.is_converged] and [method Lumivox.get_status] the viewport shows none.
///
/// Volumes follow the exposure of the scene's [CameraAttributes] as its lights and sky do, and [member exposure] besides.
///
/// They are drawn after opaque things and the sky, and before all that is transparent or looks at what is behind it:
/// refraction, and shaders with [code]hint_screen_texture[/code] or [code]hint_depth_texture[/code], see volumes. (With MSAA
/// in the Mobile renderer, the depth that shaders read has none: that renderer lends nothing to write it to.)
/// [member CompositorEffect.effect_callback_type] says so, and may be set to a later stage. Once a material with
/// subsurface scattering is loaded, they are drawn after its scattering, which would take them for skin; that is too late
/// for refraction. The Mobile renderer knows no such stage and draws them at the next, where refraction sees them.
///
/// Values beyond a setting's range become the nearest in it; what is no finite number is refused with an error.
#[derive(GodotClass)]
#[class(tool, base = CompositorEffect)]
pub struct LumivoxEffect {
    /// Brightens the volumes by so many stops: +1 doubles their light. From -64 to 64.
    #[export(range = (-10.0, 10.0, 0.01, or_less, or_greater, suffix = "EV"))]
    #[var(set)]
    exposure: f64,
    /// Samples per pixel after which the image is done and costs nothing more. Noise halves with four times as many.
    /// From 1 to 65536.
    #[export(range = (1.0, 65536.0, 1.0, exp))]
    #[var(set)]
    target_samples: i64,
    /// Noise at which the image is done before it has [member target_samples]: the error that is left, as a fraction of the
    /// brightness, 0 to 1. At 0.05 it is hardly seen. 0: by its samples alone. The samples are counted and fetched for it now
    /// and then, which costs a moment.
    #[export(range = (0.0, 0.5, 0.001, or_greater))]
    #[var(set)]
    target_noise: f64,
    /// Milliseconds of the GPU's time that tracing may take in a frame. More converges sooner and lowers the frame
    /// rate until it has. From 0.5 to 10000.
    #[export(range = (0.5, 100.0, 0.1, or_greater, suffix = "ms"))]
    #[var(set)]
    frame_budget_ms: f64,
    /// Pixels traced per pixel of the viewport along each side. Below 1 it converges sooner and is less sharp.
    /// From 0.1 to 1.
    #[export(range = (0.1, 1.0, 0.01))]
    #[var(set)]
    resolution_scale: f64,
    /// Writes the depth of volumes where they hide more than half of what is behind them: they hide transparent
    /// materials there, and shaders that read the depth, depth of field and later effects see them.
    #[export]
    #[var(set)]
    write_depth: bool,
    /// Filters the noise that is left out of the image at rest, until a pixel has 256 samples: what is shown is a little softer than
    /// the truth until then; the samples themselves never are. With [member kept_light] that is so anyway; there it counts for
    /// images that end before, by [member target_samples] or [member target_noise]. It changes nothing of what moves.
    #[export]
    #[var(set)]
    denoise: bool,
    /// Keeps light in the volumes, for clean pictures while something moves: light does not depend on the camera. At rest the
    /// image is the same with it and without. It takes memory of the GPU, at most a quarter of what the voxels take, and 48 bytes a
    /// pixel and more for the picture; where there is no room for it, nothing is kept (see [code]kept_light_bytes[/code] of
    /// [method Lumivox.get_status]). Without it the picture is coarse while something moves.
    #[export]
    #[var(set)]
    kept_light: bool,
    /// What lights the volumes besides the scene's lights. [constant ENVIRONMENT_SCENE]: the environment of the world
    /// or the camera. [constant ENVIRONMENT_STUDIO]: Lumivox' own studio light, whatever the scene's is.
    #[export(enum = (Scene, Studio))]
    #[var(set)]
    environment_source: i64,
    // Film and display of a scene file, which say more than these properties.
    #[var(rename = _document, get = _get_document, set = _set_document, usage_flags = [STORAGE, INTERNAL])]
    document: GString,
    base: Base<CompositorEffect>,
}

/// What a scene file says of its image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Image {
    pub film: Film,
    pub display: Display,
}

#[godot_api]
impl LumivoxEffect {
    /// The environment of the world or the camera lights the volumes.
    #[constant]
    pub const ENVIRONMENT_SCENE: i64 = 0;
    /// Lumivox' own studio light does.
    #[constant]
    pub const ENVIRONMENT_STUDIO: i64 = 1;

    #[func]
    fn set_exposure(&mut self, stops: f64) {
        if let Some(stops) = within("exposure", stops, self.exposure, [-64.0, 64.0]) {
            self.exposure = stops;
            self.request_redraw();
        }
    }

    #[func]
    fn set_target_samples(&mut self, samples: i64) {
        self.target_samples = samples.clamp(1, MOST_SAMPLES);
        self.request_redraw();
    }

    #[func]
    fn set_target_noise(&mut self, noise: f64) {
        if let Some(noise) = within("target_noise", noise, self.target_noise, [0.0, 1.0]) {
            self.target_noise = noise;
            self.request_redraw();
        }
    }

    #[func]
    fn set_frame_budget_ms(&mut self, milliseconds: f64) {
        if let Some(milliseconds) =
            within("frame_budget_ms", milliseconds, self.frame_budget_ms, [0.5, 10_000.0])
        {
            self.frame_budget_ms = milliseconds;
            self.request_redraw();
        }
    }

    #[func]
    fn set_resolution_scale(&mut self, scale: f64) {
        if let Some(scale) = within("resolution_scale", scale, self.resolution_scale, [0.1, 1.0]) {
            self.resolution_scale = scale;
            self.request_redraw();
        }
    }

    #[func]
    fn set_write_depth(&mut self, writes: bool) {
        self.write_depth = writes;
        self.request_redraw();
    }

    #[func]
    fn set_denoise(&mut self, filters: bool) {
        self.denoise = filters;
        self.request_redraw();
    }

    #[func]
    fn set_kept_light(&mut self, keeps: bool) {
        self.kept_light = keeps;
        self.request_redraw();
    }

    #[func]
    fn _get_document(&self) -> GString {
        self.document.clone()
    }

    #[func]
    fn _set_document(&mut self, text: GString) {
        self.document = text;
    }

    #[func]
    fn set_environment_source(&mut self, source: i64) {
        self.environment_source = source.clamp(Self::ENVIRONMENT_SCENE, Self::ENVIRONMENT_STUDIO);
        self.request_redraw();
    }
}

#[godot_api]
impl ICompositorEffect for LumivoxEffect {
    fn init(base: Base<CompositorEffect>) -> Self {
        let mut effect = base.to_init_gd();
        // Before the engine copies screen and depth for the materials that look at them.
        effect.set_effect_callback_type(EffectCallbackType::POST_SKY);
        // Primary rays end at one depth per pixel, whatever the antialiasing.
        effect.set_access_resolved_depth(true);
        Self {
            exposure: 0.0,
            target_samples: DEFAULT_SAMPLES,
            target_noise: 0.0,
            frame_budget_ms: 8.0,
            resolution_scale: 1.0,
            write_depth: true,
            denoise: false,
            kept_light: true,
            environment_source: Self::ENVIRONMENT_SCENE,
            document: GString::new(),
            base,
        }
    }
}

impl LumivoxEffect {
    /// Has the engine call the singleton in place of this effect: an effect may be freed while another thread draws,
    /// and then no call of it may be under way. To be said in each frame, since the engine names the effect again
    /// when its callback type is set, and tells nobody.
    pub fn draw_by_singleton(&self) {
        let base = self.base();
        let kind = CompositorEffectCallbackType::from_ord(base.get_effect_callback_type().ord());
        let draw = Lumivox::singleton().callable("_draw");
        RenderingServer::singleton().compositor_effect_set_callback(base.get_rid(), kind, &draw);
    }

    /// One that makes the image of a scene file.
    pub fn opened(image: &Image) -> Gd<Self> {
        let mut effect = Self::new_gd();
        {
            let mut this = effect.bind_mut();
            this.target_samples = samples(&image.film, this.target_samples);
            this.target_noise = image.film.noise.unwrap_or(0.0);
            this.denoise = image.film.denoise;
            let words = serde_json::json!({ "film": image.film, "display": image.display });
            this.document = GString::from(&words.to_string());
        }
        effect
    }

    /// The image that it makes: that of the scene file that it is of, but for what was changed since. Without one, that of
    /// scene files by default, and a display that brightens nothing.
    pub fn image(&self) -> Image {
        let mut image = self.said().unwrap_or_default();
        let film = &mut image.film;
        if self.said().is_none() || samples(film, DEFAULT_SAMPLES) != self.target_samples {
            film.samples = u32::try_from(self.target_samples).ok();
        }
        if film.noise.unwrap_or(0.0) != self.target_noise {
            // What a document has room for.
            film.noise = Some(self.target_noise.max(1e-4)).filter(|_| self.target_noise > 0.0);
        }
        film.denoise = self.denoise;
        image
    }

    fn said(&self) -> Option<Image> {
        let mut words: serde_json::Value = serde_json::from_str(&self.document.to_string()).ok()?;
        let mut part = |key: &str| words.get_mut(key).map(serde_json::Value::take);
        let film = serde_json::from_value(part("film")?).ok()?;
        Some(Image { film, display: serde_json::from_value(part("display")?).ok()? })
    }

    /// What it asks for.
    pub fn settings(&self) -> Settings {
        Settings {
            exposure: self.exposure.exp2(),
            ambient: [0.0; 3],
            target_samples: self.target_samples as u32,
            target_noise: self.target_noise,
            budget_milliseconds: self.frame_budget_ms,
            resolution_scale: self.resolution_scale,
            write_depth: self.write_depth,
            denoise: self.denoise,
            kept_light: self.kept_light,
        }
    }

    /// By how many stops it brightens volumes.
    pub fn stops(&self) -> f64 {
        self.exposure
    }

    /// Whether the scene's own environment lights the volumes.
    pub fn uses_scene_environment(&self) -> bool {
        self.environment_source == Self::ENVIRONMENT_SCENE
    }

    /// An engine that idles draws again.
    fn request_redraw(&self) {
        let base = self.base();
        // The cheapest change that the rendering server notices.
        RenderingServer::singleton().compositor_effect_set_enabled(base.get_rid(), base.get_enabled());
    }
}

/// Samples of a film, `usual` where it says none.
fn samples(film: &Film, usual: i64) -> i64 {
    film.samples.map_or(usual, |samples| i64::from(samples).min(MOST_SAMPLES))
}

/// A property's new value within its range; `None`, and an error, if it is no number.
fn within(property: &str, value: f64, before: f64, [low, high]: [f64; 2]) -> Option<f64> {
    if !value.is_finite() {
        godot_error!("LumivoxEffect.{property} must be a finite number, not {value}; it stays {before}.");
        return None;
    }
    Some(value.clamp(low, high))
}
