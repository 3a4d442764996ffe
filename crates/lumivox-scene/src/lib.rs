//! Scene documents and what they name: files become the scene of a document, and a scene becomes a document.
//!
//! The document itself is [`lumivox_core::document`]. [`open()`] reads its files, keeps the patient alone, takes off what is to come
//! off, and places all with its labels and looks; [`open_loaded`] does that with scans that a host loaded in a way of its own, and
//! [`assemble`] with what is handed over as it is shown.

mod content;
mod labels;
mod load;
mod note;
mod place;
mod read;
mod save;
mod scans;
mod show;

use std::{path::Path, sync::Arc};

use lumivox_core::{
    CancelToken, EnvironmentMap, Misplaced, PerspectiveCamera, Scene, Volume,
    document::{Entry, Lighting, SceneDocument, Step, Written},
};
use lumivox_import::ImportError;

pub use content::{content_of, identified, is_another};
pub use load::ANOTHER_SCAN;
pub use note::{Audience, Note, Notes, Remedy, Silent};
pub use place::Part;
pub use read::{ReadError, read};
pub use save::{save, save_scene};
pub use scans::{Loaded, load_scans};

use labels::LabelMaps;
use load::load_environment;
use place::{place, say_if_unseen};
use scans::Shows;
use show::show;

/// What a host allows, whatever a document says.
#[derive(Clone, Copy, Debug, Default)]
pub struct Opening {
    /// Whether headers (`.mhd`, `.nhdr`) may name data files anywhere.
    pub allow_outside_data: bool,
    /// Whether scans are told by their [content](content_of) even where the document does not say it: for hosts that save what
    /// they open. It takes the time of a hash, a fraction of a second for the largest scans.
    pub identify: bool,
}

/// A document's scene.
#[derive(Debug)]
pub struct Opened {
    /// What there is to see.
    pub scene: Scene,
    /// From where.
    pub camera: PerspectiveCamera,
}

/// Why a scene could not be opened, and the part of its document that says so.
#[derive(Debug, thiserror::Error)]
#[error("{kind}")]
pub struct OpenError {
    /// Of which volume, from 0; the whole document, if none.
    pub volume: Option<usize>,
    /// The keys that lead to the part, within the volume or the document.
    pub keys: &'static [&'static str],
    /// What is wrong.
    #[source]
    pub kind: OpenErrorKind,
}

/// What is wrong.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenErrorKind {
    /// A file is missing, damaged, or not what it should be.
    #[error(transparent)]
    Import(Box<ImportError>),
    /// A part says nothing that could be done.
    #[error("{0}")]
    Wrong(String),
    /// A style is for a label that there is not.
    #[error("label {label}: there is no such label; there are {known} and *")]
    NoSuchLabel {
        /// Which of the styles it is, from 0.
        style: usize,
        /// As it was named.
        label: String,
        /// The names that there are, with commas between them.
        known: String,
    },
    /// No label of the files lies in the scan.
    #[error("{file}: {why}")]
    LabelsElsewhere {
        /// The first of them.
        file: String,
        /// What that means, and what to do.
        why: String,
    },
    /// The camera is the point looked at.
    #[error("the camera is the point looked at; move it, or give another target")]
    NoView,
    /// It was cancelled.
    #[error(transparent)]
    Cancelled(#[from] lumivox_core::Cancelled),
}

impl From<ImportError> for OpenErrorKind {
    fn from(error: ImportError) -> Self {
        Self::Import(Box::new(error))
    }
}

impl OpenError {
    /// `scene.json, line 12, column 9`: where the document says what is wrong.
    pub fn place(&self, written: &Written) -> String {
        let volume = self.volume.iter().flat_map(|volume| [Step::from("volumes"), Step::from(*volume)]);
        let keys = self.keys.iter().map(|key| Step::from(*key));
        let style = match self.kind {
            OpenErrorKind::NoSuchLabel { style, .. } => vec![style.into(), "label".into()],
            _ => vec![],
        };
        written.place(&volume.chain(keys).chain(style).collect::<Vec<_>>())
    }

    /// Of a volume's part.
    pub fn of(volume: usize, keys: &'static [&'static str], kind: impl Into<OpenErrorKind>) -> Self {
        Self { volume: Some(volume), keys, kind: kind.into() }
    }

    /// Of a volume's scan that was not loaded.
    pub fn of_scan(volume: usize, kind: OpenErrorKind) -> Self {
        let keys: &[&str] =
            if matches!(kind, OpenErrorKind::Wrong(_)) { &["scan"] } else { &["scan", "files"] };
        Self { volume: Some(volume), keys, kind }
    }

    /// Of a part of the document.
    pub fn whole(keys: &'static [&'static str], kind: impl Into<OpenErrorKind>) -> Self {
        Self { volume: None, keys, kind: kind.into() }
    }
}

