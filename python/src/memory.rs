//! Volumes of arrays and of other libraries' images, on the way that files take.

use lumivox_import::{MemoryScan, SampleType, load_memory};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

use crate::errors;
use crate::fork;
use crate::volume::{Rows, Volume, affine, modality_of};

/// The name of a library as reports have it.
fn library(name: &str) -> PyResult<&'static str> {
    let known = ["array", "SimpleITK", "nibabel", "xarray", "MONAI", "napari"];
    let found = known.into_iter().find(|known| *known == name);
    found.ok_or_else(|| errors::value(format!("library '{name}' is not one of {}", known.join(", "))))
}

/// A volume of the bytes of an array (z, y, x) in order, and what was mended in it. Without a `modality` it is guessed, as a
/// file's is.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "what a scan is, one by one")]
pub fn volume_of_samples(
    py: Python<'_>,
    bytes: PyReadonlyArray1<'_, u8>,
    dims: [usize; 3],
    sample: &str,
    big_endian: bool,
    rescale: [f64; 2],
    patient_from_voxel: Rows,
    modality: Option<&str>,
    unit: Option<String>,
    from: &str,
) -> PyResult<(Volume, Vec<String>)> {
    let format = library(from)?;
    let sample: SampleType = sample.parse().map_err(errors::value)?;
    let modality = modality.map(modality_of).transpose()?;
    let bytes = bytes.as_slice().map_err(|_| errors::value("the array is not contiguous"))?;
    let name = if format == "array" { "the array".to_owned() } else { format!("the image of {format}") };
    let scan = MemoryScan {
        name: &name,
        format,
        dims,
        sample,
        big_endian,
        bytes,
        rescale,
        patient_from_voxel: affine(patient_from_voxel),
        modality,
    };
    let made = fork::detach(py, || load_memory(&scan)).map_err(errors::import)?;
    let report = serde_json::to_string(&made.imported.report).map_err(errors::scan)?;
    let volume = made.imported.volume;
    let volume = match unit {
        Some(unit) => volume.with_unit(unit),
        None => volume,
    };
    // An array that is as it should be was not read from anything.
    let told = format != "array" || !made.repairs.is_empty();
    Ok((Volume::from(volume).reported(told.then_some(report)), made.repairs))
}
