//! DICOM: files to a volume at its true place in the patient.
//!
//! The walk: [`images`] finds files and reads their headers ([`elements`], [`header`], [`frames`]), [`series`] sorts images
//! into stacks and phases and makes an even grid of their places, and [`assembly`] decodes one ([`codec`](crate::codec)) and puts its
//! slices on that.
//!
//! The modules are floors, from the lowest: [`bytes`], [`elements`], [`header`], [`frames`], [`images`],
//! [`series`], [`assembly`]. Each imports only lower ones; `cargo xtask layers` sees to it.
//!
//! Structure and headers are read by Lumivox itself, within bounds that no file can widen; compressed frames go to the
//! decoders that dicom-rs uses too.

mod assembly;
mod bytes;
mod elements;
mod frames;
mod header;
mod images;
mod series;

use std::{
    collections::{BTreeMap, HashSet},
    path::{Path, PathBuf},
};

use assembly::{
    alignment::Alignment,
    label_pixels,
    pixels::{self, Failure},
    slices::Slices,
};
use bytes::source::Source;
pub(crate) use header::{segments::Segmentation, structures::Structure};
pub(crate) use images::scan::{Found, files_below};
use images::{image_file::ImageFile, rejected::Rejected, scan, siblings};
use lumivox_core::{CancelToken, Modality, Progress, Subject, Volume, Voxels, fill};
use series::{
    gaps::Gaps,
    stack::{Phase, Stack},
    stacks,
};

use crate::{
    ImportError, ImportOptions, ImportReport, Imported, SeriesSummary, SkippedFile, Thumbnail, single,
    values::{Told, judged},
};

/// What the headers of DICOM files say, before any pixel is read.
pub(crate) struct Study {
    /// The path to name in errors.
    path: PathBuf,
    files: Vec<ImageFile>,
    /// What is no usable image.
    rejected: Vec<Rejected>,
    stacks: Vec<Stack>,
    /// Of segmentations: which stack they were made on.
    alignments: Vec<Option<Alignment>>,
    skipped: Vec<SkippedFile>,
}

/// Whether a file's first bytes are those of a DICOM file, if need be one without preamble or prefix.
pub(crate) fn is_dicom(path: &Path) -> bool {
    // Opening a pipe might wait for ever.
    crate::files::is_file(path)
        && (elements::data_set::is_dicom(&Source::File(path.to_owned()))
            || elements::gzip::is_gzip_of_dicom(path).unwrap_or(false))
}

