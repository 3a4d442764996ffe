//! Long work that shows how far it is and can be stopped.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Asks work on other threads to stop. Clones share one flag.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

/// The work was stopped through its [`CancelToken`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

impl CancelToken {
    /// A token nobody has cancelled yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the work to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// [`Cancelled`] once the work was asked to stop, for use with `?`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// What long work is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub enum WorkStage {
    /// Looking through files and reading their headers.
    Scanning,
    /// Decoding slices or blocks of voxels.
    Decoding,
    /// Computing voxels.
    Generating,
    /// Telling apart what a scan shows.
    Segmenting,
    /// Cutting away what lassos enclose.
    Cutting,
    /// Writing files.
    Writing,
    /// Fetching images from another machine.
    Receiving,
}

impl WorkStage {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Scanning,
        Self::Decoding,
        Self::Generating,
        Self::Segmenting,
        Self::Cutting,
        Self::Writing,
        Self::Receiving,
    ];

    /// What a progress bar says.
    pub fn label(self) -> &'static str {
        match self {
            WorkStage::Scanning => "reading headers",
            WorkStage::Decoding => "decoding slices",
            WorkStage::Generating => "growing the phantom",
            WorkStage::Segmenting => "finding the patient",
            WorkStage::Cutting => "cutting",
            WorkStage::Writing => "writing slices",
            WorkStage::Receiving => "receiving images",
        }
    }
}

/// Receives `(stage, done, total)`, from any thread, `done` not always rising. Cheap to call.
#[derive(Clone, Copy)]
pub struct Progress<'a>(Option<&'a (dyn Fn(WorkStage, u64, u64) + Sync)>);

impl<'a> Progress<'a> {
    /// Tells nobody.
    pub const SILENT: Progress<'static> = Progress(None);

    /// Tells `callback`.
    pub fn new(callback: &'a (dyn Fn(WorkStage, u64, u64) + Sync)) -> Self {
        Self(Some(callback))
    }

    /// Reports that `done` of `total` steps of `stage` are finished.
    pub fn report(&self, stage: WorkStage, done: u64, total: u64) {
        if let Some(callback) = self.0 {
            callback(stage, done, total);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hosts make a table of them.
    #[test]
    fn all_stages_are_all() {
        // Whatever reads one says which there are.
        let why = serde_json::from_str::<WorkStage>("\"none\"").unwrap_err().to_string();
        let (_, names) = why.split_once("expected one of ").expect("a list of names");
        let known = names.split('`').skip(1).step_by(2);
        let listed = WorkStage::ALL.map(|stage| format!("{stage:?}"));
        assert_eq!(known.collect::<Vec<_>>(), listed);
    }
}
