//! From images to stacks: what belongs together, what to load, what to leave out.
//!
//! A stack is what becomes a volume: images of one series with one size, spacing, orientation and kind, in order along
//! their normal. FrameOfReferenceUID parts nothing: whole scans are known to have a new one in every slice.

use std::collections::HashMap;

use lumivox_core::{Modality, glam::DVec3};

use super::{
    attributes as attr,
    geometry::{Plane, sort_into_runs},
    header::{Frame, ImageFile},
};
use crate::report::{SeriesSummary, SkippedFile};

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

/// Images that make up a volume.
#[derive(Clone, Debug)]
pub(crate) struct Stack {
    /// In order along the normal.
    pub(crate) slices: Vec<Slice>,
    pub(crate) plane: Plane,
    /// Where the first pixel of each slice lies.
    pub(crate) places: Vec<DVec3>,
    /// Sentences about liberties taken.
    pub(crate) notes: Vec<String>,
}

impl Stack {
    /// The file of the first slice, which speaks for all.
    pub(crate) fn first<'a>(&self, files: &'a [ImageFile]) -> &'a ImageFile {
        &files[self.slices[0].file]
    }

    fn voxels(&self, files: &[ImageFile]) -> usize {
        let format = &self.first(files).format;
        self.slices.len().saturating_mul(format.rows * format.columns)
    }

    /// What the report says about it.
    pub(crate) fn summary(&self, files: &[ImageFile]) -> SeriesSummary {
        let first = self.first(files);
        let (columns, rows, n) = (first.format.columns, first.format.rows, self.slices.len());
        let modality = if first.modality_code.is_empty() { "no modality" } else { first.modality_code };
        let slices = if n == 1 { "slice" } else { "slices" };
        let kind = &first.frames[self.slices[0].frame].kind;
        let kind = if kind.is_empty() { String::new() } else { format!(", {kind}") };
        let mut used: Vec<usize> = self.slices.iter().map(|slice| slice.file).collect();
        used.sort_unstable();
        used.dedup();
        SeriesSummary {
            id: shown_id(first),
            number: first.series_number,
            description: format!("{modality}, {n} {slices}, {columns} x {rows}{kind}"),
            files: used.len(),
        }
    }
}

/// What a series is called: its SeriesInstanceUID, or a file's name. A damaged UID may be any text, a patient's name too.
fn shown_id(file: &ImageFile) -> String {
    let is_uid = |uid: &&String| uid.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    match file.series_uid.as_ref().filter(is_uid) {
        Some(uid) => uid.clone(),
        None => file.source.path().file_name().unwrap_or_default().to_string_lossy().into_owned(),
    }
}

/// Sorts all images of `files` into stacks, the best first: those with depth before single slices, CT, MR and PET before
/// dose grids and the like, then by voxels.
pub(crate) fn stacks(files: &[ImageFile]) -> (Vec<Stack>, Vec<SkippedFile>) {
    let mut stacks = Vec::new();
    let mut skipped = Vec::new();
    for group in groups(files) {
        stack_group(files, group, &mut stacks, &mut skipped);
    }
    // A localizer is a picture to plan by; it is shown only where there is nothing else.
    if stacks.iter().any(|stack| !stack.first(files).is_localizer) {
        stacks.retain(|stack| {
            let keep = !stack.first(files).is_localizer;
            if !keep {
                skipped.extend(stack.slices.iter().map(|slice| skip(&files[slice.file], "a localizer")));
            }
            keep
        });
    }
    // Stable: where nothing else decides, the order of the files does.
    stacks.sort_by_key(|stack| {
        let is_scan = stack.first(files).modality != Modality::Other;
        std::cmp::Reverse((stack.slices.len() > 1, is_scan, stack.voxels(files)))
    });
    (stacks, skipped)
}

fn skip(file: &ImageFile, reason: &str) -> SkippedFile {
    SkippedFile { path: file.source.path(), reason: reason.to_owned() }
}

/// Images of one series that share size, spacing, orientation and kind.
fn groups(files: &[ImageFile]) -> Vec<Vec<Slice>> {
    let mut groups: Vec<Vec<Slice>> = Vec::new();
    let mut of_series: HashMap<&str, Vec<usize>> = HashMap::new();
    for (file, image) in files.iter().enumerate() {
        let series = of_series.entry(image.series_uid.as_deref().unwrap_or_default()).or_default();
        for frame in 0..image.frames.len() {
            let belongs = |&group: &usize| {
                let first = groups[group][0];
                let (of, first) = (&files[first.file], &files[first.file].frames[first.frame]);
                (of.format.rows, of.format.columns) == (image.format.rows, image.format.columns)
                    && (of.modality, of.is_localizer) == (image.modality, image.is_localizer)
                    && alike(first, &image.frames[frame])
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

fn alike(a: &Frame, b: &Frame) -> bool {
    a.kind == b.kind
        && a.position.is_some() == b.position.is_some()
        && a.row_direction.distance(b.row_direction) < SAME_DIRECTION
        && a.column_direction.distance(b.column_direction) < SAME_DIRECTION
        && (a.spacing_mm - b.spacing_mm).abs().max_element() < SAME_SPACING * a.spacing_mm.min_element()
}

/// Makes stacks of a group, whose images may lie in several places.
fn stack_group(
    files: &[ImageFile],
    mut group: Vec<Slice>,
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
            let places = vec![DVec3::ZERO];
            stacks.push(Stack { slices: vec![slice], plane, places, notes });
        } else {
            // Neither instance numbers nor names are a safe order.
            let reason = format!("{} is missing, so that its place is unknown", attr::IMAGE_POSITION_PATIENT);
            skipped.extend(group.iter().map(|slice| skip(&files[slice.file], &reason)));
        }
        return;
    };
    // Of several images at one place the first in this order stays.
    let mut order: Vec<usize> = (0..group.len()).collect();
    order.sort_by_key(|&k| (frame(&group[k]).sequence, group[k].frame));
    group = order.iter().map(|&k| group[k]).collect();
    let places: Vec<DVec3> = order.iter().map(|&k| places[k]).collect();
    for (run, repeated) in sort_into_runs(&plane, &places).runs {
        let mut notes = Vec::new();
        let (n, all) = (run.len(), run.len() + repeated);
        if repeated > 0 && all.is_multiple_of(n) {
            let each = all / n;
            notes.push(format!(
                "{each} images lie at every place (phases, echoes or copies); the first of each is used"
            ));
        } else if repeated > 0 {
            notes.push(format!(
                "{repeated} of {all} images lie at the place of another; the first of each is used"
            ));
        }
        stacks.push(Stack {
            slices: run.iter().map(|&k| group[k]).collect(),
            places: run.iter().map(|&k| places[k]).collect(),
            plane,
            notes,
        });
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
    (0..stacks.len()).filter(|&k| stacks[k].first(files).series_number == Some(number)).collect()
}
