//! Has the GPU make majorants of value ranges and transfer functions, and beside them the pages of bricks and what all points
//! of a cell have in common.

use lumivox_core::Volume;
use lumivox_shaders::Kernel;
use lumivox_shaders::constants::{self, BRICK_SIZE};
use lumivox_shaders::layout::{EmptySpaceParams, MajorantParams, RANGE_MAXIMUM_LEVELS, TABLE_SIZE};

use super::classes::Shapes;
use super::label_sets::CellLabels;
use super::tables::{Function, TableBuffers, difference};
use super::{Placed, affine_rows, voxel_from_patient};
use crate::recording::{Payload, Recording, ResourceId, Step};
use crate::store::{SceneCopy, TexelScale, ValueRanges};

/// What an instance's cells are made of, besides its value ranges and its functions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct CellsOf {
    /// Of each label, then of each clip shape, as the kernel reads them.
    looks: Vec<[f32; 4]>,
    style_count: u32,
    shapes_of_rays: u32,
    /// The copy of the labels, and how they lie.
    pub labels: Option<(ResourceId, CellLabels)>,
    /// What is peeled.
    peel: Option<PeeledCells>,
}

/// What is taken off cells by depths below the skin.
#[derive(Clone, Debug, PartialEq)]
struct PeeledCells {
    ranges: ValueRanges,
    /// Voxels of the depths from voxels of the instance, on the GPU.
    depth_from_voxel: [[f32; 4]; 3],
    /// From stored depths to mm.
    scale: f32,
    bias: f32,
    mm: f32,
    inverse_width: f32,
}

impl CellsOf {
    /// Of an instance, whose fields are there.
    pub fn new(
        placed: &Placed<'_>,
        functions: &[Function],
        acquired: &SceneCopy,
        labels: Option<&SceneCopy>,
        depth: Option<&SceneCopy>,
    ) -> Self {
        let Placed { instance, looks, .. } = placed;
        let SceneCopy { bricks, ranges } = acquired;
        let voxel_from_patient = voxel_from_patient(&instance.volume, bricks.factor);
        let from_voxel = |volume: &Volume, factor| {
            super::voxel_from_patient(volume, factor) * voxel_from_patient.inverse()
        };
        let styles = looks.for_majorants(functions, TexelScale::of(&instance.volume), |function| {
            function * RANGE_MAXIMUM_LEVELS * TABLE_SIZE
        });
        let style_count = (styles.len() / constants::CELL_STYLE_ROWS as usize) as u32;
        let labels = instance.labels.as_ref().zip(labels).map(|(labelling, copy)| {
            let factor = copy.bricks.factor;
            let cells = CellLabels {
                dims: bricks.grid.dims,
                grid_dims: ranges.grid_dims,
                cell_size: ranges.cell_size,
                labels_from_voxel: from_voxel(labelling.labels.volume(), factor),
                factor,
            };
            (copy.bricks.source, cells)
        });
        let peel = instance.peel.as_ref().zip(depth).map(|(peel, copy)| {
            let texel = TexelScale::of(&peel.depth);
            PeeledCells {
                ranges: copy.ranges,
                depth_from_voxel: affine_rows(from_voxel(&peel.depth, copy.bricks.factor)),
                scale: texel.per_texel as f32,
                bias: texel.at_zero as f32,
                mm: peel.mm as f32,
                inverse_width: (1.0 / peel.width_mm()) as f32,
            }
        });
        let shapes = Shapes::new(instance, looks);
        let looks = [styles, shapes.for_majorants(voxel_from_patient)].concat();
        Self { looks, style_count, shapes_of_rays: shapes.of_rays as u32, labels, peel }
    }

    /// Of a field, which no ray meets: nothing but where its voxels are.
    fn of_field() -> Self {
        Self { looks: vec![[0.0; 4]; constants::CELL_STYLE_ROWS as usize], style_count: 1, ..Self::default() }
    }
}

/// What the GPU keeps of an instance, for majorants that are made anew when a shape moves or something is peeled: a host would
/// otherwise make buffers in every frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MadeOf {
    /// The range maxima of its functions.
    pub maxima: ResourceId,
    /// The labels of each cell, where there are any.
    pub sets: Option<ResourceId>,
    written: Written,
}

/// Buffers that are written with each making.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Written {
    pages: ResourceId,
    looks: ResourceId,
    /// Of the empty space.
    distances: ResourceId,
    /// Elements of each.
    sizes: [usize; 3],
}

impl MadeOf {
    /// With buffers of before, and of the cells that they were for, where they have the size; what else they were is the
    /// caller's to free.
    pub fn new(
        maxima: ResourceId,
        sets: Option<ResourceId>,
        before: Option<(Self, &CellsOf)>,
        cells: &CellsOf,
        SceneCopy { bricks, ranges }: &SceneCopy,
        recording: &mut Recording,
    ) -> Self {
        let sizes = [bricks.pages.len(), cells.looks.len(), ranges.cells()];
        let written = match before.filter(|(before, _)| before.written.sizes == sizes) {
            Some((Self { written, .. }, had)) => {
                let data = Payload::copy_of(&bricks.pages);
                recording.push(Step::WriteBuffer { id: written.pages, offset: 0, data });
                let differ = difference(&had.looks, &cells.looks);
                if !differ.is_empty() {
                    let offset = (differ.start * size_of::<[f32; 4]>()) as u64;
                    let data = Payload::copy_of(&cells.looks[differ]);
                    recording.push(Step::WriteBuffer { id: written.looks, offset, data });
                }
                written
            }
            None => Written {
                pages: recording.create_buffer_with("pages", &bricks.pages),
                looks: recording.create_buffer_with("looks", &cells.looks),
                distances: recording.create_buffer("distances", 2 * 4 * ranges.cells() as u64),
                sizes,
            },
        };
        Self { maxima, sets, written }
    }

