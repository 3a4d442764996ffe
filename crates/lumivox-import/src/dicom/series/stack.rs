//! A stack: images of one series with one size, spacing, orientation and kind, in order along their normal, once for each
//! phase. It is what becomes a volume.

use lumivox_core::{Modality, glam::DVec3};

use crate::{
    dicom::{
        frames::frame::Frame,
        images::image_file::{ImageFile, Slice},
        series::{
            gaps::Gaps,
            geometry::{self, Grid, Plane},
            label_grid, storage,
        },
    },
    report::{SeriesSummary, orientation_words},
};

/// Directions nearer than this are one: 0.1 degrees, more than writers round away.
const SAME_DIRECTION: f64 = 2e-3;
/// Relative difference of pixel spacings that are one.
const SAME_SPACING: f64 = 1e-3;

/// Images that make up a volume, in order along the normal.
#[derive(Clone, Debug)]
pub(crate) struct Phase {
    pub(crate) slices: Vec<Slice>,
    /// Where the first pixel of each slice lies.
    pub(crate) places: Vec<DVec3>,
}

impl Phase {
    /// Slices whose file ends before their pixels do.
    pub(crate) fn truncated(&self, files: &[ImageFile]) -> usize {
        self.slices.iter().filter(|slice| !files[slice.file].has(slice.frame)).count()
    }
}

/// What can be loaded: a volume, or several that were taken one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Stack {
    pub(crate) plane: Plane,
    /// At least one.
    pub(crate) phases: Vec<Phase>,
    /// What tells phases apart: `trigger time`.
    pub(crate) told_by: String,
    /// Sentences about liberties taken.
    pub(crate) notes: Vec<String>,
}

impl Stack {
    /// The file of the first slice, which speaks for all.
    pub(crate) fn first<'a>(&self, files: &'a [ImageFile]) -> &'a ImageFile {
        &files[self.phases[0].slices[0].file]
    }

    fn voxels(&self, files: &[ImageFile]) -> usize {
        let format = &self.first(files).format;
        self.phases[0].slices.len().saturating_mul(format.rows * format.columns)
    }

    /// Whether it is a map of numbers around 0, of which a picture is not one of the body.
    fn is_signed_map(&self, files: &[ImageFile]) -> bool {
        let slices = &self.phases[0].slices;
        slices.iter().any(|slice| files[slice.file].frames[slice.frame].is_signed_map)
    }

    /// What decides which is the best; the greatest is.
    pub(crate) fn rank(&self, files: &[ImageFile]) -> Rank {
        let first = self.first(files);
        let is_derived = first.frames[self.phases[0].slices[0].frame].kind.contains("derived");
        Rank {
            is_no_localizer: !first.is_localizer,
            has_depth: self.phases[0].slices.len() > 1,
            is_scan: first.modality != Modality::Other && first.segmentation.is_none(),
            is_picture: !self.is_signed_map(files),
            voxels: self.voxels(files),
            is_original: !is_derived,
        }
    }

    /// Why `best` comes before it.
    pub(crate) fn reason(&self, best: &Stack, files: &[ImageFile]) -> &'static str {
        let (own, best) = (self.rank(files), best.rank(files));
        match () {
            () if own.is_no_localizer != best.is_no_localizer => "a localizer",
            () if own.has_depth != best.has_depth => "a single image",
            () if own.is_scan != best.is_scan && self.first(files).segmentation.is_some() => "a segmentation",
            () if own.is_scan != best.is_scan => "not CT, MR or PET",
            () if own.is_picture != best.is_picture => "a map of values around 0",
            () if own.voxels < best.voxels => "fewer voxels",
            () if own.is_original != best.is_original => "derived",
            () => "equal to the first, and found later",
        }
    }

    /// Notes of the stack and of the files of a phase, each once.
    pub(crate) fn all_notes(&self, files: &[ImageFile], phase: &Phase) -> Vec<String> {
        let mut notes = self.notes.clone();
        for slice in &phase.slices {
            for note in &files[slice.file].notes {
                if !notes.contains(note) {
                    notes.push(note.clone());
                }
            }
        }
        notes
    }

    /// What the report says of the phase that is taken, where there are several.
    pub(crate) fn taken_note(&self, number: usize) -> String {
        format!("phase {} of {} is taken (told apart by {})", number + 1, self.phases.len(), self.told_by)
    }

    /// The even grid that a phase's slices become which lie at `places`.
    pub(crate) fn grid(&self, files: &[ImageFile], places: &[DVec3], sample_bytes: usize) -> Grid {
        let format = &self.first(files).format;
        let slice_bytes = format.columns * format.rows * sample_bytes;
        if self.first(files).segmentation.is_some() {
            // Slices without a label are no part of the file, however many they are.
            return label_grid::grid(&self.plane, places, most_slices(places.len(), slice_bytes, LABELS));
        }
        geometry::even_grid(&self.plane, places, most_slices(places.len(), slice_bytes, IMAGES))
    }

    /// What the report says about it, where `gaps` are left or filled.
    pub(crate) fn summary(&self, files: &[ImageFile], gaps: Gaps) -> SeriesSummary {
        let (first, phase) = (self.first(files), &self.phases[0]);
        let (columns, rows, n) = (first.format.columns, first.format.rows, phase.slices.len());
        let modality = if first.modality_code.is_empty() { "no modality" } else { first.modality_code };
        let number = first.series_number.map_or(String::new(), |number| format!(" series {number}"));
        let labels: String =
            first.labels.iter().filter(|label| !label.is_empty()).map(|label| format!(", {label}")).collect();
        let slices = if n == 1 { "slice" } else { "slices" };
        let kind = &first.frames[phase.slices[0].frame].kind;
        let kind = if kind.is_empty() { String::new() } else { format!(", {kind}") };
        let phases = match self.phases.len() {
            1 => String::new(),
            n => format!(", {n} phases"),
        };
        let mut used: Vec<usize> =
            self.phases.iter().flat_map(|phase| &phase.slices).map(|slice| slice.file).collect();
        used.sort_unstable();
        used.dedup();

        let sample_bytes = match &first.segmentation {
            Some(_) => storage::LABEL_BYTES,
            None => storage::sample_bytes(files, &phase.slices),
        };
        let mut notes = self.all_notes(files, phase);
        let mut grid = self.grid(files, &phase.places, sample_bytes);
        grid.settle(gaps);
        notes.extend(grid.notes);
        if self.phases.len() > 1 {
            notes.push(format!("{} phases, told apart by {}", self.phases.len(), self.told_by));
        }
        match phase.truncated(files) {
            0 => {}
            1 => notes.push(format!("1 of {n} slices is cut short")),
            cut => notes.push(format!("{cut} of {n} slices are cut short")),
        }
        let depth = grid.sources.map_or(n, |sources| sources.len());
        let matrix = grid.patient_from_voxel.matrix3;
        SeriesSummary {
            id: shown_id(first),
            uid: shown_uid(first).cloned(),
            number: first.series_number,
            name: match first.modality_code {
                "" | "other" => format!("Scan{number}"),
                code => format!("{code}{number}"),
            },
            description: format!(
                "{modality}{number}{labels}, {n} {slices}, {columns} x {rows}{kind}{phases}"
            ),
            files: used.len(),
            modality: first.modality_code.to_owned(),
            dims: [columns, rows, depth],
            spacing_mm: [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::length),
            orientation: orientation_words(matrix),
            phases: self.phases.len(),
            unit: first.unit.clone().into_owned(),
            bytes: (columns * rows * depth * sample_bytes) as u64,
            reason: String::new(),
            segments_series: None,
            aligned_series: Vec::new(),
            notes,
        }
    }
}

