//! What the engine lends of one eye's picture: its camera, and the textures that volumes are drawn to.

use godot::classes::rendering_device::{DataFormat, TextureSamples};
use godot::classes::{RenderSceneBuffersRd, RenderSceneData, RenderingDevice};
use godot::prelude::*;
use lumivox_core::{Camera, HostCamera};
use lumivox_renderer::stage::{Lent, ViewFrame};
use lumivox_renderer::{Fog, HostDepth, HostFrame, HostVelocity, LiveSettings, Recording, ResourceId, Step};

use crate::convert;
use crate::executor::Executor;
use crate::render::Settings;

/// The scaling mode that brings its own temporal antialiasing.
const FSR2: i64 = 2;

/// Names of the engine's own textures.
const BUFFERS: &str = "render_buffers";
const VELOCITY: &str = "velocity";
const VELOCITY_MULTISAMPLED: &str = "velocity_msaa";

/// What half of an image is in the engine's velocities: all of it is 1, and y grows downwards.
const HALF: [f64; 2] = [0.5, 0.5];

/// One eye of one viewport, as the engine draws it in this frame.
pub struct HostView {
    host: HostCamera,
    /// Pixels that are drawn, before any scaling.
    size: [u32; 2],
    /// Resolved, for primary rays end at one depth per pixel.
    depth: Rid,
    /// What is drawn over; multisampled where the engine's is.
    color: Rid,
    /// Where volumes write their depth; multisampled where the engine's is.
    written_depth: Rid,
    /// What the engine makes of a multisampled `color`.
    resolved_color: Option<Rid>,
    /// Where it is kept how far what is seen has moved, if somebody looks at that.
    velocity: Option<Rid>,
    /// Whether the camera is shifted by part of a pixel in each frame.
    jittered: bool,
    light_per_color: f64,
}

impl HostView {
    /// `None` if there is nothing to draw to.
    pub fn new(
        device: &mut Gd<RenderingDevice>,
        buffers: &mut Gd<RenderSceneBuffersRd>,
        scene_data: &Gd<RenderSceneData>,
        view: u32,
    ) -> Option<Self> {
        let world_from_head = convert::affine(scene_data.get_cam_transform());
        // Its y points down, and depth is what the buffer holds.
        let clip_from_head = convert::matrix(scene_data.get_view_projection(view));
        let host = HostCamera::from_matrices(world_from_head, clip_from_head)?;
        let size = buffers.get_internal_size();
        if size.x <= 0 || size.y <= 0 {
            return None;
        }
        let multisampled = buffers.get_texture_samples() != TextureSamples::SAMPLES_1;
        let color = buffers.get_color_layer_ex(view).msaa(multisampled).done();
        Some(Self {
            host,
            size: [size.x as u32, size.y as u32],
            depth: buffers.get_depth_layer(view),
            color,
            written_depth: buffers.get_depth_layer_ex(view).msaa(multisampled).done(),
            resolved_color: multisampled.then(|| buffers.get_color_layer(view)),
            velocity: velocity(buffers, view),
            jittered: buffers.get_use_taa() || scaling_mode(buffers) == FSR2,
            light_per_color: light_per_color(device, color),
        })
    }

    /// What an effect's settings make of this picture, and what the renderer is to know of the textures.
    pub fn view_frame(&self, lent: Lent, settings: &Settings, fog: Option<Fog>) -> ViewFrame {
        ViewFrame::new(
            self.camera(),
            self.live_settings(settings),
            self.frame(lent, settings.write_depth, fog),
            settings.budget_milliseconds,
        )
    }

    fn live_settings(&self, settings: &Settings) -> LiveSettings {
        let [width, height] = self.size;
        LiveSettings::new(width, height).with(|it| {
            it.resolution_scale = settings.resolution_scale;
            it.target_samples = settings.target_samples;
            it.target_noise = settings.target_noise;
            it.exposure = settings.exposure * self.light_per_color;
            it.ambient = settings.ambient;
            it.denoise = settings.denoise;
            it.kept_light = settings.kept_light;
        })
    }

    /// The camera that is traced from.
    fn camera(&self) -> Camera {
        if self.jittered { self.host.camera.without_jitter(self.size) } else { self.host.camera }
    }

