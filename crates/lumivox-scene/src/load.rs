//! A document's files.

use std::{
    path::{Component, Path, PathBuf},
    sync::Arc,
};

use lumivox_core::{
    CancelToken, Environment, Volume,
    document::{Scan, Surroundings},
};
use lumivox_import::{ImportError, ImportOptions, Imported, files::canonicalize};

use crate::{Audience, Note, OpenErrorKind, Opening, identified, is_another};

/// What is said of a scan whose content is not that of the document.
pub const ANOTHER_SCAN: &str = "this is not the scan that the scene was saved with, or it is read differently since: look \
                                whether the picture is right, and save the scene again";

/// Loads a scan as it lies in its files.
///
/// # Errors
/// A file that is missing or no scan, and what no option can be.
pub fn load(
    index: usize,
    scan: &Scan,
    folder: &Path,
    opening: &Opening,
    audience: &impl Audience,
    cancel: &CancelToken,
) -> Result<Imported, OpenErrorKind> {
    let mut options = ImportOptions::of_scan(scan)
        .map_err(|wrong| OpenErrorKind::Wrong(format!("{}: {wrong}", wrong.key)))?;
    options.allow_outside_data = opening.allow_outside_data;
    let files: Vec<PathBuf> = scan.files.iter().map(|file| within(folder, file)).collect();
    let mut imported = audience.watch(|progress| lumivox_import::load(&files, &options, progress, cancel))?;
    if opening.identify || scan.content.is_some() {
        imported.volume = identified(imported.volume);
        say_if_another(index, scan, &imported.volume, audience);
    }
    Ok(imported)
}

/// Says where a volume is another scan than the one that a document was saved with.
pub fn say_if_another(index: usize, scan: &Scan, volume: &Volume, audience: &impl Audience) {
    if is_another(scan, volume) {
        let file = scan.files.first().map_or_else(String::new, |file| format!("{}: ", file.display()));
        audience.note(Note { another: Some(index), ..Note::new(file + ANOTHER_SCAN) });
    }
}

/// A file as seen from a folder, without steps back where nothing but they is left out: a link may lead elsewhere.
pub fn within(folder: &Path, file: &Path) -> PathBuf {
    let path = folder.join(file);
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir if matches!(plain.components().next_back(), Some(Component::Normal(_))) => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    match (canonicalize(&path), canonicalize(&plain)) {
        (Ok(one), Ok(other)) if one == other => plain,
        _ => path,
    }
}

/// The light of a document, its map read.
///
/// # Errors
/// A file that is missing or no panorama.
pub fn load_environment(surroundings: &Surroundings, folder: &Path) -> Result<Environment, ImportError> {
    let map = surroundings
        .file()
        .map(|file| lumivox_import::load_environment(&within(folder, file)))
        .transpose()?;
    Ok(surroundings.environment(map.map(Arc::new)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn steps_back_are_left_out_where_they_lead_to_the_same_file() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("scenes/day");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(root.path().join("scenes/head.nii"), b"").unwrap();
        let head = Path::new("../head.nii");
        assert_eq!(within(&folder, head), root.path().join("scenes/head.nii"));
        assert_eq!(within(&folder, Path::new("../none.nii")), folder.join("../none.nii"), "as it was said");
        // A step back from a link does not lead to where the link is.
        std::os::unix::fs::symlink(&folder, root.path().join("link")).unwrap();
        assert_eq!(within(&root.path().join("link"), head), root.path().join("link/../head.nii"));
    }
}
