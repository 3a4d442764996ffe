//! Scans that a host has in memory already, such as another library's images: on the way that a file's samples take, with
//! the same repairs in the same words.

use std::path::PathBuf;

use lumivox_core::{Modality, glam::DAffine3};

use crate::{
    Imported,
    error::ImportError,
    payload::{Payload, too_many_voxels},
    sample::{SampleType, VoxelBuilder},
    single::Single,
    values::Told,
};

/// Samples, and what is known of them.
#[derive(Clone, Copy, Debug)]
pub struct MemoryScan<'a> {
    /// What errors call it where files have their names: `the nibabel image`.
    pub name: &'a str,
    /// What had it, as [`ImportReport::format`](crate::ImportReport::format) names formats: `nibabel`.
    pub format: &'static str,
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// The type of one sample.
    pub sample: SampleType,
    /// Whether the first byte of a sample is its most significant.
    pub big_endian: bool,
    /// The samples, x fastest.
    pub bytes: &'a [u8],
    /// Slope and intercept: `value = sample * slope + intercept`.
    pub rescale: [f64; 2],
    /// LPS millimetres from voxel indices.
    pub patient_from_voxel: DAffine3,
    /// What it is, where that is known; else it is guessed as that of a file.
    pub modality: Option<Modality>,
}

/// A scan of samples in memory.
#[derive(Debug)]
pub struct MemoryImport {
    /// The scan, and how it was taken.
    pub imported: Imported,
    /// What was wrong with samples, and was mended.
    pub repairs: Vec<String>,
}

/// Makes a scan of samples in memory. Not a byte is changed of those; what is no number in them is mended as a file's is.
///
/// # Errors
/// [`ImportError`], as of a file: for sizes and spacings that nothing has, and where not one sample is a number.
pub fn load_memory(scan: &MemoryScan<'_>) -> Result<MemoryImport, ImportError> {
    let path = PathBuf::from(scan.name);
    // That there are none is said by the volume, not by what looks for numbers.
    let sample = if scan.bytes.is_empty() { SampleType::U8 } else { scan.sample };
    let voxels = scan.bytes.len() / sample.bytes();
    let mut builder =
        VoxelBuilder::new(sample, scan.big_endian, voxels).map_err(|_| too_many_voxels(&path, scan.dims))?;
    builder.push(scan.bytes);
    let single = Single {
        payload: Payload::in_file(&path, scan.sample, scan.big_endian, 0).into(),
        path,
        format: scan.format,
        dims: scan.dims,
        phases: 1,
        rescale: scan.rescale,
        patient_from_voxel: scan.patient_from_voxel,
        modality: scan.modality,
        notes: vec![],
    };
    let decoded = builder.finish().ok_or_else(|| single.no_number())?;
    let repairs = decoded.notes.clone();
    let imported = single.finish(decoded, &Told::default(), vec![])?;
    Ok(MemoryImport { imported, repairs })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(bytes: &[u8], sample: SampleType) -> MemoryScan<'_> {
        MemoryScan {
            name: "the array",
            format: "array",
            dims: [bytes.len() / sample.bytes(), 1, 1],
            sample,
            big_endian: false,
            bytes,
            rescale: [2.0, 1.0],
            patient_from_voxel: DAffine3::IDENTITY,
            modality: None,
        }
    }

    #[test]
    fn samples_in_memory_are_mended_and_told_as_a_files_are() {
        let bytes: Vec<u8> = [0.5f32, f32::NAN, 2.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let made = load_memory(&scan(&bytes, SampleType::F32)).unwrap();
        assert_eq!(made.imported.volume.value_range(), [2.0, 5.0]);
        assert!(made.repairs[0].starts_with("1 of 3 samples are NaN"), "{:?}", made.repairs);
        assert!(made.imported.report.notes.contains(&made.repairs[0]));
        assert_eq!(made.imported.report.format, "array");
    }

    #[test]
    fn what_is_no_scan_is_named() {
        let bytes: Vec<u8> = [f64::NAN; 2].iter().flat_map(|v| v.to_le_bytes()).collect();
        let error = load_memory(&scan(&bytes, SampleType::F64)).unwrap_err().to_string();
        assert!(error.starts_with("the array: the image data holds not one finite number"), "{error}");
        let far = MemoryScan { dims: [9, 9, 9], ..scan(&[1, 2], SampleType::U8) };
        assert!(load_memory(&far).is_err());
    }
}
