//! Several files as one label map: folders with a mask for each organ, segmentations beside each other.
//!
//! Grids are parts of one where their axes are the same and their voxels lie on each other's, so that labels move by whole
//! voxels and are never interpolated.

use std::path::{Path, PathBuf};

use lumivox_core::{
    CancelToken, Label, LabelVolume, Progress, WorkStage,
    glam::{DAffine3, DVec3},
};

use super::{
    ImportedLabels, LabelFile, finish_volume, load_one, no_labels,
    table::{Table, clean},
    values::{MOST_LABELS, NoLabels},
};
use crate::{
    ImportOptions, ImportReport, choice::volumes_in, claims::Claims, colors, dicom, error::ImportError,
    payload::too_many_voxels, zarr,
};

/// How far from a whole number of voxels grids may lie beside each other: headers round.
const WHOLE: f64 = 0.02;
/// The grid around all may always have so many voxels, and beyond it so many times those of the files.
const ALWAYS: usize = 64 << 20;
const TIMES: usize = 8;
/// Files that a note names.
const MOST_NAMED: usize = 8;

/// Where labels lie.
#[derive(Clone, Copy, Debug)]
struct Grid {
    dims: [usize; 3],
    patient_from_voxel: DAffine3,
}

/// A file, before its voxels are wanted.
struct Part {
    path: PathBuf,
    grid: Grid,
    /// Of DICOM, whose grid is known once it is read.
    loaded: Option<ImportedLabels>,
}

