//! Long work beside the interface: the one place where threads are. In a browser a Worker takes their place.
//!
//! A job is told what to do when it starts, tells what it found in messages, and ends. The interface polls it in its frames, shows
//! its progress, and may cancel it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};

use lumivox_core::{CancelToken, Progress, WorkStage, host};

/// Wakes the interface, from whatever thread.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// What a job is busy with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Busy {
    /// Which kind of work it is, where that is known.
    pub stage: Option<WorkStage>,
    /// So much of it is done.
    pub done: u64,
    /// Of so much; 0 where nobody knows.
    pub total: u64,
}

impl Busy {
    /// The part that is done, where that is known.
    pub fn part(&self) -> Option<f32> {
        (self.total > 0).then(|| (self.done as f32 / self.total as f32).clamp(0.0, 1.0))
    }
}

/// A job, as the interface sees it. Dropped, it is cancelled: nobody would hear of it.
pub struct Job<M> {
    messages: mpsc::Receiver<M>,
    /// Ends what does not ask whether it is to end.
    ends: Option<Box<dyn FnOnce()>>,
    cancel: CancelToken,
    busy: Arc<Mutex<Busy>>,
    is_over: bool,
    was_done: Arc<AtomicBool>,
}

/// A job, as its work sees it.
pub struct Desk<M> {
    was_done: Arc<AtomicBool>,
    messages: mpsc::Sender<M>,
    cancel: CancelToken,
    busy: Arc<Mutex<Busy>>,
    wake: Wake,
}

/// Wakes the interface when it goes.
struct WakeLast(Wake);

impl Drop for WakeLast {
    fn drop(&mut self) {
        (self.0)();
    }
}

fn lock(busy: &Mutex<Busy>) -> MutexGuard<'_, Busy> {
    busy.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A job that is done elsewhere, and where what it says is put down; it is broken unless that says that it is done. `ends` is
/// called when nobody would hear of it any more.
pub fn elsewhere<M>(wake: Wake, ends: impl FnOnce() + 'static) -> (Job<M>, Desk<M>) {
    let (send, messages) = mpsc::channel();
    let (cancel, busy, was_done) =
        (CancelToken::new(), Arc::new(Mutex::new(Busy::default())), Arc::default());
    let desk = Desk { messages: send, cancel: cancel.clone(), busy: busy.clone(), wake, was_done };
    let was_done = desk.was_done.clone();
    (Job { messages, ends: Some(Box::new(ends)), cancel, busy, is_over: false, was_done }, desk)
}

/// Begins a job.
pub fn start<M: Send + 'static>(
    name: &str,
    wake: Wake,
    work: impl FnOnce(&Desk<M>) + Send + 'static,
) -> Job<M> {
    let (job, desk) = elsewhere(wake, || {});
    let done = move || {
        // The last to go, however the work ends: the channel closes before the interface looks.
        let _wake = WakeLast(desk.wake.clone());
        let desk = desk;
        work(&desk);
        desk.done();
    };
    // Where there is no thread for it, it is done here.
    if let Err(work) = host::spawn(name, done) {
        work();
    }
    job
}

impl<M> Job<M> {
    /// What was told since the last time.
    pub fn poll(&mut self) -> Vec<M> {
        let mut told = vec![];
        loop {
            match self.messages.try_recv() {
                Ok(message) => told.push(message),
                Err(mpsc::TryRecvError::Empty) => return told,
                Err(mpsc::TryRecvError::Disconnected) => {
                    self.is_over = true;
                    return told;
                }
            }
        }
    }

    /// Whether it has ended, and all that it told was polled.
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// Whether it has ended by a panic: a fault of ours, of which the one who waits is to hear.
    pub fn is_broken(&self) -> bool {
        self.is_over && !self.was_done.load(Ordering::Acquire)
    }

    /// What it is busy with.
    pub fn busy(&self) -> Busy {
        *lock(&self.busy)
    }

    /// Asks it to end soon.
    pub fn cancel(&self) {
        self.cancel.cancel();
    }
}

impl<M> Drop for Job<M> {
    fn drop(&mut self) {
        self.cancel.cancel();
        if let Some(end) = self.ends.take() {
            end();
        }
    }
}

impl<M> Desk<M> {
    /// All is told.
    pub fn done(&self) {
        self.was_done.store(true, Ordering::Release);
    }

    /// Tells the interface something.
    pub fn tell(&self, message: M) {
        // Nobody listens any more where another job took its place.
        let _ = self.messages.send(message);
        (self.wake)();
    }

    /// Wakes the interface.
    pub fn wake(&self) {
        (self.wake)();
    }

    /// Whether it is to end.
    pub fn cancel(&self) -> &CancelToken {
        &self.cancel
    }

    /// How far it is.
    pub fn report(&self, busy: Busy) {
        *lock(&self.busy) = busy;
        (self.wake)();
    }

    /// Work that tells how far it is.
    pub fn watch<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T
    where
        M: Send,
    {
        let (busy, wake) = (self.busy.clone(), self.wake.clone());
        let report = move |stage, done, total| {
            *lock(&busy) = Busy { stage: Some(stage), done, total };
            wake();
        };
        work(Progress::new(&report))
    }
}
