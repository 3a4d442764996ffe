//! Room for light that is kept in the volumes (`live/light.rs`): it has what voxels leave of the store's
//! [capacity](VoxelStore::set_capacity), and gives way to them.

use super::VoxelStore;

/// Bytes of a view's light, counted for as long as this is held.
#[derive(Debug)]
pub(crate) struct LightRoom {
    store: VoxelStore,
    bytes: u64,
}

impl LightRoom {
    /// How many there are.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// How many there might be.
    pub fn most(&self) -> u64 {
        let store = self.store.lock();
        self.bytes + store.left_by_voxels().saturating_sub(store.light)
    }

    /// Has others in their place.
    pub fn resize(&mut self, bytes: u64) {
        let mut store = self.store.lock();
        store.light = store.light - self.bytes + bytes;
        self.bytes = bytes;
    }

    /// Whether the voxels that have come since still leave it.
    pub fn is_left(&self) -> bool {
        let store = self.store.lock();
        store.may_keep_light() && store.light <= store.left_by_voxels()
    }
}

impl Drop for LightRoom {
    fn drop(&mut self) {
        self.resize(0);
    }
}

impl VoxelStore {
    /// Bytes that the light takes which is kept in volumes. With the voxels it stays within the [capacity](Self::set_capacity).
    pub fn light_bytes(&self) -> u64 {
        self.lock().light
    }

    /// Learns that the device has no memory for light: none is kept until there is more room.
    pub(crate) fn refuse_light(&self) {
        let mut store = self.lock();
        store.without_light = Some(store.releases);
    }

    /// Room for as much as there is of `most` bytes of light; `None` where that is less than `least`.
    pub(crate) fn light_room(&self, least: u64, most: u64) -> Option<LightRoom> {
        let mut store = self.lock();
        let left = store.left_by_voxels().saturating_sub(store.light);
        let bytes = most.min(left);
        if !store.may_keep_light() || bytes < least {
            return None;
        }
        store.light += bytes;
        drop(store);
        Some(LightRoom { store: self.clone(), bytes })
    }
}

impl super::Store {
    pub(super) fn may_keep_light(&self) -> bool {
        self.without_light != Some(self.releases)
    }

    fn left_by_voxels(&self) -> u64 {
        self.capacity.saturating_sub(self.pools.lasting_bytes())
    }
}
