//! Which slices make one volume, and what becomes of slices at uneven places: what was measured comes out as it was
//! measured, and two scans at nearly the same places never make one.

use std::path::Path;

use crate::common::values;
use crate::writer::*;
use lumivox_core::{CancelToken, Progress, glam::DVec3};
use lumivox_import::{ImportOptions, Imported};

const ACQUISITION_NUMBER: u32 = 0x0020_0012;
const ACQUISITION_TIME: u32 = 0x0008_0032;
const CONTENT_TIME: u32 = 0x0008_0033;
const CONTRAST_BOLUS_AGENT: u32 = 0x0018_0010;
const SLICE_THICKNESS: u32 = 0x0018_0050;
const AIR: f64 = -1000.0;

/// Values of a slice, which no neighbour's values lead to.
fn samples(scan: usize, slice: usize) -> Vec<u16> {
    let mut random = Random((1000 * scan + slice) as u64);
    (0..6).map(|_| random.below(3000) as u16).collect()
}

/// A CT slice of 3 x 2 pixels.
fn slice(scan: usize, number: usize, z: f64) -> Elements {
    image("CT", 3, 2, samples(scan, number))
        .decimals(RESCALE_INTERCEPT, &[-1024.0])
        .decimals(IMAGE_POSITION_PATIENT, &[7.0, 8.0, z])
        .text(INSTANCE_NUMBER, "IS", &(number + 1).to_string())
}

fn write(folder: &Path, heights: &[f64]) {
    for (k, &z) in heights.iter().enumerate() {
        slice(0, k, z).write(&folder.join(format!("{k:03}")), Syntax::Explicit);
    }
}

fn load_as(folder: &Path, leave_gaps: bool, phase: Option<usize>) -> Imported {
    let mut options = ImportOptions::default();
    (options.leave_gaps, options.phase) = (leave_gaps, phase);
    lumivox_import::load(&[folder.to_owned()], &options, Progress::SILENT, &CancelToken::new()).unwrap()
}

/// Whether slice `z` of a volume is slice `number` of a scan, voxel for voxel.
fn is_slice(imported: &Imported, z: usize, scan: usize, number: usize) -> bool {
    let expected: Vec<f64> = samples(scan, number).iter().map(|&s| f64::from(s) - 1024.0).collect();
    values(&imported.volume)[6 * z..6 * (z + 1)] == expected
}

#[test]
fn uneven_slices_are_kept_on_their_common_grid() {
    // Multiples of 2.5 mm, none of them next to another; and as a writer rounds them.
    let even = [0.0, 7.5, 20.0, 135.0, 150.0, 162.5, 180.0];
    let rounded = [0.0, 7.54, 20.03, 134.96, 150.04, 162.46, 180.0];
    for heights in [even, rounded] {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &heights);
        for leave_gaps in [false, true] {
            let imported = load_as(folder.path(), leave_gaps, None);
            assert_eq!(imported.volume.dims(), [3, 2, 73]);
            assert_eq!(imported.volume.spacing_mm(), DVec3::new(1.0, 1.0, 2.5));
            let at: Vec<usize> = even.iter().map(|z| (z / 2.5) as usize).collect();
            for (number, &z) in at.iter().enumerate() {
                assert!(is_slice(&imported, z, 0, number), "slice {number}");
            }
            let words = if leave_gaps { "left empty" } else { "filled in from the neighbours' values" };
            let note = &imported.report.notes[0];
            assert!(
                note.starts_with("the slices lie unevenly, 7.") && note.contains("they stay as they are"),
                "{note}"
            );
            assert!(note.contains("73 slices 2.500 mm apart") && note.ends_with(words), "{note}");
            let empty: Vec<usize> = (0..73).filter(|z| !at.contains(z)).collect();
            assert_eq!(imported.report.empty_slices, if leave_gaps { empty } else { vec![] });
            if leave_gaps {
                let all = values(&imported.volume);
                let left = |z: usize| all[6 * z..6 * (z + 1)].iter().all(|value| *value == AIR);
                assert!((0..73).all(|z| at.contains(&z) != left(z)));
            }
        }
    }
}

