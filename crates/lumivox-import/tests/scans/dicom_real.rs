//! Real scans: every value and place as other readers see them.

use std::path::Path;

use crate::common::{load, load_series, reference, shared, slice_sum, unzip};
use lumivox_core::{Modality, Voxels, glam::DVec3};

fn assert_near(a: DVec3, b: DVec3, tolerance: f64) {
    assert!(a.distance(b) < tolerance, "{a} is not {b}");
}

#[test]
fn ct_torso_has_every_slice_in_place() {
    let Some(folder) = unzip("ct_torso.zip") else { return };
    let imported = load(folder.path()).unwrap();
    let volume = &imported.volume;
    println!("{:?}", imported.report);
    assert_eq!(volume.dims(), [512, 512, 275]);
    assert_eq!(volume.modality(), Modality::Ct);
    assert!(matches!(volume.voxels(), Voxels::U16(_)));
    assert_near(volume.spacing_mm(), DVec3::new(0.781, 0.781, 1.0), 1e-3);

    // Each file by itself, at its place in the volume.
    let lines = reference("ct_torso/");
    assert_eq!(lines.len(), 275);
    let voxel_from_patient = volume.patient_from_voxel().inverse();
    let mut seen = [false; 275];
    for (k, line) in lines.values().enumerate() {
        if k % 11 == 0 {
            let single = load(&folder.path().join(&line.path)).unwrap().volume;
            let place = voxel_from_patient.transform_point3(single.patient_from_voxel().translation);
            assert_near(place, DVec3::new(0.0, 0.0, place.z.round()), 1e-3);
            assert_eq!(slice_sum(volume, place.z.round() as usize), (line.sum, line.range), "{}", line.path);
        }
    }
    // All of them, in whatever order.
    let mut sums: Vec<f64> = lines.values().map(|line| line.sum).collect();
    sums.sort_by(f64::total_cmp);
    for z in 0..275 {
        let (sum, _) = slice_sum(volume, z);
        let position = sums.binary_search_by(|s| s.total_cmp(&sum)).unwrap_or_else(|_| panic!("slice {z}"));
        seen[position] = true;
    }
    assert!(seen.iter().filter(|seen| **seen).count() > 270);
}

#[test]
fn a_zipped_study_is_the_same_as_its_folder() {
    let (Some(zip), Some(folder)) = (shared("mr_missing_slices.zip"), unzip("mr_missing_slices.zip")) else {
        return;
    };
    let (zipped, plain) = (load(&zip).unwrap(), load(folder.path()).unwrap());
    assert_eq!(zipped.volume.voxels(), plain.volume.voxels());
    assert_eq!(zipped.volume.patient_from_voxel(), plain.volume.patient_from_voxel());
    assert_eq!(zipped.report.notes, plain.report.notes);
    assert_eq!(zipped.report.skipped.len(), plain.report.skipped.len());
}

