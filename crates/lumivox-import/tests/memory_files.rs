//! Files in memory are read as those of a system are. Alone in its program, for they are all that it reads from then on.

#[allow(dead_code, reason = "not all of it is used here")]
#[path = "common/mod.rs"]
mod common;
#[allow(dead_code, reason = "not all of it is used here")]
#[path = "common/field.rs"]
mod field;
#[allow(dead_code, reason = "not all of it is used here")]
#[path = "common/writer.rs"]
mod writer;

use std::{
    io::{Cursor, Write},
    path::{Path, PathBuf},
};

use common::{load, values};
use lumivox_core::{CancelToken, Progress};
use lumivox_import::{ImportError, LabelOptions, MemoryFiles, files, load_labels, set_files};

/// The files of a series, by their names.
fn series() -> Vec<(String, Vec<u8>)> {
    let series = field::Series::axial(field::heights(&[0.0, 3.0, 6.0, 9.0]));
    (0..4).map(|k| (format!("{k:03}.dcm"), series.slice(k).file(writer::Syntax::Explicit))).collect()
}

fn zipped() -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(vec![]));
    for (name, bytes) in series() {
        archive.start_file(format!("a/{name}"), zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(&bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A structure set: a square of 20 mm in three planes of 3 mm.
fn structures() -> Vec<u8> {
    use writer::Elements;
    let square = |z: f64| {
        let corners = [[-10.0, -10.0, z], [10.0, -10.0, z], [10.0, 10.0, z], [-10.0, 10.0, z]];
        Elements::default()
            .text(0x3006_0042, "CS", "CLOSED_PLANAR")
            .decimals(0x3006_0050, corners.as_flattened())
    };
    let name = Elements::default().text(0x3006_0022, "IS", "4").text(0x3006_0026, "LO", "Lens");
    let region = Elements::default()
        .text(0x3006_002A, "IS", "255\\0\\0")
        .items(0x3006_0040, [0.0, 3.0, 6.0].map(square).into())
        .text(0x3006_0084, "IS", "4");
    Elements::default()
        .text(0x0008_0016, "UI", "1.2.840.10008.5.1.4.1.1.481.3")
        .text(0x0008_0060, "CS", "RTSTRUCT")
        .items(0x3006_0020, vec![name])
        .items(0x3006_0039, vec![region])
        .file(writer::Syntax::Explicit)
}

/// A header whose data lie in a file beside it.
const NRRD: &str = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 2\nspacings: 1 2 3\nencoding: raw\n\
                    data file: head.raw\n\n";

#[test]
fn files_in_memory_are_read_as_those_of_a_system() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in series() {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let truth = load(folder.path()).unwrap();
    let memory = MemoryFiles::new();
    for (name, bytes) in series() {
        memory.put(Path::new("scan/inner").join(name), bytes);
    }
    memory.put("scan.zip", zipped());
    memory.put("scan/letter.txt", b"no scan".to_vec());
    memory.put("scan.structures/rs.dcm", structures());
    memory.put("head.nhdr", NRRD.as_bytes().to_vec());
    memory.put("head.raw", (0..12).collect::<Vec<u8>>());
    assert!(set_files(Box::new(memory.clone())).is_ok(), "the first files are given");
    assert!(set_files(Box::new(MemoryFiles::new())).is_err(), "there are some already");

    for path in ["scan", "./scan/inner/", "scan.zip"] {
        let found = load(Path::new(path)).unwrap();
        assert_eq!(found.volume.dims(), truth.volume.dims(), "{path}");
        assert_eq!(values(&found.volume), values(&truth.volume), "{path}");
        assert_eq!(found.volume.patient_from_voxel(), truth.volume.patient_from_voxel(), "{path}");
    }
    let told = load(Path::new("scan")).unwrap().report;
    assert_eq!(
        told.skipped.iter().map(|file| file.path.clone()).collect::<Vec<_>>(),
        [PathBuf::from("scan/letter.txt")]
    );
    assert_eq!(
        values(&load(Path::new("head.nhdr")).unwrap().volume),
        (0..12).map(f64::from).collect::<Vec<_>>()
    );
    let (set, options) = (Path::new("scan.structures/rs.dcm"), LabelOptions::default());
    let found = load_labels(set, &options, Progress::SILENT, &CancelToken::new()).unwrap();
    let [lens] = found.labels.labels() else { panic!("a structure is one") };
    assert_eq!((&lens.name[..], lens.color, found.labels.dims()[2]), ("Lens", [1.0, 0.0, 0.0], 3));
    let ml = found.labels.counts()[1] as f64 * found.labels.voxel_mm3() / 1e3;
    assert!((ml - 3.6).abs() < 0.1, "{ml} ml");
    // The system's files are out of reach, and what is not there is named.
    let gone = load(folder.path()).unwrap_err();
    assert!(matches!(&gone, ImportError::Io { path, .. } if path == folder.path()), "{gone}");
    assert!(load(Path::new("none.nii")).unwrap_err().to_string().starts_with("none.nii: "));
    assert!(files::is_dir("scan.structures") && !files::is_dir("scan.struct"));
    assert!(files::is_dir("scan") && !files::is_dir("scan.zip") && files::is_file("scan/../scan.zip"));
    memory.clear();
    assert!(load(Path::new("scan.zip")).is_err());
}
