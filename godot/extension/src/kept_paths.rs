//! Paths of scans as resources keep them.
//!
//! What lies in the project, or in a game's own folder, is found there on other machines, too. What lies elsewhere, and is often
//! called by a patient's name, is no part of a resource that goes with a game: the resource keeps a word for it, which a file
//! beside the project's own explains. Godot exports nothing of folders whose names begin with a dot.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::{fs, io};

use godot::classes::{Os, ProjectSettings};
use godot::prelude::*;

use crate::convert::system_path;

/// The folder in the project, and the file in it that says which word stands for which path.
const FOLDER: &str = ".lumivox";
const FILE: &str = "elsewhere.json";

/// What words for paths begin with.
const ELSEWHERE: &str = "elsewhere:";

/// Of those who write the file, one at a time.
static WRITING: Mutex<()> = Mutex::new(());

/// A path as resources keep it. `None` for a name that is no Unicode.
pub fn kept_path(path: &Path) -> Option<String> {
    let own = own_folders();
    if let Some(inside) = within(path, &own) {
        return Some(inside);
    }
    let name = path.to_str()?;
    // An exported game has no folder of its project: what it saves stays on the machine.
    let project = Path::new(&own[0].1);
    let is_project = project.is_absolute() && project.join("project.godot").is_file();
    Some(if is_project {
        remember(project, name).unwrap_or_else(|_| name.to_owned())
    } else {
        name.to_owned()
    })
}

/// The same for people, who want to know the paths.
pub fn shown_paths<'a>(paths: impl IntoIterator<Item = &'a PathBuf>) -> PackedStringArray {
    let own = own_folders();
    let shown = |path: &PathBuf| within(path, &own).or_else(|| path.to_str().map(str::to_owned));
    paths.into_iter().filter_map(|path| shown(path).as_ref().map(GString::from)).collect()
}

/// The path that the operating system knows of one that was kept. `None` in an exported game for what lay in its project or
/// elsewhere, and on another machine for what lay elsewhere.
pub fn found_path(kept: &str) -> Option<PathBuf> {
    if kept.starts_with(ELSEWHERE) {
        let [(_, project), _] = own_folders();
        return known(Path::new(&project)).remove(kept).map(PathBuf::from);
    }
    let path = system_path(&GString::from(kept));
    path.is_absolute().then_some(path)
}

/// The project's folder and the game's.
fn own_folders() -> [(&'static str, String); 2] {
    [
        ("res://", ProjectSettings::singleton().globalize_path("res://").to_string()),
        ("user://", Os::singleton().get_user_data_dir().to_string()),
    ]
}

fn within(path: &Path, own: &[(&str, String)]) -> Option<String> {
    let inside = |(begin, folder): &(&str, String)| {
        let within = path.strip_prefix(folder).ok().filter(|_| Path::new(folder).is_absolute())?;
        Some(format!("{begin}{}", within.to_str()?))
    };
    let kept = own.iter().find_map(inside)?;
    Some(if cfg!(windows) { kept.replace('\\', "/") } else { kept })
}

/// The word for a path, which the project's file explains from now on.
fn remember(project: &Path, path: &str) -> io::Result<String> {
    let word = format!("{ELSEWHERE}{:016x}", fnv1a(path.as_bytes()));
    let _one_at_a_time = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut known = known(project);
    if known.get(&word).is_some_and(|known| known == path) {
        return Ok(word);
    }
    known.insert(word.clone(), path.to_owned());
    let folder = project.join(FOLDER);
    fs::create_dir_all(&folder)?;
    // It says where files lie on this machine.
    fs::write(folder.join(".gitignore"), "*\n")?;
    let aside = folder.join(format!("{FILE}.{}.part", std::process::id()));
    fs::write(&aside, serde_json::to_string_pretty(&known)?)?;
    fs::rename(&aside, folder.join(FILE))?;
    Ok(word)
}

/// Paths by their words. None where the file is missing, or is none of ours.
fn known(project: &Path) -> BTreeMap<String, String> {
    let text = fs::read_to_string(project.join(FOLDER).join(FILE)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Fowler, Noll and Vo's hash of 64 bits: the same word for a path whenever it is saved.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn what_lies_in_the_project_is_kept_as_its_own() {
        let own = [("res://", "/games/one/".to_owned()), ("user://", "/home/ann/.local/one".to_owned())];
        let kept = |path: &str| within(Path::new(path), &own);
        assert_eq!(kept("/games/one/scans/head").unwrap(), "res://scans/head");
        assert_eq!(kept("/home/ann/.local/one/head.nii").unwrap(), "user://head.nii");
        assert_eq!(kept("/games/one-more/head.nii"), None);
        assert_eq!(within(Path::new("/a/b"), &[("res://", String::new())]), None);
    }

    #[test]
    fn what_lies_elsewhere_is_found_by_its_word_in_the_project_alone() {
        let project = std::env::temp_dir().join(format!("lumivox-kept-{}", std::process::id()));
        fs::create_dir_all(&project).unwrap();
        let [one, other] =
            ["/archive/Doe^Jane", "/archive/head"].map(|path| remember(&project, path).unwrap());
        assert_ne!(one, other);
        assert!(!one.contains("Doe"), "{one}");
        assert_eq!(remember(&project, "/archive/Doe^Jane").unwrap(), one, "the same again");
        assert_eq!(known(&project)[&one], "/archive/Doe^Jane");
        assert_eq!(known(&project)[&other], "/archive/head");
        fs::write(project.join(FOLDER).join(FILE), "not ours").unwrap();
        assert!(known(&project).is_empty());
        fs::remove_dir_all(&project).unwrap();
        assert!(known(&project).is_empty());
    }
}
