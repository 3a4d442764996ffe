//! Simple bodies among simple things, in every position and sampling: what is what is known at each voxel.

mod common;

use std::sync::Mutex;

use lumivox_core::{
    CancelToken, Cancelled, Modality, Progress, Volume, Voxels,
    glam::{DAffine3, DMat3, DVec2, DVec3},
};
use lumivox_segmentation::{Class, segment};

use common::{run, share};

/// What is at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Truth {
    Air,
    Body,
    Lung,
    Gas,
    Thing,
}

use Truth::*;

/// How a scan is made.
#[derive(Clone, Copy)]
struct Scan {
    /// Voxels, and their size in mm.
    dims: [usize; 3],
    spacing: DVec3,
    /// How the patient lies on the table: turned around z, in degrees.
    turned: f64,
    /// The gantry's tilt, in degrees: slices are turned around x, and follow each other along z.
    tilt: f64,
    noise: f64,
    /// What lies outside the round field of view, in HU; none where it is square.
    padding: Option<f64>,
    /// The field of view's centre, in mm.
    center: DVec3,
}

impl Default for Scan {
    fn default() -> Self {
        Self {
            dims: [128, 128, 60],
            spacing: DVec3::new(3.4, 3.4, 5.0),
            turned: 0.0,
            tilt: 0.0,
            noise: 20.0,
            padding: None,
            center: DVec3::ZERO,
        }
    }
}

fn ellipse(p: DVec2, center: DVec2, radii: DVec2) -> f64 {
    ((p - center) / radii).length()
}

/// A chest with arms beside it. Its axes: x to the left, y to the back, z to the head, from -150 to 150 mm.
fn chest(p: DVec3) -> (f64, Truth) {
    let xy = p.truncate();
    // Narrower at the waist, and at the neck.
    let size = 1.0 - 0.10 * (p.z / 150.0).powi(2) - 0.25 * ((p.z - 110.0) / 40.0).clamp(0.0, 1.0);
    let trunk = ellipse(xy, DVec2::ZERO, DVec2::new(150.0, 100.0) * size);
    for side in [-1.0, 1.0] {
        let arm =
            ellipse(xy, DVec2::new(side * (172.0 + 0.04 * p.z), 25.0 + 0.05 * p.z), DVec2::new(30.0, 34.0));
        if arm < 1.0 {
            return (
                if arm < 0.3 {
                    400.0
                } else if arm < 0.85 {
                    55.0
                } else {
                    -95.0
                },
                Body,
            );
        }
        let lung = (p - DVec3::new(side * 68.0, -8.0, 40.0)) / DVec3::new(48.0, 66.0, 140.0);
        if lung.length() < 1.0 && trunk < 0.85 {
            return (-860.0, Lung);
        }
    }
    if (xy - DVec2::new(0.0, -15.0)).length() < 8.5 && p.z > 20.0 {
        return (-990.0, Gas);
    }
    if (p - DVec3::new(-40.0, -50.0, -120.0)).length() < 22.0 {
        return (-985.0, Gas);
    }
    if trunk >= 1.0 {
        return (-1000.0, Air);
    }
    let spine = ellipse(xy, DVec2::new(0.0, 62.0), DVec2::splat(18.0));
    (
        if spine < 1.0 {
            350.0
        } else if trunk > 0.9 {
            -100.0
        } else {
            50.0
        },
        Body,
    )
}

/// A table whose shell touches the back, a blanket, a cable, and specks.
fn things(p: DVec3) -> Option<f64> {
    let curve = 98.0 - 0.0012 * p.x * p.x;
    let below = p.y - curve;
    if p.x.abs() < 230.0 && ((1.0..4.5).contains(&below) || (45.0..48.5).contains(&below)) {
        return Some(120.0);
    }
    if p.x.abs() < 230.0 && (4.5..45.0).contains(&below) {
        return Some(-930.0);
    }
    let blanket = -128.0 + 8.0 * (p.x * 0.06 + p.z * 0.02).sin();
    if p.x.abs() < 190.0 && (p.y - blanket).abs() < 2.0 && p.z < 60.0 {
        return Some(-780.0);
    }
    // A cable over the chest, and one beside the table.
    let cable =
        DVec2::new(p.y + 140.0, p.z - 0.2 * p.x).length().min(DVec2::new(p.x - 205.0, p.y + 20.0).length());
    (cable < 2.6).then_some(1500.0)
}

fn noise(i: usize, sigma: f64) -> f64 {
    let mut hash = i as u64;
    let mut sum = -6.0;
    for _ in 0..12 {
        hash = (hash ^ 0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash ^= hash >> 29;
        sum += (hash >> 11) as f64 / (1u64 << 53) as f64;
    }
    sum * sigma
}

/// The scan, and the truth of its voxels.
fn scan(scan: Scan) -> (Volume, Vec<Truth>) {
    let [nx, ny, nz] = scan.dims;
    let (sine, cosine) = scan.tilt.to_radians().sin_cos();
    let matrix = DMat3::from_cols(
        DVec3::X * scan.spacing.x,
        DVec3::new(0.0, cosine, -sine) * scan.spacing.y,
        DVec3::Z * scan.spacing.z,
    );
    let middle = DVec3::new(nx as f64 - 1.0, ny as f64 - 1.0, nz as f64 - 1.0) / 2.0;
    let place = DAffine3::from_mat3_translation(matrix, scan.center - matrix * middle);
    let turn = DMat3::from_rotation_z(scan.turned.to_radians());
    let mut truth = Vec::with_capacity(nx * ny * nz);
    let mut samples = Vec::with_capacity(nx * ny * nz);
    for i in 0..nx * ny * nz {
        let voxel = DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
        let p = turn * place.transform_point3(voxel);
        let (mut hu, mut what) = chest(p);
        if let (Air, Some(thing)) = (what, things(p)) {
            (hu, what) = (thing, Thing);
        }
        hu += noise(i, scan.noise);
        let off = (voxel - middle).truncate() / DVec2::new(nx as f64 / 2.0, ny as f64 / 2.0);
        if let Some(padding) = scan.padding
            && off.length() > 1.0
        {
            (hu, what) = (padding, Air);
        }
        samples.push((hu.max(-3024.0) + 4000.0).round() as u16);
        truth.push(what);
    }
    let volume = Volume::new(scan.dims, Voxels::U16(samples), [1.0, -4000.0], place, Modality::Ct).unwrap();
    (volume, truth)
}

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
        pool.install(|| run(&volume))
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.labels, three.labels);
    assert_eq!(one.depth_below_skin_mm, three.depth_below_skin_mm);
    assert_eq!(one.report, three.report);
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
