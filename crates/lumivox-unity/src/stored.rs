//! A scan as a file that opens at once: what an editor keeps of an import, and a game is shipped with.
//!
//! Layout, little-endian: `LUMIVOX1`, the length of the header as u64, the header as JSON, zeros up to a multiple of 16,
//! then the voxels as they lie in memory, x fastest. Nothing follows them.

use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::Path;

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{CancelToken, Label, LabelVolume, Modality, Progress, Stage, Volume, Voxels};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::border::Outcome;
use crate::volume::{LumivoxVolume, voxels_from_bytes};

const MAGIC: &[u8; 8] = b"LUMIVOX1";

/// Longer headers are damaged.
const MAX_HEADER: u64 = 16 << 20;

/// Bytes between two looks at whether to stop.
const PIECE: usize = 8 << 20;

/// All but the voxels. Numbers that must come back to the last bit are written as their bits.
#[derive(Serialize, Deserialize)]
struct Header {
    dims: [usize; 3],
    bytes_per_voxel: u32,
    rescale: [u64; 2],
    patient_from_voxel: [u64; 12],
    modality: String,
    unit: String,
    #[serde(default)]
    report: Value,
    /// Of a label map: what its values mean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    labels: Option<Vec<StoredLabel>>,
}

#[derive(Serialize, Deserialize)]
struct StoredLabel {
    value: u8,
    name: String,
    /// Linear RGB.
    color: [u64; 3],
}

