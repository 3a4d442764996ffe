//! The patient alone: what becomes air, and what stays as it was.

mod common;

use lumivox_core::{
    CancelToken, Cancelled, Modality, Progress, Volume, Voxels,
    glam::{DAffine3, DVec3},
};
use lumivox_segmentation::{
    Class, DEPTH_STEP_MM, PatientAlone, depth_below_skin, patient_alone, peel, peel_skin, skin_is_dense,
};

use common::chest::{Scan, Truth, scan};

fn alone(volume: Volume) -> PatientAlone {
    patient_alone(volume, Progress::SILENT, &CancelToken::new()).unwrap()
}

/// The same scan with other samples: `samples` of the physical values, which are `stored * slope + intercept`.
fn stored_as(volume: &Volume, rescale: [f64; 2], samples: impl FnOnce(&[f64]) -> Voxels) -> Volume {
    let values: Vec<f64> = (0..volume.voxel_count())
        .map(|i| volume.voxels().get(i) * volume.slope() + volume.intercept())
        .collect();
    let stored: Vec<f64> = values.iter().map(|value| (value - rescale[1]) / rescale[0]).collect();
    Volume::new(volume.dims(), samples(&stored), rescale, volume.patient_from_voxel(), Modality::Ct).unwrap()
}

#[test]
fn things_become_air_and_the_patient_stays() {
    let (volume, truth) = scan(Scan::default());
    let found = alone(volume.clone());
    let note = found.note().unwrap();
    assert!(note.starts_with("hidden: table and supports (") && note.contains("other objects ("), "{note}");
    let (mut things, mut visible, mut lost, mut air, mut air_changed) = (0, 0, 0, 0, 0);
    let mut changed = 0;
    for (i, &what) in truth.iter().enumerate() {
        let value = |volume: &Volume| volume.voxels().get(i) + volume.intercept();
        let (before, after) = (value(&volume), value(&found.volume));
        changed += usize::from(before != after);
        match what {
            Truth::Thing => {
                things += 1;
                visible += usize::from(after > -700.0);
            }
            Truth::Air => {
                air += 1;
                air_changed += usize::from(before != after);
            }
            _ => lost += usize::from(before != after),
        }
    }
    let all = truth.len();
    let around = found.surroundings.unwrap();
    assert_eq!((around.voxel_count(), found.changed), (changed, changed));
    assert!(around.put_back(&found.volume).unwrap().voxels() == volume.voxels(), "it comes back to the bit");
    println!(
        "{things} things of {all}, {visible} visible, {lost} lost, {air_changed} of {air} of air changed"
    );
    assert!(things > 20_000, "{things}");
    assert!((visible as f64) < 0.005 * things as f64, "{visible} of {things} things are visible");
    assert!((lost as f64) < 0.0005 * all as f64, "{lost} voxels of the patient changed");
    // Only the rim of things.
    assert!((air_changed as f64) < 0.35 * air as f64, "{air_changed} of {air} of the air changed");
    assert_eq!(changed, found.changed);
}

#[test]
fn samples_of_any_type_give_the_same_picture() {
    let (volume, _) = scan(Scan { noise: 0.0, ..Scan::default() });
    let floats = stored_as(&volume, [1.0, 0.0], |all| Voxels::F32(all.iter().map(|&v| v as f32).collect()));
    let falling =
        stored_as(&volume, [-1.0, 3000.0], |all| Voxels::U16(all.iter().map(|v| v.round() as u16).collect()));
    let bytes =
        stored_as(&volume, [12.0, -1024.0], |all| Voxels::U8(all.iter().map(|v| v.round() as u8).collect()));
    let value = |volume: &Volume, i: usize| volume.voxels().get(i) * volume.slope() + volume.intercept();
    let wanted = alone(volume);
    assert!(wanted.changed > 20_000);
    for (name, other, tolerance) in
        [("floats", floats, 0.5), ("falling", falling, 0.5), ("bytes", bytes, 12.0)]
    {
        let other = alone(other);
        let unlike = (0..other.volume.voxel_count())
            .filter(|&i| (value(&other.volume, i) - value(&wanted.volume, i)).abs() > tolerance)
            .count();
        // Coarser values may fall on the other side of a threshold.
        assert!(unlike < 2_000, "{name}: {unlike} voxels differ");
    }
}

