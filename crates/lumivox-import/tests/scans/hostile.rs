//! Folders and archives as nobody should make them, and some do.

use std::{fs, path::Path};

use crate::common::load;
use crate::writer::*;
use lumivox_core::{CancelToken, Progress};
use lumivox_import::{ImportError, ImportOptions, ImportReport};

const SOP_INSTANCE_UID: u32 = 0x0008_0018;
const PATIENT_ID: u32 = 0x0010_0020;

fn slice(k: usize) -> Elements {
    image("CT", 2, 1, vec![k as u16, 7])
        .text(SOP_INSTANCE_UID, "UI", &format!("1.2.840.{k}"))
        .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 2.0 * k as f64])
}

fn write_slices(folder: &Path, slices: usize) {
    fs::create_dir_all(folder).unwrap();
    (0..slices).for_each(|k| slice(k).write(&folder.join(k.to_string()), Syntax::Explicit));
}

fn scan(path: &Path) -> ImportReport {
    let options = ImportOptions::default();
    lumivox_import::scan(&[path.to_owned()], &options, Progress::SILENT, &CancelToken::new()).unwrap()
}

/// A zip archive of stored entries: name, content and flags.
fn zip(entries: &[(&str, &[u8], u16)]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, content, flags) in entries {
        let mut crc = flate2::Crc::new();
        crc.update(content);
        let mut common = [20u16, *flags, 0, 0, 0x21].map(u16::to_le_bytes).concat();
        let size = content.len() as u32;
        common.extend([crc.sum(), size, size].map(u32::to_le_bytes).concat());
        common.extend((name.len() as u16).to_le_bytes());
        let start = out.len() as u32;
        out.extend([b"PK\x03\x04", &common[..], &[0, 0], name.as_bytes(), content].concat());
        directory.extend([b"PK\x01\x02\x14\0", &common[..], &[0; 12]].concat());
        directory.extend(start.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let count = (entries.len() as u16).to_le_bytes();
    let (size, start) = ((directory.len() as u32).to_le_bytes(), (out.len() as u32).to_le_bytes());
    out.extend([&directory[..], b"PK\x05\x06\0\0\0\0", &count, &count, &size, &start, &[0, 0]].concat());
    out
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_not_waited_for() {
    use std::os::unix::{ffi::OsStrExt, fs::symlink, net::UnixListener};
    let folder = tempfile::tempdir().unwrap();
    write_slices(folder.path(), 3);
    let pipe = folder.path().join("pipe");
    let name = std::ffi::CString::new(pipe.as_os_str().as_bytes()).unwrap();
    // SAFETY: the name is a C string.
    assert_eq!(unsafe { libc::mkfifo(name.as_ptr(), 0o600) }, 0);
    symlink("/dev/zero", folder.path().join("zero")).unwrap();
    let _socket = UnixListener::bind(folder.path().join("socket")).unwrap();
    assert_eq!(load(folder.path()).unwrap().volume.dims(), [2, 1, 3]);
    for special in [pipe, folder.path().join("zero")] {
        let error = load(&special).unwrap_err().to_string();
        assert!(error.contains("it is not a plain file"), "{error}");
        let paths = [folder.path().join("0"), special];
        let options = ImportOptions::default();
        assert!(lumivox_import::load(&paths, &options, Progress::SILENT, &CancelToken::new()).is_err());
    }
    // Nor where a header calls for one.
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: pipe\n";
    fs::write(folder.path().join("a.nhdr"), header).unwrap();
    let error = load(&folder.path().join("a.nhdr")).unwrap_err().to_string();
    assert!(error.contains("not in a plain file"), "{error}");
}

#[cfg(unix)]
#[test]
fn what_may_not_be_read_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    write_slices(folder.path(), 3);
    let closed = folder.path().join("closed");
    write_slices(&closed, 4);
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o000)).unwrap();
    fs::set_permissions(folder.path().join("2"), fs::Permissions::from_mode(0o000)).unwrap();
    // Nothing is closed to the system's administrator.
    let slices = if fs::read_dir(&closed).is_ok() { 4 } else { 2 };
    let imported = load(folder.path()).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o700)).unwrap();
    assert_eq!(imported.volume.dims()[2], slices);
    let named = |path: &str| imported.report.skipped.iter().any(|file| file.path.ends_with(path));
    if slices == 2 {
        assert!(named("closed") && named("2"), "{:?}", imported.report.skipped);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_whose_listing_breaks_off_is_named() {
    let folder = tempfile::tempdir().unwrap();
    write_slices(folder.path(), 3);
    // Opens for its owner, but lists nothing without more rights; the system may close or open it altogether, too.
    let listed = Path::new("/proc/1/map_files");
    std::os::unix::fs::symlink(listed, folder.path().join("broken")).unwrap();
    let imported = load(folder.path()).unwrap();
    assert_eq!(imported.volume.dims(), [2, 1, 3]);
    let is_closed = fs::read_dir(listed).and_then(|mut entries| entries.next().transpose()).is_err();
    let is_named = imported.report.skipped.iter().any(|file| file.path.ends_with("broken"));
    assert_eq!(is_named, is_closed, "{:?}", imported.report.skipped);
}

/// Longer than Windows' paths were for long, by itself and from above. Wine cannot say where such a folder really is.
#[test]
fn a_scan_in_a_long_path_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let long: std::path::PathBuf = ["l", "o", "n"].map(|letter| letter.repeat(100)).iter().collect();
    write_slices(&folder.path().join(&long), 3);
    for path in [folder.path().to_owned(), folder.path().join(long)] {
        assert_eq!(load(&path).unwrap().volume.dims(), [2, 1, 3]);
    }
}

