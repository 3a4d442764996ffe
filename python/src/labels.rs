//! Labels: which voxels are what, from files and arrays.

use std::path::PathBuf;
use std::sync::Arc;

use lumivox_core::glam::DVec3;
use lumivox_core::labels::CutAway;
use lumivox_core::{Label, LabelVolume};
use lumivox_import::{LabelOptions, default_label_color};
use numpy::PyReadonlyArray3;
use pyo3::prelude::*;

use crate::errors;
use crate::fork;
use crate::volume::{Grid, Rows, Volume, affine, import_options, rows, samples, view};
use crate::wait;

/// A label's value, name and linear colour.
type Entry = (u8, String, [f64; 3]);

/// The label of each voxel of a grid.
#[pyclass(frozen, module = "lumivox._native")]
pub struct Labels {
    labels: Arc<LabelVolume>,
    /// The numbers by which people know them: those of their file.
    numbers: Vec<(i128, u8)>,
    report: Option<String>,
    /// Whether they are sure enough to hide anything by.
    sure: bool,
}

impl Labels {
    /// Labels that were found.
    pub fn new(labels: Arc<LabelVolume>, sure: bool) -> Self {
        Self { numbers: labels.numbers(), labels, report: None, sure }
    }

    /// The labels, shared.
    pub fn shared(&self) -> Arc<LabelVolume> {
        self.labels.clone()
    }

    /// Whether they are sure enough to hide anything by.
    pub fn is_sure(&self) -> bool {
        self.sure
    }
}

#[pymethods]
impl Labels {
    /// From values (z, y, x), and what the values mean; those without a colour get one. Their numbers are their values, unless
    /// they are given.
    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "what labels are, one by one")]
    #[pyo3(signature = (values, patient_from_voxel, entries, sure, report, numbers=None, cut_away=None))]
    fn from_array(
        py: Python<'_>,
        values: PyReadonlyArray3<'_, u8>,
        patient_from_voxel: Rows,
        entries: Vec<(u8, String, Option<[f64; 3]>)>,
        sure: bool,
        report: Option<String>,
        numbers: Option<Vec<(i128, u8)>>,
        cut_away: Option<String>,
    ) -> PyResult<Self> {
        let (dims, voxels) = samples(&values)?;
        let table = entries.into_iter().map(|(value, name, color)| Label {
            value,
            name,
            color: color.unwrap_or_else(|| default_label_color(value)),
        });
        let (table, place) = (table.collect(), affine(patient_from_voxel));
        let labels =
            fork::detach(py, || LabelVolume::new(dims, voxels, place, table)).map_err(errors::scan)?;
        let numbers = numbers.unwrap_or_else(|| labels.numbers());
        let cut = cut_away.and_then(|text| serde_json::from_str::<CutAway>(&text).ok());
        let labels = match cut {
            Some(cut) => labels.with_cut(cut),
            None => labels,
        };
        Ok(Self { labels: Arc::new(labels), numbers, report, sure })
    }

    /// The value of each voxel (z, y, x): a view that keeps the labels and cannot be written to.
    fn array<'py>(slf: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let labels = slf.get().shared();
        view(slf.as_any(), labels.voxels(), labels.dims())
    }

    /// Voxels along x, y, z.
    #[getter]
    fn dims(&self) -> [usize; 3] {
        self.labels.dims()
    }

    #[getter]
    fn spacing_mm(&self) -> [f64; 3] {
        self.labels.spacing_mm().to_array()
    }

    #[getter]
    fn patient_from_voxel(&self) -> Rows {
        rows(self.labels.patient_from_voxel())
    }

    /// What the values mean, by rising value.
    #[getter]
    fn entries(&self) -> Vec<Entry> {
        let labels = self.labels.labels().iter();
        labels.map(|label| (label.value, label.name.clone(), label.color)).collect()
    }

    /// What people know as labels, by rising value: all names but that of what lassos cut away.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.labels.own_labels().map(|label| label.name.clone()).collect()
    }

    /// What lassos cut away, as JSON for [`from_array`](Self::from_array).
    #[getter]
    fn cut_away(&self) -> Option<String> {
        self.labels.cut_away().and_then(|cut| serde_json::to_string(cut).ok())
    }

    /// The numbers that labels have in their file, each with its value.
    #[getter]
    fn numbers(&self) -> Vec<(i128, u8)> {
        self.numbers.clone()
    }

    /// The values that people mean by a word, as the command's `--label` takes it; none where it means nothing.
    fn values_of(&self, word: &str) -> Vec<u16> {
        self.labels.values_of(word, &self.numbers).into_iter().map(u16::from).collect()
    }

    /// The word by which scenes know a value.
    fn word_of(&self, value: u8) -> String {
        self.labels.word_of(value)
    }

    /// Voxels of each value.
    fn counts(&self, py: Python<'_>) -> Vec<u64> {
        fork::detach(py, || self.labels.counts()).to_vec()
    }

    #[getter]
    fn sure(&self) -> bool {
        self.sure
    }

    /// How they were read, as JSON; `None` for those that were not.
    #[getter]
    fn report(&self) -> Option<&str> {
        self.report.as_deref()
    }

    /// The box around the voxels that have one of some values, as opposite corners of it in voxel indices, halves included;
    /// `None` where there are none.
    fn bounds(&self, py: Python<'_>, values: Vec<u8>) -> Option<[[f64; 3]; 2]> {
        let [nx, ny, _] = self.labels.dims();
        let (low, high) = fork::detach(py, || {
            let (mut low, mut high) = (DVec3::MAX, DVec3::MIN);
            for (i, value) in self.labels.voxels().iter().enumerate() {
                if values.contains(value) {
                    let at = DVec3::from_array([i % nx, i / nx % ny, i / (nx * ny)].map(|n| n as f64));
                    (low, high) = (low.min(at), high.max(at));
                }
            }
            (low, high)
        });
        low.cmple(high).all().then(|| [(low - 0.5).to_array(), (high + 0.5).to_array()])
    }

    /// Why they seem not to be a volume's, and whether none of them lies in it; `None` where they lie in it.
    fn misplaced(&self, py: Python<'_>, volume: &Volume) -> Option<(bool, String)> {
        let volume = volume.shared();
        fork::detach(py, || self.labels.misplaced(&volume)).map(|misplaced| (misplaced.all, misplaced.why))
    }
}

/// Loads a label map.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "what the importer asks for, one by one")]
pub fn load_labels(
    py: Python<'_>,
    path: PathBuf,
    table: Option<PathBuf>,
    series: Option<String>,
    phase: Option<usize>,
    allow_outside_data: bool,
    grid: Grid,
    progress: Option<Py<PyAny>>,
) -> PyResult<Labels> {
    let mut options = LabelOptions::default();
    options.table = table;
    options.import = import_options(series, phase, false, false, allow_outside_data, &grid)?;
    let loaded = wait::stages(py, progress, |progress, cancel| {
        lumivox_import::load_labels(&path, &options, progress, cancel)
    })?;
    let loaded = loaded.map_err(errors::import)?;
    let report = Some(serde_json::to_string(&loaded.report).map_err(errors::scan)?);
    Ok(Labels { labels: Arc::new(loaded.labels), numbers: loaded.numbers, report, sure: true })
}
