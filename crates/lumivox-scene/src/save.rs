//! A scene's document as a file.

use std::{
    fs, io,
    path::{Component, Path, PathBuf},
};

use lumivox_core::document::SceneDocument;

/// Writes a document; absolute paths in it become relative to its folder where both lie below one folder that is no root. A
/// file that is there is replaced only when the new one is whole.
///
/// # Errors
/// When the file cannot be written.
pub fn save(document: &SceneDocument, file: &Path) -> io::Result<()> {
    let file = std::path::absolute(file)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut document = document.clone();
    for entry in &mut document.volumes {
        entry.scan.files.iter_mut().for_each(|path| *path = seen_from(folder, path));
        if let Some(labels) = &mut entry.labels {
            labels.files.iter_mut().chain(&mut labels.table).for_each(|path| *path = seen_from(folder, path));
        }
    }
    if let Some(map) = document.environment.file().map(|map| seen_from(folder, map)) {
        document.environment.source = map;
    }
    let aside = file.with_extension(format!("{}.part", std::process::id()));
    let text = document.to_json().map_err(|_| {
        let why = "the name of one of its files is no Unicode, which scenes need; rename the file";
        io::Error::new(io::ErrorKind::InvalidData, why)
    })?;
    fs::write(&aside, text).and_then(|()| fs::rename(&aside, &file)).inspect_err(|_| {
        let _ = fs::remove_file(&aside);
    })
}

/// A path as seen from a folder, with `/` between names.
fn seen_from(folder: &Path, path: &Path) -> PathBuf {
    if !path.is_absolute() {
        return path.to_owned();
    }
    let names = |path: &Path| path.components().map(|c| c.as_os_str().to_owned()).collect::<Vec<_>>();
    let is_root = |c: &Component<'_>| matches!(c, Component::Prefix(_) | Component::RootDir);
    let (own, other) = (names(folder), names(path));
    let shared = own.iter().zip(&other).take_while(|(a, b)| a == b).count();
    if shared <= folder.components().take_while(is_root).count() {
        return path.to_owned();
    }
    let up = std::iter::repeat_n("..".into(), own.len() - shared);
    let seen: PathBuf = up.chain(other[shared..].iter().cloned()).collect();
    if cfg!(windows) { seen.to_string_lossy().replace('\\', "/").into() } else { seen }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn paths_are_seen_from_the_documents_folder() {
        let seen = |path: &str| seen_from(Path::new("/home/ann/scenes"), Path::new(path));
        assert_eq!(seen("/home/ann/scenes/a/head.nii"), Path::new("a/head.nii"));
        assert_eq!(seen("/home/ann/scans/head"), Path::new("../scans/head"));
        assert_eq!(seen("/data/head"), Path::new("/data/head"), "nothing is shared but the root");
        assert_eq!(seen("scans/head"), Path::new("scans/head"));
    }
}