#[test]
fn a_tree_that_is_too_deep_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let deep: std::path::PathBuf = (0..35).map(|k| format!("d{k}")).collect();
    write_slices(&folder.path().join(&deep), 3);
    // All of it lies there: the error says where to look.
    let error = load(folder.path()).unwrap_err().to_string();
    assert!(error.contains("more than 32 folders deep") && error.contains("Open it by itself"), "{error}");
    assert_eq!(load(&folder.path().join("d0/d1/d2/d3/d4")).unwrap().volume.dims(), [2, 1, 3]);
    write_slices(folder.path(), 4);
    let imported = load(folder.path()).unwrap();
    assert_eq!(imported.volume.dims(), [2, 1, 4]);
    assert!(imported.report.skipped.iter().any(|file| file.reason.contains("32 folders deep")));
}

#[test]
fn archives_are_read_whatever_their_names_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.zip");
    let files: Vec<Vec<u8>> = (0..5).map(|k| slice(k).file(Syntax::Explicit)).collect();
    let outside = folder.path().join("outside");
    let names = ["./0", "../../../1", outside.to_str().unwrap(), "C:\\3", "a/./b/../4"];
    let entries: Vec<_> = names.iter().zip(&files).map(|(name, file)| (*name, &file[..], 0)).collect();
    fs::write(&path, zip(&entries)).unwrap();
    let imported = load(&path).unwrap();
    assert_eq!(imported.volume.dims(), [2, 1, 5]);
    assert_eq!((fs::read_dir(folder.path()).unwrap().count(), outside.exists()), (1, false));

    // What is no slice is named for what it is.
    let inner = zip(&[("x", b"x", 0)]);
    let entries = [
        ("0", &files[0][..], 0),
        ("1", &files[1], 0),
        ("1", &files[2], 0),
        ("inner.zip", &inner, 0),
        ("scan.nrrd", b"NRRD0004\n", 0),
        ("scan.nii.gz", b"\x1f\x8b\x08\0", 0),
        ("secret", &files[3], 1),
        ("note.txt", b"hello", 0),
    ];
    fs::write(&path, zip(&entries)).unwrap();
    let report = scan(&path);
    assert_eq!(report.series[0].files, 2);
    let reason = |name: &str| {
        let file = report.skipped.iter().find(|file| file.path.ends_with(name));
        file.unwrap_or_else(|| panic!("{name} is not named: {:?}", report.skipped)).reason.as_str()
    };
    assert_eq!(reason("a.zip"), "1 entries of the archive have the names of others");
    assert_eq!(reason("inner.zip"), "it is a zip archive within the archive; unpack it");
    assert_eq!(reason("scan.nrrd"), "it is a NRRD file in an archive; unpack it");
    assert_eq!(reason("scan.nii.gz"), "it is a gzip archive within the archive; unpack it");
    assert_eq!(reason("secret"), "encrypted with a password");
    assert_eq!(reason("note.txt"), "it is not a DICOM file");

    fs::write(&path, zip(&[])).unwrap();
    let error = load(&path).unwrap_err();
    assert!(matches!(error, ImportError::NoSeries { files: 0, .. }), "{error}");
    fs::write(&path, zip(&[("inner.zip", &inner, 0)])).unwrap();
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("a zip archive within the archive"), "{error}");
}