#[test]
fn gaps_are_left_where_slices_have_no_grid_in_common() {
    let heights = [0.0, 4.0, 8.0, 9.13, 16.31, 23.77];
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &heights);
    let filled = load_as(folder.path(), false, None);
    assert!(
        filled.report.notes[0].contains("interpolated to 23 slices 1.080 mm apart"),
        "{:?}",
        filled.report.notes
    );
    let left = load_as(folder.path(), true, None);
    assert_eq!(left.volume.dims(), filled.volume.dims());
    let places: Vec<usize> =
        (0..6).map(|number| (0..23).find(|&z| is_slice(&left, z, 0, number)).unwrap()).collect();
    assert_eq!(left.report.empty_slices, (0..23).filter(|z| !places.contains(z)).collect::<Vec<_>>());
    let step = left.volume.spacing_mm().z;
    let off =
        heights.iter().zip(&places).map(|(z, place)| (z - *place as f64 * step).abs()).fold(0.0, f64::max);
    assert!(off < step / 2.0);
    let note = &left.report.notes[0];
    assert!(
        note.contains(&format!("up to {off:.3} mm beside its own")) && note.ends_with("left empty"),
        "{note}"
    );
    assert!(!note.contains("interpolated"), "{note}");
}

#[test]
fn a_grid_that_is_too_fine_is_said() {
    // On a step of a quarter of a millimetre there would be 19,867 slices.
    let mut heights = vec![0.0];
    for gap in [4.0, 250.25, 300.5, 300.75, 300.25, 1310.5, 2500.25] {
        heights.push(heights[heights.len() - 1] + gap);
    }
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &heights);
    let imported = load_as(folder.path(), false, None);
    let note = &imported.report.notes[0];
    assert!(note.contains("on a grid of 19867 slices 0.250 mm apart, which are too many"), "{note}");
    assert!(note.ends_with("interpolated to 1243 slices 3.999 mm apart"), "{note}");
    assert_eq!(imported.volume.dims()[2], 1243);
}

type Tell = fn(Elements, usize, usize) -> Elements;

fn clock(seconds: f64) -> String {
    let whole = seconds as u64;
    format!("10{:02}{:02}.{:03}", whole / 60, whole % 60, ((seconds - whole as f64) * 1000.0).round())
}

/// Writes scans of one series, each a first height, a step and a number of slices.
fn write_scans(folder: &Path, scans: &[(f64, f64, usize)], tell: Tell) {
    for (scan, &(first, step, slices)) in scans.iter().enumerate() {
        for k in 0..slices {
            let image = slice(scan, k, first + step * k as f64);
            tell(image, scan, k).write(&folder.join(format!("{scan} {k:03}")), Syntax::Explicit);
        }
    }
}

/// Asserts that `scans`, written as one series, are a phase each.
fn assert_phases(what: &str, scans: &[(f64, f64, usize)], tell: Tell) {
    let folder = tempfile::tempdir().unwrap();
    write_scans(folder.path(), scans, tell);
    for (scan, &(first, step, slices)) in scans.iter().enumerate() {
        let imported = load_as(folder.path(), false, Some(scan + 1));
        let series = &imported.report.series;
        assert_eq!(series.len(), 1, "{what}: {series:?}");
        assert_eq!(series[0].phases, scans.len(), "{what}: {series:?}");
        assert!(series[0].notes.iter().any(|note| note.ends_with(what)), "{what}: {:?}", series[0].notes);
        assert_eq!(imported.volume.dims()[2], slices, "{what}");
        let matrix = imported.volume.patient_from_voxel();
        assert!(matrix.translation.distance(DVec3::new(7.0, 8.0, first)) < 1e-9, "{what}");
        assert!((matrix.matrix3.z_axis.z - step).abs() < 1e-9, "{what}");
        assert!((0..slices).all(|z| is_slice(&imported, z, scan, z)), "{what}");
    }
}

