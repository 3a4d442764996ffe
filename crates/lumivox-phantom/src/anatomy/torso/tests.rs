#![allow(clippy::disallowed_methods, reason = "tests round as they like")]

use std::sync::LazyLock;

use glam::Vec3;

use super::*;
use crate::{
    AIR_HU,
    anatomy::tests::{around, tissue},
    noise::hash64,
    sdf::at,
};

/// The default patient, with metal, under a blanket.
static MODEL: LazyLock<Model> = LazyLock::new(|| {
    model(&TorsoOptions { metal: Metal::SternalWires, blanket: true, ..TorsoOptions::default() })
});

fn small(size: usize) -> TorsoOptions {
    TorsoOptions { size, noise_hu: 0.0, ..TorsoOptions::default() }
}

fn grow(options: TorsoOptions) -> Volume {
    torso(options, Progress::SILENT, &CancelToken::new()).unwrap()
}

fn parts(options: TorsoOptions) -> Vec<TorsoPart> {
    let numbers = torso_parts(options, Progress::SILENT, &CancelToken::new()).unwrap();
    numbers.into_iter().map(|n| TorsoPart::from_number(n).unwrap()).collect()
}

fn part(place: Vec3) -> TorsoPart {
    raster::part_at(&MODEL, place).and_then(TorsoPart::from_number).unwrap_or(TorsoPart::OutsideAir)
}

#[test]
fn tissues_have_credible_values_and_the_truth_knows_them() {
    let expect = |wanted: TorsoPart, place: Vec3, range: std::ops::Range<f64>| {
        let hu = tissue(&MODEL, place);
        assert!(range.contains(&hu), "{wanted:?} at {place}: {hu} HU, not in {range:?}");
        assert_eq!(part(place), wanted, "at {place}, {hu} HU");
    };
    expect(TorsoPart::OutsideAir, at(0.0, -160.0, 0.0), -1001.0..-999.0);
    expect(TorsoPart::AirwayAir, at(-1.0, 0.0, 144.0), -1001.0..-950.0);
    expect(TorsoPart::AirwayAir, at(20.0, 21.0, 78.0), -1001.0..-950.0);
    expect(TorsoPart::Lung, at(-96.0, 20.0, 44.0), -950.0..-780.0);
    expect(TorsoPart::Lung, at(98.0, 40.0, 20.0), -950.0..-780.0);
    expect(TorsoPart::Fat, at(6.0, -40.0, 108.0), -130.0..-60.0);
    expect(TorsoPart::Artery, at(13.0, 16.0, -40.0), 280.0..330.0);
    expect(TorsoPart::Artery, at(38.0, -26.0, 25.0), 270.0..330.0);
    expect(TorsoPart::PulmonaryArtery, at(14.0, -36.0, 86.0), 250.0..310.0);
    expect(TorsoPart::Vein, at(-25.0, 2.0, -40.0), 120.0..180.0);
    expect(TorsoPart::Myocardium, at(46.0, -2.0, 14.0), 80.0..130.0);
    expect(TorsoPart::Liver, at(-100.0, -20.0, -80.0), 60.0..120.0);
    expect(TorsoPart::Spleen, at(106.0, 36.0, -74.0), 70.0..150.0);
    expect(TorsoPart::Kidney, at(86.0, 48.0, -108.0), 150.0..240.0);
    expect(TorsoPart::GutGas, at(60.0, -46.0, -90.0), -1001.0..-950.0);
    expect(TorsoPart::Muscle, at(36.0, 82.0, -150.0), 20.0..95.0);
    expect(TorsoPart::Bone, at(0.0, 49.0, 31.0), 100.0..420.0);
    expect(TorsoPart::SpinalCanal, at(0.0, 72.0, 31.0), 0.0..60.0);
    expect(TorsoPart::Mattress, at(0.0, 124.0, -40.0), -940.0..-860.0);
    expect(TorsoPart::Table, at(0.0, 150.0, -40.0), -960.0..-890.0);
    let hardest = |place: Vec3| around(&MODEL, place, 6.0, 0.75).into_iter().fold(f64::MIN, f64::max);
    assert!((600.0..1300.0).contains(&hardest(at(0.0, 60.0, 53.0))), "lamina");
    let wire = LazyLock::force(&MODEL);
    let metal = around(wire, body::cage().at(0.0, 68.0, 14.0), 3.0, 0.4).into_iter().fold(f64::MIN, f64::max);
    assert!(metal > 2900.0, "a wire has {metal} HU");
}

