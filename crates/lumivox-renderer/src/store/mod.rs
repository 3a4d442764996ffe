//! The voxels on a device, shared by all its scenes: what one scene has brought, another finds.
//!
//! A volume is cut into [`bricks`], which lie in the [`pools`] wherever there is room. It is known by its identity: its
//! voxels stay as long as somebody, on the GPU or off it, holds the [`Volume`]; what no scene shows goes first where room
//! is scarce.
//!
//! Its words: a [`Source`] is a volume and how it is read; an [`Entry`] is what the store knows of one that some scene has asked
//! for; [`Bricks`] are a copy of it on the device, of which the entry has a [`StoredCopy`] and each scene a [`SceneCopy`]. A copy
//! that is on its way is an [`Arrival`]; room for it is made by its [plan](arrivals::ArrivalPlan). What other threads make before a
//! frame needs it is *ahead*: [`BricksAhead`](bricks_ahead::BricksAhead), [`TextureAhead`].
//!
//! A large volume arrives a little with every frame; until it is whole, a coarse copy of it that was
//! [prepared](prepare_volume) stands in its place. What there is no room for is reduced instead of refused.

mod arrival;
mod arrivals;
mod bricks;
mod bricks_ahead;
mod coarse;
mod light_room;
mod pool;
mod pools;
mod source;
mod switches;
mod texels;
mod texture_ahead;
mod value_ranges;

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use lumivox_core::Volume;
use lumivox_shaders::constants::BRICK_TEXELS;
use lumivox_shaders::layout::POOL_COUNT;

use self::arrival::Arrival;
pub(crate) use self::bricks::BrickGrid;
#[cfg(test)]
pub(crate) use self::bricks::picked;
use self::coarse::is_prepared;
pub(crate) use self::coarse::prepare_source;
pub use self::coarse::prepare_volume;
pub(crate) use self::light_room::LightRoom;
use self::pools::Pools;
pub(crate) use self::source::{Source, WeakSource};
pub(crate) use self::texels::TexelScale;
use self::texture_ahead::TextureAhead;
use self::value_ranges::Ranges;
pub(crate) use self::value_ranges::{GridKey, MAX_CELL_SIZE, ValueRanges, grid};
use crate::error::RenderError;
use crate::ids;
use crate::limits::DeviceLimits;
use crate::recording::{Recording, ResourceId, Step, TextureOrder};

/// A budget of so many bytes has no bound.
const AT_ONCE: u64 = u64::MAX / 2;

/// Room that is not worth trying.
const LEAST_BYTES: u64 = 1 << 20;

/// A pool that is emptier than this, and wastes so many bytes, is left by its last volumes.
const SPARSE: u64 = 4;
const SPARSE_BYTES: u64 = 128 << 20;

/// The voxels of all volumes on a device. Clones are the same store.
#[derive(Clone, Debug)]
pub struct VoxelStore(Arc<Mutex<Store>>);

/// How much of a volume is on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// Voxels of the scan along an axis for one on the device; 1 where all are there.
    pub factor: u32,
    /// Whether finer ones are on their way.
    pub arriving: bool,
}

/// A copy of a volume, cut into bricks that lie in the pools; perhaps a reduced one. They are its own as long as somebody
/// holds it.
#[derive(Debug)]
pub(crate) struct Bricks {
    /// Of the volume, not of the copy.
    pub source: ResourceId,
    /// Voxels of the volume along an axis for one of the copy.
    pub factor: u32,
    pub grid: BrickGrid,
    /// Where each brick lies.
    pub pages: Vec<u32>,
    /// The copy for another filter whose bricks these are, where it stands in for one that is not there yet.
    lender: Option<Arc<Bricks>>,
    /// Whether the device refused what wrote it: its bricks are given to others by now.
    is_lost: AtomicBool,
}

/// What a scene gets of a source: a copy, and the ranges of values in the cells that it asked for.
#[derive(Clone, Debug)]
pub(crate) struct SceneCopy {
    pub bricks: Arc<Bricks>,
    pub ranges: ValueRanges,
}

