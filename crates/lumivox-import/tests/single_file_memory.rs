//! How much memory a large single file takes to load. Alone in its process, which it measures.

use std::io::{Seek, SeekFrom, Write};

use lumivox_core::{CancelToken, Progress};
use lumivox_import::{ImportOptions, load};

/// The most memory that this process has had in use, in bytes.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

#[test]
fn a_large_nrrd_takes_little_more_memory_than_its_volume() {
    const SIDE: usize = 384;
    let mut file = tempfile::NamedTempFile::with_suffix(".nrrd").unwrap();
    write!(
        file,
        "NRRD0004\ntype: short\ndimension: 3\nsizes: {SIDE} {SIDE} {SIDE}\nendian: little\nencoding: raw\n\n"
    )
    .unwrap();
    let bytes = (SIDE * SIDE * SIDE * 2) as u64;
    // The samples are a hole of zeros with a one at its end.
    file.seek(SeekFrom::Current(bytes as i64 - 2)).unwrap();
    file.write_all(&1i16.to_le_bytes()).unwrap();
    let paths = [file.path().to_owned()];
    let volume =
        load(&paths, &ImportOptions::default(), Progress::SILENT, &CancelToken::new()).unwrap().volume;
    assert_eq!(volume.value_range(), [0.0, 1.0]);
    let Some(peak) = peak() else { return };
    println!("volume {} MiB, peak {} MiB", bytes >> 20, peak >> 20);
    assert!(peak < bytes * 3 / 2, "{peak} bytes for a volume of {bytes}");
}
