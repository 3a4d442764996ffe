//! Label maps as files: DICOM SEG, structure sets of radiotherapy, NIfTI, NRRD (3D Slicer's segmentations too), MetaImage and RAW to a [`LabelVolume`],
//! with the names and colours that the file has, or a table beside it.
//!
//! Labels are numbers: they are never interpolated, and read exactly. A [`LabelVolume`] tells 255 apart; numbers beyond
//! that range are numbered anew, by rising number.

mod contours;
mod extension;
mod files;
pub(crate) mod segments;
mod table;
mod values;

use std::path::{Path, PathBuf};

use lumivox_core::{CancelToken, Label, LabelVolume, Progress, glam::DAffine3, labels::LabelSource};

use crate::{
    ImportOptions, ImportReport, Imported, SampleType,
    choice::{channel, format_of, unused},
    colors, dicom,
    error::ImportError,
    format::Format,
    metaimage, mgh, nifti, npy, nrrd, payload, pictures, raw,
    single::Single,
    source, zarr,
};
use segments::Segment;
use table::{Entry, Table};
use values::{Collected, Collector, MOST_LABELS, NoLabels, Number};

/// Voxels between two looks at the cancel token.
const CHUNK: usize = 1 << 16;

/// How a label map is read.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct LabelOptions {
    /// A table of names and colours: ITK-SNAP's label descriptions, FreeSurfer's and 3D Slicer's colour tables, FSLeyes'
    /// look-up tables, or columns `index`, `name` and `color` with headings. It goes before what the label map itself
    /// says. By default one of the same name beside the label map is taken (`.label`, `.ctbl`, `.lut`, `.txt`, `.tsv`,
    /// `.csv`), if there is one and the map has no names of its own.
    pub table: Option<PathBuf>,
    /// As for a scan: [`ImportOptions::series`] names one segmentation of a DICOM study, [`ImportOptions::phase`] a part
    /// of a 4D file.
    pub import: ImportOptions,
}

/// Labels and what became of their file.
#[derive(Debug)]
#[non_exhaustive]
pub struct ImportedLabels {
    /// The labels.
    pub labels: LabelVolume,
    /// The numbers that labels have in their file, each with its value in [`Self::labels`]; several layers of a file may
    /// have the same number.
    pub numbers: Vec<(i128, u8)>,
    /// How they were read.
    pub report: ImportReport,
}

/// The linear colour of a label that has none of its own: neighbours differ in hue, and far ones in lightness.
pub fn default_label_color(value: u8) -> [f64; 3] {
    colors::default_color(value)
}

