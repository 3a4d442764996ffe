//! Series written for one question each: is every value at its true place in the patient?

use crate::common::{load, load_written};
use crate::field::*;
use crate::writer::*;
use lumivox_core::{CancelToken, Modality, Progress, Voxels, glam::DVec3};
use lumivox_import::{ImportError, ImportOptions, Imported};

#[test]
fn every_orientation_is_in_place() {
    let orientations = [
        ("head first, supine", DVec3::X, DVec3::Y),
        ("head first, prone", -DVec3::X, -DVec3::Y),
        ("feet first, supine", -DVec3::X, DVec3::Y),
        ("feet first, prone", DVec3::X, -DVec3::Y),
        ("sagittal", DVec3::Y, -DVec3::Z),
        ("coronal", DVec3::X, -DVec3::Z),
        ("decubitus", -DVec3::Y, DVec3::X),
    ];
    for (name, row, column) in orientations {
        let normal = row.cross(column);
        for step in [3.0, -3.0] {
            let places =
                [2.0, 0.0, 3.0, 1.0].map(|k| DVec3::new(5.0, -6.0, 7.0) + normal * (k * step)).to_vec();
            let imported = Series { row, column, ..Series::axial(places) }.load();
            let volume = imported.volume;
            println!("{name}");
            assert_eq!(volume.dims(), [5, 4, 4]);
            assert_eq!(volume.spacing_mm(), DVec3::new(2.0, 4.0, 3.0));
            assert_field(&volume, 0.0);
            // Right-handed voxel axes, whatever the order of the files.
            assert!(volume.patient_from_voxel().matrix3.determinant() > 0.0);
            assert!(imported.report.notes.is_empty(), "{:?}", imported.report.notes);
        }
    }
}

#[test]
fn signed_samples_keep_their_sign() {
    let series =
        Series { signed: true, rescale: |_| [1.0, 0.0], ..Series::axial(heights(&[0.0, -30.0, -60.0])) };
    let volume = series.load().volume;
    assert_eq!(volume.modality(), Modality::Ct);
    assert!(matches!(volume.voxels(), Voxels::U16(_)));
    assert_eq!((volume.slope(), volume.intercept()), (1.0, -32768.0));
    assert!(volume.value_range()[0] < 0.0 && volume.value_range()[1] > 0.0);
    assert_field(&volume, 0.0);
}

#[test]
fn a_tilted_gantry_is_kept_as_shear() {
    let places = (0..6).map(|k| DVec3::new(1.0, -2.0 * k as f64, 6.0 * k as f64)).collect();
    let imported = Series::axial(places).load();
    assert_eq!(imported.volume.patient_from_voxel().matrix3.z_axis, DVec3::new(0.0, -2.0, 6.0));
    assert_field(&imported.volume, 0.0);
    assert_eq!(imported.report.notes, ["gantry tilt 18.4 degrees, kept as shear"]);
}

#[test]
fn missing_slices_are_filled_in() {
    let imported = Series::axial(heights(&[0.0, 2.0, 4.0, 8.0, 10.0])).load();
    assert_eq!(imported.volume.dims(), [5, 4, 6]);
    assert_field(&imported.volume, 0.0);
    assert_eq!(imported.report.notes, ["1 of 6 slices is missing; filled in from the neighbours' values"]);

    // Or left empty, where nothing may be made up.
    let folder = tempfile::tempdir().unwrap();
    Series::axial(heights(&[0.0, 2.0, 4.0, 8.0, 10.0])).write(folder.path());
    let mut options = ImportOptions::default();
    options.leave_gaps = true;
    let paths = [folder.path().to_owned()];
    let imported = lumivox_import::load(&paths, &options, Progress::SILENT, &CancelToken::new()).unwrap();
    assert_eq!(imported.report.notes, ["1 of 6 slices is missing; left empty"]);
    assert_eq!(imported.volume.value([2, 1, 3]), -1000.0);
    assert_eq!(imported.volume.value([0, 0, 4]), field(DVec3::new(-10.0, 20.0, 8.0)));
}

