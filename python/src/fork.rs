//! Processes that were forked, as `multiprocessing` makes them on Linux: of all threads, a child has the one that forked.
//! Rayon's pool would wait for its others for ever, and a GPU's driver, too. So a child has a pool of its own, and says of
//! a GPU that its parent used what to do instead.

use std::ptr;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicPtr, AtomicU32, Ordering};

use pyo3::PyResult;
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::{ending, errors};

/// The process that imported this.
static IMPORTED: OnceLock<u32> = OnceLock::new();

/// The first process that asked for GPUs, 0 before.
static USED_GPUS: AtomicU32 = AtomicU32::new(0);

/// A forked process's own pool, and whose it is: one that comes of a fork of that again has another.
struct Own {
    process: u32,
    pool: ThreadPool,
}

/// No lock: another thread may have held it when the process was forked. Old ones are never freed, for their threads are gone.
static OWN: AtomicPtr<Own> = AtomicPtr::new(ptr::null_mut());

/// Which process this is.
pub fn process() -> u32 {
    std::process::id()
}

/// Notes which process imported this.
pub fn imported() {
    let _ = IMPORTED.set(process());
}

/// Whether this is another process than the one that imported this.
pub fn is_forked() -> bool {
    IMPORTED.get().is_some_and(|imported| *imported != process())
}

/// Does work that may use all cores.
pub fn on_all_cores<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    match own() {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// [`on_all_cores`], without the interpreter's lock.
pub fn detach<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    ending::detach(py, || on_all_cores(work))
}

/// The pool of a forked process; `None` in one that was not.
fn own() -> Option<&'static ThreadPool> {
    if !is_forked() {
        return None;
    }
    let process = process();
    let there = OWN.load(Ordering::Acquire);
    // SAFETY: what is published there is never freed, and never changes.
    if let Some(own) = unsafe { there.as_ref() }
        && own.process == process
    {
        return Some(&own.pool);
    }
    let pool = rayon::ThreadPoolBuilder::new().build().ok()?;
    let made = Box::into_raw(Box::new(Own { process, pool }));
    let published = match OWN.compare_exchange(there, made, Ordering::AcqRel, Ordering::Acquire) {
        Ok(_) => made,
        // Another thread was faster; what is made here stays unused.
        Err(other) => other,
    };
    // SAFETY: as above.
    unsafe { published.as_ref() }.map(|own| &own.pool)
}

/// Notes that this process uses GPUs; an error in one that was forked from a process that did.
pub fn use_gpus() -> PyResult<()> {
    let process = process();
    match USED_GPUS.compare_exchange(0, process, Ordering::AcqRel, Ordering::Acquire) {
        Err(other) if other != process => Err(errors::forked()),
        _ => Ok(()),
    }
}
