//! The instances' transfer functions on the GPU, and the majorants that follow from them.

use lumivox_core::{TransferFunction, Volume};
use lumivox_shaders::Kernel;
use lumivox_shaders::constants::BRICK_SIZE;
use lumivox_shaders::layout::{EmptySpaceParams, MajorantParams, TABLE_PAIRS};

use super::transfer_table::TransferTable;
use super::{Placed, acquired, check_binding};
use crate::error::RenderError;
use crate::recording::{Payload, Recording, ResourceId, Step};
use crate::store::{Acquired, Source, TexelScale, ValueRanges};

/// An instance's table, and where its majorants are.
#[derive(Debug)]
struct CachedTable {
    /// The volume.
    source: ResourceId,
    /// What the majorants were made of.
    ranges: ValueRanges,
    transfer_function: TransferFunction,
    table: TransferTable,
    grid_offset: usize,
}

/// The buffers, each for all instances.
#[derive(Clone, Copy, Debug)]
pub(super) struct TableBuffers {
    pub tables: ResourceId,
    /// Majorants of all, each beside its page.
    pub grids: ResourceId,
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
    let grids = cells.map(|n| n as u64).sum::<u64>() * CELL_BYTES;
    check_binding("majorant grid", grids, limit, "Leave some volumes out")
}

/// Bytes of a cell: its majorant and its page.
const CELL_BYTES: u64 = 8;

impl CachedTables {
    /// Records what differs; returns whether anything did.
    pub fn update(
        &mut self,
        instances: &[Placed<'_>],
        volumes: &[(Source, Acquired)],
        recording: &mut Recording,
    ) -> bool {
        let of = |placed: &Placed<'_>| acquired(volumes, placed);
        let cells: usize = instances.iter().map(|p| of(p).ranges.cells()).sum();
        let needed = [instances.len(), cells];
        let mut changed = self.list.len() != instances.len();
        let suits = (0..2).all(|i| (needed[i]..=needed[i].saturating_mul(4)).contains(&self.capacity[i]));
        if self.buffers.is_none() || !suits {
            self.allocate(needed, recording);
            changed = true;
        }
        self.list.truncate(instances.len());
        let buffers = self.buffers.expect("allocated above");
        let mut grid_offset = 0;
        for (index, placed) in instances.iter().enumerate() {
            let acquired @ Acquired { resident, ranges } = of(placed);
            let volume = &placed.instance.volume;
            let function = &placed.medium.transfer_function;
            let old = self.list.get(index);
            let same_table =
                old.filter(|old| old.source == resident.source && old.transfer_function == *function);
            let same_majorants =
                same_table.is_some_and(|old| old.ranges == *ranges && old.grid_offset == grid_offset);
            if !same_majorants {
                let table = match same_table {
                    Some(old) => old.table.clone(),
                    None => TransferTable::new(function, volume),
                };
                if same_table.is_none() {
                    let (offset, data) = (index as u64 * TABLE_BYTES, Payload::copy_of(&table.pairs()));
                    recording.push(Step::WriteBuffer { id: buffers.tables, offset, data });
                }
                record_majorants(grid_offset, &table, volume, acquired, buffers, recording);
                let entry = CachedTable {
                    source: resident.source,
                    ranges: *ranges,
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
            grid_offset += ranges.cells();
        }
        changed
    }

    /// Makes room for the tables of so many instances, and for so many cells of their majorant grids.
    fn allocate(&mut self, [instances, cells]: [usize; 2], recording: &mut Recording) {
        self.free(recording);
        self.capacity = [instances, cells];
        self.buffers = Some(TableBuffers {
            grids: recording.create_buffer("majorants", cells as u64 * CELL_BYTES),
            tables: recording.create_buffer("transfer functions", instances as u64 * TABLE_BYTES),
        });
    }

    /// An instance's table and the first cell of its majorants.
    pub fn get(&self, index: usize) -> (&TransferTable, usize) {
        (&self.list[index].table, self.list[index].grid_offset)
    }

    pub fn free(&mut self, recording: &mut Recording) {
        if let Some(buffers) = self.buffers.take() {
            for id in [buffers.grids, buffers.tables] {
                recording.push(Step::Free { id });
            }
        }
        self.list.clear();
    }
}

/// Has the GPU make an instance's majorants.
fn record_majorants(
    grid_offset: usize,
    table: &TransferTable,
    volume: &Volume,
    Acquired { resident, ranges }: &Acquired,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    let maxima = recording.create_buffer_with("range maxima", &table.range_maxima());
    let pages = recording.create_buffer_with("pages", &resident.pages);
    let (scale, bias) = table.coordinate(TexelScale::of(volume));
    let cell_count = ranges.cells() as u32;
    let [group, _] = Kernel::MajorantGrid.workgroup_size();
    let groups = cell_count.div_ceil(group);
    let workgroups = [groups.min(1024), groups.div_ceil(1024)];
    let params = MajorantParams {
        cell_count,
        majorant_offset: grid_offset as u32,
        row_length: workgroups[0] * group,
        table_scale: scale as f32,
        table_bias: bias as f32,
        cells_per_brick: BRICK_SIZE / ranges.cell_size,
        grid_dims: ranges.grid_dims,
        bricks: resident.bricks.counts,
        ..Default::default()
    };
    recording.push(Step::Dispatch {
        kernel: Kernel::MajorantGrid,
        uniforms: vec![bytemuck::bytes_of(&params).to_vec()],
        resources: vec![ranges.buffer, maxima, pages, buffers.grids],
        workgroups,
    });
    recording.push(Step::Free { id: maxima });
    recording.push(Step::Free { id: pages });
    record_empty_space(grid_offset, ranges, buffers, recording);
}

/// Has the GPU measure the empty space between an instance's majorants.
fn record_empty_space(
    grid_offset: usize,
    ranges: &ValueRanges,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    let kernel = Kernel::EmptySpace;
    let cell_count = ranges.cells() as u32;
    let [group, _] = kernel.workgroup_size();
    let groups = cell_count.div_ceil(group);
    let workgroups = [groups.min(1024), groups.div_ceil(1024)];
    let distances = recording.create_buffer("distances", 2 * 4 * u64::from(cell_count));
    for axis in 0..3 {
        let params = EmptySpaceParams {
            cell_count,
            majorant_offset: grid_offset as u32,
            row_length: workgroups[0] * group,
            axis,
            grid_dims: ranges.grid_dims,
            padding: 0,
        };
        recording.push(Step::Dispatch {
            kernel,
            uniforms: vec![bytemuck::bytes_of(&params).to_vec()],
            resources: vec![buffers.grids, distances],
            workgroups,
        });
    }
    recording.push(Step::Free { id: distances });
}