/// Loads one label map of files and folders. `given` names labels.
pub(super) fn load(
    paths: &[PathBuf],
    import: &ImportOptions,
    given: Option<Table>,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<ImportedLabels, ImportError> {
    let mut files = Vec::new();
    for path in paths {
        let is_study = !crate::files::is_dir(path)
            || zarr::is_zarr(path)
            || dicom::Study::open(std::slice::from_ref(path), Progress::SILENT, cancel)?.is_dicom();
        if is_study {
            files.push(path.clone());
        } else {
            files.extend(volumes_in(path, import, cancel)?);
        }
    }
    match &files[..] {
        [only] => load_one(only, import, given.as_ref(), progress, cancel),
        _ => {
            let from_folder = files.len() > paths.len();
            join(&files, from_folder, import, given.as_ref(), progress, cancel)
        }
    }
}

/// Joins the labels of several files.
fn join(
    files: &[PathBuf],
    from_folder: bool,
    import: &ImportOptions,
    given: Option<&Table>,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<ImportedLabels, ImportError> {
    let parts: Vec<Part> = files.iter().map(|path| part(path, import, cancel)).collect::<Result<_, _>>()?;
    let first = &parts[0];
    let (grid, offsets) = around(&parts)?;
    let count = grid.dims.iter().product();
    let mut claims = Claims::new(count).map_err(|_| too_many_voxels(&first.path, grid.dims))?;
    let mut joined = Joined::default();
    let (n, header) = (parts.len(), first.path.clone());
    for (k, (part, offset)) in parts.into_iter().zip(offsets).enumerate() {
        progress.report(WorkStage::Decoding, k as u64, n as u64);
        cancel.check()?;
        let loaded = match part.loaded {
            Some(loaded) => Ok(loaded),
            None => load_one(&part.path, import, None, Progress::SILENT, cancel),
        };
        let loaded = match loaded {
            // A folder may hold the scan itself beside its masks.
            Err(ImportError::Unsupported { .. }) if from_folder => {
                joined.left_out += 1;
                continue;
            }
            loaded => loaded?,
        };
        joined.add(&part.path, loaded, &mut claims, (grid.dims, offset), given)?;
    }
    progress.report(WorkStage::Decoding, n as u64, n as u64);
    joined.finish(&header, claims, grid, n)
}

/// What a file says of its grid.
fn part(path: &Path, import: &ImportOptions, cancel: &CancelToken) -> Result<Part, ImportError> {
    let (grid, loaded) = match LabelFile::open(path, import)? {
        Some(file) => {
            let LabelFile { single, .. } = file;
            (Grid { dims: single.dims, patient_from_voxel: single.patient_from_voxel }, None)
        }
        None => {
            let loaded = load_one(path, import, None, Progress::SILENT, cancel)?;
            let labels = &loaded.labels;
            let grid = Grid { dims: labels.dims(), patient_from_voxel: labels.patient_from_voxel() };
            (grid, Some(loaded))
        }
    };
    Ok(Part { path: path.to_owned(), grid, loaded })
}

/// The grid around those of all parts, and where in it each of these begins.
fn around(parts: &[Part]) -> Result<(Grid, Vec<[usize; 3]>), ImportError> {
    let first = parts[0].grid;
    let starts: Vec<[i64; 3]> = parts.iter().map(|part| start_in(first, part)).collect::<Result<_, _>>()?;
    let low: [i64; 3] = std::array::from_fn(|axis| starts.iter().map(|start| start[axis]).min().unwrap_or(0));
    let end = |axis: usize| {
        let ends = parts.iter().zip(&starts).map(|(part, start)| start[axis] + part.grid.dims[axis] as i64);
        ends.max().unwrap_or(1)
    };
    let dims: [usize; 3] = std::array::from_fn(|axis| (end(axis) - low[axis]) as usize);
    let of_files = parts.iter().fold(0usize, |sum, part| sum.saturating_add(part.grid.dims.iter().product()));
    let most = ALWAYS.max(of_files.saturating_mul(TIMES));
    let count = dims.iter().try_fold(1usize, |n, side| n.checked_mul(*side));
    if count.is_none_or(|count| count > most) {
        return Err(apart(
            &parts[0].path,
            "so far apart that hardly a voxel of a grid around all would be in one",
        ));
    }
    let origin = DVec3::from_array(low.map(|start| start as f64));
    let shift = DAffine3::from_translation(origin);
    let grid = Grid { dims, patient_from_voxel: first.patient_from_voxel * shift };
    let offsets = starts.iter().map(|start| std::array::from_fn(|axis| (start[axis] - low[axis]) as usize));
    Ok((grid, offsets.collect()))
}

/// The voxel of `first` in which a part's first one lies.
fn start_in(first: Grid, part: &Part) -> Result<[i64; 3], ImportError> {
    /// Voxels that no grid is beside another.
    const FAR: f64 = 1e6;
    let relative = first.patient_from_voxel.inverse() * part.grid.patient_from_voxel;
    // A whole grid long, what the axes differ by must be less than a voxel, too.
    let far = DVec3::from_array(part.grid.dims.map(|side| side.saturating_sub(1) as f64));
    let [start, end] = [DVec3::ZERO, far].map(|corner| relative.transform_point3(corner) - corner);
    let rounded = start.round();
    let is_whole = |at: DVec3| (at - rounded).abs().max_element() < WHOLE;
    if !(is_whole(start) && is_whole(end) && rounded.abs().max_element() < FAR) {
        return Err(apart(
            &part.path,
            "on a grid of its own, whose voxels are not those of the first label map",
        ));
    }
    Ok(rounded.to_array().map(|at| at as i64))
}

fn apart(path: &Path, what: &str) -> ImportError {
    ImportError::Unsupported {
        path: path.to_owned(),
        what: format!("labels {what}"),
        remedy: "Export all of them on the grid of one scan".to_owned(),
    }
}

/// The labels of several files.
#[derive(Default)]
struct Joined {
    labels: Vec<Label>,
    report: Option<ImportReport>,
    /// Labels in whose files nothing is set.
    empty: Vec<String>,
    /// Files of a folder that are no label maps.
    left_out: usize,
}

impl Joined {
    /// Adds the labels of a file, whose grid begins at `offset` of one of `dims`.
    fn add(
        &mut self,
        path: &Path,
        loaded: ImportedLabels,
        claims: &mut Claims,
        (dims, offset): ([usize; 3], [usize; 3]),
        given: Option<&Table>,
    ) -> Result<(), ImportError> {
        let ImportedLabels { labels, numbers, report } = loaded;
        let stem = clean(&stem(path));
        let mut finals = [0u16; 256];
        for label in labels.labels() {
            let number =
                numbers.iter().find(|(_, value)| *value == label.value).map_or(0, |(number, _)| *number);
            let has_own = label.name != format!("label {number}");
            let name = match (has_own, labels.labels().len()) {
                (true, _) => label.name.clone(),
                (false, 1) => stem.clone(),
                (false, _) => format!("{stem} {number}"),
            };
            let color = (label.color != colors::default_color(label.value)).then_some(label.color);
            finals[usize::from(label.value)] = self.push(path, name, color, given)?.into();
        }
        if labels.labels().is_empty() {
            // It is known by its name all the same, and draws nothing.
            self.push(path, stem.clone(), None, given)?;
            self.empty.push(stem);
        }
        let [columns, rows, _] = labels.dims();
        for (row, values) in labels.voxels().chunks_exact(columns).enumerate() {
            let (y, z) = (row % rows + offset[1], row / rows + offset[2]);
            let start = (z * dims[1] + y) * dims[0] + offset[0];
            for (x, value) in values.iter().enumerate().filter(|(_, value)| **value != 0) {
                claims.add(start + x, finals[usize::from(*value)]);
            }
        }
        self.report.get_or_insert(report);
        Ok(())
    }

    /// Adds a label; its number.
    fn push(
        &mut self,
        path: &Path,
        name: String,
        color: Option<[f64; 3]>,
        given: Option<&Table>,
    ) -> Result<u8, ImportError> {
        if self.labels.len() == MOST_LABELS {
            return Err(no_labels(path, NoLabels::TooMany));
        }
        let value = self.labels.len() as u8 + 1;
        let listed = given.and_then(|table| table.get(&value.into()));
        let name = listed.map_or(name, |entry| entry.name.clone());
        let color = listed.and_then(|entry| entry.color).or(color);
        self.labels.push(Label { value, name, color: color.unwrap_or_else(|| colors::default_color(value)) });
        Ok(value)
    }

    fn finish(
        self,
        path: &Path,
        claims: Claims,
        grid: Grid,
        files: usize,
    ) -> Result<ImportedLabels, ImportError> {
        let Self { labels, report, empty, left_out } = self;
        let Some(mut report) = report else { return Err(no_labels(path, NoLabels::None)) };
        let settled = claims.settle();
        let name = |number: u16| labels[usize::from(number) - 1].name.clone();
        let mut notes = vec![format!("{} labels of {} files", labels.len(), files - left_out)];
        if left_out > 0 {
            notes.push(format!("{left_out} of {files} files hold no labels, and are left out"));
        }
        if !empty.is_empty() {
            let mut named: Vec<String> = empty.iter().take(MOST_NAMED).cloned().collect();
            named.extend((empty.len() > MOST_NAMED).then(|| format!("{} more", empty.len() - MOST_NAMED)));
            notes.push(format!("nothing is set in the masks of {}", named.join(", ")));
        }
        notes.extend(settled.notes(name));
        let voxels: Vec<u8> = settled.voxels.into_iter().map(|label| label as u8).collect();
        report.notes = notes.clone();
        if let Some(series) = report.series.get_mut(report.chosen) {
            let [x, y, z] = grid.dims;
            series.dims = grid.dims;
            series.files = files - left_out;
            series.description = format!("{x} x {y} x {z}, labels of {} files", files - left_out);
            series.notes = notes;
        }
        let numbers = labels.iter().map(|label| (i128::from(label.value), label.value)).collect();
        let labels: Result<LabelVolume, ImportError> =
            finish_volume(path, grid.dims, grid.patient_from_voxel, voxels, labels, &mut report);
        Ok(ImportedLabels { labels: labels?, numbers, report })
    }
}

/// A file's name without what says its format.
fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let lower = name.to_ascii_lowercase();
    let end = super::table::ENDINGS.iter().find(|ending| lower.ends_with(**ending));
    match end {
        Some(ending) => name[..name.len() - ending.len()].to_owned(),
        None => Path::new(&*name).file_stem().unwrap_or_default().to_string_lossy().into_owned(),
    }
}
