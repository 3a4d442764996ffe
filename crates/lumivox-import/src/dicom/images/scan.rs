//! Finds files and reads their headers.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

use lumivox_core::{CancelToken, Progress, WorkStage};
use rayon::prelude::*;

use crate::{
    ImportError,
    dicom::{
        bytes::source::{Source, is_junk, zip_entries},
        elements::gzip::gzip,
        images::{image_file::ImageFile, read::read_image, rejected::Rejected},
    },
    files,
    format::{Format, sniff},
    payload::GZIP_MAGIC,
};

/// Deeper folders are no study.
const DEEPEST_FOLDER: usize = 32;

/// What a set of files holds.
#[derive(Debug, Default)]
pub(crate) struct Scan {
    /// Images, in the order of their paths.
    pub(crate) images: Vec<ImageFile>,
    /// Everything else, with the reason.
    pub(crate) rejected: Vec<Rejected>,
}

/// Reads the headers of all files in `paths`: files, folders with all that is in them, zip archives.
///
/// # Errors
/// When a path given cannot be read, or on cancel. What lies within folders and archives is rejected instead.
pub(crate) fn scan(
    paths: &[PathBuf],
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Scan, ImportError> {
    let mut scan = Scan::default();
    let mut sources = Vec::new();
    for path in paths {
        if files::metadata(path).map_err(ImportError::io(path))?.is_dir() {
            let Found { files, closed } = files_below(path, cancel)?;
            scan.rejected.extend(closed);
            for file in files {
                cancel.check()?;
                add(&file, &mut sources, &mut scan.rejected, cancel).unwrap_or_else(|error| {
                    scan.rejected.push(Rejected::new(file, error));
                });
            }
        } else {
            add(path, &mut sources, &mut scan.rejected, cancel)?;
        }
    }
    cancel.check()?;
    let total = sources.len() as u64;
    let done = AtomicU64::new(0);
    let results: Vec<_> = sources
        .par_iter()
        .map(|source| {
            cancel.check()?;
            let result = read_image(source, cancel);
            cancel.check()?;
            progress.report(WorkStage::Scanning, done.fetch_add(1, Ordering::Relaxed) + 1, total);
            Ok(result)
        })
        .collect::<Result<_, ImportError>>()?;
    for (source, result) in sources.iter().zip(results) {
        match result {
            Ok(image) => scan.images.push(image),
            Err(rejected) => {
                let Rejected { path, error, series_uid } = *rejected;
                scan.rejected.push(Rejected { path, error: in_archive(source, error), series_uid });
            }
        }
    }
    Ok(scan)
}

/// The error about an entry of an archive, which says what else it is that would be read outside of it.
fn in_archive(source: &Source, error: ImportError) -> ImportError {
    let ImportError::UnknownFormat { path, found } = error else { return error };
    let mut head = [0; 1024];
    let n = match source {
        Source::Entry { .. } => source.open().and_then(|mut input| input.read_up_to(&mut head)).unwrap_or(0),
        Source::File(_) | Source::Gzip { .. } => 0,
    };
    let found = match sniff(&head[..n]) {
        Some(Format::Zip) => "it is a zip archive within the archive; unpack it".to_owned(),
        Some(format) => format!("it is a {} file in an archive; unpack it", format.name()),
        None if head[..n].starts_with(&GZIP_MAGIC) => {
            "it is a gzip archive within the archive; unpack it".to_owned()
        }
        None => found,
    };
    ImportError::UnknownFormat { path, found }
}

/// Adds the file at `path`, or the entries of the archive that it is.
fn add(
    path: &Path,
    sources: &mut Vec<Source>,
    rejected: &mut Vec<Rejected>,
    cancel: &CancelToken,
) -> Result<(), ImportError> {
    let unusable =
        |found: &str| ImportError::UnknownFormat { path: path.to_owned(), found: found.to_owned() };
    // Opening a pipe or a device might wait for ever.
    if !files::metadata(path).map_err(ImportError::io(path))?.is_file() {
        return Err(unusable("it is not a plain file"));
    }
    let source = Source::File(path.to_owned());
    let mut magic = [0; 4];
    source.open().and_then(|mut input| input.read_up_to(&mut magic)).map_err(ImportError::io(path))?;
    if magic.starts_with(&GZIP_MAGIC) {
        match gzip(path, cancel) {
            Ok(Some(unpacked)) => {
                sources.push(unpacked);
                return Ok(());
            }
            Ok(None) => {}
            Err(fault) => {
                cancel.check()?;
                let problem = format!("cannot be unpacked ({fault})");
                let error = ImportError::Damaged { path: path.to_owned(), problem };
                rejected.push(Rejected::new(path.to_owned(), error));
                return Ok(());
            }
        }
    }
    // With entries, or without any.
    if &magic != b"PK\x03\x04" && &magic != b"PK\x05\x06" {
        sources.push(source);
        return Ok(());
    }
    let entries = zip_entries(path)?;
    sources.extend(entries.sources);
    rejected.extend(entries.skipped.into_iter().map(|(path, what)| {
        let error =
            ImportError::Unsupported { path: path.clone(), what, remedy: "Unpack it first".to_owned() };
        Rejected::new(path, error)
    }));
    Ok(())
}

/// What is in a folder and the folders in it.
#[derive(Debug, Default)]
pub(crate) struct Found {
    /// Files, in the order of their paths.
    pub(crate) files: Vec<PathBuf>,
    /// Folders that cannot be read, or not to their end.
    pub(crate) closed: Vec<Rejected>,
}

/// All files in a folder and the folders in it. Links to folders are followed, but to each
/// folder once, and to none that this one lies in.
pub(crate) fn files_below(folder: &Path, cancel: &CancelToken) -> Result<Found, ImportError> {
    let Found { mut files, mut closed } = Found::default();
    let mut folders = vec![(folder.to_owned(), 0)];
    let root = real_folder(folder).map_err(ImportError::io(folder))?;
    let mut seen = HashSet::from([root.clone()]);
    let mut close = |folder: PathBuf, source| {
        let error = ImportError::Io { path: folder.clone(), source };
        closed.push(Rejected::new(folder, error));
    };
    let mut too_deep = Vec::new();
    while let Some((folder, depth)) = folders.pop() {
        let entries = match files::read_dir(&folder) {
            // A folder within that is closed to the user is no reason to give up on the rest.
            Err(error) if depth > 0 => {
                close(folder, error);
                continue;
            }
            result => result.map_err(ImportError::io(&folder))?,
        };
        for entry in entries {
            cancel.check()?;
            let entry = match entry {
                // Some open, and say what is in them no further.
                Err(error) if depth > 0 => {
                    close(folder, error);
                    break;
                }
                result => result.map_err(ImportError::io(&folder))?,
            };
            if is_junk(&entry.name.to_string_lossy()) {
                continue;
            }
            let path = entry.path;
            if entry.is_dir || (entry.is_link && files::is_dir(&path)) {
                let Ok(real) = real_folder(&path) else { continue };
                if depth >= DEEPEST_FOLDER {
                    let error = ImportError::Unsupported {
                        path: path.clone(),
                        what: format!(
                            "a folder more than {DEEPEST_FOLDER} folders deep, in which nothing was looked for"
                        ),
                        remedy: "Open it by itself".to_owned(),
                    };
                    too_deep.push(Rejected::new(path, error));
                    continue;
                }
                if !root.starts_with(&real) && seen.insert(real) {
                    folders.push((path, depth + 1));
                }
            } else if entry.is_file || files::is_file(&path) {
                files.push(path);
            }
        }
    }
    files.sort();
    closed.append(&mut too_deep);
    Ok(Found { files, closed })
}

/// Where a folder is that is there, links followed. Some drives of Windows (disks in memory, Wine's in long paths) cannot say that:
/// such a folder is where it is called, and what leads back into it ends at the deepest folder.
fn real_folder(folder: &Path) -> std::io::Result<PathBuf> {
    files::canonicalize(folder).or_else(|error| match files::metadata(folder) {
        Ok(_) => files::absolute(folder),
        Err(_) => Err(error),
    })
}
