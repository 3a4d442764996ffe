//! Looks: presets, transfer functions in files, maps of light.

use std::path::PathBuf;
use std::sync::Arc;

use lumivox_core::{self as core, Ease, EnvironmentMap, Filter, Preset};
use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::description::{TransferFunction, environment_map};
use crate::errors;
use crate::fork;
use crate::volume::Volume;

/// Opacity knots `(value, opacity, ease)` and colour stops `(value, linear RGB)`.
type Points = (Vec<(f64, f64, &'static str)>, Vec<(f64, [f64; 3])>);

/// `(transfer function, density, albedo, anisotropy, bounces, filter, surface)`, the surface as its four numbers.
type MediumParts = (Points, f64, f64, f64, u32, &'static str, [f64; 4]);

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

fn points(curve: &core::TransferFunction) -> Points {
    let ease = |ease| match ease {
        Ease::Linear => "linear",
        Ease::InOut => "in-out",
    };
    let knots = curve.opacity_knots().iter().map(|knot| (knot.value, knot.opacity, ease(knot.ease)));
    (knots.collect(), curve.color_stops().iter().map(|stop| (stop.value, stop.color)).collect())
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

/// A preset's name, its right spelling, and its medium, placed for a volume.
#[pyfunction]
pub fn preset_medium(py: Python<'_>, name: &str, volume: &Volume) -> PyResult<(&'static str, MediumParts)> {
    let preset = Preset::from_name(name).map_err(errors::value)?;
    let volume = volume.shared();
    // Some look at all voxels. Where all are equal, the gradients of surfaces are none, which nothing may have.
    let medium = fork::detach(py, || preset.medium(&volume)).sanitized();
    let surface = medium.surface;
    let filter = match medium.filter {
        Filter::Nearest => "nearest",
        Filter::Trilinear => "trilinear",
        Filter::Tricubic => "tricubic",
        Filter::Smooth => "smooth",
    };
    let parts = (
        points(&medium.transfer_function),
        medium.density_scale,
        medium.albedo,
        medium.anisotropy,
        medium.max_bounces,
        filter,
        [surface.strength, surface.gradient_per_mm, surface.roughness, surface.specular],
    );
    Ok((preset.name(), parts))
}

/// Opacity and linear RGB at values that change so much per mm.
#[pyfunction]
pub fn transfer_function_at(
    curve: TransferFunction,
    values: Vec<f64>,
    per_mm: f64,
) -> PyResult<Vec<(f64, [f64; 3])>> {
    let medium = curve.medium()?;
    Ok(values.into_iter().map(|value| medium.opacity_and_color(value, per_mm)).collect())
}

/// The points of a transfer function in a file, and those of its rows for gradients, in units per mm.
#[pyfunction]
pub fn load_transfer_function(
    path: PathBuf,
    value_range: [f64; 2],
) -> PyResult<(Points, Vec<(f64, Points)>)> {
    let loaded = lumivox_import::load_transfer_function_2d(&path, value_range);
    let (curve, gradients) = loaded.map_err(errors::import)?;
    let rows = gradients.iter().map(|row| (row.per_mm, points(&row.transfer_function)));
    Ok((points(&curve), rows.collect()))
}

/// Writes a transfer function's file.
#[pyfunction]
pub fn save_transfer_function(path: PathBuf, curve: TransferFunction, unit: &str) -> PyResult<()> {
    let medium = curve.medium()?;
    let (function, rows) = (&medium.transfer_function, &medium.gradients);
    lumivox_import::save_transfer_function_2d(&path, function, rows, unit).map_err(errors::import)
}

/// An equirectangular `.hdr` or `.exr` file.
#[pyfunction]
pub fn load_environment(py: Python<'_>, path: PathBuf) -> PyResult<Map> {
    let map = fork::detach(py, || lumivox_import::load_environment(&path)).map_err(errors::import)?;
    Ok(Map(Arc::new(map)))
}
