//! What is said of series: enough to tell them apart, and nothing that may name a person.

use std::{collections::HashSet, path::Path};

use crate::common::{load, load_written};
use crate::writer::*;
use lumivox_core::{CancelToken, Progress};
use lumivox_import::{ImportOptions, ImportReport};

const SERIES_DESCRIPTION: u32 = 0x0008_103E;

fn report(elements: &Elements) -> ImportReport {
    load_written(|path| elements.write(path, Syntax::Explicit)).unwrap().report
}

fn description(elements: &Elements) -> String {
    report(elements).series[0].description.clone()
}

#[test]
fn eleven_series_of_one_size_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    for k in 0..11 {
        let slice = |z: f64| {
            image("CT", 2, 1, vec![0, 1])
                .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, z])
                .text(SERIES_INSTANCE_UID, "UI", &format!("1.2.3.{k}"))
                .text(SERIES_NUMBER, "IS", &(k + 1).to_string())
        };
        for z in [0.0, 1.0] {
            slice(z).write(&folder.path().join(format!("{k} {z}")), Syntax::Explicit);
        }
    }
    let report = load(folder.path()).unwrap().report;
    let told: HashSet<_> = report.series.iter().map(|series| &series.description).collect();
    assert_eq!(told.len(), 11, "{told:?}");
    let reasons: HashSet<_> = report.series[1..].iter().map(|series| series.reason.as_str()).collect();
    assert_eq!(reasons, HashSet::from(["equal to the first, and found later"]));
}

#[test]
fn series_are_called_by_number_words_kernel_and_time() {
    let ct = image("CT", 2, 1, vec![0, 1])
        .text(SERIES_DESCRIPTION, "LO", "Thorax^1.0 B30f (Miller) JANE")
        .text(0x0018_1210, "SH", "B30f")
        .text(0x0008_0031, "TM", "103105.25");
    let told = description(&ct);
    assert!(
        told.starts_with("CT series 7, Thorax 1.0 B30f, kernel B30f, 10:31:05, 1 slice, 2 x 1"),
        "{told}"
    );
    // Neither names nor numbers of patients, even those that are terms, nor what no kernel is called.
    let other = image("CT", 2, 1, vec![0, 1])
        .text(PATIENT_NAME, "PN", "Brain^Jane")
        .text(SERIES_DESCRIPTION, "LO", "BRAIN SECRET 19500312 P1234567 axial")
        .text(0x0018_1210, "SH", "SECRET NAME");
    assert_eq!(description(&other), "CT series 7, axial, 1 slice, 2 x 1");
    let name = |elements: &Elements| report(elements).series[0].name.clone();
    assert_eq!(name(&ct), "CT series 7");
    assert_eq!(name(&image("SECRET", 1, 1, vec![0]).without(SERIES_NUMBER)), "Scan");
}

#[test]
fn weightings_are_guessed_and_said() {
    let mr = |sequence: &str, tr: f64, te: f64, ti: f64| {
        let mr = image("MR", 2, 1, vec![0, 1])
            .text(0x0018_0020, "CS", sequence)
            .decimals(0x0018_0080, &[tr])
            .decimals(0x0018_0081, &[te])
            .decimals(0x0018_0082, &[ti]);
        description(&mr)
    };
    assert!(mr("SE", 500.0, 12.0, 0.0).contains("T1-weighted by TR 500 TE 12 ms"));
    assert!(mr("SE", 4000.0, 100.0, 0.0).contains("T2-weighted"));
    assert!(mr("SE", 3000.0, 20.0, 0.0).contains("PD-weighted"));
    assert!(mr("SE\\IR", 9000.0, 120.0, 2500.0).contains("FLAIR"));
    assert!(mr("GR\\IR", 2000.0, 3.0, 900.0).contains("T1-weighted"));
    assert!(!mr("GR", 3.0, 1.5, 0.0).contains("weighted"));
    assert!(mr("RM", 100.0, 5.0, 0.0).contains("TR 100 TE 5 ms"));
}

#[test]
fn a_folder_without_files_is_said_to_be_one() {
    let open = |path: &Path| {
        let options = ImportOptions::default();
        lumivox_import::load(&[path.to_owned()], &options, Progress::SILENT, &CancelToken::new())
            .unwrap_err()
            .to_string()
    };
    let folder = tempfile::tempdir().unwrap();
    let empty = open(folder.path());
    assert!(empty.ends_with("it holds no file. Choose the folder that holds the scan"), "{empty}");
    std::fs::write(folder.path().join("a.txt"), "text").unwrap();
    let one = open(folder.path());
    assert!(one.contains("its one file is no image"), "{one}");
}

#[test]
fn parts_of_a_name_or_number_are_told_nowhere() {
    let told = |name: &str, id: &str, text: &str, kernel: &str| {
        let ct = image("CT", 2, 1, vec![0, 1])
            .text(PATIENT_NAME, "PN", name)
            .text(0x0010_0020, "LO", id)
            .text(SERIES_DESCRIPTION, "LO", text)
            .text(0x0018_1210, "SH", kernel);
        description(&ct)
    };
    // Beside digits, behind a point; a number without its dash, and in pieces.
    assert_eq!(
        told("DOE^JANE", "1", "DOE1950 chest DOE.1 T2", "JANE3"),
        "CT series 7, chest T2, 1 slice, 2 x 1"
    );
    assert_eq!(told("DOE^JANE", "AB-123", "AB123 axial T2", ""), "CT series 7, axial T2, 1 slice, 2 x 1");
    assert_eq!(told("DOE^JANE", "AB123", "A.B.123 123 axial", ""), "CT series 7, axial, 1 slice, 2 x 1");
}

#[test]
fn what_a_scan_is_of_is_known_and_no_text_of_it() {
    use lumivox_core::{BodyPart, Focus, Subject};
    let subject = |elements: Elements| -> Subject {
        crate::common::load_written(|path| elements.write(path, Syntax::Explicit)).unwrap().volume.subject()
    };
    let ct = || image("CT", 2, 2, vec![0, 1, 2, 3]);
    assert_eq!(subject(ct()), Subject::default());
    let chest = subject(ct().text(0x0018_0015, "CS", "CHEST").text(0x0018_1030, "LO", "Head routine"));
    assert_eq!((chest.part, chest.focus, chest.contrast), (Some(BodyPart::Chest), None, None));
    let angiogram = subject(ct().text(0x0008_103E, "LO", "CTA Kopf 0.75"));
    assert_eq!((angiogram.part, angiogram.focus), (Some(BodyPart::Head), Some(Focus::Vessels)));
    for (agent, contrast) in [("Imeron 400", Some(true)), ("NONE", None), ("", None)] {
        assert_eq!(subject(ct().text(0x0018_0010, "LO", agent)).contrast, contrast, "{agent}");
    }
    assert_eq!(subject(ct().text(0x0018_1210, "SH", "LUNG")).focus, Some(Focus::Lungs));
}
