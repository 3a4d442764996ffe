//! Files that hold one scan, and no others beside it: what their headers say, and the way from samples to an
//! [`Imported`]. Every reader but DICOM's ends here.

use std::path::{Path, PathBuf};

use lumivox_core::{
    CancelToken, Modality, Progress, Volume,
    glam::{DAffine3, DMat3, DVec3},
};

use crate::{
    Imported,
    error::ImportError,
    lengths::SPACING_MM,
    report::{ImportReport, SeriesSummary, Thumbnail, orientation_words},
    sample::Decoded,
    samples::Samples,
    values::{Told, judged, looks_like_hounsfield},
};

/// Pixels of the largest slice that a picture is made of.
pub(crate) const LARGEST_PICTURE: usize = 1 << 28;

/// What a header says.
pub(crate) struct Single {
    pub path: PathBuf,
    /// The format's name: `NIfTI`.
    pub format: &'static str,
    pub dims: [usize; 3],
    /// Grids of that size, one after the other.
    pub phases: usize,
    pub payload: Samples,
    /// The header's slope and intercept.
    pub rescale: [f64; 2],
    pub patient_from_voxel: DAffine3,
    /// What the header says it is, if it does.
    pub modality: Option<Modality>,
    pub notes: Vec<String>,
}

impl Single {
    /// Compares what the header promises with the files that are there. Reads no sample.
    ///
    /// # Errors
    /// When a data file is missing or too short, and for sizes and spacings that nothing has.
    pub fn checked(self) -> Result<Self, ImportError> {
        self.payload.check(&self.path, self.dims, self.phases)?;
        check_spacing(&self.path, self.patient_from_voxel)?;
        Ok(self)
    }

    /// What to tell of several phases.
    pub fn phases_note(&self) -> Option<String> {
        (self.phases > 1).then(|| format!("{} phases", self.phases))
    }

    /// What the header tells.
    pub fn report(&self) -> ImportReport {
        let mut notes = self.notes.clone();
        notes.extend(self.phases_note());
        // Wider samples are kept in 16 bits where that loses nothing, which shows when they are read.
        let bytes = self.payload.sample().bytes().min(4) * self.dims.iter().product::<usize>();
        self.report_of(self.modality.unwrap_or_default(), bytes as u64, notes)
    }

    fn report_of(&self, modality: Modality, bytes: u64, notes: Vec<String>) -> ImportReport {
        let [x, y, z] = self.dims;
        let code = match modality {
            Modality::Ct => "CT",
            Modality::Mr => "MR",
            Modality::Pet => "PET",
            Modality::Other => "",
        };
        let prefix = if code.is_empty() { String::new() } else { format!("{code}, ") };
        let sample = self.payload.sample();
        let kind = if sample.is_integer() { "" } else { " float" };
        let phases = if self.phases > 1 { format!(", {} phases", self.phases) } else { String::new() };
        let matrix = self.patient_from_voxel.matrix3;
        let detached = !self.payload.files().contains(&self.path) && crate::files::is_file(&self.path);
        let summary = SeriesSummary {
            id: self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned(),
            name: if code.is_empty() { format!("{} scan", self.format) } else { code.to_owned() },
            uid: None,
            number: None,
            description: format!("{prefix}{x} x {y} x {z}, {}-bit{kind}{phases}", 8 * sample.bytes()),
            files: self.payload.files().len() + usize::from(detached),
            modality: code.to_owned(),
            dims: self.dims,
            spacing_mm: [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::length),
            orientation: orientation_words(matrix),
            phases: self.phases,
            unit: modality.usual_unit().to_owned(),
            bytes,
            reason: String::new(),
            segments_series: None,
            aligned_series: Vec::new(),
            notes: notes.clone(),
        };
        ImportReport {
            format: self.format.to_owned(),
            series: vec![summary],
            notes,
            ..ImportReport::default()
        }
    }

