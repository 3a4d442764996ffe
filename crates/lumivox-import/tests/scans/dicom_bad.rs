//! Files made to hurt: each is refused, or read where it can be, within seconds and without memory. Alone in its
//! program, so that the peak is its own.

use std::time::{Duration, Instant};

use lumivox_import::ImportError;

/// Bad as they are, all that a volume needs is there.
const READABLE: [&str; 7] = [
    "a_pixeldata_len_fffffff0.dcm",
    "e_nest_1000.dcm",
    "e_nest_20000.dcm",
    "e_nest_500000.dcm",
    "noPreamble_noMeta_explicit.dcm",
    "noPreamble_withMeta.dcm",
    "v_comma_decimal.dcm",
];

#[test]
fn bad_files_are_refused_quickly_and_in_little_memory() {
    let Some(folder) = crate::common::shared("bad") else { return };
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for path in files {
        let start = Instant::now();
        let result = crate::common::load(&path);
        let elapsed = start.elapsed();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        match &result {
            Ok(imported) => println!("{name}: {:?} {:?}", imported.volume.dims(), imported.report.notes),
            Err(error) => println!("{name}: {error}"),
        }
        assert!(elapsed < Duration::from_secs(5), "{name} took {elapsed:?}");
        if name == "a_pixeldata_len_fffffff0.dcm" {
            let notes = result.as_ref().unwrap().report.notes.join("; ");
            assert!(notes.contains("PixelData (7FE0,0010) declares 4294967280 bytes where"), "{notes}");
        }
        assert_eq!(result.is_ok(), READABLE.contains(&name.as_str()), "{name}");
        if let Err(error) = result {
            assert!(error.to_string().contains(&name), "{error}");
            // A field with an impossible value is named.
            assert!(!name.starts_with("v_") || matches!(error, ImportError::Field { .. }), "{error}");
        }
    }
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
        let kib: u64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
        assert!(kib < 200 << 10, "peak {} MiB", kib >> 10);
    }
}
