//! The render thread's side: scenes and films on the GPU, one frame of a viewport at a time.

use std::collections::HashMap;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use godot::classes::{RenderData, RenderSceneBuffersRd, RenderSceneData, RenderingDevice, RenderingServer};
use godot::prelude::*;
use lumivox_core::Camera;
use lumivox_renderer::pacing::{Pacer, Pass};
use lumivox_renderer::recording::Kernel;
use lumivox_renderer::{
    Fog, LiveSettings, LiveStatus, LiveView, Recording, RenderError, SceneCache, Step, ViewKind, VoxelStore,
};

use crate::executor::{ExecuteError, Executor, make_ahead, workshop};
use crate::host_view::{self, HostView, Lent};
use crate::shared::{self, Snapshot, Status, Target, WorldKey};
use crate::uploads::Uploads;

/// Begins the names of captured times.
const TIMED: &str = "lumivox";

/// What an effect asks for, with what the camera adds.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Multiplies the light.
    pub exposure: f64,
    /// Radiance from everywhere besides that of the scene: what no exposure changes, before this one.
    pub ambient: [f64; 3],
    /// Samples per pixel after which an image is done.
    pub target_samples: u32,
    /// Milliseconds of the GPU's time in a frame.
    pub budget_milliseconds: f64,
    /// Pixels traced per pixel of the viewport along a side.
    pub resolution_scale: f64,
    /// Whether volumes write their depth.
    pub write_depth: bool,
    /// Whether noise is filtered out of what is shown.
    pub denoise: bool,
}

/// A scene on the GPU.
struct World {
    cache: SceneCache,
    /// The snapshot that it holds; one that does not fit is not tried again.
    version: u64,
    /// Why it does not fit.
    error: Option<String>,
    /// Whether there is anything to draw: a scene that fits.
    whole: bool,
    /// What is prepared for the next scene, on another thread that holds the same.
    preparing: Option<Arc<()>>,
}

/// How far a scene's copy is.
#[derive(Clone, Copy, PartialEq)]
enum Update {
    Done,
    /// It is there, but for finer voxels that are on their way.
    Arriving,
    /// The one before is there while something is prepared for the next.
    Before,
    /// Nothing is there yet.
    Nothing,
}

/// What a scene waits for.
#[derive(PartialEq)]
enum Missing {
    Kernels,
    /// Of its volumes or its environment.
    Computation,
}

/// One eye of one viewport.
struct Eye {
    live: LiveView,
    pacer: Pacer,
    /// What was traced last: another one is a new image.
    traced: Option<(Camera, u64, [u32; 2], [f64; 3])>,
    /// When the last frame began, unless it was done then and the engine may have idled since.
    began: Option<Instant>,
    read_backs: Vec<Receiver<Vec<u8>>>,
    lent: Lent,
    world: WorldKey,
}

/// A frame of an eye, as it was recorded.
#[derive(Clone, Copy)]
struct Frame {
    status: LiveStatus,
    pass: Pass,
    /// Pixel samples that were granted for `milliseconds`.
    budget: u64,
    milliseconds: f64,
}

/// A render target and the eye.
type EyeKey = (Rid, u32);