    /// Reads the samples of a phase, counted from 1; by default of the first. What the user `told` of its values goes before
    /// what the file says.
    ///
    /// # Errors
    /// When there is no such phase, when data are missing or damaged, and on cancel.
    pub fn load(
        &self,
        phase: Option<usize>,
        told: &Told,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<Imported, ImportError> {
        let path = &self.path;
        let wanted = phase.unwrap_or(1);
        if !(1..=self.phases).contains(&wanted) {
            return Err(ImportError::NoSuchPhase { path: path.clone(), wanted, phases: self.phases });
        }
        let part = (wanted - 1, 0..self.dims.into_iter().product());
        let decoded = self.payload.read(path, self.dims, self.phases, part, progress, cancel)?;
        let decoded = decoded.ok_or_else(|| self.no_number())?;

        let mut notes = self.notes.clone();
        if self.phases > 1 {
            notes.push(format!("phase {wanted} of {} is taken", self.phases));
            if let Some(there) = self.payload.phases_of_cut(path, self.dims, self.phases, cancel)? {
                let verb = if there == 1 { "is" } else { "are" };
                let phases = self.phases;
                notes.push(format!("the file is cut short: {there} of {phases} phases {verb} there"));
            }
        }
        self.finish(decoded, told, notes)
    }

    /// The scan of samples that were read, and what there is to tell of it after `notes`.
    ///
    /// # Errors
    /// When they make no volume.
    pub fn finish(
        &self,
        decoded: Decoded,
        told: &Told,
        mut notes: Vec<String>,
    ) -> Result<Imported, ImportError> {
        let path = &self.path;
        notes.extend(decoded.notes);
        let [slope, intercept] = told.rescale(self.rescale);
        let [own_slope, own_intercept] = decoded.rescale;
        let rescale = [slope * own_slope, slope * own_intercept + intercept];
        let modality = self.modality.unwrap_or_default();
        let mut volume = Volume::new(self.dims, decoded.voxels, rescale, self.patient_from_voxel, modality)
            .map_err(|source| ImportError::Volume { path: path.clone(), source })?;
        let is_known = self.modality.is_some() || told.modality.is_some() || told.unit.is_some();
        volume = told.apply(volume);
        if !is_known && decoded.integral && looks_like_hounsfield(&volume) {
            volume = volume.with_modality(Modality::Ct);
            let [min, max] = volume.value_range();
            notes.push(format!("values from {min} to {max} look like Hounsfield units: taken for CT"));
        }
        volume = judged(volume, told, &mut notes);
        notes.extend(remarks(&volume));
        let report = self.report_of(volume.modality(), volume.voxels().as_bytes().len() as u64, notes);
        Ok(Imported { volume, report })
    }

    /// A picture of the middle slice of the first phase, for which no more than that is kept in memory.
    ///
    /// # Errors
    /// When data are missing or damaged, and on cancel.
    pub fn thumbnail(&self, side: usize, cancel: &CancelToken) -> Result<Thumbnail, ImportError> {
        let [columns, rows, depth] = self.dims;
        let len = columns * rows;
        if len > LARGEST_PICTURE {
            return Err(ImportError::Unsupported {
                path: self.path.clone(),
                what: format!("a slice of {columns} x {rows} pixels, too large for a picture of it"),
                remedy: "Load it without a picture, or resample the scan to fewer voxels".to_owned(),
            });
        }
        let part = (0, depth / 2 * len..(depth / 2 + 1) * len);
        let decoded =
            self.payload.read(&self.path, self.dims, self.phases, part, Progress::SILENT, cancel)?;
        let values: Vec<f64> = match decoded {
            Some(decoded) => {
                let [slope, intercept] = decoded.rescale;
                let value =
                    |i| (decoded.voxels.get(i) * slope + intercept) * self.rescale[0] + self.rescale[1];
                (0..len).map(value).collect()
            }
            // Nothing was measured there.
            None => vec![0.0; len],
        };
        let matrix = self.patient_from_voxel.matrix3;
        let spacing = [matrix.x_axis, matrix.y_axis].map(DVec3::length);
        Ok(Thumbnail::new(&values, [columns, rows], spacing, None, side))
    }

    pub fn no_number(&self) -> ImportError {
        ImportError::Field {
            path: self.path.clone(),
            field: "the image data".to_owned(),
            problem: "holds not one finite number".to_owned(),
            remedy: "Export the scan again".to_owned(),
        }
    }
}
/// LPS from RAS: NIfTI's and 3D Slicer's axes point the other way in x and y.
pub(crate) fn lps_from_ras() -> DAffine3 {
    DAffine3::from_scale(DVec3::new(-1.0, -1.0, 1.0))
}

/// A placement without rotation.
pub(crate) fn axis_aligned(spacing_mm: [f64; 3], origin_mm: [f64; 3]) -> DAffine3 {
    DAffine3::from_mat3_translation(
        DMat3::from_diagonal(DVec3::from_array(spacing_mm)),
        DVec3::from_array(origin_mm),
    )
}

/// Refuses distances between voxels that no scanner makes and no renderer can place.
pub(crate) fn check_spacing(path: &Path, patient_from_voxel: DAffine3) -> Result<(), ImportError> {
    let DMat3 { x_axis, y_axis, z_axis } = patient_from_voxel.matrix3;
    let [x, y, z] = [x_axis, y_axis, z_axis].map(DVec3::length);
    if [x, y, z].iter().all(|mm| SPACING_MM.contains(mm)) {
        return Ok(());
    }
    Err(ImportError::Field {
        path: path.to_owned(),
        field: "the distance between voxels".to_owned(),
        problem: format!(
            "is {x} x {y} x {z} mm, not from {} to {} mm each way",
            SPACING_MM.start(),
            SPACING_MM.end()
        ),
        remedy: "Correct the spacing or its unit, or export the scan again".to_owned(),
    })
}

/// What to tell of a volume that is one only by name.
pub(crate) fn remarks(volume: &Volume) -> Option<String> {
    let [min, max] = volume.value_range();
    if min == max {
        return Some(format!("every voxel has the same value, {min}: there is nothing to tell apart"));
    }
    let thin = volume.dims().contains(&1);
    thin.then(|| "a single slice is not a volume: it is shown as a thin sheet".to_owned())
}

/// Whether voxels can lie there: finite and not flattened.
pub(crate) fn is_placement(patient_from_voxel: DAffine3) -> bool {
    patient_from_voxel.is_finite() && patient_from_voxel.matrix3.determinant().is_normal()
}
