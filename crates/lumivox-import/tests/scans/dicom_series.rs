//! Folders and archives: which series there are, which is loaded, and what is refused.

use crate::common::{load, load_series, load_written};
use crate::field::{Series, assert_field, heights};
use crate::writer::*;
use lumivox_core::{CancelToken, Progress, glam::DVec3};
use lumivox_import::{ImportError, ImportOptions};

#[test]
fn series_do_not_mix_and_can_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, elements: &Elements| elements.write(&folder.path().join(name), Syntax::Explicit);
    let axial = Series::axial(heights(&[0.0, 2.0, 4.0]));
    let sagittal = Series { row: DVec3::Y, column: -DVec3::Z, ..Series::axial(vec![DVec3::ZERO, DVec3::X]) };
    for k in 0..3 {
        write(&format!("a{k}"), &axial.slice(k));
    }
    for k in 0..2 {
        let slice =
            sagittal.slice(k).text(SERIES_INSTANCE_UID, "UI", "1.2.4").text(SERIES_NUMBER, "IS", "44");
        write(&format!("b{k}"), &slice);
        // In the first series, but seen from the side.
        write(&format!("c{k}"), &sagittal.slice(k));
    }
    write("localizer", &axial.slice(0).text(IMAGE_TYPE, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER"));
    let rgb = axial.slice(0).short(SAMPLES_PER_PIXEL, 3).text(PHOTOMETRIC_INTERPRETATION, "CS", "RGB");
    write("rgb", &rgb);
    std::fs::write(folder.path().join("README.txt"), "not a scan").unwrap();
    std::fs::write(folder.path().join(".DS_Store"), "junk").unwrap();

    let imported = load(folder.path()).unwrap();
    assert_eq!(imported.volume.dims(), [5, 4, 3]);
    let reasons: Vec<_> = imported.report.series.iter().map(|series| series.reason.as_str()).collect();
    assert_eq!(reasons, ["", "fewer voxels", "fewer voxels", "a localizer"]);
    assert_eq!(imported.report.series[0].description, "CT series 7, 3 slices, 5 x 4");
    assert_eq!(imported.report.series[0].files, 3);
    let skipped: Vec<_> = imported.report.skipped.iter().map(|s| s.reason.as_str()).collect();
    assert_eq!(skipped.len(), 2);
    assert!(!format!("{:?}", imported.report).contains("SECRET"));
    for (wanted, id, slices) in [
        ("1.2.4", "1.2.4", 2),
        ("44", "1.2.4", 2),
        ("1.2.3", "1.2.3", 3),
        ("1", "1.2.3", 3),
        ("1.2.3#2", "1.2.3#2", 2),
        ("4", "1.2.3#3", 1),
    ] {
        let imported = load_series(folder.path(), Some(wanted)).unwrap();
        assert_eq!(imported.report.series[imported.report.chosen].id, id, "{wanted}");
        assert_eq!(imported.volume.dims()[2], slices, "{wanted}");
        assert_field(&imported.volume, 0.0);
        // A scene of it opens the same part of the same series.
        let said = imported.volume.source().unwrap().series.clone().unwrap();
        let again = load_series(folder.path(), Some(&said)).unwrap();
        assert_eq!((said.as_str(), again.report.chosen), (id, imported.report.chosen), "{wanted}");
    }
    for gone in ["1.2.3#0", "1.2.3#1x", "1.2.3#4", "#2"] {
        assert!(load_series(folder.path(), Some(gone)).is_err(), "{gone}");
    }
    // Two volumes of one series.
    match load_series(folder.path(), Some("7")).unwrap_err() {
        ImportError::AmbiguousSeries { candidates, .. } => {
            assert!(
                candidates.contains("1 (CT series 7, 3 slices")
                    && candidates.contains("(CT series 7, 2 slices")
            );
            assert!(!candidates.contains("1.2.4"), "{candidates}");
        }
        other => panic!("{other}"),
    }
    match load_series(folder.path(), Some("99")).unwrap_err() {
        ImportError::NoSuchSeries { wanted, available, .. } => {
            assert_eq!(wanted, "99");
            assert!(available.contains("1.2.4"));
        }
        other => panic!("{other}"),
    }
}

#[test]
fn places_in_the_list_count_before_series_numbers() {
    let folder = tempfile::tempdir().unwrap();
    for (series, n, number) in [("a", 3, "2"), ("b", 2, "1")] {
        let places: Vec<f64> = (0..n).map(f64::from).collect();
        let written = Series::axial(heights(&places));
        for k in 0..n as usize {
            let slice = written.slice(k).text(SERIES_NUMBER, "IS", number);
            let slice = slice.text(SERIES_INSTANCE_UID, "UI", &format!("1.2.{n}"));
            slice.write(&folder.path().join(format!("{series}{k}")), Syntax::Explicit);
        }
    }
    for (wanted, slices) in [("1", 3), ("2", 2), (" 2 ", 2), ("1.2.2", 2)] {
        assert_eq!(load_series(folder.path(), Some(wanted)).unwrap().volume.dims()[2], slices, "{wanted}");
    }
}

#[test]
fn scans_come_before_dose_grids_and_unknown_codes_are_not_shown() {
    let folder = tempfile::tempdir().unwrap();
    for (modality, n, uid) in [("RTDOSE", 5, "1.2.5"), ("DOE^JANE", 4, "1.2.6"), ("MR", 3, "1.2.7")] {
        let places: Vec<f64> = (0..n).map(f64::from).collect();
        let series = Series { modality, ..Series::axial(heights(&places)) };
        for k in 0..n as usize {
            let slice = series.slice(k).text(SERIES_INSTANCE_UID, "UI", uid);
            slice.write(&folder.path().join(format!("{uid} {k}")), Syntax::Explicit);
        }
    }
    // A damaged UID may hold anything, too.
    let dose = image("RTDOSE", 1, 1, vec![0]).text(SERIES_INSTANCE_UID, "UI", "DOE^JANE");
    let series = load_written(|path| dose.write(path, Syntax::Explicit)).unwrap().report.series;
    assert_eq!(series[0].id, "image.dcm");
    let series = load(folder.path()).unwrap().report.series;
    let series: Vec<_> = series.iter().map(|series| series.description.as_str()).collect();
    assert_eq!(
        series,
        [
            "MR series 7, 3 slices, 5 x 4",
            "RTDOSE series 7, 5 slices, 5 x 4",
            "other series 7, 4 slices, 5 x 4"
        ]
    );
}

/// A zip archive with one DICOM file, stored as it is.
fn zipped(data: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    zip.start_file("image.dcm", options).unwrap();
    zip.write_all(data).unwrap();
    zip.finish().unwrap().into_inner()
}

#[test]
fn damaged_and_encrypted_archives_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.zip");
    let load = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        load(&path)
    };
    for side in [4u16, 200] {
        let samples: Vec<u16> = (0..side * side).map(|k| 0x5000 + k).collect();
        let archive = zipped(&image("CT", side, side, samples).file(Syntax::Explicit));
        assert_eq!(load(&archive).unwrap().volume.dims(), [side.into(), side.into(), 1]);
        let mut damaged = archive.clone();
        let sample = damaged.windows(4).position(|bytes| bytes == [0x02, 0x50, 0x03, 0x50]).unwrap();
        damaged[sample] ^= 1;
        let error = load(&damaged).unwrap_err();
        assert!(matches!(error, ImportError::Damaged { .. }), "{error}");
        assert!(error.to_string().contains("its checksum is not the one in the archive"), "{error}");
        let mut encrypted = archive;
        let central = encrypted.windows(4).position(|bytes| bytes == b"PK\x01\x02").unwrap();
        encrypted[6] |= 1;
        encrypted[central + 8] |= 1;
        let error = load(&encrypted).unwrap_err();
        assert!(matches!(error, ImportError::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains("encrypted with a password"), "{error}");
    }
}