/// Loads with options.
fn load_as(folder: &std::path::Path, leave_gaps: bool, fill_damaged: bool) -> Imported {
    let mut options = ImportOptions::default();
    (options.leave_gaps, options.fill_damaged) = (leave_gaps, fill_damaged);
    lumivox_import::load(&[folder.to_owned()], &options, Progress::SILENT, &CancelToken::new()).unwrap()
}

#[test]
fn damaged_slices_are_left_empty_unless_asked() {
    // One is missing at 8 mm; at 4 and 12 mm they are cut short, one in its pixels and one behind its last element.
    let z = [0.0, 2.0, 4.0, 6.0, 10.0, 12.0, 14.0];
    let folder = tempfile::tempdir().unwrap();
    Series::axial(heights(&z)).write(folder.path());
    let mut files: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    let place = |file: &std::path::PathBuf| load(file).unwrap().volume.patient_from_voxel().translation.z;
    for (at, left) in [(4.0, 7), (12.0, 0)] {
        let file = files.iter().find(|file| place(file) == at).unwrap().clone();
        let bytes = std::fs::read(&file).unwrap();
        std::fs::write(&file, &bytes[..bytes.len() - 40 + left]).unwrap();
        assert!(matches!(load(&file), Err(ImportError::Truncated { .. })));
        files.retain(|other| *other != file);
    }
    let value = |imported: &Imported, z: usize| imported.volume.value([2, 1, z]);
    let truth = |z: usize| field(DVec3::new(-10.0 + 2.0 * 2.0, 20.0 + 4.0, 2.0 * z as f64));
    let check = |imported: &Imported, empty: &[usize]| {
        assert_eq!(imported.volume.dims(), [5, 4, 8]);
        assert_eq!(imported.report.empty_slices, empty);
        for z in 0..8 {
            let expected = if empty.contains(&z) { -1000.0 } else { truth(z) };
            assert!((value(imported, z) - expected).abs() < 0.51, "slice {z}: {:?}", imported.report.notes);
        }
        // Each is named once.
        assert_eq!(imported.report.skipped.len(), 2, "{:?}", imported.report.skipped);
        assert!(imported.report.skipped.iter().all(|file| file.reason.starts_with("cut short: ")));
    };
    let imported = load_as(folder.path(), false, false);
    check(&imported, &[2, 6]);
    assert_eq!(
        imported.report.notes,
        [
            "2 of 7 slices are damaged; left empty: slice 3 at (-10, 20, 4) mm, slice 7 at (-10, 20, 12) mm",
            "1 of 8 slices is missing; filled in from the neighbours' values"
        ]
    );
    let listed = &imported.report.series[0];
    assert_eq!((listed.dims, listed.files), ([5, 4, 8], 7));
    assert!(listed.notes.contains(&"2 of 7 slices are cut short".to_owned()), "{:?}", listed.notes);
    let imported = load_as(folder.path(), false, true);
    check(&imported, &[]);
    assert_eq!(
        imported.report.notes,
        [
            "2 of 7 slices could not be decoded",
            "3 of 8 slices are missing; filled in from the neighbours' values"
        ]
    );
    check(&load_as(folder.path(), true, false), &[2, 4, 6]);
    check(&load_as(folder.path(), true, true), &[2, 4, 6]);
    // A whole copy of one that is cut short counts.
    let whole = Series::axial(heights(&z)).slice(2);
    whole.write(&folder.path().join("z whole"), Syntax::Explicit);
    assert_eq!(load_as(folder.path(), false, false).volume.value([2, 1, 2]), truth(2).round());
}

