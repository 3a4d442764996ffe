//! Looks: presets, transfer functions in files, maps of light.

use std::path::PathBuf;
use std::sync::Arc;

use lumivox_core::{EnvironmentMap, Preset, document::Look};
use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::description::{environment_map, written_out};
use crate::errors;
use crate::fork;
use crate::volume::Volume;

/// A map of light from all directions.
#[pyclass(frozen, name = "EnvironmentMap", module = "lumivox._native")]
pub struct Map(pub Arc<EnvironmentMap>);

#[pymethods]
impl Map {
    /// From radiance (rows from the zenith, columns, 3).
    #[new]
    fn new(texels: PyReadonlyArray3<'_, f32>) -> PyResult<Self> {
        let view = texels.as_array();
        let &[height, width, 3] = view.shape() else {
            return Err(errors::value("an environment map must be (rows, columns, 3)"));
        };
        let flat: Vec<f32> = view.iter().copied().collect();
        let texels = flat.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        environment_map(width, height, texels).map(Self)
    }

    /// Radiance (rows from the zenith, columns, 3).
    fn array<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let flat = PyArray1::from_vec(py, self.0.texels.as_flattened().to_vec());
        flat.reshape([self.0.height, self.0.width, 3])
    }
}

/// Name and description of every preset.
#[pyfunction]
pub fn presets() -> Vec<(&'static str, &'static str)> {
    Preset::ALL.iter().map(|preset| (preset.name(), preset.description())).collect()
}

/// The name of the preset that suits a volume when nobody chose one.
#[pyfunction]
pub fn default_preset(py: Python<'_>, volume: &Volume) -> &'static str {
    let volume = volume.shared();
    fork::detach(py, || Preset::default_for(&volume)).name()
}

/// A preset's name, its right spelling, and its look, placed for a volume: written out, as documents have it.
#[pyfunction]
pub fn preset_look(py: Python<'_>, name: &str, volume: &Volume) -> PyResult<(&'static str, String)> {
    let preset = Preset::from_name(name).map_err(errors::value)?;
    let volume = volume.shared();
    // Some look at all voxels. Where all are equal, the gradients of surfaces are none, which nothing may have.
    let medium = fork::detach(py, || preset.medium(&volume)).sanitized();
    Ok((preset.name(), serde_json::to_string(&Look::of_medium(&medium)).map_err(errors::words)?))
}

/// Opacity and linear RGB, by a look's function, at values that change so much per mm.
#[pyfunction]
pub fn transfer_function_at(look: &str, values: Vec<f64>, per_mm: f64) -> PyResult<Vec<(f64, [f64; 3])>> {
    let medium = written_out(look)?;
    Ok(values.into_iter().map(|value| medium.opacity_and_color(value, per_mm)).collect())
}

/// The look of a transfer function in a file.
#[pyfunction]
pub fn load_transfer_function(path: PathBuf, value_range: [f64; 2]) -> PyResult<String> {
    let loaded = lumivox_import::load_transfer_function_2d(&path, value_range);
    let (function, gradients) = loaded.map_err(errors::import)?;
    let look = Look { transfer_function: Some(function), gradients, ..Look::default() };
    serde_json::to_string(&look).map_err(errors::words)
}

/// Writes a transfer function's file.
#[pyfunction]
pub fn save_transfer_function(path: PathBuf, look: &str, unit: &str) -> PyResult<()> {
    let medium = written_out(look)?;
    let (function, rows) = (&medium.transfer_function, &medium.gradients);
    lumivox_import::save_transfer_function_2d(&path, function, rows, unit).map_err(errors::import)
}

/// An equirectangular `.hdr` or `.exr` file.
#[pyfunction]
pub fn load_environment(py: Python<'_>, path: PathBuf) -> PyResult<Map> {
    let map = fork::detach(py, || lumivox_import::load_environment(&path)).map_err(errors::import)?;
    Ok(Map(Arc::new(map)))
}
