//! Where what is made is kept: the browser's downloads.

use std::error::Error;
use std::io::Write;
use std::path::Path;

use js_sys::Uint8Array;
use lumivox_core::Scene;
use lumivox_core::document::SceneDocument;

/// What writes a file's bytes.
pub type Writing<'a> = &'a mut dyn FnMut(&mut dyn Write) -> Result<(), Box<dyn Error>>;

/// Gives somebody a file.
///
/// # Errors
/// A sentence that names the file.
pub fn save(file: &Path, writing: Writing<'_>) -> Result<(), String> {
    let mut bytes = vec![];
    writing(&mut bytes).map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    crate::web::with_page(|page| page.save(&name, &Uint8Array::from(&bytes[..])));
    Ok(())
}

/// Gives somebody a scene's file. It names its scan's files as they are called: whoever opens it gives both.
///
/// # Errors
/// A sentence that names the file.
pub fn save_scene(file: &Path, document: &SceneDocument, _: &Scene) -> Result<(), String> {
    let unsaved = |why: &dyn std::fmt::Display| format!("{}: it cannot be saved: {why}", file.display());
    let mut document = document.clone();
    crate::web::with_arrivals(|all| all.name(&mut document)).map_err(|why| unsaved(&why))?;
    let text = document.to_json().map_err(|error| unsaved(&error))?;
    // Whoever opens it would say so: better now.
    SceneDocument::parse(&text).map_err(|error| unsaved(&error.why))?;
    save(file, &mut |out| Ok(out.write_all(text.as_bytes())?))
}
