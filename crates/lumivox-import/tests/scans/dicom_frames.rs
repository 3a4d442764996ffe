//! What the frames of a file are: slices where they are slices, phases where they are moments of a volume, and no volume
//! where they are a film, views from around, or tiles.

use std::path::Path;

use crate::common::{load, load_series, load_written, values};
use crate::writer::*;
use lumivox_core::{CancelToken, Progress, Volume, glam::DVec3};
use lumivox_import::{ImportError, ImportOptions, Imported};

const SOP_CLASS_UID: u32 = 0x0008_0016;
const FRAME_TIME: u32 = 0x0018_1063;
const FRAME_TIME_VECTOR: u32 = 0x0018_1065;
const SLICE_LOCATION_VECTOR: u32 = 0x0018_2005;
const FRAME_INCREMENT_POINTER: u32 = 0x0028_0009;
const ENERGY_WINDOW_VECTOR: u32 = 0x0054_0010;
const DETECTOR_VECTOR: u32 = 0x0054_0020;
const DETECTOR_INFORMATION_SEQUENCE: u32 = 0x0054_0022;
const PHASE_VECTOR: u32 = 0x0054_0030;
const ROTATION_VECTOR: u32 = 0x0054_0050;
const RR_INTERVAL_VECTOR: u32 = 0x0054_0060;
const TIME_SLOT_VECTOR: u32 = 0x0054_0070;
const SLICE_VECTOR: u32 = 0x0054_0080;
const ANGULAR_VIEW_VECTOR: u32 = 0x0054_0090;
const TIME_SLICE_VECTOR: u32 = 0x0054_0100;

/// Frames of 2 x 1 pixels, with the samples 10 k + 1 and 10 k + 2.
fn frames(modality: &str, count: u16) -> Elements {
    let samples = (0..count).flat_map(|k| [10 * k + 1, 10 * k + 2]).collect();
    image(modality, 2, 1, samples).text(NUMBER_OF_FRAMES, "IS", &count.to_string())
}

/// Functional groups of a frame at this height.
fn place_group(z: f64) -> Elements {
    let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, z]);
    Elements::default().items(0x0020_9113, vec![place])
}

/// Sets FrameIncrementPointer.
fn counted_by(mut elements: Elements, attributes: &[u32]) -> Elements {
    let tags = attributes.iter().flat_map(|tag| [(tag >> 16) as u16, *tag as u16]);
    let bytes: Vec<u8> = tags.flat_map(u16::to_le_bytes).collect();
    elements.set(FRAME_INCREMENT_POINTER, "AT", Value::Raw(bytes.len() as u32, bytes));
    elements
}

/// Sets vectors, and FrameIncrementPointer to them.
fn with_vectors(mut elements: Elements, vectors: &[(u32, &[u16])]) -> Elements {
    for (tag, numbers) in vectors {
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        elements.set(*tag, "US", Value::Raw(bytes.len() as u32, bytes));
    }
    let tags: Vec<u32> = vectors.iter().map(|(tag, _)| *tag).collect();
    counted_by(elements, &tags)
}

fn load_one(elements: &Elements) -> Result<Imported, ImportError> {
    load_written(|path| elements.write(path, Syntax::Explicit))
}

fn load_phase(path: &Path, phase: usize) -> Volume {
    let mut options = ImportOptions::default();
    options.phase = Some(phase);
    let paths = [path.to_owned()];
    lumivox_import::load(&paths, &options, Progress::SILENT, &CancelToken::new()).unwrap().volume
}

/// The first sample of each slice.
fn firsts(volume: &Volume) -> Vec<f64> {
    values(volume).iter().step_by(2).copied().collect()
}

#[track_caller]
fn assert_refused(elements: &Elements, words: &str) {
    let error = load_one(elements).unwrap_err().to_string();
    assert!(error.contains(words), "{error}");
    assert!(!error.contains("SECRET"), "{error}");
}

