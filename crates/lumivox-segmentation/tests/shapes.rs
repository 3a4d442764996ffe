//! Simple bodies among simple things, in every position and sampling: what is what is known at each voxel.

mod common;

use std::sync::Mutex;

use lumivox_core::{
    CancelToken, Cancelled, Modality, Progress, Volume, Voxels,
    glam::{DAffine3, DVec3},
};
use lumivox_segmentation::{Class, depth_below_skin, segment};

use common::{
    chest::{Scan, Truth::*, noise, scan},
    run, share,
};

fn check(name: &str, how: Scan) {
    let (volume, truth) = scan(how);
    let found = run(&volume);
    let patient = |class: Option<Class>| class.is_some_and(Class::is_patient);
    let kept = share(&found, |i| !matches!(truth[i], Air | Thing), patient);
    let removed = share(&found, |i| truth[i] == Thing, |class| !patient(class));
    let air = share(&found, |i| truth[i] == Air, |class| !patient(class));
    let lungs = share(&found, |i| truth[i] == Lung, |class| class == Some(Class::Lungs));
    let gas = share(&found, |i| truth[i] == Gas, |class| matches!(class, Some(Class::Gas | Class::Airways)));
    println!("{name}: kept {kept:.5}, removed {removed:.5}, air {air:.5}, lungs {lungs:.4}, gas {gas:.4}");
    assert!(kept >= 0.999, "{name}: {kept} of the patient kept");
    assert!(removed >= 0.995, "{name}: {removed} of the things removed");
    assert!(air >= 0.99, "{name}: {air} of the air is outside");
    assert!(lungs >= 0.97, "{name}: {lungs} of the lungs");
    assert!(gas >= 0.9, "{name}: {gas} of the gas");
    assert!(found.report.confidence >= 0.7, "{name}: {}", found.report);
}

#[test]
fn a_chest_whose_back_touches_the_table() {
    check("supine", Scan::default());
}

#[test]
fn the_table_is_found_on_any_side() {
    for turned in [90.0, 180.0, 250.0] {
        check(&format!("turned by {turned}"), Scan { turned, ..Scan::default() });
    }
}

#[test]
fn slices_of_a_tilted_gantry() {
    check("tilted", Scan { tilt: 20.0, ..Scan::default() });
}

#[test]
fn thick_slices_and_thin_ones() {
    check("thick", Scan { dims: [200, 200, 42], spacing: DVec3::new(2.2, 2.2, 7.0), ..Scan::default() });
    check("thin", Scan { dims: [140, 140, 280], spacing: DVec3::new(3.1, 3.1, 1.0), ..Scan::default() });
}

#[test]
fn the_noise_of_a_low_dose() {
    check("noisy", Scan { noise: 60.0, ..Scan::default() });
}

#[test]
fn round_fields_of_view_with_any_padding() {
    for padding in [-1024.0, -1500.0, -2000.0, -3024.0] {
        check(&format!("padded with {padding}"), Scan { padding: Some(padding), ..Scan::default() });
    }
    // Arms, table and a lung are cut.
    let center = DVec3::new(40.0, 0.0, 0.0);
    let spacing = DVec3::new(2.0, 2.0, 5.0);
    check("cut", Scan { padding: Some(-2000.0), center, spacing, ..Scan::default() });
    check("cut square", Scan { center, spacing, ..Scan::default() });
}

#[test]
fn labels_do_not_depend_on_the_number_of_threads() {
    let (volume, _) = scan(Scan::default());
    let on = |threads: usize| {
        let pool = lumivox_core_threads(threads);
        pool.install(|| {
            let found = run(&volume);
            let depth =
                depth_below_skin(&volume, &found.labels, Progress::SILENT, &CancelToken::new()).unwrap();
            (found, depth)
        })
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.0.labels, three.0.labels);
    assert_eq!(one.0.report, three.0.report);
    assert_eq!(one.1, three.1);
}

