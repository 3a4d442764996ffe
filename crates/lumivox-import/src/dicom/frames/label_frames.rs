//! The frames of a segmentation: which segment each shows, and where they lie where the file does not say.

use std::collections::{BTreeMap, BTreeSet};

use crate::dicom::{
    elements::{attributes as attr, data_set::DataSet, values::FieldFault},
    frames::frame::Frame,
    header::{refusal::Refusal, segments::Kind},
};

/// Gives frames without the number of a segment that of the only one there is.
///
/// # Errors
/// Where several frames have none, and several segments may be meant. Frames whose pixels are numbers need none.
pub(crate) fn number_frames(frames: &mut [Frame], data: &DataSet) -> Result<(), FieldFault> {
    let (n, missing) = (frames.len(), frames.iter().filter(|frame| frame.segment.is_none()).count());
    if missing == 0 || Kind::of(data) == Kind::Labels {
        return Ok(());
    }
    let number = match data.items(attr::SEGMENT_SEQUENCE) {
        [only] => only.unsigned(attr::SEGMENT_NUMBER).and_then(|number| u16::try_from(number).ok()),
        _ if n > 1 => {
            let problem = format!("is missing in {missing} of {n} frames");
            return Err(FieldFault::new(attr::REFERENCED_SEGMENT_NUMBER, problem));
        }
        _ => None,
    };
    frames.iter_mut().for_each(|frame| frame.segment = frame.segment.or(number));
    Ok(())
}

/// Stacks the frames of a segmentation that says nowhere where they lie, if it tells their order; says so.
///
/// # Errors
/// Where the order is not known, or where only some frames have a place.
pub(crate) fn stack_frames(frames: &mut [Frame], data: &DataSet) -> Result<Option<String>, Refusal> {
    let n = frames.len();
    match frames.iter().filter(|frame| frame.position.is_none()).count() {
        0 => return Ok(None),
        missing if missing == n => {}
        missing => {
            let problem = format!("is missing in {missing} of {n} frames");
            return Err(FieldFault::new(attr::IMAGE_POSITION_PATIENT, problem).into());
        }
    }
    let (slices, by) = match (slices_in_stack(data, n), slices_of_segments(frames)) {
        (Some(slices), _) => (slices, "by InStackPositionNumber"),
        (None, Some(slices)) => (slices, "in the order of the frames"),
        (None, None) => {
            return Err(Refusal::Unsupported(
                "a segmentation without the places of its frames, in an order that does not tell them"
                    .to_owned(),
                "Export it again with ImagePositionPatient for each frame",
            ));
        }
    };
    let first = &frames[0];
    let step = first.row_direction.cross(first.column_direction) * first.thickness_mm;
    let (count, mm) = (slices.iter().collect::<BTreeSet<_>>().len(), first.thickness_mm);
    for (frame, slice) in frames.iter_mut().zip(slices) {
        frame.position = Some(step * slice as f64);
    }
    Ok(Some(match count {
        1 => "the place in the patient is not given; put at the origin".to_owned(),
        _ => format!(
            "the places of the {count} slices are not given; stacked {mm} mm apart at the origin, {by}"
        ),
    }))
}

/// The slice of each of `n` frames, by the file's own count of its stack.
fn slices_in_stack(data: &DataSet, n: usize) -> Option<Vec<usize>> {
    let number = |group: &DataSet| {
        let content = group.items(attr::FRAME_CONTENT_SEQUENCE).first()?;
        content.unsigned(attr::IN_STACK_POSITION_NUMBER).map(|number| number as usize)
    };
    let groups = data.items(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE).iter().take(n);
    let numbers: Vec<usize> = groups.map(number).collect::<Option<_>>()?;
    let lowest = *numbers.iter().min().filter(|_| numbers.len() == n)?;
    Some(numbers.iter().map(|number| number - lowest).collect())
}

/// The slice of each frame where every segment has a frame in each: those of one follow each other.
fn slices_of_segments(frames: &[Frame]) -> Option<Vec<usize>> {
    let mut counts: BTreeMap<Option<u16>, usize> = BTreeMap::new();
    let mut count = |frame: &Frame| {
        let count = counts.entry(frame.segment).or_default();
        *count += 1;
        *count - 1
    };
    let slices: Vec<usize> = frames.iter().map(&mut count).collect();
    let each = frames.len() / counts.len();
    counts.values().all(|count| *count == each).then_some(slices)
}