#[test]
fn a_gap_stays_where_a_damaged_file_may_belong() {
    let folder = tempfile::tempdir().unwrap();
    Series::axial(heights(&[0.0, 2.0, 4.0, 8.0, 10.0])).write(folder.path());
    let mut bytes = Series::axial(heights(&[6.0])).slice(0).file(Syntax::Explicit);
    // In the middle of an early element: nobody knows where it lies.
    bytes.truncate(250);
    std::fs::write(folder.path().join("head"), bytes).unwrap();
    let imported = load_as(folder.path(), false, false);
    let note = "1 of 6 slices is missing; left empty, for damaged files may belong there";
    assert_eq!(imported.report.notes, [note], "{:?}", imported.report.skipped);
    assert_eq!(imported.report.empty_slices, [3]);
    assert!(load_as(folder.path(), false, true).report.empty_slices.is_empty());
}

#[test]
fn uneven_slices_are_resampled_at_true_heights() {
    let imported = Series::axial(heights(&[0.0, 4.0, 8.0, 9.13, 16.31, 23.77])).load();
    assert_eq!(imported.volume.dims()[2], 23);
    // Half a step of the stored integers, twice; and what a slice that is nearly hit is off.
    assert_field(&imported.volume, 1.2);
    assert!(imported.report.notes[0].starts_with("the slices lie unevenly"));
}

#[test]
fn of_several_images_at_one_place_the_first_is_used() {
    let folder = tempfile::tempdir().unwrap();
    let series = Series::axial(heights(&[0.0, 2.0, 4.0]));
    for k in 0..3 {
        for echo in [2, 1] {
            let mut slice = series.slice(k).text(INSTANCE_NUMBER, "IS", &echo.to_string());
            if echo == 2 {
                slice.set(PIXEL_DATA, "OW", Value::Words(vec![0; 20]));
            }
            slice.write(&folder.path().join(format!("{k} {echo}")), Syntax::Explicit);
        }
    }
    let imported = load(folder.path()).unwrap();
    assert_field(&imported.volume, 0.0);
    assert_eq!(imported.report.notes, ["phase 1 of 2 is taken (told apart by instance number)"]);
    let series = &imported.report.series[0];
    assert_eq!((series.phases, series.dims, series.files), (2, [5, 4, 3], 6));
}

#[test]
fn changing_intercepts_keep_integers_and_changing_slopes_keep_values() {
    let places = heights(&[0.0, 2.0, 4.0]);
    let shifted = Series {
        rescale: |k| [1.0, -1000.0 - 24.0 * k as f64],
        signed: true,
        ..Series::axial(places.clone())
    };
    // 16 stored bits and a shift do not fit in 16 bits.
    assert!(matches!(shifted.load().volume.voxels(), Voxels::F32(_)));
    assert_field(&shifted.load().volume, 0.0);
    let folder = tempfile::tempdir().unwrap();
    for k in 0..3 {
        let slice = shifted.slice(k).short(BITS_STORED, 15).short(HIGH_BIT, 14);
        slice.write(&folder.path().join(k.to_string()), Syntax::Explicit);
    }
    let volume = load(folder.path()).unwrap().volume;
    assert!(matches!(volume.voxels(), Voxels::U16(_)));
    assert_field(&volume, 0.0);

    let pet = Series { rescale: |k| [0.25 + k as f64, -500.0], modality: "PT", ..Series::axial(places) };
    let volume = pet.load().volume;
    assert_eq!(volume.modality(), Modality::Pet);
    assert!(matches!(volume.voxels(), Voxels::F32(_)));
    assert_field(&volume, 1.2);
}

/// Loads one file.
fn load_one(elements: &Elements, syntax: Syntax) -> Result<Imported, ImportError> {
    load_written(|path| elements.write(path, syntax))
}

fn values(elements: &Elements) -> Vec<f64> {
    let volume = load_one(elements, Syntax::Explicit).unwrap().volume;
    (0..volume.voxel_count()).map(|i| volume.voxels().get(i) * volume.slope() + volume.intercept()).collect()
}

