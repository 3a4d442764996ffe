//! DICOM: files to a volume at its true place in the patient.
//!
//! The walk: [`scan`](scan::scan) finds files and reads their headers ([`elements`], [`header`]), [`series`] sorts
//! images into stacks and chooses one, [`pixels`] decodes it ([`codec`]), and [`geometry`] makes an even grid of it.
//!
//! Structure and headers are read by Lumivox itself, within bounds that no file can widen; compressed frames go to the
//! decoders that dicom-rs uses too.

mod attributes;
mod codec;
mod elements;
mod geometry;
mod header;
mod pixels;
mod resample;
mod rle;
mod scan;
mod series;
mod source;
mod values;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use lumivox_core::{CancelToken, Progress, Volume};
use scan::Scan;
pub(crate) use scan::files_below;

use crate::{ImportError, ImportOptions, ImportReport, Imported, SeriesSummary, SkippedFile, scan as single};

/// Loads a volume from DICOM files, folders with all that is in them, and zip archives.
///
/// # Errors
/// [`ImportError`] when nothing of it makes a volume, when a path cannot be read, and on cancel.
pub(crate) fn load(
    paths: &[PathBuf],
    options: &ImportOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Imported, ImportError> {
    let scan = scan::scan(paths, progress, cancel)?;
    load_scan(paths, scan, options, progress, cancel)
}

/// Loads a volume from a folder of DICOM files; `None` if there are none in it.
///
/// # Errors
/// As [`load`].
pub(crate) fn load_folder(
    folder: &Path,
    options: &ImportOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Option<Imported>, ImportError> {
    let paths = [folder.to_owned()];
    let scan = scan::scan(&paths, progress, cancel)?;
    if scan.images.is_empty() && !scan.rejected.iter().any(scan::Rejected::is_dicom) {
        return Ok(None);
    }
    load_scan(&paths, scan, options, progress, cancel).map(Some)
}

/// Whether a file's first bytes are those of a DICOM file, if need be one without preamble or prefix.
pub(crate) fn is_dicom(path: &Path) -> bool {
    // Opening a pipe might wait for ever.
    path.is_file() && elements::is_dicom(&source::Source::File(path.to_owned()))
}

fn load_scan(
    paths: &[PathBuf],
    scan: Scan,
    options: &ImportOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Imported, ImportError> {
    let Scan { images: files, rejected } = scan;
    let path = paths.first().cloned().unwrap_or_default();
    let (stacks, left_out) = series::stacks(&files);
    let mut skipped: Vec<SkippedFile> = rejected.iter().map(scan::Rejected::skipped).collect();
    skipped.extend(left_out);
    if stacks.is_empty() {
        let count = files.len() + rejected.len();
        return Err(match (count, rejected.into_iter().next()) {
            // The one file's own error says more than that there is no series.
            (1, Some(only)) => only.error,
            _ => ImportError::NoSeries { path, files: count, detail: commonest_reason(&skipped) },
        });
    }
    let summaries: Vec<_> = stacks.iter().map(|stack| stack.summary(&files)).collect();
    let chosen = match &options.series {
        None => 0,
        Some(wanted) => {
            let path = path.clone();
            let wanted = wanted.clone();
            match series::choose(&stacks, &files, &wanted)[..] {
                [chosen] => chosen,
                [] => {
                    let available = list(&summaries, 0..summaries.len());
                    return Err(ImportError::NoSuchSeries { path, wanted, available });
                }
                ref several => {
                    let candidates = list(&summaries, several.iter().copied());
                    return Err(ImportError::AmbiguousSeries { path, wanted, candidates });
                }
            }
        }
    };
    let stack = &stacks[chosen];
    let decoded = pixels::decode(&files, stack, progress, cancel)?;

    let mut notes = stack.notes.clone();
    for slice in &stack.slices {
        for note in &files[slice.file].notes {
            if !notes.contains(note) {
                notes.push(note.clone());
            }
        }
    }
    let mut places = stack.places.clone();
    let format = &stack.first(&files).format;
    let frame_len = format.columns * format.rows;
    let mut voxels = decoded.voxels;
    if !decoded.failed.is_empty() {
        let mut keep = vec![true; places.len()];
        decoded.failed.iter().for_each(|(slice, _)| keep[*slice] = false);
        if !keep.contains(&true) {
            let (_, error) = decoded.failed.into_iter().next().expect("some slice failed");
            return Err(error);
        }
        notes.push(format!("{} of {} slices could not be decoded", decoded.failed.len(), places.len()));
        skipped.extend(decoded.failed.into_iter().map(|(slice, error)| {
            let path = files[stack.slices[slice].file].source.path();
            scan::Rejected { path, error }.skipped()
        }));
        voxels = resample::keep_slices(voxels, frame_len, &keep);
        let mut kept = keep.iter();
        places.retain(|_| *kept.next().expect("one flag per slice"));
    }
    let most_slices = most_slices(places.len(), frame_len * voxels.bytes_per_sample());
    let grid = geometry::even_grid(&stack.plane, &places, most_slices);
    notes.extend(grid.notes);
    let mut depth = places.len();
    if let Some(sources) = grid.sources {
        depth = sources.len();
        voxels = resample::interpolate(&voxels, frame_len, &sources, cancel)?;
    }
    let dims = [format.columns, format.rows, depth];
    let modality = stack.first(&files).modality;
    single::check_spacing(&path, grid.patient_from_voxel)?;
    let volume = Volume::new(dims, voxels, decoded.rescale, grid.patient_from_voxel, modality)
        .map_err(|source| ImportError::Volume { path, source })?;
    notes.extend(single::remarks(&volume));
    let report = ImportReport { format: "DICOM".to_owned(), series: summaries, chosen, notes, skipped };
    Ok(Imported { volume, report })
}

/// Some of `series`, each with its place in the list, for a message.
fn list(series: &[SeriesSummary], places: impl Iterator<Item = usize>) -> String {
    let entry = |k: usize| format!("{} ({}; {})", k + 1, series[k].description, series[k].id);
    places.map(entry).collect::<Vec<_>>().join(", ")
}

/// How many slices filling gaps may make of `slices`: a quarter more in any case, else as memory allows.
fn most_slices(slices: usize, slice_bytes: usize) -> usize {
    const ALWAYS: usize = 4 << 30;
    (slices + slices / 4 + 1).max((slices * 8).min(ALWAYS / slice_bytes))
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