/// Opens a document, whose relative paths are seen from `folder`.
///
/// # Errors
/// [`OpenError`] names the part of the document.
pub fn open(
    document: &SceneDocument,
    folder: &Path,
    opening: &Opening,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Opened, OpenError> {
    let scans = load_scans(document, folder, opening, audience, cancel)?;
    let told = scans.iter().filter(|scan| !scan.is_shared);
    told.flat_map(|scan| &scan.report.notes).for_each(|note| audience.note(Note::new(note)));
    let scans = scans.into_iter().map(|scan| scan.volume).collect();
    open_loaded(document, scans, folder, opening, audience, cancel)
}

/// Opens a document whose scans are loaded: what of them is shown, labels, light, places and looks. Of entries that share a scan
/// and show the same of it, that is found once, and they share it.
///
/// # Errors
/// [`OpenError`] names the part of the document.
pub fn open_loaded(
    document: &SceneDocument,
    scans: Vec<Arc<Volume>>,
    folder: &Path,
    opening: &Opening,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Opened, OpenError> {
    let environment = load_environment(&document.environment, folder)
        .map_err(|error| OpenError::whole(&["environment", "source"], error))?;
    let is_alone = scans.len() == 1;
    let mut maps = LabelMaps::default();
    let shows: Vec<Shows> =
        document.volumes.iter().zip(&scans).map(|(entry, scan)| Shows::of(entry, scan)).collect();
    let first = |index: usize| shows.iter().position(|shown| *shown == shows[index]).unwrap_or(index);
    // The last one that shows something else of a scan takes its voxels as they are, and those before copies.
    let mut scans: Vec<Option<Arc<Volume>>> =
        scans.into_iter().enumerate().map(|(index, scan)| (first(index) == index).then_some(scan)).collect();
    let mut all_shown: Vec<Part> = Vec::with_capacity(scans.len());
    let mut parts = Vec::with_capacity(scans.len());
    for (index, entry) in document.volumes.iter().enumerate() {
        let of_labels = |kind| OpenError::of(index, &["labels", "files"], kind);
        let labels = match &entry.labels {
            Some(labels) if !labels.files.is_empty() => {
                Some(maps.load(labels, folder, opening, audience, cancel).map_err(of_labels)?)
            }
            _ => None,
        };
        let cancelled = |kind| OpenError::of(index, &["scan"], OpenErrorKind::Cancelled(kind));
        let shown = match scans[index].take() {
            Some(scan) => {
                let scan = Arc::try_unwrap(scan).unwrap_or_else(|shared| Volume::clone(&shared));
                Part::new(show(entry, scan, audience, cancel).map_err(cancelled)?)
            }
            None => all_shown[first(index)].clone(),
        };
        if let (Some(map), Some(named)) = (&labels, &entry.labels) {
            match map.misplaced(&shown.volume) {
                Some(Misplaced { all: true, why }) if is_alone => {
                    let file = named.files[0].display().to_string();
                    return Err(of_labels(OpenErrorKind::LabelsElsewhere { file, why }));
                }
                // They may be another scan's.
                Some(Misplaced { why, .. }) => audience.note(Note::new(why)),
                None => {}
            }
        }
        all_shown.push(shown.clone());
        let part = match labels {
            Some(_) => Part { labels, ..shown },
            None => shown,
        };
        parts.push(cut_part(index, entry, part, audience, cancel)?);
    }
    let lights = document.lights.iter().map(Lighting::light).collect();
    let scene = place(&document.volumes, parts, lights, environment, audience)?;
    for (entry, instance) in document.volumes.iter().zip(&scene.volumes) {
        let styles = entry.labels.as_ref().map_or(&[][..], |labels| &labels.styles);
        say_if_unseen(instance, styles, audience);
    }
    let camera = document.camera.camera(&scene, document.film.aspect());
    let camera = camera.ok_or_else(|| OpenError::whole(&["camera"], OpenErrorKind::NoView))?;
    Ok(Opened { scene, camera })
}

fn cut_part(
    index: usize,
    entry: &Entry,
    part: Part,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Part, OpenError> {
    let labels = labels::cut(entry, &part.volume, part.labels.as_ref(), audience, cancel);
    let labels = labels.map_err(|kind| OpenError::of(index, &["lassos"], kind))?;
    Ok(Part { labels, ..part })
}

/// The scene of a document of which all is there as it is shown, but for what lassos cut away now.
///
/// # Errors
/// [`OpenError`] as [`assemble`], and where lassos cannot cut.
pub fn cut_anew(
    document: &SceneDocument,
    parts: Vec<Part>,
    map: Option<Arc<EnvironmentMap>>,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Scene, OpenError> {
    let entries = document.volumes.iter().enumerate().zip(parts);
    let cut = entries.map(|((index, entry), part)| cut_part(index, entry, part, audience, cancel));
    assemble(document, cut.collect::<Result<_, _>>()?, map)
}

/// The scene of a document that is handed over with all that is in it: what it names is not looked for.
///
/// # Errors
/// [`OpenError`] for styles of labels that there are not.
pub fn assemble(
    document: &SceneDocument,
    parts: Vec<Part>,
    map: Option<Arc<EnvironmentMap>>,
) -> Result<Scene, OpenError> {
    let lights = document.lights.iter().map(Lighting::light).collect();
    place(&document.volumes, parts, lights, document.environment.environment(map), &Silent)
}

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
