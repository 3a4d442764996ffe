//! What belongs to the host: its clock and its threads.
//!
//! A library cannot take them for granted. A browser has a clock of its own and often no threads, an engine may want to know
//! of every thread in its process. So nothing below the hosts asks the system: [`Moment::now`], [`spawn`], [`sleep`] and
//! [`aside`] do, by way of the [`Host`] that was [given](set_host). On a system that has both nobody has to give one.
//! (`cargo xtask layers` finds who asks the system all the same.)
//!
//! Parallel iterators are rayon's. Without threads they run on the thread that calls them.

use std::ops::Sub;
use std::sync::OnceLock;
use std::time::Duration;

/// Something to do, once.
pub type Work = Box<dyn FnOnce() + Send>;

/// A host's clock and threads.
pub trait Host: Send + Sync {
    /// The time since a moment that the host chose once. Never less than before.
    fn now(&self) -> Duration;

    /// How many threads are worth having besides the caller's; 0 where all work is done where it stands.
    fn spare_threads(&self) -> usize;

    /// Does the work on a thread of its own, of that name.
    ///
    /// # Errors
    /// The work, undone, where there is no thread for it.
    fn spawn(&self, name: &str, work: Work) -> Result<(), Work>;

    /// Holds up the calling thread. A host whose threads may not be held up returns at once.
    fn sleep(&self, time: Duration);
}

static HOST: OnceLock<Box<dyn Host>> = OnceLock::new();

/// Gives the clock and the threads of this process. The first thing that a host does: moments from before compare with none
/// from after.
///
/// Without it they are the system's. WebAssembly without a system (`wasm32-unknown-unknown`) has neither: work is done where
/// it stands, and the clock stands still. Then no image has a time limit, and no live view is paced by its frame rate.
///
/// # Errors
/// The host, where one was given before.
pub fn set_host(host: Box<dyn Host>) -> Result<(), Box<dyn Host>> {
    HOST.set(host)
}

fn host() -> &'static dyn Host {
    HOST.get().map_or(&System, |host| &**host)
}

/// A moment by the host's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Moment(Duration);

impl Moment {
    /// This one.
    pub fn now() -> Self {
        Self(host().now())
    }

    /// The time since then.
    pub fn elapsed(self) -> Duration {
        Self::now() - self
    }
}

/// The time from the second to the first; none where that is later.
impl Sub for Moment {
    type Output = Duration;

    fn sub(self, before: Self) -> Duration {
        self.0.saturating_sub(before.0)
    }
}

/// See [`Host::spare_threads`].
pub fn spare_threads() -> usize {
    host().spare_threads()
}

/// See [`Host::spawn`].
///
/// # Errors
/// The work, undone: whoever needs it does it where it stands.
pub fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Result<(), Work> {
    host().spawn(name, Box::new(work))
}

/// See [`Host::sleep`].
pub fn sleep(time: Duration) {
    host().sleep(time);
}

/// Has rayon's threads do something that nobody waits for, in the order of the calls. Without threads it is done here.
pub fn aside(work: impl FnOnce() + Send + 'static) {
    if rayon::current_num_threads() > 1 { rayon::spawn_fifo(work) } else { work() }
}

/// The system that the program runs on.
struct System;

#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
impl Host for System {
    fn now(&self) -> Duration {
        static START: OnceLock<std::time::Instant> = OnceLock::new();
        START.get_or_init(std::time::Instant::now).elapsed()
    }

    fn spare_threads(&self) -> usize {
        std::thread::available_parallelism().map_or(0, |threads| threads.get() - 1)
    }

    fn spawn(&self, name: &str, work: Work) -> Result<(), Work> {
        use std::sync::{Arc, Mutex, PoisonError};
        // A thread that does not start drops what it was to do.
        let kept = Arc::new(Mutex::new(Some(work)));
        let shared = kept.clone();
        let take = |kept: &Mutex<Option<Work>>| kept.lock().unwrap_or_else(PoisonError::into_inner).take();
        let run = move || {
            if let Some(work) = take(&shared) {
                work();
            }
        };
        match std::thread::Builder::new().name(name.to_owned()).spawn(run) {
            Ok(_) => Ok(()),
            Err(_) => take(&kept).map_or(Ok(()), Err),
        }
    }

    fn sleep(&self, time: Duration) {
        std::thread::sleep(time);
    }
}

/// No system.
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
impl Host for System {
    fn now(&self) -> Duration {
        Duration::ZERO
    }

    fn spare_threads(&self) -> usize {
        0
    }

    fn spawn(&self, _: &str, work: Work) -> Result<(), Work> {
        Err(work)
    }

    fn sleep(&self, _: Duration) {}
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Arc, mpsc};

    use super::*;

    #[test]
    fn the_system_is_the_host_where_none_is_given() {
        let began = Moment::now();
        let (send, receive) = mpsc::channel();
        let told = send.clone();
        let work = move || send.send(std::thread::current().name().map(str::to_owned)).unwrap();
        assert!(spawn("of that name", work).is_ok(), "the system gives a thread");
        assert_eq!(receive.recv().unwrap().as_deref(), Some("of that name"));
        aside(move || told.send(None).unwrap());
        assert_eq!(receive.recv().unwrap(), None);
        sleep(Duration::from_millis(2));
        assert!(began.elapsed() >= Duration::from_millis(2));
        assert_eq!(began - Moment::now(), Duration::ZERO, "time does not run backwards");
    }

    #[test]
    fn what_is_put_aside_is_done_at_once_where_there_is_one_thread() {
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let is_done = Arc::new(AtomicBool::new(false));
        let done = is_done.clone();
        one.install(move || aside(move || done.store(true, Ordering::Relaxed)));
        assert!(is_done.load(Ordering::Relaxed));
    }
}
