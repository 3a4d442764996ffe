//! What nobody saved yet, kept in a file beside the settings: a program that is killed at any moment loses seconds, and the next one
//! asks. Each program that runs has a place of its own, which the system gives free when it ends, however that is.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use lumivox_core::document::SceneDocument;

use crate::files;

/// Seconds between two looks at what changed.
pub const EVERY_SECONDS: f64 = 20.0;
/// Programs beside each other that keep what is unsaved.
const MOST_PLACES: usize = 16;

/// A place for unsaved work.
pub struct Rescue {
    file: PathBuf,
    /// Held while the program runs.
    _place: File,
    written: Option<SceneDocument>,
}

impl Rescue {
    /// The first free place of a folder; `None` where nothing can be kept.
    pub fn in_folder(folder: &Path) -> Option<Self> {
        fs::create_dir_all(folder).ok()?;
        let places = (0..MOST_PLACES).filter_map(|number| {
            let place = File::create(folder.join(format!("unsaved-{number}.lock"))).ok()?;
            place.try_lock().ok()?;
            Some(Self {
                file: folder.join(format!("unsaved-{number}.lumivox")),
                _place: place,
                written: None,
            })
        });
        // What another left comes first.
        let mut free: Vec<Self> = places.collect();
        let with_work = free.iter().position(|place| place.file.exists()).unwrap_or(0);
        (!free.is_empty()).then(|| free.swap_remove(with_work))
    }

    /// What a program left that did not end by itself.
    pub fn left(&self) -> Option<&Path> {
        (self.written.is_none() && self.file.exists()).then_some(self.file.as_path())
    }

    /// Keeps a document, unless it is kept. What cannot be kept is tried again.
    pub fn keep(&mut self, document: &SceneDocument) {
        if self.written.as_ref() == Some(document) {
            return;
        }
        let Ok(text) = document.to_json() else { return };
        if files::save(&self.file, &mut |out| Ok(out.write_all(text.as_bytes())?)).is_ok() {
            self.written = Some(document.clone());
        }
    }

    /// Nothing is unsaved any more.
    pub fn clear(&mut self) {
        // What is not there was removed already.
        let _ = fs::remove_file(&self.file);
        self.written = None;
    }
}
