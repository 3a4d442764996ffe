//! Scans behind handles.

use std::ffi::{c_char, c_void};
use std::sync::{Arc, OnceLock};

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{
    CancelToken, Histogram, LabelVolume, Medium, Modality, Preset, Progress, Volume, Voxels, placement,
};
use lumivox_import::ImportReport;
use lumivox_phantom::{AnatomyOptions, TorsoOptions};
use lumivox_segmentation::Surroundings;
use serde_json::{Value, json};

use crate::abi::LumivoxVolumeInfo;
use crate::border::{
    LumivoxText, Outcome, free, guard, guard_handle, guard_status, known, known_mut, list, needed_text,
};
use crate::convert;

/// Most voxels along a side of a phantom.
const MAX_PHANTOM_SIZE: u32 = 1024;

/// A scan. Handles share it.
pub struct LumivoxVolume(Arc<Scan>);

/// A scan, and what is found out about it once.
struct Scan {
    volume: Arc<Volume>,
    /// What was taken out of it: the table, clothes, cables.
    surroundings: Option<Arc<Surroundings>>,
    /// What is kept of how it was read.
    report: Value,
    histogram: OnceLock<Histogram>,
    suited: OnceLock<Medium>,
    /// What its values mean, where it is a label map.
    labels: Option<Labels>,
    /// Depths below its skin, once they were looked for; none where no skin is there for sure.
    skin: OnceLock<Option<Arc<Volume>>>,
}

/// What the values of a label map mean, and how many voxels have each.
pub(crate) struct Labels {
    pub(crate) map: Arc<LabelVolume>,
    pub(crate) counts: [u64; 256],
}

impl LumivoxVolume {
    pub(crate) fn new(volume: Volume, report: Value) -> Self {
        Self::with_surroundings(volume, None, report)
    }

    /// One that something was taken out of.
    pub(crate) fn with_surroundings(
        volume: Volume,
        surroundings: Option<Surroundings>,
        report: Value,
    ) -> Self {
        Self::of(Arc::new(volume), surroundings.map(Arc::new), report, None)
    }

    /// A label map: a scan whose values are those of its labels.
    pub(crate) fn of_labels(labels: LabelVolume, report: Value) -> Self {
        Self::of_shared_labels(Arc::new(labels), report)
    }

    /// The same of one that others show, too.
    pub(crate) fn of_shared_labels(labels: Arc<LabelVolume>, report: Value) -> Self {
        // Counted here, on the job's thread: whoever asks later may not wait.
        let counts = labels.counts();
        let volume = labels.volume().clone();
        Self::of(volume, None, report, Some(Labels { map: labels, counts }))
    }

    fn of(
        volume: Arc<Volume>,
        surroundings: Option<Arc<Surroundings>>,
        report: Value,
        labels: Option<Labels>,
    ) -> Self {
        let (histogram, suited, skin) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Self(Arc::new(Scan { volume, surroundings, report, histogram, suited, labels, skin }))
    }

    /// A scan that was computed of another.
    pub(crate) fn of_another(volume: Arc<Volume>) -> Self {
        Self::of(volume, None, Value::Null, None)
    }

    pub(crate) fn volume(&self) -> &Arc<Volume> {
        &self.0.volume
    }

    pub(crate) fn surroundings(&self) -> Option<&Arc<Surroundings>> {
        self.0.surroundings.as_ref()
    }

    pub(crate) fn report(&self) -> &Value {
        &self.0.report
    }

    /// The look of the preset that suits it.
    pub(crate) fn suited(&self) -> &Medium {
        self.0.suited.get_or_init(|| Preset::default_for(self.volume()).medium(self.volume()))
    }

    /// What its values mean, where it is a label map.
    pub(crate) fn labels(&self) -> Option<&Labels> {
        self.0.labels.as_ref()
    }

    /// Depths below its skin; `None` before they were looked for, none where no skin is there for sure.
    pub(crate) fn skin(&self) -> Option<&Option<Arc<Volume>>> {
        self.0.skin.get()
    }

    /// Keeps what was looked for.
    pub(crate) fn keep_skin(&self, skin: Option<Arc<Volume>>) {
        // Two may have looked: they have found the same.
        let _ = self.0.skin.set(skin);
    }

    pub(crate) fn share(&self) -> Self {
        Self(self.0.clone())
    }
}

