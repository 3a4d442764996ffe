//! Writing a volume as the CT, MR or PET series that a scanner would have sent.
//!
//! DICOM PS3.3 A.3, A.4 and A.21 (CT, MR and PET Image IOD), one file per axial slice, explicit VR little endian.

use std::{
    collections::HashSet,
    fs::{self, File},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

use dicom_core::{DataElement, PrimitiveValue, Tag, VR};
use dicom_dictionary_std::{tags, uids};
use dicom_object::{FileMetaTableBuilder, InMemDicomObject, OpenFileOptions};
use glam::DVec3;
use lumivox_core::{CancelToken, Cancelled, Modality, Progress, Volume, Voxels, WorkStage};
use rayon::prelude::*;

use crate::noise::hash64;

/// Who and what a written series says it shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SeriesDescription {
    /// Patient's Name (0010,0010), its parts separated by `^`.
    pub patient_name: String,
    /// Patient ID (0010,0020).
    pub patient_id: String,
    /// Study Description (0008,1030).
    pub study: String,
    /// Series Description (0008,103E).
    pub series: String,
    /// Body Part Examined (0018,0015).
    pub body_part: String,
    /// Series Number (0020,0011).
    pub series_number: u32,
    /// Study, series and acquisition date (`YYYYMMDD`).
    pub date: String,
    /// What the UIDs are made from: the same seed gives the same series.
    pub seed: u64,
}

impl Default for SeriesDescription {
    fn default() -> Self {
        Self {
            patient_name: "Phantom^Lumivox".into(),
            patient_id: "LUMIVOX-PHANTOM".into(),
            study: "Procedural phantom".into(),
            series: "Head and neck, contrast".into(),
            body_part: "HEADNECK".into(),
            series_number: 1,
            date: "20240101".into(),
            seed: 1,
        }
    }
}

