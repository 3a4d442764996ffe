//! Has the GPU make majorants of value ranges and transfer functions, and beside them the pages of bricks.

use lumivox_core::Volume;
use lumivox_shaders::Kernel;
use lumivox_shaders::constants::BRICK_SIZE;
use lumivox_shaders::layout::{EmptySpaceParams, MajorantParams, RANGE_MAXIMUM_LEVELS, TABLE_SIZE};

use super::classes::Looks;
use super::tables::{Function, TableBuffers};
use crate::recording::{Recording, Step};
use crate::store::{Acquired, TexelScale, ValueRanges};

/// What an instance's majorants are made of, besides its value ranges.
pub(super) struct MadeOf<'a> {
    pub looks: &'a Looks,
    pub functions: &'a [Function],
    /// The labels of each cell, where there are any.
    pub sets: Option<&'a [[u32; 2]]>,
}

/// An instance's majorants, and the empty space between them.
pub(super) fn record(
    grid_offset: usize,
    made_of: &MadeOf<'_>,
    volume: &Volume,
    acquired: &Acquired,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    let maxima: Vec<f32> = made_of.functions.iter().flat_map(Function::range_maxima).collect();
    let first = |function: usize| function * RANGE_MAXIMUM_LEVELS * TABLE_SIZE;
    let styles = made_of.looks.for_majorants(made_of.functions, TexelScale::of(volume), first);
    record_cells(grid_offset, &maxima, &styles, made_of.sets, acquired, buffers, recording);
    record_empty_space(grid_offset, &acquired.ranges, buffers, recording);
}

/// Cells that say where a field's voxels are, and nothing else: no ray walks through them.
pub(super) fn record_pages(
    grid_offset: usize,
    acquired: &Acquired,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    record_cells(grid_offset, &[0.0], &[[0.0; 4]], None, acquired, buffers, recording);
}

fn record_cells(
    grid_offset: usize,
    maxima: &[f32],
    styles: &[[f32; 4]],
    sets: Option<&[[u32; 2]]>,
    Acquired { resident, ranges }: &Acquired,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    let maxima = recording.create_buffer_with("range maxima", maxima);
    let pages = recording.create_buffer_with("pages", &resident.pages);
    let style_count = styles.len() as u32;
    let styles = recording.create_buffer_with("styles", styles);
    let has_labels = sets.is_some().into();
    let sets = recording.create_buffer_with("label sets", sets.unwrap_or(&[[0; 2]]));
    let cell_count = ranges.cells() as u32;
    let [group, _] = Kernel::MajorantGrid.workgroup_size();
    let groups = cell_count.div_ceil(group);
    let workgroups = [groups.min(1024), groups.div_ceil(1024)];
    let params = MajorantParams {
        cell_count,
        majorant_offset: grid_offset as u32,
        row_length: workgroups[0] * group,
        cells_per_brick: BRICK_SIZE / ranges.cell_size,
        style_count,
        has_labels,
        grid_dims: ranges.grid_dims,
        bricks: resident.bricks.counts,
        ..Default::default()
    };
    recording.push(Step::Dispatch {
        kernel: Kernel::MajorantGrid,
        uniforms: vec![bytemuck::bytes_of(&params).to_vec()],
        resources: vec![ranges.buffer, maxima, pages, styles, sets, buffers.grids],
        workgroups,
    });
    for id in [maxima, pages, styles, sets] {
        recording.push(Step::Free { id });
    }
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
