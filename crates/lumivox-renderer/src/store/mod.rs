//! The voxels on a device, shared by all its scenes: what one scene has brought, another finds.
//!
//! A volume is cut into [`bricks`], which lie in the [`pools`] wherever there is room. It is known by its identity: its
//! voxels stay as long as somebody, on the GPU or off it, holds the [`Volume`]; what no scene shows goes first where room
//! is scarce. A large volume arrives a little with every frame; until it is whole, a coarse copy of it that was
//! [prepared](prepare_volume) stands in its place. What there is no room for is reduced instead of refused.

mod bricks;
mod pools;
mod texels;
mod value_ranges;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use lumivox_core::Volume;
use lumivox_shaders::constants::BRICK_TEXELS;
use lumivox_shaders::layout::POOL_COUNT;

use self::bricks::Arrival;
pub(crate) use self::bricks::BrickGrid;
use self::pools::Pools;
pub(crate) use self::texels::TexelScale;
use self::value_ranges::Ranges;
pub(crate) use self::value_ranges::{GridKey, MAX_CELL_SIZE, ValueRanges, grid};
use crate::derived::Derived;
use crate::error::RenderError;
use crate::ids;
use crate::recording::{Recording, ResourceId, Step, TextureFormat};
use crate::scene_cache::DeviceLimits;

/// Bytes that any frame can bring to the device: volumes that are no larger need no coarse copy.
const QUICK_BYTES: u64 = 4 << 20;

/// Voxels of a coarse copy at most.
const COARSE_VOXELS: usize = 128 * 128 * 128;

/// Halvings after which there is no room for anything.
const MAX_FACTOR: u32 = 64;

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

/// A copy of a volume in the pools, perhaps a reduced one. Its bricks are its own as long as somebody holds it.
#[derive(Debug)]
pub(crate) struct Resident {
    /// Of the volume, not of the copy.
    pub source: ResourceId,
    /// Voxels of the volume along an axis for one of the copy.
    pub factor: u32,
    pub bricks: BrickGrid,
    /// Where each brick lies.
    pub pages: Vec<u32>,
}

/// What a scene gets of a volume.
#[derive(Clone, Debug)]
pub(crate) struct Acquired {
    pub resident: Arc<Resident>,
    pub ranges: ValueRanges,
}

#[derive(Debug)]
struct Store {
    limits: DeviceLimits,
    pools: Pools,
    entries: Vec<Entry>,
    /// Bytes that the pools may take together.
    capacity: u64,
    /// Goes up when room is made.
    releases: u64,
    clock: u64,
    unprepared: u64,
    /// Buffers that nobody uses any more, to be freed with the next recording.
    orphans: Vec<ResourceId>,
}

/// A volume that some scene has asked for.
#[derive(Debug)]
struct Entry {
    id: ResourceId,
    volume: Weak<Volume>,
    shown: Option<CopyOnDevice>,
    arriving: Option<(CopyOnDevice, Arrival)>,
    /// When it was asked for last.
    asked: u64,
    /// Releases of room when it was last tried to have it whole.
    tried: u64,
}

#[derive(Debug)]
struct CopyOnDevice {
    resident: Arc<Resident>,
    ranges: Vec<Ranges>,
}

/// Coarse copies that were made ahead, as 16-bit fractions in the order of bricks.
static COARSE: Derived<Volume, (), Vec<u16>> = Derived::new();

/// Makes ahead, on this thread and rayon's, what a store shows of a large volume while it arrives: best where it is
/// loaded. Nothing to do for small ones, or if it was done before.
pub fn prepare_volume(volume: &Arc<Volume>) {
    if needs_coarse_copy(volume) {
        COARSE.get_or(volume, (), || bricks::fractions_of_all(volume, coarse_factor(volume)));
    }
}

/// Whether [`prepare_volume`] has nothing to do.
pub(crate) fn is_prepared(volume: &Arc<Volume>) -> bool {
    !needs_coarse_copy(volume) || COARSE.get(volume, &()).is_some()
}

fn needs_coarse_copy(volume: &Volume) -> bool {
    // What pools take for it, at 16 bits.
    2 * volume.voxel_count() as u64 > QUICK_BYTES
}

/// The least power of two by which the copy becomes small.
fn coarse_factor(volume: &Volume) -> u32 {
    let voxels = |factor: &u32| {
        volume.dims().iter().map(|n| n.div_ceil(*factor as usize)).product::<usize>() <= COARSE_VOXELS
    };
    (1..16).map(|power| 1 << power).find(voxels).unwrap_or(1 << 16)
}