#[test]
fn scans_at_nearly_the_same_places_are_phases() {
    let ways: [(&str, Tell); 6] = [
        ("acquisition", |e, scan, _| e.text(ACQUISITION_NUMBER, "IS", &(scan + 3).to_string())),
        ("time", |e, scan, _| e.text(ACQUISITION_TIME, "TM", &clock(40.0 * scan as f64))),
        // Each slice has a time of its own.
        ("time", |e, scan, k| e.text(CONTENT_TIME, "TM", &clock(40.0 * scan as f64 + 0.2 * k as f64))),
        (
            "contrast agent",
            |e, scan, _| {
                if scan == 0 { e } else { e.text(CONTRAST_BOLUS_AGENT, "LO", "SECRET^NAME") }
            },
        ),
        // Numbered on, at last.
        ("instance number", |e, scan, k| e.text(INSTANCE_NUMBER, "IS", &(100 * scan + k).to_string())),
        // Downwards.
        ("instance number", |e, scan, k| e.text(INSTANCE_NUMBER, "IS", &(100 * scan + 50 - k).to_string())),
    ];
    for (what, tell) in ways {
        let what = format!("told apart by {what}");
        // An offset of no simple part of the step; a third; a small one; and the second over a longer way.
        for second in [(0.7, 2.5, 12), (0.8333333, 2.5, 12), (0.1, 2.5, 12), (-20.8, 2.5, 30)] {
            assert_phases(&what, &[(0.0, 2.5, 12), second], tell);
        }
        if !what.ends_with("agent") {
            assert_phases(&what, &[(0.0, 2.5, 12), (0.7, 2.5, 12), (1.6, 2.5, 12)], tell);
        }
    }
    // Without contrast, and with the same twice.
    let three = [(0.0, 2.5, 12), (0.7, 2.5, 12), (1.6, 2.5, 12)];
    assert_phases("told apart by contrast agent and acquisition", &three, |e, scan, _| {
        let e = e.text(ACQUISITION_NUMBER, "IS", &[4, 4, 5][scan].to_string());
        if scan == 0 { e } else { e.text(CONTRAST_BOLUS_AGENT, "LO", "SECRET^NAME") }
    });
    // Thin slices and thick ones.
    assert_phases("told apart by acquisition", &[(0.0, 1.0, 30), (0.3, 2.5, 12)], ways[0].1);
}

#[test]
fn at_half_a_step_the_slices_own_distance_decides() {
    // As thick as their step: each scan leaves nothing out.
    assert_phases("told apart by acquisition", &[(0.0, 3.0, 10), (1.5, 3.0, 10)], |e, scan, _| {
        e.text(ACQUISITION_NUMBER, "IS", &scan.to_string()).decimals(SLICE_THICKNESS, &[3.0])
    });
    // Half as thick, or half as far from the next: one volume, every other slice of which was taken first.
    let ways: [Tell; 3] = [
        |e, scan, _| e.text(ACQUISITION_NUMBER, "IS", &scan.to_string()).decimals(SLICE_THICKNESS, &[1.5]),
        |e, scan, k| {
            let time = clock(90.0 * scan as f64 + 0.2 * k as f64);
            e.text(ACQUISITION_TIME, "TM", &time).decimals(SPACING_BETWEEN_SLICES, &[1.5])
        },
        // Nothing is known.
        |e, scan, _| e.text(ACQUISITION_NUMBER, "IS", &scan.to_string()),
    ];
    for tell in ways {
        assert_one(20, &[(0.0, 3.0, 10), (1.5, 3.0, 10)], tell);
        // The second begins below, or lacks its end.
        assert_one(21, &[(0.0, 3.0, 10), (-1.5, 3.0, 11)], tell);
        assert_one(19, &[(0.0, 3.0, 10), (1.5, 3.0, 9)], tell);
    }
    // Three times interleaved.
    assert_one(30, &[(0.0, 3.0, 10), (1.0, 3.0, 10), (2.0, 3.0, 10)], |e, scan, k| {
        let e = e.decimals(SPACING_BETWEEN_SLICES, &[1.0]).text(ACQUISITION_NUMBER, "IS", &scan.to_string());
        e.text(INSTANCE_NUMBER, "IS", &(100 * scan + k).to_string())
    });
}

