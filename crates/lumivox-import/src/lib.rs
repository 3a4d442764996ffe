//! Files to volumes: DICOM, NIfTI, NRRD, MetaImage and RAW, with progress, cancel and a report.
//!
//! [`load`] recognises a format from the content of what it is given, never from the name alone. It is the second
//! stop of the walk: files -> [`load`] -> [`Volume`].
//!
//! Nothing a file says is believed before it is checked: sizes against what is there, numbers for being finite.

mod axes;
mod dicom;
mod environment_file;
mod error;
mod format;
mod metaimage;
mod nifti;
mod nrrd;
mod payload;
mod radiance;
mod raw;
mod report;
mod sample;
mod scan;
mod text_header;
mod transfer_function_file;

use std::path::{Path, PathBuf};

pub use axes::{PatientAxes, UnknownAxes};
pub use environment_file::load_environment;
pub use error::ImportError;
use format::Format;
use lumivox_core::{CancelToken, Progress, Volume};
pub use raw::{RawDescription, RawDescriptionError, load_raw};
pub use report::{ImportReport, SeriesSummary, SkippedFile};
pub use sample::{SampleType, UnknownSampleType};
pub use transfer_function_file::{load_transfer_function, save_transfer_function};

/// What to load when there is a choice.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ImportOptions {
    /// A 1-based position in [`ImportReport::series`], else a DICOM SeriesInstanceUID, else a series number that no
    /// other series has; `None` takes the first, which is the best.
    pub series: Option<String>,
    /// What the bytes of a file mean that no other reader knows.
    pub raw: Option<RawDescription>,
}

/// A scan and what became of its files.
#[derive(Debug)]
#[non_exhaustive]
pub struct Imported {
    /// The scan.
    pub volume: Volume,
    /// How it was read.
    pub report: ImportReport,
}

/// Loads the volume in `paths`: one file of any format, a folder, a zip archive, or several DICOM files.
///
/// A folder is a DICOM study with all that is in it; one without any DICOM may hold one volume of another format. Of
/// several series the best is loaded (with depth, then CT, MR or PET, then the most voxels), unless
/// [`ImportOptions::series`] names another.
///
/// # Errors
/// [`ImportError`] names the file, what is wrong and what to do.
pub fn load(
    paths: &[PathBuf],
    options: &ImportOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Imported, ImportError> {
    let mut imported = match paths {
        [folder] if folder.is_dir() => match dicom::load_folder(folder, options, progress, cancel)? {
            Some(imported) => imported,
            None => load_file(&only_volume_in(folder, options, cancel)?, options, progress, cancel)?,
        },
        [file] => load_file(file, options, progress, cancel)?,
        _ => dicom::load(paths, options, progress, cancel)?,
    };
    imported.report.notes.extend(unused(options, &imported.report.format));
    Ok(imported)
}

/// Notes on options that a file of this format has no use for.
fn unused(options: &ImportOptions, format: &str) -> Vec<String> {
    let mut notes = Vec::new();
    if options.series.is_some() && format != "DICOM" {
        notes.push(format!("--series was not used: a {format} file holds one image"));
    }
    if options.raw.is_some() && format != "RAW" {
        notes.push(format!("--raw was not used: {format} describes itself"));
    }
    notes
}

/// Loads a single file.
fn load_file(
    path: &Path,
    options: &ImportOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Imported, ImportError> {
    let format = match (&options.raw, format::recognise(path)) {
        (Some(description), Ok(Format::Raw)) => return load_raw(path, description, progress, cancel),
        (Some(description), Err(error)) if !matches!(error, ImportError::Io { .. }) => {
            return load_raw(path, description, progress, cancel);
        }
        // The DICOM reader knows more ways to begin a file, if it has to.
        (None, Err(ImportError::UnknownFormat { .. })) if dicom::is_dicom(path) => Format::Dicom,
        (_, format) => format?,
    };
    match format {
        Format::Dicom | Format::Zip => dicom::load(&[path.to_owned()], options, progress, cancel),
        Format::Nifti => nifti::load(path, progress, cancel),
        Format::Nrrd => nrrd::load(path, progress, cancel),
        Format::MetaImage => metaimage::load(path, progress, cancel),
        Format::Raw => raw::load(path, progress, cancel),
    }
}

/// The one file of a folder without DICOM that is a volume; if there is none, the one that [`ImportOptions::raw`] can
/// only mean.
fn only_volume_in(
    folder: &Path,
    options: &ImportOptions,
    cancel: &CancelToken,
) -> Result<PathBuf, ImportError> {
    let all = dicom::files_below(folder, cancel)?;
    let volumes: Vec<&PathBuf> = all.iter().filter(|file| format::recognise(file).is_ok()).collect();
    match (&volumes[..], &all[..]) {
        ([only], _) => Ok(only.to_path_buf()),
        ([], [only]) if options.raw.is_some() => Ok(only.clone()),
        ([], _) => Err(ImportError::NoSeries {
            path: folder.to_owned(),
            files: all.len(),
            detail: match &options.raw {
                Some(_) => "Open the one that --raw describes",
                None => "None is of a format that Lumivox reads",
            }
            .to_owned(),
        }),
        (several, _) => Err(ImportError::Unsupported {
            path: folder.to_owned(),
            what: format!("it holds {} volumes", several.len()),
            remedy: "Open one of its files".to_owned(),
        }),
    }
}
