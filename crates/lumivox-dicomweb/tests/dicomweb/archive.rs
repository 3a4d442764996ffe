//! A real archive.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use lumivox_core::{CancelToken, Progress, WorkStage};
use lumivox_dicomweb::{Error, Filter, Login, Server, Uid};
use lumivox_phantom::{AnatomyOptions, SeriesDescription, write_dicom_series};
use lumivox_testing::orthanc::{NAME, Orthanc, PASSWORD};

struct Archive {
    orthanc: Orthanc,
    place: PathBuf,
}

/// One for all tests: a head of two series in two studies of one patient, and one of another.
fn archive() -> &'static Archive {
    static ARCHIVE: OnceLock<Archive> = OnceLock::new();
    ARCHIVE.get_or_init(|| {
        // Left to the end of the process: nothing is dropped of what is static.
        let place = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("dicomweb");
        let _ = fs::remove_dir_all(&place);
        let kept = place.join("kept");
        fs::create_dir_all(&kept).unwrap();
        let orthanc = Orthanc::start(&kept);
        for (name, patient, size, day, seed) in [
            ("a", "Doe^Jane", 16, "20240131", 1),
            ("b", "Doe^Jane", 20, "20240301", 2),
            ("c", "M\u{fc}ller^J", 12, "20230101", 3),
        ] {
            let never = CancelToken::new();
            let options = AnatomyOptions { size, ..AnatomyOptions::default() };
            let head = lumivox_phantom::anatomy(options, Progress::SILENT, &never).unwrap();
            let description = SeriesDescription {
                patient_name: patient.into(),
                patient_id: format!("ID-{name}"),
                series: format!("Series {name}"),
                date: day.into(),
                seed,
                ..SeriesDescription::default()
            };
            write_dicom_series(&head, &place.join(name), &description, Progress::SILENT, &never).unwrap();
            orthanc.store(&place.join(name));
        }
        Archive { orthanc, place }
    })
}

fn server() -> Server {
    let login = Login::Password { name: NAME.into(), password: PASSWORD.into() };
    Server::new(&archive().orthanc.address(), login).unwrap()
}

fn patients(filter: Filter) -> Vec<String> {
    server().studies(&filter).unwrap().found.into_iter().map(|study| study.patient_id).collect()
}

#[test]
fn studies_are_found_by_each_of_their_fields() {
    assert_eq!(patients(Filter::default()), ["ID-b", "ID-a", "ID-c"], "the newest first");
    assert_eq!(patients(Filter { patient: "doe".into(), ..Filter::default() }), ["ID-b", "ID-a"]);
    assert_eq!(patients(Filter { patient: "M\u{fc}ll".into(), ..Filter::default() }), ["ID-c"]);
    assert_eq!(patients(Filter { patient: "Doe, Ja".into(), ..Filter::default() }), ["ID-b", "ID-a"]);
    assert_eq!(
        patients(Filter { patient_id: "ID".into(), ..Filter::default() }).len(),
        0,
        "an identifier is whole"
    );
    assert_eq!(patients(Filter { patient: "*jane".into(), ..Filter::default() }), ["ID-b", "ID-a"]);
    assert_eq!(patients(Filter { patient_id: "ID-a".into(), ..Filter::default() }), ["ID-a"]);
    assert_eq!(patients(Filter { days: "2024-02-01 -".into(), ..Filter::default() }), ["ID-b"]);
    assert_eq!(patients(Filter { days: "2023-01-01".into(), ..Filter::default() }), ["ID-c"]);
    assert_eq!(patients(Filter { modality: "ct".into(), ..Filter::default() }).len(), 3);
    assert_eq!(patients(Filter { modality: "MR".into(), ..Filter::default() }).len(), 0);
    assert_eq!(patients(Filter { patient: "nobody & all=%*".into(), ..Filter::default() }).len(), 0);
    let all = server().studies(&Filter::default()).unwrap();
    assert!(!all.has_more);
    let study = &all.found[2];
    assert_eq!((study.patient.as_str(), study.day.as_str()), ("M\u{fc}ller, J", "2023-01-01"));
    assert_eq!(study.description, "Procedural phantom");
    assert_eq!(study.modalities, ["CT"]);
    assert_eq!((study.series, study.images), (Some(1), Some(12)));
    let series = server().series(&study.uid).unwrap();
    assert_eq!(series.len(), 1);
    assert_eq!((series[0].description.as_str(), series[0].modality.as_str()), ("Series c", "CT"));
    assert_eq!((series[0].number, series[0].images), (Some(1), Some(12)));
}