/// Everything on the GPU.
#[derive(Default)]
struct Renderer {
    executor: Executor,
    store: Option<VoxelStore>,
    uploads: Uploads,
    worlds: HashMap<WorldKey, World>,
    eyes: HashMap<EyeKey, Eye>,
    serial: u64,
    timed_frame: u64,
    /// See [`stalls`].
    computed: u64,
    postponed: u64,
    /// Whether an eye left a world that nobody else may look at.
    turned: bool,
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
    if std::mem::take(&mut renderer.turned) {
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
    let Renderer { executor, eyes, worlds, .. } = &mut *renderer;
    executor.finish(&mut device);
    let mut statuses: HashMap<Rid, LiveStatus> = HashMap::new();
    for ((target, _), eye) in eyes {
        eye.take_read_backs();
        // While it shows the scene before, which counts for nothing.
        let scene = scenes.get(target).and_then(|(key, version)| Some((worlds.get(key)?, *version)));
        if scene.is_none_or(|(world, version)| world.version != version) {
            continue;
        }
        let status = eye.live.status();
        let all = statuses.entry(*target).or_insert(status);
        all.samples = all.samples.min(status.samples);
        all.converged &= status.converged;
    }
    drop(renderer);
    let mut shared = shared::lock();
    for (target, live) in statuses {
        let Some(status) = shared.statuses.get_mut(&target) else { continue };
        (status.samples, status.converged, status.awaits_feedback) = (live.samples, live.converged, false);
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
    let renderer = renderer();
    [renderer.computed, renderer.postponed]
}

/// Frees everything. On the render thread.
pub fn free() {
    let Some(mut device) = RenderingServer::singleton().get_rendering_device() else { return };
    let mut renderer = renderer();
    renderer.sweep(&mut device, &HashMap::new());
    renderer.store = None;
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
        self.collect(device);
        let update = self.update_world(device, target)?;
        let pending = Status { target: target.settings.target_samples, ..Status::default() };
        let views = buffers.get_view_count();
        let world = match update {
            Update::Nothing => self.world_before(buffers.get_render_target(), target.snapshot.key),
            Update::Done | Update::Arriving | Update::Before => Some(target.snapshot.key),
        };
        let Some(world) = world else { return Ok(Some(pending)) };
        let budget_milliseconds = target.settings.budget_milliseconds / f64::from(views);
        let settings = Settings { budget_milliseconds, ..target.settings };
        let mut status = Status { converged: true, samples: u32::MAX, ..Status::default() };
        for view in 0..views {
            let key = (buffers.get_render_target(), view);
            let Some(host) = HostView::new(device, buffers, scene_data, view) else { return Ok(None) };
            let Some(eye) = self.draw_eye(device, settings, target, world, &host, key)? else {
                return Ok(None);
            };
            status.samples = status.samples.min(eye.samples);
            status.converged &= eye.converged;
            status.awaits_feedback |= eye.awaits_feedback;
            status.pixel_samples += eye.pixel_samples;
            // The picture stays: it is the best there is.
            if eye.lost_pixels > 0 && !std::mem::replace(&mut self.said_lost, true) {
                let error = RenderError::SamplesLost { pixels: eye.lost_pixels };
                shared::lock().error = Some(error.to_string());
            }
            if let Some(eye) = self.eyes.get(&key) {
                status.milliseconds += eye.pacer.milliseconds();
            }
        }
        status.target = settings.target_samples;
        status.converged &= update == Update::Done;
        // An image of the scene before counts for nothing.
        Ok(Some(if matches!(update, Update::Done | Update::Arriving) { status } else { pending }))
    }

    /// What a viewport showed last of a scenario, while nothing is there yet of what it is to show: another environment
    /// or other layers make another world.
    fn world_before(&self, target: Rid, key: WorldKey) -> Option<WorldKey> {
        let before = self.eyes.get(&(target, 0))?.world;
        let is_alike = before.scenario == key.scenario;
        let is_whole = self.worlds.get(&before).is_some_and(|world| world.whole);
        (is_alike && is_whole).then_some(before)
    }

    /// Brings a scene's copy on the GPU up to date, once all that takes long is prepared; until then the one before
    /// goes on. One that does not fit is an error until it changes.
    fn update_world(&mut self, device: &mut Gd<RenderingDevice>, target: &Target) -> Result<Update, String> {
        let snapshot = &*target.snapshot;
        let store = self.store(device);
        let world = self.worlds.entry(snapshot.key).or_insert_with(|| World::new(&store));
        let is_another = world.version != snapshot.version;
        if !is_another && (world.error.is_some() || world.cache.is_settled()) {
            return world.error.clone().map_or(Ok(Update::Done), Err);
        }
        if is_another
            && !target.at_once
            && let Some(missing) = world.unprepared(snapshot)
        {
            self.postponed += u64::from(missing == Missing::Kernels);
            return Ok(if world.whole { Update::Before } else { Update::Nothing });
        }
        world.version = snapshot.version;
        let mut recording = Recording::new();
        let computed = world.cache.unprepared();
        let granted = if target.at_once { u64::MAX } else { self.uploads.budget(shared::lock().frame) };
        let (mut budget, began) = (granted, Instant::now());
        let updated = world.cache.update_within(&snapshot.scene, &mut budget, &mut recording);
        self.computed += world.cache.unprepared() - computed;
        let settled = world.cache.is_settled();
        let mut error = updated.err().map(|error| error.to_string());
        // Also after an error: that room was made may be recorded.
        match self.executor.execute(device, &recording, TIMED) {
            Ok(_) => {
                if granted < u64::MAX {
                    let took = began.elapsed().as_secs_f64() * 1e3;
                    self.uploads.took(granted - budget, granted, took);
                }
            }
            Err(refused) => {
                self.executor.discard(device, &recording);
                let may_come_reduced = store.refused(&recording);
                self.forget_world(device, snapshot.key);
                let is_memory = matches!(refused, ExecuteError::Memory { .. });
                if is_memory && may_come_reduced {
                    // It comes reduced, in the next frame.
                    return Ok(Update::Nothing);
                }
                error = Some(refused.to_string());
            }
        }
        if let Some(world) = self.worlds.get_mut(&snapshot.key) {
            world.version = snapshot.version;
            world.error.clone_from(&error);
            world.whole = error.is_none();
        }
        let done = if settled { Update::Done } else { Update::Arriving };
        error.map_or(Ok(done), Err)
    }

    /// Frees voxels that nobody holds any more.
    fn collect(&mut self, device: &mut Gd<RenderingDevice>) {
        let Some(store) = &self.store else { return };
        let mut recording = Recording::new();
        store.collect(&mut recording);
        // Freeing never fails.
        let _ = self.executor.execute(device, &recording, TIMED);
    }

    fn store(&mut self, device: &Gd<RenderingDevice>) -> VoxelStore {
        let store = self.store.get_or_insert_with(|| VoxelStore::new(Executor::limits(device)));
        shared::lock().store.get_or_insert_with(|| store.clone());
        store.clone()
    }

    /// Starts a scene over whose copy is not whole, once something in it changes.
    fn forget_world(&mut self, device: &mut Gd<RenderingDevice>, key: WorldKey) {
        let store = self.store(device);
        let Some(world) = self.worlds.get_mut(&key) else { return };
        (world.version, world.whole) = (0, false);
        let broken = std::mem::replace(&mut world.cache, SceneCache::new(&store));
        let mut recording = Recording::new();
        broken.free(&mut recording);
        // Freeing never fails.
        let _ = self.executor.execute(device, &recording, TIMED);
    }

    /// Draws the volumes of the world `shown` into one eye's picture; `None` where there is nothing to draw.
    fn draw_eye(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        settings: Settings,
        Target { snapshot, fog, .. }: &Target,
        shown: WorldKey,
        host: &HostView,
        key: EyeKey,
    ) -> Result<Option<LiveStatus>, String> {
        let mut recording = Recording::new();
        self.find_eye(device, key, shown, &host.live_settings(&settings), &mut recording)?;
        let world = self.worlds.get(&shown);
        let (Some(world), Some(eye)) = (world, self.eyes.get_mut(&key)) else { return Ok(None) };
        eye.take_read_backs();
        host.lend(&mut self.executor, eye.lent);
        // A scene goes with its own light, also when it is the one before.
        let is_before = shown != snapshot.key || world.version != snapshot.version;
        let ambient = eye.traced.filter(|_| is_before).map_or(settings.ambient, |(.., ambient)| ambient);
        let settings = Settings { ambient, ..settings };
        match eye.record(world, host, *fog, &settings, &mut recording) {
            Ok(frame) => self.execute_eye(device, key, &recording, frame).map(Some),
            Err(error) => {
                // A new eye's films are made all the same: the next frame counts on them.
                let _ = self.executor.execute(device, &recording, TIMED);
                Err(error.to_string())
            }
        }
    }

    /// Sees to it that there is an eye, if there is its scene. One that turns to another scene starts over there.
    fn find_eye(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        key: EyeKey,
        shown: WorldKey,
        live_settings: &LiveSettings,
        recording: &mut Recording,
    ) -> Result<(), String> {
        let Some(world) = self.worlds.get(&shown) else { return Ok(()) };
        if self.eyes.get(&key).is_some_and(|eye| eye.world == shown) {
            return Ok(());
        }
        if let Some(other) = self.eyes.remove(&key) {
            other.free(recording);
            self.turned = true;
        }
        match LiveView::new(live_settings, &world.cache, recording) {
            Ok(live) => {
                self.eyes.insert(key, Eye::new(live, shown));
                Ok(())
            }
            Err(error) => {
                // What was freed meanwhile is freed.
                let _ = self.executor.execute(device, recording, TIMED);
                Err(error.to_string())
            }
        }
    }

    /// Hands an eye's recording to the device. An eye that it refuses starts over in the next frame.
    fn execute_eye(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        key: EyeKey,
        recording: &Recording,
        frame: Frame,
    ) -> Result<LiveStatus, String> {
        self.serial += 1;
        match self.executor.execute(device, recording, &format!("{TIMED} {}", self.serial)) {
            Ok(read_backs) => {
                if let Some(eye) = self.eyes.get_mut(&key) {
                    eye.executed(self.serial, frame, read_backs);
                }
                Ok(frame.status)
            }
            Err(error) => {
                self.executor.discard(device, recording);
                // What it made is gone: it makes everything anew.
                if let Some(eye) = self.eyes.remove(&key) {
                    self.free_eye(device, eye);
                }
                Err(error.to_string())
            }
        }
    }

    /// Tells views what their frames took.
    fn read_times(&mut self, device: &Gd<RenderingDevice>) {
        let frame = device.get_captured_timestamps_frame();
        if frame == self.timed_frame {
            return;
        }
        self.timed_frame = frame;
        let mut begun = HashMap::new();
        for i in 0..device.get_captured_timestamps_count() {
            let name = device.get_captured_timestamp_name(i).to_string();
            let mut words = name.split(' ');
            if words.next() != Some(TIMED) {
                continue;
            }
            let Some(serial) = words.next().and_then(|word| word.parse::<u64>().ok()) else { continue };
            let time = device.get_captured_timestamp_gpu_time(i);
            match (words.next(), begun.get(&serial)) {
                (Some("begin"), _) => {
                    begun.insert(serial, time);
                }
                (Some("end"), Some(begin)) => {
                    let milliseconds = time.saturating_sub(*begin) as f64 * 1e-6;
                    self.eyes.values_mut().for_each(|eye| eye.pacer.measured(serial, milliseconds));
                }
                _ => {}
            }
        }
    }

    fn sweep(&mut self, device: &mut Gd<RenderingDevice>, shown: &HashMap<Rid, WorldKey>) {
        let gone: Vec<EyeKey> =
            self.eyes.keys().filter(|(target, _)| !shown.contains_key(target)).copied().collect();
        for key in gone {
            if let Some(eye) = self.eyes.remove(&key) {
                self.free_eye(device, eye);
            }
        }
        // A viewport goes on with its world until the next one is there.
        let in_use: Vec<WorldKey> =
            shown.values().copied().chain(self.eyes.values().map(|eye| eye.world)).collect();
        let gone: Vec<WorldKey> = self.worlds.keys().filter(|key| !in_use.contains(key)).copied().collect();
        for key in gone {
            self.forget_world(device, key);
            self.worlds.remove(&key);
        }
        self.collect(device);
    }

    fn free_eye(&mut self, device: &mut Gd<RenderingDevice>, eye: Eye) {
        let mut recording = Recording::new();
        eye.free(&mut recording);
        // Freeing never fails.
        let _ = self.executor.execute(device, &recording, TIMED);
    }
}

impl World {
    fn new(store: &VoxelStore) -> Self {
        let cache = SceneCache::new(store);
        Self { cache, version: 0, error: None, whole: false, preparing: None }
    }

