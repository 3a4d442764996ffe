//! A large scan is loaded fast and in little memory. Alone in its program, so that the peak is its own.

mod common;

use std::{path::Path, time::Instant};

use lumivox_core::Volume;

#[test]
fn ct_torso_takes_little_more_memory_than_its_volume() {
    let Some(folder) = common::unzip("ct_torso.zip") else { return };
    let volume = measure(folder.path(), "folder");
    // A slice between the ends is lost: the volume is made anew on the even grid.
    let last = volume.dims()[2] as f64 - 1.0;
    let voxel_from_patient = volume.patient_from_voxel().inverse();
    drop(volume);
    let between = |path: &Path| {
        let place = common::load(path).ok()?.volume.patient_from_voxel().translation;
        let z = voxel_from_patient.transform_point3(place).z;
        (z > 0.5 && z < last - 0.5).then_some(())
    };
    let files: Vec<_> = std::fs::read_dir(folder.path().join("ct_torso")).unwrap().collect();
    let lost = files.iter().map(|file| file.as_ref().unwrap().path()).find(|path| between(path).is_some());
    std::fs::remove_file(lost.unwrap()).unwrap();
    assert_eq!(measure(folder.path(), "folder without a slice").dims()[2] as f64, last + 1.0);
    // Unpacked while it is read.
    measure(&common::shared("ct_torso.zip").unwrap(), "zip");
}

fn measure(path: &Path, what: &str) -> Volume {
    let start = Instant::now();
    let volume = common::load(path).unwrap().volume;
    let seconds = start.elapsed().as_secs_f64();
    let volume_mib = (volume.voxel_count() * volume.voxels().bytes_per_sample()) as f64 / 1048576.0;
    match peak_mib() {
        Some(peak) => {
            println!("{what}: {seconds:.2} s, volume {volume_mib:.0} MiB, peak {peak:.0} MiB");
            assert!(peak < 2.5 * volume_mib, "peak {peak} MiB for a volume of {volume_mib} MiB");
        }
        None => println!("{what}: {seconds:.2} s, volume {volume_mib:.0} MiB"),
    }
    volume
}

/// The most memory that this program ever had, where the system tells.
fn peak_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}
