//! `lumivox import`: what can be loaded from a folder, and why other files cannot. Nothing that DICOM says about a
//! patient; files that were left out are named, by their paths below the folder.

use std::{
    collections::BTreeMap,
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

use lumivox_core::{
    CancelToken, Progress,
    words::{self, lengths},
};
use lumivox_import::{ImportError, ImportReport, SeriesSummary, Study, Thumbnail};
use serde_json::{Value, json};

use crate::{
    args::ImportArgs,
    commands::error_object,
    exit::{self, Failure},
    inputs,
    opening::check_are_scans,
    output::{self, Picture, PngOutput},
    progress::{Reporter, say},
};

/// Files that are named for one reason; the others are counted.
const MOST_NAMED: usize = 3;

/// Prints what each scan holds.
pub fn run(args: &ImportArgs) -> Result<(), Failure> {
    inputs::check(&args.input)?;
    check_are_scans(&args.input)?;
    let cancel = exit::cancel_on_ctrl_c()?;
    let reporter = Reporter::new(args.json || args.quiet);
    let options = inputs::options(&args.input);
    if let Some(folder) = &args.thumbnails {
        fs::create_dir_all(folder)
            .map_err(|error| Failure::other(format!("cannot make {}: {error}", folder.display())))?;
    }
    let scans = inputs::scans(&args.input.inputs);
    if let Some(folder) = &args.thumbnails {
        scans
            .iter()
            .try_for_each(|files| output::check_is_no_slice(&folder.join("series-001.png"), files))?;
    }
    let (mut text, mut objects, mut found, mut why_none) = (String::new(), Vec::new(), 0, None);
    for (index, files) in scans.iter().enumerate() {
        let mut study = reporter.stages(|progress| Study::open(files, &options, progress, &cancel))?;
        let prefix = if scans.len() > 1 { format!("scan-{}-", index + 1) } else { String::new() };
        let pictures = match &args.thumbnails {
            Some(folder) => thumbnails(&study, folder, &prefix, args, &cancel)?,
            None => Vec::new(),
        };
        if study.report().series.is_empty() && why_none.is_none() {
            why_none = study.load(&options, Progress::SILENT, &cancel).err();
        }
        let report = study.report();
        found += report.series.len();
        if args.json {
            objects.push(to_json(report, &pictures, root(files))?);
        } else {
            if scans.len() > 1 {
                let _ = writeln!(
                    text,
                    "{}Scan {} of {}",
                    if index > 0 { "\n" } else { "" },
                    index + 1,
                    scans.len()
                );
            }
            text += &to_text(report, root(files));
        }
    }
    let failure = why_none.filter(|_| found == 0).map(Failure::from);
    if args.json {
        let mut object = match &failure {
            Some(failure) => error_object(&failure.message, failure.exit as u8),
            None => json!({}),
        };
        object["scans"] = json!(objects);
        text = format!("{object:#}\n");
    }
    output::print(&text)?;
    failure.map_or(Ok(()), Err)
}

/// The folder whose files need not be named in full.
fn root(files: &[PathBuf]) -> Option<&Path> {
    match files {
        [only] if only.is_dir() => Some(only),
        [first, ..] => first.parent(),
        [] => None,
    }
}

/// A file as it is named below the folder `root`.
fn below<'a>(root: Option<&Path>, file: &'a Path) -> &'a Path {
    root.and_then(|root| file.strip_prefix(root).ok()).unwrap_or(file)
}

/// Writes a picture of each series; its path, or nothing where no slice could be decoded.
fn thumbnails(
    study: &Study,
    folder: &Path,
    prefix: &str,
    args: &ImportArgs,
    cancel: &CancelToken,
) -> Result<Vec<Option<PathBuf>>, Failure> {
    let picture = |place: usize| {
        let thumbnail = match study.thumbnail(place, args.thumbnail_size as usize, cancel) {
            Ok(thumbnail) => thumbnail,
            Err(ImportError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) => {
                if !args.quiet {
                    say(&format!("no picture of series {}: {error}", place + 1));
                }
                return Ok(None);
            }
        };
        let path = folder.join(format!("{prefix}series-{:03}.png", place + 1));
        PngOutput::prepare(&path, args.input.inputs.iter().map(PathBuf::as_path))?.write(&grey(thumbnail))?;
        Ok(Some(path))
    };
    (0..study.report().series.len()).map(picture).collect()
}