#[test]
fn junk_bits_are_masked_and_signs_extended() {
    let twelve = |samples| image("MR", 2, 1, samples).short(BITS_STORED, 12).short(HIGH_BIT, 11);
    assert_eq!(values(&twelve(vec![0xF123, 0x8FFF])), [291.0, 4095.0]);
    assert_eq!(values(&twelve(vec![0xF123, 0x8FFF]).short(PIXEL_REPRESENTATION, 1)), [291.0, -1.0]);
    // Stored in the upper bits.
    let upper = image("MR", 2, 1, vec![0x123F, 0xFFF0]).short(BITS_STORED, 12).short(HIGH_BIT, 15);
    assert_eq!(values(&upper), [291.0, 4095.0]);
    let mut eight =
        image("MR", 3, 1, vec![]).short(BITS_ALLOCATED, 8).short(BITS_STORED, 8).short(HIGH_BIT, 7);
    eight.set(PIXEL_DATA, "OB", Value::Bytes(vec![1, 128, 255]));
    assert_eq!(values(&eight), [1.0, 128.0, 255.0]);
    assert!(matches!(load_one(&eight, Syntax::Explicit).unwrap().volume.voxels(), Voxels::U8(_)));
    let eight = eight.short(PIXEL_REPRESENTATION, 1);
    assert_eq!(values(&eight), [1.0, -128.0, -1.0]);
    assert!(matches!(load_one(&eight, Syntax::Explicit).unwrap().volume.voxels(), Voxels::U8(_)));
}

#[test]
fn padding_becomes_air_or_the_lowest_value() {
    let ct = image("CT", 4, 1, vec![-2000i16 as u16, -1024i16 as u16, 0, 40])
        .short(PIXEL_REPRESENTATION, 1)
        .short(PIXEL_PADDING_VALUE, -2000i16 as u16);
    assert_eq!(values(&ct), [-1000.0, -1024.0, 0.0, 40.0]);
    let mr = image("MR", 4, 1, vec![0, 7, 9, 3]).short(PIXEL_PADDING_VALUE, 0);
    assert_eq!(values(&mr), [3.0, 7.0, 9.0, 3.0]);
    let mr =
        image("MR", 4, 1, vec![0, 7, 9, 2]).short(PIXEL_PADDING_VALUE, 3).short(PIXEL_PADDING_RANGE_LIMIT, 0);
    assert_eq!(values(&mr), [7.0, 7.0, 9.0, 7.0]);
    // Padding that needs more bits than are stored is no value of the image.
    let ct = image("CT", 3, 1, vec![63536, 2096, 1024])
        .short(BITS_STORED, 12)
        .short(HIGH_BIT, 11)
        .decimals(RESCALE_INTERCEPT, &[-1024.0])
        .short(PIXEL_PADDING_VALUE, 63536);
    assert_eq!(values(&ct), [-1000.0, 1072.0, 0.0]);
    // Nothing but padding.
    assert_eq!(values(&image("MR", 2, 1, vec![5, 5]).short(PIXEL_PADDING_VALUE, 5)).len(), 2);
}

/// With a negative slope the lowest value is that of the highest sample.
#[test]
fn the_lowest_value_is_not_the_lowest_sample() {
    let slices = [[0u16, 7, 9, 3], [0, 5, 6, 4], [0, 8, 2, 3]];
    let folder = tempfile::tempdir().unwrap();
    for (k, samples) in slices.into_iter().enumerate() {
        image("MR", 4, 1, samples.to_vec())
            .decimals(RESCALE_SLOPE, &[-2.0])
            .decimals(RESCALE_INTERCEPT, &[100.0])
            .short(PIXEL_PADDING_VALUE, 0)
            .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, [0.0, 1.0, 3.0][k]])
            .text(INSTANCE_NUMBER, "IS", &k.to_string())
            .write(&folder.path().join(k.to_string()), Syntax::Explicit);
    }
    let slices = |imported: &Imported| -> Vec<Vec<f64>> {
        crate::common::values(&imported.volume).chunks(4).map(<[f64]>::to_vec).collect()
    };
    let (first, second, last) =
        ([82.0, 86.0, 82.0, 94.0], [82.0, 90.0, 88.0, 92.0], [82.0, 84.0, 96.0, 94.0]);
    // So of padding, and of a gap that is left.
    assert_eq!(slices(&load_as(folder.path(), true, false)), [first, second, [82.0; 4], last]);
    // And of a damaged slice, which has no part in it.
    let path = folder.path().join("2");
    image("MR", 4, 1, vec![0, 8, 2, 3])
        .decimals(RESCALE_SLOPE, &[-2.0])
        .decimals(RESCALE_INTERCEPT, &[100.0])
        .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 2.0])
        .write(&path, Syntax::Explicit);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 4]).unwrap();
    assert_eq!(slices(&load_as(folder.path(), false, false)), [first, second, [82.0; 4]]);
}