#[test]
fn a_film_is_no_volume() {
    let film = "a film: its frames are moments of one picture";
    for modality in ["XA", "RF", "US", "OT"] {
        let bare = frames(modality, 5).without(IMAGE_POSITION_PATIENT).without(IMAGE_ORIENTATION_PATIENT);
        let timed = counted_by(bare.clone().text(FRAME_TIME, "DS", "33.3"), &[FRAME_TIME]);
        assert_refused(&timed, film);
        let timed = bare.text(FRAME_TIME_VECTOR, "DS", "0\\33\\34\\33\\40");
        assert_refused(&counted_by(timed, &[FRAME_TIME_VECTOR]), film);
    }
    // Of a place in the patient, too.
    let timed = counted_by(frames("MR", 5).text(FRAME_TIME, "DS", "40"), &[FRAME_TIME]);
    assert_refused(&timed, film);
    assert_refused(&timed, "Open a series of slices, or the volume that was reconstructed of it");
    // One frame is a picture, as others are.
    let one = counted_by(frames("XA", 1).text(FRAME_TIME, "DS", "0"), &[FRAME_TIME]);
    assert_eq!(load_one(&one).unwrap().volume.dims(), [2, 1, 1]);
}

#[test]
fn films_of_several_slices_are_phases_of_a_volume() {
    let folder = tempfile::tempdir().unwrap();
    // The moments of each of three slices in a file of its own.
    for slice in 0..3u16 {
        let samples = (0..4).flat_map(|moment| [100 * slice + moment, 7]).collect();
        let film = image("MR", 2, 1, samples)
            .text(NUMBER_OF_FRAMES, "IS", "4")
            .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 8.0 * f64::from(slice)])
            .text(FRAME_TIME, "DS", "40");
        counted_by(film, &[FRAME_TIME]).write(&folder.path().join(slice.to_string()), Syntax::Explicit);
    }
    let imported = load(folder.path()).unwrap();
    let series = &imported.report.series;
    assert_eq!((series.len(), series[0].phases, series[0].dims), (1, 4, [2, 1, 3]), "{series:?}");
    for moment in 1..=4 {
        let volume = load_phase(folder.path(), moment);
        let first = (moment - 1) as f64;
        assert_eq!(firsts(&volume), [first, 100.0 + first, 200.0 + first]);
        assert_eq!(volume.spacing_mm().z, 8.0);
    }
}

#[test]
fn projections_and_tiles_are_no_volumes() {
    let classes = [
        ("XA", "1.2.840.10008.5.1.4.1.1.12.1", "projections"),
        ("RF", "1.2.840.10008.5.1.4.1.1.12.2", "projections"),
        ("XA", "1.2.840.10008.5.1.4.1.1.12.1.1", "projections"),
        ("DX", "1.2.840.10008.5.1.4.1.1.1.1", "projections"),
        ("MG", "1.2.840.10008.5.1.4.1.1.13.1.4", "projections"),
        ("US", "1.2.840.10008.5.1.4.1.1.3.1", "a film"),
        ("SM", "1.2.840.10008.5.1.4.1.1.77.1.6", "tiles of a microscope slide"),
    ];
    for (modality, class, words) in classes {
        let bare = frames(modality, 4).text(SOP_CLASS_UID, "UI", class);
        assert_refused(&bare.clone().without(IMAGE_POSITION_PATIENT), words);
        assert_refused(&bare, words);
    }
    // Tiles, whatever they are of.
    for organization in ["TILED_FULL", "TILED_SPARSE"] {
        assert_refused(&frames("OT", 4).text(0x0020_9311, "CS", organization), "tiles of a microscope slide");
    }
    // Frames with groups of their own say where they are, whatever counts them.
    let timed = frames("MR", 3).items(0x5200_9230, [0.0, 1.0, 2.0].map(place_group).to_vec());
    let timed = counted_by(timed.without(IMAGE_POSITION_PATIENT), &[FRAME_TIME]);
    assert_eq!(load_one(&timed).unwrap().volume.dims(), [2, 1, 3]);
    // The reconstruction of such views is a volume, with places of its own.
    let tomosynthesis = frames("MG", 3)
        .text(SOP_CLASS_UID, "UI", "1.2.840.10008.5.1.4.1.1.13.1.3")
        .items(0x5200_9230, [0.0, 1.0, 2.0].map(place_group).to_vec());
    assert_eq!(load_one(&tomosynthesis).unwrap().volume.dims(), [2, 1, 3]);
}

#[test]
fn slice_locations_say_where_frames_are() {
    let captured = frames("CT", 3).text(SLICE_LOCATION_VECTOR, "DS", "12\\8\\10");
    let imported = load_one(&counted_by(captured, &[SLICE_LOCATION_VECTOR])).unwrap();
    let notes = imported.report.notes.join("; ");
    assert!(notes.contains("frames lie where SliceLocationVector (0018,2005) says"), "{notes}");
    let volume = imported.volume;
    assert_eq!(firsts(&volume), [11.0, 21.0, 1.0]);
    assert_eq!(volume.spacing_mm().z, 2.0);
}

