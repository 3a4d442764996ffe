//! Procedural scans, for trying things on.

use std::path::PathBuf;

use lumivox_phantom::{AnatomyOptions, MrPart, SeriesDescription, TorsoOptions, WriteError};
use pyo3::prelude::*;

use crate::errors;
use crate::volume::Volume;
use crate::wait;

/// Voxels along the longest side unless asked otherwise, as the command's.
const DEFAULT_SIZE: usize = 256;

/// The same of a PET, which is coarser.
const DEFAULT_PET_SIZE: usize = 128;

/// Hounsfield units of the homogeneous bodies, as the command makes them.
const BODY_HU: f64 = 1000.0;

/// Voxels of air around a homogeneous body, on both sides together.
const AIR_VOXELS: usize = 6;

/// A phantom of one of the command's kinds.
#[pyfunction]
pub fn phantom(
    py: Python<'_>,
    kind: &str,
    size: Option<usize>,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Volume> {
    let size = size.unwrap_or(if kind == "torso-pet" { DEFAULT_PET_SIZE } else { DEFAULT_SIZE });
    if !(8..=1024).contains(&size) {
        return Err(errors::value("size must be 8 to 1024"));
    }
    let inside = size.saturating_sub(AIR_VOXELS).max(1) as f64;
    let volume = match kind {
        "head" => {
            let options = AnatomyOptions { size, seed, ..AnatomyOptions::default() };
            wait::stages(py, progress, |progress, cancel| {
                lumivox_phantom::anatomy(options, progress, cancel)
            })?
            .map_err(|_| errors::cancelled())?
        }
        "mr-head" | "mr-brain" => {
            let options = AnatomyOptions { size, seed, ..AnatomyOptions::default() };
            let part = if kind == "mr-head" { MrPart::Head } else { MrPart::Brain };
            wait::stages(py, progress, |progress, cancel| {
                lumivox_phantom::anatomy_mr(options, part, progress, cancel)
            })?
            .map_err(|_| errors::cancelled())?
        }
        "torso" | "torso-pet" => {
            let options = TorsoOptions { size, seed, ..TorsoOptions::default() };
            let is_pet = kind == "torso-pet";
            wait::stages(py, progress, |progress, cancel| match is_pet {
                true => lumivox_phantom::torso_pet(options, progress, cancel),
                false => lumivox_phantom::torso(options, progress, cancel),
            })?
            .map_err(|_| errors::cancelled())?
        }
        "cube" => lumivox_phantom::cube(size),
        "slab" => lumivox_phantom::slab(BODY_HU, inside / 10.0, 1.0),
        "sphere" => lumivox_phantom::sphere(BODY_HU, inside / 2.0 - 0.5, 1.0),
        other => {
            return Err(errors::value(format!(
                "there is no phantom '{other}'. Phantoms: head, mr-head, mr-brain, torso, torso-pet, cube, slab, sphere"
            )));
        }
    };
    Ok(volume.into())
}

/// Writes a volume as the DICOM files that a scanner would have sent; returns how many.
#[pyfunction]
pub fn write_dicom_series(
    py: Python<'_>,
    volume: &Volume,
    folder: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<usize> {
    let description = SeriesDescription::default();
    let volume = volume.shared();
    let written = wait::stages(py, progress, |progress, cancel| {
        lumivox_phantom::write_dicom_series(&volume, &folder, &description, progress, cancel)
    })?;
    written.map_err(|error| match error {
        WriteError::Cancelled(_) => errors::cancelled(),
        error => errors::scan(error),
    })
}
