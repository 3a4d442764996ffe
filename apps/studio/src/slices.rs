//! Slices through a scan as radiologists look at them: along the patient's own axes or turned, thin or through a slab.

use eframe::egui::{Color32, ColorImage};
use lumivox_core::glam::{DVec2, DVec3};
use lumivox_core::placement::side_letters;
use lumivox_core::{Modality, Volume};
use rayon::prelude::*;

use crate::overlay::Overlay;

/// A plane of the patient.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Plane {
    /// Across the body, seen from the feet.
    Axial,
    /// Seen from the front.
    Coronal,
    /// Seen from the patient's left.
    Sagittal,
    /// Turned as a person likes; a coronal one before that.
    Oblique,
}

/// Where an image's right and bottom lie in the patient (LPS), and the way from slice to slice. All are of length 1.
pub type Axes = [DVec3; 3];

impl Plane {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Axial, Self::Coronal, Self::Sagittal, Self::Oblique];

    /// Its place among all.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The axes of a plane that is not turned. Radiological: the patient's right is at the image's left.
    pub fn axes(self) -> Axes {
        match self {
            Self::Axial => [DVec3::X, DVec3::Y, DVec3::Z],
            Self::Coronal | Self::Oblique => [DVec3::X, DVec3::NEG_Z, DVec3::Y],
            Self::Sagittal => [DVec3::Y, DVec3::NEG_Z, DVec3::X],
        }
    }
}

/// What lies at the image's left, right, top and bottom edge.
pub fn edge_letters([right, down, _]: Axes) -> [String; 4] {
    [-right, right, -down, down].map(direction_letters)
}

/// A direction by the patient's own sides, the one that it runs along most first: `A`, of a turned one `AR`.
pub fn direction_letters(direction: DVec3) -> String {
    /// What it runs along less than that, about 15 degrees, is not said.
    const LEAST: f64 = 0.26;
    side_letters(direction, LEAST)
}

/// The corners of a scan's box along the patient's axes, in mm.
pub fn bounds_mm(volume: &Volume) -> [DVec3; 2] {
    let along = |axis: DVec3| reach_mm(volume, axis);
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(along);
    [0, 1].map(|end| DVec3::new(x[end], y[end], z[end]))
}

/// From where to where a scan's box reaches along a direction, in mm.
pub fn reach_mm(volume: &Volume, direction: DVec3) -> [f64; 2] {
    let from_box = volume.patient_from_box();
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let along = (0..8).map(|i| from_box.transform_point3(corner(i)).dot(direction));
    along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
}

/// From voxel to voxel along the axis of the grid that runs most along a direction, in mm along that.
pub fn step_mm(volume: &Volume, direction: DVec3) -> f64 {
    let columns = volume.patient_from_voxel().matrix3;
    let along = [columns.x_axis, columns.y_axis, columns.z_axis].map(|axis| axis.dot(direction).abs());
    along.into_iter().fold(1e-6, f64::max)
}

/// Which part of a plane an image shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// The plane.
    pub axes: Axes,
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
        axes: Axes,
        through: DVec3,
        size: [usize; 2],
        zoom: f64,
        moved: DVec2,
    ) -> Self {
        /// Room for letters at the edges.
        const MARGIN: f64 = 1.12;
        let [right, down, normal] = axes;
        let [across, along] = [right, down].map(|axis| reach_mm(volume, axis));
        let size = size.map(|n| n.max(1));
        let extent = |[low, high]: [f64; 2]| (high - low).max(1e-6);
        let fit = (extent(across) / size[0] as f64).max(extent(along) / size[1] as f64) * MARGIN;
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        let center = right * (middle(across) - moved.x)
            + down * (middle(along) - moved.y)
            + normal * through.dot(normal);
        Self { axes, center, mm_per_pixel: fit / zoom.max(1e-3), size }
    }

    /// The point of the patient at a place of the image, in pixels.
    pub fn point(&self, [x, y]: [f64; 2]) -> DVec3 {
        let [right, down, _] = self.axes;
        let [x, y] = [x - 0.5 * self.size[0] as f64, y - 0.5 * self.size[1] as f64];
        self.center + (right * x + down * y) * self.mm_per_pixel
    }

    /// Where a point of the patient lies in the image, in pixels, along the way from slice to slice.
    pub fn pixel(&self, point: DVec3) -> [f64; 2] {
        let [right, down, _] = self.axes;
        let by = (point - self.center) / self.mm_per_pixel;
        [by.dot(right) + 0.5 * self.size[0] as f64, by.dot(down) + 0.5 * self.size[1] as f64]
    }

    /// How far a point lies before or behind the plane, in mm.
    pub fn distance_mm(&self, point: DVec3) -> f64 {
        (point - self.center).dot(self.axes[2]).abs()
    }
}

/// What a part of a scan's box, in fractions along its axes, leaves of a plane: the corners of that in the patient, around. None
/// where the plane passes by.
pub fn outline(volume: &Volume, [low, high]: [[f64; 3]; 2], geometry: &Geometry) -> Vec<DVec3> {
    let [right, down, normal] = geometry.axes;
    let from_box = volume.patient_from_box();
    let corner = |i: usize| {
        let at = [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] });
        from_box.transform_point3(DVec3::from_array(at))
    };
    let edges = (0..8)
        .flat_map(|i| (0..3).filter(move |axis| i >> axis & 1 == 0).map(move |axis| (i, i | 1 << axis)));
    let crossed = edges.filter_map(|(from, to)| {
        let [from, to] = [corner(from), corner(to)];
        let [before, behind] = [from, to].map(|point| (point - geometry.center).dot(normal));
        (before * behind <= 0.0 && before != behind).then(|| from.lerp(to, before / (before - behind)))
    });
    let mut points: Vec<DVec3> = crossed.collect();
    if points.len() < 3 {
        return vec![];
    }
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let angle = |point: &DVec3| (*point - middle).dot(down).atan2((*point - middle).dot(right));
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points
}

