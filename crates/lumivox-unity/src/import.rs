//! What an import is told, and what becomes of a scan that was read.

use std::ffi::c_char;
use std::path::{Path, PathBuf};

use lumivox_core::{CancelToken, Cancelled, Progress};
use lumivox_import::{ImportError, ImportOptions, Imported, ImportedLabels, LabelOptions, RawDescription};
use lumivox_segmentation::Surroundings;

use crate::abi::LumivoxImportOptions;
use crate::border::{Outcome, list, path, text};

/// The files that an import reads.
///
/// # Safety
/// `paths` points to `count` strings.
pub unsafe fn files(paths: *const *const c_char, count: u32) -> Outcome<Vec<PathBuf>> {
    // SAFETY: as the caller promises.
    let paths = unsafe { list(paths, count as usize, "paths") }?;
    // SAFETY: as the caller promises.
    let paths: Vec<PathBuf> =
        paths.iter().map(|file| unsafe { path(*file, "path") }).collect::<Outcome<_>>()?;
    match paths.is_empty() {
        true => Err("there is nothing to read: name a file, a folder or an archive".to_owned()),
        false => Ok(paths),
    }
}

/// The patient alone: what lies around in a CT becomes air, is kept beside it, and the report says so.
pub fn without_things(
    mut imported: Imported,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<(Imported, Option<Surroundings>), Cancelled> {
    let alone = lumivox_segmentation::patient_alone(imported.volume, progress, cancel)?;
    if let Some(note) = alone.note() {
        let more = if alone.changed > 0 { " ('Keep Everything' shows it)" } else { "" };
        imported.report.notes.push(format!("{note}{more}"));
    }
    imported.volume = alone.volume;
    Ok((imported, alone.surroundings))
}

/// Whether what lies around the patient is a part of the scan.
///
/// # Safety
/// `options` is null or points to options.
pub unsafe fn keeps_everything(options: *const LumivoxImportOptions) -> bool {
    // SAFETY: as the caller promises.
    unsafe { options.as_ref() }.is_some_and(|options| options.keep_everything != 0)
}

/// Whether the file is a label map: see [`LumivoxImportOptions::labels`].
///
/// # Safety
/// `options` is null or points to options.
pub unsafe fn label_map(options: *const LumivoxImportOptions) -> u32 {
    // SAFETY: as the caller promises.
    unsafe { options.as_ref() }.map_or(0, |options| options.labels)
}

/// A file as a label map.
pub fn read_labels(
    file: &Path,
    options: &ImportOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<ImportedLabels, ImportError> {
    let mut labels = LabelOptions::default();
    labels.import = options.clone();
    lumivox_import::load_labels(file, &labels, progress, cancel)
}

/// All else that the importer is told.
///
/// # Safety
/// `options` is null or points to options.
pub unsafe fn import_options(options: *const LumivoxImportOptions) -> Outcome<ImportOptions> {
    let mut all = ImportOptions::default();
    // SAFETY: as the caller promises.
    let Some(options) = (unsafe { options.as_ref() }) else { return Ok(all) };
    // SAFETY: as the caller promises.
    let (series, raw) = unsafe { (text(options.series, "series")?, text(options.raw, "raw")?) };
    let said = |text: Option<&str>| text.filter(|text| !text.trim().is_empty()).map(str::to_owned);
    all.series = said(series);
    all.phase = (options.phase > 0).then_some(options.phase as usize);
    all.leave_gaps = options.leave_gaps != 0;
    all.fill_damaged = options.fill_damaged != 0;
    all.allow_outside_data = options.allow_outside_data != 0;
    if let Some(raw) = said(raw) {
        all.raw = Some(raw.parse::<RawDescription>().map_err(|error| error.to_string())?);
    }
    Ok(all)
}
