//! What an update would compute that takes long, as work for another thread: value ranges of volumes, where an
//! environment's light comes from.

use std::sync::Arc;

use lumivox_core::{EnvironmentSource, Scene, Volume};

use super::value_ranges::GridKey;
use super::{SceneCache, importance, place, volumes};

/// Work ahead of an [`update`](SceneCache::update). What it computes is kept with the volume or the map, for all scenes.
#[derive(Clone, Debug)]
pub struct Preparation {
    grids: Vec<(Arc<Volume>, GridKey)>,
    environment: Option<EnvironmentSource>,
}

impl Preparation {
    /// Does it, on this thread and rayon's.
    pub fn run(&self) {
        for (volume, key) in &self.grids {
            key.grid(volume);
        }
        if let Some(source) = &self.environment {
            importance::of(source);
        }
    }
}

impl SceneCache {
    /// What [`update`](Self::update) would have to compute for `scene` that takes long; `None` where all is known. A
    /// host that must not miss a frame runs it on another thread, and shows the scene before until it is done.
    pub fn preparation(&self, scene: &Scene) -> Option<Preparation> {
        let wanted = volumes::distinct(&place(scene), self.cell_size);
        let grids: Vec<_> = wanted.into_iter().filter(|(volume, key)| !key.is_known(volume)).collect();
        let source = &scene.environment.source;
        let is_new = !self.environment.holds(source) && !importance::is_known(source);
        let environment = is_new.then(|| source.clone());
        (!grids.is_empty() || environment.is_some()).then_some(Preparation { grids, environment })
    }
}

/// Computes what every scene needs of a volume, unless it is known: best where it is loaded.
pub fn prepare_volume(volume: &Arc<Volume>) {
    GridKey { wide: false, cell_size: volumes::cell_size(volume, None) }.grid(volume);
}