/// Writes a scan, whole or not at all.
pub fn save(scan: &LumivoxVolume, path: &Path, progress: Progress<'_>, cancel: &CancelToken) -> Outcome<()> {
    let failed = |error: std::io::Error| format!("cannot write {}: {error}", path.display());
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new()
        .prefix(".lumivox")
        .tempfile_in(folder)
        .map_err(|error| format!("cannot write in {}: {error}", folder.display()))?;
    let volume = scan.volume();
    let header = serde_json::to_vec(&header(scan)).map_err(|error| error.to_string())?;
    file.write_all(MAGIC).map_err(failed)?;
    file.write_all(&(header.len() as u64).to_le_bytes()).map_err(failed)?;
    file.write_all(&header).map_err(failed)?;
    file.write_all(&[0; 16][..padding(header.len())]).map_err(failed)?;
    let bytes = volume.voxels().as_bytes();
    for (i, piece) in bytes.chunks(PIECE).enumerate() {
        cancel.check().map_err(|error| error.to_string())?;
        progress.report(Stage::Writing, (i * PIECE) as u64, bytes.len() as u64);
        file.write_all(piece).map_err(failed)?;
    }
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// Reads the scan of a file.
pub fn open(path: &Path, progress: Progress<'_>, cancel: &CancelToken) -> Outcome<LumivoxVolume> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|error| format!("cannot read {name}: {error}"))?;
    let length = file.metadata().map_err(|error| format!("cannot read {name}: {error}"))?.len();
    read(BufReader::new(file), length, &name, progress, cancel)
}

/// Reads the scan of `length` bytes from what is called `name`.
pub fn read(
    mut from: impl Read,
    length: u64,
    name: &str,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Outcome<LumivoxVolume> {
    let damaged = |why: &str| {
        format!("{name} is not a scan that Lumivox has stored, or damaged: {why}. Import the scan anew")
    };
    let cut = |_| damaged("it ends too soon");
    let mut start = [0; 16];
    from.read_exact(&mut start).map_err(cut)?;
    if start[..8] != MAGIC[..] {
        return Err(damaged("it begins otherwise"));
    }
    let header_length = start[8..].first_chunk().map_or(u64::MAX, |length| u64::from_le_bytes(*length));
    if header_length > MAX_HEADER.min(length) {
        return Err(damaged("its header is longer than can be"));
    }
    let mut header = vec![0; header_length as usize];
    from.read_exact(&mut header).map_err(cut)?;
    let skipped = padding(header.len());
    from.read_exact(&mut start[..skipped]).map_err(cut)?;
    let header: Header = serde_json::from_slice(&header).map_err(|error| damaged(&error.to_string()))?;
    let voxels = header
        .dims
        .iter()
        .try_fold(u64::from(header.bytes_per_voxel), |product, &n| product.checked_mul(n as u64));
    let rest = length - (16 + header_length + skipped as u64).min(length);
    if voxels != Some(rest) {
        return Err(damaged("it is longer or shorter than its header says"));
    }
    let mut bytes = vec![0; rest as usize];
    for (i, piece) in bytes.chunks_mut(PIECE).enumerate() {
        cancel.check().map_err(|error| error.to_string())?;
        progress.report(Stage::Decoding, (i * PIECE) as u64, rest);
        from.read_exact(piece).map_err(cut)?;
    }
    let voxels = match header.bytes_per_voxel {
        1 => Voxels::U8(bytes),
        _ => voxels_from_bytes(header.bytes_per_voxel, &bytes).map_err(|why| damaged(&why))?,
    };
    let place = header.patient_from_voxel.map(f64::from_bits);
    let column = |i: usize| DVec3::new(place[3 * i], place[3 * i + 1], place[3 * i + 2]);
    let axes = DMat3::from_cols(column(0), column(1), column(2));
    let modality = match header.modality.as_str() {
        "CT" => Modality::Ct,
        "MR" => Modality::Mr,
        "PET" => Modality::Pet,
        _ => Modality::Other,
    };
    let place = DAffine3::from_mat3_translation(axes, column(3));
    if let (Some(labels), Voxels::U8(_)) = (&header.labels, &voxels) {
        let label = |stored: &StoredLabel| Label {
            value: stored.value,
            name: stored.name.clone(),
            color: stored.color.map(f64::from_bits),
        };
        let named = labels.iter().map(label).collect();
        let Voxels::U8(voxels) = voxels else { unreachable!("they are bytes") };
        let labels = LabelVolume::new(header.dims, voxels, place, named)
            .map_err(|error| damaged(&error.to_string()))?;
        return Ok(LumivoxVolume::of_labels(labels, header.report));
    }
    let volume = Volume::new(header.dims, voxels, header.rescale.map(f64::from_bits), place, modality)
        .map_err(|error| damaged(&error.to_string()))?;
    Ok(LumivoxVolume::new(volume.with_unit(header.unit), header.report))
}

fn header(scan: &LumivoxVolume) -> Header {
    let volume = scan.volume();
    let place = volume.patient_from_voxel();
    let mut numbers = [0; 12];
    let all = place.matrix3.to_cols_array().into_iter().chain(place.translation.to_array());
    numbers.iter_mut().zip(all).for_each(|(to, number)| *to = number.to_bits());
    Header {
        dims: volume.dims(),
        bytes_per_voxel: volume.voxels().bytes_per_sample() as u32,
        rescale: [volume.slope().to_bits(), volume.intercept().to_bits()],
        patient_from_voxel: numbers,
        modality: match volume.modality() {
            Modality::Ct => "CT",
            Modality::Mr => "MR",
            Modality::Pet => "PET",
            Modality::Other => "",
        }
        .to_owned(),
        unit: volume.unit().to_owned(),
        report: scan.report().clone(),
        labels: scan.labels().map(|labels| {
            let stored = |label: &Label| StoredLabel {
                value: label.value,
                name: label.name.clone(),
                color: label.color.map(f64::to_bits),
            };
            labels.map.labels().iter().map(stored).collect()
        }),
    }
}

/// Zeros behind a header.
fn padding(header_length: usize) -> usize {
    header_length.next_multiple_of(16) - header_length
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan() -> LumivoxVolume {
        let axes = DMat3::from_cols(DVec3::X * 0.1, DVec3::Y / 3.0, DVec3::Z * 1.7);
        let place = DAffine3::from_mat3_translation(axes, DVec3::new(0.3, -1e-7, 1e9));
        let voxels = Voxels::U16((0..24).map(|i| i * 1000).collect());
        let volume = Volume::new([2, 3, 4], voxels, [0.1, -1024.7], place, Modality::Ct).unwrap();
        LumivoxVolume::new(volume.with_unit("HU"), serde_json::json!({"notes": ["\u{b5}"]}))
    }

    fn stored() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.lumivox");
        save(&scan(), &path, Progress::SILENT, &CancelToken::new()).unwrap();
        std::fs::read(path).unwrap()
    }

    fn read_bytes(bytes: &[u8]) -> Outcome<LumivoxVolume> {
        read(bytes, bytes.len() as u64, "a.lumivox", Progress::SILENT, &CancelToken::new())
    }

    #[test]
    fn a_scan_comes_back_to_the_last_bit() {
        let (before, after) = (scan(), read_bytes(&stored()).unwrap());
        let (a, b) = (before.volume(), after.volume());
        assert_eq!(a.dims(), b.dims());
        assert_eq!(a.voxels().as_bytes(), b.voxels().as_bytes());
        assert_eq!(a.patient_from_voxel(), b.patient_from_voxel());
        assert_eq!((a.slope(), a.intercept(), a.unit()), (b.slope(), b.intercept(), b.unit()));
        assert_eq!(a.modality(), b.modality());
        assert_eq!(before.report(), after.report());
    }

    #[test]
    fn damage_is_told_and_never_worse() {
        let whole = stored();
        for end in 0..whole.len() {
            let error = read_bytes(&whole[..end]).err().unwrap_or_else(|| panic!("{end} bytes were a scan"));
            assert!(error.starts_with("a.lumivox is not a scan"), "{error}");
        }
        for at in 0..whole.len() - 48 {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x55;
            if let Err(error) = read_bytes(&bytes) {
                assert!(error.contains("Import the scan anew"), "{error}");
            }
        }
        let mut longer = whole;
        longer.push(0);
        assert!(read_bytes(&longer).is_err());
    }

    #[test]
    fn a_file_that_cannot_be_written_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("no").join("a.lumivox");
        let error = save(&scan(), &path, Progress::SILENT, &CancelToken::new()).unwrap_err();
        assert!(error.starts_with("cannot write in "), "{error}");
        let cancelled = CancelToken::new();
        cancelled.cancel();
        let path = folder.path().join("a.lumivox");
        assert!(save(&scan(), &path, Progress::SILENT, &cancelled).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
