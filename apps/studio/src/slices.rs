//! Slices through a scan along the patient's own axes, as radiologists look at them.

use eframe::egui::{Color32, ColorImage};
use lumivox_core::glam::{DVec2, DVec3};
use lumivox_core::{Modality, Volume};
use rayon::prelude::*;

/// A plane of the patient.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Plane {
    /// Across the body, seen from the feet.
    Axial,
    /// Seen from the front.
    Coronal,
    /// Seen from the patient's left.
    Sagittal,
}

impl Plane {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Axial, Self::Coronal, Self::Sagittal];

    /// Where the image's right and bottom lie in the patient (LPS), and the way from slice to slice. Radiological: the patient's
    /// right is at the image's left.
    pub fn axes(self) -> [DVec3; 3] {
        match self {
            Self::Axial => [DVec3::X, DVec3::Y, DVec3::Z],
            Self::Coronal => [DVec3::X, DVec3::NEG_Z, DVec3::Y],
            Self::Sagittal => [DVec3::Y, DVec3::NEG_Z, DVec3::X],
        }
    }

    /// What lies at the image's left, right, top and bottom edge.
    pub fn letters(self) -> [&'static str; 4] {
        match self {
            Self::Axial => ["R", "L", "A", "P"],
            Self::Coronal => ["R", "L", "H", "F"],
            Self::Sagittal => ["A", "P", "H", "F"],
        }
    }
}

/// The corners of a scan's box along the patient's axes, in mm.
pub fn bounds_mm(volume: &Volume) -> [DVec3; 2] {
    let from_box = volume.patient_from_box();
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let corners = (0..8).map(|i| from_box.transform_point3(corner(i)));
    corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Which part of a plane an image shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// The plane.
    pub plane: Plane,
    /// The middle of the image, in the patient's mm.
    pub center: DVec3,
    /// Millimetres of a pixel.
    pub mm_per_pixel: f64,
    /// Pixels across and down.
    pub size: [usize; 2],
}

impl Geometry {
    /// All of a scan in an image of so many pixels, through a point; `zoom` times as large, moved by so many mm.
    pub fn new(
        volume: &Volume,
        plane: Plane,
        through: DVec3,
        size: [usize; 2],
        zoom: f64,
        moved: DVec2,
    ) -> Self {
        /// Room for letters at the edges.
        const MARGIN: f64 = 1.12;
        let [low, high] = bounds_mm(volume);
        let [right, down, normal] = plane.axes();
        let extent = |axis: DVec3| (high - low).dot(axis).abs().max(1e-6);
        let size = size.map(|n| n.max(1));
        let fit = (extent(right) / size[0] as f64).max(extent(down) / size[1] as f64) * MARGIN;
        let middle = 0.5 * (low + high);
        let center = middle + normal * (through - middle).dot(normal) - right * moved.x - down * moved.y;
        Self { plane, center, mm_per_pixel: fit / zoom.max(1e-3), size }
    }

    /// The point of the patient at a place of the image, in pixels.
    pub fn point(&self, [x, y]: [f64; 2]) -> DVec3 {
        let [right, down, _] = self.plane.axes();
        let [x, y] = [x - 0.5 * self.size[0] as f64, y - 0.5 * self.size[1] as f64];
        self.center + (right * x + down * y) * self.mm_per_pixel
    }

    /// Where a point of the patient lies in the image, in pixels, along the way from slice to slice.
    pub fn pixel(&self, point: DVec3) -> [f64; 2] {
        let [right, down, _] = self.plane.axes();
        let by = (point - self.center) / self.mm_per_pixel;
        [by.dot(right) + 0.5 * self.size[0] as f64, by.dot(down) + 0.5 * self.size[1] as f64]
    }
}

/// What becomes black and white: the middle and the width, in the scan's unit.
pub type Window = [f64; 2];

/// The window that suits: soft tissue of a CT, nearly all values of others.
pub fn window_for(volume: &Volume) -> Window {
    if volume.modality() == Modality::Ct && volume.is_hounsfield() {
        return [40.0, 400.0];
    }
    let [low, high] = match volume.percentiles(&[0.01, 0.995])[..] {
        [low, high] if high > low => [low, high],
        _ => volume.value_range(),
    };
    [0.5 * (low + high), (high - low).max(1e-9)]
}

/// A slice as it is shown; what lies outside of the scan is clear.
pub fn image(volume: &Volume, geometry: &Geometry, [level, width]: Window) -> ColorImage {
    let voxel_from_patient = volume.patient_from_voxel().inverse();
    let [columns, rows] = geometry.size;
    let first = voxel_from_patient.transform_point3(geometry.point([0.5, 0.5]));
    let [right, down, _] =
        geometry.plane.axes().map(|axis| voxel_from_patient.transform_vector3(axis) * geometry.mm_per_pixel);
    let low = level - 0.5 * width;
    let mut pixels = vec![Color32::TRANSPARENT; columns * rows];
    pixels.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
        let start = first + down * row as f64;
        for (column, pixel) in line.iter_mut().enumerate() {
            if let Some(value) = volume.interpolated(start + right * column as f64) {
                let part = ((value - low) / width.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                *pixel = Color32::from_gray((part * 255.0 + 0.5) as u8);
            }
        }
    });
    ColorImage::new([columns, rows], pixels)
}

/// The value of a scan at a point of the patient, between the voxels.
pub fn value_at(volume: &Volume, point: DVec3) -> Option<f64> {
    volume.interpolated(volume.patient_from_voxel().inverse().transform_point3(point))
}
