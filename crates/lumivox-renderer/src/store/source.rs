//! What scenes read of a volume: its voxels, or means of them.

use std::sync::{Arc, Weak};

use lumivox_core::{Filter, Volume};

/// How voxels go to the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reading {
    /// As they are; where they are reduced, as means.
    Plain,
    /// Averaged with their neighbours, for [`Filter::Smooth`].
    Smooth,
    /// As they are, and where they are reduced as one of them: a mean of labels is another label.
    Labels,
}

/// A volume as it is read: the same volume may be in a store in more than one way.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub volume: Arc<Volume>,
    pub reading: Reading,
}

/// The same, without holding the volume.
#[derive(Clone, Debug)]
pub(crate) struct WeakSource {
    volume: Weak<Volume>,
    reading: Reading,
}

impl Source {
    pub fn new(volume: &Arc<Volume>, filter: Filter) -> Self {
        let reading = if filter == Filter::Smooth { Reading::Smooth } else { Reading::Plain };
        Self { volume: volume.clone(), reading }
    }

    /// Of a volume whose values are labels.
    pub fn labels(volume: &Arc<Volume>) -> Self {
        Self { volume: volume.clone(), reading: Reading::Labels }
    }

    pub fn downgrade(&self) -> WeakSource {
        WeakSource { volume: Arc::downgrade(&self.volume), reading: self.reading }
    }
}

/// By identity.
impl PartialEq for Source {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.volume, &other.volume) && self.reading == other.reading
    }
}

impl WeakSource {
    pub fn upgrade(&self) -> Option<Source> {
        Some(Source { volume: self.volume.upgrade()?, reading: self.reading })
    }

    /// Whether copies of it can stand in for each other's: labels can for nothing.
    pub fn is_like(&self, other: &Source) -> bool {
        self.is_of(&other.volume) && ![self.reading, other.reading].contains(&Reading::Labels)
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
        self.is_of_same(other) && self.reading == other.reading
    }
}

impl PartialEq<Source> for WeakSource {
    fn eq(&self, other: &Source) -> bool {
        self.is_of(&other.volume) && self.reading == other.reading
    }
}
