//! What is meant by a path and its options: a format, a volume of a folder, a channel; and which options mean nothing.

use std::path::{Path, PathBuf};

use lumivox_core::CancelToken;

use crate::{
    ImportOptions, dicom,
    error::ImportError,
    format::{self, Format},
    pictures,
    single::Single,
    zarr,
};

/// The channel that options name, as a series, counted from 1.
pub(crate) fn channel(channels: &[Single], options: &ImportOptions) -> Result<usize, ImportError> {
    let Some(wanted) = &options.series else { return Ok(0) };
    let number = wanted.trim().parse::<usize>().ok().and_then(|number| number.checked_sub(1));
    number.filter(|number| *number < channels.len()).ok_or_else(|| ImportError::NoSuchSeries {
        path: channels[0].path.clone(),
        wanted: wanted.clone(),
        available: format!("channels 1 to {}", channels.len()),
    })
}

/// Notes on options that a file of this format has no use for.
pub(crate) fn unused(options: &ImportOptions, format: &str) -> Vec<String> {
    let mut notes = Vec::new();
    let has_channels = ["TIFF", "PNG", zarr::NAME].contains(&format);
    let is_array = has_channels || format == "NPY";
    let told = [
        (options.spacing_mm.is_some(), "spacing"),
        (options.axes.is_some(), "orientation"),
        (options.layout.is_some() && !has_channels, "layout"),
    ];
    for (_, what) in told.iter().filter(|(is_told, _)| *is_told && !is_array) {
        notes.push(format!(
            "the {what} that was given was not used: it is for arrays and pictures, and not for {format}"
        ));
    }
    if options.series.is_some() && format != "DICOM" && !has_channels {
        notes.push(format!("no series was looked for: a {format} file holds one image"));
    }
    if options.raw.is_some() && format != "RAW" {
        notes.push(format!("the description of raw samples was not used: {format} describes itself"));
    }
    notes
}

/// How a single file is to be read.
pub(crate) fn format_of(path: &Path, options: &ImportOptions) -> Result<Format, ImportError> {
    match (&options.raw, format::recognise(path)) {
        (Some(_), Err(error)) if !matches!(error, ImportError::Io { .. }) => Ok(Format::Raw),
        // The DICOM reader knows more ways to begin a file, if it has to.
        // It unpacks them, too.
        (None, Err(ImportError::UnknownFormat { .. })) if dicom::is_dicom(path) => Ok(Format::Dicom),
        (_, format) => format,
    }
}

/// The one file of a folder without DICOM that is a volume; if there is none, the one that [`ImportOptions::raw`] can
/// only mean.
pub(crate) fn only_volume_in(
    folder: &Path,
    options: &ImportOptions,
    cancel: &CancelToken,
) -> Result<PathBuf, ImportError> {
    let mut volumes = volumes_in(folder, options, cancel)?;
    match volumes.len() {
        1 => Ok(volumes.remove(0)),
        several => Err(ImportError::Unsupported {
            path: folder.to_owned(),
            what: format!("it holds {several} volumes"),
            remedy: "Open one of its files".to_owned(),
        }),
    }
}

/// The files of a folder without DICOM that are volumes, by their names; if there is none, the one that
/// [`ImportOptions::raw`] can only mean.
///
/// # Errors
/// Where there is none.
pub(crate) fn volumes_in(
    folder: &Path,
    options: &ImportOptions,
    cancel: &CancelToken,
) -> Result<Vec<PathBuf>, ImportError> {
    let dicom::Found { files: all, closed } = dicom::files_below(folder, cancel)?;
    let mut volumes = Vec::new();
    for file in &all {
        cancel.check()?;
        // Pages of pictures are slices of one volume, mostly.
        volumes
            .extend(format::recognise(file).is_ok_and(|format| format != Format::Tiff).then(|| file.clone()));
    }
    volumes.sort();
    match (&volumes[..], &all[..]) {
        ([_, ..], _) => Ok(volumes),
        ([], [only]) if options.raw.is_some() => Ok(vec![only.clone()]),
        ([], _) => Err(ImportError::NoSeries {
            path: folder.to_owned(),
            files: all.len(),
            detail: match &options.raw {
                _ if !closed.is_empty() => {
                    format!(
                        "'{}' was left out: {}. Open it by itself",
                        closed[0].path.display(),
                        closed[0].reason()
                    )
                }
                _ if all.is_empty() => crate::error::CHOOSE_FOLDER.to_owned(),
                Some(_) => "Open the one that is described".to_owned(),
                None => "None is of a format that Lumivox reads".to_owned(),
            },
        }),
    }
}

/// Whether a picture at `output` would be one more slice of a scan the next time that scan is opened: it would lie in its folder of
/// PNG or TIFF slices, or beside them where they are named one by one.
pub fn would_be_a_slice(output: &Path, scan: &[PathBuf], cancel: &CancelToken) -> bool {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    let real = |path: &Path| crate::files::canonicalize(path).ok();
    let Some(folder) = real(folder.unwrap_or(Path::new("."))) else { return false };
    let is_output = |file: &Path| file.file_name() == output.file_name() && lies_in(file, &folder);
    match scan {
        [below] if crate::files::is_dir(below) => {
            real(below).is_some_and(|below| folder.starts_with(below))
                && dicom::files_below(below, cancel).is_ok_and(|found| {
                    let others: Vec<PathBuf> =
                        found.files.into_iter().filter(|file| !is_output(file)).collect();
                    pictures::are_pictures(&others)
                })
        }
        [_] => false,
        slices => slices.iter().any(|file| lies_in(file, &folder)) && pictures::are_pictures(slices),
    }
}

fn lies_in(file: &Path, folder: &Path) -> bool {
    let own = file.parent().filter(|own| !own.as_os_str().is_empty()).unwrap_or(Path::new("."));
    crate::files::canonicalize(own).is_ok_and(|own| own == folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_among_slices_would_be_one() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["slices", "slices/more", "mixed", "out"] {
            std::fs::create_dir(at(name)).unwrap();
        }
        let png = b"\x89PNG\r\n\x1a\n";
        for name in ["slices/1.png", "slices/2.png", "mixed/1.png", "mixed/2.png", "mixed/a.txt"] {
            std::fs::write(at(name), if name.ends_with("txt") { &b"dear sirs"[..] } else { &png[..] })
                .unwrap();
        }
        let would = |output: &str, scan: &[&str]| {
            let scan: Vec<PathBuf> = scan.iter().map(|name| at(name)).collect();
            would_be_a_slice(&at(output), &scan, &CancelToken::new())
        };
        assert!(would("slices/out.png", &["slices"]));
        assert!(would("out/../slices/out.png", &["slices"]));
        assert!(would("slices/2.png", &["slices"]), "one that would be replaced, too");
        assert!(would("slices/more/out.png", &["slices"]), "folders are read with all that is in them");
        assert!(would("slices/out.png", &["slices/1.png", "slices/2.png"]));
        assert!(!would("out/out.png", &["slices"]));
        assert!(!would("out.png", &["slices"]));
        assert!(!would("mixed/out.png", &["mixed"]), "no stack");
        assert!(!would("out/out.png", &["out"]));
        assert!(!would("slices/out.png", &["slices/1.png"]), "one by itself");
    }
}