/// The structures of a radiotherapy structure set; `None` of a file that is none, or that cannot be read, which its study tells.
pub(crate) fn structures_of(path: &Path, cancel: &CancelToken) -> Option<Vec<Structure>> {
    if !crate::files::is_file(path) {
        return None;
    }
    let header = elements::data_set::read_header(&Source::File(path.to_owned()), cancel).ok()?;
    let data = &header.data;
    header::structures::is_structure_set(data).then(|| header::structures::structures(data))
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
        let mut files = with_pixels(files, &mut rejected);
        if let ([path], [only]) = (paths, &mut files[..])
            && let Some(note) = siblings::note(path, only, cancel)?
        {
            only.notes.push(note);
        }
        if files.is_empty() && rejected.len() == 1 && !paths.iter().any(crate::files::is_dir) {
            // The one file's own error says more than that there is no series.
            return Err(rejected.remove(0).error);
        }
        let (stacks, left_out) = stacks::stacks(&files);
        let mut skipped: Vec<SkippedFile> = rejected.iter().map(Rejected::skipped).collect();
        skipped.extend(left_out);
        let truncated = files.iter().filter_map(|file| Some((file, file.truncation()?)));
        skipped.extend(truncated.map(|(file, error)| Rejected::new(file.source.path(), error).skipped()));
        let alignments: Vec<_> = (0..stacks.len()).map(|k| Alignment::of(k, &stacks, &files)).collect();
        let path = paths.first().cloned().unwrap_or_default();
        Ok(Self { path, files, rejected, stacks, alignments, skipped })
    }

    /// What the report says of each series.
    fn summaries(&self, options: &ImportOptions) -> Vec<SeriesSummary> {
        let summary = |(stack, alignment): (&Stack, &Option<Alignment>)| {
            let mut summary = stack.summary(&self.files, self.gaps(stack, &stack.phases[0], options));
            alignment.iter().for_each(|alignment| alignment.describe(&mut summary));
            summary
        };
        let mut summaries: Vec<_> = self.stacks.iter().zip(&self.alignments).map(summary).collect();
        for (summary, stack) in summaries.iter_mut().zip(&self.stacks).skip(1) {
            summary.reason = stack.reason(&self.stacks[0], &self.files).to_owned();
        }
        let frame = |k: usize| {
            let first = self.stacks[k].first(&self.files);
            first.frame_of_reference.as_ref().filter(|_| first.segmentation.is_none())
        };
        for (place, summary) in summaries.iter_mut().enumerate() {
            let Some(own) = frame(place) else { continue };
            let others = (0..self.stacks.len()).filter(|&k| k != place && frame(k) == Some(own));
            summary.aligned_series = others.collect();
        }
        stacks::name_apart(&mut summaries);
        summaries
    }

    /// What becomes of the gaps of a phase.
    fn gaps(&self, stack: &Stack, phase: &Phase, options: &ImportOptions) -> Gaps {
        if options.leave_gaps {
            Gaps::Left
        } else if !options.fill_damaged && self.is_damaged_somewhere(stack, phase) {
            Gaps::MayBeDamaged
        } else {
            Gaps::Filled
        }
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
                _ => ImportError::NoSeries { path, files, detail: self.why_none() },
            });
        }
        let Some(wanted) = options.series.clone() else { return Ok(0) };
        match stacks::choose(&self.stacks, &self.files, &wanted)[..] {
            [chosen] => Ok(chosen),
            [] => {
                let available = list(&self.summaries(options), 0..self.stacks.len());
                Err(ImportError::NoSuchSeries { path, wanted, available })
            }
            ref several => {
                let candidates = list(&self.summaries(options), several.iter().copied());
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
        let series = self.summaries(options);
        Ok(ImportReport {
            format: FORMAT.to_owned(),
            notes: series.get(chosen).map(|series| series.notes.clone()).unwrap_or_default(),
            series,
            chosen,
            empty_slices: Vec::new(),
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
        let told = Told::by(options);
        self.rescale(chosen, &told);
        let (files, stack) = (&self.files, &self.stacks[chosen]);
        let number = phase_number(stack, files, options, &self.path)?;
        let phase = &stack.phases[number];
        let first = stack.first(files);
        let is_labels = first.segmentation.is_some();

        let mut notes = stack.all_notes(files, phase);
        let (decoded, failed) = Slices::decode(files, stack, phase, &mut notes, progress, cancel)?;
        notes.extend((stack.phases.len() > 1).then(|| stack.taken_note(number)));
        let mut skipped = self.skipped.clone();
        skipped.extend(newly_skipped(files, phase, failed));

        let fills_damaged = options.fill_damaged && !options.leave_gaps && !is_labels;
        let slices = if fills_damaged { decoded.without_damaged(&mut notes) } else { decoded };
        let mut on_grid = slices.on_grid(files, stack, self.alignments[chosen].as_ref(), &mut notes)?;
        let sources = on_grid.sources(self.gaps(stack, phase, options), &mut notes);
        let empty_slices = on_grid.empty_slices(&sources);
        let (dims, patient_from_voxel) = (on_grid.dims(), on_grid.patient_from_voxel());
        let (mut voxels, rescale) = on_grid.filled(&sources, cancel)?;
        if !is_labels {
            let empty = first.is_hounsfield().then_some(pixels::AIR_HU);
            let found = fill::replace(&mut voxels, rescale, empty);
            notes.extend(found.iter().map(|fill| fill.note(voxels.len())));
        }

        single::check_spacing(&self.path, patient_from_voxel)?;
        cancel.check()?;
        let modality = if is_labels { Modality::Other } else { first.modality };
        let mut volume = Volume::new(dims, voxels, rescale, patient_from_voxel, modality)
            .map_err(|source| ImportError::Volume { path: self.path.clone(), source })?
            .with_unit(first.unit.clone())
            .with_subject(if is_labels { Subject::default() } else { first.subject });
        if !is_labels {
            volume = judged(told.apply(volume), &told, &mut notes);
        }
        notes.extend(single::remarks(&volume));
        let series = self.summaries(options);
        let report = ImportReport { format: FORMAT.to_owned(), series, chosen, notes, empty_slices, skipped };
        Ok(Imported { volume, report })
    }

    /// Gives the images of a series the slope and intercept that the user told, in place of their own.
    fn rescale(&mut self, series: usize, told: &Told) {
        let slices = self.stacks[series].phases.iter().flat_map(|phase| &phase.slices);
        for slice in slices {
            let file = &mut self.files[slice.file];
            let is_image = file.segmentation.is_none() && file.format.lut.is_none();
            if is_image && let Some(frame) = file.frames.get_mut(slice.frame) {
                frame.rescale = told.rescale(frame.rescale);
            }
        }
    }

    /// Loads the segmentation that `options` name, by default the first in the list, and says what its segments are.
    ///
    /// # Errors
    /// As [`Study::load`]; where no series is a segmentation, or the one that is named is none.
    pub(crate) fn load_segmentation(
        &mut self,
        options: &ImportOptions,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<(Imported, Segmentation), ImportError> {
        let mut options = options.clone();
        let mut others = String::new();
        if options.series.is_none() && !self.stacks.is_empty() {
            let is_labels = |place: &usize| self.stacks[*place].first(&self.files).segmentation.is_some();
            let all: Vec<usize> = (0..self.stacks.len()).filter(is_labels).collect();
            options.series = all.first().map(|place| (place + 1).to_string());
            if let [_, rest @ ..] = &all[..]
                && !rest.is_empty()
            {
                others = list(&self.summaries(&options), rest.iter().copied());
            }
        }
        let chosen = self.choose(&options)?;
        let Some(segmentation) = self.stacks[chosen].first(&self.files).segmentation.clone() else {
            let available = list(&self.summaries(&options), 0..self.stacks.len());
            return Err(ImportError::Unsupported {
                path: self.path.clone(),
                what: format!("a DICOM series of images, no segmentation; it has: {available}"),
                remedy: "Export the labels as a segmentation object (SEG)".to_owned(),
            });
        };
        let mut loaded = self.load(&options, progress, cancel)?;
        if !others.is_empty() {
            loaded.report.notes.push(format!(
                "this is the first of several segmentations; name the file of another to take that: {others}"
            ));
        }
        Ok((loaded, segmentation))
    }

    /// Why there is no series, as a sentence: what is wrong with the DICOM files, or what the others are.
    fn why_none(&self) -> String {
        let dicom = || self.rejected.iter().filter(|rejected| rejected.is_dicom());
        // A damaged image is what the user misses.
        let Some(first) = dicom().find(|rejected| rejected.is_damaged()).or_else(|| dicom().next()) else {
            return commonest_reason(&self.skipped);
        };
        let name = first.path.strip_prefix(&self.path).unwrap_or(&first.path);
        let others = match dicom().count() - 1 {
            0 => String::new(),
            1 => "; another DICOM file was left out, too".to_owned(),
            others => format!("; {others} other DICOM files were left out, too"),
        };
        format!("'{}' was left out: {}{others}", name.display(), first.reason())
    }

    /// Whether there are files that may belong in the gaps of a phase: damaged or refused, or their place is not known.
    fn is_damaged_somewhere(&self, stack: &Stack, phase: &Phase) -> bool {
        let first = stack.first(&self.files);
        let lacks_place = |file: &ImageFile| {
            (&file.series_uid, file.is_localizer) == (&first.series_uid, first.is_localizer)
                && (file.format.rows, file.format.columns) == (first.format.rows, first.format.columns)
                && file.frames.iter().any(|frame| frame.position.is_none())
        };
        self.rejected.iter().any(|rejected| rejected.may_belong_to(first.series_uid.as_deref()))
            || phase.slices.iter().any(|slice| self.files[slice.file].is_cut_short())
            || self.files.iter().any(lacks_place)
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
        if slice_len > single::LARGEST_PICTURE {
            return Err(ImportError::Unsupported {
                path: first.source.path(),
                what: format!(
                    "a slice of {} x {} pixels, too large for a picture of it",
                    format.columns, format.rows
                ),
                remedy: "Load it without a picture, or export a part of it".to_owned(),
            });
        }
        let picture = |voxels: &Voxels, [slope, intercept]: [f64; 2], slice: usize, window| {
            let value = |i| voxels.get(slice * slice_len + i) * slope + intercept;
            let values: Vec<f64> = (0..slice_len).map(value).collect();
            Thumbnail::new(&values, [format.columns, format.rows], spacing, window, side)
        };
        let slices = &stack.phases[0].slices;
        let middle = slices.len() / 2;
        if first.segmentation.is_some() {
            let (decoded, _) = label_pixels::decode(&self.files, stack, Progress::SILENT, cancel)?;
            return Ok(picture(&decoded.voxels, decoded.rescale, middle, None));
        }
        // Soft tissue and bone, where values are absolute.
        let window = first.is_hounsfield().then_some([-200.0, 500.0]);
        let mut fault = None;
        let (whole, cut): (Vec<usize>, Vec<usize>) = (middle..slices.len())
            .chain((0..middle).rev())
            .partition(|&slice| self.files[slices[slice].file].has(slices[slice].frame));
        for slice in whole.into_iter().chain(cut).take(MOST_TRIED) {
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

/// Leaves out files without a whole frame, unless they mark a place in a series: another file of it has the same size,
/// and none is a whole copy of them.
fn with_pixels(files: Vec<ImageFile>, rejected: &mut Vec<Rejected>) -> Vec<ImageFile> {
    if files.iter().all(|file| file.truncated.is_none()) {
        return files;
    }
    let size = |file: &ImageFile| (file.series_uid.clone(), file.format.rows, file.format.columns);
    let place = |file: &ImageFile| {
        let frame = &file.frames[0];
        (size(file), frame.position.map(|p| p.to_array().map(f64::to_bits)), frame.phase.instance)
    };
    let whole = || files.iter().filter(|file| file.truncated.is_none());
    let (sizes, places): (HashSet<_>, HashSet<_>) =
        (whole().map(size).collect(), whole().map(place).collect());
    let marks = |file: &ImageFile| sizes.contains(&size(file)) && !places.contains(&place(file));
    let (kept, lost): (Vec<_>, Vec<_>) =
        files.into_iter().partition(|file| file.truncated.is_none() || marks(file));
    rejected
        .extend(lost.iter().filter_map(|file| Some(Rejected::new(file.source.path(), file.truncation()?))));
    kept
}

/// The files of `failed` slices that are not among those left out yet.
fn newly_skipped(files: &[ImageFile], phase: &Phase, failed: Vec<Failure>) -> Vec<SkippedFile> {
    let mut named = HashSet::new();
    let skip = |(slice, error): Failure| {
        let index = phase.slices[slice].file;
        let file = &files[index];
        // One that is cut short was named when it was found; one of many frames is named once.
        let is_new = file.truncated.is_none() && named.insert(index);
        is_new.then(|| Rejected::new(file.source.path(), error).skipped())
    };
    failed.into_iter().filter_map(skip).collect()
}

/// Slices that are tried for a thumbnail where some are damaged.
const MOST_TRIED: usize = 8;

/// The position of the phase that `options` name; by default the first of those that have the most slices.
fn phase_number(
    stack: &Stack,
    files: &[ImageFile],
    options: &ImportOptions,
    path: &Path,
) -> Result<usize, ImportError> {
    let there = stack.phases.len();
    match options.phase {
        None => {
            let whole = |phase: &Phase| phase.slices.len() - phase.truncated(files);
            let most = stack.phases.iter().map(whole).max();
            Ok(stack.phases.iter().position(|phase| Some(whole(phase)) == most).unwrap_or(0))
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
        None => crate::error::CHOOSE_FOLDER.to_owned(),
    }
}
