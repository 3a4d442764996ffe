//! Scenes as every host wrote them: `scenes/HOST.lumivox`, of a head that tests make beside them.
//!
//! The suites of hosts run on their own. So each holds that its host still writes its file, and opens the files of all: that
//! is every pair, whatever runs first. The suites of Python and Unity read the same folder.

use std::fs;
use std::path::{Path, PathBuf};

/// All of them. `command` is the scene that the others opened, and changed in ways of their own.
pub const HOSTS: [&str; 5] = ["command", "window", "python", "godot", "unity"];

/// What the scenes call their scan: a head, whose voxels are [`SCAN_SIZE`] along each side.
pub const SCAN: &str = "scan";
/// See [`SCAN`].
pub const SCAN_SIZE: usize = 32;

/// Set this variable to have what hosts write today kept, in place of what they wrote. Look at it before committing.
pub const UPDATE_SWITCH: &str = "LUMIVOX_UPDATE";

/// The scene that a host wrote.
pub fn scene(host: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{host}.lumivox"))
}

/// Puts all scenes into a folder, where their scan is or will be.
///
/// # Panics
/// When they cannot be written there.
pub fn copy_scenes(folder: &Path) {
    for host in HOSTS {
        let (from, to) = (scene(host), folder.join(format!("{host}.lumivox")));
        fs::copy(&from, &to)
            .unwrap_or_else(|error| panic!("{} to {}: {error}", from.display(), to.display()));
    }
}

/// Holds that a host wrote what it wrote before; under [`UPDATE_SWITCH`] keeps it instead.
///
/// # Panics
/// When it wrote something else, or nothing.
pub fn assert_written(host: &str, file: &Path) {
    let kept = scene(host);
    let read =
        |path: &Path| fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let text = read(file);
    if std::env::var_os(UPDATE_SWITCH).is_some() {
        fs::write(&kept, text).unwrap_or_else(|error| panic!("{}: {error}", kept.display()));
        return;
    }
    let wanted = read(&kept);
    let differing = wanted.lines().zip(text.lines()).enumerate().find(|(_, (wanted, got))| wanted != got);
    let line = differing.map_or(wanted.lines().count().min(text.lines().count()), |(line, _)| line) + 1;
    assert!(
        text == wanted,
        "{} is not {} from line {line} on: {differing:?}. To keep it, run again with {UPDATE_SWITCH}=1",
        file.display(),
        kept.display()
    );
}
