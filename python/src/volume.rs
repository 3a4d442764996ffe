//! Volumes: from files and arrays, and what of them is the patient.

use std::fmt::Display;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

pub use lumivox_core::document::{Rows, affine, rows};
use lumivox_core::{self as core, LabelVolume, Modality, Organ, Preset, Voxels};
use lumivox_import::{CodecWorker, ImportOptions, UnknownAxes, UnknownLayout, parse_spacing};
use lumivox_segmentation::{SegmentationReport, has_organ, skin_is_dense};
use numpy::ndarray::ArrayView3;
use numpy::{Element, PyArray3, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::ending;
use crate::errors;
use crate::fork;
use crate::labels::Labels;
use crate::wait;

/// Which part of a volume is shown, in place of all.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// Without so many mm of skin; ears stay.
    WithoutSkin(f64),
    /// Without all that lies less than so many mm deep.
    Below(f64),
    /// One organ.
    Organ(Organ),
}

/// What was found of a scan.
#[derive(Clone)]
struct Found {
    labels: Arc<LabelVolume>,
    /// Whether they are sure enough to hide anything by.
    sure: bool,
    /// What was hidden, or why nothing was.
    note: Option<String>,
}

/// A scan, and what is known of it.
#[pyclass(frozen, module = "lumivox._native")]
pub struct Volume {
    volume: Arc<core::Volume>,
    report: Option<String>,
    found: Option<Found>,
    /// The last part that was shown of it.
    part: Mutex<Option<(Part, Arc<core::Volume>)>>,
    /// Depth below its skin, once it was asked for.
    depth: Mutex<Option<Arc<core::Volume>>>,
}

impl From<core::Volume> for Volume {
    fn from(volume: core::Volume) -> Self {
        Self::of(Arc::new(volume))
    }
}

impl Volume {
    /// The volume, shared.
    pub fn shared(&self) -> Arc<core::Volume> {
        self.volume.clone()
    }

    /// The same with how it was read, as JSON.
    pub fn reported(self, report: Option<String>) -> Self {
        Self { report, ..self }
    }

    /// A volume of which nothing more is known.
    pub fn of(volume: Arc<core::Volume>) -> Self {
        Self { volume, report: None, found: None, part: Mutex::new(None), depth: Mutex::new(None) }
    }
}

