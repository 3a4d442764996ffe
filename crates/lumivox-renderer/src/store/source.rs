//! What scenes read of a volume: its voxels, or means of them.

use std::sync::{Arc, Weak};

use lumivox_core::{Filter, Volume};

/// A volume as a filter reads it: the same volume may be in a store as both.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub volume: Arc<Volume>,
    /// Whether each voxel is averaged with its neighbours, for [`Filter::Smooth`].
    pub is_smooth: bool,
}

/// The same, without holding the volume.
#[derive(Clone, Debug)]
pub(crate) struct WeakSource {
    volume: Weak<Volume>,
    is_smooth: bool,
}

impl Source {
    pub fn new(volume: &Arc<Volume>, filter: Filter) -> Self {
        Self { volume: volume.clone(), is_smooth: filter == Filter::Smooth }
    }

    pub fn downgrade(&self) -> WeakSource {
        WeakSource { volume: Arc::downgrade(&self.volume), is_smooth: self.is_smooth }
    }
}

/// By identity.
impl PartialEq for Source {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.volume, &other.volume) && self.is_smooth == other.is_smooth
    }
}

impl WeakSource {
    pub fn upgrade(&self) -> Option<Source> {
        Some(Source { volume: self.volume.upgrade()?, is_smooth: self.is_smooth })
    }

    /// Whether nobody holds the volume any more.
    pub fn is_gone(&self) -> bool {
        self.volume.strong_count() == 0
    }

    pub fn is_of(&self, volume: &Arc<Volume>) -> bool {
        // A weak reference keeps the address from being used again.
        std::ptr::eq(self.volume.as_ptr(), Arc::as_ptr(volume))
    }

    /// Whether it is the same volume, read in whatever way.
    pub fn is_of_same(&self, other: &Self) -> bool {
        self.volume.ptr_eq(&other.volume)
    }
}

/// By identity.
impl PartialEq for WeakSource {
    fn eq(&self, other: &Self) -> bool {
        self.is_of_same(other) && self.is_smooth == other.is_smooth
    }
}

impl PartialEq<Source> for WeakSource {
    fn eq(&self, other: &Source) -> bool {
        self.is_of(&other.volume) && self.is_smooth == other.is_smooth
    }
}
