//! Any bytes, as a table of names and colours beside a label map.
#![no_main]

use std::{fs, path::PathBuf, sync::LazyLock};

use lumivox_core::{CancelToken, Progress};
use lumivox_import::{LabelOptions, load_labels};

/// A label map of five voxels, and its table.
static FILES: LazyLock<[PathBuf; 2]> = LazyLock::new(|| {
    let shm = PathBuf::from("/dev/shm");
    let folder = if shm.is_dir() { shm } else { std::env::temp_dir() };
    let map = folder.join(format!("lumivox-fuzz-map-{}.nrrd", std::process::id()));
    let header = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 5 1 1\nencoding: raw\n\n";
    fs::write(&map, [header.as_bytes(), &[0, 1, 2, 9, 17]].concat()).expect("the scratch file can be written");
    [map.with_extension("table"), map]
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let [table, map] = &*FILES;
    fs::write(table, bytes).expect("the scratch file can be written");
    let mut options = LabelOptions::default();
    options.table = Some(table.clone());
    if let Ok(imported) = load_labels(map, &options, Progress::SILENT, &CancelToken::new()) {
        assert_eq!(imported.labels.labels().len(), 4);
        assert!(imported.labels.labels().iter().all(|label| !label.name.contains(char::is_control)));
    }
});