#[derive(Debug)]
struct Store {
    limits: DeviceLimits,
    pools: Pools,
    entries: Vec<Entry>,
    /// Bytes that the pools may take together.
    capacity: u64,
    /// Bytes of the light that is kept in volumes.
    light: u64,
    /// Releases of room when the device last refused light.
    without_light: Option<u64>,
    /// Goes up when room is made.
    releases: u64,
    clock: u64,
    unprepared: u64,
    /// Buffers that nobody uses any more, to be freed with the next recording.
    orphans: Vec<ResourceId>,
}

/// What some scene has asked for.
#[derive(Debug)]
struct Entry {
    id: ResourceId,
    source: WeakSource,
    shown: Option<StoredCopy>,
    /// What scenes show that have nothing of it yet.
    borrowed: Weak<Bricks>,
    /// Each takes the place of the one before.
    arriving: VecDeque<(StoredCopy, Arrival)>,
    /// When it was asked for last.
    asked: u64,
    /// Releases of room when it was last tried to have it whole.
    tried: u64,
}

/// A copy, and the ranges of values in the cells of each size that scenes have asked for.
#[derive(Debug)]
struct StoredCopy {
    bricks: Arc<Bricks>,
    ranges: Vec<Ranges>,
}

impl VoxelStore {
    /// An empty store for a device.
    pub fn new(limits: DeviceLimits) -> Self {
        Self(Arc::new(Mutex::new(Store {
            limits,
            pools: Pools::new(&limits),
            entries: vec![],
            capacity: u64::MAX,
            light: 0,
            without_light: None,
            releases: 0,
            clock: 0,
            unprepared: 0,
            orphans: vec![],
        })))
    }

    /// The device's limits.
    pub fn limits(&self) -> DeviceLimits {
        self.lock().limits
    }

    /// Bounds the bytes that voxels may take on the device, and the light that is kept in them: that has what voxels leave, and
    /// none is kept where that is too little. Voxels that there is no room for arrive reduced; whole with the next
    /// updates where the bound is raised. Those that are there already stay where it is lowered.
    pub fn set_capacity(&self, bytes: u64) {
        let mut store = self.lock();
        store.releases += u64::from(bytes > store.capacity);
        store.capacity = bytes;
    }

    /// Bytes that voxels take on the device, the room for more included.
    pub fn bytes(&self) -> u64 {
        self.lock().pools.bytes()
    }

    /// How much there is of a volume; `None` where no scene has asked for it.
    pub fn resolution(&self, volume: &Arc<Volume>) -> Option<Resolution> {
        let store = self.lock();
        let of_volume = store.entries.iter().filter(|entry| entry.source.is_of(volume));
        let arriving = of_volume.clone().any(|entry| !entry.arriving.is_empty());
        let resolutions = of_volume.filter_map(|entry| {
            let factor = entry.shown.as_ref()?.bricks.factor;
            Some(Resolution { factor, arriving })
        });
        // As more than one filter reads it: the coarsest.
        resolutions.max_by_key(|resolution| resolution.factor)
    }

    /// Volumes that there is no room for but reduced.
    pub fn reduced(&self) -> usize {
        let is_reduced = |entry: &&Entry| {
            entry.arriving.is_empty() && entry.shown.as_ref().is_some_and(|shown| shown.bricks.factor > 1)
        };
        self.lock().entries.iter().filter(is_reduced).count()
    }

    /// Records that what belonged to volumes which nobody holds any more is freed.
    pub fn collect(&self, recording: &mut Recording) {
        let mut store = self.lock();
        store.clock += 1;
        store.drop_dead(recording);
        store.drop_left_over(recording);
        store.drop_stale(recording);
        store.pools.free_empty(recording);
    }

