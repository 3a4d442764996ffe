//! The scene's volumes on the GPU: their voxels in one atlas, and the value ranges that majorants are made from.

use std::sync::Arc;

use lumivox_core::{Filter, Volume};

use super::atlas::{self, Arrangement, Atlas};
use super::value_ranges::ValueRangeGrid;
use super::{DeviceLimits, Placed};
use crate::error::RenderError;
use crate::recording::{Recording, ResourceId};

/// One volume, shared by all its instances.
#[derive(Debug)]
pub(super) struct CachedVolume {
    pub volume: Arc<Volume>,
    pub grid: ValueRangeGrid,
    /// The grid's first cell in the buffer of ranges.
    pub range_offset: usize,
}

/// All volumes of a scene.
#[derive(Debug, Default)]
pub(super) struct CachedVolumes {
    pub list: Vec<CachedVolume>,
    pub atlas: Option<Atlas>,
    pub value_ranges: Option<ResourceId>,
    grid_settings: GridSettings,
}

/// What decides a grid, besides its volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct GridSettings {
    /// Whether some volume is filtered wider than linearly.
    pub wide_filter: bool,
    /// Side of a cell in voxels, where the suitable one is not wanted.
    pub cell_size: Option<usize>,
}

impl GridSettings {
    pub fn cell_size(&self, volume: &Volume) -> usize {
        self.cell_size.unwrap_or_else(|| ValueRangeGrid::suitable_cell_size(volume))
    }
}

/// Each volume once, in the order of its first instance.
pub(super) fn distinct(instances: &[Placed<'_>]) -> Vec<Arc<Volume>> {
    let mut volumes: Vec<Arc<Volume>> = vec![];
    for placed in instances {
        if !volumes.iter().any(|v| Arc::ptr_eq(v, &placed.instance.volume)) {
            volumes.push(placed.instance.volume.clone());
        }
    }
    volumes
}

impl CachedVolumes {
    /// The place of a volume in the list.
    pub fn index(&self, volume: &Arc<Volume>) -> usize {
        self.list
            .iter()
            .position(|v| Arc::ptr_eq(&v.volume, volume))
            .expect("every placed volume is in the list")
    }

    /// Finds room on the device for `wanted`; `None` if those are the volumes that there are.
    pub fn arrange(
        &self,
        wanted: &[Arc<Volume>],
        limits: &DeviceLimits,
    ) -> Result<Option<Arrangement>, RenderError> {
        let same = self.atlas.is_some()
            && wanted.len() == self.list.len()
            && wanted.iter().zip(&self.list).all(|(a, b)| Arc::ptr_eq(a, &b.volume));
        if same { Ok(None) } else { atlas::arrange(wanted, limits.max_texture_3d).map(Some) }
    }

    /// Records what differs; returns whether anything did. The arrangement is that of [`arrange`](Self::arrange).
    pub fn update(
        &mut self,
        wanted: Vec<Arc<Volume>>,
        arrangement: Option<Arrangement>,
        settings: GridSettings,
        recording: &mut Recording,
    ) -> bool {
        if arrangement.is_none() && settings == self.grid_settings {
            return false;
        }
        if let Some(arrangement) = arrangement {
            // Freed first: two atlases at once could be more than the GPU holds.
            recording.free(self.atlas.take().map(|old| old.texture));
            self.atlas = Some(Atlas::record(&wanted, arrangement, recording));
        }
        let filter = if settings.wide_filter { Filter::Tricubic } else { Filter::Trilinear };
        // Grids that are as they should be stay.
        let mut old: Vec<CachedVolume> = std::mem::take(&mut self.list);
        let same_filter = settings.wide_filter == self.grid_settings.wide_filter;
        let mut range_offset = 0;
        for volume in wanted {
            let cell_size = settings.cell_size(&volume);
            let kept = old.iter().position(|o| {
                same_filter && Arc::ptr_eq(&o.volume, &volume) && o.grid.cell_size == cell_size
            });
            let grid = match kept {
                Some(index) => old.swap_remove(index).grid,
                None => ValueRangeGrid::new(&volume, filter, cell_size),
            };
            let cells = grid.ranges.len();
            self.list.push(CachedVolume { volume, grid, range_offset });
            range_offset += cells;
        }
        self.grid_settings = settings;
        let packed: Vec<u32> = self.list.iter().flat_map(|v| v.grid.packed()).collect();
        recording.free(self.value_ranges.take());
        self.value_ranges = Some(recording.create_buffer_with("value ranges", &packed));
        true
    }

    pub fn free(&mut self, recording: &mut Recording) {
        recording.free(self.atlas.take().map(|a| a.texture));
        recording.free(self.value_ranges.take());
        self.list.clear();
    }
}
