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
use lumivox_import::{ImportError, MemoryFiles, files, set_files};

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
    // The system's files are out of reach, and what is not there is named.
    let gone = load(folder.path()).unwrap_err();
    assert!(matches!(&gone, ImportError::Io { path, .. } if path == folder.path()), "{gone}");
    assert!(load(Path::new("none.nii")).unwrap_err().to_string().starts_with("none.nii: "));
    assert!(files::is_dir("scan") && !files::is_dir("scan.zip") && files::is_file("scan/../scan.zip"));
    memory.clear();
    assert!(load(Path::new("scan.zip")).is_err());
}