#[test]
fn a_ct_of_which_nothing_says_that_it_is_one_is_taken_for_one() {
    let (volume, _) = scan(Scan::default());
    let known = alone(volume.clone());
    let found = alone(volume.with_modality(Modality::Other));
    let (known, found) = (known.report.unwrap(), found.report.unwrap());
    assert_eq!(found.findings, known.findings);
    assert!(found.confidence < known.confidence && found.notes.len() == known.notes.len() + 1, "{found}");
}

#[test]
fn nobody_is_as_large_as_a_house() {
    let place = DAffine3::from_scale(DVec3::splat(40.0));
    let (small, _) = scan(Scan::default());
    let large =
        Volume::new(small.dims(), small.voxels().clone(), [1.0, -4000.0], place, Modality::Ct).unwrap();
    let found = alone(large);
    assert_eq!(found.changed, 0);
    let note = found.note().unwrap();
    assert!(note.contains("large for a body"), "{note}");
}

#[test]
fn a_scan_that_is_not_understood_comes_back_as_it_was() {
    let samples: Vec<u16> = (0..64_000).map(|i: usize| (i * 7919 % 977) as u16).collect();
    for (modality, says) in [(Modality::Ct, true), (Modality::Mr, false), (Modality::Pet, false)] {
        let voxels = Voxels::U16(samples.clone());
        let volume = Volume::new([40; 3], voxels, [1.0, -1000.0], DAffine3::IDENTITY, modality).unwrap();
        let found = alone(volume.clone());
        assert_eq!(found.volume.voxels(), volume.voxels());
        assert_eq!((found.changed, found.report.is_some()), (0, says));
        let note = found.note();
        assert_eq!(note.is_some(), says, "{note:?}");
        if let Some(note) = note {
            assert!(note.contains("stays visible") && note.contains(": "), "{note}");
        }
    }
}

#[test]
fn it_can_be_cancelled_to_its_end() {
    let (volume, _) = scan(Scan::default());
    for stop in [1, 400, 720, 900] {
        let cancel = CancelToken::new();
        let progress = |_, done: u64, total: u64| {
            assert!(done <= total);
            if done >= stop {
                cancel.cancel();
            }
        };
        let ended = patient_alone(volume.clone(), Progress::new(&progress), &cancel);
        assert_eq!(ended.unwrap_err(), Cancelled, "{stop}");
    }
}

#[test]
fn a_peeled_patient_is_as_deep_everywhere() {
    let (volume, _) = scan(Scan { noise: 0.0, ..Scan::default() });
    let (silent, cancel) = (Progress::SILENT, CancelToken::new());
    let found = alone(volume);
    let labels = found.labels.unwrap();
    let depth = depth_below_skin(&found.volume, &labels, silent, &cancel).unwrap();
    let mm = 16.0;
    let peeled = peel(found.volume.clone(), &labels, mm, silent, &cancel).unwrap();
    // The surface is smooth over so much.
    let width = 4.0 * found.volume.spacing_mm().min_element();
    let (mut skin, mut inner, mut border) = (0, 0, 0);
    for (i, &label) in labels.voxels().iter().enumerate() {
        let value = |volume: &Volume| volume.voxels().get(i) + volume.intercept();
        let (before, after) = (value(&found.volume), value(&peeled));
        let deep = f64::from(depth.steps()[i]) * f64::from(DEPTH_STEP_MM);
        match Class::of(label) {
            Some(Class::Air) => assert_eq!(after, -1000.0),
            Some(class) if class.is_patient() && deep > mm + width => {
                inner += 1;
                assert_eq!(after, before);
            }
            Some(class) if class.is_patient() && deep < mm - width => {
                skin += 1;
                assert_eq!(after, -1000.0);
            }
            Some(class) if class.is_patient() => {
                border += 1;
                assert!(after >= -1000.0 && after <= before.max(-1000.0), "{before} became {after}");
            }
            _ => assert_eq!(after, before),
        }
    }
    assert!(skin > 5_000 && border > 5_000 && inner > 50_000, "{skin} {border} {inner}");
    let stopped = CancelToken::new();
    stopped.cancel();
    assert_eq!(peel(peeled, &labels, mm, silent, &stopped).unwrap_err(), Cancelled);
}