#[pymethods]
impl Volume {
    /// From samples (z, y, x): `value = stored * slope + intercept`.
    #[staticmethod]
    fn from_array(
        py: Python<'_>,
        stored: &Bound<'_, PyAny>,
        slope: f64,
        intercept: f64,
        patient_from_voxel: Rows,
        modality: &str,
        unit: Option<String>,
    ) -> PyResult<Self> {
        let (dims, voxels) = if let Ok(array) = stored.extract::<PyReadonlyArray3<'_, u8>>() {
            let (dims, samples) = samples(&array)?;
            (dims, Voxels::U8(samples))
        } else if let Ok(array) = stored.extract::<PyReadonlyArray3<'_, u16>>() {
            let (dims, samples) = samples(&array)?;
            (dims, Voxels::U16(samples))
        } else if let Ok(array) = stored.extract::<PyReadonlyArray3<'_, f32>>() {
            let (dims, samples) = samples(&array)?;
            (dims, Voxels::F32(samples))
        } else {
            return Err(errors::value("an array of uint8, uint16 or float32 with axes z, y, x is needed"));
        };
        let (modality, place) = (modality_of(modality)?, affine(patient_from_voxel));
        let made = fork::detach(py, || core::Volume::new(dims, voxels, [slope, intercept], place, modality));
        let volume = made.map_err(errors::scan)?;
        Ok(match unit {
            Some(unit) => volume.with_unit(unit),
            None => volume,
        }
        .into())
    }

    /// The stored samples (z, y, x): a view that keeps the volume and cannot be written to.
    fn array<'py>(slf: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let volume = slf.get().shared();
        let dims = volume.dims();
        match volume.voxels() {
            Voxels::U8(samples) => view(slf.as_any(), samples, dims),
            Voxels::U16(samples) => view(slf.as_any(), samples, dims),
            Voxels::F32(samples) => view(slf.as_any(), samples, dims),
        }
    }

    /// Voxels along x, y, z.
    #[getter]
    fn dims(&self) -> [usize; 3] {
        self.volume.dims()
    }

    #[getter]
    fn slope(&self) -> f64 {
        self.volume.slope()
    }

    #[getter]
    fn intercept(&self) -> f64 {
        self.volume.intercept()
    }

    #[getter]
    fn spacing_mm(&self) -> [f64; 3] {
        self.volume.spacing_mm().to_array()
    }

    #[getter]
    fn center_mm(&self) -> [f64; 3] {
        self.volume.center_mm().to_array()
    }

    #[getter]
    fn patient_from_voxel(&self) -> Rows {
        rows(self.volume.patient_from_voxel())
    }

    #[getter]
    fn modality(&self) -> &'static str {
        match self.volume.modality() {
            Modality::Ct => "CT",
            Modality::Mr => "MR",
            Modality::Pet => "PT",
            Modality::Other => "",
        }
    }

    #[getter]
    fn unit(&self) -> &str {
        self.volume.unit()
    }

    #[getter]
    fn value_range(&self) -> [f64; 2] {
        self.volume.value_range()
    }

    /// How it was read, as JSON; `None` for one that was not.
    #[getter]
    fn report(&self) -> Option<&str> {
        self.report.as_deref()
    }

    /// What was hidden of it, or why nothing was; `None` where nothing was looked for, or there was nothing to hide.
    #[getter]
    fn note(&self) -> Option<&str> {
        self.found.as_ref()?.note.as_deref()
    }

    /// The scan without what lies around the patient.
    fn patient_alone(&self, py: Python<'_>, progress: Option<Py<PyAny>>) -> PyResult<Self> {
        let volume = core::Volume::clone(&self.volume);
        let mut alone = find(py, volume, progress)?;
        alone.report.clone_from(&self.report);
        Ok(alone)
    }

    /// Tells apart what it shows, and changes nothing.
    fn segment(&self, py: Python<'_>, progress: Option<Py<PyAny>>) -> PyResult<Self> {
        let volume = self.volume.clone();
        let found = wait::stages(py, progress, |progress, cancel| {
            lumivox_segmentation::segment(&volume, progress, cancel)
        })?
        .map_err(|_| errors::cancelled())?;
        let note = (!found.report.notes.is_empty()).then(|| found.report.notes.join("; "));
        let sure = found.report.is_sure();
        let found = Some(Found { labels: Arc::new(found.labels), sure, note });
        Ok(Self { report: self.report.clone(), found, ..Self::of(self.volume.clone()) })
    }

    /// What was found in it; `None` where nothing was looked for.
    #[getter]
    fn labels(&self) -> Option<Labels> {
        self.found.as_ref().map(|found| Labels::new(found.labels.clone(), found.sure))
    }

    /// The same volume with labels that were found before.
    fn with_labels(&self, labels: &Labels, note: Option<String>) -> PyResult<Self> {
        let (sure, labels) = (labels.is_sure(), labels.shared());
        if labels.dims() != self.volume.dims() {
            return Err(errors::value("labels of another grid"));
        }
        let found = Some(Found { labels, sure, note });
        Ok(Self { report: self.report.clone(), found, ..Self::of(self.volume.clone()) })
    }

    /// The same volume with how it was read, as JSON.
    fn with_report(&self, report: Option<String>) -> Self {
        Self { report, found: self.found.clone(), ..Self::of(self.volume.clone()) }
    }

    /// The voxels alone, without what is known of them.
    fn bare(&self) -> Self {
        Self::of(self.volume.clone())
    }

    /// What a look shows of it, and what there is to say about that: one organ alone, without skin where that hides what the
    /// preset is for, or without the `peel` mm below the skin that are asked for.
    fn shown(
        &self,
        py: Python<'_>,
        preset: Option<&str>,
        peel: Option<f64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Self, Option<&'static str>)> {
        let all = |note| Ok((Self::of(self.volume.clone()), note));
        let preset = preset.map(Preset::from_name).transpose().map_err(errors::value)?;
        let found = self.found.as_ref().filter(|found| found.sure);
        let part = if let Some(organ) = preset.and_then(Preset::organ) {
            match found {
                Some(found) if fork::detach(py, || has_organ(&found.labels, organ)) => Part::Organ(organ),
                _ => return all(Some("no lungs with airways were found: all is shown")),
            }
        } else {
            match peel {
                Some(mm) if mm > 0.0 => Part::Below(mm),
                Some(_) => return all(None),
                None => Part::WithoutSkin(preset.map_or(0.0, Preset::peel_mm)),
            }
        };
        let Some(found) = found else {
            let asked = matches!(part, Part::Below(_));
            let note = "nothing is peeled: no skin was found, as in all that is no CT of a body";
            return all(asked.then_some(note));
        };
        let (volume, labels) = (&self.volume, &found.labels);
        if let Part::WithoutSkin(mm) = part
            && (mm <= 0.0 || !fork::detach(py, || skin_is_dense(volume, labels)))
        {
            return all(None);
        }
        let kept = self.part.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some((_, kept)) = kept.filter(|(of, _)| *of == part) {
            return Ok((Self::of(kept), None));
        }
        let made = wait::stages(py, progress, |progress, cancel| {
            let volume = core::Volume::clone(volume);
            match part {
                Part::Below(mm) => lumivox_segmentation::peel(volume, labels, mm, progress, cancel),
                Part::WithoutSkin(mm) => {
                    lumivox_segmentation::peel_skin(volume, labels, mm, progress, cancel)
                }
                Part::Organ(organ) => {
                    lumivox_segmentation::organ_alone(volume, labels, organ, progress, cancel)
                }
            }
        })?;
        let made = Arc::new(made.map_err(|_| errors::cancelled())?);
        *self.part.lock().unwrap_or_else(PoisonError::into_inner) = Some((part, made.clone()));
        Ok((Self::of(made), None))
    }

    /// Depth below the skin in mm, where a skin was found for sure.
    fn skin_depth(&self, py: Python<'_>, progress: Option<Py<PyAny>>) -> PyResult<Option<Self>> {
        let Some(found) = self.found.as_ref().filter(|found| found.sure) else { return Ok(None) };
        let kept = self.depth.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some(kept) = kept {
            return Ok(Some(Self::of(kept)));
        }
        let made = wait::stages(py, progress, |progress, cancel| {
            lumivox_segmentation::skin_depth(&self.volume, &found.labels, progress, cancel)
        })?;
        let made = Arc::new(made.map_err(|_| errors::cancelled())?);
        *self.depth.lock().unwrap_or_else(PoisonError::into_inner) = Some(made.clone());
        Ok(Some(Self::of(made)))
    }

    /// Whether both are of the same voxels in memory.
    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.volume, &other.volume)
    }
}

