//! What an import found and did, for people and programs.

use std::{collections::BTreeMap, path::PathBuf};

use lumivox_core::{
    Volume,
    glam::{DMat3, DVec3},
};
use serde::{Deserialize, Serialize, Serializer};

/// A scan and what became of its files.
#[derive(Debug)]
#[non_exhaustive]
pub struct Imported {
    /// The scan.
    pub volume: Volume,
    /// How it was read.
    pub report: ImportReport,
}

/// One series (or file) that could be loaded.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SeriesSummary {
    /// SeriesInstanceUID, or the file's name where there is none; of several with one in common the second is `ID#2`. A file's name may
    /// be a patient's.
    pub id: String,
    /// What to call it where files and folders may be named by the patient: `CT series 4`, `PET`, `NIfTI scan`.
    pub name: String,
    /// SeriesInstanceUID, where there is one.
    pub uid: Option<String>,
    /// DICOM's SeriesNumber.
    pub number: Option<i64>,
    /// What it is, without a word about the patient, and what tells it from others:
    /// `CT series 4, thorax 1.0, kernel B30f, 10:31:05, 275 slices, 512 x 512`.
    pub description: String,
    /// Files that make it up.
    pub files: usize,
    /// DICOM's code for what made it: `CT`; `other` for an unknown one, empty where nothing says it.
    pub modality: String,
    /// Voxels along x, y, z of the volume that it becomes, one phase of it.
    pub dims: [usize; 3],
    /// Distances between neighbouring voxels along x, y, z, in mm.
    pub spacing_mm: [f64; 3],
    /// How the slices lie in the patient: `axial`, `oblique coronal`.
    pub orientation: String,
    /// Volumes in it: phases, echoes, weightings. [`ImportOptions::phase`](crate::ImportOptions::phase) takes one.
    pub phases: usize,
    /// What values are measured in: `HU`, `SUV`, `Bq/ml`, `Gy`; empty where that is not known.
    pub unit: String,
    /// Memory that one phase's voxels take, in bytes.
    pub bytes: u64,
    /// Why another comes first: `a localizer`, `a single image`, `fewer voxels`; empty for the first.
    pub reason: String,
    /// Position in the list, from 0, of the series that a segmentation was made on.
    pub segments_series: Option<usize>,
    /// Positions in the list, from 0, of other series that lie in the same place of the same patient: their files name one
    /// FrameOfReferenceUID. A PET and its CT do.
    pub aligned_series: Vec<usize>,
    /// What is worth knowing before it is loaded: `1 of 176 slices is missing; ...`.
    pub notes: Vec<String>,
}

/// A file that was left out, and why.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SkippedFile {
    /// The file.
    #[serde(serialize_with = "for_programs")]
    pub path: PathBuf,
    /// Why, as a phrase: `it holds no image`, `a localizer`.
    pub reason: String,
}

/// What an import found and did.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ImportReport {
    /// The format's name: `DICOM`, `NIfTI`, `NRRD`, `MetaImage`, `RAW`.
    pub format: String,
    /// What could have been loaded; the best first.
    pub series: Vec<SeriesSummary>,
    /// Which of `series` was, or would be.
    pub chosen: usize,
    /// Sentences worth telling about it: `gantry tilt 18.5 degrees, kept as shear`, `1 of 176 slices is missing`.
    pub notes: Vec<String>,
    /// Slices of the volume, along z from 0, that hold nothing measured: damaged ones, and missing ones that were left
    /// empty. Known once it is loaded.
    pub empty_slices: Vec<usize>,
    /// What was left out.
    pub skipped: Vec<SkippedFile>,
}

impl ImportReport {
    /// The chosen series and one that is seen in it: a CT or else an MR, and a PET of the same place, as positions in the
    /// list. `None` where one of them is not there, or is no volume.
    pub fn fusion(&self) -> Option<[usize; 2]> {
        /// Of fewer slices there is no inside to see.
        const LEAST_SLICES: usize = 5;
        let own = self.series.get(self.chosen)?;
        let is_volume = |series: &SeriesSummary| series.dims[2] >= LEAST_SLICES;
        let others = |modality: &str| {
            let is_it = |series: &SeriesSummary| series.modality == modality && is_volume(series);
            let of_it = own.aligned_series.iter().copied().filter(|&k| is_it(&self.series[k]));
            of_it.collect::<Vec<usize>>()
        };
        match own.modality.as_str() {
            _ if !is_volume(own) => None,
            "CT" | "MR" => {
                let all = others("PT");
                // Of several, one that was corrected for what the body takes away.
                let best = all.iter().find(|&&k| self.series[k].unit == "SUV").or(all.first())?;
                Some([self.chosen, *best])
            }
            "PT" => {
                let all = [others("CT"), others("MR")].concat();
                Some([*all.first()?, self.chosen])
            }
            _ => None,
        }
    }

