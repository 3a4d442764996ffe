//! The instances' transfer functions on the GPU, and the majorants that follow from them.

use std::sync::Arc;

use lumivox_core::{TransferFunction, Volume};
use lumivox_shaders::Kernel;
use lumivox_shaders::layout::{MajorantParams, TABLE_PAIRS};

use super::atlas::TexelScale;
use super::transfer_table::TransferTable;
use super::value_ranges::ValueRangeGrid;
use super::volumes::{CachedVolume, CachedVolumes};
use super::{Placed, check_binding};
use crate::error::RenderError;
use crate::recording::{Payload, Recording, ResourceId, Step};

/// An instance's table, and where its majorants are.
#[derive(Debug)]
struct CachedTable {
    volume: Arc<Volume>,
    /// What the majorants were made of.
    grid: Arc<ValueRangeGrid>,
    transfer_function: TransferFunction,
    table: TransferTable,
    grid_offset: usize,
}

/// The buffers, each for all instances.
#[derive(Clone, Copy, Debug)]
pub(super) struct TableBuffers {
    pub tables: ResourceId,
    pub majorants: ResourceId,
}

/// All tables of a scene.
#[derive(Debug, Default)]
pub(super) struct CachedTables {
    list: Vec<CachedTable>,
    pub buffers: Option<TableBuffers>,
    /// Instances and cells that the buffers have room for.
    capacity: [usize; 2],
}

/// Bytes of an instance's table.
const TABLE_BYTES: u64 = 8 * TABLE_PAIRS as u64;

/// Whether the device has room for the tables and majorants of instances with so many cells each.
pub(super) fn check(cells: impl ExactSizeIterator<Item = usize>, limit: u64) -> Result<(), RenderError> {
    check_binding("transfer functions", cells.len() as u64 * TABLE_BYTES, limit, "Leave some volumes out")?;
    let majorants = cells.map(|n| n as u64).sum::<u64>() * 4;
    check_binding("majorant grid", majorants, limit, "Leave some volumes out")
}

impl CachedTables {
    /// Records what differs; returns whether anything did.
    pub fn update(
        &mut self,
        instances: &[Placed<'_>],
        volumes: &CachedVolumes,
        recording: &mut Recording,
    ) -> bool {
        let cached: Vec<&CachedVolume> =
            instances.iter().map(|p| &volumes.list[volumes.index(&p.instance.volume)]).collect();
        let needed = [cached.len(), cached.iter().map(|v| v.grid.ranges.len()).sum()];
        let mut changed = self.list.len() != cached.len();
        let suits = (0..2).all(|i| (needed[i]..=needed[i].saturating_mul(4)).contains(&self.capacity[i]));
        if self.buffers.is_none() || !suits {
            self.allocate(needed, recording);
            changed = true;
        }
        self.list.truncate(cached.len());
        let buffers = self.buffers.expect("allocated above");
        let value_ranges = volumes.value_ranges.expect("volumes are updated before tables");
        let mut grid_offset = 0;
        for (index, (placed, cached)) in instances.iter().zip(cached).enumerate() {
            let function = &placed.medium.transfer_function;
            let old = self.list.get(index);
            let same_table = old
                .filter(|old| Arc::ptr_eq(&old.volume, &cached.volume) && old.transfer_function == *function);
            let same_majorants = same_table
                .is_some_and(|old| Arc::ptr_eq(&old.grid, &cached.grid) && old.grid_offset == grid_offset);
            if !same_majorants {
                let table = match same_table {
                    Some(old) => old.table.clone(),
                    None => TransferTable::new(function, &cached.volume),
                };
                record_table(index, grid_offset, &table, cached, value_ranges, buffers, recording);
                let entry = CachedTable {
                    volume: cached.volume.clone(),
                    grid: cached.grid.clone(),
                    transfer_function: function.clone(),
                    table,
                    grid_offset,
                };
                match self.list.get_mut(index) {
                    Some(old) => *old = entry,
                    None => self.list.push(entry),
                }
                changed = true;
            }
            grid_offset += cached.grid.ranges.len();
        }
        changed
    }

    /// Makes room for the tables of so many instances, and for so many cells of their majorant grids.
    fn allocate(&mut self, [instances, cells]: [usize; 2], recording: &mut Recording) {
        self.free(recording);
        self.capacity = [instances, cells];
        self.buffers = Some(TableBuffers {
            majorants: recording.create_buffer("majorants", cells as u64 * 4),
            tables: recording.create_buffer("transfer functions", instances as u64 * TABLE_BYTES),
        });
    }

    /// An instance's table and the first cell of its majorants.
    pub fn get(&self, index: usize) -> (&TransferTable, usize) {
        (&self.list[index].table, self.list[index].grid_offset)
    }

    pub fn free(&mut self, recording: &mut Recording) {
        if let Some(buffers) = self.buffers.take() {
            for id in [buffers.majorants, buffers.tables] {
                recording.push(Step::Free { id });
            }
        }
        self.list.clear();
    }
}

/// Uploads an instance's table and has the GPU make its majorants.
fn record_table(
    index: usize,
    grid_offset: usize,
    table: &TransferTable,
    cached: &CachedVolume,
    value_ranges: ResourceId,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    let data = Payload::copy_of(&table.pairs());
    recording.push(Step::WriteBuffer { id: buffers.tables, offset: index as u64 * TABLE_BYTES, data });

    let maxima = recording.create_buffer_with("range maxima", &table.range_maxima());
    let (scale, bias) = table.coordinate(TexelScale::of(&cached.volume));
    let cell_count = cached.grid.ranges.len() as u32;
    let [group, _] = Kernel::MajorantGrid.workgroup_size();
    let groups = cell_count.div_ceil(group);
    let workgroups = [groups.min(1024), groups.div_ceil(1024)];
    let params = MajorantParams {
        cell_count,
        range_offset: cached.range_offset as u32,
        majorant_offset: grid_offset as u32,
        row_length: workgroups[0] * group,
        table_scale: scale as f32,
        table_bias: bias as f32,
        padding: [0; 2],
    };
    recording.push(Step::Dispatch {
        kernel: Kernel::MajorantGrid,
        uniforms: vec![bytemuck::bytes_of(&params).to_vec()],
        resources: vec![value_ranges, maxima, buffers.majorants],
        workgroups,
    });
    recording.push(Step::Free { id: maxima });
}
