//! What values are measured in: maps of a CT are no Hounsfield units, and quantities have units of their own.

use crate::common::{load_written, values};
use crate::writer::*;
use lumivox_core::Modality;
use lumivox_import::Imported;

const RESCALE_TYPE: u32 = 0x0028_1054;
const REAL_WORLD_VALUE_MAPPING_SEQUENCE: u32 = 0x0040_9096;

fn load_one(elements: &Elements) -> Imported {
    load_written(|path| elements.write(path, Syntax::Explicit)).unwrap()
}

/// A CT whose second sample is padding; values are 10 and -1000 as Hounsfield units.
fn ct() -> Elements {
    image("CT", 3, 1, vec![1010, 0, 3000])
        .decimals(RESCALE_SLOPE, &[1.0])
        .decimals(RESCALE_INTERCEPT, &[-1000.0])
        .short(PIXEL_PADDING_VALUE, 0)
}

/// A mapping to `unit` by a slope and an intercept.
fn real_world(unit: &str, slope: f64, intercept: f64) -> Elements {
    let code = Elements::default().text(0x0008_0100, "SH", unit).text(0x0008_0102, "SH", "UCUM");
    let mut mapping = Elements::default().items(0x0040_08EA, vec![code]);
    mapping.set(0x0040_9224, "FD", Value::Raw(8, intercept.to_le_bytes().to_vec()));
    mapping.set(0x0040_9225, "FD", Value::Raw(8, slope.to_le_bytes().to_vec()));
    mapping
}

/// The unit in the report, the first two values, and whether looks of CT fit them.
fn seen(elements: &Elements) -> (String, [f64; 2], bool) {
    let imported = load_one(elements);
    let found = values(&imported.volume);
    (imported.report.series[0].unit.clone(), [found[0], found[1]], imported.volume.is_hounsfield())
}

#[test]
fn maps_of_a_ct_are_no_hounsfield_units() {
    let hu = ("HU".to_owned(), [10.0, -1000.0], true);
    assert_eq!(seen(&ct()), hu);
    assert_eq!(seen(&ct().text(RESCALE_TYPE, "LO", "HU ")), hu);
    // Padding is the lowest value of what was measured, not air.
    for (told, unit) in [
        ("MGML", "mg/ml"),
        ("Z_EFF", "Z_eff"),
        ("ED", "10^23 e/ml"),
        ("EDW", "electrons per electron of water"),
        ("PCT", "%"),
        ("ml/100ml/s", "ml/100ml/s"),
        ("US", ""),
        ("SECRET^NAME", ""),
    ] {
        let map = ct().decimals(RESCALE_INTERCEPT, &[0.0]).text(RESCALE_TYPE, "LO", told);
        assert_eq!(seen(&map), (unit.to_owned(), [1010.0, 1010.0], false), "{told}");
        let imported = load_one(&map);
        let notes = imported.report.notes.join("; ");
        assert!(notes.contains("not Hounsfield units") && !notes.contains("SECRET"), "{notes}");
        assert_eq!(imported.volume.modality(), Modality::Ct, "a CT made it all the same");
    }
    for kind in ["MAT_SPECIFIC", "CBF", "EFF_ATOMIC_NUM"] {
        let map = ct().text(IMAGE_TYPE, "CS", &format!("DERIVED\\PRIMARY\\AXIAL\\{kind}"));
        assert_eq!(seen(&map), (String::new(), [10.0, 10.0], false), "{kind}");
    }
    // Of original images that begin at air the unit is known, whatever the scanner calls it.
    let original = ct().text(RESCALE_TYPE, "LO", "US").text(IMAGE_TYPE, "CS", "ORIGINAL\\PRIMARY\\AXIAL");
    assert_eq!(seen(&original), hu);
}

#[test]
fn tables_and_frames_tell_units_too() {
    // A table of the modality, whose type is that of a rescale.
    let mut table = Elements::default().text(0x0028_3004, "LO", "MGML");
    table.set(0x0028_3002, "US", Value::Words(vec![2, 0, 16]));
    table.set(0x0028_3006, "OW", Value::Words(vec![7, 9]));
    let map = image("CT", 2, 1, vec![0, 1]).items(0x0028_3000, vec![table]);
    assert_eq!(seen(&map), ("mg/ml".to_owned(), [7.0, 9.0], false));
    // An enhanced image has it in its functional groups.
    let rescale = Elements::default()
        .decimals(RESCALE_SLOPE, &[0.5])
        .decimals(RESCALE_INTERCEPT, &[0.0])
        .text(RESCALE_TYPE, "LO", "EDW");
    let shared = Elements::default().items(0x0028_9145, vec![rescale]);
    let map = image("CT", 2, 1, vec![2, 4]).items(0x5200_9229, vec![shared]);
    assert_eq!(seen(&map), ("electrons per electron of water".to_owned(), [1.0, 2.0], false));
}

