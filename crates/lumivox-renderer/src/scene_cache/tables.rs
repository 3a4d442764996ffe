//! The instances' transfer functions on the GPU, what else their points are classified by, and the majorants that follow.

use std::ops::Range;

use lumivox_shaders::layout::{ImportanceCell, Light, TABLE_PAIRS, TABLE_SIZE};

use super::classes::{self, Looks};
use super::fields::{Field, FieldKind};
use super::hierarchy::Node;
use super::label_sets::{self, CellLabels};
use super::majorants::{self, CellsOf, MadeOf};
use super::mirror::Part;
pub use super::transfer_table::{Envelope, Function};
use super::{DeviceLimits, Placed, acquired, check_binding, voxel_from_patient};
use crate::error::RenderError;
use crate::recording::{Payload, Recording, ResourceId, Step};
use crate::store::{SceneCopy, Source, TexelScale, ValueRanges};

/// An instance's functions and classification, and where its majorants are.
#[derive(Debug)]
struct CachedTable {
    /// The volume.
    source: ResourceId,
    /// What the majorants were made of, besides the functions.
    ranges: ValueRanges,
    cells: CellsOf,
    /// What the majorants were made of, where the GPU keeps it: of what is classified.
    made_of: Option<MadeOf>,
    looks: Looks,
    functions: Vec<Function>,
    /// The largest opacity of all of them, behind the classification, where it is not the only one's.
    envelope: Option<Envelope>,
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
    /// Where the pairs of instances are in the buffer of tables.
    range: Range<usize>,
    /// How often the labels of a volume were looked at in an update, for nobody had before.
    pub unprepared: u64,
}

/// Elements of what else is in the buffer of tables: before what instances have what is large and seldom changes, then the rest.
pub(super) struct Besides {
    pub importance: usize,
    pub nodes: usize,
    pub lights: usize,
}

impl Besides {
    /// Bytes before what instances have, and behind it.
    fn bytes(&self) -> [u64; 2] {
        let [_, lights] = self.offsets(0);
        [Part::<ImportanceCell>::room(self.importance), lights + Part::<Light>::ample_room(self.lights)]
    }

    /// The first bytes of nodes and lights, where that ends at a byte.
    pub fn offsets(&self, behind: u64) -> [u64; 2] {
        [behind, behind + Part::<Node>::ample_room(self.nodes)]
    }
}

/// Bytes of a pair.
pub(super) const PAIR_BYTES: u64 = 8;

/// Bytes of a cell: its majorant and its page.
const CELL_BYTES: u64 = 8;

/// Whole numbers up to here are exact as floats, which is how a classification tells where pairs are.
const MOST_PAIRS: u64 = 1 << 24;

/// Pairs of an instance.
fn pairs(placed: &Placed<'_>, looks: &Looks, classified: bool) -> usize {
    let classes = if classified { classes::pairs_of(placed.instance, looks) } else { 0 };
    let envelope = if looks.has_envelope() { TABLE_SIZE } else { 0 };
    looks.rows() * TABLE_PAIRS + classes + envelope
}