#[test]
fn only_values_without_a_scale_are_inverted() {
    let inverted = |modality| {
        let image = image(modality, 2, 1, vec![1, 4000]).short(BITS_STORED, 12).short(HIGH_BIT, 11);
        values(&image.text(PHOTOMETRIC_INTERPRETATION, "CS", "MONOCHROME1"))
    };
    assert_eq!(inverted("MR"), [4094.0, 95.0]);
    assert_eq!(inverted("CT"), [1.0, 4000.0]);
}

#[test]
fn every_way_of_writing_is_read() {
    let image = Series::axial(heights(&[3.0])).slice(0);
    for syntax in [Syntax::Explicit, Syntax::Implicit, Syntax::BigEndian, Syntax::Deflated] {
        assert_field(&load_one(&image, syntax).unwrap().volume, 0.0);
    }
    // Without preamble, without anything before the data set, or with the prefix alone.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.dcm");
    let file = image.file(Syntax::Explicit);
    let bare = |syntax| image.data_set(syntax);
    let ways = [
        file[128..].to_vec(),
        file[132..].to_vec(),
        bare(Syntax::Explicit),
        bare(Syntax::Implicit),
        bare(Syntax::BigEndian),
    ];
    for (k, bytes) in ways.iter().enumerate() {
        std::fs::write(&path, bytes).unwrap();
        assert_field(&load(&path).unwrap_or_else(|e| panic!("way {k}: {e}")).volume, 0.0);
    }
    // A file that says explicit and is implicit, and the other way round.
    let swap = |said: Syntax, is: Syntax| [&said_head(said)[..], &image.data_set(is)].concat();
    for bytes in [swap(Syntax::Explicit, Syntax::Implicit), swap(Syntax::Implicit, Syntax::Explicit)] {
        std::fs::write(&path, bytes).unwrap();
        assert_field(&load(&path).unwrap().volume, 0.0);
    }
}

fn said_head(syntax: Syntax) -> Vec<u8> {
    Elements::default().file(syntax)
}

