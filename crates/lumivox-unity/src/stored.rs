//! A scan as a file that opens at once: what an editor keeps of an import, and a game is shipped with.
//!
//! Layout, little-endian: `LUMIVOX1`, the length of the header as u64, the header as JSON, zeros up to a multiple of 16,
//! then the voxels as they lie in memory, x fastest. Where something was taken out of the scan, what that was follows: the
//! first voxel and the length of each run, as u64, then the samples of all runs as they lie in memory. Nothing follows.

use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};

use lumivox_core::document::Scan;
use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::labels::{CutAway, LabelSource};
use lumivox_core::{CancelToken, Label, LabelVolume, Modality, Progress, Volume, Voxels, WorkStage};
use lumivox_segmentation::Surroundings;
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
    /// Of what was taken out of the scan; files of before it was kept say nothing of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    surroundings: Option<StoredRuns>,
    /// The files that it was read from, as scene documents say it; files of before it was kept say nothing of it.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    source: Value,
    /// The same of a label map.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    label_source: Value,
    /// Of a label map: what lassos cut away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cut_away: Option<CutAway>,
}

/// A map's files, and the numbers that its labels have in them.
#[derive(Serialize, Deserialize)]
struct StoredLabelSource {
    files: Vec<PathBuf>,
    table: Option<PathBuf>,
    /// As text: JSON's numbers are smaller.
    numbers: Vec<(String, u8)>,
}

impl StoredLabelSource {
    fn of(source: &LabelSource) -> Self {
        Self {
            files: source.files.clone(),
            table: source.table.clone(),
            numbers: source.numbers.iter().map(|(number, value)| (number.to_string(), *value)).collect(),
        }
    }

    fn source(self) -> Option<LabelSource> {
        let number = |(number, value): (String, u8)| Some((number.parse().ok()?, value));
        let numbers = self.numbers.into_iter().map(number).collect::<Option<_>>()?;
        Some(LabelSource { files: self.files, table: self.table, numbers })
    }
}

/// How much was taken out.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct StoredRuns {
    runs: u64,
    samples: u64,
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
    let around = scan.surroundings();
    let runs: Vec<u8> = around.map_or(vec![], |around| {
        let numbers = around.runs().as_flattened().iter();
        numbers.flat_map(|&number| (number as u64).to_le_bytes()).collect()
    });
    let taken = around.map_or(&[][..], |around| around.samples().as_bytes());
    let parts = [volume.voxels().as_bytes(), &runs, taken];
    let (mut done, total) = (0, parts.iter().map(|part| part.len() as u64).sum());
    for piece in parts.iter().flat_map(|part| part.chunks(PIECE)) {
        cancel.check().map_err(|error| error.to_string())?;
        progress.report(WorkStage::Writing, done, total);
        file.write_all(piece).map_err(failed)?;
        done += piece.len() as u64;
    }
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// Copies a stored scan without what tells where it was read from: for whom a game is given to.
pub fn copy_nameless(from: &Path, to: &Path) -> Outcome<()> {
    let unread = |error: std::io::Error| format!("cannot read {}: {error}", from.display());
    let unwritten = |error: std::io::Error| format!("cannot write {}: {error}", to.display());
    let mut file = BufReader::new(File::open(from).map_err(unread)?);
    let damaged = || format!("{} is not a scan that Lumivox has stored, or damaged", from.display());
    let mut start = [0; 16];
    file.read_exact(&mut start).map_err(|_| damaged())?;
    let length = start[8..].first_chunk().map_or(u64::MAX, |length| u64::from_le_bytes(*length));
    if start[..8] != MAGIC[..] || length > MAX_HEADER {
        return Err(damaged());
    }
    let mut header = vec![0; length as usize + padding(length as usize)];
    file.read_exact(&mut header).map_err(|_| damaged())?;
    let mut header: serde_json::Map<String, Value> =
        serde_json::from_slice(&header[..length as usize]).map_err(|_| damaged())?;
    header.remove("source");
    header.remove("label_source");
    let header = serde_json::to_vec(&header).map_err(|error| error.to_string())?;
    let mut copy = File::create(to).map_err(unwritten)?;
    copy.write_all(MAGIC).map_err(unwritten)?;
    copy.write_all(&(header.len() as u64).to_le_bytes()).map_err(unwritten)?;
    copy.write_all(&header).map_err(unwritten)?;
    copy.write_all(&[0; 16][..padding(header.len())]).map_err(unwritten)?;
    std::io::copy(&mut file, &mut copy).map_err(unwritten)?;
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
    let rest = length - (16 + header_length + skipped as u64).min(length);
    let parts = header
        .parts()
        .filter(|parts| parts.iter().try_fold(0u64, |all, &n| all.checked_add(n)) == Some(rest));
    let Some(parts) = parts else {
        return Err(damaged("it is longer or shorter than its header says"));
    };
    let mut done = 0;
    let mut take = |length: u64| -> Outcome<Vec<u8>> {
        let mut bytes = vec![0; length as usize];
        for piece in bytes.chunks_mut(PIECE) {
            cancel.check().map_err(|error| error.to_string())?;
            progress.report(WorkStage::Decoding, done, rest);
            from.read_exact(piece).map_err(cut)?;
            done += piece.len() as u64;
        }
        Ok(bytes)
    };
    let [voxels, runs, taken] = [take(parts[0])?, take(parts[1])?, take(parts[2])?];
    let samples = |bytes: Vec<u8>| match header.bytes_per_voxel {
        1 => Ok(Voxels::U8(bytes)),
        _ => voxels_from_bytes(header.bytes_per_voxel, &bytes).map_err(|why| damaged(&why)),
    };
    let voxels = samples(voxels)?;
    let around = match header.surroundings {
        Some(_) => {
            let all = Surroundings::from_parts(runs_of(&runs), samples(taken)?);
            Some(all.map_err(|error| damaged(&error.to_string()))?)
        }
        None => None,
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
        let mut labels = LabelVolume::new(header.dims, voxels, place, named)
            .map_err(|error| damaged(&error.to_string()))?;
        let source = serde_json::from_value(header.label_source).ok();
        if let Some(source) = source.and_then(StoredLabelSource::source) {
            labels = labels.with_source(source);
        }
        if let Some(cut) = header.cut_away {
            labels = labels.with_cut(cut);
        }
        return Ok(LumivoxVolume::of_labels(labels, header.report));
    }
    let mut volume = Volume::new(header.dims, voxels, header.rescale.map(f64::from_bits), place, modality)
        .map_err(|error| damaged(&error.to_string()))?;
    // What a later version says of it beyond what is known here is no reason not to show it.
    if let Ok(source) = serde_json::from_value::<Scan>(header.source) {
        volume = volume.with_source(source);
    }
    if around.as_ref().is_some_and(|around| !around.fits(&volume)) {
        return Err(damaged("what was taken out of it is of another scan"));
    }
    Ok(LumivoxVolume::with_surroundings(volume.with_unit(header.unit), around, header.report))
}

