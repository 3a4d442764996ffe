//! Segmentations without the series that they were made on: every label comes out unchanged, at its place or at one that
//! the report tells.

use crate::common::{load_written, values};
use crate::writer::*;
use lumivox_core::glam::DVec3;
use lumivox_import::{ImportError, Imported};

/// A frame of a segmentation of 8 x 1 pixels.
#[derive(Clone, Copy, Default)]
struct LabelFrame {
    segment: u16,
    /// Where it lies, if the file says so.
    height: Option<f64>,
    /// InStackPositionNumber, if there is one.
    in_stack: Option<u32>,
    pixels: u8,
}

/// Frames with a height, each of segment 1.
fn placed(frames: &[(f64, u8)]) -> Vec<LabelFrame> {
    let frame = |&(z, pixels): &(f64, u8)| LabelFrame { segment: 1, height: Some(z), in_stack: None, pixels };
    frames.iter().map(frame).collect()
}

/// Frames without a place: segment and pixels.
fn unplaced(frames: &[(u16, u8)]) -> Vec<LabelFrame> {
    let frame = |&(segment, pixels): &(u16, u8)| LabelFrame { segment, pixels, ..LabelFrame::default() };
    frames.iter().map(frame).collect()
}

fn segmentation(frames: &[LabelFrame], spacing: f64) -> Elements {
    let group = |frame: &LabelFrame| {
        let which = Elements::default().short(0x0062_000B, frame.segment);
        let mut group = Elements::default().items(0x0062_000A, vec![which]);
        if let Some(z) = frame.height {
            let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[3.0, 4.0, z]);
            group = group.items(0x0020_9113, vec![place]);
        }
        if let Some(number) = frame.in_stack {
            let mut content = Elements::default();
            content.set(0x0020_9057, "UL", Value::Raw(4, number.to_le_bytes().to_vec()));
            group = group.items(0x0020_9111, vec![content]);
        }
        group
    };
    let mut seg = image("SEG", 8, 1, vec![])
        .without(IMAGE_POSITION_PATIENT)
        .decimals(SPACING_BETWEEN_SLICES, &[spacing])
        .text(0x0008_0016, "UI", "1.2.840.10008.5.1.4.1.1.66.4")
        .text(0x0062_0001, "CS", "BINARY")
        .short(BITS_ALLOCATED, 1)
        .short(BITS_STORED, 1)
        .short(HIGH_BIT, 0)
        .text(NUMBER_OF_FRAMES, "IS", &frames.len().to_string())
        .items(0x5200_9230, frames.iter().map(group).collect());
    seg.set(PIXEL_DATA, "OB", Value::Bytes(frames.iter().map(|frame| frame.pixels).collect()));
    seg
}

fn load(frames: &[LabelFrame], spacing: f64) -> Result<Imported, ImportError> {
    load_written(|path| segmentation(frames, spacing).write(path, Syntax::Explicit))
}

/// The label at every voxel of every slice that has one: height in mm, and the pixels as bits, of segment 1.
fn slices_with_labels(imported: &Imported) -> Vec<(f64, u8)> {
    let volume = &imported.volume;
    let labels = values(volume);
    let slice = |z: usize| {
        let pixels = labels[8 * z..8 * (z + 1)].iter().enumerate();
        pixels.map(|(i, label)| if *label == 0.0 { 0 } else { 1 << i }).sum::<u8>()
    };
    let height = |z: usize| volume.patient_from_voxel().transform_point3(DVec3::new(0.0, 0.0, z as f64)).z;
    (0..volume.dims()[2]).map(|z| (height(z), slice(z))).filter(|(_, pixels)| *pixels != 0).collect()
}

#[test]
fn labels_far_apart_are_all_kept_in_place() {
    // 201 places, three of which have labels.
    let written = [(0.0, 0b101), (30.0, 0b10), (200.0, 0b1000_0001)];
    let imported = load(&placed(&written), 1.0).unwrap();
    assert_eq!(imported.volume.dims(), [8, 1, 201]);
    assert_eq!(imported.volume.spacing_mm(), DVec3::new(1.0, 1.0, 1.0));
    assert_eq!(slices_with_labels(&imported), written);
    let notes = imported.report.notes.join("; ");
    assert!(notes.contains("198 of 201 slices hold no segment"), "{notes}");
    assert!(!notes.contains("filled in") && !notes.contains("interpolated"), "{notes}");
    assert_eq!(imported.report.series[0].dims, [8, 1, 201]);
}

