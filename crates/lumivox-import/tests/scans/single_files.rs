//! NIfTI, NRRD and RAW scans of real people and machines, against numbers that other programs read from them.

use std::path::PathBuf;

use crate::common::shared;
use lumivox_core::{CancelToken, Modality, Progress, Volume, Voxels, glam::DVec3};
use lumivox_import::{ImportOptions, Imported, RawDescription, load};

fn load_one(path: PathBuf) -> Imported {
    load(&[path], &ImportOptions::default(), Progress::SILENT, &CancelToken::new()).unwrap()
}

/// The sum of all values, by which other programs' reading is compared.
fn sum(volume: &Volume) -> f64 {
    let stored: f64 = (0..volume.voxel_count()).map(|i| volume.voxels().get(i)).sum();
    stored * volume.slope() + volume.intercept() * volume.voxel_count() as f64
}

#[test]
fn ct_angiogram_nifti_gz() {
    let Some(path) = shared("nifti/CT_AVM.nii.gz") else { return };
    let Imported { volume, report, .. } = load_one(path);
    assert_eq!(report.format, "NIfTI");
    assert_eq!(volume.dims(), [256, 242, 154]);
    let slope = f64::from(2.2086275f32);
    assert_eq!(volume.value_range(), [0.0, 255.0 * slope]);
    assert!((sum(&volume) / slope - 22_359_514.0).abs() < 1e-3);
    assert!(volume.spacing_mm().distance(DVec3::new(0.72, 0.7217, 1.0)) < 1e-3, "{}", volume.spacing_mm());
    // Its axes run to the right, front and head.
    let axes = volume.directions();
    assert!(axes.x_axis.distance(DVec3::NEG_X) < 1e-9 && axes.y_axis.distance(DVec3::NEG_Y) < 1e-9);
    assert!(axes.z_axis.distance(DVec3::Z) < 1e-9);
}

#[test]
fn mr_nifti_keeps_every_value_and_its_place() {
    let Some(path) = shared("syntaxes/1.nii") else { return };
    let Imported { volume, .. } = load_one(path);
    assert_eq!(volume.dims(), [64, 64, 35]);
    assert!(matches!(volume.voxels(), Voxels::U16(_)));
    assert_eq!(volume.value_range(), [0.0, 2362.0]);
    assert_eq!(sum(&volume), 38_036_663.0);
    assert_eq!(volume.modality(), Modality::Other);
    // To the left, and tilted: to the front and a little up. Its sform has x and y the other way round, in RAS.
    let place = volume.patient_from_voxel();
    let near = |a: DVec3, b: DVec3| assert!(a.distance(b) < 1e-3, "{a} is not {b}");
    near(place.translation, DVec3::new(-104.0, 58.6843, -84.7980));
    near(place.matrix3.x_axis, DVec3::new(3.25, 0.0, 0.0));
    near(place.matrix3.y_axis, DVec3::new(0.0, -3.2310, 0.3515));
    near(place.matrix3.z_axis, DVec3::new(0.0, 0.3888, 3.5789));
    assert!((volume.spacing_mm() - DVec3::new(3.25, 3.25, 3.6)).abs().max_element() < 1e-3);
}

#[test]
fn oblique_slice_nrrd() {
    let Some(path) = shared("nrrd/adi_slice.nrrd") else { return };
    let Imported { volume, report, .. } = load_one(path);
    assert_eq!(report.format, "NRRD");
    assert_eq!(volume.dims(), [192, 192, 1]);
    assert_eq!(volume.value_range(), [0.0, 836.0]);
    assert_eq!(sum(&volume), 3_454_721.0);
    let origin = volume.patient_from_voxel().translation;
    assert!(origin.distance(DVec3::new(44.638686, -139.689596, 131.843936)) < 1e-5);
    assert!((volume.patient_from_voxel().matrix3.y_axis.z + 1.1454327).abs() < 1e-6);
}

#[test]
fn raw_head_described_by_its_name_or_the_user() {
    let Some(path) = shared("raw/head_ct_256x256x108_int16_0.957x0.957x1.5mm.raw") else { return };
    let Imported { volume, report, .. } = load_one(path.clone());
    assert_eq!(report.format, "RAW");
    assert_eq!(volume.dims(), [256, 256, 108]);
    assert_eq!(volume.value_range(), [-1024.0, 2986.0]);
    assert_eq!(sum(&volume), -4_147_325_847.0);
    assert_eq!(volume.value([128, 128, 54]), 3.0);
    assert!(volume.spacing_mm().distance(DVec3::new(0.957, 0.957, 1.5)) < 1e-9);
    assert_eq!(volume.modality(), Modality::Ct, "{:?}", report.notes);

    let mut options = ImportOptions::default();
    options.raw = Some(RawDescription::parse("256x256x108:i16le:spacing=1,1,2:modality=other").unwrap());
    let volume =
        load(std::slice::from_ref(&path), &options, Progress::SILENT, &CancelToken::new()).unwrap().volume;
    assert_eq!(volume.spacing_mm(), DVec3::new(1.0, 1.0, 2.0));
    assert_eq!(volume.modality(), Modality::Other);
    // Its y runs to the front.
    options.raw = Some(RawDescription::parse("256x256x108:i16le:axes=LAS").unwrap());
    let volume = load(&[path], &options, Progress::SILENT, &CancelToken::new()).unwrap().volume;
    assert_eq!(volume.directions().y_axis, DVec3::NEG_Y);
    assert_eq!(volume.value([128, 128, 54]), 3.0);
}

fn nrrd(dims: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {dims}\nencoding: raw\n\n");
    [header.as_bytes(), data].concat()
}

#[test]
fn options_without_use_and_volumes_without_content_are_noted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.nrrd");
    let notes = |data: &[u8]| {
        std::fs::write(&path, nrrd("2 2 2", data)).unwrap();
        let mut options = ImportOptions::default();
        options.series = Some("2".to_owned());
        options.raw = Some(RawDescription::parse("2x2x2:u8").unwrap());
        load(std::slice::from_ref(&path), &options, Progress::SILENT, &CancelToken::new())
            .unwrap()
            .report
            .notes
            .join("; ")
    };
    let told = notes(&[1, 2, 3, 4, 5, 6, 7, 8]);
    assert!(told.contains("no series was looked for: a NRRD file holds one image"), "{told}");
    assert!(told.contains("the description of raw samples was not used"), "{told}");
    assert!(!told.contains("every voxel"), "{told}");
    assert!(notes(&[7; 8]).contains("every voxel has the same value, 7"));
    std::fs::write(&path, nrrd("2 2 1", &[1, 2, 3, 4])).unwrap();
    let Imported { report, .. } = load_one(path);
    assert!(report.notes.iter().any(|note| note.starts_with("a single slice is not a volume")));
    assert!(!report.notes.iter().any(|note| note.contains("not used")));
}

#[test]
fn a_description_counts_for_the_one_file_of_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("samples"), [1, 2, 3, 0xff, 5, 6, 7, 8]).unwrap();
    let mut options = ImportOptions::default();
    let load = |options: &ImportOptions| {
        load(&[folder.path().to_owned()], options, Progress::SILENT, &CancelToken::new())
    };
    assert!(load(&options).is_err());
    options.raw = Some(RawDescription::parse("2x2x2:u8").unwrap());
    let Imported { volume, report, .. } = load(&options).unwrap();
    assert_eq!((volume.dims(), report.format.as_str()), ([2; 3], "RAW"));
    std::fs::write(folder.path().join("others"), [9; 8]).unwrap();
    let error = load(&options).unwrap_err().to_string();
    assert!(error.contains("Open the one that is described"), "{error}");
}
