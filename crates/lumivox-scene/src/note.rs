//! What is told while a scene is opened.

use std::sync::{Mutex, PoisonError};

use lumivox_core::Progress;
use lumivox_core::document::Written;

/// Something worth telling about a scan.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// A sentence.
    pub text: String,
    /// What would change it, which each host has its own words for.
    pub remedy: Option<Remedy>,
    /// Where it says that a scan is [another](crate::is_another) than the one that the scene was saved with: whose, by the
    /// number of the document's volume.
    pub another: Option<usize>,
}

/// What would change what a note tells.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remedy {
    /// To keep everything that was scanned.
    KeepEverything,
    /// A density.
    Density(f64),
    /// A preset of the label's own.
    LabelPreset,
}

impl Note {
    /// A sentence.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), remedy: None, another: None }
    }

    /// With what would change it.
    #[must_use]
    pub fn with(mut self, remedy: Remedy) -> Self {
        self.remedy = Some(remedy);
        self
    }
}

/// Who waits for a scene.
pub trait Audience {
    /// Hears something worth telling.
    fn note(&self, note: Note);

    /// Hears what is done, which changes nothing.
    fn say(&self, line: &str);

    /// Watches work that takes long.
    fn watch<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T;
}

/// Nobody listens.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Audience for Silent {
    fn note(&self, _: Note) {}

    fn say(&self, _: &str) {}

    fn watch<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T {
        work(Progress::SILENT)
    }
}

/// Keeps what is told as sentences, for hosts that show them afterwards.
pub struct Notes<'a> {
    progress: Progress<'a>,
    words: fn(Remedy) -> Option<String>,
    written: Option<&'a Written>,
    told: Mutex<Vec<String>>,
}

impl<'a> Notes<'a> {
    /// `words` are what the host says of a remedy, behind the note; `None` where the note is not worth telling there.
    pub fn new(progress: Progress<'a>, words: fn(Remedy) -> Option<String>) -> Self {
        Self { progress, words, written: None, told: Mutex::default() }
    }

    /// Where a scan is another, it is told with the document's line.
    #[must_use]
    pub fn with_lines(mut self, written: &'a Written) -> Self {
        self.written = Some(written);
        self
    }

    /// What was told.
    pub fn into_sentences(self) -> Vec<String> {
        self.told.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Audience for Notes<'_> {
    fn note(&self, note: Note) {
        let words = note.remedy.map_or_else(|| Some(String::new()), self.words);
        if let Some(words) = words {
            let place = match (note.another, self.written) {
                (Some(index), Some(written)) => {
                    written.place(&["volumes".into(), index.into(), "scan".into()]) + ": "
                }
                _ => String::new(),
            };
            self.told.lock().unwrap_or_else(PoisonError::into_inner).push(place + &note.text + &words);
        }
    }

    fn say(&self, _: &str) {}

    fn watch<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T {
        work(self.progress)
    }
}
