//! Images each of which is a series by itself, as some exports and anonymizers leave them: where they lie evenly one behind
//! the other, they are the slices of one volume.

use crate::dicom::{
    images::image_file::{ImageFile, Slice},
    series::{
        geometry::{Plane, sort_into_runs},
        stack::{Phase, Stack, alike},
    },
};

/// Fewer may lie evenly by chance.
const FEWEST: usize = 3;
/// By how much steps may differ from the first, as a part of it.
const EVEN: f64 = 0.05;
/// No slices lie farther apart, in mm.
const FARTHEST_MM: f64 = 20.0;
/// Groups that an image is compared with.
const GROUPS_COMPARED: usize = 256;

/// Puts stacks of one image together that are of as many series and fit.
pub(super) fn join(files: &[ImageFile], stacks: Vec<Stack>) -> Vec<Stack> {
    let (mut lone, mut kept): (Vec<Stack>, Vec<Stack>) =
        stacks.into_iter().partition(|stack| is_lone(files, stack));
    if lone.len() < FEWEST {
        kept.append(&mut lone);
        return kept;
    }
    let slice = |stack: &Stack| stack.phases[0].slices[0];
    let mut groups: Vec<Vec<Stack>> = Vec::new();
    for stack in lone {
        let fits = |group: &&mut Vec<Stack>| fits(files, slice(&group[0]), slice(&stack));
        match groups.iter_mut().rev().take(GROUPS_COMPARED).find(fits) {
            Some(group) => group.push(stack),
            None => groups.push(vec![stack]),
        }
    }
    for group in groups {
        match together(files, &group) {
            Some(stack) => kept.push(stack),
            None => kept.extend(group),
        }
    }
    kept
}

/// Whether a stack is the only image of its file, and has a place.
fn is_lone(files: &[ImageFile], stack: &Stack) -> bool {
    let [phase] = &stack.phases[..] else { return false };
    let [slice] = phase.slices[..] else { return false };
    let file = &files[slice.file];
    file.frames.len() == 1
        && file.frames[0].position.is_some()
        && file.segmentation.is_none()
        && !file.is_localizer
}

/// Whether two images may be of one volume, but for their series.
fn fits(files: &[ImageFile], a: Slice, b: Slice) -> bool {
    let (one, other) = (&files[a.file], &files[b.file]);
    (one.format.rows, one.format.columns) == (other.format.rows, other.format.columns)
        && (one.modality, one.patient) == (other.modality, other.patient)
        && (&one.kernel, &one.unit) == (&other.kernel, &other.unit)
        && alike(&one.frames[a.frame], &other.frames[b.frame])
}

/// The one stack of images that lie evenly, each of another series.
fn together(files: &[ImageFile], group: &[Stack]) -> Option<Stack> {
    let slices: Vec<Slice> = group.iter().map(|stack| stack.phases[0].slices[0]).collect();
    let mut series: Vec<_> = slices.iter().map(|slice| files[slice.file].series_uid.as_deref()).collect();
    series.sort_unstable();
    series.dedup();
    if slices.len() < FEWEST || series.len() < slices.len() {
        return None;
    }
    let places: Vec<_> = group.iter().map(|stack| stack.phases[0].places[0]).collect();
    let plane: Plane = group[0].plane;
    let runs = sort_into_runs(&plane, &places);
    let [run] = &runs[..] else { return None };
    let order: Vec<usize> =
        run.iter().map(|place| (place.len() == 1).then_some(place[0])).collect::<Option<_>>()?;
    let steps: Vec<_> = order.windows(2).map(|pair| places[pair[1]] - places[pair[0]]).collect();
    let first = *steps.first()?;
    let is_even = steps.iter().all(|step| step.distance(first) <= EVEN * first.length());
    if !is_even || first.length() > FARTHEST_MM {
        return None;
    }
    let note = format!("{} series of one image each lie evenly, and are taken for one volume", slices.len());
    let phase = Phase {
        slices: order.iter().map(|&k| slices[k]).collect(),
        places: order.iter().map(|&k| places[k]).collect(),
    };
    Some(Stack { plane, phases: vec![phase], told_by: String::new(), notes: vec![note] })
}