/// What of a report goes with a scan to wherever it is copied: neither what the files on this machine are called, nor
/// what names the patient's study, nor its other series.
pub(crate) fn kept(report: &ImportReport) -> Value {
    let mut series = serde_json::to_value(report.series.get(report.chosen)).unwrap_or_default();
    if let Some(series) = series.as_object_mut() {
        series.remove("id");
        series.remove("uid");
    }
    json!({ "format": report.format, "notes": report.notes, "series": series })
}

/// A phantom of a kind that has one.
pub(crate) fn phantom(
    kind: &str,
    size: u32,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Outcome<LumivoxVolume> {
    let size = match size {
        0 => 128,
        8..=MAX_PHANTOM_SIZE => size as usize,
        _ => return Err(format!("A phantom has 8 to {MAX_PHANTOM_SIZE} voxels along a side, not {size}.")),
    };
    let volume = match kind {
        "head" => {
            let options = AnatomyOptions { size, ..AnatomyOptions::default() };
            lumivox_phantom::anatomy(options, progress, cancel).map_err(|error| error.to_string())?
        }
        "torso" => {
            let options = TorsoOptions { size, table: false, ..TorsoOptions::default() };
            lumivox_phantom::torso(options, progress, cancel).map_err(|error| error.to_string())?
        }
        "cube" => lumivox_phantom::cube(size),
        _ => return Err(format!("There is no phantom '{kind}'. There are 'head', 'torso' and 'cube'.")),
    };
    Ok(LumivoxVolume::new(volume, Value::Null))
}

/// A scan that is computed, `head`, `torso` (without a table) or `cube`, with `size` voxels along a side, 8 to 1024; 0 stands for 128. Waits for it.
///
/// # Safety
/// `kind` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_phantom(kind: *const c_char, size: u32) -> *mut LumivoxVolume {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let kind = unsafe { needed_text(kind, "kind of phantom") }?;
        phantom(kind, size, Progress::SILENT, &CancelToken::new())
    })
}

/// A scan of voxels that are copied: `dimensions` along x (fastest), y and z, `bytes_per_voxel` 1 and 2 (unsigned) or 4
/// (float), value = stored * slope + intercept. `patient_from_voxel` holds three columns and an origin, in millimetres of
/// the patient (LPS); `modality` as in `LumivoxVolumeInfo`.
///
/// # Safety
/// `dimensions` points to 3 numbers, `voxels` to `length` bytes, `patient_from_voxel` to 12 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_new(
    dimensions: *const u32,
    bytes_per_voxel: u32,
    voxels: *const c_void,
    length: u64,
    slope: f64,
    intercept: f64,
    patient_from_voxel: *const f64,
    modality: u32,
) -> *mut LumivoxVolume {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let (dimensions, bytes, place) = unsafe {
            (
                list(dimensions, 3, "dimensions")?,
                list(voxels.cast::<u8>(), length as usize, "voxels")?,
                list(patient_from_voxel, 12, "numbers of patient_from_voxel")?,
            )
        };
        let dimensions = [0, 1, 2].map(|i| dimensions[i] as usize);
        let voxels = voxels_from_bytes(bytes_per_voxel, bytes)?;
        let column = |i: usize| DVec3::new(place[3 * i], place[3 * i + 1], place[3 * i + 2]);
        let axes = DMat3::from_cols(column(0), column(1), column(2));
        let place = DAffine3::from_mat3_translation(axes, column(3));
        let modality = match modality {
            1 => Modality::Ct,
            2 => Modality::Mr,
            3 => Modality::Pet,
            _ => Modality::Other,
        };
        let volume = Volume::new(dimensions, voxels, [slope, intercept], place, modality);
        Ok(LumivoxVolume::new(volume.map_err(|error| error.to_string())?, Value::Null))
    })
}

/// Voxels of so many bytes each, little-endian.
pub(crate) fn voxels_from_bytes(bytes_per_voxel: u32, bytes: &[u8]) -> Outcome<Voxels> {
    if !matches!(bytes_per_voxel, 1 | 2 | 4) {
        return Err(format!("a voxel has 1, 2 or 4 bytes, not {bytes_per_voxel}"));
    }
    if !bytes.len().is_multiple_of(bytes_per_voxel as usize) {
        return Err(format!("{} bytes are no whole number of voxels of {bytes_per_voxel}", bytes.len()));
    }
    Ok(match bytes_per_voxel {
        1 => Voxels::U8(bytes.to_vec()),
        2 => Voxels::U16(bytes.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect()),
        _ => Voxels::F32(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()),
    })
}

