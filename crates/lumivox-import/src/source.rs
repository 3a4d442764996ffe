//! What a scene document says of a scan, and what it means for loading it.

use std::path::{Path, PathBuf};

use lumivox_core::document::{Keep, Scan, TakenOff};

use crate::{ImportOptions, ImportReport};

/// A part of a document's scan that says nothing that could be done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{why}")]
pub struct WrongScan {
    /// Its key.
    pub key: &'static str,
    /// What is wrong with it.
    pub why: String,
}

impl ImportOptions {
    /// How a document says that its scan is loaded. That data may lie anywhere is no document's to say.
    ///
    /// # Errors
    /// [`WrongScan`] names the key.
    pub fn of_scan(scan: &Scan) -> Result<Self, WrongScan> {
        fn parsed<T: std::str::FromStr<Err: ToString>>(
            key: &'static str,
            text: Option<&String>,
        ) -> Result<Option<T>, WrongScan> {
            let wrong = |error: T::Err| WrongScan { key, why: error.to_string() };
            text.map(|text| text.parse().map_err(wrong)).transpose()
        }
        Ok(Self {
            series: scan.series.clone(),
            phase: scan.phase.map(|phase| phase as usize),
            leave_gaps: scan.leave_gaps,
            fill_damaged: scan.fill_damaged,
            allow_outside_data: false,
            raw: parsed("raw", scan.raw.as_ref())?,
            spacing_mm: scan.spacing,
            axes: parsed("axes", scan.axes.as_ref())?,
            layout: parsed("layout", scan.layout.as_ref())?,
            slope: scan.slope,
            intercept: scan.intercept,
            modality: scan.modality,
            unit: scan.unit.clone(),
        })
    }
}

/// A path wherever the program is.
pub(crate) fn whole(path: &Path) -> PathBuf {
    crate::files::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// What a document says of what was loaded of these files. Which series it was is said where there were several.
pub(crate) fn scan(paths: &[PathBuf], options: &ImportOptions, report: &ImportReport) -> Scan {
    let chosen = report.series.get(report.chosen).filter(|_| report.series.len() > 1);
    // A file's name may be a patient's.
    let place = || (report.chosen + 1).to_string();
    let series = chosen.map(|series| series.uid.as_ref().map_or_else(place, |_| series.id.clone()));
    Scan {
        files: paths.iter().map(|path| whole(path)).collect(),
        series: series.or_else(|| options.series.clone()),
        phase: options.phase.and_then(|phase| phase.try_into().ok()),
        content: None,
        leave_gaps: options.leave_gaps,
        fill_damaged: options.fill_damaged,
        raw: options.raw.as_ref().map(ToString::to_string),
        spacing: options.spacing_mm,
        axes: options.axes.as_ref().map(ToString::to_string),
        layout: options.layout.as_ref().map(ToString::to_string),
        slope: options.slope,
        intercept: options.intercept,
        modality: options.modality,
        unit: options.unit.clone(),
        keep: Keep::Everything,
        taken_off: Some(TakenOff::Nothing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_come_back_from_what_is_said_of_a_scan() {
        let options = ImportOptions {
            series: Some("2".into()),
            phase: Some(3),
            leave_gaps: true,
            raw: Some("4x5x6:i16be:spacing=1,1,2.5:axes=RAS:intercept=-1024".parse().unwrap()),
            spacing_mm: Some([0.1, 0.2, 0.3]),
            axes: Some("LAS".parse().unwrap()),
            layout: Some("tzyx".parse().unwrap()),
            slope: Some(1.0 / 3.0),
            modality: Some(lumivox_core::Modality::Pet),
            unit: Some("SUV".into()),
            ..ImportOptions::default()
        };
        let report = ImportReport::default();
        let scan = scan(&["a/b.raw".into()], &options, &report);
        assert!(scan.files[0].is_absolute() && scan.files[0].ends_with("a/b.raw"));
        let back = ImportOptions::of_scan(&scan).unwrap();
        assert_eq!(format!("{back:?}"), format!("{options:?}"));
        let wrong = Scan { axes: Some("XYZ".into()), ..scan };
        assert_eq!(ImportOptions::of_scan(&wrong).unwrap_err().key, "axes");
    }
}