fn grey(thumbnail: Thumbnail) -> Picture {
    let rgba = thumbnail.grey.iter().flat_map(|&level| [level, level, level, 255]).collect();
    Picture { width: thumbnail.width as u32, height: thumbnail.height as u32, rgba }
}

fn to_text(report: &ImportReport, root: Option<&Path>) -> String {
    let mut text = match report.series.len() {
        0 => format!("{}, nothing that makes a volume\n", report.format),
        1 => format!("{}, 1 series\n", report.format),
        n => format!("{}, {n} series (take one with --series, the first by default)\n", report.format),
    };
    for (place, series) in report.series.iter().enumerate() {
        let mark = if place == report.chosen && report.series.len() > 1 { '*' } else { ' ' };
        let _ = writeln!(text, "\n{mark} {}  {}", place + 1, series.description);
        let _ = writeln!(text, "     {}", geometry(series));
        if !series.reason.is_empty() {
            let _ = writeln!(text, "     not the first: {}", series.reason);
        }
        series.notes.iter().for_each(|note| text += &format!("     - {note}\n"));
    }
    let own = report.series.get(report.chosen).map_or(&[][..], |series| &series.notes);
    let more: Vec<_> = report.notes.iter().filter(|note| !own.contains(note)).collect();
    if !more.is_empty() {
        text += "\nNotes:\n";
        more.iter().for_each(|note| text += &format!("  {note}\n"));
    }
    if !report.skipped.is_empty() {
        text += "\nLeft out:\n";
        let mut by_reason: BTreeMap<&str, Vec<&Path>> = BTreeMap::new();
        for file in &report.skipped {
            by_reason.entry(&file.reason).or_default().push(&file.path);
        }
        for (reason, files) in by_reason {
            let _ = writeln!(text, "  {} x {reason}", files.len());
            for file in files.iter().take(MOST_NAMED) {
                let _ = writeln!(text, "      {}", words::path(below(root, file)));
            }
            if files.len() > MOST_NAMED {
                let _ = writeln!(text, "      and {} more", files.len() - MOST_NAMED);
            }
        }
    }
    text
}

/// `512 x 512 x 275 voxels of 0.781 x 0.781 x 1.000 mm, axial, HU, 144.2 MB, 275 files`.
fn geometry(series: &SeriesSummary) -> String {
    let [x, y, z] = series.dims;
    let mut words = vec![format!("{x} x {y} x {z} voxels of {}", lengths(series.spacing_mm, 3))];
    words.extend([&series.orientation, &series.unit].into_iter().filter(|word| !word.is_empty()).cloned());
    words.push(format!("{:.1} MB", series.bytes as f64 / 1e6));
    words.push(if series.files == 1 { "1 file".to_owned() } else { format!("{} files", series.files) });
    words.join(", ")
}

fn to_json(
    report: &ImportReport,
    pictures: &[Option<PathBuf>],
    root: Option<&Path>,
) -> Result<Value, Failure> {
    let mut object = serde_json::to_value(report)
        .map_err(|error| Failure::other(format!("cannot write the report: {error}")))?;
    for (place, picture) in pictures.iter().enumerate() {
        object["series"][place]["thumbnail"] = json!(picture.as_deref().map(words::path));
    }
    // The folder is often called by the patient's name.
    for (place, file) in report.skipped.iter().enumerate() {
        object["skipped"][place]["path"] = json!(words::path(below(root, &file.path)));
    }
    object["skipped_by_reason"] = json!(report.skipped_by_reason());
    Ok(object)
}
