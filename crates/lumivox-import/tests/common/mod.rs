//! The shared real scans, and helpers to look at what was loaded.

use std::{
    collections::HashMap,
    fs::File,
    io::Write,
    path::{Path, PathBuf},
    sync::Once,
};

use lumivox_core::{CancelToken, Progress, Volume};
use lumivox_import::{ImportError, ImportOptions, Imported};

/// Names another folder of shared scans.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub const SHARED: &str = "LUMIVOX_TEST_SCANS";

/// Where `name` of the shared scans is. They belong to nobody's repository: `None` where they are absent, of which each
/// test program says one line that is seen.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn shared(name: &str) -> Option<PathBuf> {
    static SAID: Once = Once::new();
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let path = std::env::var_os(SHARED).map_or(PathBuf::from(beside), PathBuf::from).join(name);
    if path.exists() {
        return Some(path);
    }
    // The test harness keeps what `eprintln!` prints of a test that passes, but not this.
    SAID.call_once(|| {
        let _ = writeln!(
            std::io::stderr(),
            "real scans are absent ({}): tests of them check nothing",
            path.display()
        );
    });
    None
}

/// Unpacks a zip archive of the shared scans.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn unzip(name: &str) -> Option<tempfile::TempDir> {
    let folder = tempfile::tempdir().unwrap();
    zip::ZipArchive::new(File::open(shared(name)?).unwrap()).unwrap().extract(folder.path()).unwrap();
    Some(folder)
}

/// Loads one path with default options.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn load(path: &Path) -> Result<Imported, ImportError> {
    load_series(path, None)
}

/// Loads what `write` writes to the path that it is given.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn load_written(write: impl FnOnce(&Path)) -> Result<Imported, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.dcm");
    write(&path);
    load(&path)
}

/// Physical values of all voxels.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn values(volume: &Volume) -> Vec<f64> {
    (0..volume.voxel_count()).map(|i| volume.voxels().get(i) * volume.slope() + volume.intercept()).collect()
}

/// Loads a series of one path.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn load_series(path: &Path, series: Option<&str>) -> Result<Imported, ImportError> {
    let mut options = ImportOptions::default();
    options.series = series.map(str::to_owned);
    lumivox_import::load(&[path.to_owned()], &options, Progress::SILENT, &CancelToken::new())
}

/// A line of reference.csv: what another reader gets of a file.
#[derive(Clone, Debug)]
#[allow(dead_code, reason = "not every test program uses every helper")]
pub struct Reference {
    pub path: String,
    pub status: String,
    pub columns: usize,
    pub rows: usize,
    pub frames: usize,
    pub sum: f64,
    pub range: [f64; 2],
}

/// The lines of reference.csv whose path starts with `prefix`, by path.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn reference(prefix: &str) -> HashMap<String, Reference> {
    let Some(path) = shared("reference.csv") else { return HashMap::new() };
    let text = std::fs::read_to_string(path).unwrap();
    let parse = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |k: usize| fields.get(k).and_then(|f| f.parse().ok()).unwrap_or(0);
        let (low, high) = fields.get(7).and_then(|f| f.split_once("..")).unwrap_or(("0", "0"));
        Reference {
            path: fields[0].to_owned(),
            status: fields[1].to_owned(),
            columns: number(3),
            rows: number(4),
            frames: number(5),
            sum: fields.get(6).and_then(|f| f.parse().ok()).unwrap_or(0.0),
            range: [low.parse().unwrap_or(0.0), high.parse().unwrap_or(0.0)],
        }
    };
    let lines = text.lines().skip(1).map(parse).filter(|line| line.path.starts_with(prefix));
    lines.map(|line| (line.path.clone(), line)).collect()
}

/// Sum and range of the values of slice `z`.
#[allow(dead_code, reason = "not every test program uses every helper")]
pub fn slice_sum(volume: &Volume, z: usize) -> (f64, [f64; 2]) {
    let [columns, rows, _] = volume.dims();
    let mut sum = 0.0;
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for y in 0..rows {
        for x in 0..columns {
            let value = volume.value([x, y, z]);
            sum += value;
            range = [range[0].min(value), range[1].max(value)];
        }
    }
    (sum, range)
}
