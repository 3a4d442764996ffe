//! Studies of a real archive, asked for as a person does.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{By, Queryable};
use lumivox_core::{Preset, Progress};
use lumivox_dicomweb::Error;
use lumivox_phantom::{AnatomyOptions, SeriesDescription, anatomy, write_dicom_series};
use lumivox_studio::archive::told::{REASONS, words};
use lumivox_studio::settings::{Drawer, Settings};
use lumivox_studio::state::{Action, Dialog};
use lumivox_studio::words::Language;
use lumivox_testing::orthanc::{NAME, Orthanc, PASSWORD};

use super::{
    LONGEST, PATIENT, Studio, alone, click, head, launch_with, open, says, screenshot, session, settle,
    texts, undo, wait,
};

/// What was kept, and a folder for images.
#[derive(Clone)]
struct Kept(Arc<Mutex<Settings>>, PathBuf);

impl Drawer for Kept {
    fn read(&self) -> Option<Settings> {
        Some(self.0.lock().unwrap().clone())
    }

    fn write(&self, settings: &Settings) {
        *self.0.lock().unwrap() = settings.clone();
    }

    fn archive_folder(&self) -> Option<PathBuf> {
        Some(self.1.clone())
    }
}

/// Types into a field, in place of what is there.
fn fill(studio: &mut Studio, label: &str, text: &str) {
    let is_field = |role: Role| matches!(role, Role::TextInput | Role::PasswordInput);
    let node = studio.get(By::new().label(label).predicate(move |node| is_field(node.role())));
    node.focus();
    studio.run_steps(2);
    studio.key_press_modifiers(Modifiers::COMMAND, Key::A);
    let node = studio.get(By::new().label(label).predicate(move |node| is_field(node.role())));
    node.type_text(text);
    studio.run_steps(2);
}

/// Frames until words are seen.
fn until(studio: &mut Studio, words: &str) {
    let begin = Instant::now();
    while begin.elapsed() < LONGEST {
        if says(studio, words) {
            return;
        }
        studio.step();
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("nothing says '{words}': {:?}", texts(studio));
}

fn archive_of(place: &Path) -> Orthanc {
    let kept = place.join("orthanc");
    std::fs::create_dir_all(&kept).unwrap();
    let orthanc = Orthanc::start(&kept);
    orthanc.store(&head(place, 24));
    let never = Default::default();
    let other = anatomy(AnatomyOptions { size: 16, ..Default::default() }, Progress::SILENT, &never).unwrap();
    let series = SeriesDescription {
        patient_name: "Roe^Richard".into(),
        patient_id: "ROE-1".into(),
        study: "Neck, follow-up".into(),
        date: "20250612".into(),
        seed: 7,
        ..SeriesDescription::default()
    };
    write_dicom_series(&other, &place.join("other"), &series, Progress::SILENT, &never).unwrap();
    orthanc.store(&place.join("other"));
    orthanc
}

#[test]
fn a_study_is_found_in_an_archive_and_opened() {
    let _alone = alone();
    let place = tempfile::tempdir().unwrap();
    let orthanc = archive_of(place.path());
    let kept = Kept(
        Arc::new(Mutex::new(Settings { has_agreed: true, ..Settings::default() })),
        place.path().join("came"),
    );
    let (mut studio, _answers) = launch_with(Box::new(kept.clone()), false);
    studio.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::A);
    studio.run_steps(2);
    assert!(says(&studio, "Open from an archive") && says(&studio, "to nobody else"));
    // Whoever is wrong is told what to do.
    fill(&mut studio, "Address (DICOMweb)", "ftp://archive");
    click(&mut studio, "Search");
    until(&mut studio, "neither with http:// nor with https://");
    fill(&mut studio, "Address (DICOMweb)", "http://archive.example.org/dicom-web");
    assert!(says(&studio, "not encrypted"));
    fill(&mut studio, "Address (DICOMweb)", &orthanc.address());
    assert!(!says(&studio, "not encrypted"));
    click(&mut studio, "Search");
    until(&mut studio, "does not let you in");
    fill(&mut studio, "User name", NAME);
    fill(&mut studio, "Password, or a token alone", PASSWORD);
    studio.key_press(Key::Enter);
    until(&mut studio, "2025-06-12   Roe, Richard   ROE-1   CT   Neck, follow-up   16");
    assert!(says(&studio, "2024-01-01   Doe, Jane"), "{:?}", texts(&studio));
    screenshot(&mut studio, "archive_studies");
    fill(&mut studio, "Day, or from - to", "2024");
    click(&mut studio, "Search");
    until(&mut studio, "no day and no range");
    fill(&mut studio, "Day, or from - to", "- 2024-12-31");
    click(&mut studio, "Search");
    // One study alone shows its series at once.
    until(&mut studio, "1   CT   Head and neck, contrast   24");
    assert!(!says(&studio, "Roe, Richard"));
    screenshot(&mut studio, "archive_series");
    click(&mut studio, "Open series");
    wait(&mut studio, "it comes", |app| app.state.session.is_some());
    settle(&mut studio);
    assert_eq!(session(&studio).scan().dims(), [24; 3]);
    assert!(studio.state().state.dialog.is_none() && studio.state().state.failed.is_none());
    // Work is asked about when a series is there, not when it is asked for: much may be done meanwhile.
    studio.state_mut().state.act(Action::Look(Preset::ALL[3]));
    studio.run_steps(2);
    click(&mut studio, "Archive…");
    until(&mut studio, "1   CT   Head and neck, contrast   24");
    click(&mut studio, "Open series");
    wait(&mut studio, "it asks", |app| app.state.dialog == Some(Dialog::Leave { opens: true }));
    click(&mut studio, "Cancel");
    settle(&mut studio);
    undo(&mut studio);
    assert!(!says(&studio, "Doe"), "the patient is named");
    screenshot(&mut studio, "archive_opened");
    // The address is kept, and no password.
    let settings = kept.0.lock().unwrap().clone();
    assert_eq!((settings.archive.as_str(), settings.archive_name.as_str()), (&*orthanc.address(), NAME));
    let text = serde_json::to_string(&settings).unwrap();
    assert!(!text.contains(PASSWORD) && !text.contains(PATIENT) && !text.contains("Doe"), "{text}");
    // An archive that is gone: what is open stays, and what is asked says so.
    drop(orthanc);
    click(&mut studio, "Archive…");
    until(&mut studio, "1   CT   Head and neck, contrast   24");
    click(&mut studio, "Open series");
    wait(&mut studio, "it fails", |app| app.state.failed.is_some());
    let (_, why) = studio.state_mut().state.failed.take().unwrap();
    assert!(why.contains("cannot be reached"), "{why}");
    assert_eq!(session(&studio).scan().dims(), [24; 3]);
    click(&mut studio, "Archive…");
    click(&mut studio, "Search");
    until(&mut studio, "cannot be reached");
    // Images go when that is said twice.
    assert_eq!(std::fs::read_dir(&kept.1).unwrap().count(), 1);
    click(&mut studio, "Delete them…");
    assert!(says(&studio, "lose their scans"));
    click(&mut studio, "Cancel");
    click(&mut studio, "Delete them…");
    assert!(kept.1.is_dir());
    click(&mut studio, "Delete all images that came");
    wait(&mut studio, "they go", |_| !kept.1.exists());
    // One that never answers is not waited for.
    let silent = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    fill(&mut studio, "Address (DICOMweb)", &format!("http://{}", silent.local_addr().unwrap()));
    click(&mut studio, "Search");
    click(&mut studio, "Stop asking");
    assert!(!says(&studio, "Stop asking") && !says(&studio, "cannot be reached"));
    // Whoever reads German is told so.
    let settings = studio.state().state.settings.clone();
    studio.state_mut().state.act(Action::Settings(Settings { language: Language::German, ..settings }));
    studio.run_steps(2);
    fill(&mut studio, "Adresse (DICOMweb)", "ftp://archive");
    click(&mut studio, "Suchen");
    until(&mut studio, "weder mit http:// noch mit https://");
    click(&mut studio, "Schließen");
    assert!(studio.state().state.dialog.is_none());
}

