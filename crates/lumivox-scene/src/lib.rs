//! Scene documents and what they name: files become the scene of a document, and a scene becomes a document.
//!
//! The document itself is [`lumivox_core::document`]. Here its files are read ([`load`](load_scan)), the patient alone is kept and
//! what is taken off comes off ([`show()`]), labels and looks are found ([`place()`]); [`open()`] does all of that. Hosts that load
//! scans in ways of their own call the steps.

mod content;
mod labels;
mod load;
mod note;
mod place;
mod save;
mod show;

use std::path::Path;

use lumivox_core::{CancelToken, Environment, PerspectiveCamera, Scene, document::SceneDocument};
use lumivox_import::ImportError;

pub use content::content_of;
pub use labels::{labelling, lie_within, load_labels};
pub use load::{load_environment, load_scan};
pub use note::{Audience, Note, Remedy, Silent};
pub use place::{Part, look, place};
pub use save::save;
pub use show::{Shown, show};

/// What a host allows, whatever a document says.
#[derive(Clone, Copy, Debug, Default)]
pub struct Opening {
    /// Whether headers (`.mhd`, `.nhdr`) may name data files anywhere.
    pub allow_outside_data: bool,
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
    let environment = environment(document, folder)?;
    let mut parts = Vec::with_capacity(document.volumes.len());
    for (index, entry) in document.volumes.iter().enumerate() {
        let loaded = load_scan(&entry.scan, folder, opening, audience, cancel)
            .map_err(|kind| OpenError::of_scan(index, kind))?;
        let from_files = match &entry.labels {
            Some(labels) if !labels.files.is_empty() => {
                let loaded = load_labels(labels, folder, opening, audience, cancel);
                Some(loaded.map_err(|kind| OpenError::of(index, &["labels"], kind))?)
            }
            _ => None,
        };
        let cancelled = |kind| OpenError::of(index, &["scan"], OpenErrorKind::Cancelled(kind));
        let shown = show(entry, loaded.volume, audience, cancel).map_err(cancelled)?;
        parts.push(Part::new(shown, from_files));
    }
    let scene = place(
        &document.volumes,
        parts,
        document.lights.iter().map(|light| light.light()).collect(),
        environment,
        audience,
    )?;
    let camera = document.camera.camera(&scene, document.film.aspect()).ok_or_else(|| {
        OpenError::whole(
            &["camera"],
            OpenErrorKind::Wrong("the camera is the point looked at; move it, or give another target".into()),
        )
    })?;
    Ok(Opened { scene, camera })
}

fn environment(document: &SceneDocument, folder: &Path) -> Result<Environment, OpenError> {
    load_environment(&document.environment, folder)
        .map_err(|error| OpenError::whole(&["environment", "source"], error))
}

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
