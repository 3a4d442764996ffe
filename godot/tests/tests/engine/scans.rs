//! Scans as files, for what imports them.

use std::path::Path;

use lumivox_core::{CancelToken, Progress, Volume};
use lumivox_phantom::{AnatomyOptions, SeriesDescription, TorsoOptions, anatomy};

/// The anatomical CT of a head, with `size` voxels along a side.
pub fn head(size: usize) -> Volume {
    let options = AnatomyOptions { size, ..AnatomyOptions::default() };
    anatomy(options, Progress::SILENT, &CancelToken::new()).unwrap()
}

/// The CT of a torso on its table, with `size` voxels along a side.
pub fn torso(size: usize) -> Volume {
    let options = TorsoOptions { size, ..TorsoOptions::default() };
    lumivox_phantom::torso(options, Progress::SILENT, &CancelToken::new()).unwrap()
}

/// Writes a volume as a series of DICOM files into a folder, which is made for it.
pub fn write_series(volume: &Volume, folder: &Path) {
    write_described_series(volume, folder, &SeriesDescription::default());
}

/// The same as the series of that number; series of one study differ in it.
pub fn write_series_number(volume: &Volume, folder: &Path, number: u32) {
    let description =
        SeriesDescription { series_number: number, seed: number.into(), ..SeriesDescription::default() };
    write_described_series(volume, folder, &description);
}

fn write_described_series(volume: &Volume, folder: &Path, description: &SeriesDescription) {
    lumivox_phantom::write_dicom_series(volume, folder, description, Progress::SILENT, &CancelToken::new())
        .unwrap();
}
