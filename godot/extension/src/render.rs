//! The render thread's side: what the stage records, replayed on the engine's device, one frame of a viewport at a time.

use std::collections::HashMap;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use godot::classes::{RenderData, RenderSceneBuffersRd, RenderSceneData, RenderingDevice, RenderingServer};
use godot::prelude::*;
use lumivox_renderer::recording::{Kernel, Step, TextureOrder};
use lumivox_renderer::stage::{self, Recorded, Refusal, Shown, ViewRecorded, Workbench, WorldState};
use lumivox_renderer::{LiveStatus, RenderError, ViewKind};

use crate::executor::{ExecuteError, Executor, make_ahead, workshop};
use crate::host_view::{self, HostView};
use crate::shared::{self, Status, Target, WorldKey};

/// Begins the names of captured times.
const TIMED: &str = "lumivox";

/// Milliseconds of the GPU's time after which a picture that is traced in one frame waits for the device: drivers end what
/// takes seconds.
const WHOLE_STEP_MILLISECONDS: f64 = 100.0;

/// What an effect asks for, with what the camera adds.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Multiplies the light.
    pub exposure: f64,
    /// Radiance from everywhere besides that of the scene: what no exposure changes, before this one.
    pub ambient: [f64; 3],
    /// Samples per pixel after which an image is done.
    pub target_samples: u32,
    /// Noise at which it is done before; 0: by its samples alone.
    pub target_noise: f64,
    /// Milliseconds of the GPU's time in a frame.
    pub budget_milliseconds: f64,
    /// Pixels traced per pixel of the viewport along a side.
    pub resolution_scale: f64,
    /// Whether volumes write their depth.
    pub write_depth: bool,
    /// Whether noise is filtered out of what is shown at rest.
    pub denoise: bool,
    /// Whether light is kept in the volumes, for what moves.
    pub kept_light: bool,
}

/// A render target and the eye.
type EyeKey = (Rid, u32);

type Stage = stage::Stage<WorldKey, EyeKey>;

/// Kernels and textures made on other threads.
struct Ahead;

impl Workbench for Ahead {
    fn are_ready(&self, kernels: &[Kernel]) -> bool {
        let is_missing = |kernel: &Kernel| !workshop().is_ready(*kernel);
        let missing: Vec<Kernel> = kernels.iter().copied().filter(is_missing).collect();
        workshop().hurry(missing.iter().copied());
        missing.is_empty()
    }

    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send> {
        Box::new(make_ahead)
    }
}

/// Everything on the GPU.
#[derive(Default)]
struct Renderer {
    executor: Executor,
    /// There is one once something was drawn.
    stage: Option<Stage>,
    /// What comes back of the stage's recordings, by ticket, in the order of their steps.
    read_backs: Vec<(u64, Receiver<Vec<u8>>)>,
    timed_frame: u64,
    /// Whether it was said that paths are cut short.
    said_lost: bool,
}

static RENDERER: LazyLock<Mutex<Renderer>> = LazyLock::new(Mutex::default);

/// The renderer, in whatever state.
fn renderer() -> MutexGuard<'static, Renderer> {
    RENDERER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Draws the volumes of a viewport. Called by the engine while it draws that viewport, at a stage of that.
pub fn draw(stage: i32, data: &Gd<RenderData>) {
    let Some(buffers) = data.get_render_scene_buffers() else { return };
    let Ok(mut buffers) = buffers.try_cast::<RenderSceneBuffersRd>() else { return };
    let Some(scene_data) = data.get_render_scene_data() else { return };
    let Some(mut device) = RenderingServer::singleton().get_rendering_device() else { return };
    if stage < shared::last_stage() && host_view::goes_on_with_meshes(&mut buffers) {
        return;
    }
    let target = buffers.get_render_target();
    let Some(shown) = shared::lock().begin(target, stage) else { return };
    // After a panic, which was reported, nothing is drawn any more rather than the same panic again.
    let Ok(mut renderer) = RENDERER.lock() else { return };
    let drawn = renderer.draw(&mut device, &shown, &mut buffers, &scene_data);
    // What an eye left, perhaps nobody else looks at.
    if renderer.stage.as_ref().is_some_and(Stage::wants_sweep) {
        let worlds = shared::lock().worlds();
        renderer.sweep(&mut device, &worlds);
    }
    drop(renderer);
    let mut shared = shared::lock();
    match drawn {
        Ok(Some(status)) => {
            shared.wants_frame |= !status.converged;
            shared.awaits_feedback |= status.converged && status.awaits_feedback;
            shared.statuses.insert(target, status);
        }
        Ok(None) => {}
        Err(error) => {
            shared.error = Some(error);
            shared.statuses.remove(&target);
        }
    }
}

