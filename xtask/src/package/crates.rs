//! The libraries as crates.io takes them, together.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::{VERSION, run, target_folder};
use crate::layers;

/// Packs them, not built again from there; returns their names, after the folder.
pub fn make(root: &Path, out: &Path) -> Result<Vec<String>, String> {
    let folder = out.join("crates");
    super::make_empty(&folder)?;
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["package", "--quiet", "--no-verify", "--allow-dirty", "--offline"]).current_dir(root);
    run(cargo.args(layers::LIBRARIES.iter().flat_map(|name| ["--package", name])))?;
    let mut names = vec![];
    for library in layers::LIBRARIES {
        let name = format!("{library}-{VERSION}.crate");
        let from = target_folder(root).join("package").join(&name);
        fs::copy(&from, folder.join(&name)).map_err(|error| format!("{}: {error}", from.display()))?;
        names.push(format!("crates/{name}"));
    }
    Ok(names)
}