/// Why a series was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// A file or folder could not be made, read or replaced.
    #[error("cannot {action} '{}': {source}", path.display())]
    Io {
        /// What was tried: `create`, `write`, ...
        action: &'static str,
        /// Where.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The folder holds files that are not of this series; nothing was changed.
    #[error("'{}' is not part of this series; choose an empty folder", path.display())]
    FolderNotEmpty {
        /// The first foreign file, in alphabetical order.
        path: PathBuf,
    },
    /// Only CT volumes of 8 or 16 bits, MR volumes of such without a rescale, and PET volumes of such in SUV without an
    /// intercept, can be stored without loss.
    #[error("a DICOM series cannot hold this volume: {0}")]
    Unsuitable(&'static str),
    /// The data set could not be encoded.
    #[error("cannot encode '{}': {reason}", path.display())]
    Encode {
        /// The file it was for.
        path: PathBuf,
        /// What the encoder said.
        reason: String,
    },
    /// The work was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Writes `volume` as a CT, MR or PET series, one file per slice, into `folder` (created if missing); returns the number of files.
///
/// A folder that holds anything but an earlier copy of the same series is left alone. Every file is written under a
/// temporary name first, so that a cancelled or failed run leaves only whole files.
///
/// # Errors
/// [`WriteError`], with the path it is about.
pub fn write_dicom_series(
    volume: &Volume,
    folder: &Path,
    description: &SeriesDescription,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<usize, WriteError> {
    let series = Series::new(volume, description)?;
    let slices = volume.dims()[2];
    cancel.check()?;
    fs::create_dir_all(folder).map_err(|source| io_error("create", folder, source))?;
    series.refuse_foreign_files(folder)?;
    let done = AtomicU64::new(0);
    (0..slices).into_par_iter().try_for_each(|k| {
        cancel.check()?;
        series.write_slice(k, &folder.join(series.file_name(k)))?;
        progress.report(WorkStage::Writing, done.fetch_add(1, Ordering::Relaxed) + 1, slices as u64);
        Ok::<_, WriteError>(())
    })?;
    Ok(slices)
}

fn io_error(action: &'static str, path: &Path, source: io::Error) -> WriteError {
    WriteError::Io { action, path: path.to_owned(), source }
}

const MANUFACTURER: &str = "Lumivox";

/// What all slices share.
struct Series<'a> {
    volume: &'a Volume,
    description: &'a SeriesDescription,
    row: DVec3,
    column: DVec3,
    spacing: DVec3,
    largest: u16,
}

impl<'a> Series<'a> {
    fn new(volume: &'a Volume, description: &'a SeriesDescription) -> Result<Self, WriteError> {
        match volume.modality() {
            Modality::Ct => {}
            // MR images have no rescale.
            Modality::Mr if volume.slope() == 1.0 && volume.intercept() == 0.0 => {}
            Modality::Mr => return Err(WriteError::Unsuitable("its values are not those that are stored")),
            Modality::Pet if volume.intercept() == 0.0 && volume.unit() == "SUV" => {}
            Modality::Pet => {
                return Err(WriteError::Unsuitable("its values are no SUV, or do not begin at 0"));
            }
            _ => return Err(WriteError::Unsuitable("its modality is neither CT, MR nor PET")),
        }
        if matches!(volume.voxels(), Voxels::F32(_)) {
            return Err(WriteError::Unsuitable("its samples are floating-point numbers"));
        }
        let [columns, rows, slices] = volume.dims();
        if columns > 65535 || rows > 65535 || slices > 9999 {
            return Err(WriteError::Unsuitable(
                "it has more than 65535 rows or columns, or more than 9999 slices",
            ));
        }
        let directions = volume.directions();
        if directions.x_axis.dot(directions.y_axis).abs() > 1e-4 {
            return Err(WriteError::Unsuitable("its rows and columns are not at right angles"));
        }
        Ok(Self {
            volume,
            description,
            row: directions.x_axis,
            column: directions.y_axis,
            spacing: volume.spacing_mm(),
            largest: volume.stored_range()[1] as u16,
        })
    }

    fn is_mr(&self) -> bool {
        self.volume.modality() == Modality::Mr
    }

    fn is_pet(&self) -> bool {
        self.volume.modality() == Modality::Pet
    }

    fn modality(&self) -> &'static str {
        match self.volume.modality() {
            Modality::Mr => "MR",
            Modality::Pet => "PT",
            _ => "CT",
        }
    }

    fn sop_class(&self) -> &'static str {
        match self.volume.modality() {
            Modality::Mr => uids::MR_IMAGE_STORAGE,
            Modality::Pet => uids::POSITRON_EMISSION_TOMOGRAPHY_IMAGE_STORAGE,
            _ => uids::CT_IMAGE_STORAGE,
        }
    }

    fn file_name(&self, slice: usize) -> String {
        format!("{}{:04}.dcm", self.modality(), slice + 1)
    }

    /// Nothing of somebody else's may be overwritten or mixed up with this series.
    fn refuse_foreign_files(&self, folder: &Path) -> Result<(), WriteError> {
        let slices = self.volume.dims()[2];
        let own: HashSet<_> = (0..slices).map(|k| folder.join(self.file_name(k))).collect();
        let entries = fs::read_dir(folder).map_err(|source| io_error("read", folder, source))?;
        let mut foreign = Vec::new();
        for entry in entries {
            let path = entry.map_err(|source| io_error("read", folder, source))?.path();
            if !own.contains(&path) || !self.contains(&path) {
                foreign.push(path);
            }
        }
        match foreign.into_iter().min() {
            Some(path) => Err(WriteError::FolderNotEmpty { path }),
            None => Ok(()),
        }
    }

    /// Whether a file belongs to this series.
    fn contains(&self, path: &Path) -> bool {
        let header = OpenFileOptions::new().read_until(tags::IMAGE_POSITION_PATIENT).open_file(path);
        let uid = header
            .ok()
            .and_then(|h| h.element(tags::SERIES_INSTANCE_UID).ok()?.to_str().ok().map(String::from));
        uid.is_some_and(|uid| uid.trim_end_matches(['\0', ' ']) == self.series_uid())
    }

    fn write_slice(&self, k: usize, path: &Path) -> Result<(), WriteError> {
        let encode = |reason: String| WriteError::Encode { path: path.to_owned(), reason };
        let meta = FileMetaTableBuilder::new()
            .transfer_syntax(uids::EXPLICIT_VR_LITTLE_ENDIAN)
            .media_storage_sop_class_uid(self.sop_class())
            .media_storage_sop_instance_uid(self.uid("instance", k));
        let object = self.slice(k).with_meta(meta).map_err(|e| encode(e.to_string()))?;

        let partial = path.with_extension("part");
        let file = File::create(&partial).map_err(|source| io_error("create", &partial, source))?;
        let mut writer = Reporting { inner: BufWriter::new(file), error: None };
        let written = object.write_all(&mut writer).map_err(|e| match writer.error.take() {
            Some(source) => io_error("write", path, source),
            None => encode(e.to_string()),
        });
        let finished = written
            .and_then(|()| writer.inner.flush().map_err(|source| io_error("write", path, source)))
            .and_then(|()| fs::rename(&partial, path).map_err(|source| io_error("replace", path, source)));
        if finished.is_err() {
            // The first error is the one to tell; the leftover may be impossible to remove for the same reason.
            let _ = fs::remove_file(&partial);
        }
        finished
    }

    /// The data set of slice `k`.
    fn slice(&self, k: usize) -> InMemDicomObject {
        let d = self.description;
        let v = self.volume;
        let [columns, rows, _] = v.dims();
        let stride = v.patient_from_voxel().matrix3.z_axis;
        let origin = v.patient_from_voxel().transform_point3(DVec3::Z * k as f64);
        let normal = self.row.cross(self.column);
        let bits: u16 = if self.largest < 4096 { 12 } else { 16 };
        let mut object = InMemDicomObject::new_empty();
        let mut put = |tag: Tag, vr: VR, value: PrimitiveValue| {
            object.put(DataElement::new(tag, vr, value));
        };
        let text = |s: &str| PrimitiveValue::from(s);
        let many = |s: Vec<String>| PrimitiveValue::Strs(s.into());
        let decimals = |numbers: &[f64]| many(numbers.iter().map(|n| decimal_string(*n)).collect());

        put(tags::SPECIFIC_CHARACTER_SET, VR::CS, text("ISO_IR 192"));
        // A PET's type has two values.
        let kind: &[&str] = match v.modality() {
            Modality::Mr => &["ORIGINAL", "PRIMARY", "OTHER"],
            Modality::Pet => &["ORIGINAL", "PRIMARY"],
            _ => &["ORIGINAL", "PRIMARY", "AXIAL"],
        };
        put(tags::IMAGE_TYPE, VR::CS, many(kind.iter().map(|word| (*word).to_owned()).collect()));
        put(tags::SOP_CLASS_UID, VR::UI, text(self.sop_class()));
        put(tags::SOP_INSTANCE_UID, VR::UI, text(&self.uid("instance", k)));
        put(tags::STUDY_DATE, VR::DA, text(&d.date));
        put(tags::SERIES_DATE, VR::DA, text(&d.date));
        put(tags::ACQUISITION_DATE, VR::DA, text(&d.date));
        put(tags::CONTENT_DATE, VR::DA, text(&d.date));
        for time in [tags::STUDY_TIME, tags::SERIES_TIME, tags::ACQUISITION_TIME, tags::CONTENT_TIME] {
            put(time, VR::TM, text("120000"));
        }
        put(tags::ACCESSION_NUMBER, VR::SH, PrimitiveValue::Empty);
        put(tags::MODALITY, VR::CS, text(self.modality()));
        put(tags::MANUFACTURER, VR::LO, text(MANUFACTURER));
        put(tags::MANUFACTURER_MODEL_NAME, VR::LO, text("Procedural phantom"));
        put(tags::REFERRING_PHYSICIAN_NAME, VR::PN, PrimitiveValue::Empty);
        put(tags::STUDY_DESCRIPTION, VR::LO, text(&d.study));
        put(tags::SERIES_DESCRIPTION, VR::LO, text(&d.series));

        put(tags::PATIENT_NAME, VR::PN, text(&d.patient_name));
        put(tags::PATIENT_ID, VR::LO, text(&d.patient_id));
        put(tags::PATIENT_BIRTH_DATE, VR::DA, PrimitiveValue::Empty);
        put(tags::PATIENT_SEX, VR::CS, text("O"));

        put(tags::BODY_PART_EXAMINED, VR::CS, text(&d.body_part));
        put(tags::SLICE_THICKNESS, VR::DS, decimals(&[stride.dot(normal).abs()]));
        if self.is_mr() {
            // An MPRAGE, as it is usual for heads.
            put(tags::SCANNING_SEQUENCE, VR::CS, many(["GR", "IR"].map(String::from).to_vec()));
            put(tags::SEQUENCE_VARIANT, VR::CS, text("MP"));
            put(tags::SCAN_OPTIONS, VR::CS, PrimitiveValue::Empty);
            put(tags::MR_ACQUISITION_TYPE, VR::CS, text("3D"));
            put(tags::REPETITION_TIME, VR::DS, decimals(&[2300.0]));
            put(tags::ECHO_TIME, VR::DS, decimals(&[3.0]));
            put(tags::INVERSION_TIME, VR::DS, decimals(&[900.0]));
            put(tags::ECHO_TRAIN_LENGTH, VR::IS, text("1"));
        } else if self.is_pet() {
            // Grams per millilitre are what SUV by body weight is measured in.
            put(tags::UNITS, VR::CS, text("GML"));
            put(tags::SUV_TYPE, VR::CS, text("BW"));
            put(tags::COUNTS_SOURCE, VR::CS, text("EMISSION"));
            put(tags::SERIES_TYPE, VR::CS, many(["STATIC", "IMAGE"].map(String::from).to_vec()));
            put(tags::CORRECTED_IMAGE, VR::CS, many(["ATTN", "DECY", "SCAT"].map(String::from).to_vec()));
            put(tags::DECAY_CORRECTION, VR::CS, text("START"));
            put(tags::NUMBER_OF_SLICES, VR::US, PrimitiveValue::from(v.dims()[2] as u16));
            put(tags::IMAGE_INDEX, VR::US, PrimitiveValue::from((k + 1) as u16));
            put(tags::FRAME_REFERENCE_TIME, VR::DS, decimals(&[0.0]));
            put(tags::ACTUAL_FRAME_DURATION, VR::IS, text("180000"));
        } else {
            put(tags::KVP, VR::DS, decimals(&[120.0]));
            put(tags::GANTRY_DETECTOR_TILT, VR::DS, decimals(&[0.0]));
            put(tags::CONVOLUTION_KERNEL, VR::SH, text("STANDARD"));
        }
        put(tags::PATIENT_POSITION, VR::CS, text("HFS"));

        put(tags::STUDY_INSTANCE_UID, VR::UI, text(&self.uid("study", 0)));
        put(tags::SERIES_INSTANCE_UID, VR::UI, text(&self.series_uid()));
        put(tags::STUDY_ID, VR::SH, text("1"));
        put(tags::SERIES_NUMBER, VR::IS, text(&d.series_number.to_string()));
        put(tags::ACQUISITION_NUMBER, VR::IS, text("1"));
        put(tags::INSTANCE_NUMBER, VR::IS, text(&(k + 1).to_string()));
        put(tags::IMAGE_POSITION_PATIENT, VR::DS, decimals(&origin.to_array()));
        let orientation = [self.row.to_array(), self.column.to_array()].concat();
        put(tags::IMAGE_ORIENTATION_PATIENT, VR::DS, decimals(&orientation));
        put(tags::FRAME_OF_REFERENCE_UID, VR::UI, text(&self.uid("frame of reference", 0)));
        put(tags::POSITION_REFERENCE_INDICATOR, VR::LO, PrimitiveValue::Empty);
        put(tags::SLICE_LOCATION, VR::DS, decimals(&[origin.dot(normal)]));

        put(tags::SAMPLES_PER_PIXEL, VR::US, PrimitiveValue::from(1u16));
        put(tags::PHOTOMETRIC_INTERPRETATION, VR::CS, text("MONOCHROME2"));
        put(tags::ROWS, VR::US, PrimitiveValue::from(rows as u16));
        put(tags::COLUMNS, VR::US, PrimitiveValue::from(columns as u16));
        // Pixel Spacing is between rows (along y) first.
        put(tags::PIXEL_SPACING, VR::DS, decimals(&[self.spacing.y, self.spacing.x]));
        put(tags::BITS_ALLOCATED, VR::US, PrimitiveValue::from(16u16));
        put(tags::BITS_STORED, VR::US, PrimitiveValue::from(bits));
        put(tags::HIGH_BIT, VR::US, PrimitiveValue::from(bits - 1));
        put(tags::PIXEL_REPRESENTATION, VR::US, PrimitiveValue::from(0u16));
        let window = match v.modality() {
            Modality::Mr => [400.0, 800.0],
            Modality::Pet => [5.0, 10.0],
            _ => [40.0, 400.0],
        };
        put(tags::WINDOW_CENTER, VR::DS, decimals(&window[..1]));
        put(tags::WINDOW_WIDTH, VR::DS, decimals(&window[1..]));
        if !self.is_mr() {
            put(tags::RESCALE_INTERCEPT, VR::DS, decimals(&[v.intercept()]));
            put(tags::RESCALE_SLOPE, VR::DS, decimals(&[v.slope()]));
            if !self.is_pet() {
                put(tags::RESCALE_TYPE, VR::LO, text("HU"));
            }
        }
        let pixels = columns * rows;
        let range = k * pixels..(k + 1) * pixels;
        let samples: Vec<u16> = match v.voxels() {
            Voxels::U16(s) => s[range].to_vec(),
            Voxels::U8(s) => s[range].iter().map(|x| u16::from(*x)).collect(),
            Voxels::F32(_) => unreachable!("refused in Series::new"),
        };
        put(tags::PIXEL_DATA, VR::OW, PrimitiveValue::U16(samples.into()));
        object
    }

    fn series_uid(&self) -> String {
        self.uid("series", 0)
    }

    /// A UID under 2.25 (PS3.5 B.2): a UUID of version 8 made from the seed, the patient, the role and a number, and
    /// for what is inside a series from its number and grid too.
    fn uid(&self, role: &str, number: usize) -> String {
        let d = self.description;
        let mix = |h: u64, s: &str| s.bytes().fold(h, |h, b| hash64(h ^ u64::from(b)));
        let mut base = mix(mix(hash64(d.seed), &d.patient_id), role);
        if matches!(role, "series" | "instance") {
            let grid = self.volume.dims().map(|n| n as u64);
            base = [u64::from(d.series_number)].into_iter().chain(grid).fold(base, |h, n| hash64(h ^ n));
        }
        let high = hash64(base ^ number as u64);
        let low = hash64(high ^ 0x6c75_6d69_766f_7821);
        let uuid = (u128::from(high) << 64 | u128::from(low)) & !(0xf << 76) & !(0b11 << 62);
        format!("2.25.{}", uuid | 8 << 76 | 0b10 << 62)
    }
}

