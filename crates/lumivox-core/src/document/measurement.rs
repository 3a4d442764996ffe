//! What was measured in a scan, and what that says: lengths, angles, and the values within a region.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{numbers::Faults, ranges};
use crate::volume::Volume;

/// Something that was measured, by points of the first scan's patient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Measurement {
    /// What it is.
    pub kind: MeasurementKind,
    /// Points in the patient (LPS), in mm: two of a distance; three of an angle, at the second of them; three of a region, an ellipse
    /// by its centre and an end of each half-axis.
    #[cfg_attr(test, schemars(length(min = 2, max = 3), transform = ranges::schema::points))]
    pub points: Vec<[f64; 3]>,
}

/// A kind of measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum MeasurementKind {
    /// From a point to another.
    Distance,
    /// Between two ways from a point.
    Angle,
    /// The values within an ellipse.
    Region,
}

impl MeasurementKind {
    /// How many points it has.
    pub fn points(self) -> usize {
        match self {
            Self::Distance => 2,
            Self::Angle | Self::Region => 3,
        }
    }
}

/// What a measurement says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// Millimetres.
    Length(f64),
    /// Degrees, 0 to 180.
    Angle(f64),
    /// An ellipse.
    Region {
        /// Square millimetres within it.
        area_mm2: f64,
        /// Its values; `None` where no voxel lies in it.
        values: Option<RegionValues>,
    },
}

/// Values of a region, in the scan's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionValues {
    /// How many there are.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// The root of their mean square distance from that.
    pub standard_deviation: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Measurement {
    /// What it says of a scan. `None` where it does not have the points of its kind.
    pub fn measured(&self, volume: &Volume) -> Option<Measured> {
        let at = |index: usize| DVec3::from_array(self.points[index]);
        if self.points.len() != self.kind.points() {
            return None;
        }
        Some(match self.kind {
            MeasurementKind::Distance => Measured::Length(at(0).distance(at(1))),
            MeasurementKind::Angle => {
                let [one, other] = [at(0) - at(1), at(2) - at(1)];
                // The arc tangent is exact at 0 and 180 degrees, too.
                Measured::Angle(one.cross(other).length().atan2(one.dot(other)).to_degrees())
            }
            MeasurementKind::Region => {
                let ellipse = Ellipse::new(at(0), at(1), at(2));
                Measured::Region { area_mm2: ellipse.area_mm2(), values: ellipse.values(volume) }
            }
        })
    }

    pub(super) fn check(&self, faults: &mut Faults) {
        let (is, needs) = (self.points.len(), self.kind.points());
        faults.unless(is == needs, "points", || format!("there are {is} points, where {needs} are needed"));
        for point in &self.points {
            faults.numbers("points", Some(*point), ranges::COORDINATE);
        }
    }
}

/// An ellipse in the patient.
struct Ellipse {
    center: DVec3,
    /// Half-axes in mm, square to each other.
    half_axes: [DVec3; 2],
}

impl Ellipse {
    fn new(center: DVec3, end: DVec3, other_end: DVec3) -> Self {
        let first = end - center;
        let second = other_end - center;
        let along = second.dot(first) / first.length_squared().max(f64::MIN_POSITIVE);
        Self { center, half_axes: [first, second - first * along] }
    }

    fn area_mm2(&self) -> f64 {
        std::f64::consts::PI * self.half_axes[0].length() * self.half_axes[1].length()
    }

    fn holds(&self, point: DVec3) -> bool {
        let by = point - self.center;
        let share = |axis: DVec3| by.dot(axis) / axis.length_squared();
        // Of an ellipse without a width it is no number.
        self.half_axes.iter().map(|axis| share(*axis).powi(2)).sum::<f64>() <= 1.0
    }

    /// The voxels whose centres lie in it where it lies in a slice of the scan, the nearest one; of a plane that is turned, values
    /// between voxels, as far from each other as these are.
    fn values(&self, volume: &Volume) -> Option<RegionValues> {
        let [first, second] = self.half_axes;
        let normal = first.cross(second).normalize_or_zero();
        let axes = volume.directions();
        let across = |axis: usize| axes.col(axis).dot(normal).abs() < 1e-3;
        let through = (0..3).find(|axis| (0..3).all(|other| other == *axis || across(other)));
        let values = match through {
            Some(axis) => self.voxels(volume, axis),
            None => self.between_voxels(volume),
        };
        summary(&values)
    }

    fn voxels(&self, volume: &Volume, through: usize) -> Vec<f64> {
        let patient_from_voxel = volume.patient_from_voxel();
        let voxel_from_patient = patient_from_voxel.inverse();
        let dims = volume.dims();
        let middle = voxel_from_patient.transform_point3(self.center);
        let reach: DVec3 =
            self.half_axes.iter().map(|axis| voxel_from_patient.transform_vector3(*axis).abs()).sum();
        let range = |axis: usize| {
            let last = dims[axis] as f64 - 1.0;
            let [low, high] = if axis == through {
                [middle[axis].round(); 2]
            } else {
                [(middle[axis] - reach[axis]).ceil(), (middle[axis] + reach[axis]).floor()]
            };
            let is_there = high >= 0.0 && low <= last;
            if is_there { low.max(0.0) as usize..high.min(last) as usize + 1 } else { 0..0 }
        };
        // Where the slice lies is up to its own: only what lies within it counts.
        let flat = |point: DVec3| {
            let normal = self.half_axes[0].cross(self.half_axes[1]).normalize_or_zero();
            point - normal * (point - self.center).dot(normal)
        };
        let mut values = vec![];
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let point = patient_from_voxel.transform_point3(DVec3::new(x as f64, y as f64, z as f64));
                    if self.holds(flat(point)) {
                        values.push(volume.value([x, y, z]));
                    }
                }
            }
        }
        values
    }

    fn between_voxels(&self, volume: &Volume) -> Vec<f64> {
        /// More is not looked at along a half-axis.
        const MOST: f64 = 2000.0;
        let voxel_from_patient = volume.patient_from_voxel().inverse();
        let step_mm = volume.spacing_mm().min_element();
        let count = self.half_axes.map(|axis| (axis.length() / step_mm).min(MOST) as i64);
        let step = self.half_axes.map(|axis| axis.normalize_or_zero() * step_mm);
        let mut values = vec![];
        for i in -count[0]..=count[0] {
            for j in -count[1]..=count[1] {
                let point = self.center + step[0] * i as f64 + step[1] * j as f64;
                if self.holds(point) {
                    values.extend(volume.interpolated(voxel_from_patient.transform_point3(point)));
                }
            }
        }
        values
    }
}

