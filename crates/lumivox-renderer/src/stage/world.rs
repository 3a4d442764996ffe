//! One world's copy on the device, and what is prepared for its next.

use std::sync::Arc;
use std::time::Duration;

use lumivox_core::{Scene, host};

use super::{StageError, Workbench, WorldState};
use crate::features::ViewKind;
use crate::scene_cache::SceneCache;
use crate::store::VoxelStore;

/// While a driver makes a large texture, 5 to 7 ms for 300 MB, it holds up what is handed over to the GPU. So the frame under
/// way is to be handed over before, and the time that the engine waits for it anyway is used.
const UNTIL_THE_FRAME_IS_OUT: Duration = Duration::from_millis(1);

/// A scene on the device.
#[derive(Debug)]
pub struct World {
    pub cache: SceneCache,
    /// Of the scene that it holds; one that does not fit is not tried again.
    pub version: u64,
    /// Why it does not fit.
    pub error: Option<StageError>,
    /// Whether there is anything to draw: a scene that fits.
    pub is_whole: bool,
    pub state: WorldState,
    /// Whether views of it keep guides: their kernel is another.
    pub has_guides: bool,
    /// Whether some view would keep light, and whether its kernels are made. Until then views go without: what else they show
    /// does not wait for it.
    pub wants_light: bool,
    pub keeps_light: bool,
    /// Whether the last update did nothing, for there was no room for it in its frame.
    pub was_skipped: bool,
    /// What is prepared for the next scene, on another thread that holds the same, if there is one.
    preparing: Option<Arc<()>>,
}

/// What a scene waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    Kernels,
    /// Of its volumes or its environment.
    Computation,
}

impl World {
    pub fn new(store: &VoxelStore) -> Self {
        Self {
            cache: new_cache(store),
            version: 0,
            error: None,
            is_whole: false,
            state: WorldState::Nothing,
            has_guides: false,
            wants_light: false,
            keeps_light: false,
            was_skipped: false,
            preparing: None,
        }
    }

    /// What a scene lacks to be shown without holding up the frame. It is on its way then.
    pub fn unprepared(&mut self, scene: &Scene, workbench: &impl Workbench) -> Option<Missing> {
        let kernels = self
            .cache
            .kernels(scene, ViewKind::Live { guides: self.has_guides, kept_light: self.keeps_light });
        let lacks_kernels = !workbench.are_ready(&kernels);
        let preparation = self.cache.preparation(scene);
        let computing = preparation.is_some().then_some(Missing::Computation);
        let under_way = self.preparing.as_ref().is_some_and(|shared| Arc::strong_count(shared) > 1);
        if let Some(preparation) = preparation.filter(|_| !under_way) {
            let done = self.preparing.insert(Arc::default()).clone();
            let mut make = workbench.texture_maker();
            // Where there are no threads this is the frame.
            let wait = (host::spare_threads() > 0).then_some(UNTIL_THE_FRAME_IS_OUT);
            let run = move || {
                let mut waits = wait;
                preparation.run_with(|order| {
                    if let Some(time) = waits.take() {
                        host::sleep(time);
                    }
                    make(order)
                });
                drop(done);
            };
            // Without a thread the frame waits for it.
            if let Err(work) = host::spawn("lumivox preparation", run) {
                work();
            }
        }
        if lacks_kernels { Some(Missing::Kernels) } else { computing }
    }

    /// Has what light is kept with made where it is wanted. `at_once`: whoever needs it first makes it.
    pub fn prepare_light(&mut self, scene: &Scene, at_once: bool, workbench: &impl Workbench) {
        if self.wants_light && !self.keeps_light {
            let view = ViewKind::Live { guides: false, kept_light: true };
            self.keeps_light = at_once || workbench.are_ready(&self.cache.kernels(scene, view));
        }
    }

    /// Starts over with nothing. Returns what was there.
    pub fn forget(&mut self, store: &VoxelStore) -> SceneCache {
        (self.version, self.error, self.is_whole) = (0, None, false);
        self.state = WorldState::Nothing;
        std::mem::replace(&mut self.cache, new_cache(store))
    }

    /// An update was replayed, or came to nothing.
    pub fn updated(&mut self, version: u64, error: Option<StageError>) {
        self.version = version;
        self.is_whole = error.is_none();
        self.state = match (self.is_whole, self.cache.is_settled()) {
            (true, true) => WorldState::Done,
            (true, false) => WorldState::Arriving,
            (false, _) => WorldState::Nothing,
        };
        self.error = error;
    }
}

/// An empty one; all that is shown of it are live views.
fn new_cache(store: &VoxelStore) -> SceneCache {
    let mut cache = SceneCache::new(store);
    cache.follow_light();
    cache
}
