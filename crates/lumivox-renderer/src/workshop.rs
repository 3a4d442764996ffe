//! Kernels made for a device on threads of their own, ahead of the frame that wants them. What "made" means is the
//! host's: a wgpu pipeline, a shader of an engine's. What of one kernel is made several times, as a pipeline is for each
//! kind of target that it draws onto, has a key of the host's own.

use std::collections::{HashMap, VecDeque};
use std::hash::Hash;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use lumivox_core::host;

use crate::recording::Kernel;

/// Most threads at once: compilers take memory, and the host's own threads go on beside them.
const MAX_THREADS: usize = 4;

/// What is made of a key, or why nothing can be.
type Made<T> = Result<T, String>;

/// Makes `T` of keys, each once: of kernels, unless a host has keys of its own. Threads last while there is something to
/// make.
pub struct Workshop<T, K = Kernel>(Arc<Inner<T, K>>);

struct Inner<T, K> {
    make: Box<dyn Fn(K) -> Made<T> + Send + Sync>,
    state: Mutex<State<T, K>>,
    changed: Condvar,
    max_threads: usize,
}

struct State<T, K> {
    /// In the order in which they are made.
    orders: VecDeque<K>,
    threads: usize,
    /// `None` while it is being made.
    made: HashMap<K, Option<Made<T>>>,
    waits: u64,
}

impl<T, K> std::fmt::Debug for Workshop<T, K> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let state = self.0.lock();
        write!(f, "Workshop({} made, {} ordered)", state.made.len(), state.orders.len())
    }
}

impl<T: Clone + Send + 'static, K: Copy + Eq + Hash + Send + 'static> Workshop<T, K> {
    /// An empty one. `make` is called on threads that it starts, and on those that [`get`](Self::get).
    pub fn new(make: impl Fn(K) -> Made<T> + Send + Sync + 'static) -> Self {
        Self(Arc::new(Inner {
            make: Box::new(make),
            state: Mutex::new(State { orders: VecDeque::new(), threads: 0, made: HashMap::new(), waits: 0 }),
            changed: Condvar::new(),
            max_threads: host::spare_threads().clamp(1, MAX_THREADS),
        }))
    }

    /// Has kernels made that are not yet, after those ordered before. Returns at once, but where the host has no
    /// threads: there they are made here.
    pub fn prepare(&self, kernels: impl IntoIterator<Item = K>) {
        let mut state = self.0.lock();
        for key in kernels {
            if !state.made.contains_key(&key) && !state.orders.contains(&key) {
                state.orders.push_back(key);
            }
        }
        self.start_threads(state);
    }

    /// The same, before all others: something waits for them.
    pub fn hurry(&self, kernels: impl IntoIterator<Item = K>) {
        let mut state = self.0.lock();
        let wanted: Vec<K> = kernels.into_iter().filter(|key| !state.made.contains_key(key)).collect();
        state.orders.retain(|other| !wanted.contains(other));
        wanted.into_iter().rev().for_each(|key| state.orders.push_front(key));
        self.start_threads(state);
    }

    /// Whether [`get`](Self::get) will not have to wait.
    pub fn is_ready(&self, key: K) -> bool {
        matches!(self.0.lock().made.get(&key), Some(Some(_)))
    }

    /// What is made of a key. Waits for it where it is being made, and makes it where nobody does.
    ///
    /// # Errors
    /// What the maker said; it is not tried again.
    pub fn get(&self, key: K) -> Made<T> {
        let mut state = self.0.lock();
        let mut waited = false;
        loop {
            match state.made.get(&key) {
                Some(Some(made)) => return made.clone(),
                Some(None) => {
                    state.waits += u64::from(!waited);
                    waited = true;
                    state = self.0.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                }
                None => {
                    state.waits += u64::from(!waited);
                    state.orders.retain(|other| *other != key);
                    state.made.insert(key, None);
                    drop(state);
                    return self.0.make(key);
                }
            }
        }
    }

    /// Kernels that are ordered and not made.
    pub fn outstanding(&self) -> usize {
        let state = self.0.lock();
        state.orders.len() + state.made.values().filter(|made| made.is_none()).count()
    }

    /// How often [`get`](Self::get) had to wait, or to make a kernel itself: 0 where all were prepared in time.
    pub fn waits(&self) -> u64 {
        self.0.lock().waits
    }

