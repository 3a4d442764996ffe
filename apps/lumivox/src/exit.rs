//! How the command ends: exit codes, and failures that carry one.

use std::{
    fmt, fs,
    path::PathBuf,
    process::ExitCode,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use lumivox_core::{CancelToken, Cancelled};
use lumivox_import::ImportError;

use crate::progress::{self, Reporter};

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

/// What another Ctrl-C, or polite kill, asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
    /// What the one before asked for: `timeout` sends two at once, and keys bounce.
    Same,
    /// To stop.
    Stop,
    /// To end, where something is still being kept: it is asked again.
    Hurry,
    /// To end at once.
    End,
}

/// What was asked for so far.
#[derive(Debug, Default)]
struct Wishes {
    count: u32,
    last: Option<Instant>,
}

impl Wishes {
    /// Signals closer than that are one wish.
    const APART: Duration = Duration::from_millis(300);

    fn next(&mut self, now: Instant, is_keeping: bool) -> Wish {
        if self.last.is_some_and(|last| now.saturating_duration_since(last) < Self::APART) {
            return Wish::Same;
        }
        self.last = Some(now);
        self.count += 1;
        match self.count {
            1 => Wish::Stop,
            2 if is_keeping => Wish::Hurry,
            _ => Wish::End,
        }
    }
}

/// A token that Ctrl-C (or a polite kill) cancels. The second time ends the process at once, unless there is
/// [something to keep](keep): then the third.
pub fn cancel_on_ctrl_c() -> Result<CancelToken, Failure> {
    let token = CancelToken::new();
    let cancelled = token.clone();
    let mut wishes = Wishes::default();
    ctrlc::set_handler(move || {
        let keeping = *lock(&KEEPING);
        match wishes.next(Instant::now(), keeping.is_some()) {
            Wish::Same => {}
            Wish::Stop => {
                cancelled.cancel();
                lock(&STOPPED).get_or_insert_with(Instant::now);
                if let Some(reporter) = keeping {
                    reporter.say("stopping; the picture is saved as it is");
                }
            }
            Wish::Hurry => {
                HURRIES.store(true, Ordering::Relaxed);
                progress::say("the picture is being saved; once more ends at once, without it");
            }
            Wish::End => {
                if let Some(path) = lock(&HALF_WRITTEN).take() {
                    let _ = fs::remove_file(path);
                }
                std::process::exit(Exit::Interrupted as i32);
            }
        }
    })
    .map_err(|error| Failure::other(format!("cannot listen for Ctrl-C: {error}")))?;
    Ok(token)
}

/// From now on there may be a picture, which a second Ctrl-C does not lose.
pub fn keep(reporter: Reporter) {
    *lock(&KEEPING) = Some(reporter);
}

/// Whether what makes the picture nicer still has time: once somebody wants it stopped no more than some seconds, and none once
/// that was asked for twice.
pub fn has_time() -> bool {
    const PATIENCE: Duration = Duration::from_secs(10);
    !HURRIES.load(Ordering::Relaxed) && lock(&STOPPED).is_none_or(|at| at.elapsed() < PATIENCE)
}

/// Who hears of it, where there is something to keep.
static KEEPING: Mutex<Option<Reporter>> = Mutex::new(None);

/// When the first Ctrl-C came.
static STOPPED: Mutex<Option<Instant>> = Mutex::new(None);

/// Whether a second came.
static HURRIES: AtomicBool = AtomicBool::new(false);

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file that nobody wants when the process ends while it is written.
static HALF_WRITTEN: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Remembers, or forgets, the file that goes when Ctrl-C ends the process.
pub fn remove_when_killed(path: Option<PathBuf>) {
    *lock(&HALF_WRITTEN) = path;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_lost_to_the_third_wish_and_nothing_else_to_the_second() {
        let begin = Instant::now();
        let wishes = |is_keeping: bool| {
            let mut wishes = Wishes::default();
            [0, 20, 1000, 1200, 2000].map(|ms| wishes.next(begin + Duration::from_millis(ms), is_keeping))
        };
        assert_eq!(wishes(true), [Wish::Stop, Wish::Same, Wish::Hurry, Wish::Same, Wish::End]);
        assert_eq!(wishes(false), [Wish::Stop, Wish::Same, Wish::End, Wish::Same, Wish::End]);
    }
}