    /// What a scene lacks to be shown without holding up the frame. It is on its way then.
    fn unprepared(&mut self, snapshot: &Snapshot) -> Option<Missing> {
        let mut kernels: Vec<Kernel> = self.cache.kernels(&snapshot.scene, ViewKind::Live);
        kernels.retain(|kernel| !workshop().is_ready(*kernel));
        workshop().hurry(kernels.iter().copied());
        let preparation = self.cache.preparation(&snapshot.scene);
        let computing = preparation.is_some().then_some(Missing::Computation);
        let under_way = self.preparing.as_ref().is_some_and(|shared| Arc::strong_count(shared) > 1);
        if let Some(preparation) = preparation.filter(|_| !under_way) {
            let done = self.preparing.insert(Arc::default()).clone();
            let run = move || {
                preparation.run_with(make_ahead);
                drop(done);
            };
            // Without a thread, the next frame tries again.
            let _ = std::thread::Builder::new().spawn(run);
        }
        if kernels.is_empty() { computing } else { Some(Missing::Kernels) }
    }
}

impl Eye {
    fn new(live: LiveView, world: WorldKey) -> Self {
        Self {
            live,
            pacer: Pacer::new(),
            traced: None,
            began: None,
            read_backs: vec![],
            lent: Lent::new(),
            world,
        }
    }

