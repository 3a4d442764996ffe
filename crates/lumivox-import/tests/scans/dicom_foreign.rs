//! DICOM as other programs write it: parts of complex images in one series, segmentations that are compressed or have a
//! palette, labels in any script, ultrasound volumes, and fields that are empty, negative or left out.

use std::path::Path;

use crate::common::{load, load_written, shared, values};
use crate::writer::*;
use lumivox_core::{CancelToken, Progress, glam::DVec3};
use lumivox_import::{Imported, ImportedLabels, LabelOptions, load_labels};

const SOP_CLASS_UID: u32 = 0x0008_0016;

fn load_one(elements: &Elements) -> Imported {
    load_written(|path| elements.write(path, Syntax::Explicit)).unwrap()
}

fn labels(elements: &Elements, syntax: Syntax) -> ImportedLabels {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seg.dcm");
    elements.write(&path, syntax);
    labels_of(&path)
}

fn labels_of(path: &Path) -> ImportedLabels {
    load_labels(path, &LabelOptions::default(), Progress::SILENT, &CancelToken::new()).unwrap()
}

fn doubles(numbers: &[f64]) -> Value {
    Value::Raw(8 * numbers.len() as u32, numbers.iter().flat_map(|n| n.to_le_bytes()).collect())
}

fn words(words: &[u16]) -> Value {
    Value::Raw(2 * words.len() as u32, words.iter().flat_map(|w| w.to_le_bytes()).collect())
}

/// Writes two images at each of three places; `kind` makes what they are of one.
fn write_pairs(folder: &Path, kind: impl Fn(Elements, usize) -> Elements) {
    for slice in 0..3u16 {
        for part in 0..2usize {
            let samples = vec![100 * part as u16 + slice, 5];
            let image = image("MR", 2, 1, samples)
                .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 2.0 * f64::from(slice)])
                .text(INSTANCE_NUMBER, "IS", &(slice + 1 + 10 * part as u16).to_string());
            kind(image, part).write(&folder.join(format!("{slice} {part}")), Syntax::Explicit);
        }
    }
}

/// The first of each pair is what should come first.
#[track_caller]
fn are_series_of_their_own(name: &str, kind: impl Fn(Elements, usize) -> Elements) {
    let folder = tempfile::tempdir().unwrap();
    write_pairs(folder.path(), kind);
    let imported = load(folder.path()).unwrap();
    let series = &imported.report.series;
    let found: Vec<_> = series.iter().map(|series| (series.phases, series.dims[2])).collect();
    assert_eq!(found, [(1, 3), (1, 3)], "{name}: {:?}", series[0].description);
    assert_eq!(values(&imported.volume)[0].abs() % 100.0, 0.0, "{name}");
    assert!(values(&imported.volume)[0] < 50.0, "{name}: the magnitude comes first");
}

#[test]
fn parts_of_complex_images_are_series_of_their_own() {
    // However they are spelt, and whichever was found first.
    for (first, second) in [
        ("SW_M_FFE\\SW_M\\FFE", "SW_P_FFE\\SW_P\\FFE"),
        ("M_FFE\\M\\FFE", "P_FFE\\P\\FFE"),
        ("M\\ND", "P\\ND"),
        ("MAGNITUDE", "PHASE"),
        ("M", "PHASE MAP"),
        ("M_IR\\M\\IR", "R_IR\\R\\IR"),
        ("OTHER", "IMAGINARY"),
        ("OTHER", "B0_MAP"),
        ("M_PCA\\M\\PCA", "PHASE CONTRAST M\\P\\PCA"),
    ] {
        are_series_of_their_own(second, |image, part| {
            image.text(IMAGE_TYPE, "CS", &format!("ORIGINAL\\PRIMARY\\{}", [first, second][part]))
        });
        // The map's files come first.
        are_series_of_their_own(second, |image, part| {
            let image =
                image.text(IMAGE_TYPE, "CS", &format!("ORIGINAL\\PRIMARY\\{}", [second, first][part]));
            // What is expected to come first has the small samples.
            let samples = if part == 1 { vec![0, 5] } else { vec![100, 5] };
            let mut image = image;
            image.set(PIXEL_DATA, "OW", Value::Words(samples));
            image
        });
    }
    // Water and fat, of which either may come first.
    let folder = tempfile::tempdir().unwrap();
    write_pairs(folder.path(), |image, part| {
        image.text(IMAGE_TYPE, "CS", ["DERIVED\\PRIMARY\\DIXON\\WATER", "DERIVED\\PRIMARY\\DIXON\\FAT"][part])
    });
    assert_eq!(load(folder.path()).unwrap().report.series.len(), 2);
    // By GE's own numbers alone.
    for (element, numbers) in [(0x2F, [0u16, 1]), (0x2F, [0, 3]), (0x30, [2, 0])] {
        are_series_of_their_own("GE", |image, part| {
            let mut image = image.text(IMAGE_TYPE, "CS", "ORIGINAL\\PRIMARY\\OTHER").text(
                0x0043_0010,
                "LO",
                "GEMS_PARM_01",
            );
            image.set(0x0043_1000 | element, "SS", words(&[numbers[part]]));
            if part == 1 {
                image.set(0x0028_0106, "SS", words(&[-505i16 as u16]));
                image = image.short(PIXEL_REPRESENTATION, 1).decimals(0x0028_1050, &[0.0]);
            }
            image
        });
    }
    // Phases stay phases.
    let folder = tempfile::tempdir().unwrap();
    write_pairs(folder.path(), |image, part| {
        image.text(IMAGE_TYPE, "CS", "ORIGINAL\\PRIMARY\\M\\IN_PHASE").text(
            0x0018_0086,
            "IS",
            &(part + 1).to_string(),
        )
    });
    let report = load(folder.path()).unwrap().report;
    assert_eq!((report.series.len(), report.series[0].phases), (1, 2));
}