/// A number as a DICOM decimal string: at most 16 characters, as exact as they allow.
fn decimal_string(x: f64) -> String {
    let exact = format!("{x}");
    if exact.len() <= 16 {
        return exact;
    }
    let shortest = (0..=14).rev().flat_map(|digits| [format!("{x:.digits$}"), format!("{x:.digits$e}")]);
    // An exponent may keep more digits of a very small number: of those that fit, take the nearest.
    shortest
        .filter(|s| s.len() <= 16)
        .min_by(|a, b| {
            let error = |s: &String| s.parse::<f64>().map_or(f64::MAX, |y| (y - x).abs());
            error(a).total_cmp(&error(b))
        })
        .expect("one digit fits")
}

/// Keeps the typed I/O error that the encoder wraps beyond reach.
struct Reporting<W> {
    inner: W,
    error: Option<io::Error>,
}

impl<W: Write> Write for Reporting<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.inner.write(bytes).inspect_err(|e| self.error = Some(copy_error(e)))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush().inspect_err(|e| self.error = Some(copy_error(e)))
    }
}

fn copy_error(e: &io::Error) -> io::Error {
    e.raw_os_error().map_or_else(|| io::Error::new(e.kind(), e.to_string()), io::Error::from_raw_os_error)
}

#[cfg(test)]
mod tests;
