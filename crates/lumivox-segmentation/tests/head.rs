//! A head in a head-rest, and a real chest.

mod common;

use std::path::{Path, PathBuf};

use lumivox_core::{CancelToken, Modality, Progress, Volume, Voxels, glam::DVec3};
use lumivox_import::{ImportOptions, load};
use lumivox_phantom::{AnatomyOptions, anatomy};
use lumivox_segmentation::{Class, depth_below_skin, patient_alone};

use common::{run, share};

#[test]
fn ears_stay_and_the_head_rest_goes() {
    let options = AnatomyOptions { size: 128, ..Default::default() };
    let head = anatomy(options, Progress::SILENT, &CancelToken::new()).unwrap();
    let [nx, ny, _] = head.dims();
    let mut samples = Vec::new();
    let mut rest = Vec::new();
    let air = -700.0;
    for i in 0..head.voxel_count() {
        let voxel = [i % nx, i / nx % ny, i / nx / ny];
        let p = head.patient_from_voxel().transform_point3(DVec3::from_array(voxel.map(|at| at as f64)));
        let value = head.value(voxel);
        // A bowl behind the head, up to the ears, from the neck to beyond the vertex; its pad touches the head.
        let radius = (p.truncate() - DVec3::new(0.0, 12.0, 0.0).truncate()).length();
        let is_bowl = (112.0..117.0).contains(&radius) && p.y > 0.0 && p.z > -90.0;
        let is_pad = (104.0..112.0).contains(&radius) && p.y > 60.0 && p.z > -60.0;
        let thing = value < air && (is_bowl || is_pad);
        let hu = if !thing {
            value
        } else if is_bowl {
            600.0
        } else {
            -900.0
        };
        samples.push((hu + 1024.0).round() as u16);
        rest.push(thing);
    }
    let voxels = Voxels::U16(samples);
    let scan =
        Volume::new(head.dims(), voxels, [1.0, -1024.0], head.patient_from_voxel(), Modality::Ct).unwrap();
    let found = run(&scan);
    let patient = |class: Option<Class>| class.is_some_and(Class::is_patient);
    let kept = share(&found, |i| head.voxels().get(i) - 1024.0 > -400.0, patient);
    let removed = share(&found, |i| rest[i], |class| !patient(class));
    println!("kept {kept:.5}, removed {removed:.5}");
    assert!(kept >= 0.999, "{kept} of the head kept");
    assert!(removed >= 0.995, "{removed} of the head-rest removed");
    assert!(found.report.volume_mm3(Class::Table) > 50_000.0, "{}", found.report);
    assert!(found.report.confidence >= 0.8, "{}", found.report);
}

/// Where a real scan is; `None` where they are absent.
fn shared(name: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let folder = std::env::var_os("LUMIVOX_TEST_SCANS").map_or(PathBuf::from(beside), PathBuf::from);
    let path = folder.join(name);
    if !path.exists() {
        use std::io::Write;
        // The test harness keeps what `eprintln!` prints of a test that passes, but not this.
        let absent = path.display();
        let _ = writeln!(std::io::stderr(), "a real scan is absent ({absent}): its test checks nothing");
        return None;
    }
    Some(path)
}

fn real(path: &Path) -> Volume {
    let options = ImportOptions::default();
    load(&[path.to_owned()], &options, Progress::SILENT, &CancelToken::new()).unwrap().volume
}

#[test]
fn a_real_chest_without_its_table() {
    let Some(path) = shared("ct_torso.zip") else { return };
    let scan = real(&path);
    let found = run(&scan);
    assert!(found.report.confidence >= 0.9, "{}", found.report);
    let ml = |class: Class| found.report.volume_mm3(class) / 1000.0;
    assert!((13_900.0..14_200.0).contains(&ml(Class::Body)), "{}", found.report);
    assert!((2_700.0..2_900.0).contains(&ml(Class::Lungs)), "{}", found.report);
    assert!((25.0..45.0).contains(&ml(Class::Airways)), "{}", found.report);
    assert!(ml(Class::Table) > 1_000.0, "{}", found.report);
    // Below the back there is nothing of the patient, and within the chest nothing that is not.
    let [nx, ny, nz] = scan.dims();
    let at = |voxel: [usize; 3]| Class::of(found.labels.value(voxel)).unwrap();
    for z in 0..nz {
        assert!((0..nx).all(|x| (454..ny).all(|y| !at([x, y, z]).is_patient())), "slice {z}");
        assert!((200..300).all(|x| (230..330).all(|y| at([x, y, z]).is_patient())), "slice {z}");
    }
    // The spine lies deeper than the skin.
    let (silent, cancel) = (Progress::SILENT, CancelToken::new());
    let depth = depth_below_skin(&scan, &found.labels, silent, &cancel).unwrap();
    assert!(depth.mm([246, 345, 20]) > 40.0);
    // Where the table is, nothing that a look shows is left; the patient is as scanned.
    let alone = patient_alone(scan.clone(), silent, &cancel).unwrap();
    assert_eq!(alone.report.as_ref(), Some(&found.report));
    assert!(alone.note().unwrap().starts_with("hidden: table and supports ("), "{:?}", alone.note());
    let below = (0..nz).flat_map(|z| (0..nx).flat_map(move |x| (456..ny).map(move |y| [x, y, z])));
    let visible = below.filter(|&voxel| alone.volume.value(voxel) > -750.0).count();
    assert_eq!(visible, 0);
    for (i, &label) in found.labels.voxels().iter().enumerate() {
        if Class::of(label).is_some_and(Class::is_patient) {
            assert_eq!(alone.volume.voxels().get(i), scan.voxels().get(i), "voxel {i}");
        }
    }
}
