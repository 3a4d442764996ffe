//! From images to stacks: what belongs together, what to load, what to leave out.
//!
//! FrameOfReferenceUID parts nothing: whole scans are known to have a new one in every slice.

use std::collections::{HashMap, HashSet};

use lumivox_core::glam::DVec3;

use crate::{
    dicom::{
        elements::attributes as attr,
        frames::{frame::PhaseKey, multi_frame},
        images::image_file::{ImageFile, Slice},
        series::{
            geometry::{Plane, sort_into_runs},
            lone_images,
            phases::{phases_of_run, strong_classes},
            stack::{Phase, Stack, alike, shown_id},
        },
    },
    report::SeriesSummary,
    report::SkippedFile,
};

/// Groups of one series that an image is compared with, so that a file of a thousand odd frames takes no thousand times
/// as long.
const GROUPS_COMPARED: usize = 256;

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

/// What stands before the number of a part.
const PART: char = '#';

/// Gives each series an id of its own: of those that have one in common, as the planes of a localizer and the kinds of an MR have, the
/// second of the list is `ID#2`.
pub(crate) fn name_apart(series: &mut [SeriesSummary]) {
    let mut known: HashMap<String, usize> = HashMap::new();
    for one in series {
        let count = known.entry(one.id.clone()).or_default();
        *count += 1;
        if *count > 1 {
            one.id = format!("{}{PART}{count}", one.id);
        }
    }
}

/// The positions of the stacks that `wanted` names: none, the one that is meant, or several that it cannot tell apart.
///
/// The 1-based position counts first, since it is what a list of the series shows; then SeriesInstanceUID (or what is
/// shown in its place), whose best stack is taken, or the one that is [named](name_apart) by it; then the series number.
pub(crate) fn choose(stacks: &[Stack], files: &[ImageFile], wanted: &str) -> Vec<usize> {
    let wanted = wanted.trim();
    let position = wanted.parse::<usize>().ok().and_then(|position| position.checked_sub(1));
    if let Some(index) = position.filter(|&index| index < stacks.len()) {
        return vec![index];
    }
    let of_id = |id: &str, part: usize| {
        (0..stacks.len()).filter(|&k| shown_id(stacks[k].first(files)) == id).nth(part.checked_sub(1)?)
    };
    let of_part = || {
        let (id, part) = wanted.rsplit_once(PART)?;
        of_id(id, part.parse().ok()?)
    };
    if let Some(index) = of_id(wanted, 1).or_else(of_part) {
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