/// Asserts that scans of one series make one volume of so many slices.
fn assert_one(slices: usize, scans: &[(f64, f64, usize)], tell: Tell) {
    let folder = tempfile::tempdir().unwrap();
    write_scans(folder.path(), scans, tell);
    let imported = load_as(folder.path(), false, None);
    let series = &imported.report.series;
    assert_eq!((series.len(), series[0].phases), (1, 1), "{series:?}");
    assert_eq!(imported.volume.dims()[2], slices, "{series:?}");
}

#[test]
fn what_merely_counts_slices_parts_nothing() {
    // A head, step by step: four slices at a time, each time another acquisition and later.
    let step: Vec<(f64, f64, usize)> = (0..6).map(|block| (10.0 * f64::from(block), 2.5, 4)).collect();
    assert_one(24, &step, |e, block, k| {
        e.text(ACQUISITION_NUMBER, "IS", &block.to_string())
            .text(ACQUISITION_TIME, "TM", &clock(3.0 * block as f64))
            .text(INSTANCE_NUMBER, "IS", &(4 * block + k + 1).to_string())
    });
    // Two such blocks of unequal steps, which meet.
    assert_one(24, &[(0.0, 2.5, 9), (22.5, 5.0, 8)], |e, block, _| {
        e.text(ACQUISITION_NUMBER, "IS", &block.to_string())
    });
    // Each slice its own; in the order of a writer who counts odd ones first.
    assert_one(20, &[(0.0, 2.5, 20)], |e, _, k| {
        let turn = if k % 2 == 0 { k / 2 } else { 10 + k / 2 };
        e.text(ACQUISITION_NUMBER, "IS", &turn.to_string())
            .text(ACQUISITION_TIME, "TM", &clock(2.0 * turn as f64))
            .text(INSTANCE_NUMBER, "IS", &(turn + 1).to_string())
    });
    // An interleaved volume that lacks a slice.
    let folder = tempfile::tempdir().unwrap();
    write_scans(folder.path(), &[(0.0, 3.0, 10), (1.5, 3.0, 10)], |e, scan, k| {
        let e = e.text(ACQUISITION_NUMBER, "IS", &scan.to_string()).decimals(SPACING_BETWEEN_SLICES, &[1.5]);
        e.text(INSTANCE_NUMBER, "IS", &(100 * scan + k).to_string())
    });
    std::fs::remove_file(folder.path().join("1 004")).unwrap();
    let imported = load_as(folder.path(), false, None);
    assert_eq!(imported.volume.dims()[2], 20);
    assert_eq!(imported.report.series[0].phases, 1);
    assert_eq!(imported.report.notes, ["1 of 20 slices is missing; filled in from the neighbours' values"]);
}

#[test]
fn times_as_far_apart_as_numbers_go_are_far_apart() {
    let folder = tempfile::tempdir().unwrap();
    for k in 0..6 {
        let time = if k < 5 { -1e17 } else { 1e17 };
        let slice = slice(0, k, k as f64).decimals(SLICE_THICKNESS, &[2.0]).decimals(0x0054_1300, &[time]);
        slice.write(&folder.path().join(k.to_string()), Syntax::Explicit);
    }
    assert_eq!(load_as(folder.path(), false, None).volume.dims(), [3, 2, 6]);
}

/// Slices of a CT 2 mm apart at heights from 0 to 10 mm, without that at 6 mm; `refuse` makes one of the slice that
/// belongs there.
fn with_refused(refuse: impl Fn(Elements) -> Elements) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for k in 0..6u16 {
        let slice = image("CT", 2, 1, vec![100 * k, 7])
            .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 2.0 * f64::from(k)])
            .text(INSTANCE_NUMBER, "IS", &k.to_string());
        let slice = if k == 3 { refuse(slice) } else { slice };
        slice.write(&folder.path().join(k.to_string()), Syntax::Explicit);
    }
    folder
}