/// Whether the device has room for the tables of instances, and for what there is besides.
pub(super) fn check(
    instances: &[Placed<'_>],
    classified: bool,
    besides: &Besides,
    limit: u64,
) -> Result<(), RenderError> {
    let pairs = instances.iter().map(|placed| pairs(placed, &placed.looks, classified) as u64).sum::<u64>();
    let most = if classified { limit.min(MOST_PAIRS * PAIR_BYTES) } else { limit };
    check_binding(
        "transfer functions",
        pairs * PAIR_BYTES + besides.bytes().iter().sum::<u64>(),
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
    volumes: &[(Source, SceneCopy)],
    limits: &DeviceLimits,
) -> Result<(), RenderError> {
    let bytes = cells(instances, fields, volumes) as u64 * CELL_BYTES;
    check_binding("majorant grid", bytes, limits.max_storage_binding, "Leave some volumes out")
}

fn cells(instances: &[Placed<'_>], fields: &[Field], volumes: &[(Source, SceneCopy)]) -> usize {
    let read = fields.iter().map(|field| field.source.clone());
    let sources = instances.iter().map(Placed::source).chain(read);
    sources.map(|source| acquired(volumes, &source).ranges.cells()).sum()
}

impl CachedTables {
    /// Records what differs; returns whether anything did. In a scene of which some medium is classified, all are. The buffer of
    /// tables has room for what there is besides.
    pub fn update(
        &mut self,
        instances: &[Placed<'_>],
        fields: &[Field],
        classified: bool,
        volumes: &[(Source, SceneCopy)],
        besides: &Besides,
        recording: &mut Recording,
    ) -> bool {
        let sizes: Vec<usize> =
            instances.iter().map(|placed| pairs(placed, &placed.looks, classified)).collect();
        let [before, behind] = besides.bytes().map(|bytes| (bytes / PAIR_BYTES) as usize);
        let own: usize = sizes.iter().sum();
        self.range = before..before + own;
        let needed = [self.range.end + behind, cells(instances, fields, volumes)];
        let mut changed = self.list.len() != instances.len();
        let suits = |i: usize| (needed[i]..=needed[i].saturating_mul(4)).contains(&self.capacity[i]);
        let [tables_suit, grids_suit] = [suits(0), suits(1)];
        if !grids_suit {
            self.free(recording);
            changed = true;
        }
        let is_anew = !tables_suit || self.buffers.is_none();
        if is_anew {
            // With room for as many again: what lies besides may be large, and is not to be written anew for a label more.
            self.allocate([needed[0] + own, needed[1]], recording);
        }
        for gone in self.list.drain(instances.len().min(self.list.len())..) {
            gone.free(recording);
        }
        let (mut grid_offset, mut table_offset) = (0, before);
        for (index, placed) in instances.iter().enumerate() {
            let field = |kind| {
                let at = Field::find(fields, index, kind)?;
                Some((instances.len() + at, acquired(volumes, &fields[at].source)))
            };
            let wanted = Wanted {
                placed,
                acquired: acquired(volumes, &placed.source()),
                labels: field(FieldKind::Labels),
                depth: field(FieldKind::Depth),
                classified,
                table_offset,
                grid_offset,
            };
            changed |= self.update_instance(index, &wanted, is_anew, recording);
            grid_offset += wanted.acquired.ranges.cells();
            table_offset += sizes[index];
        }
        changed | self.update_fields(fields, grid_offset, volumes, recording)
    }

    /// An instance's part of all buffers, of which that of tables may be empty.
    fn update_instance(
        &mut self,
        index: usize,
        wanted: &Wanted<'_>,
        is_anew: bool,
        recording: &mut Recording,
    ) -> bool {
        let old = self.list.get(index);
        let entry = wanted.entry(old);
        let buffers = self.buffers.expect("allocated before");
        let write = |pair: usize, data: Payload, recording: &mut Recording| {
            let offset = pair as u64 * PAIR_BYTES;
            recording.push(Step::WriteBuffer { id: buffers.tables, offset, data });
        };
        let same_functions = old.filter(|old| old.has_functions_of(&entry));
        let same_tables = same_functions.is_some_and(|old| old.table_offset == entry.table_offset);
        if is_anew || !same_tables {
            let pairs: Vec<[f32; 2]> = entry.functions.iter().flat_map(Function::pairs).collect();
            write(entry.table_offset, Payload::copy_of(&pairs), recording);
        }
        let had_classes = old.filter(|_| same_tables).map_or(&[][..], |old| &old.classes);
        let differ = difference(had_classes, &entry.classes);
        let same_classes = differ.is_empty();
        let written = if is_anew { 0..entry.classes.len() } else { differ };
        if !written.is_empty() {
            write(entry.first_class() + written.start, Payload::copy_of(&entry.classes[written]), recording);
        }
        let has_envelope = |old: &CachedTable| {
            old.envelope == entry.envelope && old.first_of_envelope() == entry.first_of_envelope()
        };
        let same_envelope = same_tables && old.is_some_and(has_envelope);
        if (is_anew || !same_envelope)
            && let Some(envelope) = &entry.envelope
        {
            write(entry.first_of_envelope(), Payload::copy_of(&envelope.pairs()), recording);
        }
        let majorants_are_there = same_functions.is_some_and(|old| old.has_cells_of(&entry));
        let had = old.and_then(|old| old.made_of);
        let mut made_of = had;
        if !majorants_are_there {
            let same_labels = old.is_some_and(|old| old.cells.labels == entry.cells.labels);
            let same_maxima = had.filter(|_| same_functions.is_some()).map(|had| had.maxima);
            let same_sets = had.filter(|_| same_labels).and_then(|had| had.sets);
            let maxima = same_maxima.unwrap_or_else(|| majorants::record_maxima(&entry.functions, recording));
            let sets = entry.cells.labels.as_ref().map(|(_, cells)| {
                same_sets.unwrap_or_else(|| {
                    let sets = wanted.cell_labels(cells, &mut self.unprepared);
                    majorants::record_sets(&sets, recording)
                })
            });
            let before = had.zip(old.map(|old| &old.cells));
            let now = MadeOf::new(maxima, sets, before, &entry.cells, wanted.acquired, recording);
            let CachedTable { grid_offset, cells, .. } = &entry;
            majorants::record(*grid_offset, cells, now, wanted.acquired, buffers, recording);
            // Of other media only functions change, and these with them.
            made_of = wanted.placed.classes().any().then_some(now);
            if made_of.is_none() {
                now.free_but(had, recording);
            }
            if let Some(had) = had {
                had.free_but(made_of, recording);
            }
        }
        let entry = CachedTable { made_of, ..entry };
        match self.list.get_mut(index) {
            Some(old) => *old = entry,
            None => self.list.push(entry),
        }
        !(same_tables && same_classes && same_envelope && majorants_are_there)
    }

    /// The cells of fields, behind those of instances.
    fn update_fields(
        &mut self,
        fields: &[Field],
        mut grid_offset: usize,
        volumes: &[(Source, SceneCopy)],
        recording: &mut Recording,
    ) -> bool {
        let buffers = self.buffers.expect("allocated before");
        let mut changed = self.fields.len() != fields.len();
        let mut cached = vec![];
        for field in fields {
            let acquired = acquired(volumes, &field.source);
            let entry = CachedField { source: acquired.bricks.source, ranges: acquired.ranges, grid_offset };
            if self.fields.get(cached.len()) != Some(&entry) {
                majorants::record_pages(grid_offset, acquired, buffers, recording);
                changed = true;
            }
            grid_offset += acquired.ranges.cells();
            cached.push(entry);
        }
        self.fields = cached;
        changed
    }

    /// Makes room for so many pairs of tables and, where there is none, for so many cells of majorant grids.
    fn allocate(&mut self, [pairs, cells]: [usize; 2], recording: &mut Recording) {
        let grids = match self.buffers.take() {
            Some(TableBuffers { tables, grids }) => {
                recording.push(Step::Free { id: tables });
                grids
            }
            None => {
                self.capacity[1] = cells;
                recording.create_buffer("majorants", cells as u64 * CELL_BYTES)
            }
        };
        self.capacity[0] = pairs;
        let tables = recording.create_buffer("tables", pairs as u64 * PAIR_BYTES);
        self.buffers = Some(TableBuffers { tables, grids });
    }

    /// The buffer of tables, and the first byte in it behind those of instances.
    pub fn behind(&self) -> Option<(ResourceId, u64)> {
        Some((self.buffers?.tables, self.range.end as u64 * PAIR_BYTES))
    }

    /// An instance's part.
    pub fn get(&self, index: usize, texel: TexelScale) -> TableOf {
        let cached = &self.list[index];
        let (coordinate, table_offset) = match &cached.envelope {
            Some(envelope) => (envelope.coordinate(texel), cached.first_of_envelope()),
            None => (cached.functions[0].coordinate(texel), cached.table_offset),
        };
        TableOf { coordinate, table_offset, classes: cached.first_class(), grid_offset: cached.grid_offset }
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
        for gone in self.list.drain(..) {
            gone.free(recording);
        }
        self.fields.clear();
    }
}

/// Where an instance's part of the buffers is.
pub(super) struct TableOf {
    /// Scale and bias that send texels to the table of its largest opacities.
    pub coordinate: (f64, f64),
    /// The first pair of that table.
    pub table_offset: usize,
    /// The first pair of its classification.
    pub classes: usize,
    /// The first cell of its majorants.
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

/// Where a list differs from the one before: all of it, if that had another length.
pub(super) fn difference<T: PartialEq>(before: &[T], list: &[T]) -> Range<usize> {
    if before.len() != list.len() {
        return 0..list.len();
    }
    let differs = |(a, b): (&T, &T)| a != b;
    let begin = before.iter().zip(list).position(differs).unwrap_or(list.len());
    let end = before.iter().zip(list).rposition(differs).map_or(begin, |last| last + 1);
    begin..end
}

/// What is to be there of an instance.
struct Wanted<'a> {
    placed: &'a Placed<'a>,
    acquired: &'a SceneCopy,
    /// The fields: where they are among all instances, and what there is of them.
    labels: Option<(usize, &'a SceneCopy)>,
    depth: Option<(usize, &'a SceneCopy)>,
    classified: bool,
    table_offset: usize,
    grid_offset: usize,
}

impl Wanted<'_> {
    /// The same as it is cached, but for the labels of its cells. Functions are those of before where they are the same.
    fn entry(&self, old: Option<&CachedTable>) -> CachedTable {
        let Self { placed, acquired, table_offset, .. } = *self;
        let volume = &placed.instance.volume;
        let looks = &placed.looks;
        let source = acquired.bricks.source;
        let same = old.filter(|old| old.source == source && old.looks.functions == looks.functions);
        let functions = match same {
            Some(old) => old.functions.clone(),
            None => looks.functions.iter().map(|rows| Function::new(rows, volume)).collect(),
        };
        let envelope = match same.filter(|old| old.looks.is_bounded_like(looks)) {
            Some(old) => old.envelope.clone(),
            None => looks.envelope(&functions),
        };
        let [labels, depth] = [self.labels, self.depth].map(|field| field.map(|(_, copy)| copy));
        let mut entry = CachedTable {
            source,
            ranges: acquired.ranges,
            cells: CellsOf::new(placed, &functions, acquired, labels, depth),
            made_of: None,
            looks: looks.clone(),
            functions,
            envelope,
            table_offset,
            classes: vec![],
            grid_offset: self.grid_offset,
        };
        if self.classified {
            let depth = self.depth.map(|(at, _)| at);
            let map = voxel_from_patient(volume, acquired.bricks.factor);
            let starts = starts(looks, table_offset);
            let begin = entry.first_class();
            let table = |function: usize| starts[function];
            entry.classes =
                classes::pairs(placed.instance, looks, &entry.functions, map, depth, begin, table);
        }
        entry
    }

    fn cell_labels(&self, cells: &CellLabels, unprepared: &mut u64) -> Vec<[u32; 2]> {
        let labelling = self.placed.instance.labels.as_ref().expect("it has a field of them");
        let (blocks, is_late) = label_sets::blocks(&labelling.labels);
        *unprepared += u64::from(is_late);
        cells.sets(&labelling.labels, &blocks)
    }
}

impl CachedTable {
    fn free(self, recording: &mut Recording) {
        if let Some(made_of) = self.made_of {
            made_of.free_but(None, recording);
        }
    }

    fn has_functions_of(&self, other: &Self) -> bool {
        self.source == other.source && self.looks.functions == other.looks.functions
    }

    /// Whether its cells are those of another with the same functions.
    fn has_cells_of(&self, other: &Self) -> bool {
        self.ranges == other.ranges && self.grid_offset == other.grid_offset && self.cells == other.cells
    }

    /// The first pair of its envelope.
    fn first_of_envelope(&self) -> usize {
        self.first_class() + self.classes.len()
    }

    /// The first pair of its classification.
    fn first_class(&self) -> usize {
        self.table_offset + self.looks.rows() * TABLE_PAIRS
    }
}
