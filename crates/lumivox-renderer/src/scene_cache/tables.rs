//! The instances' transfer functions on the GPU, what else their points are classified by, and the majorants that follow.

use lumivox_core::LabelVolume;
use lumivox_shaders::layout::TABLE_PAIRS;

use super::classes::{self, Fields, Looks};
use super::fields::{Field, FieldKind};
use super::label_sets::{self, CellLabels};
use super::majorants;
pub use super::transfer_table::Function;
use super::{DeviceLimits, Placed, acquired, check_binding, voxel_from_patient};
use crate::error::RenderError;
use crate::recording::{Payload, Recording, ResourceId, Step};
use crate::store::{Acquired, Source, ValueRanges};

/// An instance's functions and classification, and where its majorants are.
#[derive(Debug)]
struct CachedTable {
    /// The volume.
    source: ResourceId,
    /// What the majorants were made of.
    ranges: ValueRanges,
    /// The copy of the labels, and where it lies, that the majorants were made of.
    labels: Option<(ResourceId, CellLabels)>,
    looks: Looks,
    functions: Vec<Function>,
    /// The first pair of its functions.
    table_offset: usize,
    /// Behind the functions; nothing where no medium of the scene is classified.
    classes: Vec<[f32; 2]>,
    grid_offset: usize,
}

/// A field's cells, which say where its voxels are.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CachedField {
    source: ResourceId,
    ranges: ValueRanges,
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
    fields: Vec<CachedField>,
    pub buffers: Option<TableBuffers>,
    /// Pairs and cells that the buffers have room for.
    capacity: [usize; 2],
    /// How often the labels of a volume were looked at in an update, for nobody had before.
    pub unprepared: u64,
}

/// Bytes of a pair.
const PAIR_BYTES: u64 = 8;

/// Bytes of a cell: its majorant and its page.
const CELL_BYTES: u64 = 8;

/// Whole numbers up to here are exact as floats, which is how a classification tells where pairs are.
const MOST_PAIRS: u64 = 1 << 24;

/// Pairs of an instance.
fn pairs(placed: &Placed<'_>, looks: &Looks, classified: bool) -> usize {
    let classes = if classified { classes::pairs_of(placed.instance, looks) } else { 0 };
    looks.rows() * TABLE_PAIRS + classes
}