impl Header {
    /// Bytes of the voxels, of the runs that were taken out, and of their samples; `None` where nobody can count so far.
    fn parts(&self) -> Option<[u64; 3]> {
        let bytes = u64::from(self.bytes_per_voxel);
        let voxels = self.dims.iter().try_fold(bytes, |product, &n| product.checked_mul(n as u64))?;
        let StoredRuns { runs, samples } = self.surroundings.unwrap_or(StoredRuns { runs: 0, samples: 0 });
        Some([voxels, runs.checked_mul(RUN as u64)?, samples.checked_mul(bytes)?])
    }
}

/// Bytes of a run.
const RUN: usize = 16;

fn runs_of(bytes: &[u8]) -> Vec<[usize; 2]> {
    let number = |bytes: [u8; 8]| u64::from_le_bytes(bytes) as usize;
    let numbers: Vec<usize> = bytes.as_chunks().0.iter().copied().map(number).collect();
    numbers.as_chunks().0.to_vec()
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
        surroundings: scan.surroundings().map(|around| StoredRuns {
            runs: around.runs().len() as u64,
            samples: around.voxel_count() as u64,
        }),
        // A path that is no Unicode cannot be written down: then it is as if nobody knew.
        source: volume.source().and_then(|source| serde_json::to_value(source).ok()).unwrap_or_default(),
        label_source: scan
            .labels()
            .and_then(|labels| serde_json::to_value(StoredLabelSource::of(labels.map.source()?)).ok())
            .unwrap_or_default(),
        cut_away: scan.labels().and_then(|labels| labels.map.cut_away().cloned()),
    }
}

/// Zeros behind a header.
fn padding(header_length: usize) -> usize {
    header_length.next_multiple_of(16) - header_length
}

#[cfg(test)]
mod tests {
    use lumivox_core::Lasso;

    use super::*;

    fn scan() -> LumivoxVolume {
        let axes = DMat3::from_cols(DVec3::X * 0.1, DVec3::Y / 3.0, DVec3::Z * 1.7);
        let place = DAffine3::from_mat3_translation(axes, DVec3::new(0.3, -1e-7, 1e9));
        let voxels = Voxels::U16((0..24).map(|i| i * 1000).collect());
        let volume = Volume::new([2, 3, 4], voxels, [0.1, -1024.7], place, Modality::Ct).unwrap();
        let around = Surroundings::from_parts(vec![[0, 2], [5, 1]], Voxels::U16(vec![7, 8, 9])).unwrap();
        let report = serde_json::json!({"notes": ["\u{b5}"]});
        let volume = volume.with_unit("HU").with_source(source());
        LumivoxVolume::with_surroundings(volume, Some(around), report)
    }