#[test]
fn real_world_values_count_where_the_rescale_tells_nothing() {
    let mapped = |modality, unit: &str| {
        image(modality, 2, 1, vec![2, 4])
            .items(REAL_WORLD_VALUE_MAPPING_SEQUENCE, vec![real_world(unit, 0.5, 1.0)])
    };
    assert_eq!(seen(&mapped("CT", "mg/ml")), ("mg/ml".to_owned(), [2.0, 3.0], false));
    assert_eq!(seen(&mapped("MR", "mm2/s")), ("mm2/s".to_owned(), [2.0, 3.0], false));
    // One whose unit is not known, and one that a CT needs no more, change nothing.
    assert_eq!(seen(&mapped("MR", "SECRET^NAME")), (String::new(), [2.0, 4.0], false));
    let hu = mapped("CT", "mg/ml").text(RESCALE_TYPE, "LO", "HU");
    assert_eq!(seen(&hu), ("HU".to_owned(), [2.0, 4.0], true));
}

#[test]
fn a_mapping_to_plain_numbers_holds_too() {
    let mapped = |modality, mappings| {
        image(modality, 2, 1, vec![20, 40]).items(REAL_WORLD_VALUE_MAPPING_SEQUENCE, mappings)
    };
    let numbers = || real_world("1", 0.1, 5.0);
    let expected = (String::new(), [7.0, 9.0], false);
    assert_eq!(seen(&mapped("MR", vec![numbers()])), expected);
    assert_eq!(seen(&mapped("PT", vec![numbers()])), expected);
    // A map that is made of a CT has its modality.
    let map = mapped("CT", vec![numbers()]);
    assert_eq!(seen(&map), expected);
    let notes = load_one(&map).report.notes.join("; ");
    assert!(notes.contains("values are plain numbers, not Hounsfield units"), "{notes}");
    // Of a CT with a rescale that leads to Hounsfield units, it is beside them; and a unit says more.
    let ct = ct().items(REAL_WORLD_VALUE_MAPPING_SEQUENCE, vec![numbers()]);
    assert_eq!(seen(&ct), ("HU".to_owned(), [10.0, -1000.0], true));
    let both = mapped("MR", vec![numbers(), real_world("mm2/s", 0.5, 0.0)]);
    assert_eq!(seen(&both), ("mm2/s".to_owned(), [10.0, 20.0], false));
}

#[test]
fn a_mapping_is_applied_where_it_holds() {
    let over = |first: u16, last: u16, slope: f64| {
        let mut mapping = real_world("mg/ml", slope, 0.0);
        mapping.set(0x0040_9216, "US", Value::Short(first));
        mapping.set(0x0040_9211, "US", Value::Short(last));
        mapping
    };
    let mapped = |mappings: Vec<Elements>| {
        let image = image("MR", 2, 1, vec![2, 4000]).short(BITS_STORED, 12).short(HIGH_BIT, 11);
        image.items(REAL_WORLD_VALUE_MAPPING_SEQUENCE, mappings)
    };
    let notes = |elements: &Elements| load_one(elements).report.notes.join("; ");
    let all = ("mg/ml".to_owned(), [1.0, 2000.0], false);
    // The one of several that holds for all that may be stored.
    assert_eq!(seen(&mapped(vec![over(0, 100, 7.0), over(0, 4095, 0.5)])), all);
    // The only one is of the values that there are, as some programs write it; it is said.
    let only = mapped(vec![over(2, 4000, 0.5)]);
    assert_eq!(seen(&only), all);
    assert!(notes(&only).contains("given for stored values from 2 to 4000 only"), "{}", notes(&only));
    // Parts with a mapping each have no common one.
    let parts = mapped(vec![over(0, 99, 7.0), over(100, 4095, 0.5)]);
    assert_eq!(seen(&parts), (String::new(), [2.0, 4000.0], false));
    assert!(notes(&parts).contains("several mappings to mg/ml"), "{}", notes(&parts));
}
