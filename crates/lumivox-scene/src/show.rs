//! What of a scan is shown: the patient alone, without what hides what the look is for.

use lumivox_core::{
    CancelToken, Cancelled, LabelVolume, Peel, Preset, Volume,
    document::{Entry, Keep, TakenOff},
    words::number,
};
use lumivox_segmentation::{
    SegmentationReport, has_organ, organ_alone, patient_alone, peel, peel_skin, segment, skin_depth,
    skin_is_dense,
};
use std::sync::Arc;

use crate::{Audience, Note, Remedy};

/// A scan as it is shown.
#[derive(Debug)]
pub struct Shown {
    /// Its voxels.
    pub volume: Volume,
    /// What was found in it, where somebody asked.
    pub found: Option<LabelVolume>,
    /// What is not seen of it though it is there.
    pub peel: Option<Peel>,
}

/// Takes out of a scan what its entry does not keep, and takes off what hides what its look is for.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
pub fn show(
    entry: &Entry,
    scan: Volume,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Shown, Cancelled> {
    let wants_labels = entry.labels.as_ref().is_some_and(|labels| labels.files.is_empty());
    let wants_peel = entry.peel.filter(|mm| *mm > 0.0);
    let find = |volume: &Volume| audience.watch(|progress| segment(volume, progress, cancel));
    if entry.scan.keep == Keep::Everything && wants_peel.is_none() {
        let found = if wants_labels { Some(find(&scan)?.labels) } else { None };
        return Ok(Shown { volume: scan, found, peel: None });
    }
    let (volume, mut found, sure) = match entry.scan.keep {
        Keep::Everything => {
            let found = find(&scan)?;
            (scan, Some(found.labels), found.report.is_sure())
        }
        Keep::Patient => {
            let alone = audience.watch(|progress| patient_alone(scan, progress, cancel))?;
            if let Some(note) = alone.note() {
                let note = Note::new(note);
                audience.note(if alone.changed > 0 { note.with(Remedy::KeepEverything) } else { note });
            }
            let sure = alone.report.as_ref().is_some_and(SegmentationReport::is_sure);
            (alone.volume, alone.labels, sure)
        }
    };
    if wants_labels && found.is_none() {
        // What is not looked for in what is no CT: body and air, of an MR.
        found = Some(find(&volume)?.labels);
    }
    let volume = match entry.scan.keep {
        Keep::Everything => volume,
        Keep::Patient => taken_off(entry, volume, found.as_ref().filter(|_| sure), audience, cancel)?,
    };
    let peel = match (wants_peel, found.as_ref().filter(|_| sure)) {
        (Some(mm), Some(labels)) => {
            let depth = audience.watch(|progress| skin_depth(&volume, labels, progress, cancel))?;
            Some(Peel { depth: Arc::new(depth), mm })
        }
        (Some(_), None) => {
            audience.note(nothing_peeled());
            None
        }
        (None, _) => None,
    };
    Ok(Shown { volume, found: found.filter(|_| wants_labels), peel })
}

fn nothing_peeled() -> Note {
    Note::new("nothing is peeled: no skin was found, as in all that is no CT of a body")
}

/// The patient without what is taken off; `labels` are what was found, if that is sure.
fn taken_off(
    entry: &Entry,
    volume: Volume,
    labels: Option<&LabelVolume>,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Volume, Cancelled> {
    let look = &entry.look;
    // A look of its own hides nothing by itself.
    let preset = match (look.preset, &look.transfer_function) {
        (Some(preset), _) => Some(preset),
        (None, None) => Some(Preset::default_for(&volume)),
        (None, Some(_)) => None,
    };
    let by_look = || match preset.and_then(Preset::organ) {
        Some(organ) => TakenOff::AllBut(organ),
        None => TakenOff::Skin(preset.map_or(0.0, Preset::peel_mm)),
    };
    let is_asked = entry.scan.taken_off.is_some();
    let said = |mm: f64, what: &str| audience.say(&format!("  {} mm {what} taken off", number(mm)));
    match (entry.scan.taken_off.unwrap_or_else(by_look), labels) {
        (TakenOff::AllBut(organ), Some(labels)) if has_organ(labels, organ) => {
            audience.watch(|progress| organ_alone(volume, labels, organ, progress, cancel))
        }
        (TakenOff::AllBut(_), _) => {
            audience.note(Note::new("no lungs with airways were found: all is shown"));
            Ok(volume)
        }
        (TakenOff::Skin(mm), Some(labels)) if mm > 0.0 && (is_asked || skin_is_dense(&volume, labels)) => {
            said(mm, "of skin are");
            audience.watch(|progress| peel_skin(volume, labels, mm, progress, cancel))
        }
        (TakenOff::Depth(mm), Some(labels)) if mm > 0.0 => {
            said(mm, "below the skin are");
            audience.watch(|progress| peel(volume, labels, mm, progress, cancel))
        }
        (TakenOff::Depth(mm), None) if mm > 0.0 => {
            audience.note(nothing_peeled());
            Ok(volume)
        }
        (TakenOff::Nothing | TakenOff::Skin(_) | TakenOff::Depth(_), _) => Ok(volume),
    }
}
