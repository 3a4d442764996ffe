//! How the command ends: exit codes, and failures that carry one.

use std::{
    fmt, fs,
    path::PathBuf,
    process::ExitCode,
    sync::{Mutex, PoisonError},
};

use lumivox_core::{CancelToken, Cancelled};
use lumivox_import::ImportError;

/// The exit codes other than 0, as `--help` promises them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Something failed that is nobody's input: a full disk, a folder that may not be written.
    Failure = 1,
    /// The command line makes no sense.
    Usage = 2,
    /// A file is missing, damaged or not a scan.
    Input = 3,
    /// There is no usable GPU, or it was lost.
    Gpu = 4,
    /// Stopped by Ctrl-C; what was rendered is kept.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// Why the command ends early.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// What the user reads.
    pub message: String,
}

impl Failure {
    /// A failure with a message.
    pub fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self { exit, message: message.into() }
    }

    /// [`Exit::Failure`].
    pub fn other(message: impl Into<String>) -> Self {
        Self::new(Exit::Failure, message)
    }

    /// [`Exit::Usage`].
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(Exit::Usage, message)
    }

    /// [`Exit::Input`].
    pub fn input(message: impl Into<String>) -> Self {
        Self::new(Exit::Input, message)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.exit {
            Exit::Interrupted => write!(f, "{}", self.message),
            _ => write!(f, "error: {}", self.message),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::new(Exit::Interrupted, "Stopped; nothing was written.")
    }
}

impl From<ImportError> for Failure {
    fn from(error: ImportError) -> Self {
        match error {
            ImportError::Cancelled(cancelled) => cancelled.into(),
            error @ ImportError::UnknownFormat { .. } => {
                Self::input(format!("{error} ('lumivox render --help' shows how to describe it with --raw)"))
            }
            error => Self::input(error.to_string()),
        }
    }
}

/// A token that Ctrl-C (or a polite kill) cancels. The second time ends the process at once.
pub fn cancel_on_ctrl_c() -> Result<CancelToken, Failure> {
    let token = CancelToken::new();
    let cancelled = token.clone();
    ctrlc::set_handler(move || {
        if cancelled.is_cancelled() {
            if let Some(path) = HALF_WRITTEN.lock().unwrap_or_else(PoisonError::into_inner).take() {
                let _ = fs::remove_file(path);
            }
            std::process::exit(Exit::Interrupted as i32);
        }
        cancelled.cancel();
    })
    .map_err(|error| Failure::other(format!("cannot listen for Ctrl-C: {error}")))?;
    Ok(token)
}

/// A file that nobody wants when the process ends while it is written.
static HALF_WRITTEN: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Remembers, or forgets, the file that a second Ctrl-C removes.
pub fn remove_when_killed(path: Option<PathBuf>) {
    *HALF_WRITTEN.lock().unwrap_or_else(PoisonError::into_inner) = path;
}