fn lumivox_core_threads(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

#[test]
fn progress_rises_to_its_end_and_cancel_is_heard_everywhere() {
    let (volume, _) = scan(Scan::default());
    let reports = Mutex::new(Vec::new());
    let progress = |_, done: u64, total: u64| reports.lock().unwrap().push((done, total));
    segment(&volume, Progress::new(&progress), &CancelToken::new()).unwrap();
    let reports = reports.into_inner().unwrap();
    assert!(reports.len() > 20 && reports.windows(2).all(|pair| pair[0].0 < pair[1].0), "{reports:?}");
    assert_eq!(reports.last().unwrap().0, reports.last().unwrap().1);
    for stop in [1, 160, 320, 450, 550, 700, 900] {
        let cancel = CancelToken::new();
        let progress = |_, done: u64, _| {
            if done >= stop {
                cancel.cancel();
            }
        };
        assert_eq!(segment(&volume, Progress::new(&progress), &cancel).unwrap_err(), Cancelled, "{stop}");
    }
}

#[test]
fn what_is_not_understood_stays_visible() {
    let dims = [40, 40, 40];
    let samples: Vec<u16> = (0..64_000).map(|i: usize| (i * 7919 % 977) as u16).collect();
    let id = DAffine3::IDENTITY;
    for modality in [Modality::Other, Modality::Pet, Modality::Ct, Modality::Mr] {
        let volume = Volume::new(dims, Voxels::U16(samples.clone()), [1.0, -1000.0], id, modality).unwrap();
        let found = run(&volume);
        assert!(found.report.confidence < 0.3 && !found.report.notes.is_empty(), "{}", found.report);
        assert!(found.labels.voxels().iter().all(|&label| label == Class::Body.value()), "{modality:?}");
    }
}

#[test]
fn values_that_are_no_hounsfield_units_are_noticed() {
    // A cone-beam CT without calibration: air at -700.
    let (volume, _) = scan(Scan::default());
    let Voxels::U16(stored) = volume.voxels() else { unreachable!() };
    let stored = stored.iter().map(|&s| (f64::from(s) * 0.7 + 1_200.0) as u16).collect();
    let place = volume.patient_from_voxel();
    let volume =
        Volume::new(volume.dims(), Voxels::U16(stored), [1.0, -4000.0], place, Modality::Ct).unwrap();
    let found = run(&volume);
    assert!(found.report.confidence < 0.3, "{}", found.report);
}

#[test]
fn scans_of_any_size_are_taken() {
    for dims in [[1, 1, 1], [5, 1, 1], [1, 1, 50], [64, 64, 1], [64, 64, 2], [1, 64, 64]] {
        for value in [0u16, 1000] {
            let samples = vec![value; dims.iter().product()];
            let place = DAffine3::from_scale(DVec3::new(3.0, 3.0, 0.3));
            for modality in [Modality::Ct, Modality::Mr] {
                let volume =
                    Volume::new(dims, Voxels::U16(samples.clone()), [1.0, -1000.0], place, modality).unwrap();
                assert_eq!(run(&volume).labels.dims(), dims);
            }
        }
    }
}

#[test]
fn an_mr_is_parted_into_body_and_air() {
    let (ct, truth) = scan(Scan::default());
    let samples = truth.iter().enumerate().map(|(i, what)| {
        let signal = match what {
            Body | Lung | Gas => 400.0 + 100.0 * (i as f64 * 0.001).sin(),
            _ => 8.0,
        };
        (signal + noise(i, 8.0)).max(0.0) as u16
    });
    let voxels = Voxels::U16(samples.collect());
    let mr = Volume::new(ct.dims(), voxels, [1.0, 0.0], ct.patient_from_voxel(), Modality::Mr).unwrap();
    let found = run(&mr);
    let body = Some(Class::Body);
    assert!(share(&found, |i| !matches!(truth[i], Air | Thing), |class| class == body) > 0.99);
    assert!(share(&found, |i| matches!(truth[i], Air | Thing), |class| class != body) > 0.98);
    assert!(found.report.confidence > 0.6);
}
