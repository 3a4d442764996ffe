//! Voxels of a program's arrays, with their place in the patient.

use std::sync::Arc;

use js_sys::{
    Float32Array, Float64Array, Int8Array, Int16Array, Int32Array, Uint8Array, Uint8ClampedArray,
    Uint16Array, Uint32Array,
};
use lumivox_core::document::{Rows, affine, rows};
use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{CancelToken, Label, LabelVolume, Modality, Peel, Preset, Progress, Volume, Voxels};
use lumivox_phantom::{AnatomyOptions, anatomy};
use lumivox_scene::Part;
use serde::{Deserialize, Serialize};
use wasm_bindgen::prelude::*;

use crate::wrong;

/// What is said of voxels; a Worker says it to the page, too.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
pub(crate) struct Description {
    /// Voxels along x (fastest), y and z.
    dims: [usize; 3],
    /// Distances between them in mm, where x grows to the patient's left, y to the back and z to the head.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    spacing: Option<[f64; 3]>,
    /// Or all of their place: voxel indices to the patient's millimetres (LPS), three rows of four.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    patient_from_voxel: Option<Rows>,
    #[serde(default = "one")]
    slope: f64,
    #[serde(default)]
    intercept: f64,
    #[serde(default)]
    modality: Modality,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
}

fn one() -> f64 {
    1.0
}

impl Description {
    pub(crate) fn of(volume: &Volume) -> Self {
        Self {
            dims: volume.dims(),
            spacing: None,
            patient_from_voxel: Some(rows(volume.patient_from_voxel())),
            slope: volume.slope(),
            intercept: volume.intercept(),
            modality: volume.modality(),
            unit: Some(volume.unit().to_owned()),
        }
    }

    fn place(&self) -> Result<DAffine3, JsError> {
        match (self.spacing, self.patient_from_voxel) {
            (Some(_), Some(_)) => {
                Err(wrong("spacing and patientFromVoxel both say where voxels are: leave one out"))
            }
            (_, Some(rows)) => Ok(affine(rows)),
            (Some(spacing), None) if !spacing.iter().all(|mm| *mm > 0.0) => {
                Err(wrong("spacing is the distances between voxels in mm, each above 0"))
            }
            (spacing, None) => {
                let spacing = DVec3::from_array(spacing.unwrap_or([1.0; 3]));
                Ok(DAffine3::from_mat3(DMat3::from_diagonal(spacing)))
            }
        }
    }
}

/// A label's name and colour, by the value that its voxels have.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Named {
    value: u8,
    name: String,
    #[serde(default)]
    color: Option<[f64; 3]>,
}

/// A typed array's numbers, and what is added to each to get what was meant.
fn samples(array: &JsValue) -> Result<(Voxels, f64), JsError> {
    if let Some(array) = array.dyn_ref::<Uint8Array>() {
        return Ok((Voxels::U8(array.to_vec()), 0.0));
    }
    if let Some(array) = array.dyn_ref::<Uint8ClampedArray>() {
        return Ok((Voxels::U8(array.to_vec()), 0.0));
    }
    if let Some(array) = array.dyn_ref::<Int8Array>() {
        let voxels = array.to_vec().into_iter().map(|sample| sample.cast_unsigned() ^ 0x80);
        return Ok((Voxels::U8(voxels.collect()), -128.0));
    }
    if let Some(array) = array.dyn_ref::<Uint16Array>() {
        return Ok((Voxels::U16(array.to_vec()), 0.0));
    }
    if let Some(array) = array.dyn_ref::<Int16Array>() {
        let voxels = array.to_vec().into_iter().map(|sample| sample.cast_unsigned() ^ 0x8000);
        return Ok((Voxels::U16(voxels.collect()), -32_768.0));
    }
    if let Some(array) = array.dyn_ref::<Float32Array>() {
        return Ok((Voxels::F32(array.to_vec()), 0.0));
    }
    // GPUs compute with floats of 32 bits.
    if let Some(array) = array.dyn_ref::<Float64Array>() {
        return Ok((Voxels::F32(array.to_vec().into_iter().map(|sample| sample as f32).collect()), 0.0));
    }
    if let Some(array) = array.dyn_ref::<Int32Array>() {
        return Ok((Voxels::F32(array.to_vec().into_iter().map(|sample| sample as f32).collect()), 0.0));
    }
    if let Some(array) = array.dyn_ref::<Uint32Array>() {
        return Ok((Voxels::F32(array.to_vec().into_iter().map(|sample| sample as f32).collect()), 0.0));
    }
    Err(wrong("voxels are a typed array of numbers, such as an Int16Array"))
}

