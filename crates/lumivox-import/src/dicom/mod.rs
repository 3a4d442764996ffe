//! DICOM: files to a volume at its true place in the patient.
//!
//! The walk: [`scan`](scan::scan) finds files and reads their headers ([`elements`], [`header`]), [`series`] sorts
//! images into stacks and [`phases`], [`pixels`] decodes one ([`codec`]), and [`geometry`] makes an even grid of it.
//!
//! Structure and headers are read by Lumivox itself, within bounds that no file can widen; compressed frames go to the
//! decoders that dicom-rs uses too.

mod attributes;
pub(crate) mod codec;
mod convert;
mod elements;
mod frames;
mod geometry;
mod header;
mod jpeg_extended;
mod mosaic;
mod phases;
mod pixels;
mod quantity;
mod resample;
mod rle;
mod scan;
mod segmentation;
mod series;
mod source;
mod stored;
mod values;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use header::ImageFile;
use lumivox_core::{CancelToken, Modality, Progress, Volume, Voxels};
use scan::Rejected;
pub(crate) use scan::files_below;
use series::Stack;

use crate::{
    ImportError, ImportOptions, ImportReport, Imported, SeriesSummary, SkippedFile, Thumbnail, scan as single,
};

/// What the headers of DICOM files say, before any pixel is read.
pub(crate) struct Study {
    /// The path to name in errors.
    path: PathBuf,
    files: Vec<ImageFile>,
    /// What is no usable image.
    rejected: Vec<Rejected>,
    stacks: Vec<Stack>,
    summaries: Vec<SeriesSummary>,
    skipped: Vec<SkippedFile>,
}

/// Whether a file's first bytes are those of a DICOM file, if need be one without preamble or prefix.
pub(crate) fn is_dicom(path: &Path) -> bool {
    // Opening a pipe might wait for ever.
    path.is_file() && elements::is_dicom(&source::Source::File(path.to_owned()))
}

