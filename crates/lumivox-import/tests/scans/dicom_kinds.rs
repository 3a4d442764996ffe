//! What DICOM objects mean beyond a stack of grey slices: phases, labels, doses, tables, odd samples. Uptake values are in
//! `dicom_uptake.rs`.

use std::path::Path;

use crate::common::{load, load_written, values};
use crate::writer::*;
use lumivox_core::{CancelToken, Modality, Progress, glam::DVec3};
use lumivox_import::{ImportError, ImportOptions, Imported, Study};

const TRIGGER_TIME: u32 = 0x0018_1060;
const ECHO_NUMBERS: u32 = 0x0018_0086;
const TEMPORAL_POSITION_IDENTIFIER: u32 = 0x0020_0100;
const ACQUISITION_NUMBER: u32 = 0x0020_0012;
const SOP_CLASS_UID: u32 = 0x0008_0016;
const SOP_INSTANCE_UID: u32 = 0x0008_0018;

fn load_one(elements: &Elements) -> Result<Imported, ImportError> {
    load_written(|path| elements.write(path, Syntax::Explicit))
}

fn load_phase(folder: &Path, phase: usize) -> Result<Imported, ImportError> {
    let mut options = ImportOptions::default();
    options.phase = Some(phase);
    lumivox_import::load(&[folder.to_owned()], &options, Progress::SILENT, &CancelToken::new())
}

/// Writes `phases` x `slices` images; the samples tell phase and slice. `tell` marks the phase.
fn write_phases(
    folder: &Path,
    phases: usize,
    slices: usize,
    tell: impl Fn(Elements, usize, usize) -> Elements,
) {
    for phase in 0..phases {
        for slice in 0..slices {
            let image = image("MR", 2, 1, vec![phase as u16, slice as u16])
                .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 2.0 * slice as f64])
                // Counting the other way round, as nothing forbids.
                .text(INSTANCE_NUMBER, "IS", &(1000 - phase - 10 * slice).to_string());
            tell(image, phase, slice).write(&folder.join(format!("{slice} {phase}")), Syntax::Explicit);
        }
    }
}

#[test]
fn phases_are_volumes_of_their_own() {
    type Tell = fn(Elements, usize, usize) -> Elements;
    let ways: [(&str, Tell); 10] = [
        ("temporal position", |e, phase, _| {
            e.text(TEMPORAL_POSITION_IDENTIFIER, "IS", &(phase + 1).to_string())
        }),
        // Not quite the same in every slice.
        ("trigger time", |e, phase, slice| {
            e.decimals(TRIGGER_TIME, &[40.0 * phase as f64 + 0.1 * slice as f64])
        }),
        ("echo", |e, phase, _| e.text(ECHO_NUMBERS, "IS", &(phase + 1).to_string())),
        ("acquisition", |e, phase, _| e.text(ACQUISITION_NUMBER, "IS", &(phase + 1).to_string())),
        // Siemens' own element, before there was a public one.
        ("b-value", |e, phase, _| {
            let e = e.text(0x0019_0010, "LO", "SIEMENS MR HEADER");
            e.text(0x0019_100C, "IS", &(500 * phase).to_string())
        }),
        // Another's block lies before it.
        ("b-value", |e, phase, _| {
            let e = e.text(0x0019_0010, "LO", "SIEMENS MR HEADEX").text(0x0019_100C, "IS", "7");
            let e = e.text(0x0019_0021, "LO", "SIEMENS MR HEADER");
            e.text(0x0019_210C, "IS", &(500 * phase).to_string())
        }),
        // GE's own, of which some have 1e9 added.
        ("b-value", |e, phase, slice| {
            let e = e.text(0x0043_0010, "LO", "GEMS_PARM_01");
            let b = 500 * phase + if slice % 2 == 0 { 1_000_000_000 } else { 0 };
            e.text(0x0043_1039, "IS", &format!("{b}\\8\\0\\0"))
        }),
        ("b-value", |e, phase, _| {
            let e = e.text(0x0043_00C3, "LO", "GEMS_PARM_01");
            e.text(0x0043_C339, "IS", &(500 * phase).to_string())
        }),
        ("b-value", |mut e, phase, _| {
            e.set(0x2001_1103, "FL", Value::Raw(4, (500.0 * phase as f32).to_le_bytes().to_vec()));
            e.text(0x2001_0011, "LO", "Philips Imaging DD 001")
        }),
        ("b-value", |mut e, phase, _| {
            // The public one counts.
            e = e.text(0x0043_0010, "LO", "GEMS_PARM_01").text(0x0043_1039, "IS", "5\\8\\0\\0");
            e.set(0x0018_9087, "FD", Value::Raw(8, (500.0 * phase as f64).to_le_bytes().to_vec()));
            e
        }),
    ];
    for (name, tell) in ways {
        let folder = tempfile::tempdir().unwrap();
        write_phases(folder.path(), 3, 4, tell);
        let mut study = Study::open(
            &[folder.path().into()],
            &ImportOptions::default(),
            Progress::SILENT,
            &CancelToken::new(),
        )
        .unwrap();
        let series = &study.report().series;
        assert_eq!(series.len(), 1, "{name}: {series:?}");
        assert_eq!((series[0].phases, series[0].dims, series[0].files), (3, [2, 1, 4], 12), "{name}");
        assert!(
            series[0].notes.contains(&format!("3 phases, told apart by {name}")),
            "{:?}",
            series[0].notes
        );
        let first = study.load(&ImportOptions::default(), Progress::SILENT, &CancelToken::new()).unwrap();
        assert_eq!(values(&first.volume), [0.0, 0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 3.0], "{name}");
        for phase in 1..=3 {
            let volume = load_phase(folder.path(), phase).unwrap().volume;
            let expected = (phase - 1) as f64;
            assert_eq!(
                values(&volume),
                [expected, 0.0, expected, 1.0, expected, 2.0, expected, 3.0],
                "{name}"
            );
        }
        let error = load_phase(folder.path(), 4).unwrap_err();
        assert!(matches!(error, ImportError::NoSuchPhase { wanted: 4, phases: 3, .. }), "{error}");
    }
}