/// A block with a sheet of 4 mm on it, as an ear is on a head.
#[test]
fn an_ear_keeps_its_inner_sheet() {
    let ear =
        |at: [usize; 3]| at[0] >= 92 && at[0] < 112 && (60..64).contains(&at[1]) && (40..88).contains(&at[2]);
    let block = |at: [usize; 3]| at.iter().all(|at| (32..92).contains(at));
    let samples = (0..128usize.pow(3)).map(|i| {
        let at = [i % 128, i / 128 % 128, i / 128 / 128];
        match () {
            () if ear(at) => 1050,
            () if block(at) && at[2] < 60 => 900,
            () if block(at) => 1050,
            () => 0,
        }
    });
    let voxels = Voxels::U16(samples.collect());
    let volume = Volume::new([128; 3], voxels, [1.0, -1000.0], DAffine3::IDENTITY, Modality::Ct).unwrap();
    let (silent, cancel) = (Progress::SILENT, CancelToken::new());
    let found = alone(volume);
    let labels = found.labels.unwrap();
    assert_eq!(Class::of(labels.value([106, 61, 60])), Some(Class::Body), "the ear is the patient's");
    let skin = peel_skin(found.volume.clone(), &labels, 2.0, silent, &cancel).unwrap();
    let all = peel(found.volume, &labels, 2.0, silent, &cancel).unwrap();
    for (x, z) in [(100, 50), (106, 64), (108, 80)] {
        // The ear's two inner voxels stay, of its outer ones little does.
        let [outer, inner] = [60, 61].map(|y| skin.value([x, y, z]));
        assert!(outer < -500.0 && inner > -200.0, "{outer} {inner} at {x}, {z}");
        assert!(all.value([x, 61, z]) < -400.0 && all.value([x, 60, z]) == -1000.0);
    }
    // The block loses as much either way.
    for y in 32..40 {
        assert_eq!(skin.value([50, y, 75]), all.value([50, y, 75]), "{y}");
    }
    let [outer, inner] = [33, 35].map(|y| skin.value([50, y, 75]));
    assert!(outer < -900.0 && inner == 50.0, "{outer} {inner}");
}

/// A slope that rises by a voxel in six has no stairs after it was peeled.
#[test]
fn what_is_left_has_no_stairs() {
    let [n, slope, top] = [96.0, 1.0 / 6.0, 20.0];
    let samples = (0..96usize.pow(3)).map(|i| {
        let [x, y, z] = [i % 96, i / 96 % 96, i / 96 / 96].map(|at| at as f64);
        let inside =
            y > top + slope * x && y < n - 10.0 && (8.0..n - 8.0).contains(&x) && (8.0..n - 8.0).contains(&z);
        if !inside {
            0
        } else if z < 60.0 {
            900
        } else {
            1050
        }
    });
    let voxels = Voxels::U16(samples.collect());
    let volume = Volume::new([96; 3], voxels, [1.0, -1000.0], DAffine3::IDENTITY, Modality::Ct).unwrap();
    let found = alone(volume);
    let (silent, cancel) = (Progress::SILENT, CancelToken::new());
    let mm = 4.0;
    let peeled = peel(found.volume, &found.labels.unwrap(), mm, silent, &cancel).unwrap();
    // Where the value is half way, along y.
    let surface = |x: usize| {
        let value = |y: usize| peeled.value([x, y, 75]);
        let y = (0..95).find(|&y| value(y + 1) > -475.0).unwrap();
        y as f64 + (-475.0 - value(y)) / (value(y + 1) - value(y))
    };
    let tilt = slope.hypot(1.0);
    let errors: Vec<f64> = (30..66).map(|x| surface(x) - (top + slope * x as f64 + mm * tilt)).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let spread =
        (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt();
    println!("off by {mean:.3} +- {spread:.3} voxels");
    assert!(mean.abs() < 0.5, "{errors:?}");
    // Stairs of a voxel stray by .29.
    assert!(spread < 0.1, "{errors:?}");
}

#[test]
fn skin_hides_muscle_where_it_is_as_dense() {
    let skin_of = |thick: usize, spacing_mm: f64| {
        let samples = (0..96usize.pow(3)).map(|i| {
            let deepest = [i % 96, i / 96 % 96, i / 96 / 96].map(|at| at.min(95 - at).saturating_sub(19));
            match deepest.into_iter().min().unwrap() {
                0 => 0,
                depth if depth <= thick => 1040,
                depth if depth <= 10 => 900,
                _ => 1050,
            }
        });
        let (voxels, place) =
            (Voxels::U16(samples.collect()), DAffine3::from_scale(DVec3::splat(spacing_mm)));
        let found = alone(Volume::new([96; 3], voxels, [1.0, -1000.0], place, Modality::Ct).unwrap());
        skin_is_dense(&found.volume, &found.labels.unwrap())
    };
    assert!(skin_of(2, 1.0));
    // None, and a fat rim that is wider than skin.
    assert!(!skin_of(0, 1.0) && !skin_of(0, 2.0));
}