/// Another handle of the same scan.
///
/// # Safety
/// `volume` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_clone(volume: *const LumivoxVolume) -> *mut LumivoxVolume {
    // SAFETY: as the caller promises.
    guard_handle(|| Ok(unsafe { known(volume, "scan") }?.share()))
}

/// Frees a handle of a scan.
///
/// # Safety
/// `volume` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_free(volume: *mut LumivoxVolume) {
    // SAFETY: as the caller promises.
    unsafe { free(volume) };
}

/// What a scan is.
///
/// # Safety
/// `volume` is a live handle, `out` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_info(
    volume: *const LumivoxVolume,
    out: *mut LumivoxVolumeInfo,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (volume, out) = unsafe { (known(volume, "scan")?, known_mut(out, "place for it")?) };
        *out = LumivoxVolumeInfo {
            has_surroundings: u32::from(volume.surroundings().is_some()),
            ..info(volume.volume())
        };
        Ok(())
    })
}

fn info(volume: &Volume) -> LumivoxVolumeInfo {
    let [low, high] = placement::bounds(volume).map(convert::mirrored);
    // Clip coordinates are mirrored with the object: Unity's z points away from who looks at the face.
    let flip = DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)), DVec3::Z);
    let mut unit = [0; 16];
    let name = volume.unit();
    // Cut where a character ends, with a 0 behind it.
    let length = (0..unit.len().min(name.len() + 1)).rev().find(|&end| name.is_char_boundary(end));
    let length = length.unwrap_or(0);
    unit[..length].copy_from_slice(&name.as_bytes()[..length]);
    LumivoxVolumeInfo {
        dimensions: volume.dims().map(|n| n as u32),
        bytes_per_voxel: volume.voxels().bytes_per_sample() as u32,
        spacing_mm: volume.spacing_mm().to_array(),
        value_range: volume.value_range(),
        bounds_min: convert::narrow(low.min(high)),
        bounds_max: convert::narrow(low.max(high)),
        object_from_clip: convert::object_from(placement::node_from_clip(volume) * flip),
        object_from_patient: convert::object_from(placement::node_from_patient(volume)),
        modality: match volume.modality() {
            Modality::Other => 0,
            Modality::Ct => 1,
            Modality::Mr => 2,
            Modality::Pet => 3,
        },
        is_hounsfield: u32::from(volume.is_hounsfield()),
        has_surroundings: 0,
        padding: 0,
        unit,
    }
}

/// The number of voxels in each of `bins` equal parts of the values `low..=high`. The first call of a scan looks at every
/// voxel.
///
/// # Safety
/// `volume` is a live handle, `counts` can hold `bins` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_histogram(
    volume: *const LumivoxVolume,
    low: f64,
    high: f64,
    bins: u32,
    counts: *mut f32,
) -> i32 {
    guard_status(|| {
        if bins == 0 || counts.is_null() {
            return Err("a histogram needs at least one bin, and a place for its counts".to_owned());
        }
        // SAFETY: as the caller promises.
        let (volume, counts) =
            unsafe { (known(volume, "scan")?, std::slice::from_raw_parts_mut(counts, bins as usize)) };
        let histogram = volume.0.histogram.get_or_init(|| Histogram::new(volume.volume()));
        counts.copy_from_slice(&histogram.counts(bins as usize, [low, high]));
        Ok(())
    })
}

/// What is kept of how a scan was read, as JSON: `format`, `notes`, `series`; `null` where it was not.
///
/// # Safety
/// `volume` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_report(volume: *const LumivoxVolume) -> *mut LumivoxText {
    // SAFETY: as the caller promises.
    guard_handle(|| Ok(LumivoxText::new(&unsafe { known(volume, "scan") }?.report().to_string())))
}

/// Names the program `lumivox-codecs` that lies beside the library: it decodes JPEG-LS and JPEG 2000, so that a file which
/// crashes a decoder costs its slice and not the engine. Null, or a program that is not there: in this process.
///
/// # Safety
/// `path` is null or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_set_codec_program(path: *const c_char) {
    guard(|| {
        // SAFETY: as the caller promises.
        let path = unsafe { crate::border::text(path, "path of the program") }?;
        let program = path.filter(|path| can_run(std::path::Path::new(path)));
        let arguments: [&str; 0] = [];
        lumivox_import::set_codec_worker(
            program.map(|program| lumivox_import::CodecWorker::new(program, arguments)),
        );
        Ok(())
    });
}