/// Waits for what comes back of the frames drawn, and learns whether their images are done after all: an engine that
/// idles draws no more, and what comes back would never arrive. On the render thread.
pub fn settle() {
    let Some(mut device) = RenderingServer::singleton().get_rendering_device() else { return };
    let scenes: HashMap<Rid, (WorldKey, u64)> = shared::lock()
        .targets
        .iter()
        .map(|(rid, target)| (*rid, (target.snapshot.key, target.snapshot.version)))
        .collect();
    let Ok(mut renderer) = RENDERER.lock() else { return };
    renderer.executor.finish(&mut device);
    renderer.take_read_backs();
    let Some(stage) = &renderer.stage else { return };
    let mut statuses: HashMap<Rid, LiveStatus> = HashMap::new();
    for (target, (key, version)) in scenes {
        // While it shows the scene before, which counts for nothing.
        if !stage.holds(key, version) {
            continue;
        }
        let eyes = (0..).map_while(|view| stage.view_progress((target, view), key));
        let all = eyes.map(|eye| eye.live).reduce(|mut all, eye| {
            all.samples = all.samples.min(eye.samples);
            all.progress = all.progress.min(eye.progress);
            all.converged &= eye.converged;
            all
        });
        statuses.extend(all.map(|all| (target, all)));
    }
    drop(renderer);
    let mut shared = shared::lock();
    for (target, live) in statuses {
        let Some(status) = shared.statuses.get_mut(&target) else { continue };
        (status.samples, status.converged, status.awaits_feedback) = (live.samples, live.converged, false);
        status.progress = live.progress;
        shared.wants_frame |= !live.converged;
    }
}

/// Frees what no viewport shows any more. On the render thread.
pub fn sweep() {
    let Some(mut device) = RenderingServer::singleton().get_rendering_device() else { return };
    let shown = shared::lock().worlds();
    renderer().sweep(&mut device, &shown);
}

/// How often a scene's update computed something that takes long, and how many frames showed a scene's predecessor for
/// want of a kernel.
pub fn stalls() -> [u64; 2] {
    renderer().stage.as_ref().map_or([0, 0], Stage::stalls)
}

/// Frees everything. On the render thread.
pub fn free() {
    let Some(mut device) = RenderingServer::singleton().get_rendering_device() else { return };
    let mut renderer = renderer();
    renderer.sweep(&mut device, &HashMap::new());
    renderer.stage = None;
    renderer.read_backs.clear();
    shared::lock().store = None;
    renderer.executor.free(&mut device);
}

impl Renderer {
    fn draw(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        target: &Target,
        buffers: &mut Gd<RenderSceneBuffersRd>,
        scene_data: &Gd<RenderSceneData>,
    ) -> Result<Option<Status>, String> {
        self.read_times(device);
        self.take_read_backs();
        let drawn = self.draw_eyes(device, target, buffers, scene_data);
        // After an error, nothing may follow for long.
        let rest = self.stage.as_mut().and_then(Stage::left_over);
        self.free_with(device, rest);
        drawn
    }

