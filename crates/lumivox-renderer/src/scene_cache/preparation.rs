//! What an update would compute that takes long, as work for another thread: coarse copies of volumes, where an
//! environment's light comes from.

use std::sync::Arc;

use lumivox_core::{EnvironmentSource, Scene, Volume};

use super::{SceneCache, importance, place};
use crate::store::prepare_volume;

/// Work ahead of an [`update`](SceneCache::update_within). What it computes is kept with the volume or the map, for all
/// scenes.
#[derive(Clone, Debug)]
pub struct Preparation {
    volumes: Vec<Arc<Volume>>,
    environment: Option<EnvironmentSource>,
}

impl Preparation {
    /// Does it, on this thread and rayon's.
    pub fn run(&self) {
        for volume in &self.volumes {
            prepare_volume(volume);
        }
        if let Some(source) = &self.environment {
            importance::of(source);
        }
    }
}

impl SceneCache {
    /// What [`update_within`](Self::update_within) would have to compute for `scene` that takes long; `None` where all is
    /// known. A host that must not miss a frame runs it on another thread, and shows the scene before until it is done.
    pub fn preparation(&self, scene: &Scene) -> Option<Preparation> {
        let mut volumes: Vec<Arc<Volume>> = vec![];
        for placed in place(scene) {
            let volume = &placed.instance.volume;
            let is_known = volumes.iter().any(|known| Arc::ptr_eq(known, volume));
            if !is_known && self.store.lacks_preparation(volume) {
                volumes.push(volume.clone());
            }
        }
        let source = &scene.environment.source;
        let is_new = !self.environment.holds(source) && !importance::is_known(source);
        let environment = is_new.then(|| source.clone());
        (!volumes.is_empty() || environment.is_some()).then_some(Preparation { volumes, environment })
    }
}
