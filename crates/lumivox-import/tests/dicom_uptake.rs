//! Standardized uptake values of PET, from slices and from enhanced images.

mod common;
#[allow(dead_code, reason = "not every test program uses all of it")]
#[path = "common/writer.rs"]
mod writer;

use common::{load_written, values};
use lumivox_import::{ImportError, Imported};
use writer::*;

const SOP_CLASS_UID: u32 = 0x0008_0016;

fn load_one(elements: &Elements) -> Result<Imported, ImportError> {
    load_written(|path| elements.write(path, Syntax::Explicit))
}

/// A PET slice: 70 kg, 370 MBq of a half-life of one hour, given an hour before the scan.
fn pet() -> Elements {
    let drug = Elements::default()
        .text(0x0018_1072, "TM", "235900.00")
        .decimals(0x0018_1074, &[370e6])
        .decimals(0x0018_1075, &[3600.0]);
    image("PT", 2, 1, vec![0, 1000])
        .decimals(RESCALE_SLOPE, &[2.0])
        .text(0x0008_0031, "TM", "005900")
        .text(0x0008_0032, "TM", "010200.5")
        .decimals(0x0010_1030, &[70.0])
        .text(0x0028_0051, "CS", "DECY\\ATTN\\SCAT")
        .text(0x0054_1001, "CS", "BQML")
        .text(0x0054_1102, "CS", "START")
        .items(0x0054_0016, vec![drug])
}

#[test]
fn uptake_values_are_made_where_the_header_allows() {
    let imported = load_one(&pet()).unwrap();
    // Half of the dose is left.
    let expected = 2000.0 * 70_000.0 / (370e6 / 2.0);
    assert!((values(&imported.volume)[1] - expected).abs() < 1e-6, "{:?}", values(&imported.volume));
    assert_eq!(imported.report.series[0].unit, "SUV");
    let because = |elements: Elements| {
        let imported = load_one(&elements).unwrap();
        assert_eq!(values(&imported.volume)[1], 2000.0);
        imported.report.notes[0].clone()
    };
    assert!(because(pet().without(0x0010_1030)).contains("the body weight is not given"));
    assert!(because(pet().without(0x0054_0016)).contains("the radiopharmaceutical is not given"));
    assert!(because(pet().text(0x0028_0051, "CS", "DECY")).contains("not corrected for attenuation"));
    assert!(because(pet().text(0x0008_0031, "TM", "020000")).contains("made after the scan"));
    assert!(because(pet().text(0x0054_1001, "CS", "CNTS")).contains("values are counts"));
    let at_injection = load_one(&pet().text(0x0054_1102, "CS", "ADMIN")).unwrap();
    assert!((values(&at_injection.volume)[1] - expected / 2.0).abs() < 1e-6);
}

/// An enhanced PET image of two frames: 70 kg, 370 MBq of a half-life of one hour, decay corrected to an hour later.
fn enhanced_pet(unit: &str) -> Elements {
    let double = |mut e: Elements, tag, value: f64| {
        e.set(tag, "FD", Value::Raw(8, value.to_le_bytes().to_vec()));
        e
    };
    let code = Elements::default().text(0x0008_0100, "SH", unit).text(0x0008_0102, "SH", "UCUM");
    let mapping = Elements::default().items(0x0040_08EA, vec![code]);
    let mapping = double(double(mapping, 0x0040_9224, 0.0), 0x0040_9225, 2.0);
    let place = |z: f64| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, z]);
        Elements::default().items(0x0020_9113, vec![place])
    };
    let drug = Elements::default().decimals(0x0018_1074, &[370.0]).decimals(0x0018_1075, &[3600.0]).text(
        0x0018_1078,
        "DT",
        "20240229233000.00",
    );
    let mut image = image("PT", 2, 1, vec![0, 1000, 0, 500])
        .text(SOP_CLASS_UID, "UI", "1.2.840.10008.5.1.4.1.1.130")
        .text(NUMBER_OF_FRAMES, "IS", "2")
        .decimals(0x0010_1030, &[70.0])
        .text(0x0018_9701, "DT", "20240301003000")
        .text(0x0018_9758, "CS", "YES")
        .text(0x0018_9759, "CS", "YES")
        .items(0x0054_0016, vec![drug])
        .items(0x5200_9230, vec![place(0.0), place(2.0)]);
    image = image.items(0x5200_9229, vec![Elements::default().items(0x0040_9096, vec![mapping])]);
    image
}

#[test]
fn uptake_values_of_enhanced_images() {
    let imported = load_one(&enhanced_pet("Bq/ml")).unwrap();
    let expected = 2000.0 * 70_000.0 / (370e6 / 2.0);
    let found = values(&imported.volume);
    assert!((found[1] - expected).abs() < 1e-6 && (found[3] - expected / 2.0).abs() < 1e-6, "{found:?}");
    assert_eq!(imported.report.series[0].unit, "SUV");
    let given = load_one(&enhanced_pet("{SUVbw}g/ml")).unwrap();
    assert_eq!((values(&given.volume)[1], given.report.series[0].unit.as_str()), (2000.0, "SUV"));
    // A unit of which nothing is known leaves the file's own values.
    let other = load_one(&enhanced_pet("{SUVlbm}g/ml")).unwrap();
    assert_eq!((values(&other.volume)[1], other.report.series[0].unit.as_str()), (1000.0, ""));

    let because = |elements: Elements| {
        let imported = load_one(&elements).unwrap();
        assert_eq!((values(&imported.volume)[1], imported.report.series[0].unit.as_str()), (2000.0, "Bq/ml"));
        imported.report.notes.join("; ")
    };
    let pet = || enhanced_pet("Bq/ml");
    let drug = |mbq: f64, time: &str| {
        let drug = Elements::default().decimals(0x0018_1074, &[mbq]).decimals(0x0018_1075, &[3600.0]);
        drug.text(0x0018_1078, "DT", time)
    };
    let given = |mbq, time| pet().items(0x0054_0016, vec![drug(mbq, time)]);
    assert!(because(pet().without(0x0010_1030)).contains("the body weight is not given"));
    assert!(because(pet().text(0x0018_9759, "CS", "NO")).contains("not corrected for attenuation"));
    assert!(because(pet().without(0x0018_9701)).contains("to which time decay is corrected"));
    assert!(because(given(370e6, "20240229233000")).contains("the dose is not given in MBq"));
    assert!(because(given(370.0, "20240301233000")).contains("a time that makes no sense"));
    assert!(because(given(370.0, "20240229233000+0100")).contains("a time zone"));
    let two = drug(370.0, "20240229233000");
    assert!(because(pet().items(0x0054_0016, vec![two.clone(), two])).contains("several radiopharm"));
    // An hour ahead of UTC, and in it: two hours apart.
    let zones = given(370.0, "20240229233000+0100").text(0x0018_9701, "DT", "20240301003000+0000");
    let found = values(&load_one(&zones).unwrap().volume)[1];
    assert!((found - 2.0 * expected).abs() < 1e-6, "{found}");
}
