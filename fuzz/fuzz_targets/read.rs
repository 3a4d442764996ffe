//! What targets do with a file.

use std::{fs, path::PathBuf, sync::LazyLock};

use lumivox_core::{CancelToken, Progress};
use lumivox_import::{ImportOptions, LabelOptions, Study, load_labels};

/// The file that is written and read again, in memory where the system has such a folder.
static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    let shm = PathBuf::from("/dev/shm");
    let folder = if shm.is_dir() { shm } else { std::env::temp_dir() };
    folder.join(format!("lumivox-fuzz-{}", std::process::id()))
});

/// Scans, shows and loads a file of these bytes, as a front end does, and takes it for a label map.
pub fn read(bytes: &[u8]) {
    fs::write(&*FILE, bytes).expect("the scratch file can be written");
    let (options, cancel) = (ImportOptions::default(), CancelToken::new());
    if let Ok(imported) = load_labels(&FILE, &LabelOptions::default(), Progress::SILENT, &cancel) {
        let counts = imported.labels.counts();
        let known = |value: u8| value == 0 || imported.labels.label(value).is_some();
        assert!((0..=255).all(|value| counts[usize::from(value)] == 0 || known(value)));
    }
    let Ok(mut study) = Study::open(&[FILE.clone()], &options, Progress::SILENT, &cancel) else { return };
    for place in 0..study.report().series.len().min(4) {
        let _ = study.thumbnail(place, 16, &cancel);
    }
    if let Ok(imported) = study.load(&options, Progress::SILENT, &cancel) {
        assert!(imported.volume.value_range().iter().all(|value| value.is_finite()));
    }
}