/// Whether a file is a program. Whoever unpacked the package may have forgotten that it is one.
fn can_run(path: &std::path::Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let Ok(data) = path.metadata() else { return false };
        let mode = data.permissions().mode();
        let runs = mode & 0o111 != 0
            || std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode | 0o755)).is_ok();
        data.is_file() && runs
    }
    #[cfg(not(unix))]
    path.is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 x 3 x 4 voxels, axial, 10 x 20 x 30 mm.
    fn axial() -> LumivoxVolume {
        let place = [10.0, 0.0, 0.0, 0.0, 20.0, 0.0, 0.0, 0.0, 30.0, 7.0, -3.0, 90.0];
        let (dims, voxels) = ([2, 3, 4], [0u8; 24]);
        // SAFETY: all of it is there.
        let made = unsafe {
            lumivox_volume_new(dims.as_ptr(), 1, voxels.as_ptr().cast(), 24, 1.0, 0.0, place.as_ptr(), 1)
        };
        assert!(!made.is_null());
        // SAFETY: it is a handle.
        *unsafe { Box::from_raw(made) }
    }

    #[test]
    fn a_scan_lies_in_its_object_as_it_stands() {
        let volume = axial();
        let info = info(volume.volume());
        assert_eq!((info.dimensions, info.bytes_per_voxel, info.modality), ([2, 3, 4], 1, 1));
        let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(close(info.bounds_min, [-0.01, -0.06, -0.03]), "{:?}", info.bounds_min);
        assert!(close(info.bounds_max, [0.01, 0.06, 0.03]));
        // Clip coordinates run along the object's axes: x to the right, y up, z away.
        let map = convert::matrix(&info.object_from_clip);
        let corner = map.transform_point3(DVec3::ZERO);
        assert!(close(convert::narrow(corner), info.bounds_min), "{corner}");
        assert!(close(convert::narrow(map.transform_point3(DVec3::ONE)), info.bounds_max));
        // The patient's left, back and head: +x, +z and +y of an object that faces -z.
        let map = convert::matrix(&info.object_from_patient);
        assert!(close(convert::narrow(map.transform_point3(volume.volume().center_mm())), [0.0; 3]));
        let sides =
            [(DVec3::X, [1e-3, 0.0, 0.0]), (DVec3::Y, [0.0, 0.0, 1e-3]), (DVec3::Z, [0.0, 1e-3, 0.0])];
        for (side, way) in sides {
            assert!(close(convert::narrow(map.transform_vector3(side)), way), "{side}");
        }
    }

    #[test]
    fn a_long_unit_is_cut_between_characters() {
        let cut = |unit: &str| {
            let volume = (**axial().volume()).clone().with_unit(unit.to_owned());
            let unit = info(&volume).unit;
            assert_eq!(unit[15], 0);
            std::str::from_utf8(unit.split(|b| *b == 0).next().unwrap()).unwrap().to_owned()
        };
        assert_eq!(cut("HU"), "HU");
        assert_eq!(cut("12345678901234\u{b5}g"), "12345678901234");
        assert_eq!(cut("123456789012345"), "123456789012345");
    }

    #[test]
    fn voxels_that_are_no_scan_are_refused() {
        assert!(voxels_from_bytes(3, &[0; 6]).unwrap_err().contains("1, 2 or 4"));
        assert!(voxels_from_bytes(2, &[0; 5]).unwrap_err().contains("5 bytes"));
        let silent = CancelToken::new();
        let error = phantom("foot", 64, Progress::SILENT, &silent).err().unwrap();
        assert!(error.contains("'head', 'torso' and 'cube'"), "{error}");
        assert!(phantom("cube", 4, Progress::SILENT, &silent).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_program_that_lost_its_mode_gets_it_back() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("lumivox-codecs");
        assert!(!can_run(&program));
        assert!(!can_run(folder.path()));
        std::fs::write(&program, "").unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o644)).unwrap();
        assert!(can_run(&program));
        assert_eq!(program.metadata().unwrap().permissions().mode() & 0o111, 0o111);
    }
}