#[test]
fn ct_tilt_is_a_sheared_even_grid() {
    let Some(folder) = shared("ct_tilt") else { return };
    let imported = load(&folder).unwrap();
    let volume = &imported.volume;
    println!("{:?}", imported.report.notes);
    let [columns, rows, depth] = volume.dims();
    assert_eq!([columns, rows], [512, 512]);
    assert_eq!(imported.report.series[0].files, 28);
    let step = volume.patient_from_voxel().matrix3.z_axis;
    assert_near(step.normalize(), DVec3::Z, 1e-6);
    let normal = DVec3::X.cross(DVec3::new(0.0, 0.9483237, -0.3173047)).normalize();
    assert!((step.angle_between(normal).to_degrees() - 18.5).abs() < 0.05);
    assert!((step.length() * (depth - 1) as f64 - (157.7760586 - 5.8360586)).abs() < 1e-3);
    assert!(imported.report.notes.iter().any(|note| note.contains("tilt 18.5 degrees, kept as shear")));
    assert!(imported.report.notes.iter().any(|note| note.contains("1.081 to 6.999 mm apart")));
    // Padding of -1500 became air.
    assert!(volume.value_range()[0] >= -1024.0, "{:?}", volume.value_range());

    // Each slice, at its true place, between the grid's neighbours.
    let voxel_from_patient = volume.patient_from_voxel().inverse();
    for number in 1..=28 {
        let single = load(&folder.join(format!("{number:02}.dcm"))).unwrap().volume;
        let place = voxel_from_patient.transform_point3(single.patient_from_voxel().translation);
        assert!(place.x.abs() < 1e-6 && place.y.abs() < 1e-6, "slice {number}: {place}");
        let (lower, upper) = (place.z.floor(), place.z.ceil().min((depth - 1) as f64));
        let mut error = 0.0;
        for y in (0..512).step_by(7) {
            for x in (0..512).step_by(7) {
                let truth = single.value([x, y, 0]);
                let [a, b] = [lower, upper].map(|z| volume.value([x, y, z as usize]));
                error += (a + (b - a) * (place.z - lower) - truth).abs();
            }
        }
        // The grid is as fine as the finest gap: at a true place little is lost.
        assert!(error / (74.0 * 74.0) < 12.0, "slice {number}: mean error {}", error / (74.0 * 74.0));
    }
}

#[test]
fn every_transfer_syntax_gives_the_same_samples() {
    let Some(folder) = shared("syntaxes") else { return };
    let truth = load(&folder.join("1.nii")).unwrap().volume;
    for number in 1..=9 {
        let volume = load(&folder.join(format!("{number}.dcm"))).unwrap().volume;
        // The image is a mosaic of 6 x 6 tiles, of which 35 are slices.
        assert_eq!(volume.dims(), [64, 64, 35], "{number}.dcm");
        let sum: f64 = (0..35).map(|z| slice_sum(&volume, z).0).sum();
        assert_eq!((sum, volume.value_range()), (38036663.0, [0.0, 2362.0]), "{number}.dcm");
        // The converter that made the truth flipped the rows.
        for z in 0..35 {
            for y in 0..64 {
                for x in 0..64 {
                    let (value, expected) = (volume.value([x, y, z]), truth.value([x, 63 - y, z]));
                    assert_eq!(value, expected, "{number}.dcm at {x}, {y}, {z}");
                }
            }
        }
        // Each voxel lies where it does in the truth.
        for at in [[0, 0, 0], [63, 0, 0], [0, 63, 0], [0, 0, 34], [20, 40, 17]] {
            let [x, y, z] = at.map(|n| n as f64);
            let place = volume.patient_from_voxel().transform_point3(DVec3::new(x, y, z));
            let expected = truth.patient_from_voxel().transform_point3(DVec3::new(x, 63.0 - y, z));
            assert_near(place, expected, 2e-3);
        }
    }
}

#[test]
fn missing_slices_are_noted_and_filled() {
    let Some(folder) = unzip("mr_missing_slices.zip") else { return };
    let best = load(folder.path()).unwrap();
    println!("{:#?}", best.report.series);
    assert_eq!(best.report.series.len(), 4);
    assert_eq!(best.report.skipped.iter().filter(|s| s.reason == "it is not a DICOM file").count(), 3);
    for series in &best.report.series {
        let imported = load_series(folder.path(), Some(&series.id)).unwrap();
        println!("{} -> {:?} {:?}", series.description, imported.volume.dims(), imported.report.notes);
        let [columns, rows, depth] = imported.volume.dims();
        match (columns, rows) {
            (192, 192) if series.files == 175 => {
                assert_eq!(depth, 176);
                assert!(imported.report.notes[0].contains("1 of 176 slices is missing"));
            }
            (512, 384) => {
                assert_eq!(depth, 56);
                assert_near(imported.volume.spacing_mm(), DVec3::new(0.43, 0.43, 2.5), 0.01);
            }
            _ => {}
        }
    }
}