#[test]
fn kinds_of_real_series_are_no_phases() {
    let Some(swi) = shared("cases/import/philips_swi_kinds") else { return };
    let report = load(&swi).unwrap().report;
    assert_eq!(report.series.iter().map(|series| series.phases).collect::<Vec<_>>(), [1, 1]);
    assert!(report.series[1].description.contains("phase"), "{}", report.series[1].description);
    let map = shared("cases/import/ge_fieldmap_first").unwrap();
    let imported = load(&map).unwrap();
    assert_eq!(imported.report.series.iter().map(|series| series.phases).collect::<Vec<_>>(), [1, 1]);
    assert!(imported.volume.value_range()[0] >= 0.0, "{:?}", imported.volume.value_range());
    assert_eq!(imported.report.series[1].reason, "a map of values around 0");
}

/// A segmentation of 4 x 2 pixels and two frames 2 mm apart, of segment 1.
fn segmentation(class: &str, kind: &str, label: &[u8]) -> Elements {
    let group = |z: f64| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[1.0, 2.0, z]);
        let which = Elements::default().short(0x0062_000B, 1);
        Elements::default().items(0x0020_9113, vec![place]).items(0x0062_000A, vec![which])
    };
    let mut segment = Elements::default().short(0x0062_0004, 1);
    segment.set(0x0062_0005, "LO", Value::Bytes(label.to_vec()));
    image("SEG", 4, 2, vec![])
        .without(IMAGE_POSITION_PATIENT)
        .text(SOP_CLASS_UID, "UI", class)
        .text(0x0062_0001, "CS", kind)
        .decimals(SPACING_BETWEEN_SLICES, &[2.0])
        .text(NUMBER_OF_FRAMES, "IS", "2")
        .items(0x0062_0002, vec![segment])
        .items(0x5200_9230, vec![group(0.0), group(2.0)])
}

fn bits(class: &str) -> Elements {
    segmentation(class, "BINARY", b"Liver ").short(BITS_ALLOCATED, 1).short(BITS_STORED, 1).short(HIGH_BIT, 0)
}

const BINARY: &str = "1.2.840.10008.5.1.4.1.1.66.4";