#[test]
fn interleaved_acquisitions_are_one_volume_and_copies_count_once() {
    let folder = tempfile::tempdir().unwrap();
    write_phases(folder.path(), 1, 6, |e, _, slice| {
        e.text(ACQUISITION_NUMBER, "IS", &(slice % 2).to_string()).text(
            SOP_INSTANCE_UID,
            "UI",
            &format!("1.2.840.{slice}"),
        )
    });
    std::fs::copy(folder.path().join("3 0"), folder.path().join("copy of 3")).unwrap();
    let imported = load(folder.path()).unwrap();
    assert_eq!(imported.volume.dims(), [2, 1, 6]);
    assert_eq!(imported.report.series[0].phases, 1);
    assert!(imported.report.skipped[0].reason.starts_with("a copy of another file"));
    // One UID for all is an anonymizer's mistake, no reason to drop slices.
    let folder = tempfile::tempdir().unwrap();
    write_phases(folder.path(), 1, 6, |e, _, _| e.text(SOP_INSTANCE_UID, "UI", "1.2.840.1"));
    assert_eq!(load(folder.path()).unwrap().volume.dims(), [2, 1, 6]);
}

#[test]
fn kernels_make_volumes_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    write_phases(folder.path(), 2, 3, |e, kernel, _| e.text(0x0018_1210, "SH", ["B30f", "B70f"][kernel]));
    let report = load(folder.path()).unwrap().report;
    assert_eq!(report.series.iter().map(|s| (s.dims[2], s.phases)).collect::<Vec<_>>(), [(3, 1), (3, 1)]);
}

