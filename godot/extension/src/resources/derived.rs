//! Volumes that are computed of a scan, on other threads, while it is shown.

use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use lumivox_core::{CancelToken, Organ, Progress, Volume};
use lumivox_segmentation::{Surroundings, find_organ};

/// What of a scan is shown in place of the patient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// All that was scanned, the table too.
    Everything,
    /// One organ.
    Organ(Organ),
}

type Computed = OnceLock<Option<Arc<Volume>>>;

/// A volume that is computed of a scan; it lasts as long as somebody holds it.
#[derive(Clone)]
pub struct Derived(Arc<Computed>);

impl Derived {
    /// Begins to compute it.
    pub fn compute(work: impl FnOnce() -> Option<Volume> + Send + 'static) -> Self {
        let computed = Arc::new(Computed::new());
        // Whom nobody waits for any more need not be computed.
        let wanted = Arc::downgrade(&computed);
        rayon::spawn(move || {
            if wanted.strong_count() == 0 {
                return;
            }
            let volume = work().map(Arc::new);
            if let Some(computed) = wanted.upgrade() {
                volume.iter().for_each(lumivox_renderer::prepare_volume);
                let _ = computed.set(volume);
            }
        });
        Self(computed)
    }

    /// One that is there.
    pub fn ready(volume: Arc<Volume>) -> Self {
        Self(Arc::new(OnceLock::from(Some(volume))))
    }

    /// The volume; `None` while it is computed, `Some(None)` where there is none.
    pub fn get(&self) -> Option<Option<Arc<Volume>>> {
        self.0.get().cloned()
    }
}

/// The parts of a scan that somebody shows: all who show the same share it.
#[derive(Default)]
pub struct Parts(Mutex<Vec<(Part, Weak<Computed>)>>);

impl Parts {
    /// A part of a scan; `None` where that is the scan itself.
    pub fn get(&self, part: Part, scan: &Arc<Volume>, around: Option<&Arc<Surroundings>>) -> Option<Derived> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|(_, computed)| computed.strong_count() > 0);
        let found = known.iter().find(|(of, _)| *of == part).and_then(|(_, computed)| computed.upgrade());
        if let Some(computed) = found {
            return Some(Derived(computed));
        }
        let scan = scan.clone();
        let derived = match part {
            Part::Everything => {
                let around = around?.clone();
                Derived::compute(move || around.put_back(&scan).ok())
            }
            Part::Organ(organ) => Derived::compute(move || {
                find_organ(&scan, organ, Progress::SILENT, &CancelToken::new()).ok().flatten()
            }),
        };
        known.push((part, Arc::downgrade(&derived.0)));
        Some(derived)
    }
}
