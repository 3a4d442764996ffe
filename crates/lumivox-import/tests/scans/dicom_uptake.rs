//! Standardized uptake values of PET, from slices and from enhanced images.

use crate::common::{load_written, values};
use crate::writer::*;
use lumivox_import::{ImportError, Imported};

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

const SERIES_TIME: u32 = 0x0008_0031;
const DECAY_CORRECTION: u32 = 0x0054_1102;
const UNITS: u32 = 0x0054_1001;

/// The SUV of the second sample, 2000 in Bq/ml, or the first note where there is none.
fn suv(elements: &Elements) -> Result<f64, String> {
    let imported = load_one(elements).unwrap();
    match imported.report.series[0].unit.as_str() {
        "SUV" => Ok(values(&imported.volume)[1]),
        _ => Err(imported.report.notes[0].clone()),
    }
}

fn near(found: Result<f64, String>, expected: f64) {
    let found = found.unwrap();
    assert!((found - expected).abs() < 1e-6 * expected, "{found}, not {expected}");
}

/// What 2000 Bq/ml are after so many half-lives, with 370 MBq and 70 kg.
fn after(half_lives: f64) -> f64 {
    2000.0 * 70_000.0 / (370e6 * (-half_lives).exp2())
}

fn drug(half_life: f64, time: Option<&str>, date_time: Option<&str>) -> Elements {
    let mut drug = Elements::default().decimals(0x0018_1074, &[370e6]).decimals(0x0018_1075, &[half_life]);
    if let Some(time) = time {
        drug = drug.text(0x0018_1072, "TM", time);
    }
    if let Some(date_time) = date_time {
        drug = drug.text(0x0018_1078, "DT", date_time);
    }
    drug
}

/// [`pet`], on a day.
fn pet_on(date: &str, drug: Elements) -> Elements {
    pet().text(0x0008_0021, "DA", date).text(0x0008_0022, "DA", date).items(0x0054_0016, vec![drug])
}

#[test]
fn days_between_injection_and_scan_count() {
    const HOUR: f64 = 3600.0;
    // Zirconium-89, given four days before the scan, by date; 98 hours in all.
    let given = Some("20240226225900.00");
    let late = pet_on("20240302", drug(78.41 * HOUR, Some("225900"), given));
    near(suv(&late), after((4.0 * 24.0 + 2.0) / 78.41));
    // Its time of day alone would be 2.3 times too low: no SUV is better than a wrong one.
    let why = suv(&pet_on("20240302", drug(78.41 * HOUR, Some("225900"), None))).unwrap_err();
    assert!(why.contains("the day of the injection is not given"), "{why}");
    // Of what decays within hours it suffices, over midnight too; a date that was moved away counts for nothing.
    for date_time in [None, Some("20240301235900"), Some("19990101235900")] {
        near(suv(&pet_on("20240302", drug(HOUR, Some("235900"), date_time))), after(1.0));
    }
    // Both ahead of UTC by their own hours.
    let zones = pet_on("20240302", drug(HOUR, None, Some("20240301235900.0000+0000")));
    near(suv(&zones.text(0x0008_0201, "SH", "-0100")), after(2.0));
}

#[test]
fn decay_correction_and_corrections_are_believed_as_they_are_said() {
    near(suv(&pet()), after(1.0));
    near(suv(&pet().text(DECAY_CORRECTION, "CS", "ADMIN")), after(0.0));
    let why = |elements: Elements| suv(&elements).unwrap_err();
    assert!(why(pet().text(DECAY_CORRECTION, "CS", "NONE")).contains("not corrected for decay"));
    assert!(why(pet().without(DECAY_CORRECTION)).contains("to which time decay is corrected"));
    assert!(why(pet().text(0x0028_0051, "CS", "ATTN")).contains("for the image is not corrected for decay"));
    let other = pet().text(UNITS, "CS", "GML").text(0x0054_1006, "CS", "LBM");
    assert!(why(other).contains("another measure than body weight"));
}

#[test]
fn series_made_after_the_scan_are_counted_back_to_its_beginning() {
    const HALF_LIFE: f64 = 3600.0;
    // The third bed position, begun 20 minutes after the scan at 00:59:00, for three minutes.
    let duration = 180.0;
    let decay = std::f64::consts::LN_2 / HALF_LIFE;
    let mean = (decay * duration / (1.0 - (-decay * duration).exp())).ln() / decay;
    let again = pet()
        .text(0x0008_0031, "TM", "120000")
        .text(0x0008_0032, "TM", "011900")
        .decimals(0x0054_1300, &[(1200.0 + mean) * 1e3])
        .text(0x0018_1242, "IS", "180000");
    let found = suv(&again).unwrap();
    assert!((found / after(1.0) - 1.0).abs() < 1e-6, "{found}");
    // GE says it in an element of its own.
    let private = pet().text(0x0008_0031, "TM", "120000").text(0x0009_0010, "LO", "GEMS_PETD_01").text(
        0x0009_100D,
        "DT",
        "20240302005900.00",
    );
    near(suv(&private), after(1.0));
}

