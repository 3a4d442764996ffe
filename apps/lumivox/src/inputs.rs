//! From the scans named on the command line to volumes.

use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
};

use lumivox_core::{
    CancelToken, Volume,
    words::{lengths, number},
};
use lumivox_import::{
    ImportError, ImportOptions, ImportReport, Imported, ImportedLabels, LabelOptions, Study, load_labels,
};

use crate::{args::InputArgs, exit::Failure, progress::Reporter};

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

/// What to do about slices that nobody asked to be empty: what lies in them is taken for air, and the chest is open there.
pub fn note_of_holes(report: &ImportReport, volume: &Volume) -> Option<&'static str> {
    let is_asked_for = volume.source().is_some_and(|scan| scan.leave_gaps);
    (!report.empty_slices.is_empty() && !is_asked_for)
        .then_some("--fill-damaged fills in slices that are empty, beside which organs are hardly found")
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
}
