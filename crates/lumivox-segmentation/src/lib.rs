//! Finds by itself what of a scan belongs to the patient: body, lungs, airways and gas, apart from the table, what lies
//! around, and air.
//!
//! [`segment`] labels the voxels of a [`Volume`], [`depth_below_skin`] measures how deep each lies, and [`patient_alone`]
//! takes what lies around out of a scan ([`Surroundings`] bring it back), as [`peel`] takes the skin; [`organ_alone`] leaves only
//! airways or vessels. What is global is decided
//! on a grid of some 2 mm (`grid.rs`); voxels are then told apart by their own values.
//!
//! ```
//! use lumivox_core::{CancelToken, Progress};
//! use lumivox_phantom::{AnatomyOptions, anatomy};
//! use lumivox_segmentation::{Class, segment};
//!
//! let cancel = CancelToken::new();
//! let options = AnatomyOptions { size: 64, ..Default::default() };
//! let head = anatomy(options, Progress::SILENT, &cancel).unwrap();
//! let found = segment(&head, Progress::SILENT, &cancel).unwrap();
//! println!("{}", found.report);
//! let body = found.labels.counts()[usize::from(Class::Body.value())];
//! assert!(body > 30_000, "{body}");
//! ```

mod airways;
mod alone;
mod body;
mod cast;
mod class;
mod components;
mod ct;
mod distance;
mod grid;
mod lungs;
mod mr;
mod odd_slices;
mod organ;
mod outside;
mod peel;
mod progress;
mod refine;
mod report;
mod shape;
mod skin_depth;
mod smooth;
mod surroundings;
mod table;
mod thickness;

use lumivox_core::{CancelToken, Cancelled, LabelVolume, Modality, Progress, Volume, labels::LabelSource};

pub use alone::{PatientAlone, patient_alone};
pub use class::Class;
pub use distance::{DEPTH_STEP_MM, DepthField};
pub use organ::{find_organ, has_organ, organ_alone};
pub use peel::{peel, peel_skin, skin_is_dense};
pub use report::{Finding, LEAST_CONFIDENCE, SegmentationReport};
pub use skin_depth::skin_depth;
pub use surroundings::{Surroundings, WrongSurroundings};

use progress::Steps;

/// What belongs to what, and how sure that is.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Segmentation {
    /// The [`Class`] of each voxel, on the scan's own grid. Who wants to see the patient alone hides what
    /// [`Class::is_thing`]; air need not be hidden, and at the skin it holds what is skin in part.
    pub labels: LabelVolume,
    /// What was found.
    pub report: SegmentationReport,
}

/// Labels found so far, and how sure they are.
struct Labelled {
    labels: Vec<u8>,
    confidence: f64,
    notes: Vec<String>,
}

/// Tells apart what a scan shows: a CT in Hounsfield units, or what has their range, in all classes, an MR in body and air. Of anything else, and
/// where it is not sure enough ([`LEAST_CONFIDENCE`]), everything is [`Class::Body`], so that nothing gets lost.
///
/// The same scan gives the same labels, on any number of threads.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
pub fn segment(
    volume: &Volume,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Segmentation, Cancelled> {
    let steps = Steps::new(progress);
    let (labels, report) = labels_of(volume, &steps, cancel)?;
    steps.report(0.0, 1.0, 1.0);
    Ok(Segmentation { labels, report })
}

/// How deep below the body's outer surface each voxel of a scan lies, by the labels that [`segment`] found in it: what a
/// renderer peels the skin by. Hollows of the body are inside; where the field of view cuts the body there is no surface.
///
/// # Errors
/// [`Cancelled`] when `cancel` was used.
///
/// # Panics
/// When the labels are of another grid than the scan's.
pub fn depth_below_skin(
    volume: &Volume,
    labels: &LabelVolume,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<DepthField, Cancelled> {
    let steps = Steps::new(progress);
    let depth = depths(volume, labels, &steps, cancel)?;
    steps.report(0.0, 1.0, 1.0);
    Ok(depth)
}

fn depths(
    volume: &Volume,
    labels: &LabelVolume,
    steps: &Steps<'_>,
    cancel: &CancelToken,
) -> Result<DepthField, Cancelled> {
    assert_eq!(volume.dims(), labels.dims(), "labels of another grid");
    DepthField::new(
        labels,
        volume,
        |label| Class::of(label).is_some_and(|class| !class.is_patient()),
        |label| Class::of(label).is_some_and(Class::is_patient),
        cancel,
        &|part| steps.report(0.0, 1.0, part),
    )
}

/// What belongs to what, and what was found.
fn labels_of(
    volume: &Volume,
    steps: &Steps<'_>,
    cancel: &CancelToken,
) -> Result<(LabelVolume, SegmentationReport), Cancelled> {
    let found = if volume.is_hounsfield() {
        ct::labels(volume, steps, cancel)?
    } else if volume.may_be_hounsfield() {
        let found = ct::labels(volume, steps, cancel)?;
        let note = "nothing says what the values are: taken for Hounsfield units".to_owned();
        let notes = found.notes.into_iter().chain([note]).collect();
        Labelled { confidence: 0.9 * found.confidence, notes, ..found }
    } else if volume.modality() == Modality::Mr {
        mr::labels(volume, steps, cancel)?
    } else {
        let kind = if volume.unit().is_empty() { "of no known unit" } else { volume.unit() };
        let note =
            format!("values are {kind}, neither Hounsfield units nor an MR's: everything counts as body");
        Labelled { labels: Vec::new(), confidence: 0.0, notes: vec![note] }
    };
    let Labelled { mut labels, confidence, notes } = found;
    if confidence < LEAST_CONFIDENCE {
        labels.clear();
        labels.resize(volume.voxel_count(), Class::Body.value());
    }
    let table = Class::ALL.map(Class::label).to_vec();
    let labels = LabelVolume::new(volume.dims(), labels, volume.patient_from_voxel(), table)
        .expect("a label for each voxel of a volume");
    // Of no file: found again wherever the scan is.
    let source = LabelSource { numbers: labels.numbers(), ..LabelSource::default() };
    let labels = labels.with_source(source);
    let (counts, voxel_mm3) = (labels.counts(), labels.voxel_mm3());
    let findings = Class::ALL
        .into_iter()
        .map(|class| {
            let voxels = counts[usize::from(class.value())];
            Finding { class, voxels, volume_mm3: voxels as f64 * voxel_mm3 }
        })
        .filter(|finding| finding.voxels > 0)
        .collect();
    Ok((labels, SegmentationReport { findings, confidence, notes }))
}

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
