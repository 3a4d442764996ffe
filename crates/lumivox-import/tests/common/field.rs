//! Series whose every voxel says where in the patient it is.

use std::path::Path;

use lumivox_core::{
    Volume,
    glam::{DVec2, DVec3},
};
use lumivox_import::Imported;

use super::common::load;
use super::writer::*;

/// A field without any symmetry that linear interpolation keeps.
pub fn field(place: DVec3) -> f64 {
    3.0 * place.x + 7.0 * place.y + 11.0 * place.z
}

/// A series to be written.
pub struct Series {
    pub row: DVec3,
    pub column: DVec3,
    pub spacing: DVec2,
    /// Of the first pixel of each slice, in the order of the files.
    pub places: Vec<DVec3>,
    /// Slope and intercept by slice.
    pub rescale: fn(usize) -> [f64; 2],
    pub signed: bool,
    pub modality: &'static str,
}

pub const COLUMNS_N: u16 = 5;
pub const ROWS_N: u16 = 4;

impl Series {
    pub fn axial(places: Vec<DVec3>) -> Self {
        Self {
            row: DVec3::X,
            column: DVec3::Y,
            spacing: DVec2::new(2.0, 4.0),
            places,
            rescale: |_| [1.0, -2000.0],
            signed: false,
            modality: "CT",
        }
    }

    pub fn slice(&self, k: usize) -> Elements {
        let [slope, intercept] = (self.rescale)(k);
        let mut samples = Vec::new();
        for j in 0..ROWS_N {
            for i in 0..COLUMNS_N {
                let offset =
                    self.row * (self.spacing.x * i as f64) + self.column * (self.spacing.y * j as f64);
                let stored = ((field(self.places[k] + offset) - intercept) / slope).round();
                samples.push(if self.signed { stored as i16 as u16 } else { stored as u16 });
            }
        }
        let (r, c) = (self.row, self.column);
        image(self.modality, COLUMNS_N, ROWS_N, samples)
            .decimals(IMAGE_POSITION_PATIENT, &self.places[k].to_array())
            .decimals(IMAGE_ORIENTATION_PATIENT, &[r.x, r.y, r.z, c.x, c.y, c.z])
            // Rows first: y before x.
            .decimals(PIXEL_SPACING, &[self.spacing.y, self.spacing.x])
            .decimals(RESCALE_SLOPE, &[slope])
            .decimals(RESCALE_INTERCEPT, &[intercept])
            .text(INSTANCE_NUMBER, "IS", &(100 - k).to_string())
            .text(FRAME_OF_REFERENCE_UID, "UI", &format!("1.2.{k}"))
            .short(PIXEL_REPRESENTATION, self.signed.into())
    }

    pub fn write(&self, folder: &Path) {
        for k in 0..self.places.len() {
            self.slice(k).write(&folder.join(format!("{k:03}")), Syntax::Explicit);
        }
    }

    pub fn load(&self) -> Imported {
        let folder = tempfile::tempdir().unwrap();
        self.write(folder.path());
        load(folder.path()).unwrap()
    }
}

/// Every voxel has the field's value at its place.
pub fn assert_field(volume: &Volume, tolerance: f64) {
    let [nx, ny, nz] = volume.dims();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let place =
                    volume.patient_from_voxel().transform_point3(DVec3::new(x as f64, y as f64, z as f64));
                let (value, truth) = (volume.value([x, y, z]), field(place));
                assert!(
                    (value - truth).abs() <= tolerance,
                    "[{x}, {y}, {z}] at {place}: {value} is not {truth}"
                );
            }
        }
    }
}

/// Slices at these heights, in this order.
pub fn heights(z: &[f64]) -> Vec<DVec3> {
    z.iter().map(|&z| DVec3::new(-10.0, 20.0, z)).collect()
}