/// What decides between stacks, the weightiest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Rank {
    is_no_localizer: bool,
    has_depth: bool,
    is_scan: bool,
    is_picture: bool,
    voxels: usize,
    is_original: bool,
}

/// Bytes that a grid of images may take, however few they are; and one of labels.
const IMAGES: usize = 256 << 20;
const LABELS: usize = crate::sizes::at_most(2 << 30);

/// How many slices filling gaps may make of `slices`: a quarter more in any case, else as memory allows.
fn most_slices(slices: usize, slice_bytes: usize, always: usize) -> usize {
    /// More than any scan has; they cost time even where they are small.
    const MOST: usize = 16_384;
    const EIGHTFOLD: usize = crate::sizes::at_most(4 << 30);
    let eightfold = (slices * 8).min(EIGHTFOLD / slice_bytes);
    (slices + slices / 4 + 1).max(eightfold).max(MOST.min(always / slice_bytes))
}

/// SeriesInstanceUID as it may be shown. A damaged one may be any text, a patient's name too.
fn shown_uid(file: &ImageFile) -> Option<&String> {
    let is_uid = |uid: &&String| uid.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    file.series_uid.as_ref().filter(is_uid)
}

/// What a series is called: its SeriesInstanceUID, or a file's name.
pub(crate) fn shown_id(file: &ImageFile) -> String {
    let name = || file.source.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
    shown_uid(file).cloned().unwrap_or_else(name)
}

/// Whether two images may be of one volume, but for their places.
pub(super) fn alike(a: &Frame, b: &Frame) -> bool {
    // Directions of diffusion have numbers, too.
    let is_weighted = a.phase.b_value != 0 || b.phase.b_value != 0;
    a.kind == b.kind
        && (a.collapse == b.collapse || is_weighted)
        && a.position.is_some() == b.position.is_some()
        && a.row_direction.distance(b.row_direction) < SAME_DIRECTION
        && a.column_direction.distance(b.column_direction) < SAME_DIRECTION
        && (a.spacing_mm - b.spacing_mm).abs().max_element() < SAME_SPACING * a.spacing_mm.min_element()
}