#[test]
fn a_scan_stays_where_none_comes_in_its_place() {
    let _alone = alone();
    let place = tempfile::tempdir().unwrap();
    let orthanc = archive_of(place.path());
    let settings = Settings {
        has_agreed: true,
        archive: orthanc.address(),
        archive_name: NAME.into(),
        ..Settings::default()
    };
    // A file is in the way of the folder.
    let blocked = place.path().join("file");
    std::fs::write(&blocked, "").unwrap();
    let kept = Kept(Arc::new(Mutex::new(settings)), blocked.join("came"));
    let (mut studio, _answers) = launch_with(Box::new(kept), false);
    open(&mut studio, &[&place.path().join("other")]);
    click(&mut studio, "Archive…");
    fill(&mut studio, "Password, or a token alone", PASSWORD);
    fill(&mut studio, "Patient's name", "doe");
    studio.key_press(Key::Enter);
    until(&mut studio, "Head and neck, contrast");
    click(&mut studio, "Open series");
    wait(&mut studio, "it fails", |app| app.state.failed.is_some());
    let (_, why) = studio.state().state.failed.clone().unwrap();
    assert!(why.contains("came"), "{why}");
    assert_eq!(session(&studio).scan().dims(), [16; 3]);
}

#[test]
fn reasons_are_those_of_the_client() {
    let source = concat!(
        include_str!("../../../../crates/lumivox-dicomweb/src/server.rs"),
        include_str!("../../../../crates/lumivox-dicomweb/src/query.rs"),
        include_str!("../../../../crates/lumivox-dicomweb/src/fetch.rs"),
    );
    for (english, _) in REASONS {
        assert!(source.contains(&format!("\"{english}\"")), "nobody says '{english}' any more");
    }
}

#[test]
fn german_says_what_english_does() {
    let server = || "https://archive.example.org".to_owned();
    let errors = [
        Error::Address { address: server(), why: "it has no name" },
        Error::Days { days: "yesterday".to_owned() },
        Error::Unreachable { server: server(), why: "it sends on and on".to_owned() },
        Error::Untrusted { server: server(), why: "expired".to_owned() },
        Error::Login { server: server(), status: 401 },
        Error::NoArchive { server: server(), why: "no list came".to_owned() },
        Error::Refused { server: server(), status: 500, words: ": busy".to_owned() },
        Error::Nothing { server: server() },
        Error::Incomplete { server: server(), got: 12, of: "more".to_owned() },
        Error::Elsewhere { server: server(), to: "https://login.example.org".to_owned() },
        Error::Cut { server: server(), why: "the list has no end".to_owned() },
    ];
    for error in errors {
        let [english, german] = [Language::English, Language::German].map(|language| words(&error, language));
        assert_ne!(english, german);
        for (reason, _) in REASONS {
            assert!(!german.contains(reason), "{german}");
        }
        // Names, addresses and numbers are there in both.
        let facts = [
            "https://archive.example.org",
            "https://login.example.org",
            "yesterday",
            "expired",
            "busy",
            "401",
            "500",
            "12",
        ];
        for fact in facts {
            assert_eq!(english.contains(fact), german.contains(fact), "{german}");
        }
    }
}
