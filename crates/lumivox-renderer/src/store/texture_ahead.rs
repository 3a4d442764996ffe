//! Textures made before the frame that wants them, on the thread that prepares it: to make one of hundreds of megabytes
//! takes a device longer than a frame may be late.

use std::sync::{Arc, Mutex, PoisonError, TryLockError};

use lumivox_core::Volume;

use super::arrivals::ArrivalPlan;
use super::{Entry, Source, Store, WeakSource, bricks};
use crate::recording::{Recording, ResourceId, Step, TextureFormat, TextureOrder};

/// Bytes from which on a texture takes long to make.
const LARGE_BYTES: u64 = 16 << 20;

/// Updates of scenes and collections, so frames, for which a texture waits for its volumes.
const PATIENCE: u64 = 10_000;

/// A texture for volumes to come. Clones are of the same.
#[derive(Clone, Debug)]
pub(super) struct TextureAhead {
    order: TextureOrder,
    pub sources: Vec<WeakSource>,
    /// When it was ordered.
    clock: u64,
    /// Locked while it is made.
    making: Arc<Mutex<Making>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Making {
    Ordered,
    Made,
    /// It could not be made, or is not wanted any more.
    GivenUp,
}

/// Whether a volume may need a texture that takes long to make.
fn is_large(volume: &Volume) -> bool {
    2 * volume.voxel_count() as u64 >= LARGE_BYTES / 2
}

/// Whether a texture takes long to make.
fn takes_long(order: &TextureOrder) -> bool {
    bytes(order) >= LARGE_BYTES
}

fn bytes(order: &TextureOrder) -> u64 {
    let texels: u64 = order.size.iter().map(|&n| u64::from(n)).product();
    texels * order.format.bytes_per_texel() as u64
}

impl TextureAhead {
    pub fn new(order: TextureOrder, sources: Vec<WeakSource>, clock: u64) -> Self {
        Self { order, sources, clock, making: Arc::new(Mutex::new(Making::Ordered)) }
    }

    pub fn id(&self) -> ResourceId {
        self.order.id
    }

    pub fn is_for(&self, source: &Source) -> bool {
        self.sources.iter().any(|other| other == source)
    }

    /// Whether its volumes should have come long ago.
    pub fn is_old(&self, clock: u64) -> bool {
        clock.saturating_sub(self.clock) > PATIENCE
    }

    /// Makes it, unless it was given up: once, and never after it was freed.
    pub fn make(&self, make: &mut dyn FnMut(&TextureOrder) -> bool) {
        let mut making = self.making.lock().unwrap_or_else(PoisonError::into_inner);
        if *making == Making::Ordered {
            *making = if make(&self.order) { Making::Made } else { Making::GivenUp };
        }
    }

    /// `None` while it is being made, which nobody waits for.
    fn making(&self) -> Option<Making> {
        match self.making.try_lock() {
            Ok(making) => Some(*making),
            Err(TryLockError::Poisoned(making)) => Some(*making.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Whether it is to be made, or is being made.
    pub fn is_pending(&self) -> bool {
        !matches!(self.making(), Some(Making::Made | Making::GivenUp))
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> u64 {
        if self.making() == Some(Making::Made) { bytes(&self.order) } else { 0 }
    }

    /// Whether it is there and is what is wanted.
    pub fn suits(&self, format: TextureFormat, size: [u32; 3]) -> bool {
        self.order.format == format && self.order.size == size && self.making() == Some(Making::Made)
    }

    /// Records that it is used; returns its name.
    pub fn create(self, recording: &mut Recording) -> ResourceId {
        let TextureOrder { id, label, format, size } = self.order;
        recording.push(Step::CreateTexture { id, label, format, size });
        id
    }

    /// Records that it is freed, or has it not made. False while it is being made.
    pub fn give_up(&self, recording: &mut Recording) -> bool {
        let mut making = match self.making.try_lock() {
            Ok(making) => making,
            Err(TryLockError::Poisoned(making)) => making.into_inner(),
            Err(TryLockError::WouldBlock) => return false,
        };
        if std::mem::replace(&mut *making, Making::GivenUp) == Making::Made {
            recording.push(Step::Free { id: self.order.id });
        }
        true
    }
}

impl Store {
    /// Frees textures that were made ahead and are not wanted any more.
    pub(super) fn drop_stale(&mut self, recording: &mut Recording) {
        let Self { pools, entries, clock, .. } = self;
        let has_come =
            |source: &WeakSource| source.is_gone() || entries.iter().any(|entry| entry.source == *source);
        let is_stale = |ahead: &TextureAhead| ahead.is_old(*clock) || ahead.sources.iter().all(has_come);
        pools.drop_ahead(is_stale, recording);
    }

    /// Textures for volumes that come that are ordered and not made.
    pub(super) fn pending(&self, coming: &[Source]) -> impl Iterator<Item = &TextureAhead> {
        let is_for_any = |ahead: &&TextureAhead| coming.iter().any(|source| ahead.is_for(source));
        self.pools.ahead.iter().filter(|ahead| ahead.is_pending()).filter(is_for_any)
    }

    /// Textures to be made for volumes that come when others leave. A volume that somebody holds may stay nevertheless:
    /// then a texture is made in the frame that wants it.
    pub(super) fn plan_ahead(
        &self,
        coming: &[Source],
        leaving: &[WeakSource],
    ) -> impl Iterator<Item = TextureAhead> + use<> {
        let is_known = |source: &Source| self.pools.ahead.iter().any(|ahead| ahead.is_for(source));
        let new: Vec<ArrivalPlan> = coming
            .iter()
            .filter(|source| self.entry(source).is_none())
            .map(|source| ArrivalPlan {
                source: source.clone(),
                factor: bricks::least_factor(source.volume.dims()),
                at_once: false,
                coarse: self.coarse_first(source, false),
            })
            .collect();
        let mut steps = Recording::new();
        if new.iter().any(|coming| !is_known(&coming.source) && is_large(&coming.source.volume)) {
            let mut planned = self.pools.clone();
            // What stands in for what comes stays until that is there.
            let stays = |entry: &Entry| coming.iter().any(|source| entry.source.is_of(&source.volume));
            let leaves = |entry: &&Entry| leaving.contains(&entry.source) && !stays(entry);
            for entry in self.entries.iter().filter(leaves) {
                for copy in entry.copies() {
                    planned.release(copy.bricks.pages.iter().copied());
                }
            }
            planned.expected = self.expected(new.iter().map(|coming| &coming.source));
            // Where there is no room, it is made in the frame that wants it.
            let _ = planned.allocate(&self.bricks_of(&new), self.capacity, &mut steps);
        }
        let sources: Vec<WeakSource> = new.iter().map(|coming| coming.source.downgrade()).collect();
        let known: Vec<ResourceId> = self.pools.ahead.iter().map(TextureAhead::id).collect();
        let clock = self.clock;
        steps.steps.into_iter().filter_map(move |step| {
            let Step::CreateTexture { id, label, format, size } = step else { return None };
            let order = TextureOrder { id, label, format, size };
            (takes_long(&order) && !known.contains(&id))
                .then(|| TextureAhead::new(order, sources.clone(), clock))
        })
    }
}
