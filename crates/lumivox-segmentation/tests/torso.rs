//! Torsos whose every voxel is known.

mod common;

use lumivox_core::{CancelToken, Progress, Volume, Voxels};
use lumivox_phantom::{Arms, Metal, TorsoOptions, TorsoPart, torso, torso_parts};
use lumivox_segmentation::Class;

use common::{dice, run, share};

/// Grows a torso, segments it and compares.
fn check(name: &str, options: TorsoOptions) {
    let cancel = CancelToken::new();
    let volume = torso(options, Progress::SILENT, &cancel).unwrap();
    let parts = torso_parts(options, Progress::SILENT, &cancel).unwrap();
    let found = run(&volume);
    let part = |i: usize| TorsoPart::from_number(parts[i]).unwrap();
    let patient = |class: Option<Class>| class.is_some_and(Class::is_patient);
    let kept = share(&found, |i| part(i).is_body(), patient);
    let removed = share(&found, |i| part(i).is_equipment(), |class| !patient(class));
    let outside = share(&found, |i| part(i).is_outside(), |class| !patient(class));
    let lungs = share(&found, |i| part(i) == TorsoPart::Lung, |class| class == Some(Class::Lungs));
    // Vessels in lungs belong to them.
    let dice = dice(&found, Class::Lungs, |i| part(i) == TorsoPart::Lung);
    let gas = share(&found, |i| part(i) == TorsoPart::GutGas, |class| class == Some(Class::Gas));
    let leaked = share(&found, |i| part(i) == TorsoPart::Lung, |class| class == Some(Class::Airways));
    println!(
        "{name}: kept {kept:.5}, removed {removed:.5}, outside {outside:.5}, lungs {lungs:.4} (Dice {dice:.4}), \
         gas {gas:.4}, leaked {leaked:.5}"
    );
    assert!(kept >= 0.999, "{name}: {kept} of the patient kept");
    assert!(removed >= 0.995, "{name}: {removed} of the things removed");
    assert!(outside >= 0.99, "{name}: {outside} of the air is outside");
    assert!(lungs >= 0.95 && dice >= 0.93, "{name}: {lungs} of the lungs, Dice {dice}");
    assert!(gas >= 0.9, "{name}: {gas} of the gas");
    assert!(leaked < 0.01, "{name}: airways leak into {leaked} of the lungs");
    assert!(found.report.volume_mm3(Class::Airways) > 15_000.0, "{name}: {}", found.report);
    assert!(found.report.confidence >= 0.8, "{name}: {}", found.report);
}

#[test]
fn under_a_blanket_in_a_field_of_view_that_was_turned() {
    let options =
        TorsoOptions { size: 108, blanket: true, breasts: true, tilt_degrees: 10.0, ..Default::default() };
    check("blanket", options);
}

#[test]
fn a_round_field_of_view_that_cuts_arms_and_chest_at_a_low_dose() {
    let options = TorsoOptions {
        size: 108,
        arms: Arms::AtSides,
        padding: true,
        field_of_view_mm: 340.0,
        shift_mm: [50.0, 0.0, 20.0],
        metal: Metal::Pacemaker,
        noise_hu: 50.0,
        ..Default::default()
    };
    check("cut", options);
}

/// A slice of zeros opens the chest: lungs may be missed, and the report says that it is not sure, and why.
#[test]
fn a_damaged_slice_lowers_the_confidence() {
    let cancel = CancelToken::new();
    let volume = torso(TorsoOptions { size: 64, ..Default::default() }, Progress::SILENT, &cancel).unwrap();
    let whole = run(&volume);
    assert!(!whole.report.to_string().contains("unlike"), "{}", whole.report);
    let [nx, ny, nz] = volume.dims();
    let values = (0..volume.voxel_count()).map(|i| {
        if i / nx / ny == nz / 2 {
            0.0
        } else {
            (volume.voxels().get(i) * volume.slope() + volume.intercept()) as f32
        }
    });
    let voxels = Voxels::F32(values.collect());
    let place = volume.patient_from_voxel();
    let damaged = Volume::new([nx, ny, nz], voxels, [1.0, 0.0], place, volume.modality()).unwrap();
    let damaged = run(&damaged.with_unit("HU"));
    let report = damaged.report.to_string();
    assert!(damaged.report.confidence < 0.6 * whole.report.confidence, "{report}");
    assert!(report.contains(&format!("slice {} is unlike both", nz / 2 + 1)), "{report}");
}
