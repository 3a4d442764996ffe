//! From the scans named on the command line to volumes.

use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
    sync::Arc,
};

use lumivox_core::{CancelToken, LabelVolume, Organ, Progress, Volume};
use lumivox_import::{
    ImportError, ImportOptions, Imported, ImportedLabels, LabelOptions, Study, load_label_files, load_labels,
};
use lumivox_segmentation::PatientAlone;

use crate::{args::InputArgs, classification::Numbered, exit::Failure, progress::Reporter};

/// Loads every scan, in the order given.
pub fn load(args: &InputArgs, reporter: Reporter, cancel: &CancelToken) -> Result<Vec<Imported>, Failure> {
    let options = options(args);
    let scan = |files: &[PathBuf]| {
        reporter.stages(|progress| lumivox_import::load(files, &options, progress, cancel))
    };
    scans(&args.inputs).iter().map(|files| scan(files).map_err(Failure::from)).collect()
}

/// Loads a CT or MR and the PET of its place, in this order; the scan alone where there are not both.
pub fn load_fusion(
    args: &InputArgs,
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<Vec<Imported>, Failure> {
    let mut options = options(args);
    let files = &scans(&args.inputs)[0];
    let mut study = reporter.stages(|progress| Study::open(files, &options, progress, cancel))?;
    let Some(both) = study.report().fusion() else {
        return Ok(vec![reporter.stages(|progress| study.load(&options, progress, cancel))?]);
    };
    let chosen = study.report().chosen;
    let mut load = |place: usize| {
        options.series = Some((place + 1).to_string());
        // What was asked for is a phase of the series that was asked for.
        options.phase = args.phase.filter(|_| place == chosen).map(|phase| phase as usize);
        reporter.stages(|progress| study.load(&options, progress, cancel))
    };
    Ok(vec![load(both[0])?, load(both[1])?])
}

/// The labels of a file that looks like a label map; `None` where it is none after all.
pub fn labels(
    args: &InputArgs,
    path: &Path,
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<Option<ImportedLabels>, Failure> {
    let mut label_options = LabelOptions::default();
    label_options.import = options(args);
    match reporter.stages(|progress| load_labels(path, &label_options, progress, cancel)) {
        Ok(labels) => Ok(Some(labels)),
        Err(error @ ImportError::Cancelled(_)) => Err(error.into()),
        Err(_) => Ok(None),
    }
}

/// Finds the patient in a CT, and takes what lies around out of it.
pub fn patient_alone(
    volume: Volume,
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<PatientAlone, Failure> {
    Ok(reporter.stages(|progress| lumivox_segmentation::patient_alone(volume, progress, cancel))?)
}

/// Finds what belongs to what in a CT.
pub fn segment(volume: &Volume, reporter: Reporter, cancel: &CancelToken) -> Result<LabelVolume, Failure> {
    Ok(reporter.stages(|progress| lumivox_segmentation::segment(volume, progress, cancel))?.labels)
}

/// Loads files of labels as one label map.
pub fn label_files(
    args: &InputArgs,
    files: &[PathBuf],
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<Numbered, Failure> {
    // What the options say of a scan's series and layout is not about its labels.
    let mut options = LabelOptions::default();
    options.import.allow_outside_data = args.allow_outside_data;
    let loaded = reporter.stages(|progress| load_label_files(files, &options, progress, cancel))?;
    let names: Vec<&str> = loaded.labels.labels().iter().map(|label| label.name.as_str()).collect();
    let list = match names.len() {
        0 => "no labels".to_owned(),
        1 => format!("1 label: {}", names[0]),
        count => format!("{count} labels: {}", names.join(", ")),
    };
    let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    reporter.say(&format!("{}: {list}", names.join(", ")));
    loaded.report.notes.iter().for_each(|note| reporter.say(&format!("  note: {note}")));
    Ok(Numbered { labels: Arc::new(loaded.labels), numbers: loaded.numbers })
}

/// What is taken off a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Peel {
    /// So many millimetres of skin; ears stay.
    Skin(f64),
    /// All that lies less than so many millimetres deep.
    Depth(f64),
}

/// Takes what lies below the skin off a scan.
pub fn peel(
    volume: Volume,
    labels: &LabelVolume,
    peel: Peel,
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<Volume, Failure> {
    Ok(reporter.stages(|progress| match peel {
        Peel::Skin(mm) => lumivox_segmentation::peel_skin(volume, labels, mm, progress, cancel),
        Peel::Depth(mm) => lumivox_segmentation::peel(volume, labels, mm, progress, cancel),
    })?)
}

/// Leaves one organ of a scan alone.
pub fn organ_alone(
    volume: Volume,
    labels: &LabelVolume,
    organ: Organ,
    reporter: Reporter,
    cancel: &CancelToken,
) -> Result<Volume, Failure> {
    let alone =
        |progress: Progress<'_>| lumivox_segmentation::organ_alone(volume, labels, organ, progress, cancel);
    Ok(reporter.stages(alone)?)
}

/// What the importer is asked for.
pub fn options(args: &InputArgs) -> ImportOptions {
    let mut options = ImportOptions::default();
    options.series.clone_from(&args.series);
    options.phase = args.phase.map(|phase| phase as usize);
    options.leave_gaps = args.leave_gaps;
    options.fill_damaged = args.fill_damaged;
    options.allow_outside_data = args.allow_outside_data;
    options.raw.clone_from(&args.raw);
    options.spacing_mm = args.spacing;
    options.axes = args.axes;
    options.layout.clone_from(&args.layout);
    options.slope = args.slope;
    options.intercept = args.intercept;
    options.modality = args.modality;
    options.unit.clone_from(&args.unit);
    options
}

/// Checks that everything named is there, before the first is read for minutes.
pub fn check(args: &InputArgs) -> Result<(), Failure> {
    args.inputs.iter().try_for_each(|path| check_file(path))
}

/// Checks that a file is there.
pub fn check_file(path: &Path) -> Result<(), Failure> {
    let there = std::fs::metadata(path);
    there.map(|_| ()).map_err(|error| Failure::input(format!("cannot read {}: {error}", path.display())))
}

/// How many scans there will be.
pub fn count(args: &InputArgs) -> usize {
    scans(&args.inputs).len()
}

/// One entry per scan. The slices of a DICOM folder, as a shell's `folder/*.dcm` lists them, are one.
pub fn scans(inputs: &[PathBuf]) -> Vec<Vec<PathBuf>> {
    let mut scans: Vec<Vec<PathBuf>> = Vec::new();
    for input in inputs {
        let belongs = |scan: &&mut Vec<PathBuf>| {
            may_be_a_slice(input) && may_be_a_slice(&scan[0]) && scan[0].parent() == input.parent()
        };
        match scans.last_mut().filter(belongs) {
            Some(scan) => scan.push(input.clone()),
            None => scans.push(vec![input.clone()]),
        }
    }
    scans
}

fn may_be_a_slice(path: &Path) -> bool {
    const WHOLE_SCANS: [&str; 11] =
        ["nii", "gz", "nrrd", "nhdr", "mha", "mhd", "mgh", "mgz", "npy", "raw", "zip"];
    let name = path.file_name().and_then(OsStr::to_str).unwrap_or("").to_ascii_lowercase();
    let extension = Path::new(&name).extension().and_then(OsStr::to_str).unwrap_or("");
    path.is_file() && (!WHOLE_SCANS.contains(&extension) || name.ends_with(".dcm.gz"))
}

/// `CT, 512 x 512 x 275 voxels of 0.78 x 0.78 x 1.00 mm, -1000 to 3071 HU`.
pub fn describe(volume: &Volume) -> String {
    let [x, y, z] = volume.dims();
    let [low, high] = volume.value_range();
    let line = format!(
        "{modality}{x} x {y} x {z} voxels of {}, {} to {} {unit}",
        lengths(volume.spacing_mm().to_array(), 2),
        number(low),
        number(high),
        modality = modality(volume).map(|name| format!("{name}, ")).unwrap_or_default(),
        unit = volume.unit(),
    );
    line.trim_end().to_owned()
}

/// DICOM's word for what made the scan.
pub fn modality(volume: &Volume) -> Option<&'static str> {
    use lumivox_core::Modality::{Ct, Mr, Other, Pet};
    match volume.modality() {
        Ct => Some("CT"),
        Mr => Some("MR"),
        Pet => Some("PT"),
        Other => None,
    }
}

/// Lengths in mm with so many digits behind the point, in the unit that fits the longest: `0.78 x 0.78 x 1.00 mm`.
pub fn lengths<const N: usize>(mm: [f64; N], digits: usize) -> String {
    /// Units, in mm, and from how many mm on they fit.
    const UNITS: [(&str, f64, f64); 5] =
        [("km", 1e6, 1e6), ("m", 1e3, 1e4), ("mm", 1.0, 0.1), ("\u{b5}m", 1e-3, 1e-4), ("nm", 1e-6, 0.0)];
    let longest = mm.iter().copied().fold(0.0, f64::max);
    let (unit, in_mm, _) = UNITS.into_iter().find(|(_, _, least)| longest >= *least).unwrap_or(UNITS[2]);
    let numbers = mm.map(|length| format!("{:.digits$}", length / in_mm));
    format!("{} {unit}", numbers.join(" x "))
}

/// A value with as many digits as people want to read.
pub fn number(value: f64) -> String {
    if value == 0.0 || (0.01..1e7).contains(&value.abs()) {
        let digits = if value.abs() >= 100.0 || value.fract() == 0.0 { 0 } else { 2 };
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_of_one_folder_are_one_scan() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["1.dcm", "2.dcm.gz", "IM0003", "a.nii", "b.nii.gz"].map(|name| folder.path().join(name));
        for path in &paths {
            std::fs::write(path, "").unwrap();
        }
        let counts: Vec<usize> = scans(&paths).iter().map(Vec::len).collect();
        assert_eq!(counts, [3, 1, 1]);
        let folders = [folder.path().to_owned(), folder.path().to_owned()];
        assert_eq!(scans(&folders).len(), 2, "folders are scans of their own");
    }

    #[test]
    fn lengths_have_the_unit_that_fits() {
        assert_eq!(lengths([0.78125, 0.78125, 1.0], 2), "0.78 x 0.78 x 1.00 mm");
        assert_eq!(lengths([0.005, 0.005, 0.03], 2), "5.00 x 5.00 x 30.00 \u{b5}m");
        assert_eq!(lengths([4e-6; 3], 1), "4.0 x 4.0 x 4.0 nm");
        assert_eq!(lengths([500.0], 1), "500.0 mm");
        assert_eq!(lengths([64_000.0], 1), "64.0 m");
        assert_eq!(lengths([3e6], 1), "3.0 km");
    }

    #[test]
    fn numbers_read_well() {
        assert_eq!(
            [-1000.0, 0.0, 12.5, 0.001, 3e9].map(number),
            ["-1000", "0", "12.50", "1.000e-3", "3.000e9"]
        );
    }
}
