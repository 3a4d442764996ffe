//! Multi-frame files that are cut short or broken: what is there loads, what is not stays empty and is named.

use std::path::Path;

use crate::common::load;
use crate::writer::*;
use lumivox_core::{CancelToken, Progress, Volume};
use lumivox_import::{ImportError, ImportOptions, Imported, Study};

fn values(volume: &Volume) -> Vec<f64> {
    (0..volume.voxel_count()).map(|i| volume.voxels().get(i) * volume.slope() + volume.intercept()).collect()
}

/// An enhanced CT of 2 x 1 pixels, whose frames lie at these heights and have the values 10 k + 1 and 10 k + 2.
fn enhanced(heights: &[f64]) -> Elements {
    let group = |&z: &f64| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[5.0, 6.0, z]);
        Elements::default().items(0x0020_9113, vec![place])
    };
    let samples = (0..heights.len() as u16).flat_map(|k| [10 * k + 1, 10 * k + 2]).collect();
    image("CT", 2, 1, samples)
        .without(IMAGE_POSITION_PATIENT)
        .decimals(RESCALE_INTERCEPT, &[-1000.0])
        .text(0x0008_0018, "UI", "1.2.840.77")
        .text(NUMBER_OF_FRAMES, "IS", &heights.len().to_string())
        .items(0x5200_9230, heights.iter().map(group).collect())
}

fn load_bytes(bytes: &[u8]) -> Result<Imported, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.dcm");
    std::fs::write(&path, bytes).unwrap();
    load(&path)
}

fn open(path: &Path) -> Study {
    let options = ImportOptions::default();
    Study::open(&[path.to_owned()], &options, Progress::SILENT, &CancelToken::new()).unwrap()
}

const AIR: f64 = -1000.0;

#[test]
fn frames_that_are_cut_off_stay_empty_in_their_places() {
    let whole = enhanced(&[0.0, 2.0, 4.0, 6.0]).file(Syntax::Explicit);
    // The third frame lacks a byte.
    let imported = load_bytes(&whole[..whole.len() - 5]).unwrap();
    assert_eq!(imported.volume.dims(), [2, 1, 4]);
    assert_eq!(values(&imported.volume), [-999.0, -998.0, -989.0, -988.0, AIR, AIR, AIR, AIR]);
    assert_eq!(imported.report.empty_slices, [2, 3]);
    let notes = imported.report.notes.join("; ");
    for words in [
        "2 of 4 frames are there",
        "2 of 4 slices are damaged; left empty: slices 3 to 4, from (5, 6, 4) to (5, 6, 6) mm",
    ] {
        assert!(notes.contains(words), "'{words}' is missing: {notes}");
    }
    assert_eq!(imported.report.skipped.len(), 1, "a file is named once: {:?}", imported.report.skipped);
    assert_eq!(imported.report.series[0].dims, [2, 1, 4], "{:?}", imported.report.series);
}

#[test]
fn frames_are_lost_by_place_and_not_by_number() {
    // The file begins with the middle.
    let whole = enhanced(&[4.0, 0.0, 6.0, 2.0]).file(Syntax::Explicit);
    let imported = load_bytes(&whole[..whole.len() - 4]).unwrap();
    assert_eq!(values(&imported.volume), [-989.0, -988.0, AIR, AIR, -999.0, -998.0, -979.0, -978.0]);
    assert_eq!(imported.report.empty_slices, [1]);
    let mut options = ImportOptions::default();
    options.fill_damaged = true;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a"), &whole[..whole.len() - 4]).unwrap();
    let paths = [folder.path().to_owned()];
    let filled = lumivox_import::load(&paths, &options, Progress::SILENT, &CancelToken::new()).unwrap();
    assert_eq!(values(&filled.volume)[2..4], [-994.0, -993.0]);
}

#[test]
fn a_whole_copy_counts_before_one_that_is_cut_short() {
    let whole = enhanced(&[0.0, 2.0, 4.0, 6.0]).file(Syntax::Explicit);
    for names in [["a", "b"], ["b", "a"]] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(names[0]), &whole[..whole.len() - 4]).unwrap();
        std::fs::write(folder.path().join(names[1]), &whole).unwrap();
        let imported = load(folder.path()).unwrap();
        assert_eq!(imported.volume.dims(), [2, 1, 4]);
        assert!(imported.report.empty_slices.is_empty());
        let skipped = &imported.report.skipped;
        assert!(skipped.len() == 1 && skipped[0].path.ends_with(names[0]), "{skipped:?}");
    }
}

#[test]
fn the_picture_is_of_a_frame_that_is_there() {
    let heights: Vec<f64> = (0..40).map(f64::from).collect();
    let whole = enhanced(&heights).file(Syntax::Explicit);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    std::fs::write(&path, &whole[..whole.len() - 30 * 4]).unwrap();
    let picture = open(&path).thumbnail(0, 8, &CancelToken::new()).unwrap();
    assert_eq!((picture.width, picture.height), (2, 1));
}

#[test]
fn frames_that_are_only_claimed_take_no_memory() {
    // 30,000 frames of 2 MiB are told, of which one is there.
    let samples = vec![7; 1024 * 1024];
    let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 0.0]);
    let group = Elements::default().items(0x0020_9113, vec![place]);
    let claims = image("CT", 1024, 1024, samples)
        .text(NUMBER_OF_FRAMES, "IS", "30000")
        .items(0x5200_9230, vec![group; 30_000]);
    let imported = load_bytes(&claims.file(Syntax::Explicit)).unwrap();
    assert_eq!(imported.volume.dims(), [1024, 1024, 1]);
    assert!(imported.report.notes.iter().any(|note| note.contains("1 of 30000 frames")));
}

