//! What the frames of a file without functional groups are: slices, moments of time, or pictures that make no volume.
//!
//! FrameIncrementPointer names what counts them (PS3.3 C.7.6.6): for films a time, for nuclear medicine vectors of
//! numbers, one for each frame (C.8.4.8). Time is never depth.

use std::collections::{BTreeMap, BTreeSet};

use lumivox_core::glam::DVec3;

use crate::dicom::{
    elements::{
        attributes::{self as attr, Attribute},
        data_set::DataSet,
        values::FieldFault,
    },
    frames::frame::Frame,
    header::refusal::Refusal,
};

/// What parts the frames of nuclear medicine in time.
const MOMENTS: [Attribute; 4] =
    [attr::PHASE_VECTOR, attr::RR_INTERVAL_VECTOR, attr::TIME_SLOT_VECTOR, attr::TIME_SLICE_VECTOR];
/// What makes volumes of their own, and what a report calls it.
const KINDS: [(Attribute, &str); 2] =
    [(attr::ENERGY_WINDOW_VECTOR, "energy window"), (attr::DETECTOR_VECTOR, "detector")];
pub(crate) const OTHER_SERIES: &str = "Open a series of slices, or the volume that was reconstructed of it";

/// Refuses several frames that cannot be slices of a volume, whatever places they have.
///
/// # Errors
/// Says what they are.
pub(crate) fn refuse_pictures(data: &DataSet, frames: usize) -> Result<(), Refusal> {
    if frames < 2 {
        return Ok(());
    }
    let refuse = |what: &str| Err(Refusal::Unsupported(what.to_owned(), OTHER_SERIES));
    let sop_class = data.text(attr::SOP_CLASS_UID).unwrap_or_default();
    match sop_class.strip_prefix("1.2.840.10008.5.1.4.1.1.") {
        // PS3.4 B.5: radiographs and angiograms, enhanced ones, too; views of a breast for tomosynthesis; portal images.
        Some(
            "1" | "1.1" | "1.1.1" | "1.2" | "1.2.1" | "1.3" | "1.3.1" | "12.1" | "12.1.1" | "12.2" | "12.2.1"
            | "12.3" | "13.1.4" | "13.1.5" | "481.1",
        ) => return refuse("projections, which have no depth"),
        Some("3" | "3.1" | "6" | "6.1") => return refuse(FILM),
        Some("77.1.6") => return refuse(TILES),
        _ => {}
    }
    if let Some("TILED_FULL" | "TILED_SPARSE") = data.text(attr::DIMENSION_ORGANIZATION_TYPE).as_deref() {
        return refuse(TILES);
    }
    let counts = counted_by(data);
    let is_counted = |by: &Attribute| counts.contains(&by.tag);
    let is_planar = match data.texts(attr::IMAGE_TYPE).get(2).map(String::as_str) {
        Some("STATIC" | "WHOLE BODY" | "DYNAMIC" | "GATED" | "TOMO" | "GATED TOMO") => true,
        Some("RECON TOMO" | "RECON GATED TOMO") => false,
        _ => !counts.is_empty() && !is_counted(&attr::SLICE_VECTOR),
    };
    if is_planar && is_nuclear_medicine(data) {
        return refuse("planar pictures (of nuclear medicine), which have no depth");
    }
    let has_place = data.bytes(attr::IMAGE_POSITION_PATIENT).is_some();
    if is_film(data) && !has_place { refuse(FILM) } else { Ok(()) }
}

/// What frames of one place in time are.
pub(crate) const FILM: &str = "a film: its frames are moments of one picture, which has no depth";
const TILES: &str = "tiles of a microscope slide, which have no depth";

/// Whether frames follow each other in time, and not in space.
pub(crate) fn is_film(data: &DataSet) -> bool {
    let counts = counted_by(data);
    let is_reconstructed = data.texts(attr::IMAGE_TYPE).get(2).is_some_and(|kind| kind.starts_with("RECON"));
    let by_time = [attr::FRAME_TIME, attr::FRAME_TIME_VECTOR].iter().any(|time| counts.contains(&time.tag));
    // Where each frame has groups of its own, these say where it lies.
    let has_groups = !data.items(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE).is_empty();
    by_time
        && !has_groups
        && !is_reconstructed
        && ![attr::SLICE_LOCATION_VECTOR, attr::SLICE_VECTOR].iter().any(|by| counts.contains(&by.tag))
}

/// The item of each frame's detector of nuclear medicine, if there is any: the first, or those that DetectorVector counts.
///
/// # Errors
/// Where one that is counted is not described: its frames would lie where another's do.
pub(crate) fn detectors(data: &DataSet, frames: usize) -> Result<Vec<Option<&DataSet>>, FieldFault> {
    let items = data.items(attr::DETECTOR_INFORMATION_SEQUENCE);
    let numbers = vector(data, attr::DETECTOR_VECTOR, frames)?.unwrap_or_default();
    if items.is_empty() || numbers.iter().all(|number| *number == numbers[0]) {
        return Ok(vec![items.first(); frames]);
    }
    let of = |number: &u16| items.get(usize::from(*number).checked_sub(1)?);
    let found: Option<Vec<_>> = numbers.iter().map(|number| of(number).map(Some)).collect();
    found.ok_or_else(|| {
        let counted: BTreeSet<&u16> = numbers.iter().collect();
        let described = counted.iter().filter(|number| of(number).is_some()).count();
        let problem = format!("counts {} detectors, of which {described} are described", counted.len());
        FieldFault::new(attr::DETECTOR_VECTOR, problem)
    })
}

