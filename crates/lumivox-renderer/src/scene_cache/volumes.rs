//! The scene's volumes on the GPU: their voxels in one atlas, and the value ranges that majorants are made from.

use std::sync::Arc;

use lumivox_core::{Filter, Volume};

use super::atlas::{self, Arrangement, Atlas, Slot};
use super::value_ranges::{GridKey, ValueRangeGrid};
use super::{DeviceLimits, Placed};
use crate::error::RenderError;
use crate::recording::{Payload, Recording, ResourceId, Step};

/// One volume, shared by all its instances.
#[derive(Debug)]
pub(super) struct CachedVolume {
    pub volume: Arc<Volume>,
    pub grid: Arc<ValueRangeGrid>,
    /// Its place in the atlas.
    pub slot: Slot,
    /// The grid's first cell in the buffer of ranges.
    pub range_offset: usize,
}

/// All volumes of a scene.
#[derive(Debug, Default)]
pub(super) struct CachedVolumes {
    pub list: Vec<CachedVolume>,
    pub atlas: Option<Atlas>,
    pub value_ranges: Option<ResourceId>,
    /// Cells that the buffer of ranges has room for.
    range_capacity: usize,
}

/// How the wanted volumes come into the atlas.
pub(super) enum Placement {
    /// A new one, with all of them.
    Anew(Arrangement),
    /// The one that there is: the slot of each.
    InPlace(Vec<Slot>),
}

/// Side of a volume's cells in voxels: the suitable one, unless another is wanted.
pub(super) fn cell_size(volume: &Volume, wanted: Option<usize>) -> usize {
    wanted.unwrap_or_else(|| ValueRangeGrid::suitable_cell_size(volume))
}

