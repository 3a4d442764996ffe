//! Where what is made is kept: in the system's files, each whole or not at all.

use std::error::Error;
use std::fs;
use std::io::{BufWriter, Write};
use std::path::Path;

use lumivox_core::Scene;
use lumivox_core::document::SceneDocument;

/// What writes a file's bytes.
pub type Writing<'a> = &'a mut dyn FnMut(&mut dyn Write) -> Result<(), Box<dyn Error>>;

/// Keeps a file; one that is there is replaced only when the new one is whole.
///
/// # Errors
/// A sentence that names the file.
pub fn save(file: &Path, writing: Writing<'_>) -> Result<(), String> {
    let aside = file.with_extension(format!("{}.part", std::process::id()));
    let mut write = || -> Result<(), Box<dyn Error>> {
        let mut out = BufWriter::new(fs::File::create(&aside)?);
        writing(&mut out)?;
        out.flush()?;
        Ok(fs::rename(&aside, file)?)
    };
    write().map_err(|error| {
        let _ = fs::remove_file(&aside);
        format!("cannot write {}: {error}", file.display())
    })
}

/// Keeps a scene.
///
/// # Errors
/// A sentence that names the file.
pub fn save_scene(file: &Path, document: &SceneDocument, scene: &Scene) -> Result<(), String> {
    let told = |why: String| {
        let name = file.display().to_string();
        if why.contains(&name) { why } else { format!("{name}: {why}") }
    };
    lumivox_scene::save_scene(scene.clone(), file, |_| Ok(document.clone())).map_err(told)
}
