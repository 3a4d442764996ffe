//! How volumes are drawn into a viewport.

use godot::classes::compositor_effect::EffectCallbackType;
use godot::classes::rendering_server::CompositorEffectCallbackType;
use godot::classes::{CompositorEffect, ICompositorEffect, RenderingServer};
use godot::prelude::*;

use crate::render::Settings;
use crate::server::Lumivox;

/// Draws the [LumivoxVolume3D]s of a scene, in the [Compositor] of a [WorldEnvironment] or a [Camera3D]. Scenes
/// without one are drawn with these defaults; add it to change them. Of several, the first that is enabled draws.
///
/// While the camera moves the image is coarse and answers at once; at rest it converges to
/// [member target_samples] per pixel, as much in each frame as fits into [member frame_budget_ms].
///
/// Where [member CompositorEffect.enabled] is off, no volumes are drawn, and nothing is kept of their image: for
/// [method Lumivox.is_converged] and [method Lumivox.get_status] the viewport shows none.
///
/// Volumes follow the exposure of the scene's [CameraAttributes] as its lights and sky do, and [member exposure] besides.
#[derive(GodotClass)]
#[class(tool, base = CompositorEffect)]
pub struct LumivoxEffect {
    /// Brightens the volumes by so many stops: +1 doubles their light.
    #[export(range = (-10.0, 10.0, 0.01, or_less, or_greater))]
    exposure: f64,
    /// Samples per pixel after which the image is done and costs nothing more. Noise halves with four times as many.
    #[export(range = (1.0, 65536.0, 1.0, exp))]
    target_samples: i64,
    /// Milliseconds of the GPU's time that tracing may take in a frame. More converges sooner and lowers the frame
    /// rate until it has.
    #[export(range = (0.5, 100.0, 0.1, or_greater))]
    frame_budget_ms: f64,
    /// Pixels traced per pixel of the viewport along each side. Below 1 it converges sooner and is less sharp.
    #[export(range = (0.1, 1.0, 0.01))]
    resolution_scale: f64,
    /// Writes the depth of volumes, so that transparent materials, fog and later effects see them.
    #[export]
    write_depth: bool,
    /// Filters the noise out of the image while it converges. What is shown is biased (softer than the truth) until a
    /// pixel has 256 samples; the samples themselves never are.
    #[export]
    denoise: bool,
    /// What lights the volumes besides the scene's lights. Scene: the environment of the world
    /// or the camera. Studio: Lumivox' own studio light, whatever the scene's is.
    #[export(enum = (Scene, Studio))]
    environment_source: i64,
    base: Base<CompositorEffect>,
}

#[godot_api]
impl ICompositorEffect for LumivoxEffect {
    fn init(base: Base<CompositorEffect>) -> Self {
        let mut effect = base.to_init_gd();
        effect.set_effect_callback_type(EffectCallbackType::PRE_TRANSPARENT);
        // Primary rays end at one depth per pixel, whatever the antialiasing.
        effect.set_access_resolved_depth(true);
        Self {
            exposure: 0.0,
            target_samples: 512,
            frame_budget_ms: 8.0,
            resolution_scale: 1.0,
            write_depth: true,
            denoise: false,
            environment_source: 0,
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

    /// What it asks for.
    pub fn settings(&self) -> Settings {
        Settings {
            exposure: self.exposure.clamp(-64.0, 64.0).exp2(),
            target_samples: self.target_samples.clamp(1, 1 << 20) as u32,
            budget_milliseconds: self.frame_budget_ms.clamp(0.1, 10_000.0),
            resolution_scale: self.resolution_scale,
            write_depth: self.write_depth,
            denoise: self.denoise,
        }
    }

    /// Whether the scene's own environment lights the volumes.
    pub fn uses_scene_environment(&self) -> bool {
        self.environment_source == 0
    }
}