#[test]
fn a_folder_without_dicom_may_hold_one_other_volume() {
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(load(folder.path()), Err(ImportError::NoSeries { files: 0, .. })));
    std::fs::write(folder.path().join("notes.txt"), "hello").unwrap();
    assert!(load(folder.path()).unwrap_err().to_string().contains("None is of a format"));
    let nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n\n\x01\x02";
    std::fs::write(folder.path().join("volume.nrrd"), nrrd).unwrap();
    assert_eq!(load(folder.path()).unwrap().volume.dims(), [2, 1, 1]);
    std::fs::write(folder.path().join("second.nrrd"), nrrd).unwrap();
    assert!(load(folder.path()).unwrap_err().to_string().contains("2 volumes"));
}

#[test]
fn loading_can_be_cancelled_and_watched() {
    let folder = tempfile::tempdir().unwrap();
    Series::axial(heights(&[0.0, 2.0, 4.0])).write(folder.path());
    let (paths, options) = ([folder.path().to_owned()], ImportOptions::default());
    let cancel = CancelToken::new();
    let seen = std::sync::Mutex::new(Vec::new());
    let watch = |stage, done, total| {
        seen.lock().unwrap().push((stage, done, total));
    };
    lumivox_import::load(&paths, &options, Progress::new(&watch), &cancel).unwrap();
    let seen = seen.into_inner().unwrap();
    assert_eq!(seen.len(), 6);
    assert!(seen.iter().all(|(_, _, total)| *total == 3));
    // Stopped while slices are decoded, and before anything.
    let stop = |stage, _, _| {
        if stage == lumivox_core::WorkStage::Decoding {
            cancel.cancel();
        }
    };
    for _ in 0..2 {
        let result = lumivox_import::load(&paths, &options, Progress::new(&stop), &cancel);
        assert!(matches!(result, Err(ImportError::Cancelled(_))));
    }
}