fn summary(values: &[f64]) -> Option<RegionValues> {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count as f64;
    (count > 0).then(|| RegionValues {
        count,
        mean,
        standard_deviation: square.sqrt(),
        min: values.iter().copied().fold(f64::INFINITY, f64::min),
        max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    })
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3};

    use super::*;
    use crate::volume::{Modality, Voxels};

    /// Values that rise by 10 along x, 1 along y and 100 along z, in voxels of 2 x 1 x 3 mm that are turned about z.
    fn ramp(turn: f64) -> Volume {
        let dims = [40, 60, 9];
        let value = |i: usize| (10 * (i % 40) + i / 40 % 60 + 100 * (i / 2400)) as u16;
        let place = DAffine3::from_mat3_translation(
            DMat3::from_rotation_z(turn) * DMat3::from_diagonal(DVec3::new(2.0, 1.0, 3.0)),
            DVec3::new(-40.0, 7.0, 100.0),
        );
        let samples = Voxels::U16((0..dims.iter().product()).map(value).collect());
        Volume::new(dims, samples, [1.0, 0.0], place, Modality::Other).unwrap()
    }

    fn measured(volume: &Volume, kind: MeasurementKind, points: &[DVec3]) -> Option<Measured> {
        Measurement { kind, points: points.iter().map(DVec3::to_array).collect() }.measured(volume)
    }

    #[test]
    fn lengths_and_angles_are_those_of_the_points() {
        let volume = ramp(0.0);
        let at = DVec3::new(1.0, 2.0, 3.0);
        let length = measured(&volume, MeasurementKind::Distance, &[at, at + DVec3::new(2.0, 3.0, 6.0)]);
        assert_eq!(length, Some(Measured::Length(7.0)));
        for degrees in [0.0_f64, 30.0, 90.0, 179.0, 180.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let points = [at + DVec3::X * 5.0, at, at + DVec3::new(cos, 0.0, sin) * 9.0];
            let Some(Measured::Angle(found)) = measured(&volume, MeasurementKind::Angle, &points) else {
                panic!("an angle")
            };
            assert!((found - degrees).abs() < 1e-6, "{found} {degrees}");
        }
        assert_eq!(measured(&volume, MeasurementKind::Angle, &[at, at]), None);
    }

    #[test]
    fn a_region_in_a_slice_is_of_its_voxels() {
        for turn in [0.0, 0.4] {
            let volume = ramp(turn);
            let center = volume.patient_from_voxel().transform_point3(DVec3::new(20.0, 30.0, 4.2));
            let axes = volume.directions();
            // 4.1 voxels across, 8.2 down: the nearest slice is 4.
            let ends = [center + axes.x_axis * 8.2, center + axes.y_axis * 8.2];
            let points = [center, ends[0], ends[1]];
            let Some(Measured::Region { area_mm2, values: Some(values) }) =
                measured(&volume, MeasurementKind::Region, &points)
            else {
                panic!("a region with values")
            };
            assert!((area_mm2 - std::f64::consts::PI * 8.2 * 8.2).abs() < 1e-6);
            let mut wanted = vec![];
            for i in -4_i32..=4 {
                for j in -8_i32..=8 {
                    if f64::from(2 * i).hypot(f64::from(j)) <= 8.2 {
                        wanted.push(f64::from(10 * (20 + i) + 30 + j + 400));
                    }
                }
            }
            let mean = wanted.iter().sum::<f64>() / wanted.len() as f64;
            assert_eq!((values.count, values.mean), (wanted.len(), mean));
            assert_eq!((values.min, values.max), (589.0, 671.0));
            assert!(values.standard_deviation > 20.0);
        }
    }

    #[test]
    fn a_region_in_a_plane_that_is_turned_is_of_values_between_voxels() {
        let volume = ramp(0.0);
        let at = DVec3::new(20.0, 30.0, 4.0);
        let center = volume.patient_from_voxel().transform_point3(at);
        let points = [center, center + DVec3::new(6.0, 0.0, 6.0), center + DVec3::Y * 6.0];
        let Some(Measured::Region { values: Some(values), .. }) =
            measured(&volume, MeasurementKind::Region, &points)
        else {
            panic!("a region with values")
        };
        assert!((values.mean - 630.0).abs() < 1e-3 && values.count > 100, "{values:?}");
        // Beside the scan there is nothing.
        let far = points.map(|point| point + DVec3::X * 500.0);
        let Some(Measured::Region { values, area_mm2 }) = measured(&volume, MeasurementKind::Region, &far)
        else {
            panic!("a region")
        };
        assert!(values.is_none() && area_mm2 > 100.0);
    }
}
