//! Which files a header may name as its data: those beside it or below it, unless more is allowed.

use std::{fs, path::Path};

use lumivox_core::{CancelToken, Progress};
use lumivox_import::{ImportError, ImportOptions, Imported};

fn load(path: &Path, allow: bool) -> Result<Imported, ImportError> {
    let mut options = ImportOptions::default();
    options.allow_outside_data = allow;
    lumivox_import::load(&[path.to_owned()], &options, Progress::SILENT, &CancelToken::new())
}

/// A header of each format, of one slice of 2 x 2 bytes in the file `name`.
fn headers(name: &str) -> [(&'static str, String); 4] {
    let meta = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 1\nElementType = MET_UCHAR\nElementDataFile = ";
    let nrrd =
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 1\nspacings: 1 1 1\nencoding: raw\ndata file: ";
    [
        ("a.mhd", format!("{meta}{name}\n")),
        ("list.mhd", format!("{meta}LIST\n{name}\n")),
        ("a.nhdr", format!("{nrrd}{name}\n")),
        ("list.nhdr", format!("{nrrd}LIST\n{name}\n")),
    ]
}

#[test]
fn a_header_names_no_file_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let scan = folder.path().join("scan");
    fs::create_dir_all(scan.join("data")).unwrap();
    fs::write(folder.path().join("private"), [1, 2, 3, 4]).unwrap();
    for inside in ["beside.raw", "data/below.raw"] {
        fs::write(scan.join(inside), [1, 2, 3, 4]).unwrap();
        for (header, text) in headers(inside) {
            fs::write(scan.join(header), text).unwrap();
            load(&scan.join(header), false).unwrap_or_else(|error| panic!("{inside}: {error}"));
        }
    }
    let absolute = folder.path().join("private");
    let mut outside = vec!["../private".to_owned(), "data/../../private".to_owned()];
    outside.push(absolute.display().to_string());
    // A link beside the header, and one of a folder.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&absolute, scan.join("link")).unwrap();
        std::os::unix::fs::symlink(folder.path(), scan.join("folder")).unwrap();
        outside.extend(["link".to_owned(), "folder/private".to_owned()]);
    }
    for name in &outside {
        for (header, text) in headers(name) {
            fs::write(scan.join(header), text).unwrap();
            let error = load(&scan.join(header), false).unwrap_err().to_string();
            assert!(error.contains("does not lie beside the header or below it"), "{name}: {error}");
            for way in
                ["--allow-outside-data", "allow_outside_data", "'Allow data outside the scan's folder'"]
            {
                assert!(error.contains(way), "{error}");
            }
            assert_eq!(load(&scan.join(header), true).unwrap().volume.dims(), [2, 2, 1], "{name}");
        }
    }
    // Another computer would be asked for these, which may tell it who asks.
    for name in [r"\\server\share\private", "//server/share/private", r"C:\private", r"..\private"] {
        for (header, text) in headers(name) {
            fs::write(scan.join(header), text).unwrap();
            let error = load(&scan.join(header), false).unwrap_err().to_string();
            assert!(error.contains("does not lie beside the header or below it"), "{name}: {error}");
        }
    }
}
