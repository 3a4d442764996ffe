//! A scene's document as a file.

use std::{
    fs, io,
    path::{Component, Path, PathBuf},
    sync::Arc,
};

use lumivox_core::{EnvironmentMap, EnvironmentSource, Scene, document::SceneDocument};
use lumivox_import::save_environment;

use crate::read::followed;

/// Saves a scene as the document that `describe` makes of it. A map of light that came from no file is written beside it, as
/// `NAME.sky.exr`, to the bit.
///
/// # Errors
/// A sentence: what `describe` says, what no reader would take, or what cannot be written. Then no file is left that was not
/// there.
pub fn save_scene(
    mut scene: Scene,
    file: &Path,
    describe: impl FnOnce(&Scene) -> Result<SceneDocument, String>,
) -> Result<(), String> {
    let unwritten = |error: io::Error| format!("cannot write {}: {error}", file.display());
    let map = nameless_map(&scene);
    let beside = std::path::absolute(file.with_extension("sky.exr")).map_err(unwritten)?;
    if let Some(map) = &map {
        scene.environment.source = EnvironmentSource::Map(Arc::new(map.clone().with_file(&beside)));
    }
    let document = describe(&scene)?;
    // Whoever opens it would say so: better now.
    let text = document.to_json().map_err(|_| NO_UNICODE)?;
    SceneDocument::parse(&text).map_err(|error| format!("it cannot be saved: {}", error.why))?;
    let was_there = beside.exists();
    if let Some(map) = &map {
        save_environment(&beside, map).map_err(|error| error.to_string())?;
    }
    save(&document, file).map_err(|error| {
        if map.is_some() && !was_there {
            let _ = fs::remove_file(&beside);
        }
        unwritten(error)
    })
}

/// The light's map, if it is of no file; as wide as readers want it.
fn nameless_map(scene: &Scene) -> Option<EnvironmentMap> {
    let EnvironmentSource::Map(map) = &scene.environment.source else { return None };
    if map.file().is_some() {
        return None;
    }
    if map.width == 2 * map.height {
        return Some((**map).clone());
    }
    let height = map.height.max(map.width / 2).max(1);
    Some(EnvironmentMap::from_fn(2 * height, height, |direction| map.radiance(direction)))
}

const NO_UNICODE: &str = "the name of one of its files is no Unicode, which scenes need; rename the file";

/// Writes a document; absolute paths in it become relative to its folder where both lie below one folder that is no root. A
/// file that is there is replaced only when the new one is whole; of a link, the one that it leads to.
///
/// # Errors
/// When the file cannot be written.
pub fn save(document: &SceneDocument, file: &Path) -> io::Result<()> {
    let file = std::path::absolute(followed(file))?;
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
    let text = document.to_json().map_err(|_| io::Error::new(io::ErrorKind::InvalidData, NO_UNICODE))?;
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
    let mut seen: PathBuf = up.chain(other[shared..].iter().cloned()).collect();
    if seen.as_os_str().is_empty() {
        seen.push(".");
    }
    if cfg!(windows) { seen.to_string_lossy().replace('\\', "/").into() } else { seen }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumivox_core::{Environment, document::Surroundings};

    #[test]
    fn a_sky_of_no_file_is_written_beside_the_scene_and_does_not_outlast_it() {
        let folder = tempfile::tempdir().unwrap();
        let texels = (0..6).map(|i| [0.1 * i as f32, 1.0, 3e4]).collect();
        let map = Arc::new(EnvironmentMap::new(3, 2, texels).unwrap());
        let environment = Environment { source: EnvironmentSource::Map(map), ..Environment::uniform(1.0) };
        let scene = Scene { environment, ..Scene::default() };
        let describe = |scene: &Scene| SceneDocument::of(scene).map_err(|error| error.to_string());
        let there = || fs::read_dir(folder.path()).unwrap().count();
        let file = folder.path().join("view.lumivox");
        assert_eq!(save_scene(scene.clone(), &file, |_| Err("no".into())).unwrap_err(), "no");
        let wrong = |scene: &Scene| {
            let environment =
                Surroundings { strength: -1.0, ..Surroundings::of(&scene.environment).unwrap() };
            Ok(SceneDocument { environment, ..SceneDocument::default() })
        };
        assert!(save_scene(scene.clone(), &file, wrong).unwrap_err().starts_with("it cannot be saved: "));
        fs::create_dir(&file).unwrap();
        assert!(save_scene(scene.clone(), &file, describe).unwrap_err().starts_with("cannot write "));
        assert_eq!(there(), 1, "the folder in its place alone");
        fs::remove_dir(&file).unwrap();
        save_scene(scene, &file, describe).unwrap();
        assert_eq!(there(), 2);
        let text = fs::read_to_string(&file).unwrap();
        assert!(text.contains("\"view.sky.exr\""), "{text}");
        let written = lumivox_import::load_environment(&folder.path().join("view.sky.exr")).unwrap();
        assert_eq!((written.width, written.height), (4, 2), "twice as wide as high");
    }

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