/// Takes what lies around the patient out of a volume.
fn find(py: Python<'_>, volume: core::Volume, progress: Option<Py<PyAny>>) -> PyResult<Volume> {
    let alone = wait::stages(py, progress, |progress, cancel| {
        lumivox_segmentation::patient_alone(volume, progress, cancel)
    })?
    .map_err(|_| errors::cancelled())?;
    let sure = alone.report.as_ref().is_some_and(SegmentationReport::is_sure);
    let note = alone.note();
    let found = alone.labels.map(|labels| Found { labels: Arc::new(labels), sure, note });
    Ok(Volume { found, ..Volume::from(alone.volume) })
}

/// What made a scan, by the words that all hosts have for it; an empty one is anything else.
pub fn modality_of(word: &str) -> PyResult<Modality> {
    if word.is_empty() {
        return Ok(Modality::Other);
    }
    lumivox_import::modality_of_word(word)
        .ok_or_else(|| errors::value(format!("modality '{word}' is not 'CT', 'MR', 'PET' or 'other'")))
}

/// Voxels along x, y, z of an array (z, y, x), and its samples.
pub fn samples<T: Element + Copy>(array: &PyReadonlyArray3<'_, T>) -> PyResult<([usize; 3], Vec<T>)> {
    let &[z, y, x] = array.as_array().shape() else { unreachable!("three axes") };
    let samples = array.as_slice().map_err(|_| errors::value("the array is not contiguous"))?;
    Ok(([x, y, z], samples.to_vec()))
}

/// Samples that belong to an object, as an array (z, y, x) that keeps it.
pub fn view<'py, T: Element>(
    owner: &Bound<'py, PyAny>,
    samples: &[T],
    [x, y, z]: [usize; 3],
) -> PyResult<Bound<'py, PyAny>> {
    let view = ArrayView3::from_shape((z, y, x), samples).map_err(errors::value)?;
    // SAFETY: the samples live as long as their owner, a volume or labels, which the array keeps, and which never changes:
    // `frozen`, and its samples behind an `Arc` that is only read.
    let array = unsafe { PyArray3::borrow_from_array(&view, owner.clone()) };
    array.getattr("flags")?.setattr("writeable", false)?;
    Ok(array.into_any())
}

