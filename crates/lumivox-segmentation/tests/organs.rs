//! One organ alone, on a torso whose every voxel is known.

use lumivox_core::{CancelToken, Organ, Progress};
use lumivox_phantom::{TorsoOptions, TorsoPart, torso, torso_parts};
use lumivox_segmentation::{find_organ, has_organ, organ_alone, patient_alone};

/// What a look shows as solid, in HU.
const SOLID: f64 = -450.0;

#[test]
fn airways_and_vessels_of_the_lungs_stand_alone() {
    let options = TorsoOptions { size: 160, ..Default::default() };
    let (silent, cancel) = (Progress::SILENT, CancelToken::new());
    let parts = torso_parts(options, silent, &cancel).unwrap();
    let found = patient_alone(torso(options, silent, &cancel).unwrap(), silent, &cancel).unwrap();
    let labels = found.labels.unwrap();
    let shares = |organ: Organ| {
        assert!(has_organ(&labels, organ));
        let alone = organ_alone(found.volume.clone(), &labels, organ, silent, &cancel).unwrap();
        let parts = &parts;
        // Of each part, the share that is solid.
        move |part: TorsoPart| {
            let of_part =
                (0..alone.voxel_count()).filter(|&i| TorsoPart::from_number(parts[i]) == Some(part));
            let (mut all, mut solid) = (0u32, 0u32);
            for i in of_part {
                all += 1;
                solid += u32::from(alone.voxels().get(i) * alone.slope() + alone.intercept() > SOLID);
            }
            f64::from(solid) / f64::from(all)
        }
    };
    let others =
        [TorsoPart::Muscle, TorsoPart::Bone, TorsoPart::Liver, TorsoPart::Skin, TorsoPart::OutsideAir];

    let share = shares(Organ::Airways);
    let airways = share(TorsoPart::AirwayAir);
    println!("airways: {airways:.3} of the air in them");
    assert!(airways > 0.5, "{airways}");
    for part in others.into_iter().chain([TorsoPart::PulmonaryArtery]) {
        assert!(share(part) < 0.005, "{part:?}: {}", share(part));
    }
    assert!(share(TorsoPart::Lung) < 0.02, "{}", share(TorsoPart::Lung));

    let vessels = find_organ(&found.volume, Organ::LungVessels, silent, &cancel).unwrap().unwrap();
    let same = organ_alone(found.volume.clone(), &labels, Organ::LungVessels, silent, &cancel).unwrap();
    assert!(vessels.dims() == same.dims() && vessels.value_range() == same.value_range());

    let share = shares(Organ::LungVessels);
    let veins = share(TorsoPart::PulmonaryVein);
    println!("vessels: {veins:.3} of the veins");
    assert!(veins > 0.3, "{veins}");
    for part in others {
        println!("vessels: {:.4} of {part:?}", share(part));
        assert!(
            share(part) < if part == TorsoPart::Bone { 0.012 } else { 0.03 },
            "{part:?}: {}",
            share(part)
        );
    }
    assert!(share(TorsoPart::Lung) < 0.1, "{}", share(TorsoPart::Lung));
}

#[test]
fn a_head_has_neither_and_cancel_is_heard() {
    let (silent, cancel) = (Progress::SILENT, CancelToken::new());
    let options = lumivox_phantom::AnatomyOptions { size: 64, ..Default::default() };
    let head = lumivox_phantom::anatomy(options, silent, &cancel).unwrap();
    let found = patient_alone(head, silent, &cancel).unwrap();
    let labels = found.labels.unwrap();
    assert!(!has_organ(&labels, Organ::LungVessels));
    assert!(find_organ(&found.volume, Organ::Airways, silent, &cancel).unwrap().is_none());
    cancel.cancel();
    assert!(organ_alone(found.volume, &labels, Organ::LungVessels, silent, &cancel).is_err());
}
