//! Work that can be watched, and stopped at any moment.

mod common;

use std::{
    sync::atomic::{AtomicU64, Ordering},
    thread,
    time::{Duration, Instant},
};

use lumivox_core::{CancelToken, Progress, Stage};
use lumivox_import::{ImportError, ImportOptions};

/// From the wish to stop to the end of the work.
const SOON: Duration = Duration::from_millis(200);

#[test]
fn a_zipped_scan_can_be_stopped_at_any_moment() {
    let Some(path) = common::shared("ct_torso.zip") else { return };
    let paths = [path];
    let load = |progress: Progress<'_>, cancel: &CancelToken| {
        lumivox_import::load(&paths, &ImportOptions::default(), progress, cancel)
    };
    // Watched to the end once.
    let (scanned, decoded) = (AtomicU64::new(0), AtomicU64::new(0));
    let watch = |stage, _, _| match stage {
        Stage::Scanning => _ = scanned.fetch_add(1, Ordering::Relaxed),
        _ => _ = decoded.fetch_add(1, Ordering::Relaxed),
    };
    let start = Instant::now();
    load(Progress::new(&watch), &CancelToken::new()).unwrap();
    let whole = start.elapsed();
    assert_eq!(
        (scanned.into_inner(), decoded.into_inner()),
        (276, 275),
        "each file and each slice is a step"
    );

    let (mut stopped, mut slowest) = (0, Duration::ZERO);
    for moment in 0..16 {
        let cancel = CancelToken::new();
        let late = cancel.clone();
        let canceller = thread::spawn(move || {
            thread::sleep(whole * moment / 16);
            late.cancel();
            Instant::now()
        });
        let result = load(Progress::SILENT, &cancel);
        let end = Instant::now();
        let cancelled = canceller.join().unwrap();
        if let Err(error) = result {
            assert!(matches!(error, ImportError::Cancelled(_)), "{error}");
            stopped += 1;
            slowest = slowest.max(end.saturating_duration_since(cancelled));
        }
    }
    println!("{stopped} of 16 stopped in a load of {whole:.2?}, the slowest after {slowest:.1?}");
    assert!(stopped >= 8, "{stopped}");
    assert!(slowest < SOON, "{slowest:?}");
}