    /// Drops what is ordered, waits for what is being made, and hands over everything.
    pub fn clear(&self) -> Vec<T> {
        let mut state = self.0.lock();
        state.orders.clear();
        while state.threads > 0 || state.made.values().any(Option::is_none) {
            state = self.0.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.made.drain().filter_map(|(_, made)| made?.ok()).collect()
    }

    fn start_threads(&self, mut state: MutexGuard<'_, State<T, K>>) {
        // Those that are there may be busy for long.
        let under_way = state.made.values().filter(|made| made.is_none()).count();
        let wanted = (under_way + state.orders.len()).min(self.0.max_threads);
        while state.threads < wanted {
            let inner = self.0.clone();
            state.threads += 1;
            if let Err(work) = host::spawn("lumivox kernels", move || inner.work()) {
                if state.threads > 1 {
                    // Others are there, and make all.
                    state.threads -= 1;
                    return;
                }
                // Hosts wait until kernels are ready: without threads this one makes them.
                drop(state);
                return work();
            }
        }
    }
}

impl<T: Clone, K: Copy + Eq + Hash> Inner<T, K> {
    /// Makes what is ordered until nothing is.
    fn work(&self) {
        let mut state = self.lock();
        while let Some(key) = state.orders.pop_front() {
            state.made.insert(key, None);
            drop(state);
            let _ = self.make(key);
            state = self.lock();
        }
        state.threads -= 1;
        self.changed.notify_all();
    }

    fn make(&self, key: K) -> Made<T> {
        // Others may wait for it: a panic, which was reported, is one more reason why it cannot be had.
        let made = catch_unwind(AssertUnwindSafe(|| (self.make)(key)))
            .unwrap_or_else(|_| Err("its compiler panicked".to_owned()));
        self.lock().made.insert(key, Some(made.clone()));
        self.changed.notify_all();
        made
    }
}

impl<T, K> Inner<T, K> {
    fn lock(&self) -> MutexGuard<'_, State<T, K>> {
        // Nothing panics while it is held.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread::{self, ThreadId};
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn what_is_prepared_is_made_once_elsewhere_and_waited_for_never_again() {
        let calls = Arc::new(AtomicUsize::new(0));
        let counted = calls.clone();
        let workshop: Workshop<ThreadId> = Workshop::new(move |_| {
            counted.fetch_add(1, Ordering::Relaxed);
            Ok(thread::current().id())
        });
        let kernels = [Kernel::MajorantGrid, Kernel::HostDepth, Kernel::Display];
        workshop.prepare(kernels);
        workshop.hurry(kernels);
        while workshop.outstanding() > 0 {
            thread::yield_now();
        }
        for kernel in kernels {
            assert!(workshop.is_ready(kernel));
            assert_ne!(workshop.get(kernel), Ok(thread::current().id()));
        }
        assert_eq!((workshop.waits(), calls.load(Ordering::Relaxed)), (0, 3));
        assert!(!workshop.is_ready(Kernel::DenoisePrepare));
        assert_eq!(
            workshop.get(Kernel::DenoisePrepare),
            Ok(thread::current().id()),
            "made where it is wanted"
        );
        assert_eq!(workshop.waits(), 1);
        assert_eq!(workshop.clear().len(), 4);
        assert!(!workshop.is_ready(Kernel::Display));
    }

    /// A compiler may take seconds for one kernel; the next in haste does not wait for that.
    #[test]
    fn what_is_hurried_overtakes_what_is_under_way() {
        let (release, hold) = std::sync::mpsc::channel::<()>();
        let hold = Mutex::new(hold);
        let made = Arc::new(Mutex::new(vec![]));
        let order = made.clone();
        let mut workshop: Workshop<()> = Workshop::new(move |kernel| {
            if kernel == Kernel::Display {
                hold.lock().unwrap().recv().unwrap();
            }
            order.lock().unwrap().push(kernel);
            Ok(())
        });
        Arc::get_mut(&mut workshop.0).unwrap().max_threads = 2;
        workshop.prepare([Kernel::Display]);
        while workshop.0.lock().threads == 0 || !workshop.0.lock().orders.is_empty() {
            thread::yield_now();
        }
        let until_made = |kernels: &[Kernel]| {
            workshop.hurry(kernels.iter().copied());
            let begin = Instant::now();
            while !kernels.iter().all(|kernel| workshop.is_ready(*kernel)) {
                assert!(begin.elapsed() < Duration::from_secs(60), "it waits for what is under way");
                thread::yield_now();
            }
        };
        until_made(&[Kernel::HostDepth]);
        until_made(&[Kernel::FilmCount, Kernel::MajorantGrid]);
        release.send(()).unwrap();
        workshop.clear();
        let in_order = [Kernel::HostDepth, Kernel::FilmCount, Kernel::MajorantGrid, Kernel::Display];
        assert_eq!(*made.lock().unwrap(), in_order);
    }

    #[test]
    fn whoever_waits_for_a_kernel_that_cannot_be_made_is_told() {
        let workshop: Workshop<()> = Workshop::new(|kernel| match kernel {
            Kernel::Display => Err("no".to_owned()),
            _ => panic!("a compiler's fault, on purpose"),
        });
        workshop.prepare([Kernel::Display, Kernel::HostDepth]);
        assert_eq!(workshop.get(Kernel::Display), Err("no".to_owned()));
        assert_eq!(workshop.get(Kernel::HostDepth), Err("its compiler panicked".to_owned()));
        assert!(workshop.clear().is_empty());
    }
}