    fn source() -> Scan {
        Scan {
            series: Some("1.2.3".into()),
            phase: Some(2),
            content: Some("sha256:00".into()),
            leave_gaps: true,
            taken_off: Some(lumivox_core::document::TakenOff::Skin(3.3)),
            ..Scan::of_files(vec!["/scans/head".into()])
        }
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
        assert_eq!(before.surroundings(), after.surroundings());
        assert_eq!(b.source(), Some(&source()));
    }

    #[test]
    fn a_label_map_comes_back_with_its_files() {
        let label = Label { value: 3, name: "liver".into(), color: [0.1, 0.2, 0.3] };
        let source = LabelSource {
            files: vec!["/scans/liver.nii".into()],
            table: Some("/scans/names.txt".into()),
            numbers: vec![(i128::MAX, 3)],
        };
        let labels = LabelVolume::new([2, 1, 1], vec![0, 3], DAffine3::IDENTITY, vec![label]).unwrap();
        let lasso = Lasso::new(DAffine3::IDENTITY, true, vec![[0.0, 0.0], [1.0 / 3.0, 0.0], [0.0, 1.0]]);
        let cut = CutAway { lassos: vec![lasso], value: 3, before: None };
        let labels = labels.with_source(source.clone()).with_cut(cut.clone());
        let map = LumivoxVolume::of_labels(labels, Value::Null);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.lumivox");
        save(&map, &path, Progress::SILENT, &CancelToken::new()).unwrap();
        let again = read_bytes(&std::fs::read(path).unwrap()).unwrap();
        let again = &again.labels().unwrap().map;
        assert_eq!(again.source(), Some(&source));
        let back = again.cut_away().unwrap();
        assert_eq!((&back.lassos, back.value), (&cut.lassos, 3));
    }

    #[test]
    fn a_copy_for_others_tells_nothing_of_files() {
        let folder = tempfile::tempdir().unwrap();
        let [own, copy] = ["a.lumivox", "b.lumivox"].map(|name| folder.path().join(name));
        std::fs::write(&own, stored()).unwrap();
        copy_nameless(&own, &copy).unwrap();
        let bytes = std::fs::read(&copy).unwrap();
        assert!(!bytes.windows(6).any(|word| word == b"/scans"));
        let (before, after) = (scan(), read_bytes(&bytes).unwrap());
        assert_eq!(before.volume().voxels(), after.volume().voxels());
        assert_eq!(before.surroundings(), after.surroundings());
        assert_eq!(after.volume().source(), None);
        assert!(copy_nameless(&folder.path().join("none"), &copy).unwrap_err().starts_with("cannot read"));
    }

    #[test]
    fn files_of_before_surroundings_were_kept_are_scans() {
        let scan = scan();
        let older = (**scan.volume()).clone();
        let place = older.patient_from_voxel();
        let older = Volume::new(older.dims(), older.voxels().clone(), [0.1, -1024.7], place, Modality::Ct);
        let older = LumivoxVolume::new(older.unwrap(), scan.report().clone());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.lumivox");
        save(&older, &path, Progress::SILENT, &CancelToken::new()).unwrap();
        let bytes = std::fs::read(path).unwrap();
        assert!(!bytes.windows(12).any(|word| word == b"surroundings"));
        assert!(!bytes.windows(6).any(|word| word == b"source"));
        let again = read_bytes(&bytes).unwrap();
        assert_eq!(again.volume().voxels(), scan.volume().voxels());
        assert!(again.surroundings().is_none());
        assert_eq!(again.volume().source(), None);
    }

    #[test]
    fn surroundings_of_another_scan_are_damage() {
        let runs = |first: u64| {
            let mut bytes = stored();
            let at = bytes.len() - 38;
            bytes[at..at + 8].copy_from_slice(&first.to_le_bytes());
            read_bytes(&bytes).err().unwrap_or_default()
        };
        assert_eq!(runs(1), "");
        // Overlapping, beyond the scan, beyond all numbers.
        for first in [4, 5, 24, u64::MAX] {
            assert!(runs(first).contains("is of another scan"), "{first}: {}", runs(first));
        }
        let mut beyond = stored();
        let at = beyond.len() - 22;
        beyond[at..at + 8].copy_from_slice(&24u64.to_le_bytes());
        assert!(read_bytes(&beyond).err().unwrap().contains("is of another scan"));
    }

    #[test]
    fn damage_is_told_and_never_worse() {
        let whole = stored();
        for end in 0..whole.len() {
            let error = read_bytes(&whole[..end]).err().unwrap_or_else(|| panic!("{end} bytes were a scan"));
            assert!(error.starts_with("a.lumivox is not a scan"), "{error}");
        }
        for at in 0..whole.len() {
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
