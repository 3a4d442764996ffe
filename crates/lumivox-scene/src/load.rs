//! A document's files.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use lumivox_core::{
    CancelToken, Environment,
    document::{Scan, Surroundings},
};
use lumivox_import::{ImportError, ImportOptions, Imported};

use crate::{Audience, Note, OpenErrorKind, Opening, content_of};

/// Loads a scan as it lies in its files.
///
/// # Errors
/// A file that is missing or no scan, and what no option can be.
pub fn load_scan(
    scan: &Scan,
    folder: &Path,
    opening: &Opening,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Imported, OpenErrorKind> {
    let mut options = ImportOptions::of_scan(scan)
        .map_err(|wrong| OpenErrorKind::Wrong(format!("{}: {wrong}", wrong.key)))?;
    options.allow_outside_data = opening.allow_outside_data;
    let files: Vec<PathBuf> = scan.files.iter().map(|file| folder.join(file)).collect();
    let mut imported = audience.watch(|progress| lumivox_import::load(&files, &options, progress, cancel))?;
    if let Some(expected) = &scan.content {
        let content = content_of(&imported.volume);
        if content != *expected {
            audience.note(Note::new(
                "this is not the scan that the scene was saved with, or it is read differently since: look whether the picture \
                 is right, and save the scene again",
            ));
        }
        imported.volume = imported.volume.with_source_changed(|scan| scan.content = Some(content));
    }
    Ok(imported)
}

/// The light of a document, its map read.
///
/// # Errors
/// A file that is missing or no panorama.
pub fn load_environment(surroundings: &Surroundings, folder: &Path) -> Result<Environment, ImportError> {
    let map =
        surroundings.file().map(|file| lumivox_import::load_environment(&folder.join(file))).transpose()?;
    Ok(surroundings.environment(map.map(Arc::new)))
}