#[test]
fn a_series_is_chosen_by_its_place_in_the_list() {
    let Some(folder) = shared("enhanced") else { return };
    let listed = load(&folder).unwrap().report.series;
    // The number of another series is 5 here, and of two is 6.
    for place in 1..=listed.len() {
        let report = load_series(&folder, Some(&place.to_string())).unwrap().report;
        assert_eq!(report.chosen + 1, place);
        assert_eq!(report.series[report.chosen].description, listed[place - 1].description);
    }
}

#[test]
fn a_mixed_folder_yields_its_volumes_only() {
    let Some(folder) = unzip("ct_mixed_folder.zip") else { return };
    let imported = load(folder.path()).unwrap();
    println!("{:#?}", imported.report);
    let numbers: Vec<_> = imported.report.series.iter().map(|series| series.number).collect();
    assert_eq!(numbers[..2], [Some(301), Some(201)]);
    assert_eq!(imported.volume.dims(), [512, 512, 58]);
    let reasons: Vec<_> = imported.report.skipped.iter().map(|skipped| skipped.reason.as_str()).collect();
    let localizer = imported.report.series.iter().position(|series| series.reason == "a localizer");
    assert!(localizer.is_some_and(|place| place >= 2), "{:?}", imported.report.series);
    assert!(reasons.iter().any(|reason| reason.contains("colour")));
    let other = load_series(folder.path(), Some("201")).unwrap();
    assert_eq!(other.volume.dims(), [512, 512, 54]);
    for (volume, tilt, spacing) in [(&imported.volume, 16.5, None), (&other.volume, 18.5, Some(2.371))] {
        let [row, column, step] = [0, 1, 2].map(|k| volume.patient_from_voxel().matrix3.col(k));
        let normal = row.cross(column).normalize();
        assert!((step.angle_between(normal).to_degrees() - tilt).abs() < 0.1);
        if let Some(spacing) = spacing {
            assert!((step.dot(normal) - spacing).abs() < 0.002);
        }
    }
}

#[test]
fn fragmented_frames_are_joined() {
    let Some(folder) = shared("fragmented") else { return };
    let volume = load(&folder).unwrap().volume;
    assert_eq!(volume.dims(), [128, 128, 96]);
    assert_near(volume.spacing_mm(), DVec3::splat(2.0), 1e-3);
    let sum: f64 = (0..96).map(|z| slice_sum(&volume, z).0).sum();
    assert_eq!(sum, reference("fragmented/").values().map(|line| line.sum).sum::<f64>());
}

#[test]
fn enhanced_files_are_stacked_by_their_functional_groups() {
    let Some(folder) = shared("enhanced") else { return };
    for line in reference("enhanced/").values().filter(|line| !line.path.ends_with(".gz")) {
        let path = folder.join("..").join(&line.path);
        let result = load(&path);
        if line.status != "ok" {
            let error = result.unwrap_err().to_string();
            assert!(error.contains("no image"), "{error}");
            continue;
        }
        let imported = result.unwrap();
        let volume = &imported.volume;
        println!("{} {:?} {:?} {:?}", line.path, volume.dims(), volume.spacing_mm(), imported.report);
        assert_eq!(volume.dims()[..2], [line.columns, line.rows], "{}", line.path);
        assert!(volume.dims()[2] > 1, "{}", line.path);
        // Junk high bits would show here; the reference leaves the frames' own rescale out.
        if volume.dims()[2] == line.frames && matches!(volume.voxels(), Voxels::U16(_)) {
            let sum: f64 = (0..line.frames).map(|z| slice_sum(volume, z).0).sum();
            let n = volume.voxel_count() as f64;
            assert!(
                ((sum - n * volume.intercept()) / volume.slope() - line.sum).abs() < 1.0,
                "{}",
                line.path
            );
        }
    }
}