/// An ellipse about a point by its half-axes, as a closed line of many points.
pub fn ellipse(center: DVec3, first: DVec3, second: DVec3) -> impl Iterator<Item = DVec3> {
    const POINTS: i32 = 48;
    (0..=POINTS).map(move |i| {
        let (sin, cos) = (f64::from(i) / f64::from(POINTS) * std::f64::consts::TAU).sin_cos();
        center + first * cos + second * sin
    })
}

/// What becomes black and white: the middle and the width, in the scan's unit.
pub type Window = [f64; 2];

/// The window that suits: soft tissue of a CT, nearly all values of others.
pub fn window_for(volume: &Volume) -> Window {
    if volume.modality() == Modality::Ct && volume.is_hounsfield() {
        return [40.0, 400.0];
    }
    window_between(volume, [0.01, 0.995])
}

/// The window from a fraction of the voxels to another.
pub fn window_between(volume: &Volume, fractions: [f64; 2]) -> Window {
    let [low, high] = match volume.percentiles(&fractions)[..] {
        [low, high] if high > low => [low, high],
        _ => volume.value_range(),
    };
    [0.5 * (low + high), (high - low).max(1e-9)]
}

/// What is seen of a slab.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Projection {
    /// No slab: the plane itself.
    #[default]
    Thin,
    /// The largest value: vessels, bone, nodules.
    Maximum,
    /// The mean: thick slices with less noise.
    Mean,
    /// The smallest value: airways.
    Minimum,
}

impl Projection {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Thin, Self::Maximum, Self::Mean, Self::Minimum];
}

/// How thick a slice is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// What is seen of it.
    pub projection: Projection,
    /// Millimetres from its front to its back.
    pub thickness_mm: f64,
}

impl Default for Slab {
    fn default() -> Self {
        Self { projection: Projection::Thin, thickness_mm: 10.0 }
    }
}

impl Slab {
    /// Millimetres that are seen before and behind the plane.
    pub fn half_mm(&self) -> f64 {
        if self.projection == Projection::Thin { 0.0 } else { 0.5 * self.thickness_mm.max(0.0) }
    }

    /// Where it is looked at, in mm along the normal: as often as the scan has voxels there.
    fn depths_mm(&self, volume: &Volume, normal: DVec3) -> Vec<f64> {
        let half = self.half_mm();
        // As many before the plane as behind it, which is looked at, too.
        let steps = (half / step_mm(volume, normal)).ceil().min(2048.0) as i32;
        (-steps..=steps).map(|i| if i == 0 { 0.0 } else { half * f64::from(i) / f64::from(steps) }).collect()
    }

    /// What is seen of the values along a line through it; `None` where none is in the scan.
    fn seen(self, values: impl Iterator<Item = f64>) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0);
        for value in values {
            sum = match self.projection {
                _ if count == 0 => value,
                Projection::Maximum => value.max(sum),
                Projection::Minimum => value.min(sum),
                Projection::Mean | Projection::Thin => sum + value,
            };
            count += 1;
        }
        match self.projection {
            _ if count == 0 => None,
            Projection::Mean => Some(sum / f64::from(count)),
            _ => Some(sum),
        }
    }
}

/// A slice as it is shown; what lies outside of the scan is clear.
pub fn image(
    volume: &Volume,
    geometry: &Geometry,
    [level, width]: Window,
    slab: Slab,
    overlay: Option<&Overlay>,
) -> ColorImage {
    let voxel_from_patient = volume.patient_from_voxel().inverse();
    let [columns, rows] = geometry.size;
    let first = voxel_from_patient.transform_point3(geometry.point([0.5, 0.5]));
    let [right, down, _] =
        geometry.axes.map(|axis| voxel_from_patient.transform_vector3(axis) * geometry.mm_per_pixel);
    let normal = geometry.axes[2];
    let along = voxel_from_patient.transform_vector3(normal);
    let depths: Vec<DVec3> = slab.depths_mm(volume, normal).into_iter().map(|mm| along * mm).collect();
    let low = level - 0.5 * width;
    let mut pixels = vec![Color32::TRANSPARENT; columns * rows];
    pixels.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
        let start = first + down * row as f64;
        for (column, pixel) in line.iter_mut().enumerate() {
            let at = start + right * column as f64;
            let values = depths.iter().filter_map(|depth| volume.interpolated(at + *depth));
            if let Some(value) = slab.seen(values) {
                let part = ((value - low) / width.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                *pixel = Color32::from_gray((part * 255.0 + 0.5) as u8);
                if let Some(overlay) = overlay {
                    let point = geometry.point([column as f64 + 0.5, row as f64 + 0.5]);
                    *pixel = overlay.over(*pixel, point);
                }
            }
        }
    });
    ColorImage::new([columns, rows], pixels)
}

/// The value that a slice shows of a point of the patient, between the voxels.
pub fn value_at(volume: &Volume, point: DVec3, normal: DVec3, slab: Slab) -> Option<f64> {
    let voxel_from_patient = volume.patient_from_voxel().inverse();
    let depths = slab.depths_mm(volume, normal);
    let at = |mm: &f64| volume.interpolated(voxel_from_patient.transform_point3(point + normal * *mm));
    slab.seen(depths.iter().filter_map(at))
}