#[test]
fn the_torso_has_the_size_of_an_adult() {
    let options = TorsoOptions { table: false, ..small(46) };
    let volume = grow(options);
    let spacing = volume.spacing_mm().x;
    let slice = ((30.0 - volume.patient_from_voxel().translation.z) / spacing).round() as usize;
    let extent = |axis: usize| {
        let hits: Vec<usize> = (0..46 * 46)
            .map(|i| [i % 46, i / 46, slice])
            .filter(|v| volume.value(*v) > -500.0)
            .map(|v| v[axis])
            .collect();
        (hits.iter().max().unwrap() - hits.iter().min().unwrap() + 1) as f64 * spacing
    };
    assert!((318.0..358.0).contains(&extent(0)), "width {}", extent(0));
    assert!((213.0..243.0).contains(&extent(1)), "depth {}", extent(1));
    assert_eq!(volume.modality(), Modality::Ct);
    assert!(volume.size_mm().distance(DVec3::splat(TORSO_FIELD_OF_VIEW_MM)) < 1e-9);
    assert!(volume.center_mm().distance(CENTER_MM) < 1e-9);
}

#[test]
fn twelve_ribs_on_each_side() {
    // From the neck down along the side, as far behind as the last ribs reach.
    let cage = body::cage();
    let count = |side: f32| {
        let bony = |z: f32| {
            let p = cage.at(if z < -90.0 { 2.35 } else { 2.5 } * side, z, 4.6);
            part(p) == TorsoPart::Bone
        };
        let heights: Vec<bool> = (-130..172).map(|z| bony(z as f32)).collect();
        heights.windows(2).filter(|w| !w[0] && w[1]).count()
    };
    let [left, right] = [1.0, -1.0].map(count);
    assert_eq!(left, right);
    assert!((11..=13).contains(&left), "{left} ribs");
}

#[test]
fn bone_is_as_much_on_both_sides() {
    let parts = parts(small(40));
    let bone = |right: bool| {
        let here = |i: &usize| (i % 40 < 20) == right && parts[*i] == TorsoPart::Bone;
        (0..parts.len()).filter(here).count() as f64
    };
    let ratio = bone(true) / bone(false);
    assert!((0.93..1.07).contains(&ratio), "{ratio}");
}

#[test]
fn the_airways_are_connected_from_the_windpipe_on() {
    // The window of the lungs' upper part, fine enough for the lobar bronchi.
    let options = TorsoOptions { field_of_view_mm: 150.0, shift_mm: [0.0, 4.0, 80.0], ..small(78) };
    let parts = parts(options);
    let n = options.size;
    let is_air = |i: usize| parts[i] == TorsoPart::AirwayAir;
    let top = (n * n * (n - 1)..n * n * n).find(|i| is_air(*i)).expect("the windpipe enters at the top");
    let mut seen = vec![false; parts.len()];
    let mut open = vec![top];
    seen[top] = true;
    let mut reached = 0;
    while let Some(i) = open.pop() {
        reached += 1;
        let (x, y, z) = (i % n, i / n % n, i / (n * n));
        let steps =
            [(x > 0, i.wrapping_sub(1)), (x + 1 < n, i + 1), (y > 0, i.wrapping_sub(n)), (y + 1 < n, i + n)];
        let across = [(z > 0, i.wrapping_sub(n * n)), (z + 1 < n, i + n * n)];
        for (inside, j) in steps.into_iter().chain(across) {
            if inside && is_air(j) && !seen[j] {
                seen[j] = true;
                open.push(j);
            }
        }
    }
    let all = (0..parts.len()).filter(|i| is_air(*i)).count();
    // Those of a voxel's size come and go.
    assert!(reached * 100 > 90 * all, "{reached} of {all} voxels of air hang together");
    let carina = airways::CARINA;
    assert!(seen.iter().enumerate().any(|(i, s)| *s && i / (n * n) < n / 3), "as far as the lower lobes");
    assert_eq!(part(carina + at(-12.0, 0.0, -8.0)), TorsoPart::AirwayAir);
}

