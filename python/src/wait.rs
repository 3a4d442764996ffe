//! Long work without the interpreter's lock: others run meanwhile, progress is told, Ctrl-C stops it.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use lumivox_core::{CancelToken, Progress};
use pyo3::prelude::*;

use crate::{ending, fork};

/// How often signals are looked for.
const LOOK: Duration = Duration::from_millis(50);

/// Does `work` on a thread of its own, and waits for it: what it sends is given to `hear`, with the lock. Signals, and what
/// `hear` raises, and the end of the interpreter cancel the work by `cancel`; its result is waited for in any case.
pub fn wait<M: Send, T: Send>(
    py: Python<'_>,
    cancel: &CancelToken,
    work: impl FnOnce(Sender<M>) -> T + Send,
    hear: impl Fn(Python<'_>, M) -> PyResult<()> + Send,
) -> PyResult<T> {
    ending::check()?;
    let (result, raised) = ending::detach(py, move || {
        thread::scope(|scope| {
            let (sender, receiver) = channel();
            let worker = scope.spawn(move || fork::on_all_cores(|| work(sender)));
            let raised = listen(&receiver, cancel, &hear);
            // A panic goes on here, and becomes Python's.
            (worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), raised)
        })
    });
    raised.map(|()| result)
}

/// Hears until the work's end of the channel is gone.
fn listen<M>(
    messages: &Receiver<M>,
    cancel: &CancelToken,
    hear: &impl Fn(Python<'_>, M) -> PyResult<()>,
) -> PyResult<()> {
    let mut result = Ok(());
    loop {
        let message = match messages.recv_timeout(LOOK) {
            // The last is as good as all.
            Ok(message) => Some(messages.try_iter().last().unwrap_or(message)),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return result,
        };
        if result.is_ok() {
            result = Python::attach(|py| {
                ending::check()?;
                py.check_signals()?;
                message.map_or(Ok(()), |message| hear(py, message))
            });
            if result.is_err() {
                cancel.cancel();
            }
        }
    }
}

/// [`wait`] for work that reports stages, to a Python callable `(stage, done, total)` if there is one.
pub fn stages<T: Send>(
    py: Python<'_>,
    told: Option<Py<PyAny>>,
    work: impl FnOnce(Progress<'_>, &CancelToken) -> T + Send,
) -> PyResult<T> {
    let cancel = CancelToken::new();
    let tell = |py: Python<'_>, (stage, done, total): (&'static str, u64, u64)| match &told {
        Some(told) => told.call1(py, (stage, done, total)).map(drop),
        None => Ok(()),
    };
    let (listened, token) = (told.is_some(), cancel.clone());
    let report = |sender: Sender<_>| {
        let send = move |stage: lumivox_core::WorkStage, done, total| {
            if listened {
                let _ = sender.send((stage.label(), done, total));
            }
        };
        work(Progress::new(&send), &token)
    };
    wait(py, &cancel, report, tell)
}