#[test]
fn labels_off_the_header_s_steps_are_kept_too() {
    // Thickness tells nothing of their distance, but there is a step that they have in common.
    let written = [(0.0, 0b101), (7.5, 0b10), (20.0, 0b1), (45.0, 0b1000_0001)];
    let imported = load(&placed(&written), 3.3).unwrap();
    assert_eq!(slices_with_labels(&imported), written);
    assert_eq!(imported.volume.dims(), [8, 1, 19]);
    assert!(imported.report.notes.iter().any(|note| note == "15 of 19 slices hold no segment"));

    // And where there is none, each is at a place nearby.
    let written = [(0.0, 0b101), (4.0, 0b10), (8.0, 0b1), (9.13, 0b11), (16.31, 0b110), (23.77, 0b1000)];
    let imported = load(&placed(&written), 3.3).unwrap();
    let read = slices_with_labels(&imported);
    assert_eq!(read.len(), written.len(), "{:?}", imported.report.notes);
    let mut off: f64 = 0.0;
    for ((z, pixels), (true_z, true_pixels)) in read.iter().zip(written) {
        assert_eq!(*pixels, true_pixels);
        off = off.max((z - true_z).abs());
    }
    assert!(off > 0.05 && off < 1.13 / 2.0, "{off}");
    let notes = imported.report.notes.join("; ");
    assert!(
        notes.contains(&format!("unchanged, at the nearest of 23 places 1.080 mm apart, up to {off:.3} mm")),
        "{notes}"
    );
    assert!(!notes.contains("interpolated") && !notes.contains("filled in"), "{notes}");
}

#[test]
fn labels_without_places_are_stacked_where_their_order_is_known() {
    let heights = |spacing: f64, pixels: &[u8]| -> Vec<(f64, u8)> {
        pixels.iter().enumerate().map(|(k, &pixels)| (spacing * k as f64, pixels)).collect()
    };
    let told = |imported: &Imported, words: &str| {
        let notes = imported.report.notes.join("; ");
        assert!(notes.contains(words), "'{words}' is missing: {notes}");
    };
    // One segment, slice after slice.
    let imported = load(&unplaced(&[(1, 0b1), (1, 0b10), (1, 0b100)]), 2.5).unwrap();
    assert_eq!(slices_with_labels(&imported), heights(2.5, &[0b1, 0b10, 0b100]));
    told(
        &imported,
        "the places of the 3 slices are not given; stacked 2.5 mm apart at the origin, in the order of the frames",
    );
    // Two, each in all slices.
    let imported = load(&unplaced(&[(1, 0b1), (1, 0b10), (2, 0b100), (2, 0b1000)]), 2.5).unwrap();
    assert_eq!(slices_with_labels(&imported), heights(2.5, &[0b101, 0b1010]));
    assert_eq!(values(&imported.volume)[..4], [1.0, 0.0, 2.0, 0.0]);
    // The file counts the slices of its stack.
    let mut counted = unplaced(&[(1, 0b1), (2, 0b10), (2, 0b100)]);
    for (frame, number) in counted.iter_mut().zip([4, 2, 4]) {
        frame.in_stack = Some(number);
    }
    let imported = load(&counted, 2.5).unwrap();
    assert_eq!(slices_with_labels(&imported), [(0.0, 0b10), (5.0, 0b101)]);
    told(&imported, "stacked 2.5 mm apart at the origin, by InStackPositionNumber");
    // A single frame has no order to be unsure of.
    assert_eq!(slices_with_labels(&load(&unplaced(&[(1, 0b110)]), 2.5).unwrap()), [(0.0, 0b110)]);
}

#[test]
fn labels_whose_places_cannot_be_known_are_refused() {
    // Which slices the second segment has, nothing tells.
    let error = load(&unplaced(&[(1, 0b1), (1, 0b10), (2, 0b100)]), 2.5).unwrap_err().to_string();
    assert!(error.contains("a segmentation without the places of its frames"), "{error}");
    // Some frames have a place.
    let mut some = placed(&[(0.0, 0b1), (2.5, 0b10), (5.0, 0b100)]);
    some[1].height = None;
    let error = load(&some, 2.5).unwrap_err().to_string();
    assert!(error.contains("ImagePositionPatient (0020,0032) is missing in 1 of 3 frames"), "{error}");
}

