//! The end of the interpreter. A daemon thread that wants Python's lock back then is ended by Python, by an unwinding that libraries
//! with an unwinder of their own, as released wheels have, do not survive. So before that what works without the lock is stopped, and
//! waited for.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

use pyo3::exceptions::PySystemExit;
use pyo3::prelude::*;

use crate::fork;

/// How many threads work without the lock, or wait for it.
static WORKING: AtomicUsize = AtomicUsize::new(0);
/// The thread that ends the interpreter, once it does: it goes on with what else is registered, and takes the lock as before.
static ENDS: OnceLock<ThreadId> = OnceLock::new();

/// What cannot be stopped, as a driver that compiles, is waited for so long.
const LONGEST: Duration = Duration::from_secs(60);

/// One of those that work.
struct AtWork;

impl AtWork {
    fn begin() -> Self {
        WORKING.fetch_add(1, Ordering::AcqRel);
        Self
    }
}

impl Drop for AtWork {
    fn drop(&mut self) {
        WORKING.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Whether the interpreter ends, for all threads but the one that ends it.
fn is_over() -> bool {
    ENDS.get().is_some_and(|ending| *ending != thread::current().id())
}

/// Works without the interpreter's lock; with it where nobody would get it back.
pub fn detach<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    if is_over() {
        return work();
    }
    // Until the lock is held again.
    let _at_work = AtWork::begin();
    py.detach(work)
}

/// What ends a thread without a word, once the interpreter ends.
///
/// # Errors
/// That.
pub fn check() -> PyResult<()> {
    if is_over() { Err(PySystemExit::new_err(())) } else { Ok(()) }
}

/// Stops what works, and waits for it: the interpreter calls it before it ends.
#[pyfunction]
fn end(py: Python<'_>) {
    let _ = ENDS.set(thread::current().id());
    // Of the threads that were counted a forked process has one.
    if fork::is_forked() {
        return;
    }
    py.detach(|| {
        let begin = Instant::now();
        while WORKING.load(Ordering::Acquire) > 0 && begin.elapsed() < LONGEST {
            thread::sleep(Duration::from_millis(5));
        }
    });
}

/// Has the interpreter call [`end`].
///
/// # Errors
/// Where it has nothing to register that with.
pub fn imported(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let end = wrap_pyfunction!(end, module)?;
    module.py().import("atexit")?.call_method1("register", (end,))?;
    Ok(())
}