/// Loads a scan.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "what the command asks for, one by one")]
pub fn load(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    series: Option<String>,
    phase: Option<usize>,
    leave_gaps: bool,
    fill_damaged: bool,
    allow_outside_data: bool,
    grid: Grid,
    values: (Option<f64>, Option<f64>, Option<String>, Option<String>),
    patient_alone: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Volume> {
    let mut options = import_options(series, phase, leave_gaps, fill_damaged, allow_outside_data, &grid)?;
    let (slope, intercept, modality, unit) = values;
    (options.slope, options.intercept, options.unit) = (slope, intercept, unit);
    options.modality = modality.as_deref().map(modality_of).transpose()?;
    let told = progress.as_ref().map(|told| told.clone_ref(py));
    let loaded = wait::stages(py, told, |progress, cancel| {
        let mut imported = lumivox_import::load(&paths, &options, progress, cancel)?;
        // As it was read: scene documents tell by it whether another lies in its place.
        imported.volume = lumivox_scene::identified(imported.volume);
        Ok(imported)
    })?;
    let imported = loaded.map_err(errors::import)?;
    let report = Some(serde_json::to_string(&imported.report).map_err(errors::scan)?);
    let volume = match patient_alone {
        true => find(py, imported.volume, progress)?,
        false => imported.volume.into(),
    };
    Ok(Volume { report, ..volume })
}

/// What could be loaded, as JSON, without loading it.
#[pyfunction]
pub fn scan(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    allow_outside_data: bool,
    grid: Grid,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let options = import_options(None, None, false, false, allow_outside_data, &grid)?;
    let scanned = wait::stages(py, progress, |progress, cancel| {
        lumivox_import::scan(&paths, &options, progress, cancel)
    })?;
    serde_json::to_string(&scanned.map_err(errors::import)?).map_err(errors::scan)
}

/// What is told of files that do not say what they are a grid of: the layout of a RAW scan, distances between voxels, where
/// axes grow to, and the letters of an array's; each as the command has it.
pub type Grid = (Option<String>, Option<String>, Option<String>, Option<String>);

/// What the importer is asked for.
pub fn import_options(
    series: Option<String>,
    phase: Option<usize>,
    leave_gaps: bool,
    fill_damaged: bool,
    allow_outside_data: bool,
    (raw, spacing, axes, layout): &Grid,
) -> PyResult<ImportOptions> {
    if phase == Some(0) {
        return Err(errors::value("phase is counted from 1"));
    }
    let mut options = ImportOptions::default();
    options.series = series;
    options.phase = phase;
    options.leave_gaps = leave_gaps;
    options.fill_damaged = fill_damaged;
    options.allow_outside_data = allow_outside_data;
    options.raw = raw.as_deref().map(str::parse).transpose().map_err(errors::value)?;
    let wrong =
        |name: &str, given: &str, why: &dyn Display| errors::value(format!("{name} '{given}': {why}"));
    if let Some(given) = spacing {
        options.spacing_mm = Some(parse_spacing(given).map_err(|why| wrong("spacing", given, &why))?);
    }
    if let Some(given) = axes {
        options.axes = Some(given.parse().map_err(|why: UnknownAxes| wrong("axes", given, &why))?);
    }
    if let Some(given) = layout {
        options.layout = Some(given.parse().map_err(|why: UnknownLayout| wrong("layout", given, &why))?);
    }
    Ok(options)
}

/// Has JPEG-LS and JPEG 2000 decoded by a program, which a damaged file may crash.
#[pyfunction]
pub fn set_codec_worker(program: PathBuf, args: Vec<String>) {
    lumivox_import::set_codec_worker(Some(CodecWorker::new(program, args)));
}

/// What that program does: decodes from standard input to standard output until that ends.
#[pyfunction]
pub fn serve_codecs(py: Python<'_>) -> PyResult<()> {
    ending::detach(py, || lumivox_import::serve_codecs(std::io::stdin().lock(), std::io::stdout().lock()))
        .map_err(errors::scan)
}
