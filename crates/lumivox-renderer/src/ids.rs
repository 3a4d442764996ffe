//! Names for GPU resources, unique in the process, so that one executor may serve any number of scenes and views.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::recording::ResourceId;

pub(crate) fn next() -> ResourceId {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    ResourceId(NEXT.fetch_add(1, Ordering::Relaxed))
}