/// Voxels with their place in the patient, labels of them, and how deep they lie below the skin.
#[wasm_bindgen]
#[derive(Clone)]
pub struct Scan {
    volume: Arc<Volume>,
    labels: Option<Arc<LabelVolume>>,
    depth: Option<Arc<Volume>>,
}

impl Scan {
    /// As a scene has it; how much is taken off from the skin its document says.
    pub(crate) fn part(&self) -> Part {
        let peel = self.depth.clone().map(|depth| Peel { depth, mm: 0.0 });
        Part { volume: self.volume.clone(), labels: self.labels.clone(), peel }
    }
}

#[wasm_bindgen]
impl Scan {
    /// Of a typed array, x fastest, and JSON of what is said of it.
    ///
    /// # Errors
    /// What does not fit together.
    #[wasm_bindgen(constructor)]
    pub fn new(voxels: &JsValue, description: &str) -> Result<Scan, JsError> {
        let description: Description = serde_json::from_str(description).map_err(wrong)?;
        let (voxels, offset) = samples(voxels)?;
        let place = description.place()?;
        let rescale = [description.slope, description.intercept + offset * description.slope];
        let volume =
            Volume::new(description.dims, voxels, rescale, place, description.modality).map_err(wrong)?;
        let volume = match description.unit {
            Some(unit) => volume.with_unit(unit),
            None => volume,
        };
        Ok(Self { volume: Arc::new(volume), labels: None, depth: None })
    }

    /// A head that nobody has, of so many voxels along each axis.
    ///
    /// # Errors
    /// Where it would be larger than there is memory for.
    pub fn phantom(size: usize) -> Result<Scan, JsError> {
        let options = AnatomyOptions { size, ..AnatomyOptions::default() };
        let volume = anatomy(options, Progress::SILENT, &CancelToken::new()).map_err(wrong)?;
        Ok(Self { volume: Arc::new(volume), labels: None, depth: None })
    }

    /// Says of each voxel which label it has, and names them: JSON of a list of `value`, `name` and `color`.
    ///
    /// # Errors
    /// What does not fit together.
    #[wasm_bindgen(js_name = setLabels)]
    pub fn set_labels(&mut self, voxels: &Uint8Array, names: &str) -> Result<(), JsError> {
        let named: Vec<Named> = serde_json::from_str(names).map_err(wrong)?;
        let label = |named: Named| {
            let color = named.color.unwrap_or_else(|| lumivox_import::default_label_color(named.value));
            Label { value: named.value, name: named.name, color }
        };
        let labels = named.into_iter().map(label).collect();
        let place = self.volume.patient_from_voxel();
        let labels = LabelVolume::new(self.volume.dims(), voxels.to_vec(), place, labels).map_err(wrong)?;
        self.labels = Some(Arc::new(labels));
        Ok(())
    }

    /// Says how deep the patient's points lie below the skin: by another scan, of any grid, whose values are millimetres.
    #[wasm_bindgen(js_name = setDepth)]
    pub fn set_depth(&mut self, depth: &Scan) {
        self.depth = Some(depth.volume.clone());
    }

    /// Another owner of the same voxels.
    pub fn share(&self) -> Scan {
        self.clone()
    }

    /// Voxels along x, y and z.
    #[wasm_bindgen(getter)]
    pub fn dims(&self) -> Vec<usize> {
        self.volume.dims().to_vec()
    }

    /// The lowest and the highest value.
    #[wasm_bindgen(getter, js_name = valueRange)]
    pub fn value_range(&self) -> Vec<f64> {
        self.volume.value_range().to_vec()
    }

    /// What values are measured in, such as `HU`; empty where that is not known.
    #[wasm_bindgen(getter)]
    pub fn unit(&self) -> String {
        self.volume.unit().to_owned()
    }

    /// The look that suits it.
    #[wasm_bindgen(getter)]
    pub fn preset(&self) -> String {
        Preset::default_for(&self.volume).name().to_owned()
    }
}