    fn draw_eyes(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        target: &Target,
        buffers: &mut Gd<RenderSceneBuffersRd>,
        scene_data: &Gd<RenderSceneData>,
    ) -> Result<Option<Status>, String> {
        self.update_world(device, target)?;
        let key = target.snapshot.key;
        let stage = self.stage(device);
        let progress = stage.world_state(key);
        // Another environment or other layers make another world. That may be seen a little longer, another scenario not.
        let first = (buffers.get_render_target(), 0);
        let shown = stage.shown(first, key, |before| before.scenario == key.scenario);
        let pending = Status { target: target.settings.target_samples, ..Status::default() };
        let Some(shown) = shown else { return Ok(Some(pending)) };
        let views = buffers.get_view_count();
        let budget_milliseconds = target.settings.budget_milliseconds / f64::from(views);
        let kept_light = target.keeps_light();
        let settings = Settings { budget_milliseconds, kept_light, ..target.settings };
        let mut status = Status { converged: true, samples: u32::MAX, progress: 1.0, ..Status::default() };
        for view in 0..views {
            let key = (buffers.get_render_target(), view);
            let Some(host) = HostView::new(device, buffers, scene_data, view) else { return Ok(None) };
            if target.at_once {
                self.trace_whole(device, &settings, target, shown, &host, key)?;
            }
            let eye = self.draw_eye(device, &settings, target, shown, &host, key)?;
            status.samples = status.samples.min(eye.samples);
            status.converged &= eye.converged;
            status.progress = status.progress.min(eye.progress);
            status.awaits_feedback |= eye.awaits_feedback;
            status.pixel_samples += eye.pixel_samples;
            status.light_bytes += eye.light_bytes;
            // The picture stays: it is the best there is.
            if eye.lost_pixels > 0 && !std::mem::replace(&mut self.said_lost, true) {
                let error = RenderError::SamplesLost { pixels: eye.lost_pixels };
                shared::lock().error = Some(error.to_string());
            }
            status.milliseconds += self.stage(device).view_milliseconds(key);
        }
        status.target = settings.target_samples;
        status.arrived = progress == WorldState::Done;
        status.converged &= status.arrived;
        // An image of the scene before counts for nothing.
        Ok(Some(if matches!(progress, WorldState::Done | WorldState::Arriving) { status } else { pending }))
    }

    /// Brings a scene's copy on the GPU up to date. One that does not fit is an error until it changes.
    fn update_world(&mut self, device: &mut Gd<RenderingDevice>, target: &Target) -> Result<(), String> {
        let snapshot = &*target.snapshot;
        let frame = shared::lock().frame;
        let stage = self.stage(device);
        stage.begin_frame(frame);
        let view = ViewKind::Live { guides: false, kept_light: target.keeps_light() };
        stage.expect(snapshot.key, view);
        let updated =
            stage.update(snapshot.key, &snapshot.scene, snapshot.version, target.at_once, &Ahead)?;
        updated.map_or(Ok(()), |recorded| self.replay(device, recorded))
    }

    /// Traces one eye's picture until it is done, however long that takes: no other frame will. Nothing of it is drawn.
    fn trace_whole(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        settings: &Settings,
        target: &Target,
        shown: Shown<WorldKey>,
        host: &HostView,
        key: EyeKey,
    ) -> Result<(), String> {
        let budget_milliseconds = settings.budget_milliseconds.max(WHOLE_STEP_MILLISECONDS);
        let settings = Settings { budget_milliseconds, ..*settings };
        let mut idle = 0;
        // What comes back may open pixels again, or find some that are short: done is what stays so.
        while idle < 2 {
            let frame = |lent| host.view_frame(lent, &settings, target.fog);
            let ViewRecorded { mut recorded, status, lent } =
                self.stage(device).record_view(key, shown, frame)?;
            recorded.recording.steps.retain(|step| !matches!(step, Step::Draw { .. }));
            host.lend(&mut self.executor, lent);
            self.replay(device, recorded)?;
            self.executor.finish(device);
            self.take_read_backs();
            let done = self.stage(device).view_progress(key, target.snapshot.key);
            let is_done = done.is_some_and(|done| done.live.converged && !done.live.awaits_feedback);
            idle = if is_done || status.pixel_samples == 0 { idle + 1 } else { 0 };
        }
        Ok(())
    }