/// Loads a label map: one file of any format, a structure set of radiotherapy among them, a folder or archive with a DICOM segmentation, or a folder of files that hold
/// a mask or a label map each, which become one.
///
/// Labels keep their numbers where these are 1 to 255, and are numbered anew by rising number where not; a label
/// without a name is then called by the number it had (`label 1024`). 0 and what is no number have no label. Of voxels
/// that several segments claim, the smallest segment has them, and the report says how many. Fractions of a single
/// segment count from a half. Of several files the labels are numbered in their order, and one without a name is called
/// as its file is.
///
/// # Errors
/// [`ImportError`] names the file, what is wrong and what to do: also where values have fractions, or where there are
/// more than 255, as in a scan.
pub fn load_labels(
    path: &Path,
    options: &LabelOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<ImportedLabels, ImportError> {
    load_label_files(&[path.to_owned()], options, progress, cancel)
}

/// Loads one label map of several files or folders, each as [`load_labels`] takes it. Their grids may be parts of one, as
/// those of masks are that were cut to what they hold.
///
/// # Errors
/// As [`load_labels`]; where grids do not fit together, and where there are more than 255 labels in all.
pub fn load_label_files(
    paths: &[PathBuf],
    options: &LabelOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<ImportedLabels, ImportError> {
    let given = options.table.as_deref().map(table::read).transpose()?;
    let loaded = files::load(paths, &options.import, given, progress, cancel)?;
    let source = LabelSource {
        files: paths.iter().map(|path| source::whole(path)).collect(),
        table: options.table.as_deref().map(source::whole),
        numbers: loaded.numbers.clone(),
    };
    Ok(ImportedLabels { labels: loaded.labels.with_source(source), ..loaded })
}

/// What a file says of its labels before a voxel is read.
struct LabelFile {
    single: Single,
    segments: Vec<Segment>,
    /// The names that it has itself.
    table: Table,
}

impl LabelFile {
    /// Reads the header of a file, or of a folder of OME-Zarr; `None` for DICOM.
    fn open(path: &Path, import: &ImportOptions) -> Result<Option<Self>, ImportError> {
        let outside = import.allow_outside_data;
        let plain = |single: Single| Self { single, segments: Vec::new(), table: Table::new() };
        let one_of = |mut channels: Vec<Single>| {
            channel(&channels, import).map(|chosen| plain(channels.swap_remove(chosen)))
        };
        if crate::files::is_dir(path) {
            let is_zarr = zarr::is_zarr(path);
            return is_zarr.then(|| one_of(zarr::open(path, import, &CancelToken::new())?)).transpose();
        }
        Ok(Some(match (format_of(path, import)?, &import.raw) {
            (Format::Dicom | Format::Zip, _) => return Ok(None),
            (Format::Nifti, _) => Self { table: extension::table(path)?, ..plain(nifti::open(path)?) },
            (Format::Nrrd, _) => {
                Self { segments: segments::read(path, outside)?, ..plain(nrrd::open(path, outside)?) }
            }
            (Format::MetaImage, _) => plain(metaimage::open(path, outside)?),
            (Format::Mgh, _) => plain(mgh::open(path)?),
            (Format::Npy, _) => plain(npy::open(path, import)?),
            (Format::Tiff, _) => one_of(pictures::open_tiff(path, import, &CancelToken::new())?)?,
            (Format::Raw, Some(description)) => plain(raw::open_as(path, description)?),
            (Format::Raw, None) => plain(raw::open(path)?),
        }))
    }

    fn has_names(&self) -> bool {
        !self.segments.is_empty() || !self.table.is_empty()
    }
}

/// Loads the labels of one file, or of a folder or archive of DICOM. `given` names them, before all else.
fn load_one(
    path: &Path,
    import: &ImportOptions,
    given: Option<&Table>,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<ImportedLabels, ImportError> {
    let Some(file) = LabelFile::open(path, import)? else {
        if let Some(structures) = dicom::structures_of(path, cancel) {
            return contours::labels(path, &structures, given, cancel);
        }
        let study = dicom::Study::open(&[path.to_owned()], progress, cancel)?;
        return of_dicom(study, path, import, given.unwrap_or(&Table::new()), progress, cancel);
    };
    let mut notes = Vec::new();
    let table = match given {
        Some(table) => table.clone(),
        None if !file.has_names() => table_beside(path, &mut notes),
        None => file.table,
    };
    of_single(&file.single, import, &file.segments, &table, notes, progress, cancel)
}

/// The scan that a segmentation of several layers is by itself: the numbers of its labels.
///
/// # Errors
/// As [`load_labels`].
pub(crate) fn load_layers(
    single: &Single,
    segments: &[Segment],
    import: &ImportOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Imported, ImportError> {
    let mut loaded = of_single(single, import, segments, &Table::new(), Vec::new(), progress, cancel)?;
    loaded.report.series.iter_mut().for_each(|series| series.phases = 1);
    Ok(Imported { volume: loaded.labels.volume().as_ref().clone(), report: loaded.report })
}

/// The table beside a label map, if it is one; says so.
fn table_beside(path: &Path, notes: &mut Vec<String>) -> Table {
    let Some(beside) = table::beside(path) else { return Table::new() };
    // Names of files stay out of reports; its ending says which it is.
    let ending = beside.extension().unwrap_or_default().to_string_lossy().into_owned();
    match table::read(&beside) {
        Ok(table) => {
            notes.push(format!("names are those of the table beside it (.{ending})"));
            table
        }
        Err(_) => {
            notes.push(format!("the file of the same name beside it (.{ending}) is no table of labels"));
            Table::new()
        }
    }
}

/// Labels of a file that holds one grid, or one with several layers.
fn of_single(
    single: &Single,
    import: &ImportOptions,
    segments: &[Segment],
    table: &Table,
    told: Vec<String>,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<ImportedLabels, ImportError> {
    let (path, payload) = (&single.path, &single.payload);
    if payload.channels() > 1 {
        return Err(no_labels(path, NoLabels::Colors));
    }
    let voxels = single.dims.iter().product::<usize>();
    // The layers of a segmentation are read together; of anything else, one phase is.
    let all_layers = !segments.is_empty() && import.phase.is_none();
    let layers = if all_layers || payload.interleaved() { single.phases } else { 1 };
    let phase = import.phase.unwrap_or(1);
    if !(1..=single.phases).contains(&phase) {
        return Err(ImportError::NoSuchPhase { path: path.clone(), wanted: phase, phases: single.phases });
    }
    let first = if layers == single.phases { 0 } else { (phase - 1) * voxels };
    let sample = (payload.sample(), payload.big_endian());
    let mut collector = Collector::new(sample, single.rescale, voxels, (layers, payload.interleaved()))
        .map_err(|_| payload::too_many_voxels(path, single.dims))?;
    if !all_layers && payload.interleaved() {
        collector.take_only(phase - 1);
    }
    let part = first..first + layers * voxels;
    payload.read_samples(path, single.dims, single.phases, part, progress, cancel, |bytes| {
        collector.push(bytes).map_err(|fault| no_labels(path, fault))
    })?;
    let collected = collector.finish();

    let mut report = single.report();
    report.notes.extend(unused(import, &report.format));
    report.notes.extend(told);
    if single.phases > 1 && all_layers {
        report.notes.retain(|note| Some(note) != single.phases_note().as_ref());
        report.notes.push(format!("segments in {} layers", single.phases));
    } else if single.phases > 1 {
        report.notes.push(format!("phase {phase} of {} is taken", single.phases));
    }
    if collected.not_finite {
        report.notes.push("voxels whose value is no number have no label".to_owned());
    }
    if collected.is_scattered {
        let n = collected.numbers.len();
        report.notes.push(format!(
            "{n} labels, and hardly a voxel has that of its neighbour: this looks like a scan, not like a label map"
        ));
    }
    // The layer of a phase that was asked for is not the first of those read.
    let offset = if layers == 1 { phase - 1 } else { 0 };
    let own = |number: Number| {
        let is_it = |(_, segment): &(usize, &Segment)| {
            (segment.layer, segment.value) == (number.layer + offset, number.value)
        };
        segments.iter().enumerate().find(is_it)
    };
    let entry = |number: Number| {
        let own = own(number).map(|(_, segment)| segment);
        let (own_name, own_color) = own.map_or((None, None), |own| (Some(own.name.clone()), own.color));
        let listed = table.get(&number.value);
        Entry {
            name: listed.map(|entry| entry.name.clone()).or(own_name).unwrap_or_default(),
            color: listed.and_then(|entry| entry.color).or(own_color),
        }
    };
    if let Some(settled) = &collected.settled {
        let name = |label: u16| {
            let number = collected.numbers[usize::from(label) - 1];
            Some(entry(number).name)
                .filter(|name| !name.is_empty())
                .unwrap_or(format!("label {}", number.value))
        };
        report.notes.extend(settled.notes(name));
    }
    // Segments of several layers may have the same number: their order tells them apart.
    let order = |number: Number| match own(number) {
        _ if layers == 1 => (0, number),
        Some((place, _)) => (place, number),
        None => (usize::MAX, number),
    };
    let with_voxels = segments.iter().filter(|segment| {
        let number = Number { layer: segment.layer.wrapping_sub(offset), value: segment.value };
        collected.numbers.contains(&number)
    });
    let empty = segments.len() - with_voxels.count();
    if empty > 0 && (all_layers || single.phases == 1) {
        report.notes.push(format!("{empty} of {} segments have no voxel", segments.len()));
    }
    let numbered = numbered(collected, order, entry, &mut report.notes);
    finish(path, single.dims, single.patient_from_voxel, numbered, report)
}

/// Labels of a DICOM segmentation.
fn of_dicom(
    mut study: dicom::Study,
    path: &Path,
    import: &ImportOptions,
    table: &Table,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<ImportedLabels, ImportError> {
    let (imported, segmentation) = study.load_segmentation(import, progress, cancel)?;
    let (volume, mut report) = (imported.volume, imported.report);
    let dims = volume.dims();
    let only = segmentation.segments.first().map_or(1, |segment| segment.number);
    let count = volume.voxel_count();
    let mut collector = Collector::new((SampleType::U16, false), [1.0, 0.0], count, (1, false))
        .map_err(|_| payload::too_many_voxels(path, dims))?;
    let fraction = segmentation.is_one_fraction();
    // Segments are counted with 16 bits.
    let number = |at: usize| match volume.voxels().get(at) {
        stored if !fraction => stored as u16,
        stored if stored * volume.slope() + volume.intercept() >= 0.5 => only as u16,
        _ => 0,
    };
    let mut bytes = Vec::new();
    for start in (0..count).step_by(CHUNK) {
        cancel.check()?;
        bytes.clear();
        bytes.extend((start..count.min(start + CHUNK)).flat_map(|at| number(at).to_le_bytes()));
        collector.push(&bytes).map_err(|fault| no_labels(path, fault))?;
    }
    if fraction {
        report.notes.push("voxels that the segment fills at least half belong to it".to_owned());
    }
    let entry = |number: Number| {
        let own = segmentation.segments.iter().find(|own| i128::from(own.number) == number.value);
        let listed = table.get(&number.value);
        let own_name = own.map(|own| table::clean(&own.name));
        Entry {
            name: listed.map(|entry| entry.name.clone()).or(own_name).unwrap_or_default(),
            color: listed.and_then(|entry| entry.color).or(own.and_then(|own| own.color)),
        }
    };
    let place = volume.patient_from_voxel();
    let numbered = numbered(collector.finish(), |number| (0, number), entry, &mut report.notes);
    finish(path, dims, place, numbered, report)
}

/// Voxels and labels by their final numbers.
struct Numbered {
    voxels: Vec<u8>,
    labels: Vec<Label>,
    /// The numbers in the file, and the final ones.
    numbers: Vec<(i128, u8)>,
}

/// Gives each label its final number: its own where all fit, else by their order; says so.
fn numbered(
    collected: Collected,
    order: impl Fn(Number) -> (usize, Number),
    entry: impl Fn(Number) -> Entry,
    notes: &mut Vec<String>,
) -> Numbered {
    let Collected { mut voxels, numbers, .. } = collected;
    let mut sorted = numbers.clone();
    sorted.sort_by_key(|number| order(*number));
    let fits = |number: &Number| (1..=MOST_LABELS as i128).contains(&number.value);
    let one_layer = numbers.windows(2).all(|pair| pair[0].layer == pair[1].layer);
    let keeps = one_layer && numbers.iter().all(fits);
    let value = |place: usize, number: Number| if keeps { number.value as u8 } else { place as u8 + 1 };
    if let (false, [first, .., last]) = (keeps, &sorted[..]) {
        let n = sorted.len();
        notes.push(if one_layer {
            format!("labels {} to {} are numbered 1 to {n}, by rising number", first.value, last.value)
        } else {
            format!("segments are numbered 1 to {n}, in their order")
        });
    } else if let (false, [only]) = (keeps, &sorted[..]) {
        notes.push(format!("label {} is numbered 1", only.value));
    }
    let label = |(place, &number): (usize, &Number)| {
        let Entry { name, color } = entry(number);
        let value = value(place, number);
        let name = if name.is_empty() { format!("label {}", number.value) } else { name };
        Label { value, name, color: color.unwrap_or_else(|| colors::default_color(value)) }
    };
    let labels: Vec<Label> = sorted.iter().enumerate().map(label).collect();
    let mut finals = [0u8; 256];
    for (place, number) in numbers.iter().enumerate() {
        let at = sorted.iter().position(|sorted| sorted == number).expect("it was sorted");
        finals[place + 1] = value(at, *number);
    }
    voxels.iter_mut().for_each(|voxel| *voxel = finals[usize::from(*voxel)]);
    let numbers = sorted.iter().enumerate().map(|(place, &number)| (number.value, value(place, number)));
    Numbered { voxels, labels, numbers: numbers.collect() }
}

fn finish(
    path: &Path,
    dims: [usize; 3],
    patient_from_voxel: DAffine3,
    Numbered { voxels, labels, numbers }: Numbered,
    mut report: ImportReport,
) -> Result<ImportedLabels, ImportError> {
    if labels.is_empty() {
        report.notes.push("no voxel has a label: every value is 0".to_owned());
    }
    let labels = finish_volume(path, dims, patient_from_voxel, voxels, labels, &mut report)?;
    Ok(ImportedLabels { labels, numbers, report })
}

/// The label volume of `voxels`, whose memory the report tells.
fn finish_volume(
    path: &Path,
    dims: [usize; 3],
    patient_from_voxel: DAffine3,
    voxels: Vec<u8>,
    labels: Vec<Label>,
    report: &mut ImportReport,
) -> Result<LabelVolume, ImportError> {
    let bytes = voxels.len() as u64;
    if let Some(series) = report.series.get_mut(report.chosen) {
        series.bytes = bytes;
    }
    LabelVolume::new(dims, voxels, patient_from_voxel, labels).map_err(|fault| ImportError::Unsupported {
        path: path.to_owned(),
        what: format!("labels that do not fit together: {fault}"),
        remedy: "Correct the header, or export the label map again".to_owned(),
    })
}

/// Why numbers are no labels, about a file.
fn no_labels(path: &Path, fault: NoLabels) -> ImportError {
    let what = match fault {
        NoLabels::Fraction(value) => format!("no label map: it holds {value}, and labels are whole numbers"),
        NoLabels::Colors => "no label map: it holds colours, and labels are numbers".to_owned(),
        NoLabels::None => "files of which none is a label map".to_owned(),
        NoLabels::TooMany => format!("no label map: it holds more than {MOST_LABELS} different values"),
    };
    let remedy = "Open it as a scan, or export labels as whole numbers, at most 255 different ones beside 0";
    ImportError::Unsupported { path: path.to_owned(), what, remedy: remedy.to_owned() }
}