impl VoxelStore {
    /// An empty store for a device.
    pub fn new(limits: DeviceLimits) -> Self {
        Self(Arc::new(Mutex::new(Store {
            limits,
            pools: Pools::new(&limits),
            entries: vec![],
            capacity: u64::MAX,
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

    /// Bounds the bytes that voxels may take on the device. What there is no room for arrives reduced.
    pub fn set_capacity(&self, bytes: u64) {
        self.lock().capacity = bytes;
    }

    /// Bytes that voxels take on the device, the room for more included.
    pub fn bytes(&self) -> u64 {
        self.lock().pools.bytes()
    }

    /// How much there is of a volume; `None` where no scene has asked for it.
    pub fn resolution(&self, volume: &Arc<Volume>) -> Option<Resolution> {
        let store = self.lock();
        let entry = store.entry(volume)?;
        let factor = entry.shown.as_ref()?.resident.factor;
        Some(Resolution { factor, arriving: entry.arriving.is_some() })
    }

    /// Volumes that there is no room for but reduced.
    pub fn reduced(&self) -> usize {
        let is_reduced = |entry: &&Entry| {
            entry.arriving.is_none() && entry.shown.as_ref().is_some_and(|shown| shown.resident.factor > 1)
        };
        self.lock().entries.iter().filter(is_reduced).count()
    }

    /// Records that what belonged to volumes which nobody holds any more is freed.
    pub fn collect(&self, recording: &mut Recording) {
        let mut store = self.lock();
        store.drop_dead(recording);
        store.pools.free_empty(recording);
    }

    /// Learns that the device refused a recording for want of memory. What the recording made is gone; volumes that were
    /// in it arrive anew, reduced to what there is room for. Scenes that show them have to be updated.
    pub fn refused(&self, recording: &Recording) {
        let mut store = self.lock();
        let before = store.pools.bytes();
        let makes = |id: ResourceId| {
            recording.steps.iter().any(|step| match step {
                Step::CreateTexture { id: made, .. } | Step::CreateBuffer { id: made, .. } => *made == id,
                _ => false,
            })
        };
        let lost = store.pools.forget(makes);
        let is_lost =
            |resident: &Resident| resident.pages.iter().any(|page| lost.contains(&pools::pool(*page)));
        let after = store.pools.bytes();
        store.capacity = (after + (before - after) / 4 * 3).min(store.capacity);
        let Store { entries, pools, orphans, .. } = &mut *store;
        for entry in entries {
            let arriving = entry.arriving.take().map(|(copy, arrival)| {
                orphans.extend(arrival.buffer());
                copy
            });
            let lost_copy = entry.shown.take_if(|shown| is_lost(&shown.resident));
            for copy in [arriving, lost_copy].into_iter().flatten() {
                orphans.extend(copy.ranges.iter().map(|ranges| ranges.values().buffer));
                pools.release(
                    copy.resident.pages.iter().copied().filter(|p| !lost.contains(&pools::pool(*p))),
                );
            }
        }
        // What the recording made is freed by who discards it.
        orphans.retain(|id| !makes(*id));
        store.entries.retain(|entry| entry.shown.is_some());
        store.releases += 1;
    }

    /// Copies of volumes, whole if `budget` bytes suffice for that, and their value ranges. Goes on with what arrives, and
    /// takes what it records from the budget.
    ///
    /// # Errors
    /// [`RenderError::NoRoom`] when there is none for the least of each. That room was made may be recorded then.
    pub(crate) fn acquire(
        &self,
        wanted: &[(Arc<Volume>, GridKey)],
        budget: &mut u64,
        recording: &mut Recording,
    ) -> Result<Vec<Acquired>, RenderError> {
        self.lock().acquire(wanted, budget, recording)
    }

    /// Whether a copy is the one that [`acquire`](Self::acquire) would give, and stays it.
    pub(crate) fn is_settled(&self, volume: &Arc<Volume>, resident: &Arc<Resident>) -> bool {
        let store = self.lock();
        store.entry(volume).is_some_and(|entry| {
            let is_shown = entry.shown.as_ref().is_some_and(|shown| Arc::ptr_eq(&shown.resident, resident));
            is_shown && entry.arriving.is_none() && (resident.factor == 1 || entry.tried == store.releases)
        })
    }

    /// Whether [`acquire`](Self::acquire) would want a coarse copy that nobody has made.
    pub(crate) fn lacks_preparation(&self, volume: &Arc<Volume>) -> bool {
        let has_any = self.lock().entry(volume).is_some_and(|entry| entry.shown.is_some());
        !has_any && !is_prepared(volume)
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
    fn entry(&self, volume: &Arc<Volume>) -> Option<&Entry> {
        self.index(volume).map(|index| &self.entries[index])
    }

    fn index(&self, volume: &Arc<Volume>) -> Option<usize> {
        // A weak reference keeps the address from being used again.
        self.entries.iter().position(|entry| std::ptr::eq(entry.volume.as_ptr(), Arc::as_ptr(volume)))
    }

    fn acquire(
        &mut self,
        wanted: &[(Arc<Volume>, GridKey)],
        budget: &mut u64,
        recording: &mut Recording,
    ) -> Result<Vec<Acquired>, RenderError> {
        self.clock += 1;
        for (volume, _) in wanted {
            let clock = self.clock;
            match self.index(volume) {
                Some(index) => self.entries[index].asked = clock,
                None => self.entries.push(Entry::new(volume, clock)),
            }
        }
        self.drop_dead(recording);
        self.pools.ensure_one_to_bind(recording);
        // First, so that where there is one pool it grows around something small.
        for (volume, key) in wanted {
            self.show_something(volume, *key, budget, recording);
        }
        self.begin_arrivals(wanted, recording)?;
        for (volume, key) in wanted {
            self.advance(volume, *key, budget, recording);
        }
        self.pools.reclaim();
        self.pools.free_empty(recording);
        Ok(wanted.iter().map(|(volume, key)| self.acquired(volume, *key, recording)).collect())
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
            self.pools.retire(copy.resident.clone());
        }
        entry.free(recording);
        self.pools.reclaim();
    }

    /// Makes room for what is not there, reduced as far as it must be, and for those that could be finer by now.
    fn begin_arrivals(
        &mut self,
        wanted: &[(Arc<Volume>, GridKey)],
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let mut new: Vec<(usize, Arc<Volume>, u32)> = vec![];
        for (volume, _) in wanted {
            let Some(index) = self.index(volume) else { continue };
            let entry = &self.entries[index];
            let is_coarse = entry.shown.as_ref().is_some_and(|shown| shown.resident.factor > 1);
            let is_sparse =
                entry.shown.as_ref().is_some_and(|shown| self.pools.is_left(&shown.resident.pages));
            let may_be_finer = is_coarse && entry.tried != self.releases;
            if entry.arriving.is_none() && (entry.shown.is_none() || may_be_finer || is_sparse) {
                new.push((index, volume.clone(), bricks::least_factor(volume.dims())));
            }
        }
        if new.is_empty() {
            return Ok(());
        }
        let mut capacity = self.capacity;
        let copies = loop {
            match self.allocate(&new, capacity, recording) {
                Some(copies) => break copies,
                None if self.evict(recording) => {
                    // Entries have moved.
                    for (index, volume, _) in &mut new {
                        *index = self.index(volume).expect("what is wanted is not evicted");
                    }
                }
                None => {
                    let largest = new.iter_mut().max_by_key(|(_, volume, factor)| {
                        bricks::BrickGrid::new(volume.dims(), *factor).count()
                    });
                    match largest.filter(|(.., factor)| *factor < MAX_FACTOR) {
                        Some((.., factor)) => *factor *= 2,
                        // Little is better than nothing.
                        None if capacity < u64::MAX => capacity = u64::MAX,
                        None => return Err(RenderError::NoRoom { count: wanted.len() }),
                    }
                }
            }
        };
        let releases = self.releases;
        for ((index, volume, factor), resident) in new.into_iter().zip(copies) {
            let entry = &mut self.entries[index];
            entry.tried = releases;
            // No finer than what there is: it stays.
            let better = entry.shown.as_ref().is_none_or(|shown| {
                let before = &shown.resident;
                factor < before.factor || factor == before.factor && self.pools.is_left(&before.pages)
            });
            if better {
                let resident = Arc::new(Resident { source: entry.id, ..resident });
                let arrival = Arrival::new(&volume);
                entry.arriving = Some((CopyOnDevice { resident, ranges: vec![] }, arrival));
            } else {
                self.pools.release(resident.pages);
            }
        }
        Ok(())
    }

    /// Bricks for volumes reduced by factors; `None` without room.
    fn allocate(
        &mut self,
        new: &[(usize, Arc<Volume>, u32)],
        capacity: u64,
        recording: &mut Recording,
    ) -> Option<Vec<Resident>> {
        let grids: Vec<(TextureFormat, BrickGrid)> = new
            .iter()
            .map(|(_, volume, factor)| (self.pools.format(volume), BrickGrid::new(volume.dims(), *factor)))
            .collect();
        let pages = self.pools.allocate(&grids, capacity, recording)?;
        let residents = new.iter().zip(grids).zip(pages).map(|(((.., factor), (_, bricks)), pages)| {
            Resident { source: ResourceId(0), factor: *factor, bricks, pages }
        });
        Some(residents.collect())
    }

    /// Gives up the volume that no scene shows and that was longest not asked for.
    fn evict(&mut self, recording: &mut Recording) -> bool {
        let unused = |entry: &&Entry| entry.asked != self.clock && !entry.is_in_use();
        let Some(oldest) = self.entries.iter().filter(unused).min_by_key(|entry| entry.asked) else {
            return false;
        };
        let id = oldest.id;
        let index = self.entries.iter().position(|entry| entry.id == id).expect("it was just found");
        let entry = self.entries.remove(index);
        self.release_entry(entry, recording);
        true
    }

    /// A coarse copy at once for a volume of which nothing is there and that cannot arrive at once.
    fn show_something(
        &mut self,
        volume: &Arc<Volume>,
        key: GridKey,
        budget: &mut u64,
        recording: &mut Recording,
    ) {
        let Some(index) = self.index(volume) else { return };
        let format = self.pools.format(volume);
        let whole = BrickGrid::new(volume.dims(), 1).count();
        let comes_at_once = self.pools.bytes_of(format, whole) <= *budget || !needs_coarse_copy(volume);
        if comes_at_once || self.entries[index].copies().next().is_some() {
            return;
        }
        let factor = coarse_factor(volume);
        let bricks = BrickGrid::new(volume.dims(), factor);
        let Some(pages) = self.pools.allocate(&[(format, bricks)], u64::MAX, recording) else { return };
        let was_known = is_prepared(volume);
        prepare_volume(volume);
        self.unprepared += u64::from(!was_known);
        let pages = pages.into_iter().next().unwrap_or_default();
        let resident = Arc::new(Resident { source: self.entries[index].id, factor, bricks, pages });
        let mut arrival = Arrival::of_prepared(volume, COARSE.get(volume, &()));
        let mut copy = CopyOnDevice { resident, ranges: vec![] };
        copy.want(key, recording);
        let mut all = u64::MAX;
        arrival.advance(&copy.resident, &mut copy.ranges, &self.pools, &mut all, recording);
        arrival.free(recording);
        *budget = budget.saturating_sub(u64::MAX - all);
        self.entries[index].shown = Some(copy);
    }

    /// Brings more of a volume that is under way, all of it where nothing else can be shown, and shows it once it is whole.
    fn advance(&mut self, volume: &Arc<Volume>, key: GridKey, budget: &mut u64, recording: &mut Recording) {
        let Some(index) = self.index(volume) else { return };
        let entry = &mut self.entries[index];
        let Some((copy, arrival)) = &mut entry.arriving else { return };
        copy.want(key, recording);
        let mut all = u64::MAX;
        let budget = if entry.shown.is_some() { budget } else { &mut all };
        arrival.advance(&copy.resident, &mut copy.ranges, &self.pools, budget, recording);
        if !arrival.is_done(&copy.resident) {
            return;
        }
        if let Some((copy, arrival)) = entry.arriving.take() {
            arrival.free(recording);
            if let Some(before) = entry.shown.replace(copy) {
                before.free_ranges(recording);
                self.pools.retire(before.resident);
            }
        }
    }

    fn acquired(&mut self, volume: &Arc<Volume>, key: GridKey, recording: &mut Recording) -> Acquired {
        let index = self.index(volume).expect("every wanted volume has an entry");
        let Self { entries, pools, .. } = self;
        let shown = entries[index].shown.as_mut().expect("something of every wanted volume is shown");
        let ranges = shown.want(key, recording);
        if !shown.ranges[ranges].is_whole() {
            let pages = recording.create_buffer_with("pages", &shown.resident.pages);
            shown.ranges[ranges].record(&shown.resident, pages, pools, u32::MAX, recording);
            recording.push(Step::Free { id: pages });
        }
        Acquired { resident: shown.resident.clone(), ranges: shown.ranges[ranges].values() }
    }
}

impl Entry {
    fn new(volume: &Arc<Volume>, asked: u64) -> Self {
        Self {
            id: ids::next(),
            volume: Arc::downgrade(volume),
            shown: None,
            arriving: None,
            asked,
            tried: u64::MAX,
        }
    }

    fn copies(&self) -> impl Iterator<Item = &CopyOnDevice> {
        self.shown.iter().chain(self.arriving.iter().map(|(copy, _)| copy))
    }

    fn is_in_use(&self) -> bool {
        self.copies().any(|copy| Arc::strong_count(&copy.resident) > 1)
    }

    fn is_dead(&self) -> bool {
        self.volume.strong_count() == 0 && !self.is_in_use()
    }

    fn free(self, recording: &mut Recording) {
        if let Some(shown) = self.shown {
            shown.free_ranges(recording);
        }
        if let Some((copy, arrival)) = self.arriving {
            copy.free_ranges(recording);
            arrival.free(recording);
        }
    }
}

impl CopyOnDevice {
    /// Sees to it that there are value ranges for a key, computed or not; returns which.
    fn want(&mut self, key: GridKey, recording: &mut Recording) -> usize {
        let known = self.ranges.iter().position(|ranges| ranges.key == key);
        known.unwrap_or_else(|| {
            self.ranges.push(Ranges::new(key, self.resident.bricks.dims, recording));
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
