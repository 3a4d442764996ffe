//! A scene file's contents, loaded on any thread.

use std::path::Path;
use std::sync::Arc;

use lumivox_core::document::SceneDocument;
use lumivox_core::{CancelToken, Progress, words};
use lumivox_import::ImportReport;
use lumivox_scene::{Audience, Note, Notes, OpenError, Opened, Opening, Remedy};

/// What a scene file holds, with its scans.
pub struct OpenedScene {
    /// The document; the map of its light is named wherever it lies.
    pub document: SceneDocument,
    /// Its scene and its camera.
    pub opened: Opened,
    /// How each scan was loaded.
    pub reports: Vec<Arc<ImportReport>>,
    /// What is worth telling, as sentences.
    pub notes: Vec<String>,
}

/// What would change what a note tells, in the words of nodes.
fn remedy(remedy: Remedy) -> Option<String> {
    match remedy {
        // What is hidden is no warning, as of scans that are loaded.
        Remedy::KeepEverything => None,
        Remedy::Density(density) => Some(format!("; a 'Density' of {} is a body's", words::number(density))),
        Remedy::LabelPreset => Some("; give the label a transfer function of its own".to_owned()),
        _ => Some(String::new()),
    }
}

/// Loads a scene file and all that it names. `allow_outside_data`: headers may name data files anywhere.
///
/// # Errors
/// A sentence that names the file, the line and what is wrong.
pub fn open(
    path: &Path,
    allow_outside_data: bool,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<OpenedScene, String> {
    let written = lumivox_scene::read(path).map_err(|error| error.to_string())?;
    let failure = |error: OpenError| format!("{}: {}", error.place(&written), error.kind);
    let (folder, opening) = (written.folder(), Opening { allow_outside_data, identify: true });
    let listener = Notes::new(progress, remedy);
    let loaded = lumivox_scene::load_scans(&written.document, folder, &opening, &listener, cancel);
    let loaded = loaded.map_err(failure)?;
    let told = loaded.iter().filter(|scan| !scan.is_shared);
    told.flat_map(|scan| &scan.report.notes).for_each(|note| listener.note(Note::new(note)));
    let (scans, reports) = loaded.into_iter().map(|scan| (scan.volume, scan.report)).unzip();
    let opened = lumivox_scene::open_loaded(&written.document, scans, folder, &opening, &listener, cancel);
    let opened = opened.map_err(failure)?;
    let mut document = written.document.clone();
    if let Some(map) = opened.scene.environment.file() {
        document.environment.source = map.to_owned();
    }
    Ok(OpenedScene { document, opened, reports, notes: listener.into_sentences() })
}