#[test]
fn the_truth_agrees_with_the_values() {
    // Of the whole field of view, and of a window of the right lower chest.
    let all = TorsoOptions { blanket: true, padding: true, metal: Metal::Rod, ..small(36) };
    let window = TorsoOptions { field_of_view_mm: 110.0, shift_mm: [-50.0, 0.0, -20.0], ..all };
    for options in [all, window] {
        let (volume, parts) = (grow(options), parts(options));
        let n = options.size;
        let (mut checked, mut wrong) = (0, 0);
        for i in 0..parts.len() {
            let [x, y, z] = [i % n, i / n % n, i / (n * n)];
            let part = parts[i];
            let hu = volume.value([x, y, z]);
            if part == TorsoPart::Padding {
                assert_eq!(hu, INTERCEPT);
                continue;
            }
            // At borders, values mix.
            let inner = [x, y, z].into_iter().all(|c| (1..n - 1).contains(&c));
            let near = [1, n, n * n].into_iter().flat_map(|s| [i.wrapping_sub(s), i + s]);
            if !inner || near.into_iter().any(|j| parts[j] != part) {
                continue;
            }
            let range = match part {
                TorsoPart::OutsideAir | TorsoPart::AirwayAir | TorsoPart::GutGas => -1024.0..-800.0,
                TorsoPart::Lung => -960.0..-500.0,
                TorsoPart::Table | TorsoPart::Mattress => -1000.0..-300.0,
                TorsoPart::Fat => -150.0..0.0,
                TorsoPart::Muscle | TorsoPart::Liver | TorsoPart::Spleen => -60.0..160.0,
                TorsoPart::Artery | TorsoPart::PulmonaryArtery | TorsoPart::PulmonaryVein => 180.0..340.0,
                TorsoPart::Bone => 50.0..1400.0,
                _ => continue,
            };
            checked += 1;
            wrong += usize::from(!range.contains(&hu));
        }
        assert!(checked * 8 > parts.len(), "{checked} voxels lie inside of something");
        assert!(wrong * 20 < checked, "{wrong} of {checked} have another value than their part");
        // Points say what voxels say.
        let truth = TorsoTruth::new(options);
        for i in (0..parts.len()).step_by(1511).filter(|i| parts[*i] != TorsoPart::Padding) {
            let voxel = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / (n * n)) as f64);
            assert_eq!(truth.part(volume.patient_from_voxel().transform_point3(voxel)), parts[i]);
        }
        if options == all {
            for part in [TorsoPart::Table, TorsoPart::Mattress, TorsoPart::Blanket, TorsoPart::Padding] {
                assert!(parts.contains(&part), "{part:?}");
            }
        }
    }
}

#[test]
fn the_same_options_give_the_same_torso_on_any_number_of_threads() {
    let options = TorsoOptions { size: 20, ..TorsoOptions::default() };
    let first = grow(options);
    let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(first.voxels(), single.install(|| grow(options)).voxels());
    assert_ne!(first.voxels(), grow(TorsoOptions { seed: 2, ..options }).voxels());
}

#[test]
fn options_change_what_they_say() {
    let plain = small(20);
    let count = |options: TorsoOptions, wanted: fn(TorsoPart) -> bool| {
        parts(options).into_iter().filter(|p| wanted(*p)).count()
    };
    assert_eq!(count(TorsoOptions { table: false, ..plain }, TorsoPart::is_equipment), 0);
    assert!(count(plain, TorsoPart::is_equipment) > 60);
    assert!(count(TorsoOptions { breasts: true, ..plain }, |p| p == TorsoPart::Gland) > 1);
    let wide = TorsoOptions { field_of_view_mm: 520.0, arms: Arms::AtSides, ..plain };
    assert!(count(wide, |p| p == TorsoPart::Bone) > 0);
    // A field of view that is moved aside cuts the body off.
    let moved = TorsoOptions { shift_mm: [110.0, 0.0, 0.0], table: false, ..plain };
    assert!(
        count(moved, TorsoPart::is_body) * 10
            < 9 * count(TorsoOptions { table: false, ..plain }, TorsoPart::is_body)
    );
    let tilted = grow(TorsoOptions { tilt_degrees: 12.0, ..plain });
    assert!((tilted.directions().y_axis.z - 12f64.to_radians().sin()).abs() < 1e-9);
    assert!(tilted.center_mm().distance(CENTER_MM) < 1e-9);
    assert_eq!(tilted.value([0, 0, 0]), AIR_HU, "no padding, but air");
}