#[test]
fn nothing_is_made_up_for_a_slice_that_is_refused() {
    type Refuse = fn(Elements) -> Elements;
    let refusals: [(&str, Refuse); 4] = [
        ("nan", |slice| slice.text(IMAGE_POSITION_PATIENT, "DS", "0\\0\\nan")),
        ("far", |slice| slice.text(IMAGE_POSITION_PATIENT, "DS", "0\\0\\1e39")),
        ("slope", |slice| slice.decimals(RESCALE_SLOPE, &[0.0])),
        ("no place", |slice| slice.without(IMAGE_POSITION_PATIENT)),
    ];
    let note = "1 of 6 slices is missing; left empty, for damaged files may belong there";
    for (name, refuse) in refusals {
        let folder = with_refused(refuse);
        let imported = load_as(folder.path(), false, None);
        assert_eq!(imported.report.empty_slices, [3], "{name}");
        assert!(imported.report.notes.contains(&note.to_owned()), "{name}: {:?}", imported.report.notes);
        // Of another series it belongs nowhere here.
        let folder = with_refused(|slice| refuse(slice).text(SERIES_INSTANCE_UID, "UI", "1.2.4"));
        assert!(load_as(folder.path(), false, None).report.empty_slices.is_empty(), "{name}");
    }
}

#[test]
fn what_is_said_of_gaps_is_the_same_before_and_after_loading() {
    let refused = with_refused(|slice| slice.decimals(RESCALE_SLOPE, &[0.0]));
    let missing = with_refused(|slice| slice);
    std::fs::remove_file(missing.path().join("3")).unwrap();
    let uneven = tempfile::tempdir().unwrap();
    for (k, z) in [0.0, 4.0, 8.0, 9.13, 16.31, 23.77].into_iter().enumerate() {
        image("CT", 2, 1, vec![k as u16, 7])
            .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, z])
            .write(&uneven.path().join(k.to_string()), Syntax::Explicit);
    }
    for (folder, words) in [
        (&refused, ["left empty, for damaged files may belong there", "left empty"]),
        (&missing, ["filled in from the neighbours' values", "left empty"]),
        (&uneven, ["interpolated", "left empty"]),
    ] {
        for (leave_gaps, words) in [false, true].into_iter().zip(words) {
            let mut options = ImportOptions::default();
            options.leave_gaps = leave_gaps;
            let paths = [folder.path().to_owned()];
            let table =
                lumivox_import::scan(&paths, &options, Progress::SILENT, &CancelToken::new()).unwrap();
            let loaded = load_as(folder.path(), leave_gaps, None).report;
            let told = loaded.notes.iter().find(|note| note.contains(words)).unwrap_or_else(|| {
                panic!("'{words}' is missing: {:?}", loaded.notes);
            });
            for notes in [&table.notes, &table.series[0].notes, &loaded.series[0].notes] {
                assert!(notes.contains(told), "{told}: {notes:?}");
            }
        }
    }
}

#[test]
fn slices_that_do_not_say_how_they_lie() {
    let load = |step: [f64; 3]| {
        let folder = tempfile::tempdir().unwrap();
        for k in 0..6 {
            slice(0, k, 0.0)
                .decimals(IMAGE_POSITION_PATIENT, &step.map(|step| step * k as f64))
                .without(IMAGE_ORIENTATION_PATIENT)
                .write(&folder.path().join(format!("{k:03}")), Syntax::Explicit);
        }
        crate::common::load(folder.path())
    };
    let axial = load([0.0, 0.0, 3.0]).unwrap();
    assert_eq!(axial.volume.dims(), [3, 2, 6]);
    let notes = &axial.report.notes;
    assert!(
        notes.iter().any(|note| note.contains("(0020,0037) is missing: slices are taken as axial")),
        "{notes:?}"
    );
    // Sagittal ones, and oblique ones.
    for step in [[3.0, 0.0, 0.0], [0.0, 3.0, 0.5]] {
        let error = load(step).unwrap_err().to_string();
        assert!(error.contains("(0020,0037)") && error.contains("not those of the axial slices"), "{error}");
    }
}
