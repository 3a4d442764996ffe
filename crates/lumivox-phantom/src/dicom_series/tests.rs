use super::*;
use dicom_object::{FileDicomObject, open_file};
use glam::{DAffine3, DMat3};

/// 4 x 3 x 2 voxels of 0.5 x 0.75 x 2 mm, with distinct values.
fn small() -> Volume {
    let spacing = DMat3::from_diagonal(DVec3::new(0.5, 0.75, 2.0));
    let place = DAffine3::from_mat3_translation(spacing, DVec3::new(-1.0 / 3.0, 20.0, -30.5));
    let samples = (0..24).map(|i| i * 170).collect();
    Volume::new([4, 3, 2], Voxels::U16(samples), [1.0, -1024.0], place, Modality::Ct).unwrap()
}

fn write(volume: &Volume, folder: &Path) -> Result<usize, WriteError> {
    write_dicom_series(volume, folder, &SeriesDescription::default(), Progress::SILENT, &CancelToken::new())
}

fn numbers(object: &FileDicomObject<InMemDicomObject>, tag: Tag) -> Vec<f64> {
    object.element(tag).unwrap().to_multi_float64().unwrap()
}

fn text(object: &FileDicomObject<InMemDicomObject>, tag: Tag) -> String {
    object.element(tag).unwrap().to_str().unwrap().trim_end_matches('\0').to_owned()
}

#[test]
fn an_mr_is_written_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let place = DAffine3::IDENTITY;
    let new = |intercept, modality| {
        let samples = Voxels::U16((0..8).collect());
        Volume::new([2, 2, 2], samples, [1.0, intercept], place, modality).unwrap()
    };
    assert_eq!(write(&new(0.0, Modality::Mr), folder.path()).unwrap(), 2);
    let object = open_file(folder.path().join("MR0002.dcm")).unwrap();
    assert_eq!(text(&object, tags::SOP_CLASS_UID), uids::MR_IMAGE_STORAGE);
    assert_eq!(text(&object, tags::MODALITY), "MR");
    assert_eq!(object.element(tags::PIXEL_DATA).unwrap().to_multi_int::<u16>().unwrap(), [4, 5, 6, 7]);
    assert!(object.element(tags::RESCALE_TYPE).is_err() && object.element(tags::KVP).is_err());
    for volume in [new(-5.0, Modality::Mr), new(0.0, Modality::Pet)] {
        let error = write(&volume, folder.path()).unwrap_err();
        assert!(matches!(error, WriteError::Unsuitable(_)), "{error}");
    }
}

