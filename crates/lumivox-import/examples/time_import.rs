//! Times an import: reading headers, and loading the best series. `time_import PATH [ROUNDS]` prints the best of them.

use std::{path::PathBuf, time::Instant};

use lumivox_core::{CancelToken, Progress};
use lumivox_import::{ImportError, ImportOptions, Study};

fn main() -> Result<(), ImportError> {
    let mut arguments = std::env::args().skip(1);
    let path = PathBuf::from(arguments.next().unwrap_or_else(|| ".".to_owned()));
    let rounds: u32 = arguments.next().and_then(|rounds| rounds.parse().ok()).unwrap_or(3);
    let (options, cancel) = (ImportOptions::default(), CancelToken::new());
    let (mut scanned, mut loaded) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..rounds {
        let start = Instant::now();
        let mut study = Study::open(std::slice::from_ref(&path), &options, Progress::SILENT, &cancel)?;
        scanned = scanned.min(start.elapsed().as_secs_f64());
        let dims = study.load(&options, Progress::SILENT, &cancel)?.volume.dims();
        loaded = loaded.min(start.elapsed().as_secs_f64());
        assert_eq!(dims, study.report().series[0].dims, "what is promised is loaded");
    }
    println!("lumivox: headers {scanned:.3} s, headers and volume {loaded:.3} s");
    Ok(())
}
