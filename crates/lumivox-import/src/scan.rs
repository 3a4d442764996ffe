//! The last step of every reader of single files: header and samples become an [`Imported`].

use std::{ops::RangeInclusive, path::Path};

use lumivox_core::{
    Modality, Volume, Voxels,
    glam::{DAffine3, DMat3, DVec3},
};

use crate::{
    Imported,
    error::ImportError,
    report::{ImportReport, SeriesSummary, orientation_words},
    sample::Decoded,
};

/// Distances between voxels that are believed, in mm: from atoms to a kilometre.
pub(crate) const SPACING_MM: RangeInclusive<f64> = 1e-6..=1e6;

/// What a reader found.
pub(crate) struct Scan<'a> {
    pub path: &'a Path,
    /// The format's name: `NIfTI`.
    pub format: &'static str,
    pub dims: [usize; 3],
    /// Files that were read.
    pub files: usize,
    pub decoded: Decoded,
    /// The header's slope and intercept, on top of the decoder's.
    pub rescale: [f64; 2],
    pub patient_from_voxel: DAffine3,
    /// What the header says it is, if it does.
    pub modality: Option<Modality>,
    pub notes: Vec<String>,
}

impl Scan<'_> {
    /// Makes the volume and its report.
    pub fn import(self) -> Result<Imported, ImportError> {
        let Self { path, decoded, mut notes, .. } = self;
        let bits = 8 * decoded.voxels.bytes_per_sample();
        let kind = if matches!(decoded.voxels, Voxels::F32(_)) { " float" } else { "" };
        notes.extend(decoded.notes);
        let [slope, intercept] = self.rescale;
        let [own_slope, own_intercept] = decoded.rescale;
        let rescale = [slope * own_slope, slope * own_intercept + intercept];
        let modality = self.modality.unwrap_or_default();
        check_spacing(path, self.patient_from_voxel)?;
        let mut volume = Volume::new(self.dims, decoded.voxels, rescale, self.patient_from_voxel, modality)
            .map_err(|source| ImportError::Volume { path: path.to_owned(), source })?;
        if self.modality.is_none() && decoded.integral && looks_like_hounsfield(volume.value_range()) {
            volume = volume.with_modality(Modality::Ct);
            let [min, max] = volume.value_range();
            notes.push(format!("values from {min} to {max} look like Hounsfield units: taken for CT"));
        }
        notes.extend(remarks(&volume));
        let [x, y, z] = self.dims;
        let modality = match volume.modality() {
            Modality::Ct => "CT, ",
            Modality::Mr => "MR, ",
            Modality::Pet => "PET, ",
            Modality::Other => "",
        };
        let summary = SeriesSummary {
            id: path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
            number: None,
            description: format!("{modality}{x} x {y} x {z}, {bits}-bit{kind}"),
            files: self.files,
            modality: modality.trim_end_matches(", ").to_owned(),
            dims: self.dims,
            spacing_mm: volume.spacing_mm().to_array(),
            orientation: orientation_words(volume.patient_from_voxel().matrix3),
            phases: 1,
            unit: volume.modality().unit().to_owned(),
            bytes: volume.voxels().as_bytes().len() as u64,
            reason: String::new(),
            segments_series: None,
            notes: notes.clone(),
        };
        let report = ImportReport {
            format: self.format.to_owned(),
            series: vec![summary],
            notes,
            ..ImportReport::default()
        };
        Ok(Imported { volume, report })
    }
}

/// Air at -1000 and bone above 300 in one scan of integers are hardly ever anything but CT.
fn looks_like_hounsfield([min, max]: [f64; 2]) -> bool {
    (-10_000.0..=-900.0).contains(&min) && (300.0..=70_000.0).contains(&max)
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