/// An item of undefined length after the other, `depth` deep, closed again.
fn nested(depth: usize, vr: &[u8; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for _ in 0..depth {
        bytes.extend([0xFE, 0xFF, 0x00, 0xE0, 0xFF, 0xFF, 0xFF, 0xFF]);
        bytes.extend([0x09, 0x00, 0x10, 0x10]);
        bytes.extend(vr);
        bytes.extend([0, 0, 0xFF, 0xFF, 0xFF, 0xFF]);
    }
    for _ in 0..depth {
        bytes.extend([0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0, 0xFE, 0xFF, 0x0D, 0xE0, 0, 0, 0, 0]);
    }
    bytes.extend([0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
    bytes
}

#[test]
fn nesting_costs_no_stack() {
    let mut image = Series::axial(heights(&[3.0])).slice(0);
    for depth in [0, 1, 3, 200_000] {
        image.set(0x0009_1001, "SQ", Value::Raw(u32::MAX, nested(depth, b"SQ")));
        assert_field(&load_one(&image, Syntax::Explicit).unwrap().volume, 0.0);
        // Even where a sequence that is read holds itself.
        let mut bytes = nested(depth, b"SQ");
        for i in 0..bytes.len().saturating_sub(4) {
            if bytes[i..i + 4] == [0x09, 0x00, 0x10, 0x10] {
                bytes[i..i + 4].copy_from_slice(&[0x28, 0x00, 0x10, 0x91]);
            }
        }
        let mut recursive = image.clone();
        recursive.set(0x0028_9110, "SQ", Value::Raw(u32::MAX, bytes));
        assert_field(&load_one(&recursive, Syntax::Explicit).unwrap().volume, 0.0);
    }
    // A value of unknown VR holds implicit items.
    let item = Elements::default().text(0x0009_1002, "LO", "x").data_set(Syntax::Implicit);
    let mut unknown = vec![0xFE, 0xFF, 0x00, 0xE0, 0xFF, 0xFF, 0xFF, 0xFF];
    unknown.extend(item);
    unknown.extend([0xFE, 0xFF, 0x0D, 0xE0, 0, 0, 0, 0, 0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
    image.set(0x0009_1001, "UN", Value::Raw(u32::MAX, unknown));
    assert_field(&load_one(&image, Syntax::Explicit).unwrap().volume, 0.0);
}

fn little(words: &[u16]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn words(elements: &Elements) -> Vec<u16> {
    match elements.0.last() {
        Some((PIXEL_DATA, _, Value::Words(words))) => words.clone(),
        _ => panic!("no pixels"),
    }
}

#[test]
fn a_slice_that_cannot_be_decoded_is_filled_in_if_asked() {
    let folder = tempfile::tempdir().unwrap();
    let series = Series::axial(heights(&[0.0, 2.0, 4.0, 6.0, 8.0]));
    for k in 0..5 {
        let mut slice = series.slice(k);
        let packed = rle(&little(&words(&slice)), 2);
        // In two fragments, one of them cut short.
        let (a, b) = packed.split_at(70);
        let b = if k == 2 { &b[..3] } else { b };
        slice.set(PIXEL_DATA, "OB", Value::Fragments(vec![a.to_vec(), b.to_vec()]));
        slice.write(&folder.path().join(format!("{k}")), Syntax::Rle);
    }
    let notes = load(folder.path()).unwrap().report.notes;
    assert_eq!(notes, ["1 of 5 slices is damaged; left empty: slice 3 at (-10, 20, 4) mm"]);
    let imported = load_as(folder.path(), false, true);
    assert_eq!(imported.volume.dims(), [5, 4, 5]);
    assert_field(&imported.volume, 0.0);
    let notes = imported.report.notes;
    assert_eq!(notes[0], "1 of 5 slices could not be decoded");
    assert_eq!(notes[1], "1 of 5 slices is missing; filled in from the neighbours' values");
    assert!(imported.report.skipped[0].path.ends_with("2"));
    assert!(imported.report.skipped[0].reason.contains("RLE"), "{:?}", imported.report.skipped);
}

#[test]
fn frames_are_placed_by_their_functional_groups() {
    // Frames from top to bottom, each with its own rescale.
    let series =
        Series { rescale: |k| [1.0 + k as f64, -700.0], ..Series::axial(heights(&[9.0, 6.0, 3.0, 0.0])) };
    let mut samples = Vec::new();
    let mut frames = Vec::new();
    for k in 0..4 {
        samples.extend(words(&series.slice(k)));
        let [slope, intercept] = (series.rescale)(k);
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &series.places[k].to_array());
        let rescale =
            Elements::default().decimals(RESCALE_SLOPE, &[slope]).decimals(RESCALE_INTERCEPT, &[intercept]);
        frames.push(Elements::default().items(0x0020_9113, vec![place]).items(0x0028_9145, vec![rescale]));
    }
    let orientation =
        Elements::default().decimals(IMAGE_ORIENTATION_PATIENT, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let measures = Elements::default().decimals(PIXEL_SPACING, &[4.0, 2.0]);
    let shared = Elements::default().items(0x0020_9116, vec![orientation]).items(0x0028_9110, vec![measures]);
    let enhanced = image("MR", COLUMNS_N, ROWS_N, samples)
        .without(IMAGE_POSITION_PATIENT)
        .without(IMAGE_ORIENTATION_PATIENT)
        .without(PIXEL_SPACING)
        .text(NUMBER_OF_FRAMES, "IS", "4")
        .items(0x5200_9229, vec![shared])
        .items(0x5200_9230, frames);
    for syntax in [Syntax::Explicit, Syntax::Implicit, Syntax::BigEndian, Syntax::Deflated] {
        let volume = load_one(&enhanced, syntax).unwrap().volume;
        assert_eq!(volume.dims(), [5, 4, 4]);
        assert_field(&volume, 2.0);
    }
    let few = enhanced.text(NUMBER_OF_FRAMES, "IS", "5");
    let error = load_one(&few, Syntax::Explicit).unwrap_err().to_string();
    assert!(
        error.contains("PerFrameFunctionalGroupsSequence (5200,9230) has 4 items for 5 frames"),
        "{error}"
    );
}

#[test]
fn frames_without_places_are_stacked_and_noted() {
    let multi = image("NM", 2, 1, (0..6).collect()).text(NUMBER_OF_FRAMES, "IS", "3");
    let imported =
        load_one(&multi.clone().decimals(SPACING_BETWEEN_SLICES, &[2.5]), Syntax::Explicit).unwrap();
    assert_eq!(imported.volume.dims(), [2, 1, 3]);
    assert_eq!(imported.volume.spacing_mm().z, 2.5);
    assert_eq!(imported.volume.value([1, 0, 2]), 5.0);
    assert_eq!(imported.report.notes[0], "the places of the 3 frames are not given; stacked 2.5 mm apart");
    // Cut short, what is there is shown.
    let mut cut = multi.clone();
    cut.set(PIXEL_DATA, "OW", Value::Words(vec![0, 1, 2, 3, 4]));
    let imported = load_one(&cut, Syntax::Explicit).unwrap();
    assert_eq!(imported.volume.dims(), [2, 1, 2]);
    assert!(imported.report.notes.contains(&"the file is cut short: 2 of 3 frames are there".to_owned()));
    // A dose grid says where they are.
    let dose = multi.decimals(0x3004_000C, &[0.0, -4.0, -8.0]);
    let volume = load_one(&dose, Syntax::Explicit).unwrap().volume;
    assert_eq!(volume.patient_from_voxel().translation.z, -8.0);
    assert_eq!(volume.value([0, 0, 0]), 4.0);
}

#[test]
fn damaged_fields_are_not_quoted_and_impossible_spacings_are_refused() {
    let error = |spacing: &str| {
        let image = image("CT", 1, 1, vec![0]).text(PIXEL_SPACING, "DS", spacing);
        load_one(&image, Syntax::Explicit).unwrap_err().to_string()
    };
    assert!(error("DOE^JANE").contains("PixelSpacing (0028,0030) is not a number"));
    assert!(error("1-\\1").contains("is '1-\\1', not finite numbers"));
    for spacing in ["1e-7\\1", "1\\2e6"] {
        assert!(error(spacing).contains("from 0.000001 to 1000000"), "{}", error(spacing));
    }
    let single = load_one(&image("CT", 2, 1, vec![0, 1]), Syntax::Explicit).unwrap();
    assert!(single.report.notes.iter().any(|note| note.starts_with("a single slice is not a volume")));
}

/// Whatever is cut off or changed in a file, the result is a volume or an error in words, without patient data.
#[test]
fn damaged_files_never_panic() {
    let slice = Series::axial(heights(&[3.0])).slice(0);
    let mut packed = slice.clone();
    packed.set(PIXEL_DATA, "OB", Value::Fragments(vec![rle(&little(&words(&slice)), 2)]));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.dcm");
    let check = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        if let Err(error) = load(&path) {
            assert!(!error.to_string().contains("SECRET"), "{error}");
        }
    };
    for file in [slice.file(Syntax::Explicit), slice.file(Syntax::Implicit), packed.file(Syntax::Rle)] {
        for end in 128..file.len() {
            check(&file[..end]);
        }
        for at in 128..file.len() {
            for flip in [0x01, 0x80, 0xFF] {
                let mut bytes = file.clone();
                bytes[at] ^= flip;
                check(&bytes);
            }
        }
    }
}
