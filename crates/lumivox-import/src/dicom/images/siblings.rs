//! A file that is given alone, and is one of many: whoever drops a slice wants the scan, mostly.

use std::path::Path;

use lumivox_core::CancelToken;
use rayon::prelude::*;

use crate::{
    ImportError,
    dicom::{
        bytes::source::{Source, is_junk},
        images::{image_file::ImageFile, read::read_image},
    },
    files,
};

/// Files that are looked at: a note is not worth waiting for.
const MOST: usize = 2000;

/// That there are more files of the series of `image` beside it, at `path`; `None` where there are none, or it is a volume by
/// itself. Neither they nor the folder are named, which may be called by the patient.
///
/// # Errors
/// On cancel.
pub(crate) fn note(
    path: &Path,
    image: &ImageFile,
    cancel: &CancelToken,
) -> Result<Option<String>, ImportError> {
    let is_slice = image.frames.len() == 1 && image.segmentation.is_none() && files::is_file(path);
    let (true, Some(series)) = (is_slice, &image.series_uid) else { return Ok(None) };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // A folder that is closed to the user has nothing to tell.
    let Ok(entries) = files::read_dir(folder) else { return Ok(None) };
    let mut beside: Vec<_> = entries
        .take(2 * MOST)
        .filter_map(Result::ok)
        .filter(|entry| entry.is_file && !is_junk(&entry.name.to_string_lossy()))
        .filter(|entry| Some(entry.name.as_os_str()) != path.file_name())
        .map(|entry| entry.path)
        .collect();
    beside.truncate(MOST);
    let is_of_series = |file: &Path| {
        let found = read_image(&Source::File(file.to_owned()), cancel);
        found.is_ok_and(|other| other.series_uid.as_ref() == Some(series))
    };
    let count = beside.par_iter().filter(|file| !cancel.is_cancelled() && is_of_series(file)).count();
    cancel.check()?;
    Ok(match count {
        0 => None,
        1 => Some("another file of this series lies beside it; give its folder to see both".to_owned()),
        n => Some(format!("{n} other files of this series lie beside it; give its folder to see all")),
    })
}
