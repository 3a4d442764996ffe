//! What people without a compiler install, made of the tree: `cargo xtask package`.
//!
//! `parts.rs` says what there is, `build.rs` builds it for old systems, `works.rs` whose works are in it, `archive.rs` packs it so that
//! the same files make the same bytes.

pub mod archive;
mod binaries;
mod build;
mod command;
mod crates;
mod debian;
mod godot;
mod options;
mod parts;
mod python;
mod sbom;
mod studio;
mod unity;
mod works;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

pub use archive::below;
pub use options::Options;
use parts::own_licenses;
pub use parts::{Part, make};
pub use unity::unity;

/// The version of all that is made.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The date of what has none: the first of 2020.
const NO_DATE: u64 = 1_577_836_800;

/// A text that says VERSION where it means it.
fn filled(text: &str) -> String {
    text.replace("VERSION", VERSION)
}

/// The date that archives give their files, in seconds after 1970: `SOURCE_DATE_EPOCH`, or the commit's.
fn date(root: &Path) -> Result<u64, String> {
    if let Some(said) = std::env::var_os("SOURCE_DATE_EPOCH") {
        let number = said.to_str().and_then(|said| said.parse().ok());
        return number.ok_or_else(|| {
            format!("SOURCE_DATE_EPOCH is {said:?}, and must be seconds after the start of 1970")
        });
    }
    let output = Command::new("git").args(["log", "-1", "--format=%ct"]).current_dir(root).output();
    let said = output.ok().filter(|output| output.status.success());
    Ok(said.and_then(|output| String::from_utf8_lossy(&output.stdout).trim().parse().ok()).unwrap_or(NO_DATE))
}

/// Where Cargo builds.
fn target_folder(root: &Path) -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) => root.join(folder),
        None => root.join("target"),
    }
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()))
}

/// Makes a folder anew, without what was in it.
fn make_empty(folder: &Path) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(failed)?;
    }
    fs::create_dir_all(folder).map_err(failed)
}

fn run(command: &mut Command) -> Result<(), String> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{command:?}: {status}")),
        Err(error) => Err(format!("{command:?}: {error}")),
    }
}
