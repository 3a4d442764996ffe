//! What an update would do that takes long, as work for another thread: coarse copies of volumes, the textures that they
//! will lie in, where an environment's light comes from.

use std::sync::Arc;

use lumivox_core::{EnvironmentSource, LabelVolume, Scene};

use super::{Field, Placed, SceneCache, importance, label_sets, place};
use crate::recording::TextureOrder;
use crate::store::{Source, VoxelStore, WeakSource, prepare_source};

/// Work ahead of an [`update`](SceneCache::update_within). What it computes is kept with the volume or the map, for all
/// scenes.
#[derive(Clone, Debug)]
pub struct Preparation {
    store: VoxelStore,
    /// Those whose coarse copies are to be made.
    volumes: Vec<Source>,
    labels: Vec<Arc<LabelVolume>>,
    environment: Option<EnvironmentSource>,
    coming: Vec<Source>,
    /// What the scene has no more. Not held: it is to be gone when the others come.
    leaving: Vec<WeakSource>,
}

impl Preparation {
    /// Does it, on this thread and rayon's, but for the textures: the update makes them.
    pub fn run(&self) {
        self.run_with(|_| false);
    }

    /// Does it, and has the host make the large textures that the update will want: `make` says whether it could. A
    /// recording that creates a texture of that name takes it; one that frees it may come without that, with an update or
    /// a [`VoxelStore::collect`]: a host that rests calls that now and then. An executor's maker does both
    /// (`TextureMaker` in `lumivox-wgpu`).
    pub fn run_with(&self, mut make: impl FnMut(&TextureOrder) -> bool) {
        self.store.make_ahead(&self.coming, &self.leaving, &mut make);
        for volume in &self.volumes {
            prepare_source(volume);
        }
        for labels in &self.labels {
            label_sets::blocks(labels);
        }
        if let Some(source) = &self.environment {
            importance::of(source);
        }
    }
}

impl SceneCache {
    /// What [`update_within`](Self::update_within) would have to do for `scene` that takes long; `None` where all is
    /// done. A host that must not miss a frame runs it on another thread, and shows the scene before until it is done.
    pub fn preparation(&self, scene: &Scene) -> Option<Preparation> {
        let mut coming: Vec<Source> = vec![];
        let placed = place(scene);
        let fields = placed.iter().flat_map(|placed| Field::sources(placed).map(|(_, source)| source));
        for source in placed.iter().map(Placed::source).chain(fields) {
            if !coming.contains(&source) {
                coming.push(source);
            }
        }
        let labels = placed.iter().filter_map(|placed| placed.instance.labels.as_ref());
        let labels: Vec<Arc<LabelVolume>> =
            labels.map(|l| l.labels.clone()).filter(|labels| !label_sets::are_known(labels)).collect();
        let held = self.volumes.iter().map(|(source, _)| source);
        let leaving: Vec<WeakSource> =
            held.filter(|source| !coming.contains(source)).map(Source::downgrade).collect();
        let lacking = coming.iter().filter(|source| self.store.lacks_preparation(source));
        let volumes: Vec<Source> = lacking.cloned().collect();
        let source = &scene.environment.source;
        let is_new = !self.environment.holds(source) && !importance::is_known(source);
        let environment = is_new.then(|| source.clone());
        let lacks_textures = self.store.lacks_textures(&coming, &leaving);
        let lacks_labels = !labels.is_empty();
        (lacks_textures || lacks_labels || !volumes.is_empty() || environment.is_some())
            .then(|| Preparation { store: self.store.clone(), volumes, labels, environment, coming, leaving })
    }
}