#[test]
fn compressed_bits_are_read() {
    let expected = [1, 0, 1, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0];
    let packed = [0b1000_1101u8, 0b0000_0010];
    let whole: [&[u8]; 2] = [&[1, 0, 1, 1, 0, 0, 0, 1], &[0, 1, 0, 0, 0, 0, 0, 0]];
    let mut seg = bits(BINARY);
    for frames in [packed.map(|byte| rle(&[byte], 1)), whole.map(|bytes| rle(bytes, 1))] {
        seg.set(PIXEL_DATA, "OB", Value::Fragments(frames.to_vec()));
        assert_eq!(labels(&seg, Syntax::Rle).labels.voxels(), expected);
    }
    let deflate = |bytes: &[u8]| {
        use std::io::Write;
        let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    seg.set(PIXEL_DATA, "OB", Value::Fragments(packed.map(|byte| deflate(&[byte])).to_vec()));
    assert_eq!(labels(&seg, Syntax::DeflatedFrames).labels.voxels(), expected);

    let Some(folder) = shared("cases/import/seg_1bit_compressed") else { return };
    let counts =
        ["liver_deflate.dcm", "liver_rle.dcm"].map(|name| labels_of(&folder.join(name)).labels.counts());
    assert_eq!(counts[0], counts[1]);
    assert!(counts[0][1] > 36_233 + 35_645);
}

#[test]
fn a_label_map_may_have_a_palette() {
    let mut seg = segmentation("1.2.840.10008.5.1.4.1.1.66.7", "LABELMAP", b"Liver ")
        .text(0x0028_0004, "CS", "PALETTE COLOR")
        .short(BITS_ALLOCATED, 8)
        .short(BITS_STORED, 8)
        .short(HIGH_BIT, 7)
        .short(PIXEL_PADDING_VALUE, 9);
    for (channel, entries) in [[0u8, 255, 0, 0], [0, 0, 0, 0], [0, 255, 0, 0]].into_iter().enumerate() {
        seg.set(0x0028_1101 + channel as u32, "US", words(&[4, 0, 8]));
        seg.set(0x0028_1201 + channel as u32, "OW", Value::Raw(4, entries.to_vec()));
    }
    seg.set(PIXEL_DATA, "OB", Value::Bytes(vec![0, 1, 1, 9, 9, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 9]));
    let imported = labels(&seg, Syntax::Explicit);
    assert_eq!(imported.labels.voxels(), [0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
    assert_eq!(imported.labels.labels()[0].name, "Liver");
    assert_eq!(imported.labels.labels()[0].color, [1.0, 0.0, 1.0]);

    let Some(case) = shared("cases/import/seg_labelmap_palette/seg.dcm") else { return };
    let imported = labels_of(&case);
    assert_eq!((imported.labels.counts()[1], imported.labels.labels()[0].name.as_str()), (630, "Liver"));
}

#[test]
fn labels_are_told_in_every_script_and_never_with_a_name() {
    let told = |charset: &str, label: &[u8], patient: &[u8]| {
        let mut seg = bits(BINARY).text(0x0008_0005, "CS", charset);
        let mut segment = Elements::default().short(0x0062_0004, 1);
        segment.set(0x0062_0005, "LO", Value::Bytes(label.to_vec()));
        seg.set(0x0062_0002, "SQ", Value::Items(vec![segment]));
        seg.set(PATIENT_NAME, "PN", Value::Bytes(patient.to_vec()));
        seg.set(PIXEL_DATA, "OB", Value::Bytes(vec![1, 2]));
        labels(&seg, Syntax::Explicit).labels.labels()[0].name.clone()
    };
    assert_eq!(told("ISO_IR 192", "Größe der Leber 肝臓 ".as_bytes(), b""), "Größe der Leber 肝臓");
    assert_eq!(told("ISO_IR 100", b"Gr\xf6\xdfe ", b""), "Größe");
    assert_eq!(told("\\ISO 2022 IR 87", b"\x1b$B4NB!\x1b(B ", b""), "肝臓");
    assert_eq!(told("ISO_IR 144", &[0xDF, 0xD5, 0xE7, 0xD5, 0xDD, 0xEC], b""), "печень");
    assert_eq!(told("ISO_IR 166", &[0xB5, 0xD1, 0xBA, b' '], b""), "ตับ");
    assert_eq!(told("GB18030", &[0xB8, 0xCE, 0xD4, 0xE0], b""), "肝脏");
    // Folded, and inside of a word; both are in their own character sets.
    assert_eq!(told("ISO_IR 100", b"Mueller Leber ", b"M\xfcller^Anna"), "Leber");
    assert_eq!(told("ISO_IR 100", b"liverOBrien2 ", b"O'Brien^Ann "), "label 1");
    assert_eq!(told("ISO_IR 192", "肝臓 山田の".as_bytes(), "山田^太郎".as_bytes()), "肝臓");

    let Some(cases) = shared("cases/import") else { return };
    for (name, label) in
        [("utf8", "Größe der Leber 肝臓"), ("latin1", "Größe der Leber"), ("japanese", "肝臓")]
    {
        let path = cases.join(format!("seg_label_charset/{name}.dcm"));
        assert_eq!(labels_of(&path).labels.labels()[0].name, label);
    }
    for (name, label) in [("joined", "label 1"), ("plural", "liver")] {
        let imported = labels_of(&cases.join(format!("seg_label_name_part/{name}.dcm")));
        assert_eq!(imported.labels.labels()[0].name, label);
        assert!(!format!("{:?}", imported.report).to_lowercase().contains("zyxnamer"));
    }
}

#[test]
fn enhanced_ultrasound_lies_in_its_own_space() {
    let group = |z: f64| {
        let mut place = Elements::default();
        place.set(0x0020_9301, "FD", doubles(&[-5.0, -6.0, z]));
        Elements::default().items(0x0020_930E, vec![place])
    };
    let mut orientation = Elements::default();
    orientation.set(0x0020_9302, "FD", doubles(&[0.0, 1.0, 0.0, 1.0, 0.0, 0.0]));
    let measures = Elements::default().decimals(PIXEL_SPACING, &[0.5, 0.25]);
    let shared_groups =
        Elements::default().items(0x0020_930F, vec![orientation]).items(0x0028_9110, vec![measures]);
    let us = image("US", 2, 1, (0..6).collect())
        .without(IMAGE_POSITION_PATIENT)
        .without(IMAGE_ORIENTATION_PATIENT)
        .without(PIXEL_SPACING)
        .text(SOP_CLASS_UID, "UI", "1.2.840.10008.5.1.4.1.1.6.2")
        .text(NUMBER_OF_FRAMES, "IS", "3")
        .items(0x5200_9229, vec![shared_groups])
        .items(0x5200_9230, vec![group(4.0), group(3.0), group(2.0)]);
    let imported = load_one(&us);
    let volume = &imported.volume;
    assert_eq!((volume.dims(), volume.spacing_mm()), ([2, 1, 3], DVec3::new(0.25, 0.5, 1.0)));
    // The normal of these axes points down.
    assert_eq!(values(volume), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(volume.patient_from_voxel().translation, DVec3::new(-5.0, -6.0, 4.0));
    let notes = imported.report.notes.join("; ");
    assert!(notes.contains("a space of its own"), "{notes}");
    let mut wrong = us.clone();
    let mut place = Elements::default();
    place.set(0x0020_9301, "FD", doubles(&[0.0, f64::NAN, 1.0]));
    let groups = vec![Elements::default().items(0x0020_930E, vec![place]); 3];
    wrong.set(0x5200_9230, "SQ", Value::Items(groups));
    let error = load_written(|path| wrong.write(path, Syntax::Explicit)).unwrap_err().to_string();
    assert!(error.contains("ImagePositionVolume (0020,9301)"), "{error}");

    let Some(cases) = shared("cases") else { return };
    assert_eq!(load(&cases.join("us_enh")).unwrap().volume.dims(), [128; 3]);
    assert_eq!(load(&cases.join("import/us_volume/usvol.dcm")).unwrap().volume.dims(), [24, 20, 6]);
}

#[test]
fn an_empty_table_leaves_the_rescale() {
    let ct = image("CT", 2, 1, vec![0, 1100]).decimals(RESCALE_INTERCEPT, &[-1000.0]);
    let mut empty = Elements::default();
    empty.set(0x0028_3002, "US", Value::Raw(0, vec![]));
    empty.set(0x0028_3006, "US", Value::Raw(0, vec![]));
    for item in [Elements::default(), empty] {
        let imported = load_one(&ct.clone().items(0x0028_3000, vec![item]));
        assert_eq!(values(&imported.volume), [-1000.0, 100.0]);
    }
    let Some(folder) = shared("cases/import/empty_modality_lut") else { return };
    for name in ["a.dcm", "b_empty_item.dcm"] {
        assert!(load(&folder.join(name)).unwrap().volume.value_range()[0] < 0.0);
    }
}

#[test]
fn negative_spacings_lead_the_other_way() {
    let frames = image("CT", 2, 1, (0..6).collect())
        .text(NUMBER_OF_FRAMES, "IS", "3")
        .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 160.0])
        .decimals(SPACING_BETWEEN_SLICES, &[-2.0]);
    let imported = load_one(&frames);
    // From below: the last frame lies lowest.
    assert_eq!(imported.volume.patient_from_voxel().translation.z, 156.0);
    assert_eq!(values(&imported.volume), [4.0, 5.0, 2.0, 3.0, 0.0, 1.0]);
    let notes = imported.report.notes.join("; ");
    assert!(notes.contains("against the normal (SpacingBetweenSlices is negative)"), "{notes}");

    let Some(case) = shared("cases/mf_sbs_neg") else { return };
    let volume = load(&case).unwrap().volume;
    let top = volume.patient_from_voxel().transform_point3(volume.dims().map(|n| n as f64 - 1.0).into());
    assert_eq!(top.z, 160.0);
}

#[test]
fn frames_are_counted_by_their_groups_where_nothing_else_does() {
    let group = |z: f64| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, z]);
        Elements::default().items(0x0020_9113, vec![place])
    };
    let image = image("CT", 2, 1, (0..6).collect())
        .without(NUMBER_OF_FRAMES)
        .without(IMAGE_POSITION_PATIENT)
        .items(0x5200_9230, vec![group(0.0), group(1.0), group(2.0)]);
    let imported = load_one(&image);
    assert_eq!(values(&imported.volume), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let notes = imported.report.notes.join("; ");
    assert!(notes.contains("NumberOfFrames is not given; the file describes 3"), "{notes}");
}