#[test]
fn what_is_written_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let volume = small();
    assert_eq!(write(&volume, folder.path()).unwrap(), 2);
    for k in 0..2 {
        let object = open_file(folder.path().join(format!("CT{:04}.dcm", k + 1))).unwrap();
        assert_eq!(object.meta().transfer_syntax().trim_end_matches('\0'), uids::EXPLICIT_VR_LITTLE_ENDIAN);
        let stored = object.element(tags::PIXEL_DATA).unwrap().to_multi_int::<u16>().unwrap();
        let values: Vec<f64> =
            stored.iter().map(|s| f64::from(*s) + numbers(&object, tags::RESCALE_INTERCEPT)[0]).collect();
        let expected: Vec<f64> = (0..12).map(|i| volume.value([i % 4, i / 4, k])).collect();
        assert_eq!(values, expected);
        assert_eq!(numbers(&object, tags::PIXEL_SPACING), [0.75, 0.5], "between rows first");
        assert_eq!(numbers(&object, tags::IMAGE_ORIENTATION_PATIENT), [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let position = DVec3::from_slice(&numbers(&object, tags::IMAGE_POSITION_PATIENT));
        let expected = volume.patient_from_voxel().transform_point3(DVec3::Z * k as f64);
        assert!(position.distance(expected) < 1e-9);
        assert_eq!(numbers(&object, tags::SLICE_THICKNESS), [2.0]);
        assert_eq!(numbers(&object, tags::BITS_STORED), [12.0]);
        assert_eq!(text(&object, tags::PATIENT_NAME), "Phantom^Lumivox");
        assert_eq!(
            text(&object, tags::SOP_INSTANCE_UID),
            object.meta().media_storage_sop_instance_uid().trim_end_matches('\0')
        );
    }
}

#[test]
fn uids_are_valid_distinct_and_repeatable() {
    let volume = small();
    let description = SeriesDescription::default();
    let series = Series::new(&volume, &description).unwrap();
    let mut seen = HashSet::new();
    for (role, count) in [("study", 1), ("series", 1), ("instance", 500), ("frame of reference", 1)] {
        for i in 0..count {
            let uid = series.uid(role, i);
            assert!(uid.len() <= 64 && uid.starts_with("2.25."), "{uid}");
            assert!(!uid["2.25.".len()..].starts_with('0'), "{uid}");
            assert_eq!(uid, series.uid(role, i));
            assert!(seen.insert(uid));
        }
    }
    let other = SeriesDescription { seed: 2, ..description.clone() };
    let other = Series::new(&volume, &other).unwrap();
    assert_ne!(series.uid("study", 0), other.uid("study", 0));
}

#[test]
fn only_its_own_series_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let volume = small();
    write(&volume, folder.path()).unwrap();
    write(&volume, folder.path()).unwrap();
    let other = SeriesDescription { seed: 7, ..SeriesDescription::default() };
    let refused = write_dicom_series(&volume, folder.path(), &other, Progress::SILENT, &CancelToken::new());
    assert!(matches!(refused, Err(WriteError::FolderNotEmpty { .. })));

    let note = folder.path().join("A note.txt");
    fs::write(&note, "mine").unwrap();
    match write(&volume, folder.path()) {
        Err(WriteError::FolderNotEmpty { path }) => assert_eq!(path, note),
        other => panic!("{other:?}"),
    }
    assert_eq!(fs::read_to_string(&note).unwrap(), "mine");
}

#[test]
fn a_cancelled_run_leaves_no_half_file() {
    let folder = tempfile::tempdir().unwrap();
    let volume = crate::solid(0.0, [16, 16, 40], [1.0; 3]);
    let cancel = CancelToken::new();
    let stop_early = |_, done, _| {
        if done == 5 {
            cancel.cancel();
        }
    };
    let description = SeriesDescription::default();
    let run = write_dicom_series(&volume, folder.path(), &description, Progress::new(&stop_early), &cancel);
    assert!(matches!(run, Err(WriteError::Cancelled(_))));
    for entry in fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        assert_eq!(path.extension().unwrap(), "dcm", "{}", path.display());
        open_file(path).unwrap();
    }
    // What it left does not stand in the way of a second run.
    assert_eq!(write(&volume, folder.path()).unwrap(), 40);
}

#[test]
fn errors_name_the_path_and_what_does_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("occupied");
    fs::write(&file, "").unwrap();
    let error = write(&small(), &file).unwrap_err();
    assert!(matches!(&error, WriteError::Io { path, .. } if *path == file), "{error}");
    assert!(error.to_string().contains("occupied"));

    let mr = small().with_modality(Modality::Mr);
    assert!(matches!(write(&mr, folder.path()), Err(WriteError::Unsuitable(_))));
}

#[test]
fn decimal_strings_fit_and_keep_what_they_can() {
    for x in [0.0, -160.0, 1.0 / 3.0, -1.0e-7 / 3.0, -123_456.789_012_345_67, 1e300 / 7.0, 5e-324] {
        let s = decimal_string(x);
        assert!(s.len() <= 16, "{s}");
        let y: f64 = s.parse().unwrap();
        assert!((y - x).abs() <= x.abs() * 1e-8 + 1e-20, "{x} became {s}");
    }
}