fn contents(folder: &Path) -> BTreeSet<Vec<u8>> {
    fs::read_dir(folder).unwrap().map(|entry| fs::read(entry.unwrap().path()).unwrap()).collect()
}

#[test]
fn a_series_comes_as_it_was_stored() {
    let (server, into) = (server(), tempfile::tempdir().unwrap());
    let study = &server.studies(&Filter { patient_id: "ID-a".into(), ..Filter::default() }).unwrap().found[0];
    let series = &server.series(&study.uid).unwrap()[0];
    let told = std::sync::Mutex::new(vec![]);
    let report = |stage, done, total| told.lock().unwrap().push((stage, done, total));
    let never = CancelToken::new();
    let folder = server.fetch(&study.uid, series, into.path(), Progress::new(&report), &never).unwrap();
    assert_eq!(folder, into.path().join(series.uid.as_str()));
    assert_eq!(contents(&folder), contents(&archive().place.join("a")));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(&folder).unwrap().permissions().mode();
        assert_eq!(mode & 0o77, 0, "others look into it: {mode:o}");
    }
    let told = std::mem::take(&mut *told.lock().unwrap());
    assert_eq!(told.len(), 17);
    assert_eq!(told[16], (WorkStage::Receiving, 16, 16));
    // Again, in place of what was there.
    fs::write(folder.join("other"), "").unwrap();
    fs::remove_file(folder.join("000003.dcm")).unwrap();
    server.fetch(&study.uid, series, into.path(), Progress::SILENT, &never).unwrap();
    assert_eq!(contents(&folder), contents(&archive().place.join("a")));
    assert_eq!(fs::read_dir(into.path()).unwrap().count(), 1, "nothing else is left");
    let scan = lumivox_import::load(&[folder], &Default::default(), Progress::SILENT, &never).unwrap();
    assert_eq!(scan.volume.dims(), [16; 3]);
}

#[test]
fn what_is_cancelled_leaves_nothing() {
    let (server, into) = (server(), tempfile::tempdir().unwrap());
    let study = &server.studies(&Filter { patient_id: "ID-b".into(), ..Filter::default() }).unwrap().found[0];
    let series = &server.series(&study.uid).unwrap()[0];
    let cancel = CancelToken::new();
    let stop = |_, done, _| {
        if done == 3 {
            cancel.cancel();
        }
    };
    let fetched = server.fetch(&study.uid, series, into.path(), Progress::new(&stop), &cancel);
    assert!(matches!(fetched, Err(Error::Cancelled(_))), "{fetched:?}");
    assert_eq!(fs::read_dir(into.path()).unwrap().count(), 0);
}

#[test]
fn who_may_not_ask_is_told_so() {
    let address = archive().orthanc.address();
    for login in [
        Login::Nobody,
        Login::Password { name: NAME.into(), password: "guess".into() },
        Login::Token("x".into()),
    ] {
        let error = Server::new(&address, login).unwrap().studies(&Filter::default()).unwrap_err();
        assert!(matches!(error, Error::Login { status: 401 | 403, .. }), "{error}");
        assert!(!error.to_string().contains("guess"));
    }
}

#[test]
fn a_wrong_path_is_told_from_an_archive() {
    let login = Login::Password { name: NAME.into(), password: PASSWORD.into() };
    let root = archive().orthanc.address().replace("/dicom-web", "");
    for address in [root.clone(), format!("{root}/elsewhere")] {
        let error = Server::new(&address, login.clone()).unwrap().studies(&Filter::default()).unwrap_err();
        assert!(matches!(error, Error::NoArchive { .. }), "{address}: {error}");
        assert!(error.to_string().contains("/dicom-web (Orthanc)"), "{error}");
    }
}

#[test]
fn a_series_that_is_not_there_has_no_images() {
    let into = tempfile::tempdir().unwrap();
    let study = Uid::new("1.2.3").unwrap();
    let error = server()
        .fetch(&study, &crate::series("1.2.4"), into.path(), Progress::SILENT, &CancelToken::new())
        .unwrap_err();
    assert!(matches!(error, Error::Nothing { .. }), "{error}");
    assert_eq!(fs::read_dir(into.path()).unwrap().count(), 0);
}