/// Whether the device has room for the tables of instances.
pub(super) fn check(instances: &[Placed<'_>], classified: bool, limit: u64) -> Result<(), RenderError> {
    let pairs = instances.iter().map(|placed| pairs(placed, &placed.looks, classified) as u64).sum::<u64>();
    let most = if classified { limit.min(MOST_PAIRS * PAIR_BYTES) } else { limit };
    check_binding(
        "transfer functions",
        pairs * PAIR_BYTES,
        most,
        "Leave some volumes or labels' own functions out",
    )
}

/// Cells that a device binds.
pub(super) fn most_cells(limits: &DeviceLimits) -> usize {
    usize::try_from(limits.max_storage_binding / CELL_BYTES).unwrap_or(usize::MAX)
}

/// Whether the device has room for the cells of what there is of instances and fields.
pub(super) fn check_cells(
    instances: &[Placed<'_>],
    fields: &[Field],
    volumes: &[(Source, Acquired)],
    limits: &DeviceLimits,
) -> Result<(), RenderError> {
    let bytes = cells(instances, fields, volumes) as u64 * CELL_BYTES;
    check_binding("majorant grid", bytes, limits.max_storage_binding, "Leave some volumes out")
}

fn cells(instances: &[Placed<'_>], fields: &[Field], volumes: &[(Source, Acquired)]) -> usize {
    let read = fields.iter().map(|field| field.source.clone());
    let sources = instances.iter().map(Placed::source).chain(read);
    sources.map(|source| acquired(volumes, &source).ranges.cells()).sum()
}

impl CachedTables {
    /// Records what differs; returns whether anything did. In a scene of which some medium is classified, all are.
    pub fn update(
        &mut self,
        instances: &[Placed<'_>],
        fields: &[Field],
        classified: bool,
        volumes: &[(Source, Acquired)],
        recording: &mut Recording,
    ) -> bool {
        let of = |placed: &Placed<'_>| acquired(volumes, &placed.source());
        let of_field = |field: &Field| acquired(volumes, &field.source);
        let cells = cells(instances, fields, volumes);
        let sizes: Vec<usize> =
            instances.iter().map(|placed| pairs(placed, &placed.looks, classified)).collect();
        let needed = [sizes.iter().sum(), cells];
        let mut changed = self.list.len() != instances.len();
        let suits = (0..2).all(|i| (needed[i]..=needed[i].saturating_mul(4)).contains(&self.capacity[i]));
        if self.buffers.is_none() || !suits {
            self.allocate(needed, recording);
            changed = true;
        }
        self.list.truncate(instances.len());
        let buffers = self.buffers.expect("allocated above");
        let (mut grid_offset, mut table_offset) = (0, 0);
        for (index, placed) in instances.iter().enumerate() {
            let acquired @ Acquired { resident, ranges } = of(placed);
            let volume = &placed.instance.volume;
            let looks = &placed.looks;
            let own_fields = Fields {
                labels: Field::find(fields, index, FieldKind::Labels).map(|at| instances.len() + at),
                depth: Field::find(fields, index, FieldKind::Depth).map(|at| instances.len() + at),
            };
            let labels = Field::find(fields, index, FieldKind::Labels).map(|at| {
                let copy = &of_field(&fields[at]).resident;
                let labels_from_voxel = voxel_from_patient(&fields[at].source.volume, copy.factor)
                    * voxel_from_patient(volume, resident.factor).inverse();
                let (dims, grid_dims, cell_size) = (resident.bricks.dims, ranges.grid_dims, ranges.cell_size);
                let factor = copy.factor;
                (copy.source, CellLabels { dims, grid_dims, cell_size, labels_from_voxel, factor })
            });
            let old = self.list.get(index);
            let same_functions =
                old.filter(|old| old.source == resident.source && old.looks.functions == looks.functions);
            let functions = match same_functions {
                Some(old) => old.functions.clone(),
                None => looks.functions.iter().map(|rows| Function::new(rows, volume)).collect(),
            };
            let tables_are_there = same_functions.is_some_and(|old| old.table_offset == table_offset);
            let majorants_are_there = same_functions.is_some_and(|old| {
                old.ranges == *ranges
                    && old.grid_offset == grid_offset
                    && old.labels == labels
                    && old.looks.absorb_like(looks)
            });
            let starts = starts(looks, table_offset);
            let classes_begin = table_offset + looks.rows() * TABLE_PAIRS;
            let class_pairs = if classified {
                let map = voxel_from_patient(volume, resident.factor);
                classes::pairs(placed.instance, looks, &functions, map, own_fields, classes_begin, |at| {
                    starts[at]
                })
            } else {
                vec![]
            };
            let write = |pair: usize, data: Payload, recording: &mut Recording| {
                let offset = pair as u64 * PAIR_BYTES;
                recording.push(Step::WriteBuffer { id: buffers.tables, offset, data });
            };
            if !tables_are_there {
                let pairs: Vec<[f32; 2]> = functions.iter().flat_map(Function::pairs).collect();
                write(table_offset, Payload::copy_of(&pairs), recording);
                changed = true;
            }
            let classes_are_there = tables_are_there && old.is_some_and(|old| old.classes == class_pairs);
            if !classes_are_there && classified {
                write(classes_begin, Payload::copy_of(&class_pairs), recording);
                changed = true;
            }
            if !majorants_are_there {
                let sets = labels.as_ref().map(|(_, cells)| {
                    let labels = &placed.instance.labels.as_ref().expect("it has a field of them").labels;
                    cell_labels(labels, cells, &mut self.unprepared)
                });
                let made_of = majorants::MadeOf { looks, functions: &functions, sets: sets.as_deref() };
                majorants::record(grid_offset, &made_of, volume, acquired, buffers, recording);
                changed = true;
            }
            let entry = CachedTable {
                source: resident.source,
                ranges: *ranges,
                labels,
                looks: looks.clone(),
                functions,
                table_offset,
                classes: class_pairs,
                grid_offset,
            };
            match self.list.get_mut(index) {
                Some(old) => *old = entry,
                None => self.list.push(entry),
            }
            grid_offset += ranges.cells();
            table_offset += sizes[index];
        }
        let mut cached = vec![];
        for field in fields {
            let acquired = of_field(field);
            let entry =
                CachedField { source: acquired.resident.source, ranges: acquired.ranges, grid_offset };
            if self.fields.get(cached.len()) != Some(&entry) {
                majorants::record_pages(grid_offset, acquired, buffers, recording);
                changed = true;
            }
            grid_offset += acquired.ranges.cells();
            cached.push(entry);
        }
        changed |= self.fields.len() != cached.len();
        self.fields = cached;
        changed
    }

    /// Makes room for so many pairs of tables, and for so many cells of majorant grids.
    fn allocate(&mut self, [pairs, cells]: [usize; 2], recording: &mut Recording) {
        self.free(recording);
        self.capacity = [pairs, cells];
        self.buffers = Some(TableBuffers {
            grids: recording.create_buffer("majorants", cells as u64 * CELL_BYTES),
            tables: recording.create_buffer("transfer functions", pairs as u64 * PAIR_BYTES),
        });
    }

    /// An instance's own function, its first pair, the first pair of its classification, and the first cell of its majorants.
    pub fn get(&self, index: usize) -> TableOf<'_> {
        let cached = &self.list[index];
        TableOf {
            function: &cached.functions[0],
            table_offset: cached.table_offset,
            classes: cached.table_offset + cached.looks.rows() * TABLE_PAIRS,
            grid_offset: cached.grid_offset,
        }
    }

    /// The first cell of a field.
    pub fn field_grid(&self, index: usize) -> usize {
        self.fields[index].grid_offset
    }

    pub fn free(&mut self, recording: &mut Recording) {
        if let Some(buffers) = self.buffers.take() {
            for id in [buffers.grids, buffers.tables] {
                recording.push(Step::Free { id });
            }
        }
        self.list.clear();
        self.fields.clear();
    }
}

/// Where an instance's part of the buffers is.
pub(super) struct TableOf<'a> {
    pub function: &'a Function,
    pub table_offset: usize,
    pub classes: usize,
    pub grid_offset: usize,
}

/// The first pair of each function.
fn starts(looks: &Looks, table_offset: usize) -> Vec<usize> {
    let mut next = table_offset;
    let begin = |rows: &Vec<_>| {
        let end = next + rows.len() * TABLE_PAIRS;
        std::mem::replace(&mut next, end)
    };
    looks.functions.iter().map(begin).collect()
}

fn cell_labels(labels: &LabelVolume, cells: &CellLabels, unprepared: &mut u64) -> Vec<[u32; 2]> {
    let (blocks, is_late) = label_sets::blocks(labels);
    *unprepared += u64::from(is_late);
    cells.sets(labels, &blocks)
}
