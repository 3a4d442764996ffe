//! Scans as files, for what imports them.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use lumivox_core::{CancelToken, Progress, Volume};
use lumivox_phantom::{AnatomyOptions, SeriesDescription, TorsoOptions, anatomy};

/// The anatomical CT of a head, with `size` voxels along a side.
pub fn head(size: usize) -> Volume {
    grown("head", size, || {
        let options = AnatomyOptions { size, ..AnatomyOptions::default() };
        anatomy(options, Progress::SILENT, &CancelToken::new()).unwrap()
    })
}

/// The CT of a torso on its table, with `size` voxels along a side.
pub fn torso(size: usize) -> Volume {
    grown("torso", size, || {
        let options = TorsoOptions { size, ..TorsoOptions::default() };
        lumivox_phantom::torso(options, Progress::SILENT, &CancelToken::new()).unwrap()
    })
}

/// What grows for seconds, for all tests once.
fn grown(kind: &'static str, size: usize, grow: impl FnOnce() -> Volume) -> Volume {
    static GROWN: Mutex<BTreeMap<(&str, usize), Volume>> = Mutex::new(BTreeMap::new());
    let mut known = GROWN.lock().unwrap_or_else(PoisonError::into_inner);
    known.entry((kind, size)).or_insert_with(grow).clone()
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

/// A header of NIfTI-1 for 16-bit samples that count twice, less 10; spacing in millimetres.
pub fn nifti_header(dims: [usize; 3], spacing: [f32; 3]) -> Vec<u8> {
    let mut header = vec![0u8; 352];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348i32.to_le_bytes());
    for (i, n) in [3, dims[0] as i16, dims[1] as i16, dims[2] as i16, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &n.to_le_bytes());
    }
    put(70, &4i16.to_le_bytes());
    put(72, &16i16.to_le_bytes());
    for (i, mm) in [1.0, spacing[0], spacing[1], spacing[2]].into_iter().enumerate() {
        put(76 + 4 * i, &mm.to_le_bytes());
    }
    put(108, &352f32.to_le_bytes());
    put(112, &2f32.to_le_bytes());
    put(116, &(-10f32).to_le_bytes());
    // Millimetres; a placement by quaternion.
    put(123, &[2]);
    put(252, &1i16.to_le_bytes());
    put(344, b"n+1\0");
    header
}