#[test]
fn counts_become_uptake_by_philips_factors() {
    let philips = |element: u32, factor: f64| {
        let counts = pet().text(UNITS, "CS", "CNTS").text(0x7053_0010, "LO", "Philips PET Private Group");
        counts.decimals(0x7053_1000 | element, &[factor])
    };
    near(suv(&philips(0x00, 0.25)), 500.0);
    near(suv(&philips(0x09, 3.0)), 3.0 * after(1.0));
    let imported = load_one(&philips(0x09, 3.0).without(0x0010_1030)).unwrap();
    assert_eq!((values(&imported.volume)[1], imported.report.series[0].unit.as_str()), (6000.0, "Bq/ml"));
    let imported = load_one(&philips(0x00, 0.25).text(0x0028_0051, "CS", "DECY")).unwrap();
    assert_eq!((values(&imported.volume)[1], imported.report.series[0].unit.as_str()), (2000.0, "counts"));
}

#[test]
fn legacy_converted_images_have_their_unit_among_the_leftovers() {
    let classic = pet();
    // What an enhanced image has no place for moves into a sequence of the shared groups.
    let moved = [0x0028_0051, UNITS, DECAY_CORRECTION, 0x0054_0016];
    let mut leftovers = Elements::default();
    leftovers.0.extend(classic.0.iter().filter(|(tag, ..)| moved.contains(tag)).cloned());
    let rescale = Elements::default().decimals(RESCALE_SLOPE, &[2.0]).decimals(RESCALE_INTERCEPT, &[0.0]);
    let shared = Elements::default().items(0x0020_9170, vec![leftovers]).items(0x0028_9145, vec![rescale]);
    let mut legacy = classic
        .text(SOP_CLASS_UID, "UI", "1.2.840.10008.5.1.4.1.1.128.1")
        .items(0x5200_9229, vec![shared])
        .without(RESCALE_SLOPE);
    for tag in moved {
        legacy = legacy.without(tag);
    }
    near(suv(&legacy), after(1.0));
}

#[test]
fn a_scan_may_begin_a_little_before_the_injection_and_not_long_after_it() {
    const FLUORINE: f64 = 6586.2;
    const RUBIDIUM: f64 = 75.6;
    for dated in [false, true] {
        let scan = |half_life: f64, scan: &str, given: &str| {
            let date_time = format!("20240302{given}");
            let drug = drug(half_life, (!dated).then_some(given), dated.then_some(&date_time));
            suv(&pet_on("20240302", drug).text(SERIES_TIME, "TM", scan).text(0x0008_0032, "TM", scan))
        };
        near(scan(FLUORINE, "100000", "100010"), after(-10.0 / FLUORINE));
        near(scan(RUBIDIUM, "100000", "100100"), after(-60.0 / RUBIDIUM));
        // Ten seconds before, over midnight, where the day counts.
        near(scan(FLUORINE, "235955", "000005"), after(-10.0 / FLUORINE));
        // Neither long before, nor when nothing is left.
        for (half_life, at, given) in
            [(FLUORINE, "100000", "110000"), (RUBIDIUM, "100000", "100600"), (RUBIDIUM, "100000", "094500")]
        {
            let why = scan(half_life, at, given).unwrap_err();
            assert!(why.contains("the time of injection makes no sense"), "{why}");
        }
    }
    // An enhanced image, whose decay is corrected to the same moment.
    let drug = Elements::default().decimals(0x0018_1074, &[370.0]).decimals(0x0018_1075, &[RUBIDIUM]).text(
        0x0018_1078,
        "DT",
        "20240301003100",
    );
    near(suv(&enhanced_pet("Bq/ml").items(0x0054_0016, vec![drug])), after(-60.0 / RUBIDIUM));
}

#[test]
fn a_series_without_a_time_is_said_to_have_none() {
    let why = suv(&pet().without(SERIES_TIME)).unwrap_err();
    assert!(why.contains("the time of the series is not given") && !why.contains("after the scan"), "{why}");
}

#[test]
fn an_empty_value_is_completed_by_the_leftovers() {
    let leftovers = Elements::default().text(DECAY_CORRECTION, "CS", "START");
    let shared = Elements::default().items(0x0020_9170, vec![leftovers]);
    near(suv(&pet().text(DECAY_CORRECTION, "CS", "").items(0x5200_9229, vec![shared])), after(1.0));
}
