//! Value ranges over cells of a volume, from which the GPU makes majorants for any transfer function: computed from the
//! voxels that are there already.

use lumivox_core::Filter;
use lumivox_shaders::Kernel;
use lumivox_shaders::constants::BRICK_SIZE;
use lumivox_shaders::layout::ValueRangeParams;

use super::Bricks;
use super::pools::Pools;
use crate::recording::{Recording, ResourceId, Step};

/// Fewer cells than this along the longest side are made smaller: tight majorants cost little on small volumes.
const MIN_CELLS: u32 = 64;

/// Voxels along a cell's side at most; always a power of two, so that every cell lies in one brick.
pub(crate) const MAX_CELL_SIZE: u32 = 16;

/// What decides a grid of cells, besides its volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GridKey {
    /// Whether the volume is filtered wider than linearly.
    pub wide: bool,
    /// Voxels along a side of a cell, where it is not the suitable one.
    pub cell_size: Option<u32>,
}

impl GridKey {
    pub fn new(filter: Filter, cell_size: Option<u32>) -> Self {
        Self { wide: filter == Filter::Tricubic, cell_size }
    }

    /// Voxels that a filter touches beyond those on the faces of a cell. The points of cell c lie between the centres of
    /// the voxels (c - 1) * size and c * size: a linear filter touches no other.
    fn reach(self) -> u32 {
        u32::from(self.wide)
    }
}

/// The cells of a copy of a volume, and where their ranges are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ValueRanges {
    /// Cells along x, y and z.
    pub grid_dims: [u32; 3],
    /// Voxels along a side of a cell.
    pub cell_size: u32,
    /// Smallest and largest 16-bit fraction of each cell, x fastest.
    pub buffer: ResourceId,
}

impl ValueRanges {
    pub fn cells(&self) -> usize {
        self.grid_dims.iter().map(|&n| n as usize).product()
    }
}

/// Value ranges, as far as they are computed.
#[derive(Debug)]
pub(super) struct Ranges {
    pub key: GridKey,
    values: ValueRanges,
    /// Cells that are computed.
    done: u32,
}

/// The grid of a volume: cells along each axis, and voxels along a side of one, by default 8, or 4 where 8 would leave few
/// cells. The first cells begin a whole one before the centre of the first voxel, the last end beyond the last voxel.
pub(crate) fn grid(dims: [u32; 3], wanted_cell_size: Option<u32>) -> ([u32; 3], u32) {
    let longest = dims.into_iter().max().unwrap_or(1);
    let suitable = if longest < MIN_CELLS * 8 { 4 } else { 8 };
    let cell_size = wanted_cell_size.unwrap_or(suitable).clamp(1, MAX_CELL_SIZE).next_power_of_two();
    (dims.map(|n| (n - 1) / cell_size + 2), cell_size)
}

impl Ranges {
    /// Makes room for them.
    pub fn new(key: GridKey, dims: [u32; 3], recording: &mut Recording) -> Self {
        let (grid_dims, cell_size) = grid(dims, key.cell_size);
        let cells: u64 = grid_dims.iter().map(|&n| u64::from(n)).product();
        let buffer = recording.create_buffer("value ranges", cells * 4);
        Self { key, values: ValueRanges { grid_dims, cell_size, buffer }, done: 0 }
    }

    pub fn values(&self) -> ValueRanges {
        self.values
    }

    pub fn is_whole(&self) -> bool {
        self.done as usize == self.values.cells()
    }

    /// Cells whose filters need no more than so many layers of bricks.
    fn cells_within(&self, bricks: &Bricks, brick_layers: u32) -> u32 {
        let [x, y, z] = self.values.grid_dims;
        let layers = if brick_layers >= bricks.grid.counts[2] {
            z
        } else if brick_layers == 0 {
            0
        } else {
            // Those whose last voxel, which lies `reach` beyond the cell's last face, is in these layers. The kernel reads
            // each voxel in the brick that it belongs to, not in the neighbour that holds it, too.
            (brick_layers * BRICK_SIZE - 1 - self.key.reach()) / self.values.cell_size + 1
        };
        x * y * layers
    }

    /// Whether there is something to compute once so many layers of bricks are there.
    pub fn wants(&self, bricks: &Bricks, brick_layers: u32) -> bool {
        self.cells_within(bricks, brick_layers) > self.done
    }

    /// Records the ranges of cells that so many layers of bricks, whose pages are in a buffer, decide: as many as are not
    /// computed, but no larger a share of all cells than that.
    pub fn record(
        &mut self,
        bricks: &Bricks,
        pages: ResourceId,
        pools: &Pools,
        brick_layers: u32,
        share: f64,
        recording: &mut Recording,
    ) {
        let ValueRanges { grid_dims, cell_size, buffer } = self.values;
        let most = (self.values.cells() as f64 * share).ceil() as u32;
        let cell_count = self.cells_within(bricks, brick_layers).saturating_sub(self.done).min(most);
        if cell_count == 0 {
            return;
        }
        let textures = pools.textures();
        let kernel = Kernel::ValueRanges { one_pool: textures.len() == 1 };
        let [group, _] = kernel.workgroup_size();
        let groups = cell_count.div_ceil(group);
        let workgroups = [groups.min(1024), groups.div_ceil(1024)];
        let params = ValueRangeParams {
            dims: bricks.grid.dims,
            cell_size,
            grid_dims,
            reach: self.key.reach(),
            bricks: bricks.grid.counts,
            first_cell: self.done,
            cell_count,
            row_length: workgroups[0] * group,
            split_pools: pools.split(),
            padding: 0,
        };
        let mut resources = vec![pages, buffer];
        resources.extend(textures);
        let uniforms = vec![bytemuck::bytes_of(&params).to_vec()];
        recording.push(Step::Dispatch { kernel, uniforms, resources, workgroups });
        self.done += cell_count;
    }

    pub fn free(&self, recording: &mut Recording) {
        recording.push(Step::Free { id: self.values.buffer });
    }
}