/// A segmentation of 4 x 2 pixels: frames of (segment, height, samples).
fn segmentation(kind: &str, frames: &[(u16, f64, [u8; 8])]) -> Elements {
    let group = |&(segment, z, _): &(u16, f64, [u8; 8])| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[1.0, 2.0, z]);
        let which = Elements::default().short(0x0062_000B, segment);
        Elements::default().items(0x0020_9113, vec![place]).items(0x0062_000A, vec![which])
    };
    let mut numbers: Vec<u16> = frames.iter().map(|frame| frame.0).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let describe =
        |&n: &u16| Elements::default().short(0x0062_0004, n).text(0x0062_0005, "LO", &format!("part {n}"));
    let measures =
        Elements::default().decimals(PIXEL_SPACING, &[1.0, 1.0]).decimals(SPACING_BETWEEN_SLICES, &[2.0]);
    let orientation =
        Elements::default().decimals(IMAGE_ORIENTATION_PATIENT, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let shared = Elements::default().items(0x0020_9116, vec![orientation]).items(0x0028_9110, vec![measures]);
    let bits = if kind == "BINARY" { 1 } else { 8 };
    let mut seg = image("SEG", 4, 2, vec![])
        .without(IMAGE_POSITION_PATIENT)
        .without(IMAGE_ORIENTATION_PATIENT)
        .without(PIXEL_SPACING)
        .text(SOP_CLASS_UID, "UI", "1.2.840.10008.5.1.4.1.1.66.4")
        .text(0x0062_0001, "CS", kind)
        .short(BITS_ALLOCATED, bits)
        .short(BITS_STORED, bits)
        .short(HIGH_BIT, bits - 1)
        .short(0x0062_000E, 200)
        .text(NUMBER_OF_FRAMES, "IS", &frames.len().to_string())
        .items(0x0062_0002, numbers.iter().map(describe).collect())
        .items(0x5200_9229, vec![shared])
        .items(0x5200_9230, frames.iter().map(group).collect());
    let samples: Vec<u8> = frames.iter().flat_map(|frame| frame.2).collect();
    let bytes = match kind {
        "BINARY" => samples.chunks(8).map(|b| (0..8).map(|i| b[i] << i).sum()).collect(),
        _ => samples,
    };
    seg.set(PIXEL_DATA, "OB", Value::Bytes(bytes));
    seg
}