/// Each volume once, in the order of its first instance, and the grid that its filters need.
pub(super) fn distinct(
    instances: &[Placed<'_>],
    wanted_cell_size: Option<usize>,
) -> Vec<(Arc<Volume>, GridKey)> {
    let mut volumes: Vec<(Arc<Volume>, GridKey)> = vec![];
    for placed in instances {
        let volume = &placed.instance.volume;
        let wide = placed.medium.filter == Filter::Tricubic;
        match volumes.iter_mut().find(|(known, _)| Arc::ptr_eq(known, volume)) {
            Some((_, key)) => key.wide |= wide,
            None => {
                let cell_size = cell_size(volume, wanted_cell_size);
                volumes.push((volume.clone(), GridKey { wide, cell_size }));
            }
        }
    }
    volumes
}

impl CachedVolumes {
    /// The place of a volume in the list.
    pub fn index(&self, volume: &Arc<Volume>) -> usize {
        self.position(volume).expect("every placed volume is in the list")
    }

    fn position(&self, volume: &Arc<Volume>) -> Option<usize> {
        self.list.iter().position(|v| Arc::ptr_eq(&v.volume, volume))
    }

    /// Finds room on the device for `wanted`.
    pub fn arrange(
        &self,
        wanted: &[(Arc<Volume>, GridKey)],
        limits: &DeviceLimits,
    ) -> Result<Placement, RenderError> {
        let Some(atlas) = &self.atlas else {
            return atlas::arrange(wanted, limits.max_texture_3d).map(Placement::Anew);
        };
        // Those that are there stay; others take the tightest slot of those that have gone.
        let stays = |v: &&CachedVolume| wanted.iter().any(|(volume, _)| Arc::ptr_eq(volume, &v.volume));
        let unchanged = self.list.len() == wanted.len() && self.list.iter().all(|v| stays(&v));
        let gone = self.list.iter().filter(|v| !stays(v)).map(|v| v.slot);
        let mut free: Vec<Slot> = atlas.free.iter().copied().chain(gone).collect();
        let mut slots = Vec::with_capacity(wanted.len());
        for (volume, _) in wanted {
            let slot = match self.position(volume) {
                Some(index) => Some(self.list[index].slot),
                None if !atlas.holds(volume) => None,
                None => {
                    let fits = (0..free.len()).filter(|&i| free[i].fits(volume.dims()));
                    fits.min_by_key(|&i| free[i].voxels()).map(|i| free.swap_remove(i))
                }
            };
            slots.extend(slot);
        }
        if unchanged {
            return Ok(Placement::InPlace(slots));
        }
        let anew = atlas::arrange(wanted, limits.max_texture_3d);
        // A much larger texture than is needed is not kept.
        let is_too_large = |anew: &Arrangement| atlas.voxels() > 2 * atlas::voxels(anew.size);
        if slots.len() == wanted.len() && !anew.as_ref().is_ok_and(is_too_large) {
            return Ok(Placement::InPlace(slots));
        }
        anew.map(Placement::Anew)
    }

    /// Records what differs; returns whether anything did. The placement is that of [`arrange`](Self::arrange). Counts
    /// in `unprepared` what it had to compute.
    pub fn update(
        &mut self,
        wanted: Vec<(Arc<Volume>, GridKey)>,
        placement: Placement,
        unprepared: &mut u64,
        recording: &mut Recording,
    ) -> bool {
        let mut changed = false;
        let slots = match placement {
            Placement::InPlace(slots) => slots,
            Placement::Anew(arrangement) => {
                // Freed first: two atlases at once could be more than the GPU holds.
                recording.free(self.atlas.take().map(|old| old.texture));
                self.atlas = Some(Atlas::new(&wanted, arrangement.size, recording));
                self.list.clear();
                changed = true;
                arrangement.slots
            }
        };
        let atlas = self.atlas.as_mut().expect("made above where there was none");
        let before: Vec<Slot> = self.list.iter().map(|v| v.slot).collect();
        // A volume takes the place in the list, too, of the one whose slot it takes: what follows need not move.
        let mut incoming: Vec<Option<(Arc<Volume>, GridKey, Slot)>> =
            wanted.into_iter().zip(slots).map(|((volume, key), slot)| Some((volume, key, slot))).collect();
        let mut list = Vec::with_capacity(incoming.len());
        for old in std::mem::take(&mut self.list) {
            let taken =
                incoming.iter_mut().find(|i| i.as_ref().is_some_and(|(_, _, slot)| *slot == old.slot));
            match taken.and_then(Option::take) {
                Some(new) => list.push((new, Some(old))),
                None => changed = true,
            }
        }
        list.extend(incoming.into_iter().flatten().map(|new| (new, None)));

        let mut range_offset = 0;
        let mut stale = vec![];
        for ((volume, key, slot), old) in list {
            let (grid, computed) = key.grid(&volume);
            *unprepared += u64::from(computed);
            if !old.as_ref().is_some_and(|old| Arc::ptr_eq(&old.volume, &volume)) {
                atlas.record_upload(&volume, slot, recording);
                changed = true;
            }
            let same_ranges =
                old.is_some_and(|old| Arc::ptr_eq(&old.grid, &grid) && old.range_offset == range_offset);
            if !same_ranges {
                stale.push(self.list.len());
            }
            let cells = grid.ranges.len();
            self.list.push(CachedVolume { volume, grid, slot, range_offset });
            range_offset += cells;
        }
        let used = |slot: &Slot| self.list.iter().any(|v| v.slot == *slot);
        atlas.free.extend(before);
        atlas.free.retain(|slot| !used(slot));
        self.update_ranges(range_offset, &stale, recording);
        changed | !stale.is_empty()
    }

    /// Uploads the ranges of the volumes `stale`, or of all where the buffer does not suit the number of cells.
    fn update_ranges(&mut self, cells: usize, stale: &[usize], recording: &mut Recording) {
        let suits = (cells..=cells.saturating_mul(4)).contains(&self.range_capacity);
        let buffer = match self.value_ranges.filter(|_| suits) {
            Some(buffer) => buffer,
            None => {
                recording.free(self.value_ranges.take());
                self.range_capacity = cells;
                let packed: Vec<u32> = self.list.iter().flat_map(|v| v.grid.packed()).collect();
                self.value_ranges = Some(recording.create_buffer_with("value ranges", &packed));
                return;
            }
        };
        for &index in stale {
            let volume = &self.list[index];
            let offset = volume.range_offset as u64 * 4;
            let data = Payload::copy_of(&volume.grid.packed());
            recording.push(Step::WriteBuffer { id: buffer, offset, data });
        }
    }

    pub fn free(&mut self, recording: &mut Recording) {
        recording.free(self.atlas.take().map(|a| a.texture));
        recording.free(self.value_ranges.take());
        self.list.clear();
    }
}