/// Places the frames of a file whose header says where the first one is, and tells which of them are phases.
///
/// # Errors
/// Where what counts them is damaged.
pub(crate) fn place_frames(
    frames: &mut [Frame],
    data: &DataSet,
    notes: &mut Vec<String>,
) -> Result<(), Refusal> {
    // That of the first one, or of the first of each detector.
    for frame in frames.iter_mut() {
        frame.position.get_or_insert(DVec3::ZERO);
    }
    if is_film(data) {
        for (moment, frame) in (1..).zip(frames) {
            frame.phase.temporal_position = moment;
        }
        return Ok(());
    }
    number_moments(frames, data)?;
    let offsets = offsets(frames, data, notes)?;
    for (frame, offset) in frames.iter_mut().zip(offsets) {
        let normal = frame.row_direction.cross(frame.column_direction);
        frame.position = frame.position.map(|first| first + normal * offset);
    }
    Ok(())
}

/// How far along the normal each frame lies behind the first place.
fn offsets(frames: &[Frame], data: &DataSet, notes: &mut Vec<String>) -> Result<Vec<f64>, Refusal> {
    // Depths of a dose grid are relative to the first image's plane, or absolute (PS3.3 C.8.8.3.2).
    for attribute in [attr::GRID_FRAME_OFFSET_VECTOR, attr::SLICE_LOCATION_VECTOR] {
        if let Some(depths) = data.decimal_list(attribute)? {
            check_count(attribute, depths.len(), frames.len())?;
            if attribute == attr::SLICE_LOCATION_VECTOR {
                notes.push(format!("the {} frames lie where {attribute} says", frames.len()));
            }
            return Ok(depths.iter().take(frames.len()).map(|depth| depth - depths[0]).collect());
        }
    }
    let mut step = frames[0].thickness_mm;
    // A negative one leads against the normal. Only of nuclear medicine is that defined (PS3.3 C.8.4.15), but nothing else
    // can be meant.
    let spacing = data.decimal(attr::SPACING_BETWEEN_SLICES).ok().flatten();
    let is_negative = spacing.is_some_and(|spacing| spacing < 0.0);
    if is_negative {
        step = -step;
    }
    if let Some(slices) = vector(data, attr::SLICE_VECTOR, frames.len())? {
        return Ok(slices.iter().map(|&slice| (f64::from(slice) - 1.0) * step).collect());
    }
    let n = frames.len();
    let how = if is_negative { ", against the normal (SpacingBetweenSlices is negative)" } else { "" };
    notes.push(format!("the places of the {n} frames are not given; stacked {} mm apart{how}", step.abs()));
    Ok((0..n).map(|k| k as f64 * step).collect())
}

/// Tells moments and kinds of frames, by the vectors of nuclear medicine that there are.
fn number_moments(frames: &mut [Frame], data: &DataSet) -> Result<(), Refusal> {
    let n = frames.len();
    let mut moments = vec![Vec::new(); n];
    for attribute in MOMENTS {
        let numbers = vector(data, attribute, n)?.unwrap_or_default();
        moments.iter_mut().zip(numbers).for_each(|(moment, number)| moment.push(number));
    }
    let different: BTreeSet<&Vec<u16>> = moments.iter().collect();
    if different.len() > 1 {
        let numbers: BTreeMap<&Vec<u16>, i64> = different.into_iter().zip(1..).collect();
        for (frame, moment) in frames.iter_mut().zip(&moments) {
            frame.phase.temporal_position = numbers[moment];
        }
    }
    for (attribute, name) in KINDS {
        let Some(numbers) = vector(data, attribute, n)? else { continue };
        if numbers.iter().any(|number| *number != numbers[0]) {
            for (frame, number) in frames.iter_mut().zip(numbers) {
                frame.kind = format!("{} {name} {number}", frame.kind).trim_start().to_owned();
            }
        }
    }
    Ok(())
}

/// The numbers of an indexing vector, one for each of `frames`.
fn vector(data: &DataSet, attribute: Attribute, frames: usize) -> Result<Option<Vec<u16>>, FieldFault> {
    let Some(mut numbers) = data.words(attribute).filter(|numbers| !numbers.is_empty()) else {
        return Ok(None);
    };
    check_count(attribute, numbers.len(), frames)?;
    numbers.truncate(frames);
    Ok(Some(numbers))
}

fn check_count(attribute: Attribute, count: usize, frames: usize) -> Result<(), FieldFault> {
    if count >= frames {
        return Ok(());
    }
    Err(FieldFault::new(attribute, format!("has {count} values for {frames} frames")))
}

/// The tags of what counts frames.
fn counted_by(data: &DataSet) -> Vec<u32> {
    let words = data.words(attr::FRAME_INCREMENT_POINTER).unwrap_or_default();
    words.chunks_exact(2).map(|tag| u32::from(tag[0]) << 16 | u32::from(tag[1])).collect()
}

fn is_nuclear_medicine(data: &DataSet) -> bool {
    data.text(attr::MODALITY).as_deref() == Some("NM")
}