#[test]
fn binary_segments_become_labels_in_place() {
    // Two segments at 10 mm, one at 16 mm; nothing between them, and the file begins with the upper one.
    let seg = segmentation(
        "BINARY",
        &[
            (1, 16.0, [0, 0, 0, 0, 1, 1, 0, 0]),
            (1, 10.0, [1, 1, 0, 0, 0, 0, 0, 0]),
            (3, 10.0, [0, 1, 1, 0, 0, 0, 0, 1]),
        ],
    );
    let imported = load_one(&seg).unwrap();
    let volume = &imported.volume;
    assert_eq!((volume.dims(), volume.modality()), ([4, 2, 4], Modality::Other));
    assert_eq!(volume.patient_from_voxel().translation, DVec3::new(1.0, 2.0, 10.0));
    assert_eq!(volume.spacing_mm(), DVec3::new(1.0, 1.0, 2.0));
    let mut expected = vec![1.0, 3.0, 3.0, 0.0, 0.0, 0.0, 0.0, 3.0];
    expected.extend([0.0; 16]);
    expected.extend([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
    assert_eq!(values(volume), expected);
    let notes = imported.report.notes.join("; ");
    for words in [
        "values are numbers of segments",
        "1 part 1, 3 part 3",
        "2 of 4 slices hold no segment",
        "1 voxels belong",
    ] {
        assert!(notes.contains(words), "'{words}' is missing: {notes}");
    }
    assert_eq!(imported.report.series[0].dims, [4, 2, 4]);
}

#[test]
fn labels_that_reach_into_other_elements_are_not_told() {
    let label = |label: &str| {
        let label = if label.len() % 2 == 1 { format!("{label} ") } else { label.to_owned() };
        let mut segment = Elements::default().short(0x0062_0004, 1);
        segment.set(0x0062_0005, "LO", Value::Raw(label.len() as u32, label.as_bytes().to_vec()));
        let seg = segmentation("BINARY", &[(1, 0.0, [1; 8]), (1, 2.0, [1; 8])]);
        load_one(&seg.items(0x0062_0002, vec![segment])).unwrap().report.notes.join("; ")
    };
    assert!(label("left kidney\0").contains("segments: 1 left kidney"));
    let long = format!("a{}SECRET^NAME ", " ".repeat(60));
    for wrong in ["a\0\x10\0\x10\0SECRET^NAME", &long] {
        let notes = label(wrong);
        assert!(!notes.contains("SECRET") && !notes.contains("segments:"), "{notes}");
    }
}

#[test]
fn labels_that_name_the_patient_are_not_told() {
    let notes = |labels: [&str; 2]| {
        let segment = |(k, label): (usize, &&str)| {
            Elements::default().short(0x0062_0004, k as u16 + 1).text(0x0062_0005, "LO", label)
        };
        let seg = segmentation("BINARY", &[(1, 0.0, [1; 8]), (2, 2.0, [1; 8])])
            .text(PATIENT_NAME, "PN", "MILLER^JANE")
            .text(0x0010_0020, "LO", "AB-123");
        let seg = seg.items(0x0062_0002, labels.iter().enumerate().map(segment).collect());
        load_one(&seg).unwrap().report.notes
    };
    for name in ["MILLER^JANE", "miller", "AB-123", "AB123", "Jane's"] {
        let notes = notes([name, "spleen"]);
        assert!(notes.contains(&"segments: 1, 2 spleen".to_owned()), "{name}: {notes:?}");
    }
    let found = notes(["Miller left kidney", "vertebrae_L5 rechte Niere"]);
    assert!(found.contains(&"segments: 1 left kidney, 2 vertebrae_L5 rechte Niere".to_owned()), "{found:?}");
}

#[test]
fn frame_types_are_told_where_they_are_coded_words() {
    let description = |frame_type: &str| {
        let kind = Elements::default().text(0x0008_9007, "CS", frame_type);
        let shared = Elements::default().items(0x0018_9226, vec![kind]);
        let report =
            load_one(&image("MR", 2, 1, vec![0, 1]).items(0x5200_9229, vec![shared])).unwrap().report;
        report.series[0].description.clone()
    };
    assert!(description("ORIGINAL\\PRIMARY\\DIFFUSION\\NONE").ends_with("2 x 1, diffusion"));
    // The magnitude is what an image is anyway; letters are parts of complex images.
    assert!(description("ORIGINAL\\PRIMARY\\M\\NONE").ends_with("2 x 1"));
    assert!(description("ORIGINAL\\PRIMARY\\P\\PHASE").ends_with("2 x 1, phase"));
    for wrong in ["ORIGINAL\\PRIMARY\\SECRET^NAME", "ORIGINAL\\Secret", "ORIGINAL\\A VERY LONG SECRET"] {
        assert!(description(wrong).ends_with("2 x 1"), "{}", description(wrong));
    }
}

#[test]
fn fractions_stay_fractions_where_there_is_one_segment() {
    let one = segmentation("FRACTIONAL", &[(1, 0.0, [0, 50, 100, 200, 0, 0, 0, 0])]);
    let volume = load_one(&one).unwrap().volume;
    assert_eq!(values(&volume)[..4], [0.0, 0.25, 0.5, 1.0]);
    let two = segmentation(
        "FRACTIONAL",
        &[(1, 0.0, [0, 50, 100, 200, 0, 0, 0, 0]), (2, 0.0, [99, 150, 120, 0, 0, 0, 0, 0])],
    );
    assert_eq!(values(&load_one(&two).unwrap().volume)[..4], [0.0, 2.0, 2.0, 1.0]);
    // As of binary ones the smallest is kept where several fill at least half; of equal ones the highest number.
    let overlapping = segmentation(
        "FRACTIONAL",
        &[(1, 0.0, [0, 200, 100, 200, 0, 0, 0, 0]), (2, 0.0, [99, 150, 100, 99, 0, 0, 0, 0])],
    );
    let imported = load_one(&overlapping).unwrap();
    assert_eq!(values(&imported.volume)[..4], [0.0, 2.0, 2.0, 1.0]);
    let notes = imported.report.notes.join("; ");
    assert!(notes.contains("2 voxels belong to several segments"), "{notes}");
}

#[test]
fn labels_come_after_scans_and_have_pictures() {
    let folder = tempfile::tempdir().unwrap();
    segmentation("BINARY", &[(1, 0.0, [1; 8]), (1, 2.0, [1; 8]), (1, 4.0, [1; 8])])
        .text(SERIES_INSTANCE_UID, "UI", "1.2.9")
        .write(&folder.path().join("seg"), Syntax::Explicit);
    write_phases(folder.path(), 1, 2, |e, _, _| e);
    let study = Study::open(
        &[folder.path().into()],
        &ImportOptions::default(),
        Progress::SILENT,
        &CancelToken::new(),
    )
    .unwrap();
    let series: Vec<_> =
        study.report().series.iter().map(|s| (s.modality.as_str(), s.reason.as_str())).collect();
    assert_eq!(series, [("MR", ""), ("SEG", "a segmentation")]);
    let picture = study.thumbnail(1, 64, &CancelToken::new()).unwrap();
    assert_eq!((picture.width, picture.height, picture.grey.len()), (4, 2, 8));
}

#[test]
fn labels_lie_on_the_voxels_of_their_series() {
    let folder = tempfile::tempdir().unwrap();
    // Ten slices of 6 x 5 pixels; labels are 4 x 2 pixels of two of them, from pixel (1, 2) on.
    let places: Vec<f64> = (0..10).map(|k| 4.0 + 2.0 * f64::from(k)).collect();
    for &z in &places {
        let samples: Vec<u16> = (0..30).map(|i| i + 100 * z as u16).collect();
        image("CT", 6, 5, samples)
            .text(SERIES_INSTANCE_UID, "UI", "1.2.7")
            .decimals(PIXEL_SPACING, &[1.0, 1.0])
            .decimals(IMAGE_ORIENTATION_PATIENT, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0])
            .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, z])
            .write(&folder.path().join(format!("ct {z}")), Syntax::Explicit);
    }
    let reference = Elements::default().text(SERIES_INSTANCE_UID, "UI", "1.2.7");
    let seg =
        segmentation("BINARY", &[(2, 16.0, [0, 0, 0, 0, 1, 1, 0, 0]), (5, 10.0, [1, 0, 0, 1, 0, 0, 0, 0])])
            .text(SERIES_INSTANCE_UID, "UI", "1.2.9")
            .items(0x0008_1115, vec![reference]);
    seg.write(&folder.path().join("seg"), Syntax::Explicit);

    let ct = load(folder.path()).unwrap().volume;
    let mut options = ImportOptions::default();
    options.series = Some("2".to_owned());
    let paths = [folder.path().to_owned()];
    let load_labels =
        || lumivox_import::load(&paths, &options, Progress::SILENT, &CancelToken::new()).unwrap();
    let labels = load_labels();
    assert_eq!(labels.volume.dims(), ct.dims());
    assert_eq!(labels.volume.patient_from_voxel(), ct.patient_from_voxel());
    let mut expected = vec![0.0; 300];
    let at = |x: usize, y: usize, z: usize| (z * 5 + y) * 6 + x;
    for (x, y, z, label) in [(1, 3, 6, 2.0), (2, 3, 6, 2.0), (1, 2, 3, 5.0), (4, 2, 3, 5.0)] {
        expected[at(x, y, z)] = label;
    }
    assert_eq!(values(&labels.volume), expected);
    let listed = &labels.report.series[1];
    assert_eq!((listed.segments_series, listed.dims, listed.bytes), (Some(0), [6, 5, 10], 600));
    // Of the segmentations of a folder the first is taken, and the others are named.
    let others = folder.path().join("seg 2");
    seg.text(SERIES_INSTANCE_UID, "UI", "1.2.10").write(&others, Syntax::Explicit);
    let all = lumivox_import::load_labels(
        folder.path(),
        &Default::default(),
        Progress::SILENT,
        &CancelToken::new(),
    );
    let told = all.unwrap().report.notes.join("; ");
    assert!(told.contains("the first of several segmentations; name the file of another"), "{told}");
    std::fs::remove_file(others).unwrap();
    let note = "made on series 1; its voxels are those of that series".to_owned();
    assert!(listed.notes.contains(&note) && labels.report.notes.contains(&note), "{:?}", labels.report);

    // Half a pixel beside the series, labels keep their own grid.
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().unwrap().to_string_lossy().starts_with("ct") {
            std::fs::remove_file(path).unwrap();
        }
    }
    for &z in &places {
        image("CT", 6, 5, vec![0; 30])
            .text(SERIES_INSTANCE_UID, "UI", "1.2.7")
            .decimals(PIXEL_SPACING, &[1.0, 1.0])
            .decimals(IMAGE_POSITION_PATIENT, &[0.5, 0.0, z])
            .write(&folder.path().join(format!("ct {z}")), Syntax::Explicit);
    }
    let labels = load_labels();
    assert_eq!(labels.volume.dims(), [4, 2, 4]);
    assert!(labels.report.notes.iter().any(|note| note.contains("a grid of its own")), "{:?}", labels.report);
}

