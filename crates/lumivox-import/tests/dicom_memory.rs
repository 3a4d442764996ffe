//! A large scan is loaded fast and in little memory. Alone in its program, so that the peak is its own.

mod common;

use std::time::Instant;

#[test]
fn ct_torso_takes_little_more_memory_than_its_volume() {
    let Some(folder) = common::unzip("ct_torso.zip") else { return };
    // Zipped it takes longer, and may be no reason for more memory; unless asked for, the folder is what is measured.
    let zipped = std::env::var_os("LUMIVOX_ZIPPED").and_then(|_| common::shared("ct_torso.zip"));
    let path = zipped.as_deref().unwrap_or(folder.path());
    let start = Instant::now();
    let imported = common::load(path).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let volume_mib =
        (imported.volume.voxel_count() * imported.volume.voxels().bytes_per_sample()) as f64 / 1048576.0;
    match peak_mib() {
        Some(peak) => {
            println!("{seconds:.2} s, volume {volume_mib:.0} MiB, peak {peak:.0} MiB");
            assert!(peak < 2.5 * volume_mib, "peak {peak} MiB for a volume of {volume_mib} MiB");
        }
        None => println!("{seconds:.2} s, volume {volume_mib:.0} MiB"),
    }
}

/// The most memory that this program ever had, where the system tells.
fn peak_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}