    /// Frees what is no part of another.
    pub fn free_but(self, other: Option<Self>, recording: &mut Recording) {
        let is_gone = |id: &ResourceId| other.is_none_or(|other| other.ids().all(|kept| kept != *id));
        self.ids().filter(is_gone).for_each(|id| recording.push(Step::Free { id }));
    }

    fn ids(self) -> impl Iterator<Item = ResourceId> {
        let Written { pages, looks, distances, .. } = self.written;
        [Some(self.maxima), self.sets, Some(pages), Some(looks), Some(distances)].into_iter().flatten()
    }
}

/// The range maxima of functions, one after the other.
pub(super) fn record_maxima(functions: &[Function], recording: &mut Recording) -> ResourceId {
    let maxima: Vec<f32> = functions.iter().flat_map(Function::range_maxima).collect();
    recording.create_buffer_with("range maxima", &maxima)
}

/// The labels of each cell.
pub(super) fn record_sets(sets: &[[u32; 2]], recording: &mut Recording) -> ResourceId {
    recording.create_buffer_with("label sets", sets)
}

/// An instance's majorants, and the empty space between them.
pub(super) fn record(
    grid_offset: usize,
    cells: &CellsOf,
    made_of: MadeOf,
    acquired: &SceneCopy,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    record_cells(grid_offset, cells, made_of, acquired, buffers, recording);
    record_empty_space(grid_offset, made_of.written.distances, &acquired.ranges, buffers, recording);
}

/// Cells that say where a field's voxels are, and nothing else: no ray walks through them.
pub(super) fn record_pages(
    grid_offset: usize,
    acquired: &SceneCopy,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    let maxima = recording.create_buffer_with("range maxima", &[0.0f32; 2]);
    let cells = CellsOf::of_field();
    let made_of = MadeOf::new(maxima, None, None, &cells, acquired, recording);
    record_cells(grid_offset, &cells, made_of, acquired, buffers, recording);
    made_of.free_but(None, recording);
}

fn record_cells(
    grid_offset: usize,
    cells: &CellsOf,
    MadeOf { maxima, sets, written }: MadeOf,
    SceneCopy { bricks, ranges }: &SceneCopy,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    let has_labels = sets.is_some().into();
    let cell_count = ranges.cells() as u32;
    let [group, _] = Kernel::MajorantGrid.workgroup_size();
    let groups = cell_count.div_ceil(group);
    let workgroups = [groups.min(1024), groups.div_ceil(1024)];
    let style_rows = cells.style_count * constants::CELL_STYLE_ROWS;
    let mut params = MajorantParams {
        cell_count,
        majorant_offset: grid_offset as u32,
        row_length: workgroups[0] * group,
        cells_per_brick: BRICK_SIZE / ranges.cell_size,
        style_count: cells.style_count,
        has_labels,
        shape_count: (cells.looks.len() as u32 - style_rows) / constants::CELL_SHAPE_ROWS,
        grid_dims: ranges.grid_dims,
        cell_size: ranges.cell_size as f32,
        bricks: bricks.grid.counts,
        dims: bricks.grid.dims.map(|n| n as f32),
        shapes_of_rays: cells.shapes_of_rays,
        ..Default::default()
    };
    if let Some(peel) = &cells.peel {
        params.has_depth = 1;
        params.peel_mm = peel.mm;
        params.peel_inverse_width = peel.inverse_width;
        params.depth_from_voxel = peel.depth_from_voxel;
        params.depth_grid_dims = peel.ranges.grid_dims;
        params.depth_cell_size = peel.ranges.cell_size as f32;
        params.depth_scale = peel.scale;
        params.depth_bias = peel.bias;
    }
    // Something has to be bound where there are none.
    let sets = sets.unwrap_or(maxima);
    let depth_ranges = cells.peel.as_ref().map_or(ranges.buffer, |peel| peel.ranges.buffer);
    recording.push(Step::Dispatch {
        kernel: Kernel::MajorantGrid,
        uniforms: vec![bytemuck::bytes_of(&params).to_vec()],
        resources: vec![
            ranges.buffer,
            maxima,
            written.pages,
            written.looks,
            sets,
            depth_ranges,
            buffers.grids,
        ],
        workgroups,
    });
}

/// Has the GPU measure the empty space between an instance's majorants.
fn record_empty_space(
    grid_offset: usize,
    distances: ResourceId,
    ranges: &ValueRanges,
    buffers: TableBuffers,
    recording: &mut Recording,
) {
    let kernel = Kernel::EmptySpace;
    let cell_count = ranges.cells() as u32;
    let [group, _] = kernel.workgroup_size();
    let groups = cell_count.div_ceil(group);
    let workgroups = [groups.min(1024), groups.div_ceil(1024)];
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
}