    /// Learns that the device refused a recording for want of memory. What the recording made or wrote is gone; volumes
    /// that were in it arrive anew, reduced to what there is room for, or whole where light gives way to them. Scenes that show them are not
    /// [intact](crate::SceneCache::is_intact) any more and have to be made anew, too.
    /// Returns whether that may help: there is something that can take less.
    pub fn refused(&self, recording: &Recording) -> bool {
        let mut store = self.lock();
        let before = store.pools.lasting_bytes();
        let makes = |id: ResourceId| {
            recording.steps.iter().any(|step| match step {
                Step::CreateTexture { id: made, .. } | Step::CreateBuffer { id: made, .. } => *made == id,
                _ => false,
            })
        };
        let Store { entries, pools, orphans, .. } = &mut *store;
        let is_written = |bricks: &Bricks| {
            recording.steps.iter().any(|step| match step {
                Step::WriteTexture { id, origin, .. } => bricks
                    .pages
                    .iter()
                    .any(|page| pools.texture_of(*page).0 == *id && pools::first_texel(*page) == *origin),
                _ => false,
            })
        };
        let is_broken = |copy: &StoredCopy| {
            copy.ranges.iter().any(|ranges| makes(ranges.values().buffer)) || is_written(&copy.bricks)
        };
        let broken: Vec<ResourceId> = entries
            .iter()
            .filter(|entry| entry.shown.as_ref().is_some_and(is_broken))
            .map(|entry| entry.id)
            .collect();
        for entry in &mut *entries {
            let is_broken = broken.contains(&entry.id);
            let mut gone: Vec<StoredCopy> = entry.shown.take_if(|_| is_broken).into_iter().collect();
            for (copy, arrival) in entry.arriving.drain(..) {
                orphans.extend(arrival.buffer());
                gone.push(copy);
            }
            for copy in gone {
                copy.bricks.is_lost.store(true, Ordering::Relaxed);
                orphans.extend(copy.ranges.iter().map(|ranges| ranges.values().buffer));
                pools.release(copy.bricks.pages.iter().copied());
            }
        }
        let copies_into = |id: ResourceId| {
            recording.steps.iter().any(|step| matches!(step, Step::CopyTexture { to, .. } if *to == id))
        };
        let lost = pools.forget(makes, copies_into, orphans);
        let is_lost = |bricks: &Bricks| bricks.pages.iter().any(|p| lost.contains(&pools::pool(*p)));
        for entry in &mut *entries {
            if let Some(copy) = entry.shown.take_if(|shown| is_lost(&shown.bricks)) {
                copy.bricks.is_lost.store(true, Ordering::Relaxed);
                orphans.extend(copy.ranges.iter().map(|ranges| ranges.values().buffer));
                let is_left = |page: &u32| !lost.contains(&pools::pool(*page));
                pools.release(copy.bricks.pages.iter().copied().filter(is_left));
            }
        }
        // What was made for later may be what there was no room for.
        let mut given_up = Recording::new();
        let was_ahead = pools.drop_ahead(|_| true, &mut given_up);
        orphans.extend(given_up.steps.iter().filter_map(|step| match step {
            Step::Free { id } => Some(*id),
            _ => None,
        }));
        // What the recording made is freed by who discards it.
        orphans.retain(|id| !makes(*id));
        store.entries.retain(|entry| entry.shown.is_some());
        // The same goes for light: there is none until there is more room.
        let gives_way = was_ahead || store.light > 0 && store.may_keep_light();
        store.releases += 1;
        store.without_light = Some(store.releases);
        let after = store.pools.lasting_bytes();
        if !gives_way {
            store.capacity = (after + (before - after.min(before)) / 4 * 3).min(store.capacity);
        }
        gives_way || (after < before && store.capacity - after.min(store.capacity) >= LEAST_BYTES)
    }

    /// Copies of volumes, whole if `budget` bytes suffice for that, and their value ranges; none of those of which nothing
    /// is there yet, for they come one after the other. Goes on with what arrives, and takes what it records from the
    /// budget.
    ///
    /// # Errors
    /// [`RenderError::NoRoom`] when there is none for the least of each. That room was made may be recorded then.
    pub(crate) fn acquire(
        &self,
        wanted: &[(Source, GridKey)],
        budget: &mut u64,
        recording: &mut Recording,
    ) -> Result<Vec<Option<SceneCopy>>, RenderError> {
        self.lock().acquire(wanted, budget, recording)
    }

    /// Whether a copy is the one that [`acquire`](Self::acquire) would give, and stays it.
    pub(crate) fn is_settled(&self, source: &Source, bricks: &Arc<Bricks>) -> bool {
        let store = self.lock();
        store.entry(source).is_some_and(|entry| {
            let is_shown = entry.shown.as_ref().is_some_and(|shown| Arc::ptr_eq(&shown.bricks, bricks));
            let is_final = bricks.factor == 1 || entry.tried == store.releases;
            is_shown && entry.arriving.is_empty() && is_final && !store.is_left_over(source)
        })
    }