    fn frame(&self, lent: Lent, write_depth: bool, fog: Option<Fog>) -> HostFrame {
        HostFrame::new(lent.color)
            .with_depth(
                HostDepth::new(lent.depth, self.host.view_depth_from_ndc, 0.0).with_jitter(self.jittered),
            )
            .with_depth_target(write_depth.then_some(lent.written_depth))
            .with_velocity(
                self.velocity.filter(|_| write_depth).map(|_| HostVelocity::new(lent.velocity, HALF)),
            )
            .with_fog(fog.map(|fog| Fog { color: fog.color.map(|c| c * self.light_per_color), ..fog }))
    }

    /// Hands the textures over, for this frame.
    pub fn lend(&self, executor: &mut Executor, lent: Lent) {
        executor.lend(lent.depth, self.depth);
        executor.lend(lent.color, self.color);
        executor.lend(lent.written_depth, self.written_depth);
        if let Some(color) = self.resolved_color {
            executor.lend(lent.resolved_color, color);
        }
        if let Some(velocity) = self.velocity {
            executor.lend(lent.velocity, velocity);
        }
    }

    /// Repeats what was drawn into a multisampled colour in what it is resolved to. The engine resolves before this, and
    /// copies the outcome for materials that look at what is behind them. Blending and averaging samples are both linear:
    /// it is what resolving once more would give. A resolved depth cannot be drawn to: see
    /// [`depth_to_store`](Self::depth_to_store).
    pub fn draw_resolved_too(&self, lent: Lent, recording: &mut Recording) {
        if self.resolved_color.is_none() {
            return;
        }
        let again: Vec<Step> = recording.steps.iter().filter_map(|step| resolved(lent, step)).collect();
        recording.steps.extend(again);
    }

    /// The depth that is drawn into a multisampled one, and that the resolved one is to have, too.
    pub fn depth_to_store(&self, lent: Lent, recording: &Recording) -> Option<ResourceId> {
        self.resolved_color?;
        recording.steps.iter().find_map(|step| drawn_depth(lent, step))
    }
}

/// Where the engine keeps how far what is seen has moved: where that is multisampled, it is resolved when volumes are drawn.
fn velocity(buffers: &mut Gd<RenderSceneBuffersRd>, view: u32) -> Option<Rid> {
    if buffers.has_texture(BUFFERS, VELOCITY_MULTISAMPLED) {
        return Some(buffers.get_velocity_layer_ex(view).msaa(true).done());
    }
    buffers.has_texture(BUFFERS, VELOCITY).then(|| buffers.get_velocity_layer(view))
}

/// What is drawn into a multisampled depth: one for each pixel.
fn drawn_depth(lent: Lent, step: &Step) -> Option<ResourceId> {
    match step {
        Step::Draw { resources, target, .. } if *target == lent.written_depth => resources.first().copied(),
        _ => None,
    }
}

/// A step that draws into a multisampled colour, with the resolved one in its place.
fn resolved(lent: Lent, step: &Step) -> Option<Step> {
    match step {
        Step::Draw { kernel, uniforms, resources, target } if *target == lent.color => Some(Step::Draw {
            kernel: *kernel,
            uniforms: uniforms.clone(),
            resources: resources.clone(),
            target: lent.resolved_color,
        }),
        _ => None,
    }
}

/// Whether the engine goes on with meshes after the sky: where there is skin, its renderer scatters the colours whose
/// alpha says so, and adds what all meshes reflect. Both would happen to volumes that were drawn by then.
pub fn goes_on_with_meshes(buffers: &mut Gd<RenderSceneBuffersRd>) -> bool {
    buffers.has_texture("forward_clustered", "specular")
}

/// What the engine draws light of 1 as: the Mobile renderer's colours end at 1, and it halves light to keep some above
/// white.
fn light_per_color(device: &mut Gd<RenderingDevice>, color: Rid) -> f64 {
    match device.texture_get_format(color).map(|format| format.get_format()) {
        Some(DataFormat::A2B10G10R10_UNORM_PACK32) => 0.5,
        _ => 1.0,
    }
}

/// The engine's answer where nothing is scaled is none of its enum: it is asked without one.
fn scaling_mode(buffers: &mut Gd<RenderSceneBuffersRd>) -> i64 {
    buffers.call("get_scaling_3d_mode", &[]).try_to().unwrap_or_default()
}