    /// Draws the volumes of what is `shown` into one eye's picture.
    fn draw_eye(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        settings: &Settings,
        target: &Target,
        shown: Shown<WorldKey>,
        host: &HostView,
        key: EyeKey,
    ) -> Result<LiveStatus, String> {
        let frame = |lent| host.view_frame(lent, settings, target.fog);
        let ViewRecorded { mut recorded, status, lent } =
            self.stage(device).record_view(key, shown, frame)?;
        host.draw_resolved_too(lent, &mut recorded.recording);
        let depth = host.depth_to_store(lent, &recorded.recording);
        host.lend(&mut self.executor, lent);
        self.replay(device, recorded)?;
        if let Some(depth) = depth {
            let stored = self.executor.store_resolved_depth(device, depth, lent.depth);
            stored.map_err(|error| error.to_string())?;
        }
        Ok(status)
    }

    fn stage(&mut self, device: &Gd<RenderingDevice>) -> &mut Stage {
        self.stage.get_or_insert_with(|| {
            let stage = Stage::new(Executor::limits(device));
            shared::lock().store = Some(stage.store().clone());
            stage
        })
    }

    /// Hands a recording to the device, and tells the stage what became of it.
    fn replay(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        recorded: Recorded<WorldKey, EyeKey>,
    ) -> Result<(), String> {
        let ticket = recorded.ticket();
        let replayed = self.executor.execute(device, &recorded.recording, &format!("{TIMED} {ticket}"));
        let outcome = match replayed {
            Ok(read_backs) => {
                self.read_backs.extend(read_backs.into_iter().map(|read_back| (ticket, read_back)));
                Ok(())
            }
            Err(error) => {
                self.executor.discard(device, &recorded.recording);
                let why = error.to_string();
                Err(match error {
                    ExecuteError::Memory { .. } => Refusal::Memory(why),
                    ExecuteError::Kernel { .. } | ExecuteError::Fault(_) => Refusal::Other(why),
                })
            }
        };
        Ok(self.stage(device).executed(recorded, outcome)?)
    }

    /// Replays what nothing depends on.
    fn free_with(&mut self, device: &mut Gd<RenderingDevice>, recorded: Option<Recorded<WorldKey, EyeKey>>) {
        if let Some(recorded) = recorded {
            // Freeing never fails.
            let _ = self.replay(device, recorded);
        }
    }

    /// Hands over what has come back from the GPU.
    fn take_read_backs(&mut self) {
        let Some(stage) = &mut self.stage else { return };
        self.read_backs.retain(|(ticket, read_back)| match read_back.try_recv() {
            Ok(bytes) => {
                stage.feedback(*ticket, &bytes);
                false
            }
            Err(TryRecvError::Empty) => true,
            Err(TryRecvError::Disconnected) => {
                stage.feedback(*ticket, &[]);
                false
            }
        });
    }

    /// Tells views what their frames took.
    fn read_times(&mut self, device: &Gd<RenderingDevice>) {
        let frame = device.get_captured_timestamps_frame();
        if frame == self.timed_frame {
            return;
        }
        self.timed_frame = frame;
        let Some(stage) = &mut self.stage else { return };
        let mut begun = HashMap::new();
        for i in 0..device.get_captured_timestamps_count() {
            let name = device.get_captured_timestamp_name(i).to_string();
            let mut words = name.split(' ');
            if words.next() != Some(TIMED) {
                continue;
            }
            let Some(ticket) = words.next().and_then(|word| word.parse::<u64>().ok()) else { continue };
            let time = device.get_captured_timestamp_gpu_time(i);
            match (words.next(), begun.get(&ticket)) {
                (Some("begin"), _) => {
                    begun.insert(ticket, time);
                }
                (Some("end"), Some(begin)) => {
                    let milliseconds = time.saturating_sub(*begin) as f64 * 1e-6;
                    stage.measured(ticket, milliseconds);
                }
                _ => {}
            }
        }
    }

    fn sweep(&mut self, device: &mut Gd<RenderingDevice>, shown: &HashMap<Rid, WorldKey>) {
        let Some(stage) = &mut self.stage else { return };
        let swept = stage.sweep(
            |(target, _)| shown.contains_key(target),
            |world| shown.values().any(|shown| shown == world),
        );
        self.free_with(device, swept);
    }
}