    /// Whether [`acquire`](Self::acquire) would want a coarse copy that nobody has made.
    pub(crate) fn lacks_preparation(&self, source: &Source) -> bool {
        self.lock().coarse_first(source, false).is_some() && !is_prepared(source)
    }

    /// Whether [`make_ahead`](Self::make_ahead) has something to make for volumes that come when others leave, or is at it.
    pub(crate) fn lacks_textures(&self, coming: &[Source], leaving: &[WeakSource]) -> bool {
        let store = self.lock();
        store.pending(coming).next().is_some() || store.plan_ahead(coming, leaving).next().is_some()
    }

    /// Has the textures made in which volumes will lie, those that take a device long; `make` says whether it could. What
    /// the volumes do not use after all is freed with a later recording.
    pub(crate) fn make_ahead(
        &self,
        coming: &[Source],
        leaving: &[WeakSource],
        make: &mut dyn FnMut(&TextureOrder) -> bool,
    ) {
        let orders: Vec<TextureAhead> = {
            let mut store = self.lock();
            let orders: Vec<TextureAhead> = store.plan_ahead(coming, leaving).collect();
            store.pools.ahead.extend(orders.iter().cloned());
            // Also those that another thread is at: all are made when this ends.
            store.pending(coming).cloned().collect()
        };
        for ahead in orders {
            ahead.make(make);
        }
    }

    /// How often a coarse copy was made in an update, for nobody had before.
    pub(crate) fn unprepared(&self) -> u64 {
        self.lock().unprepared
    }

    /// The pools as kernels bind them.
    pub(crate) fn pool_textures(&self) -> Vec<ResourceId> {
        self.lock().pools.textures()
    }

    /// One over their texels along each axis.
    pub(crate) fn inverse_pool_sizes(&self) -> [[f32; 4]; POOL_COUNT] {
        self.lock().pools.inverse_sizes()
    }

    /// Records that everything is freed; scenes that go on have to be updated.
    pub fn free(&self, recording: &mut Recording) {
        let mut store = self.lock();
        for entry in std::mem::take(&mut store.entries) {
            entry.free(recording);
        }
        store.pools.free(recording);
        store.releases += 1;
    }

    fn lock(&self) -> MutexGuard<'_, Store> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store {
    fn entry(&self, source: &Source) -> Option<&Entry> {
        self.index(source).map(|index| &self.entries[index])
    }

    fn index(&self, source: &Source) -> Option<usize> {
        self.entries.iter().position(|entry| entry.source == *source)
    }

    fn acquire(
        &mut self,
        wanted: &[(Source, GridKey)],
        budget: &mut u64,
        recording: &mut Recording,
    ) -> Result<Vec<Option<SceneCopy>>, RenderError> {
        self.clock += 1;
        for (source, _) in wanted {
            let clock = self.clock;
            match self.index(source) {
                Some(index) => self.entries[index].asked = clock,
                None => self.entries.push(Entry::new(source, clock)),
            }
        }
        self.drop_dead(recording);
        self.pools.ensure_one_to_bind(recording);
        self.begin_arrivals(wanted, *budget, recording)?;
        self.pools.grow_on(budget, recording);
        let mut has_begun = false;
        for (source, key) in wanted {
            self.advance(source, *key, budget, &mut has_begun, recording);
        }
        self.drop_left_over(recording);
        self.pools.reclaim();
        self.pools.free_empty(recording);
        Ok(wanted.iter().map(|(source, key)| self.acquired(source, *key, recording)).collect())
    }

    /// Frees what belongs to volumes that nobody holds any more, and copies that were replaced.
    fn drop_dead(&mut self, recording: &mut Recording) {
        for id in self.orphans.drain(..) {
            recording.push(Step::Free { id });
        }
        let (dead, alive): (Vec<Entry>, Vec<Entry>) =
            std::mem::take(&mut self.entries).into_iter().partition(Entry::is_dead);
        self.entries = alive;
        for entry in dead {
            self.release_entry(entry, recording);
        }
        self.pools.reclaim();
    }