#[test]
fn images_that_are_series_by_themselves_are_put_together() {
    let write = |folder: &Path, heights: &[f64]| {
        for (k, z) in heights.iter().enumerate() {
            image("CT", 2, 1, vec![k as u16, 5])
                .text(SERIES_INSTANCE_UID, "UI", &format!("1.2.{k}"))
                .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, *z])
                .write(&folder.join(k.to_string()), Syntax::Explicit);
        }
    };
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[4.0, 0.0, 6.0, 2.0, 8.0, 10.0]);
    let imported = load(folder.path()).unwrap();
    assert_eq!((imported.report.series.len(), imported.report.series[0].files), (1, 6));
    assert_eq!(
        values(&imported.volume).iter().step_by(2).copied().collect::<Vec<_>>(),
        [1.0, 3.0, 0.0, 2.0, 4.0, 5.0]
    );
    assert!(
        imported.report.notes.iter().any(|note| note.starts_with("6 series of one image each lie evenly"))
    );
    // Unevenly they may be anything.
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[0.0, 2.0, 5.0, 11.0]);
    assert_eq!(load(folder.path()).unwrap().report.series.len(), 4);
}

/// Retired, and read all the same; of 12 bits the words name a program that reads it.
#[test]
fn progressive_jpeg_is_read() {
    // Grey from 0 to 189 in steps of 3, 8 x 8 pixels: tables of ones, and four scans, one for the means and three for the
    // frequencies by bands.
    const FRAME: [u8; 13] = [255, 194, 0, 11, 8, 0, 8, 0, 8, 1, 0, 17, 0];
    const SCANS: [u8; 107] = [
        255, 196, 0, 20, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9, 255, 196, 0, 28, 16, 0, 1, 3,
        5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 6, 9, 38, 51, 68, 82, 99, 113, 255, 218, 0, 8, 1, 0, 0, 0,
        0, 0, 60, 255, 0, 255, 218, 0, 8, 1, 0, 0, 1, 20, 0, 68, 50, 85, 24, 142, 54, 63, 255, 218, 0, 8, 1,
        0, 0, 21, 41, 0, 230, 179, 255, 218, 0, 8, 1, 0, 0, 42, 63, 0, 63, 255, 217,
    ];
    let samples: Vec<u8> = (0..64).map(|k| k * 3).collect();
    let table = [&[255, 219, 0, 67, 0][..], &[1; 64]].concat();
    let mut stream = [&[255, 216][..], &FRAME, &table, &SCANS].concat();
    let mut image =
        image("OT", 8, 8, vec![]).short(BITS_ALLOCATED, 8).short(BITS_STORED, 8).short(HIGH_BIT, 7);
    image.set(PIXEL_DATA, "OB", Value::Fragments(vec![stream.clone()]));
    for syntax in [Syntax::JpegSpectral, Syntax::JpegProgressive] {
        let found = values(&load_written(|path| image.write(path, syntax)).unwrap().volume);
        assert!(found.iter().zip(&samples).all(|(a, b)| (a - f64::from(*b)).abs() <= 2.0), "{found:?}");
    }
    // The frame header says 12 bits.
    let at = stream.windows(2).position(|pair| pair == [0xFF, 0xC2]).unwrap();
    stream[at + 4] = 12;
    image.set(PIXEL_DATA, "OB", Value::Fragments(vec![stream]));
    let error = load_written(|path| image.write(path, Syntax::JpegProgressive)).unwrap_err().to_string();
    assert!(error.contains("dcmdjpeg"), "{error}");
}

#[test]
fn other_formats_have_their_oddities_too() {
    let Some(cases) = shared("cases/import") else { return };
    let ball = load(&cases.join("nrrd_byteskip/BallBinary30x30x30_gz_byteskip_minus_one.nrrd")).unwrap();
    assert_eq!((ball.volume.dims(), ball.volume.value([15, 15, 15])), ([30; 3], 257.0));
    assert_eq!(load(&cases.join("mha_2d_spacing/h_2d3sp.mha")).unwrap().volume.dims(), [5, 4, 1]);
}
