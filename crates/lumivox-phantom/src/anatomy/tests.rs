use super::*;
use crate::{AIR_HU, sdf::at};

fn grow(options: AnatomyOptions) -> Volume {
    anatomy(options, Progress::SILENT, &CancelToken::new()).unwrap()
}

/// The noise-free values of a cube around `center`, finer than any detail.
pub(super) fn around(model: &Model, center: Vec3, half: f32, spacing: f32) -> Vec<f64> {
    let inner = (2.0 * half / spacing) as usize + 1;
    // The reconstruction circle must not cut the corners.
    let margin = inner / 2 + 1;
    let size = inner + 2 * margin;
    let first = center - (size - 1) as f32 / 2.0 * spacing;
    let scan = Scan { seed: 1, noise_hu: 0.0, padding: None };
    let grid = Grid { size, first, spacing, axes: Mat3::IDENTITY };
    let samples = raster::rasterise(model, grid, scan, Progress::SILENT, &CancelToken::new()).unwrap();
    let kept = |i: usize| (margin..margin + inner).contains(&i);
    let indices =
        (0..samples.len()).filter(|i| kept(i % size) && kept(i / size % size) && kept(i / (size * size)));
    indices.map(|i| f64::from(samples[i]) + INTERCEPT).collect()
}

/// The median of the values within a millimetre and a half.
pub(super) fn tissue(model: &Model, center: Vec3) -> f64 {
    let mut values = around(model, center, 1.5, 0.75);
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn tissues_have_credible_values() {
    let model = model(1);
    let expect = |name: &str, place: Vec3, range: std::ops::Range<f64>| {
        let hu = tissue(&model, place);
        assert!(range.contains(&hu), "{name} at {place}: {hu} HU, not in {range:?}");
    };
    expect("air", at(0.0, -160.0, 0.0), -1001.0..-999.0);
    expect("windpipe", at(0.0, -11.0, -155.0), -1001.0..-950.0);
    expect("sphenoid sinus", at(8.5, -31.0, 10.0), -1001.0..-950.0);
    expect("lung", at(48.0, 30.0, -180.0), -920.0..-700.0);
    expect("fat of the cheek", at(44.0, -50.0, -24.0), -125.0..-60.0);
    expect("brain", at(30.0, 10.0, 75.0), 0.0..45.0);
    expect("ventricle", at(11.0, 6.0, 60.0), 0.0..20.0);
    expect("vitreous", at(32.0, -76.5, 14.5), 0.0..25.0);
    expect("tongue", at(4.0, -50.0, -55.0), 0.0..95.0);
    expect("chewing muscle", at(56.0, -36.0, -36.0), 0.0..95.0);
    expect("carotid artery", vessels::LEFT_CAROTID, 300.0..370.0);
    expect("vertebral body", at(0.0, 8.0, -107.0), 120.0..480.0);
    let hardest = |place: Vec3| around(&model, place, 6.0, 0.75).into_iter().fold(f64::MIN, f64::max);
    assert!(
        (1000.0..1600.0).contains(&hardest(at(0.0, -88.0, 60.0))),
        "forehead {}",
        hardest(at(0.0, -88.0, 60.0))
    );
    assert!((2300.0..2700.0).contains(&hardest(at(4.0, -92.0, -50.0))), "incisor");
}

#[test]
fn the_filling_is_on_the_patients_left() {
    let model = model(1);
    let filling = jaw::filling();
    assert!(filling.x > 10.0, "+x is the patient's left");
    let metal = |place: Vec3| around(&model, place, 5.0, 0.5).iter().filter(|hu| **hu > 2950.0).count();
    let other_side = at(-filling.x, filling.y, filling.z);
    assert!(metal(filling) > 100);
    assert_eq!(metal(other_side), 0);
}

#[test]
fn the_head_has_the_size_of_a_head() {
    let volume = grow(AnatomyOptions { size: 80, noise_hu: 0.0, ..AnatomyOptions::default() });
    let spacing = volume.spacing_mm().x;
    let skin = |[x, y, z]: [usize; 3]| volume.value([x, y, z]) > -500.0;
    let all = |z: usize| (0..80).flat_map(move |y| (0..80).map(move |x| [x, y, z]));
    // Millimetres of a slice, from a patient z.
    let slice = |z_mm: f64| ((z_mm - LOW_CORNER_MM.z) / spacing) as usize;
    let extent = |z: usize, axis: usize| {
        let hits: Vec<usize> = all(z).filter(|v| skin(*v)).map(|v| v[axis]).collect();
        (hits.iter().max().unwrap() - hits.iter().min().unwrap() + 1) as f64 * spacing
    };
    let width = extent(slice(60.0), 0);
    let depth = extent(slice(45.0), 1);
    assert!((140.0..165.0).contains(&width), "width {width}");
    assert!((180.0..212.0).contains(&depth), "depth {depth}");
    let top = (0..80).rev().find(|z| all(*z).any(skin)).unwrap() as f64 * spacing + LOW_CORNER_MM.z;
    assert!((120.0..135.0).contains(&top), "vertex {top}");
}

#[test]
fn the_same_seed_gives_the_same_patient_on_any_number_of_threads() {
    let options = AnatomyOptions { size: 40, ..AnatomyOptions::default() };
    let first = grow(options);
    let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(first.voxels(), single.install(|| grow(options)).voxels());
    assert_ne!(first.voxels(), grow(AnatomyOptions { seed: 2, ..options }).voxels());
    // Another seed is another patient, not only other noise.
    let quiet = AnatomyOptions { noise_hu: 0.0, ..options };
    assert_ne!(grow(quiet).voxels(), grow(AnatomyOptions { seed: 2, ..quiet }).voxels());
}

#[test]
fn noise_has_the_deviation_asked_for() {
    let options = AnatomyOptions { size: 40, noise_hu: 20.0, ..AnatomyOptions::default() };
    let (noisy, quiet) = (grow(options), grow(AnatomyOptions { noise_hu: 0.0, ..options }));
    // Inside the head, where no value is clipped.
    let differences: Vec<f64> = (22..34)
        .flat_map(|z| (14..26).flat_map(move |y| (14..26).map(move |x| [x, y, z])))
        .map(|v| noisy.value(v) - quiet.value(v))
        .collect();
    let n = differences.len() as f64;
    let deviation = (differences.iter().map(|d| d * d).sum::<f64>() / n).sqrt();
    assert!((18.0..22.0).contains(&deviation), "{deviation}");
}

#[test]
fn outside_the_reconstruction_circle_is_air() {
    let volume = grow(AnatomyOptions { size: 40, ..AnatomyOptions::default() });
    for corner in [[0, 0, 0], [39, 0, 20], [39, 39, 39]] {
        assert_eq!(volume.value(corner), AIR_HU);
    }
    assert_eq!(volume.modality(), Modality::Ct);
    assert!(volume.size_mm().distance(DVec3::splat(FIELD_OF_VIEW_MM)) < 1e-9);
    let corner = volume.patient_from_box().transform_point3(DVec3::ZERO);
    assert!(corner.distance(LOW_CORNER_MM) < 1e-9);
}

#[test]
fn growing_can_be_cancelled_and_tells_how_far_it_is() {
    let cancel = CancelToken::new();
    let options = AnatomyOptions { size: 30, ..AnatomyOptions::default() };
    let last = std::sync::Mutex::new((0, 0));
    let note = |_, done, total| {
        let mut last = last.lock().unwrap();
        *last = (last.0.max(done), total);
    };
    anatomy(options, Progress::new(&note), &cancel).unwrap();
    assert_eq!(*last.lock().unwrap(), (30, 30));
    cancel.cancel();
    assert_eq!(anatomy(options, Progress::SILENT, &cancel).unwrap_err(), Cancelled);
}

#[test]
fn an_mr_shows_the_same_head_in_other_values() {
    let options = AnatomyOptions { size: 96, noise_hu: 8.0, ..Default::default() };
    let grow = |part| anatomy_mr(options, part, Progress::SILENT, &CancelToken::new()).unwrap();
    let model = model(1).in_t1();
    let signal = |place: Vec3| tissue(&model, place) - AIR_HU;
    let expect = |name: &str, place: Vec3, range: std::ops::Range<f64>| {
        let signal = signal(place);
        assert!(range.contains(&signal), "{name} at {place}: {signal}, not in {range:?}");
    };
    expect("air", at(0.0, -160.0, 0.0), -1.0..1.0);
    expect("fat of the cheek", at(44.0, -50.0, -24.0), 700.0..900.0);
    expect("ventricle", at(11.0, 6.0, 60.0), 80.0..150.0);
    expect("vitreous", at(32.0, -76.5, 14.5), 80.0..150.0);
    expect("chewing muscle", at(56.0, -36.0, -36.0), 250.0..650.0);
    expect("carotid artery", vessels::LEFT_CAROTID, 950.0..1150.0);
    let brain: Vec<f64> =
        around(&model, at(30.0, 10.0, 75.0), 8.0, 1.0).iter().map(|value| value - AIR_HU).collect();
    let white = brain.iter().filter(|signal| (540.0..580.0).contains(*signal)).count();
    let grey = brain.iter().filter(|signal| (360.0..400.0).contains(*signal)).count();
    assert!(white > 100 && grey > 100, "{white} {grey} of {}", brain.len());

    let (head, bare) = (grow(MrPart::Head), grow(MrPart::Brain));
    assert_eq!(head.modality(), Modality::Mr);
    assert_eq!(head.patient_from_voxel(), bare.patient_from_voxel());
    let above =
        |volume: &Volume| (0..volume.voxel_count()).filter(|&i| volume.voxels().get(i) > 80.0).count();
    let (all, brain) = (above(&head), above(&bare));
    assert!(brain > 20_000 && all > 2 * brain, "{all} {brain}");
    assert_eq!(bare.value([48, 2, 48]), 0.0, "nothing lies around it");
    assert_eq!(grow(MrPart::Head).voxels(), head.voxels());
}