#[test]
fn compressed_frames_before_the_break_load() {
    let frame = |k: u16| {
        let samples: Vec<u8> = [10 * k + 1, 10 * k + 2].iter().flat_map(|s| s.to_le_bytes()).collect();
        let mut stream = rle(&samples, 2);
        stream.resize(stream.len().next_multiple_of(2), 0);
        stream
    };
    let mut image = enhanced(&[0.0, 2.0, 4.0, 6.0]);
    image.set(PIXEL_DATA, "OB", Value::Fragments((0..4).map(frame).collect()));
    let whole = image.file(Syntax::Rle);
    let expected = [-999.0, -998.0, -989.0, -988.0, AIR, AIR, AIR, AIR];
    let cut = &whole[..whole.len() - 8 - frame(3).len() - 8 - 3];
    // Or something else lies where the third begins.
    let mut broken = whole.clone();
    let third = whole.len() - 8 - 2 * (8 + frame(3).len());
    broken[third..third + 4].fill(0x55);
    for bytes in [cut, &broken] {
        let imported = load_bytes(bytes).unwrap();
        assert_eq!(values(&imported.volume), expected);
        assert_eq!(imported.report.empty_slices, [2, 3]);
    }
}

/// A segmentation of 8 x 1 pixels: frames of (segment, height, bits).
fn segmentation(frames: &[(u16, f64, u8)]) -> Elements {
    let group = |&(segment, z, _): &(u16, f64, u8)| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, z]);
        let which = Elements::default().short(0x0062_000B, segment);
        Elements::default().items(0x0020_9113, vec![place]).items(0x0062_000A, vec![which])
    };
    let mut seg = image("SEG", 8, 1, vec![])
        .without(IMAGE_POSITION_PATIENT)
        .decimals(SPACING_BETWEEN_SLICES, &[2.0])
        .text(0x0008_0016, "UI", "1.2.840.10008.5.1.4.1.1.66.4")
        .text(0x0062_0001, "CS", "BINARY")
        .text(SERIES_INSTANCE_UID, "UI", "1.2.9")
        .short(BITS_ALLOCATED, 1)
        .short(BITS_STORED, 1)
        .short(HIGH_BIT, 0)
        .text(NUMBER_OF_FRAMES, "IS", &frames.len().to_string())
        .items(0x5200_9230, frames.iter().map(group).collect());
    seg.set(PIXEL_DATA, "OB", Value::Bytes(frames.iter().map(|frame| frame.2).collect()));
    seg
}

#[test]
fn labels_that_are_lost_are_named() {
    // At 0 and 2 mm a slice each, at 4 none, at 6 two segments, at 8 one.
    let seg = segmentation(&[
        (1, 0.0, 0b1),
        (1, 2.0, 0b10),
        (2, 6.0, 0b100),
        (1, 6.0, 0b1000),
        (1, 8.0, 0b1000_0000),
        (1, 10.0, 1),
    ]);
    let whole = seg.file(Syntax::Explicit);
    // Of those at 6 mm the second frame is lost, and those at 8 and 10 mm.
    let cut = &whole[..whole.len() - 3];
    let imported = load_bytes(cut).unwrap();
    assert_eq!(imported.volume.dims(), [8, 1, 6]);
    let labels = values(&imported.volume);
    let painted: Vec<(usize, f64)> = labels.iter().copied().enumerate().filter(|(_, l)| *l != 0.0).collect();
    assert_eq!(painted, [(0, 1.0), (9, 1.0), (26, 2.0)]);
    assert_eq!(imported.report.empty_slices, [4, 5], "the one at 4 mm holds no segment, which is known");
    let notes = imported.report.notes.join("; ");
    for words in [
        "3 of 6 frames could not be read",
        "1 of 5 slices with labels lack",
        "2 of 5 slices are damaged; left empty: slices 5 to 6, from (0, 0, 8) to (0, 0, 10) mm",
    ] {
        assert!(notes.contains(words), "'{words}' is missing: {notes}");
    }

    // The same on the voxels of the series that it was made on, which begins 4 mm lower.
    let folder = tempfile::tempdir().unwrap();
    for k in 0..10 {
        image("CT", 8, 2, vec![k; 16])
            .text(SERIES_INSTANCE_UID, "UI", "1.2.7")
            .decimals(IMAGE_POSITION_PATIENT, &[0.0, -1.0, 2.0 * f64::from(k) - 4.0])
            .write(&folder.path().join(format!("ct {k}")), Syntax::Explicit);
    }
    let reference = Elements::default().text(SERIES_INSTANCE_UID, "UI", "1.2.7");
    let whole = seg.items(0x0008_1115, vec![reference]).file(Syntax::Explicit);
    std::fs::write(folder.path().join("seg"), &whole[..whole.len() - 3]).unwrap();
    let mut options = ImportOptions::default();
    options.series = Some("2".to_owned());
    for fill_damaged in [false, true] {
        options.fill_damaged = fill_damaged;
        let paths = [folder.path().to_owned()];
        let imported = lumivox_import::load(&paths, &options, Progress::SILENT, &CancelToken::new()).unwrap();
        assert_eq!(imported.volume.dims(), [8, 2, 10]);
        assert_eq!(imported.report.empty_slices, [6, 7]);
        assert_eq!(values(&imported.volume).iter().filter(|label| **label != 0.0).count(), 3);
    }
}