#[test]
fn a_damaged_scan_is_named_before_what_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let (inner, whole) = (folder.path().join("a"), slice(0).file(Syntax::Explicit));
    fs::create_dir(&inner).unwrap();
    (0..4).for_each(|k| fs::write(folder.path().join(format!("note {k}")), "hello").unwrap());
    for (cut, reason) in [(200, "bytes left for element"), (whole.len() - 2, "cut short: 2 of 4 bytes")] {
        fs::write(inner.join("scan"), &whole[..cut]).unwrap();
        let error = load(folder.path()).unwrap_err().to_string();
        let name = Path::new("a").join("scan");
        let words = format!("'{}' was left out: ", name.display());
        assert!(error.contains(&words) && error.contains(reason), "{error}");
        assert!(!error.contains("other DICOM"), "{error}");
    }
    fs::write(inner.join("second"), &whole[..150]).unwrap();
    let error = load(folder.path()).unwrap_err().to_string();
    assert!(error.contains("another DICOM file was left out, too"), "{error}");
}

#[test]
fn no_error_speaks_of_a_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.raw");
    for content in [&b"hello"[..], b"\x01\x02\x03\xff\xfe", &[0; 40], b""] {
        fs::write(&path, content).unwrap();
        let error = load(&path).unwrap_err().to_string();
        assert!(!error.contains("lumivox ") && !error.contains(" --"), "{error}");
    }
}

#[test]
fn two_patients_make_two_series() {
    let folder = tempfile::tempdir().unwrap();
    for k in 0..10 {
        slice(k % 5)
            .text(PATIENT_ID, "LO", ["A", "B"][k / 5])
            .text(SOP_INSTANCE_UID, "UI", &format!("1.2.{k}"))
            .write(&folder.path().join(k.to_string()), Syntax::Explicit);
    }
    let shape = |report: &ImportReport| -> Vec<(usize, usize)> {
        report.series.iter().map(|series| (series.dims[2], series.phases)).collect()
    };
    assert_eq!(shape(&scan(folder.path())), [(5, 1), (5, 1)]);
    // A patient for each file is an anonymizer's mistake.
    let folder = tempfile::tempdir().unwrap();
    for k in 0..5 {
        slice(k)
            .text(PATIENT_ID, "LO", &format!("anonymous {k}"))
            .write(&folder.path().join(k.to_string()), Syntax::Explicit);
    }
    assert_eq!(shape(&scan(folder.path())), [(5, 1)]);
}

#[test]
fn zeros_behind_the_prefix_are_no_elements() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb");
    // As elements, of no length each, a bomb of them would take minutes; what follows them is not looked at.
    let whole = slice(0).file(Syntax::Explicit);
    let head = whole.windows(4).position(|bytes| bytes == [8, 0, 0x16, 0]).unwrap();
    for (zeros, loads) in [(0, true), (8, false), (1 << 20, false)] {
        fs::write(&path, [&whole[..head], &vec![0; zeros], &whole[head..]].concat()).unwrap();
        match load(&path) {
            Ok(_) => assert!(loads),
            Err(error) => assert!(!loads && error.to_string().contains("it holds no image"), "{error}"),
        }
    }
}

#[test]
fn impossible_numbers_are_refused_in_few_words() {
    let with = |tag, vr, text: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        slice(0).text(tag, vr, text).write(&path, Syntax::Explicit);
        load(&path).unwrap_err().to_string()
    };
    for (tag, vr, text, words) in [
        (RESCALE_SLOPE, "DS", "1e300", "is 1e300, beyond"),
        (RESCALE_INTERCEPT, "DS", "-1e300", "is -1e300, beyond"),
        (RESCALE_SLOPE, "DS", "NaN", "RescaleSlope (0028,1053) is not a number"),
        (PIXEL_SPACING, "DS", "nan\\1", "PixelSpacing (0028,0030) is not a number"),
        (PIXEL_SPACING, "DS", "0\\1", "is 0\\1, not two positive lengths"),
        (IMAGE_ORIENTATION_PATIENT, "DS", "0\\0\\0\\0\\0\\0", "a direction of no length"),
        (IMAGE_ORIENTATION_PATIENT, "DS", "1\\0\\0\\1\\0\\0", "not perpendicular"),
        (NUMBER_OF_FRAMES, "IS", "2147483648", "not a number from 1 to"),
        (NUMBER_OF_FRAMES, "IS", "-1", "not a number from 1 to"),
    ] {
        let error = with(tag, vr, text);
        assert!(error.contains(words) && error.len() < 400, "{error}");
    }
}