    fn release_entry(&mut self, entry: Entry, recording: &mut Recording) {
        self.releases += 1;
        for copy in entry.copies() {
            self.pools.retire(copy.bricks.clone());
        }
        entry.free(recording);
        self.pools.reclaim();
    }

    /// Gives up the volume that no scene shows and that was longest not asked for; what could stand in for others last.
    fn evict(&mut self, recording: &mut Recording) -> bool {
        let unused = |entry: &&Entry| entry.asked != self.clock && !entry.is_in_use();
        let stands_in = |other: &Entry| {
            let is_asked =
                |entry: &&Entry| entry.asked == self.clock && entry.source.is_of_same(&other.source);
            self.entries.iter().filter(is_asked).any(|entry| entry.shown.is_none())
        };
        let order = |entry: &&Entry| (stands_in(entry), entry.asked);
        let Some(oldest) = self.entries.iter().filter(unused).min_by_key(order) else {
            return false;
        };
        self.give_up(oldest.id, recording);
        true
    }

    fn give_up(&mut self, id: ResourceId, recording: &mut Recording) {
        let Some(index) = self.entries.iter().position(|entry| entry.id == id) else { return };
        let entry = self.entries.remove(index);
        self.release_entry(entry, recording);
    }

    fn acquired(&mut self, source: &Source, key: GridKey, recording: &mut Recording) -> Option<SceneCopy> {
        let index = self.index(source)?;
        match self.look_at(index, key, recording) {
            None => self.lend(source, key, recording),
            acquired => acquired,
        }
    }

    /// What is shown of an entry, with its value ranges.
    fn look_at(&mut self, index: usize, key: GridKey, recording: &mut Recording) -> Option<SceneCopy> {
        let Self { entries, pools, .. } = self;
        let shown = entries[index].shown.as_mut()?;
        let ranges = shown.want(key, recording);
        if !shown.ranges[ranges].is_whole() {
            let pages = recording.create_buffer_with("pages", &shown.bricks.pages);
            shown.ranges[ranges].record(&shown.bricks, pages, pools, u32::MAX, f64::INFINITY, recording);
            recording.push(Step::Free { id: pages });
        }
        Some(SceneCopy { bricks: shown.bricks.clone(), ranges: shown.ranges[ranges].values() })
    }
}

impl Bricks {
    pub fn is_lost(&self) -> bool {
        let is_lost = |copy: &Self| copy.is_lost.load(Ordering::Relaxed);
        is_lost(self) || self.lender.as_deref().is_some_and(is_lost)
    }
}

impl Entry {
    fn new(source: &Source, asked: u64) -> Self {
        Self {
            id: ids::next(),
            source: source.downgrade(),
            shown: None,
            borrowed: Weak::new(),
            arriving: VecDeque::new(),
            asked,
            tried: u64::MAX,
        }
    }

    fn copies(&self) -> impl Iterator<Item = &StoredCopy> {
        self.shown.iter().chain(self.arriving.iter().map(|(copy, _)| copy))
    }

    fn is_in_use(&self) -> bool {
        self.borrowed.strong_count() > 0 || self.copies().any(|copy| Arc::strong_count(&copy.bricks) > 1)
    }

    fn is_dead(&self) -> bool {
        self.source.is_gone() && !self.is_in_use()
    }

    fn free(self, recording: &mut Recording) {
        if let Some(shown) = self.shown {
            shown.free_ranges(recording);
        }
        for (copy, arrival) in self.arriving {
            copy.free_ranges(recording);
            arrival.free(recording);
        }
    }
}

impl StoredCopy {
    /// Sees to it that there are value ranges for a key, computed or not; returns which.
    fn want(&mut self, key: GridKey, recording: &mut Recording) -> usize {
        let known = self.ranges.iter().position(|ranges| ranges.key == key);
        known.unwrap_or_else(|| {
            self.ranges.push(Ranges::new(key, self.bricks.grid.dims, recording));
            self.ranges.len() - 1
        })
    }

    fn free_ranges(&self, recording: &mut Recording) {
        for ranges in &self.ranges {
            ranges.free(recording);
        }
    }
}

/// Texels of a brick.
const TEXELS: u64 = (BRICK_TEXELS as u64).pow(3);
