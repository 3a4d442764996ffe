//! Files made to hurt: each is refused, or read where it can be, within seconds and without memory. Alone in its
//! program, so that the peak is its own.

mod common;

use std::time::{Duration, Instant};

#[test]
fn bad_files_are_refused_quickly_and_in_little_memory() {
    let Some(folder) = common::shared("bad") else { return };
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for path in files {
        let start = Instant::now();
        let result = common::load(&path);
        let elapsed = start.elapsed();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        match &result {
            Ok(imported) => println!("{name}: {:?} {:?}", imported.volume.dims(), imported.report.notes),
            Err(error) => println!("{name}: {error}"),
        }
        assert!(elapsed < Duration::from_secs(5), "{name} took {elapsed:?}");
        if let Err(error) = result {
            assert!(error.to_string().contains(&name), "{error}");
        }
    }
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
        let kib: u64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
        assert!(kib < 200 << 10, "peak {} MiB", kib >> 10);
    }
}
