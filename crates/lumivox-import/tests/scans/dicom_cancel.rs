//! Work that can be watched, and stopped at any moment.

use std::{
    num::NonZero,
    sync::atomic::{AtomicU64, Ordering},
    thread,
};

use lumivox_core::{CancelToken, Progress, WorkStage};
use lumivox_import::{ImportError, ImportOptions};

#[test]
fn a_zipped_scan_can_be_stopped_at_any_moment() {
    let Some(path) = crate::common::shared("ct_torso.zip") else { return };
    let paths = [path];
    let load = |progress: Progress<'_>, cancel: &CancelToken| {
        lumivox_import::load(&paths, &ImportOptions::default(), progress, cancel)
    };
    // Watched to the end once.
    let (scanned, decoded) = (AtomicU64::new(0), AtomicU64::new(0));
    let watch = |stage, _, _| match stage {
        WorkStage::Scanning => _ = scanned.fetch_add(1, Ordering::Relaxed),
        _ => _ = decoded.fetch_add(1, Ordering::Relaxed),
    };
    load(Progress::new(&watch), &CancelToken::new()).unwrap();
    assert_eq!(
        (scanned.into_inner(), decoded.into_inner()),
        (276, 275),
        "each file and each slice is a step"
    );

    // Stopped at each of some steps: whoever was at work then may end that step, and nobody begins another.
    let threads = thread::available_parallelism().map_or(1, NonZero::get) as u64;
    for moment in (1..551).step_by(37) {
        let (cancel, steps) = (CancelToken::new(), AtomicU64::new(0));
        let stop = |_, _, _| {
            if steps.fetch_add(1, Ordering::Relaxed) + 1 == moment {
                cancel.cancel();
            }
        };
        let result = load(Progress::new(&stop), &cancel);
        assert!(matches!(result, Err(ImportError::Cancelled(_))), "stopped at step {moment}");
        let after = steps.into_inner() - moment;
        assert!(after < threads, "{after} steps after the one that it was stopped at, {moment}");
    }
}
