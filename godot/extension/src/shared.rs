//! What the main thread leaves for the render thread, and what comes back. Plain Rust and RIDs only.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use godot::classes::rendering_server::CompositorEffectCallbackType;
use godot::obj::EngineEnum;
use godot::prelude::Rid;
use lumivox_core::Scene;
use lumivox_renderer::{Fog, VoxelStore};

use crate::render::Settings;

/// The engine's number of the last stage before what is transparent is drawn.
pub fn last_stage() -> i32 {
    CompositorEffectCallbackType::PRE_TRANSPARENT.ord()
}

/// What tells one scene from another: cameras that share it share its copy on the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WorldKey {
    /// The world's scenario.
    pub scenario: Rid,
    /// Instance id of the environment; 0 where there is none.
    pub environment: i64,
    /// The volumes' layers that are seen.
    pub layers: u32,
    /// Whether a studio lights it instead of its environment.
    pub studio: bool,
}

/// A scene as it was at the beginning of a frame.
#[derive(Debug)]
pub struct Snapshot {
    /// Which scene.
    pub key: WorldKey,
    /// What is in it.
    pub scene: Scene,
    /// Changes whenever the scene does.
    pub version: u64,
}

/// What a render target shows.
#[derive(Clone, Debug)]
pub struct Target {
    /// Its scene.
    pub snapshot: Arc<Snapshot>,
    /// How it is drawn.
    pub settings: Settings,
    /// The engine's number of the stage of a frame at which it is drawn.
    pub stage: i32,
    /// What hides what is far from its camera.
    pub fog: Option<Fog>,
    /// Whether this frame must show its scene, however long the preparation takes: no other may follow.
    pub at_once: bool,
    /// Whether something of its volumes is still computed, and they will look otherwise.
    pub preparing: bool,
}

impl Target {
    /// Whether light is kept for it: a picture that is traced whole in its frame needs none.
    pub fn keeps_light(&self) -> bool {
        self.settings.kept_light && !self.at_once
    }
}

/// How far a viewport's image is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Status {
    /// Samples that every pixel has.
    pub samples: u32,
    /// Samples after which it is done.
    pub target: u32,
    /// The part of them that is traced, 0 to 1.
    pub progress: f32,
    /// Whether all voxels are there that the GPU has room for.
    pub arrived: bool,
    /// Whether it is.
    pub converged: bool,
    /// Whether that may turn out to be wrong.
    pub awaits_feedback: bool,
    /// Milliseconds of the GPU's time that tracing took in a recent frame.
    pub milliseconds: f64,
    /// Pixel samples traced in the last frame.
    pub pixel_samples: u64,
    /// Bytes that the light takes which is kept for it.
    pub light_bytes: u64,
}

/// What both threads see.
#[derive(Debug, Default)]
pub struct Shared {
    /// What each render target shows.
    pub targets: HashMap<Rid, Target>,
    /// Which of them this frame has drawn.
    pub drawn: HashSet<Rid>,
    /// Goes up with every frame.
    pub frame: u64,
    /// How far it is.
    pub statuses: HashMap<Rid, Status>,
    /// The voxels on the GPU, once there are any.
    pub store: Option<VoxelStore>,
    /// Why volumes cannot be drawn.
    pub error: Option<String>,
    /// The error that was told last, and need not be told again.
    pub told: Option<String>,
    /// Whether an image is not done, and an engine that idles should draw again.
    pub wants_frame: bool,
    /// Whether an engine that idles has to look what came back first.
    pub awaits_feedback: bool,
}

impl Shared {
    /// What a render target shows, if this is the stage to draw it at and this frame has not yet: a compositor may hold
    /// several effects. [`last_stage`] makes up for earlier ones: not every renderer has them, nor can volumes always be
    /// drawn there.
    pub fn begin(&mut self, target: Rid, stage: i32) -> Option<Target> {
        let is_due = |shown: &&Target| shown.stage == stage || (shown.stage < stage && stage == last_stage());
        let shown = self.targets.get(&target).filter(is_due)?;
        self.drawn.insert(target).then(|| shown.clone())
    }

    /// The world that each render target is to show.
    pub fn worlds(&self) -> HashMap<Rid, WorldKey> {
        self.targets.iter().map(|(rid, target)| (*rid, target.snapshot.key)).collect()
    }

    /// An error that was not told yet.
    pub fn take_news(&mut self) -> Option<String> {
        let news = self.error.clone().filter(|error| self.told.as_ref() != Some(error));
        if news.is_some() {
            self.told.clone_from(&news);
        }
        news
    }
}

/// Exclusive use of what both threads see. Hold it briefly.
pub fn lock() -> MutexGuard<'static, Shared> {
    static SHARED: LazyLock<Mutex<Shared>> = LazyLock::new(Mutex::default);
    // A panic elsewhere was reported there; what is in here is replaced every frame.
    SHARED.lock().unwrap_or_else(PoisonError::into_inner)
}