/// A reconstructed SPECT: slices of 2 x 1 pixels from (5, 6, 70) on, whose place is in the detector's item.
fn spect(image_type: &str, count: u16, spacing: f64) -> Elements {
    let detector = Elements::default()
        .decimals(IMAGE_POSITION_PATIENT, &[5.0, 6.0, 70.0])
        .decimals(IMAGE_ORIENTATION_PATIENT, &[0.0, 1.0, 0.0, -1.0, 0.0, 0.0]);
    frames("NM", count)
        .without(IMAGE_POSITION_PATIENT)
        .without(IMAGE_ORIENTATION_PATIENT)
        .text(SOP_CLASS_UID, "UI", "1.2.840.10008.5.1.4.1.1.20")
        .text(IMAGE_TYPE, "CS", &format!("ORIGINAL\\PRIMARY\\{image_type}\\EMISSION"))
        .decimals(SPACING_BETWEEN_SLICES, &[spacing])
        .items(DETECTOR_INFORMATION_SEQUENCE, vec![detector])
}

#[test]
fn spect_lies_where_its_detector_says_and_is_not_mirrored() {
    for (spacing, order) in [(4.0, [1u16, 2, 3]), (-4.0, [1, 2, 3]), (-4.0, [3, 1, 2])] {
        let spect = with_vectors(spect("RECON TOMO", 3, spacing), &[(SLICE_VECTOR, &order)]);
        let imported = load_one(&spect).unwrap();
        let volume = &imported.volume;
        assert_eq!(volume.dims(), [2, 1, 3]);
        let voxel_from_patient = volume.patient_from_voxel().inverse();
        for (frame, number) in order.into_iter().enumerate() {
            // Behind the first slice where the spacing is positive (PS3.3 C.8.4.15).
            let place = DVec3::new(5.0, 6.0, 70.0 + spacing * f64::from(number - 1));
            let at = voxel_from_patient.transform_point3(place).round();
            assert!(at.x == 0.0 && at.y == 0.0 && (0.0..3.0).contains(&at.z), "{at}");
            assert_eq!(volume.value([0, 0, at.z as usize]), 10.0 * frame as f64 + 1.0, "{spacing} {order:?}");
            // Columns run towards the back.
            let next = voxel_from_patient.transform_point3(place + DVec3::Y).round();
            assert_eq!(next - at, DVec3::X);
        }
        assert!(volume.patient_from_voxel().matrix3.determinant() > 0.0);
        let notes = &imported.report.notes;
        assert!(!notes.iter().any(|note| note.contains("not given")), "{notes:?}");
    }
    // Only nuclear medicine knows a sign (PS3.3 C.7.6.2); of others nothing else can be meant, and it is told.
    let other = frames("OT", 3).decimals(SPACING_BETWEEN_SLICES, &[-4.0]);
    let imported = load_one(&other).unwrap();
    assert_eq!(firsts(&imported.volume), [21.0, 11.0, 1.0]);
    assert!(imported.report.notes.iter().any(|note| note.contains("against the normal")));
}

