//! From images to stacks: what belongs together, what to load, what to leave out.
//!
//! A stack is what becomes a volume: images of one series with one size, spacing, orientation and kind, in order along
//! their normal, once for each phase. FrameOfReferenceUID parts nothing: whole scans are known to have a new one in
//! every slice.

use std::collections::{HashMap, HashSet};

use lumivox_core::{Modality, glam::DVec3};

use super::{
    attributes as attr,
    frames::{Frame, PhaseKey},
    gaps::Gaps,
    geometry::{self, Grid, Plane, sort_into_runs},
    header::ImageFile,
    lone_images, multi_frame,
    phases::{phases_of_run, strong_classes},
    pixels, segmentation,
};
use crate::report::{SeriesSummary, SkippedFile, orientation_words};

/// Directions nearer than this are one: 0.1 degrees, more than writers round away.
const SAME_DIRECTION: f64 = 2e-3;
/// Relative difference of pixel spacings that are one.
const SAME_SPACING: f64 = 1e-3;

/// Groups of one series that an image is compared with, so that a file of a thousand odd frames takes no thousand times
/// as long.
const GROUPS_COMPARED: usize = 256;

/// One image: a frame of a file, by position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slice {
    pub(crate) file: usize,
    pub(crate) frame: usize,
}

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
    fn rank(&self, files: &[ImageFile]) -> Rank {
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
            return segmentation::grid(&self.plane, places, most_slices(places.len(), slice_bytes, LABELS));
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
            Some(_) => segmentation::SAMPLE_BYTES,
            None => pixels::sample_bytes(files, &phase.slices),
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
struct Rank {
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
fn shown_id(file: &ImageFile) -> String {
    let name = || file.source.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
    shown_uid(file).cloned().unwrap_or_else(name)
}

/// Sorts all images of `files` into stacks, the best first: localizers, which are pictures to plan by, last; those with
/// depth before single slices, CT, MR and PET before dose grids and the like, then by voxels.
pub(crate) fn stacks(files: &[ImageFile]) -> (Vec<Stack>, Vec<SkippedFile>) {
    let mut stacks = Vec::new();
    let mut skipped = Vec::new();
    let copies = copies(files);
    for (file, _) in files.iter().zip(&copies).filter(|(_, is_copy)| **is_copy) {
        skipped.push(skip(file, "a copy of another file (the same SOPInstanceUID)"));
    }
    for group in groups(files, &copies) {
        stack_group(files, group, &mut stacks, &mut skipped);
    }
    let mut stacks = lone_images::join(files, stacks);
    // Stable: where nothing else decides, the order of the files does.
    stacks.sort_by_key(|stack| std::cmp::Reverse(stack.rank(files)));
    (stacks, skipped)
}

fn skip(file: &ImageFile, reason: &str) -> SkippedFile {
    SkippedFile { path: file.source.path(), reason: reason.to_owned() }
}

/// Which files say and show that they are another one. Careless anonymizers give all instances one UID: the place must
/// be the same too.
fn copies(files: &[ImageFile]) -> Vec<bool> {
    let mut seen = HashMap::new();
    let mut copies = vec![false; files.len()];
    for (index, file) in files.iter().enumerate() {
        let Some(uid) = &file.instance_uid else { continue };
        let place = file.frames.first().and_then(|frame| frame.position);
        let instance = file.frames.first().map(|frame| frame.phase.instance);
        let bits = place.map(|place| place.to_array().map(f64::to_bits));
        let kept = seen.entry((uid, file.series_uid.as_deref(), bits, instance, file.frames.len()));
        let kept = kept.or_insert(index);
        // Of a whole one and one that is cut short, the whole one is kept.
        let copy = if file.whole > files[*kept].whole { std::mem::replace(kept, index) } else { index };
        copies[copy] |= copy != *kept;
    }
    copies
}

/// Images of one series that share size, spacing, orientation and kind.
fn groups(files: &[ImageFile], left_out: &[bool]) -> Vec<Vec<Slice>> {
    let mut groups: Vec<Vec<Slice>> = Vec::new();
    // The files of a series, and their patients. Careless programs give one UID to series of several patients; careless
    // anonymizers give every file a patient of its own, which tells nothing.
    let mut patients: HashMap<Option<&str>, (usize, HashSet<u64>)> = HashMap::new();
    for image in files {
        let (count, of_series) = patients.entry(image.series_uid.as_deref()).or_default();
        *count += 1;
        of_series.insert(image.patient);
    }
    let several = |image: &ImageFile| {
        let (count, of_series) = &patients[&image.series_uid.as_deref()];
        of_series.len() > 1 && 2 * of_series.len() <= *count
    };
    let mut of_series: HashMap<&str, Vec<usize>> = HashMap::new();
    for (file, image) in files.iter().enumerate().filter(|(file, _)| !left_out[*file]) {
        let series = of_series.entry(image.series_uid.as_deref().unwrap_or_default()).or_default();
        for frame in 0..image.frames.len() {
            let belongs = |&group: &usize| {
                let first = groups[group][0];
                let of = &files[first.file];
                (of.format.rows, of.format.columns) == (image.format.rows, image.format.columns)
                    && (of.modality, of.is_localizer) == (image.modality, image.is_localizer)
                    && (of.patient == image.patient || !several(image))
                    && (&of.kernel, &of.unit) == (&image.kernel, &image.unit)
                    // Each file of labels is a volume of its own.
                    && (image.segmentation.is_none() && of.segmentation.is_none() || first.file == file)
                    && alike(&of.frames[first.frame], &image.frames[frame])
            };
            let slice = Slice { file, frame };
            match series.iter().rev().take(GROUPS_COMPARED).copied().find(|group| belongs(group)) {
                Some(group) => groups[group].push(slice),
                None => {
                    series.push(groups.len());
                    groups.push(vec![slice]);
                }
            }
        }
    }
    groups
}

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

/// Whether places cannot be those of slices in such planes: they lie beside each other, and not behind.
fn contradict_orientation(plane: &Plane, places: &[DVec3]) -> bool {
    /// Slices of a tilted gantry are farther apart along their normal than across it.
    const BESIDE: f64 = 2.0;
    const SOME_MM: f64 = 0.1;
    let normal = plane.normal();
    places.iter().any(|place| {
        let offset = *place - places[0];
        let behind = offset.dot(normal);
        let beside = (offset - normal * behind).length();
        beside > SOME_MM && beside > BESIDE * behind.abs()
    })
}

/// Makes stacks of a group, whose images may lie in several places and belong to several phases.
fn stack_group(
    files: &[ImageFile],
    group: Vec<Slice>,
    stacks: &mut Vec<Stack>,
    skipped: &mut Vec<SkippedFile>,
) {
    let frame = |slice: &Slice| &files[slice.file].frames[slice.frame];
    let first = frame(&group[0]);
    let plane = Plane {
        row_direction: first.row_direction,
        column_direction: first.column_direction,
        spacing_mm: first.spacing_mm,
        thickness_mm: first.thickness_mm,
    };
    let Some(places) = group.iter().map(|slice| frame(slice).position).collect::<Option<Vec<_>>>() else {
        if let [slice] = group[..] {
            let notes = vec!["the place in the patient is not given; put at the origin".to_owned()];
            let phases = vec![Phase { slices: vec![slice], places: vec![DVec3::ZERO] }];
            stacks.push(Stack { plane, phases, told_by: String::new(), notes });
        } else {
            // Neither instance numbers nor names are a safe order.
            let reason = format!("{} is missing, so that its place is unknown", attr::IMAGE_POSITION_PATIENT);
            skipped.extend(group.iter().map(|slice| skip(&files[slice.file], &reason)));
        }
        return;
    };
    if !first.is_oriented && contradict_orientation(&plane, &places) {
        let reason = format!(
            "{} is missing, and its positions are not those of the axial slices that it might show",
            attr::IMAGE_ORIENTATION_PATIENT
        );
        skipped.extend(group.iter().map(|slice| skip(&files[slice.file], &reason)));
        return;
    }
    let phase = |images: &[usize]| Phase {
        slices: images.iter().map(|&k| group[k]).collect(),
        places: images.iter().map(|&k| places[k]).collect(),
    };
    if files[group[0].file].segmentation.is_some() {
        // A frame for each segment at each place; labels are put together when they are read.
        let images: Vec<usize> =
            sort_into_runs(&plane, &places).iter().flatten().map(|place| place[0]).collect();
        let phases = vec![phase(&images)];
        stacks.push(Stack { plane, phases, told_by: String::new(), notes: Vec::new() });
        return;
    }
    let film = &files[group[0].file];
    if film.is_film && film.frames.len() > 1 && places.iter().all(|place| *place == places[0]) {
        let mut films: Vec<usize> = group.iter().map(|slice| slice.file).collect();
        films.dedup();
        let reason = format!("{}. {}", multi_frame::FILM, multi_frame::OTHER_SERIES);
        skipped.extend(films.into_iter().map(|file| skip(&files[file], &reason)));
        return;
    }
    let keys: Vec<PhaseKey> = group.iter().map(|slice| frame(slice).phase).collect();
    let normal = plane.normal();
    let depths: Vec<f64> = places.iter().map(|place| place.dot(normal)).collect();
    let (classes, told_by) = strong_classes(&keys, &depths, plane.thickness_mm);
    // By class, then run, then place.
    let runs: Vec<_> = classes
        .iter()
        .map(|class| {
            let mut runs = sort_into_runs(&plane, &class.iter().map(|&k| places[k]).collect::<Vec<_>>());
            runs.iter_mut().flatten().flatten().for_each(|index| *index = class[*index]);
            runs
        })
        .collect();
    let is_one = runs.iter().all(|of_class| of_class.len() == runs[0].len());
    let mut add = |runs: Vec<&Vec<Vec<usize>>>| {
        let (mut phases, mut told_by, mut notes) = (Vec::new(), told_by.clone(), Vec::new());
        for run in runs {
            let found = phases_of_run(run, &keys);
            phases.extend(found.phases.iter().map(|images| phase(images)));
            if !found.told_by.is_empty() && !told_by.contains(&found.told_by) {
                told_by.push(found.told_by);
            }
            if found.repeated > 0 {
                let all = found.repeated + run.len();
                notes.push(format!(
                    "{} of {all} images lie at the place of another; the first of each is used",
                    found.repeated
                ));
            }
        }
        stacks.push(Stack { plane, phases, told_by: told_by.join(" and "), notes });
    };
    if is_one {
        (0..runs[0].len()).for_each(|run| add(runs.iter().map(|of_class| &of_class[run]).collect()));
    } else {
        runs.iter().flatten().for_each(|run| add(vec![run]));
    }
}

/// The positions of the stacks that `wanted` names: none, the one that is meant, or several that it cannot tell apart.
///
/// The 1-based position counts first, since it is what a list of the series shows; then SeriesInstanceUID (or what is
/// shown in its place), whose best stack is taken; then the series number.
pub(crate) fn choose(stacks: &[Stack], files: &[ImageFile], wanted: &str) -> Vec<usize> {
    let wanted = wanted.trim();
    let position = wanted.parse::<usize>().ok().and_then(|position| position.checked_sub(1));
    if let Some(index) = position.filter(|&index| index < stacks.len()) {
        return vec![index];
    }
    if let Some(index) = stacks.iter().position(|stack| shown_id(stack.first(files)) == wanted) {
        return vec![index];
    }
    let Ok(number) = wanted.parse::<i64>() else { return Vec::new() };
    let mut found: Vec<usize> =
        (0..stacks.len()).filter(|&k| stacks[k].first(files).series_number == Some(number)).collect();
    // A localizer of the same number is hardly meant.
    if found.iter().any(|&k| !stacks[k].first(files).is_localizer) {
        found.retain(|&k| !stacks[k].first(files).is_localizer);
    }
    found
}