#[test]
fn parts_are_numbered_in_order() {
    for (i, part) in TorsoPart::ALL.into_iter().enumerate() {
        assert_eq!((part as usize, TorsoPart::from_number(i as u8)), (i, Some(part)));
    }
    assert_eq!(TorsoPart::from_number(TorsoPart::ALL.len() as u8), None);
}

#[test]
fn pruning_does_not_change_the_parts() {
    let unit = |i: u64| (hash64(i) >> 40) as f32 / (1 << 24) as f32 - 0.5;
    let whole = TorsoTruth { model: model(&TorsoOptions::default()) };
    let options = small(32);
    let parts = parts(options);
    let n = options.size;
    for i in 0..300u64 {
        let voxel = std::array::from_fn(|c| ((unit(3 * i + c as u64) * 0.7 + 0.5) * n as f32) as usize);
        let [x, y, z]: [usize; 3] = voxel;
        let place =
            options.first() + options.axes() * (DVec3::new(x as f64, y as f64, z as f64) * options.spacing());
        assert_eq!(whole.part(place), parts[(z * n + y) * n + x], "at {place}");
    }
}

#[test]
fn pet_shows_organs_by_their_uptake_and_lesions_where_they_lie() {
    let (silent, never) = (Progress::SILENT, CancelToken::new());
    let options = TorsoOptions { size: 100, ..Default::default() };
    let pet = torso_pet(options, silent, &never).unwrap();
    assert_eq!((pet.unit(), pet.modality()), ("SUV", Modality::Pet));
    let few = small(12);
    let places = [torso_pet(few, silent, &never), torso(few, silent, &never)]
        .map(|of| of.unwrap().patient_from_voxel());
    assert_eq!(places[0], places[1], "one place");
    let truth = TorsoTruth::new(options);
    let voxel_from_patient = pet.patient_from_voxel().inverse();
    let suv = |at: DVec3| {
        let at = voxel_from_patient.transform_point3(at).round().as_ivec3().to_array();
        pet.value(at.map(|i| i as usize))
    };
    let parts: Vec<TorsoPart> = pet::LESIONS.iter().map(|lesion| truth.part(lesion.at)).collect();
    println!("lesions lie in {parts:?}");
    assert_eq!((parts[0], parts[3], parts[4]), (TorsoPart::Lung, TorsoPart::Liver, TorsoPart::Liver));
    for lesion in &pet::LESIONS {
        assert!(suv(lesion.at) > 0.55 * lesion.suv, "{}: {}", lesion.at, suv(lesion.at));
    }
    let numbers = torso_parts(options, silent, &never).unwrap();
    let mean = |part: TorsoPart| {
        let all = (0..numbers.len()).filter(|&i| numbers[i] == part as u8);
        let values: Vec<f64> = all.map(|i| pet.voxels().get(i) * pet.slope()).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let means =
        [TorsoPart::OutsideAir, TorsoPart::Lung, TorsoPart::Muscle, TorsoPart::Liver, TorsoPart::Kidney]
            .map(mean);
    println!("air, lung, muscle, liver, kidney: {means:.2?}");
    assert!(means.is_sorted() && means[0] < 0.1 && means[4] > 4.0, "{means:?}");
    // What the patient lies on takes up nothing.
    assert!(mean(TorsoPart::Table) < 0.1);
    assert!(
        torso_pet(options, silent, &{
            let cancel = CancelToken::new();
            cancel.cancel();
            cancel
        })
        .is_err()
    );
}