#[test]
fn single_bits_are_read_across_bytes() {
    let mut image = image("OT", 3, 1, vec![])
        .short(BITS_ALLOCATED, 1)
        .short(BITS_STORED, 1)
        .short(HIGH_BIT, 0)
        .text(NUMBER_OF_FRAMES, "IS", "3");
    image.set(PIXEL_DATA, "OB", Value::Bytes(vec![0b0101_0101, 0b1]));
    assert_eq!(values(&load_one(&image).unwrap().volume), [1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
    image.set(PIXEL_DATA, "OB", Value::Raw(2, vec![0b0101_0101]));
    let cut = load_one(&image).unwrap();
    assert!(cut.report.notes.iter().any(|note| note.contains("2 of 3 frames")), "{:?}", cut.report.notes);
}

#[test]
fn samples_of_twelve_bits_are_read_across_bytes() {
    // Frames of three samples, the second of which begins within a byte.
    let samples = [0x123u16, 0xABC, 0xFFF, 0x001, 0x800, 0x7FE];
    let bits = samples.iter().flat_map(|sample| (0..12).map(move |bit| (sample >> bit & 1) as u8));
    let bits: Vec<u8> = bits.collect();
    let packed: Vec<u8> =
        bits.chunks(8).map(|b| b.iter().enumerate().map(|(i, bit)| bit << i).sum()).collect();
    assert_eq!(packed[..3], [0x23, 0xC1, 0xAB]);
    let mut image = image("CT", 3, 1, vec![])
        .short(BITS_ALLOCATED, 12)
        .short(BITS_STORED, 12)
        .short(HIGH_BIT, 11)
        .text(NUMBER_OF_FRAMES, "IS", "2");
    image.set(PIXEL_DATA, "OW", Value::Bytes(packed.clone()));
    let expected: Vec<f64> = samples.iter().map(|&sample| sample.into()).collect();
    assert_eq!(values(&load_one(&image).unwrap().volume), expected);
    let signed = image.clone().short(PIXEL_REPRESENTATION, 1);
    let expected: Vec<f64> = samples.iter().map(|&sample| f64::from((sample << 4) as i16 >> 4)).collect();
    assert_eq!(values(&load_one(&signed).unwrap().volume), expected);
    image.set(PIXEL_DATA, "OW", Value::Raw(8, packed[..8].to_vec()));
    let cut = load_one(&image).unwrap();
    assert!(cut.report.notes.iter().any(|note| note.contains("1 of 2 frames")), "{:?}", cut.report.notes);
}

#[test]
fn tables_give_values() {
    let table = |first: i16| {
        let mut item = Elements::default();
        item.set(
            0x0028_3002,
            "US",
            Value::Raw(6, [3u16, first as u16, 16].iter().flat_map(|w| w.to_le_bytes()).collect()),
        );
        item.set(
            0x0028_3006,
            "US",
            Value::Raw(6, [100u16, 300, 40_000].iter().flat_map(|w| w.to_le_bytes()).collect()),
        );
        item
    };
    let with = |item| image("XA", 5, 1, vec![0, 10, 11, 12, 500]).items(0x0028_3000, vec![item]);
    let imported = load_one(&with(table(10))).unwrap();
    assert_eq!(values(&imported.volume), [100.0, 100.0, 300.0, 40_000.0, 40_000.0]);
    assert!(imported.report.notes[0].contains("ModalityLUTSequence"));
    // Signed pixels, and a signed start.
    let signed = image("XA", 3, 1, vec![-2i16 as u16, -1i16 as u16, 0])
        .short(PIXEL_REPRESENTATION, 1)
        .items(0x0028_3000, vec![table(-2)]);
    assert_eq!(values(&load_one(&signed).unwrap().volume), [100.0, 300.0, 40_000.0]);
    let error = load_one(&with(table(10).without(0x0028_3006))).unwrap_err().to_string();
    assert!(error.contains("LUTData (0028,3006) has 0 entries where its descriptor says 3"), "{error}");
}

#[test]
fn doses_are_in_gray() {
    let dose =
        image("RTDOSE", 2, 1, vec![0, 20_000]).text(0x3004_0002, "CS", "GY").decimals(0x3004_000E, &[0.001]);
    let imported = load_one(&dose).unwrap();
    assert_eq!(values(&imported.volume), [0.0, 20.0]);
    assert_eq!(imported.report.series[0].unit, "Gy");
    let error = load_one(&dose.decimals(0x3004_000E, &[0.0])).unwrap_err().to_string();
    assert!(error.contains("DoseGridScaling"), "{error}");
}

#[test]
fn a_block_of_another_creator_tells_nothing() {
    let blocks: [fn(Elements, usize) -> Elements; 2] = [
        |e, phase| e.text(0x0043_0010, "LO", "ACME").text(0x0043_1039, "IS", &(500 * phase).to_string()),
        // Without a creator, or with one of another block.
        |e, phase| {
            e.text(0x0043_0011, "LO", "GEMS_PARM_01").text(0x0043_1039, "IS", &(500 * phase).to_string())
        },
    ];
    for block in blocks {
        let folder = tempfile::tempdir().unwrap();
        write_phases(folder.path(), 2, 4, |e, phase, _| block(e, phase));
        let report = load(folder.path()).unwrap().report;
        let notes = report.series[0].notes.join("; ");
        assert!(notes.contains("told apart by instance number"), "{notes}");
    }
}

#[test]
fn floating_point_samples_and_their_padding() {
    let floats = |samples: &[f32], padding: Option<f32>| {
        let mut image = image("MR", samples.len() as u16, 1, vec![]).without(PIXEL_DATA);
        let bytes: Vec<u8> = samples.iter().flat_map(|s| s.to_le_bytes()).collect();
        image.set(0x7FE0_0008, "OW", Value::Raw(bytes.len() as u32, bytes));
        if let Some(padding) = padding {
            image.set(0x0028_0122, "FL", Value::Raw(4, padding.to_le_bytes().to_vec()));
        }
        values(&load_one(&image).unwrap().volume)
    };
    assert_eq!(floats(&[0.5, -3.25, 1e6], None), [0.5, -3.25, 1e6]);
    assert_eq!(floats(&[0.5, -9999.0, f32::NAN], Some(-9999.0)), [0.5, 0.5, 0.5]);
    let mut double = image("MR", 2, 1, vec![]).without(PIXEL_DATA);
    double.set(
        0x7FE0_0009,
        "OW",
        Value::Raw(16, [0.125f64, -4.0].iter().flat_map(|s| s.to_le_bytes()).collect()),
    );
    assert_eq!(values(&load_one(&double).unwrap().volume), [0.125, -4.0]);
}

#[test]
fn the_extended_offset_table_finds_frames() {
    // Two frames of RLE, in three fragments; by themselves they could be parted in two ways.
    let packed = |samples: &[u16]| {
        let plane = |shift: u32| -> Vec<u8> {
            let bytes = samples.iter().map(|s| (s >> shift) as u8);
            [samples.len() as u8 - 1].into_iter().chain(bytes).collect()
        };
        let (high, low) = (plane(8), plane(0));
        let head = [2u32, 64, 64 + high.len() as u32, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        let mut bytes: Vec<u8> = [head.iter().flat_map(|n| n.to_le_bytes()).collect(), high, low].concat();
        bytes.resize(bytes.len().next_multiple_of(2), 0);
        bytes
    };
    let (first, second) = (packed(&[1, 2, 3]), packed(&[0x400, 5, 6]));
    let (a, b) = first.split_at(30);
    let mut image = image("MR", 3, 1, vec![]).text(NUMBER_OF_FRAMES, "IS", "2");
    let offsets = [0u64, (16 + first.len()) as u64];
    image.set(0x7FE0_0001, "OB", Value::Raw(16, offsets.iter().flat_map(|o| o.to_le_bytes()).collect()));
    image.set(PIXEL_DATA, "OB", Value::Fragments(vec![a.to_vec(), b.to_vec(), second]));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.dcm");
    image.write(&path, Syntax::Rle);
    assert_eq!(values(&load(&path).unwrap().volume), [1.0, 2.0, 3.0, 1024.0, 5.0, 6.0]);
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_lead_in_no_circles() {
    use std::os::unix::fs::symlink;
    let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    write_phases(elsewhere.path(), 1, 3, |e, _, _| e);
    std::fs::create_dir(folder.path().join("a")).unwrap();
    symlink(elsewhere.path(), folder.path().join("a/study")).unwrap();
    symlink(elsewhere.path(), folder.path().join("again")).unwrap();
    symlink(folder.path(), folder.path().join("a/up")).unwrap();
    symlink("/", folder.path().join("a/root")).unwrap();
    symlink("nowhere", folder.path().join("broken")).unwrap();
    let imported = load(folder.path()).unwrap();
    assert_eq!(imported.volume.dims(), [2, 1, 3]);
    assert_eq!((imported.report.series[0].files, imported.report.skipped.len()), (3, 0));
}