/// Small odd files: each is read as by another reader, or refused in words.
#[test]
fn odd_files_are_read_or_refused() {
    let Some(folder) = shared("pydicom_files") else { return };
    let lines = reference("pydicom_files/");
    for path in files_in(&folder) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let line = &lines[&format!("pydicom_files/{name}")];
        match load(&path) {
            Ok(imported) => {
                let volume = &imported.volume;
                let sum: f64 = (0..volume.dims()[2]).map(|z| slice_sum(volume, z).0).sum();
                println!(
                    "{name}: {:?}, sum {sum} for {}, {:?}",
                    volume.dims(),
                    line.sum,
                    imported.report.notes
                );
                // The reference gives up on 12 bits where it is not told that there are so many.
                if name == "JPEG-lossy.dcm" {
                    assert_eq!((volume.dims(), volume.value_range()), ([256, 1024, 1], [0.0, 264.0]));
                    continue;
                }
                assert_eq!(line.status.split(':').next(), Some("ok"), "{name}");
                assert_eq!(volume.dims(), [line.columns, line.rows, line.frames], "{name}");
                // The reference knows nothing of DoseGridScaling.
                let (scale, error) = if name.starts_with("rtdose") { (1e-6, 1e-6) } else { (1.0, 0.0) };
                let error = if name == "JPGExtended.dcm" { 2e-3 } else { error };
                // The reference keeps fill values: the corners around this round field, -2000 for -1000 here.
                let replaced = if name == "J2K_pixelrep_mismatch.dcm" { 56_252.0 * 1000.0 } else { 0.0 };
                // It keeps PixelPaddingValue as it is, too.
                if name != "693_J2KI.dcm" {
                    let expected = line.sum * scale + replaced;
                    assert!((sum - expected).abs() <= error * sum.abs(), "{name}: {sum} for {expected}");
                }
            }
            Err(error) => {
                println!("{name}: {error} ({})", line.status);
                // What another reader can read, Lumivox refuses for a reason of its own only.
                let why = ["colour"];
                let error = error.to_string();
                assert!(line.status != "ok" || why.iter().any(|why| error.contains(why)), "{error}");
            }
        }
    }
}

fn files_in(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Whatever happens to a codestream, its decoder gives samples or an error: no panic, no crash, no great delay.
#[test]
fn damaged_codestreams_are_survived() {
    let Some(folder) = shared("syntaxes") else { return };
    let mutations = std::env::var("LUMIVOX_MUTATIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(30);
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("damaged.dcm");
    let mut state = 1u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    for number in 4..=9 {
        let whole = std::fs::read(folder.join(format!("{number}.dcm"))).unwrap();
        let pixels = whole.windows(4).rposition(|tag| tag == [0xE0, 0x7F, 0x10, 0x00]).unwrap();
        for round in 0..mutations {
            let mut bytes = whole.clone();
            // Heads of codestreams are where damage hurts most.
            let reach = if round % 2 == 0 { 200 } else { bytes.len() - pixels };
            for _ in 0..=random(4) {
                let at = pixels + random(reach);
                bytes[at] = random(256) as u8;
            }
            if round % 5 == 0 {
                bytes.truncate(pixels + random(bytes.len() - pixels));
            }
            std::fs::write(&path, bytes).unwrap();
            let start = std::time::Instant::now();
            let _ = load(&path);
            assert!(start.elapsed().as_secs() < 5, "{number}.dcm, round {round}");
        }
    }
}

/// Who has no scans sees that, and no failure.
#[test]
fn absent_scans_are_said_once() {
    let output = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["dicom_real::", "--skip", "absent_scans_are_said_once"])
        .env(crate::common::SHARED, "/nonexistent")
        .output()
        .unwrap();
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{stdout}");
    assert_eq!(stderr.matches("real scans are absent (/nonexistent").count(), 1, "{stderr}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
}