impl Study {
    /// Reads the headers of DICOM files, folders with all that is in them, and zip archives.
    ///
    /// # Errors
    /// When a path cannot be read, when the only file is no image, and on cancel.
    pub(crate) fn open(
        paths: &[PathBuf],
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<Self, ImportError> {
        let scan::Scan { images: files, mut rejected } = scan::scan(paths, progress, cancel)?;
        if files.is_empty() && rejected.len() == 1 && !paths.iter().any(|path| path.is_dir()) {
            // The one file's own error says more than that there is no series.
            return Err(rejected.remove(0).error);
        }
        let (stacks, left_out) = series::stacks(&files);
        let mut skipped: Vec<SkippedFile> = rejected.iter().map(Rejected::skipped).collect();
        skipped.extend(left_out);
        let summaries = stacks.iter().map(|stack| stack.summary(&files)).collect();
        let path = paths.first().cloned().unwrap_or_default();
        Ok(Self { path, files, rejected, stacks, summaries, skipped })
    }

    /// Whether there is any DICOM in it.
    pub(crate) fn is_dicom(&self) -> bool {
        !self.files.is_empty() || self.rejected.iter().any(Rejected::is_dicom)
    }

    /// The position of the series that `options` name.
    ///
    /// # Errors
    /// When there is no series, or none or several of that name.
    fn choose(&mut self, options: &ImportOptions) -> Result<usize, ImportError> {
        let path = self.path.clone();
        if self.stacks.is_empty() {
            let files = self.files.len() + self.rejected.len();
            return Err(match self.rejected.len() {
                1 if files == 1 => self.rejected.remove(0).error,
                _ => ImportError::NoSeries { path, files, detail: commonest_reason(&self.skipped) },
            });
        }
        let Some(wanted) = options.series.clone() else { return Ok(0) };
        match series::choose(&self.stacks, &self.files, &wanted)[..] {
            [chosen] => Ok(chosen),
            [] => {
                let available = list(&self.summaries, 0..self.summaries.len());
                Err(ImportError::NoSuchSeries { path, wanted, available })
            }
            ref several => {
                let candidates = list(&self.summaries, several.iter().copied());
                Err(ImportError::AmbiguousSeries { path, wanted, candidates })
            }
        }
    }

    /// What was found.
    ///
    /// # Errors
    /// When `options` name a series that is not there. A study without any series is no error here.
    pub(crate) fn report(&mut self, options: &ImportOptions) -> Result<ImportReport, ImportError> {
        let chosen = if self.stacks.is_empty() { 0 } else { self.choose(options)? };
        Ok(ImportReport {
            format: FORMAT.to_owned(),
            notes: self.summaries.get(chosen).map(|series| series.notes.clone()).unwrap_or_default(),
            series: self.summaries.clone(),
            chosen,
            skipped: self.skipped.clone(),
        })
    }

    /// Loads the series and phase that `options` name.
    ///
    /// # Errors
    /// [`ImportError`] when nothing of it makes a volume, and on cancel.
    pub(crate) fn load(
        &mut self,
        options: &ImportOptions,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<Imported, ImportError> {
        let chosen = self.choose(options)?;
        let (files, stack, path) = (&self.files, &self.stacks[chosen], self.path.clone());
        let mut skipped = self.skipped.clone();
        let number = phase_number(stack, options, &path)?;
        let phase = &stack.phases[number];
        let format = &stack.first(files).format;
        let slice_len = format.columns * format.rows;
        let mut phase = phase.clone();
        let mut notes = stack.all_notes(files, &phase);
        let is_labels = stack.first(files).segmentation.is_some();
        let decoded = if is_labels {
            let (decoded, more) = segmentation::decode(files, stack, progress, cancel)?;
            notes.extend(more);
            decoded
        } else {
            pixels::decode(files, &phase.slices, progress, cancel)?
        };
        if stack.phases.len() > 1 {
            notes.push(format!(
                "phase {} of {} is taken (told apart by {})",
                number + 1,
                stack.phases.len(),
                stack.told_by
            ));
        }
        let mut voxels = decoded.voxels;
        if !decoded.failed.is_empty() {
            let total = phase.places.len();
            let mut keep = vec![true; total];
            decoded.failed.iter().for_each(|(slice, _)| keep[*slice] = false);
            if !keep.contains(&true) {
                let (_, error) = decoded.failed.into_iter().next().expect("some slice failed");
                return Err(error);
            }
            notes.push(format!("{} of {total} slices could not be decoded", decoded.failed.len()));
            skipped.extend(decoded.failed.into_iter().map(|(slice, error)| {
                let path = files[phase.slices[slice].file].source.path();
                Rejected { path, error }.skipped()
            }));
            voxels = resample::keep_slices(voxels, slice_len, &keep);
            let mut kept = keep.iter();
            phase.places.retain(|_| *kept.next().expect("one flag per slice"));
        }
        let grid = stack.grid(files, &phase, voxels.bytes_per_sample());
        notes.extend(grid.notes);
        let mut depth = phase.places.len();
        if let Some(sources) = grid.sources {
            depth = sources.len();
            voxels = if is_labels {
                resample::leave_gaps(&voxels, slice_len, &sources, 0.0)
            } else if options.leave_gaps && grid.has_gaps {
                notes.iter_mut().for_each(|note| *note = note.replace(geometry::FILLED_IN, "left empty"));
                let [slope, intercept] = decoded.rescale;
                let lowest = match stack.first(files).modality {
                    Modality::Ct => (pixels::AIR_HU - intercept) / slope,
                    _ => (0..voxels.len()).map(|i| voxels.get(i)).reduce(f64::min).unwrap_or(0.0),
                };
                resample::leave_gaps(&voxels, slice_len, &sources, lowest)
            } else {
                resample::interpolate(&voxels, slice_len, &sources, cancel)?
            };
        }
        let dims = [format.columns, format.rows, depth];
        let modality = if is_labels { Modality::Other } else { stack.first(files).modality };
        single::check_spacing(&path, grid.patient_from_voxel)?;
        cancel.check()?;
        let volume = Volume::new(dims, voxels, decoded.rescale, grid.patient_from_voxel, modality)
            .map_err(|source| ImportError::Volume { path, source })?;
        notes.extend(single::remarks(&volume));
        let report = ImportReport {
            format: FORMAT.to_owned(),
            series: self.summaries.clone(),
            chosen,
            notes,
            skipped,
        };
        Ok(Imported { volume, report })
    }

    /// The middle slice of a series, by its position in the report.
    ///
    /// # Errors
    /// When no slice near the middle can be decoded, and on cancel.
    pub(crate) fn thumbnail(
        &self,
        series: usize,
        side: usize,
        cancel: &CancelToken,
    ) -> Result<Thumbnail, ImportError> {
        let stack = &self.stacks[series];
        let first = stack.first(&self.files);
        let (format, spacing) = (&first.format, stack.plane.spacing_mm.to_array());
        let slice_len = format.columns * format.rows;
        let picture = |voxels: &Voxels, [slope, intercept]: [f64; 2], slice: usize, window| {
            let value = |i| voxels.get(slice * slice_len + i) * slope + intercept;
            let values: Vec<f64> = (0..slice_len).map(value).collect();
            Thumbnail::new(&values, [format.columns, format.rows], spacing, window, side)
        };
        let slices = &stack.phases[0].slices;
        let middle = slices.len() / 2;
        if first.segmentation.is_some() {
            let (decoded, _) = segmentation::decode(&self.files, stack, Progress::SILENT, cancel)?;
            return Ok(picture(&decoded.voxels, decoded.rescale, middle, None));
        }
        // Soft tissue and bone, where values are absolute.
        let window = (first.unit == "HU").then_some([-200.0, 500.0]);
        let mut fault = None;
        for slice in (middle..slices.len()).chain((0..middle).rev()).take(MOST_TRIED) {
            let mut decoded = pixels::decode(&self.files, &[slices[slice]], Progress::SILENT, cancel)?;
            match decoded.failed.pop() {
                None => return Ok(picture(&decoded.voxels, decoded.rescale, 0, window)),
                Some((_, error)) => fault = fault.or(Some(error)),
            }
        }
        Err(fault.expect("a stack has a slice"))
    }
}

const FORMAT: &str = "DICOM";

/// Slices that are tried for a thumbnail where some are damaged.
const MOST_TRIED: usize = 8;

/// The position of the phase that `options` name; by default the first of those that have the most slices.
fn phase_number(stack: &Stack, options: &ImportOptions, path: &Path) -> Result<usize, ImportError> {
    let there = stack.phases.len();
    match options.phase {
        None => {
            let most = stack.phases.iter().map(|phase| phase.slices.len()).max();
            Ok(stack.phases.iter().position(|phase| Some(phase.slices.len()) == most).unwrap_or(0))
        }
        Some(wanted @ 1..) if wanted <= there => Ok(wanted - 1),
        Some(wanted) => Err(ImportError::NoSuchPhase { path: path.to_owned(), wanted, phases: there }),
    }
}

/// Some of `series`, each with its place in the list, for a message.
fn list(series: &[SeriesSummary], places: impl Iterator<Item = usize>) -> String {
    let entry = |k: usize| format!("{} ({}; {})", k + 1, series[k].description, series[k].id);
    places.map(entry).collect::<Vec<_>>().join(", ")
}

/// The reason that most files were left out for, as a sentence.
fn commonest_reason(skipped: &[SkippedFile]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for file in skipped {
        *counts.entry(&file.reason).or_default() += 1;
    }
    match counts.into_iter().max_by_key(|&(_, count)| count) {
        Some((reason, count)) => format!("{count} left out: {reason}"),
        None => "It is empty".to_owned(),
    }
}