    /// Records as much of the picture as fits into the time that it has.
    fn record(
        &mut self,
        world: &World,
        host: &HostView,
        fog: Option<Fog>,
        settings: &Settings,
        recording: &mut Recording,
    ) -> Result<Frame, RenderError> {
        let camera = host.camera();
        // The cache's version and not the snapshot's: a light that reaches no volume starts nothing over.
        let traced = Some((camera, world.cache.version(), self.live.film_size(), settings.ambient));
        let before = std::mem::replace(&mut self.traced, traced);
        let pass = if before == traced { Pass::Still } else { Pass::Moving };
        let milliseconds = settings.budget_milliseconds;
        let now = Instant::now();
        if let Some(before) = self.began {
            self.pacer.interval((now - before).as_secs_f64() * 1e3);
        }
        let budget = self.pacer.budget(pass, milliseconds);
        let host_frame = host.frame(self.lent, settings.write_depth, fog);
        let live_settings = host.live_settings(settings);
        let status =
            self.live.record_frame(&world.cache, &camera, &live_settings, &host_frame, budget, recording)?;
        host.draw_resolved_too(self.lent, recording);
        self.began = (!status.converged).then_some(now);
        Ok(Frame { status, pass, budget, milliseconds })
    }

    /// Waits for what comes back of a frame, and for what it took.
    fn executed(&mut self, serial: u64, frame: Frame, read_backs: Vec<Receiver<Vec<u8>>>) {
        let Frame { status, pass, budget, milliseconds } = frame;
        self.pacer.recorded(serial, pass, status.pixel_samples, budget, milliseconds);
        self.read_backs.extend(read_backs);
    }

    fn free(self, recording: &mut Recording) {
        self.live.free(recording);
        for id in self.lent.ids() {
            recording.push(Step::Free { id });
        }
    }

    /// Hands over what has come back from the GPU.
    fn take_read_backs(&mut self) {
        let live = &mut self.live;
        self.read_backs.retain(|read_back| match read_back.try_recv() {
            Ok(bytes) => {
                live.feedback(&bytes);
                false
            }
            Err(TryRecvError::Empty) => true,
            Err(TryRecvError::Disconnected) => {
                live.feedback(&[]);
                false
            }
        });
    }
}