#[test]
fn gated_spect_has_phases() {
    let spect = with_vectors(
        spect("RECON GATED TOMO", 6, -4.0),
        &[
            (RR_INTERVAL_VECTOR, &[1; 6]),
            (TIME_SLOT_VECTOR, &[1, 1, 1, 2, 2, 2]),
            (SLICE_VECTOR, &[1, 2, 3, 1, 2, 3]),
        ],
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spect.dcm");
    spect.write(&path, Syntax::Explicit);
    let series = load(&path).unwrap().report.series;
    assert_eq!((series.len(), series[0].phases, series[0].dims), (1, 2, [2, 1, 3]), "{series:?}");
    assert_eq!(firsts(&load_phase(&path, 1)), [21.0, 11.0, 1.0]);
    assert_eq!(firsts(&load_phase(&path, 2)), [51.0, 41.0, 31.0]);

    // A volume again and again, and one of two isotopes.
    let again: &[(u32, &[u16])] = &[(TIME_SLICE_VECTOR, &[1, 2, 1, 2]), (SLICE_VECTOR, &[1, 1, 2, 2])];
    with_vectors(self::spect("RECON TOMO", 4, 4.0), again).write(&path, Syntax::Explicit);
    assert_eq!(firsts(&load_phase(&path, 1)), [1.0, 21.0]);
    assert_eq!(firsts(&load_phase(&path, 2)), [11.0, 31.0]);
    let windows: &[(u32, &[u16])] = &[(ENERGY_WINDOW_VECTOR, &[1, 1, 2, 2]), (SLICE_VECTOR, &[1, 2, 1, 2])];
    with_vectors(self::spect("RECON TOMO", 4, 4.0), windows).write(&path, Syntax::Explicit);
    let imported = load(&path).unwrap();
    let found: Vec<_> =
        imported.report.series.iter().map(|s| (s.phases, s.dims, s.description.as_str())).collect();
    assert_eq!(
        found,
        [
            (1, [2, 1, 2], "NM series 7, 2 slices, 2 x 1, energy window 1"),
            (1, [2, 1, 2], "NM series 7, 2 slices, 2 x 1, energy window 2")
        ]
    );
    // A vector that is too short is no vector.
    let short: &[(u32, &[u16])] = &[(SLICE_VECTOR, &[1, 2, 3])];
    let error = load_one(&with_vectors(self::spect("RECON TOMO", 4, 4.0), short)).unwrap_err().to_string();
    assert!(error.contains("SliceVector (0054,0080) has 3 values for 4 frames"), "{error}");
}

#[test]
fn planar_nuclear_medicine_is_no_volume() {
    let kinds: [(&str, &[u32]); 5] = [
        ("WHOLE BODY", &[ENERGY_WINDOW_VECTOR, DETECTOR_VECTOR]),
        ("STATIC", &[ENERGY_WINDOW_VECTOR, DETECTOR_VECTOR]),
        ("DYNAMIC", &[ENERGY_WINDOW_VECTOR, DETECTOR_VECTOR, PHASE_VECTOR, TIME_SLICE_VECTOR]),
        ("GATED", &[ENERGY_WINDOW_VECTOR, DETECTOR_VECTOR, RR_INTERVAL_VECTOR, TIME_SLOT_VECTOR]),
        ("TOMO", &[ENERGY_WINDOW_VECTOR, DETECTOR_VECTOR, ROTATION_VECTOR, ANGULAR_VIEW_VECTOR]),
    ];
    for (kind, vectors) in kinds {
        let vectors: Vec<(u32, &[u16])> = vectors.iter().map(|tag| (*tag, &[1u16, 2][..])).collect();
        assert_refused(&with_vectors(spect(kind, 2, 4.0), &vectors), "planar pictures (of nuclear medicine)");
        // By the vectors alone, and by the image type alone.
        let untold = spect(kind, 2, 4.0).without(IMAGE_TYPE);
        assert_refused(&with_vectors(untold, &vectors), "planar pictures (of nuclear medicine)");
        assert_refused(&spect(kind, 2, 4.0), "planar pictures (of nuclear medicine)");
    }
    // A single one is a picture, as others are.
    assert_eq!(load_one(&spect("STATIC", 1, 4.0)).unwrap().volume.dims(), [2, 1, 1]);
}

#[test]
fn reconstructions_of_several_detectors_lie_where_each_says() {
    let detector = |x: f64| {
        Elements::default()
            .decimals(IMAGE_POSITION_PATIENT, &[x, 6.0, 70.0])
            .decimals(IMAGE_ORIENTATION_PATIENT, &[0.0, 1.0, 0.0, -1.0, 0.0, 0.0])
    };
    let of = |detectors: Vec<Elements>| {
        let vectors: &[(u32, &[u16])] = &[(DETECTOR_VECTOR, &[1, 1, 2, 2]), (SLICE_VECTOR, &[1, 2, 1, 2])];
        with_vectors(spect("RECON TOMO", 4, 4.0), vectors).items(DETECTOR_INFORMATION_SEQUENCE, detectors)
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spect.dcm");
    of(vec![detector(5.0), detector(-50.0)]).write(&path, Syntax::Explicit);
    for (series, x) in [("1", 5.0), ("2", -50.0)] {
        let volume = load_series(&path, Some(series)).unwrap().volume;
        assert_eq!(volume.dims(), [2, 1, 2]);
        assert_eq!(volume.patient_from_voxel().translation, DVec3::new(x, 6.0, 70.0), "detector {series}");
    }
    // Where the second is described by nothing, its frames may lie anywhere.
    assert_refused(&of(vec![detector(5.0)]), "DetectorVector (0054,0020) counts 2 detectors, of which 1");
}