    /// Why files were left out, and how many for each reason.
    pub fn skipped_by_reason(&self) -> BTreeMap<&str, usize> {
        let mut reasons = BTreeMap::new();
        for file in &self.skipped {
            *reasons.entry(file.reason.as_str()).or_default() += 1;
        }
        reasons
    }
}

/// A path as text, even one that is no Unicode.
fn for_programs<S: Serializer>(path: &std::path::Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&lumivox_core::words::path(path))
}

/// A picture of a series: 8-bit grey, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Thumbnail {
    /// Pixels from left to right.
    pub width: usize,
    /// Pixels from top to bottom.
    pub height: usize,
    /// `width * height` of them, 0 black to 255 white.
    pub grey: Vec<u8>,
}

impl Thumbnail {
    /// The picture of a slice of `columns` x `rows` values that lie `spacing_mm` apart, at most `side` pixels wide and
    /// high. `window` is what becomes black and white; by default nearly all values fit.
    pub(crate) fn new(
        values: &[f64],
        [columns, rows]: [usize; 2],
        spacing_mm: [f64; 2],
        window: Option<[f64; 2]>,
        side: usize,
    ) -> Self {
        let [low, high] = window.unwrap_or_else(|| usual_range(values));
        let side = side.max(1) as f64;
        let (wide, tall) = (columns as f64 * spacing_mm[0], rows as f64 * spacing_mm[1]);
        // No finer than the slice itself.
        let scale = (side / wide.max(tall)).min(1.0 / spacing_mm[0].min(spacing_mm[1]));
        let pixels = |mm: f64| ((mm * scale).round().max(1.0) as usize).min(side as usize);
        let (width, height) = (pixels(wide), pixels(tall));
        // The values below a pixel, at least one.
        let below = |at: usize, pixels: usize, samples: usize| {
            let first = at * samples / pixels;
            first..((at + 1) * samples / pixels).clamp(first + 1, samples.max(first + 1))
        };
        let mut grey = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut count) = (0.0, 0.0);
                for row in below(y, height, rows) {
                    for column in below(x, width, columns) {
                        sum += values[row * columns + column];
                        count += 1.0;
                    }
                }
                let level = (sum / count - low) / (high - low).max(f64::MIN_POSITIVE);
                grey.push((level.clamp(0.0, 1.0) * 255.0).round() as u8);
            }
        }
        Self { width, height, grey }
    }
}

/// The 1st and 99.5th percentile.
fn usual_range(values: &[f64]) -> [f64; 2] {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let at = |part: f64| sorted.get((part * sorted.len() as f64) as usize).or(sorted.last()).copied();
    [at(0.01).unwrap_or(0.0), at(0.995).unwrap_or(1.0)]
}

/// A normal farther than this from every axis is oblique.
const OBLIQUE_DEGREES: f64 = 10.0;

/// How slices lie whose columns and rows run along the first two axes of `patient_from_voxel`.
pub(crate) fn orientation_words(patient_from_voxel: DMat3) -> String {
    let Some(normal) = patient_from_voxel.x_axis.cross(patient_from_voxel.y_axis).try_normalize() else {
        return String::new();
    };
    let planes = [(DVec3::X, "sagittal"), (DVec3::Y, "coronal"), (DVec3::Z, "axial")];
    let along = |axis: DVec3| normal.dot(axis).abs();
    let (axis, plane) =
        planes.into_iter().max_by(|a, b| along(a.0).total_cmp(&along(b.0))).expect("there are three");
    let off = along(axis).min(1.0).acos().to_degrees();
    if off > OBLIQUE_DEGREES { format!("oblique {plane}") } else { plane.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_have_their_names() {
        let words = |x, y| orientation_words(DMat3::from_cols(x, y, x.cross(y)));
        assert_eq!(words(DVec3::X, DVec3::Y), "axial");
        assert_eq!(words(DVec3::Y, -DVec3::Z), "sagittal");
        assert_eq!(words(-DVec3::X, DVec3::Z * 2.0), "coronal");
        assert_eq!(words(DVec3::X, DVec3::new(0.0, 0.948, -0.317)), "oblique axial");
    }

    #[test]
    fn thumbnails_keep_the_shape_of_the_slice() {
        let values: Vec<f64> = (0..8 * 4).map(f64::from).collect();
        let small = Thumbnail::new(&values, [8, 4], [1.0, 2.0], Some([0.0, 31.0]), 4);
        assert_eq!((small.width, small.height), (4, 4));
        assert_eq!((small.grey[0], small.grey[15]), (4, 251));
        // Never larger than the slice.
        let same = Thumbnail::new(&values, [8, 4], [1.0, 1.0], None, 256);
        assert_eq!((same.width, same.height), (8, 4));
        assert_eq!((same.grey[0], same.grey[31]), (0, 255));
        let one = Thumbnail::new(&[5.0], [1, 1], [1.0, 1.0], None, 256);
        assert_eq!(one.grey.len(), 1);
    }
}