#[test]
fn labels_without_numbers_of_segments_are_refused() {
    let segments = |numbers: &[u16]| -> Vec<Elements> {
        numbers.iter().map(|&number| Elements::default().short(0x0062_0004, number)).collect()
    };
    let load = |seg: &Elements| load_written(|path| seg.write(path, Syntax::Explicit));
    // Two segments of ten slices each, in a file that says one place and nothing of its frames.
    let frames: Vec<(u16, u8)> = (0..20).map(|k| (1 + k / 10, 1 << (k % 8))).collect();
    let bare = segmentation(&unplaced(&frames), 2.0)
        .without(0x5200_9230)
        .decimals(IMAGE_POSITION_PATIENT, &[3.0, 4.0, 5.0]);
    let error = load(&bare.clone().items(0x0062_0002, segments(&[1, 2]))).unwrap_err().to_string();
    assert!(error.contains("ReferencedSegmentNumber (0062,000B) is missing in 20 of 20 frames"), "{error}");
    // Places alone do not tell whose they are, either.
    let place = |z: f64| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[3.0, 4.0, z]);
        Elements::default().items(0x0020_9113, vec![place])
    };
    let placed =
        segmentation(&unplaced(&[(1, 1), (2, 2)]), 2.0).items(0x5200_9230, vec![place(0.0), place(2.0)]);
    let error = load(&placed.clone().items(0x0062_0002, segments(&[1, 2]))).unwrap_err().to_string();
    assert!(error.contains("is missing in 2 of 2 frames"), "{error}");
    // Of a single segment, and where voxels are numbers themselves, nothing is missing.
    let one = load(&placed.clone().items(0x0062_0002, segments(&[3]))).unwrap();
    assert_eq!(values(&one.volume)[..2], [3.0, 0.0]);
    let stacked = load(&bare.items(0x0062_0002, segments(&[1]))).unwrap();
    assert_eq!(stacked.volume.dims(), [8, 1, 20]);
    let notes = stacked.report.notes.join("; ");
    assert!(notes.contains("the places of the 20 slices are not given; stacked 2 mm apart"), "{notes}");
    let mut map = placed.text(0x0062_0001, "CS", "LABELMAP").short(BITS_ALLOCATED, 8).short(BITS_STORED, 8);
    map.set(HIGH_BIT, "US", Value::Short(7));
    map.set(PIXEL_DATA, "OB", Value::Bytes((0..16).collect()));
    assert_eq!(values(&load(&map).unwrap().volume), (0..16).map(f64::from).collect::<Vec<_>>());
}

#[test]
fn labels_of_a_packed_file_with_another_checksum_are_refused() {
    use std::io::Write;
    let native = segmentation(&placed(&[(0.0, 0xA5), (1.0, 0x5A)]), 1.0);
    let fraction = |value: u8| {
        let mut stream = rle(&[value; 8], 1);
        stream.resize(stream.len().next_multiple_of(2), 0);
        stream
    };
    let mut encapsulated = native
        .clone()
        .text(0x0062_0001, "CS", "FRACTIONAL")
        .short(BITS_ALLOCATED, 8)
        .short(BITS_STORED, 8)
        .short(HIGH_BIT, 7);
    encapsulated.set(PIXEL_DATA, "OB", Value::Fragments(vec![fraction(0xA5), fraction(0x5A)]));
    for (seg, syntax, pixels) in
        [(native, Syntax::Explicit, &[0xA5, 0x5A][..]), (encapsulated, Syntax::Rle, &[0xA5; 8])]
    {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
        packed.write_all(&seg.file(syntax)).unwrap();
        let mut packed = packed.finish().unwrap();
        load_written(|path| std::fs::write(path, &packed).unwrap()).unwrap();
        let at = packed.windows(pixels.len()).rposition(|window| window == pixels).unwrap();
        packed[at] ^= 2;
        let error = load_written(|path| std::fs::write(path, &packed).unwrap()).unwrap_err().to_string();
        assert!(error.contains("cannot be unpacked"), "{syntax:?}: {error}");
    }
}

#[test]
fn two_labels_far_apart_are_no_thick_slabs() {
    let written = [(0.0, 0b101), (28.8, 0b10)];
    let imported = load(&placed(&written), 5.0).unwrap();
    assert_eq!(imported.volume.dims(), [8, 1, 7]);
    assert!((imported.volume.spacing_mm().z - 4.8).abs() < 1e-9);
    let read = slices_with_labels(&imported);
    assert!(read.len() == 2 && read[0] == written[0] && (read[1].0 - 28.8).abs() < 1e-9 && read[1].1 == 0b10);
    let notes = imported.report.notes.join("; ");
    assert!(notes.contains("5 of 7 slices hold no segment"), "{notes}");
    assert!(
        notes.contains("28.800 mm apart, taken as 6 steps of 4.800 mm (5.000 mm were expected)"),
        "{notes}"
    );
    // No multiple of it is near.
    let imported = load(&placed(&[(0.0, 0b101), (7.0, 0b10)]), 5.0).unwrap();
    assert_eq!(imported.volume.dims(), [8, 1, 2]);
    let notes = imported.report.notes.join("; ");
    assert!(
        notes.contains("7.000 mm apart, which is no multiple of the 5.000 mm that were expected"),
        "{notes}"
    );
}
