//! Measurements as people read them: a line in a picture, a row of a list, a table for a file.

use std::collections::VecDeque;
use std::sync::Arc;

use lumivox_core::Volume;
use lumivox_core::document::{Measured, Measurement, MeasurementKind};
use lumivox_core::glam::DVec3;

use crate::slices::Axes;
use crate::state::ViewId;
use crate::words::{Language, Word};

/// A measurement that is being made: points, and where the next would be.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// What it becomes.
    pub kind: MeasurementKind,
    /// In which view.
    pub view: ViewId,
    /// Points of the patient that are placed, in mm.
    pub points: Vec<DVec3>,
    /// Where the pointer is, in the patient.
    pub next: Option<DVec3>,
}

/// Points that a person places for a measurement: an ellipse is drawn from corner to corner.
pub fn placed_points(kind: MeasurementKind) -> usize {
    match kind {
        MeasurementKind::Distance | MeasurementKind::Region => 2,
        MeasurementKind::Angle => 3,
    }
}

/// The measurement of points that a person placed in a plane; `None` where they are too few, or all one.
pub fn made(kind: MeasurementKind, points: &[DVec3], axes: Axes) -> Option<Measurement> {
    if points.len() != placed_points(kind) || points.windows(2).any(|pair| pair[0] == pair[1]) {
        return None;
    }
    let points = match kind {
        MeasurementKind::Distance | MeasurementKind::Angle => points.to_vec(),
        MeasurementKind::Region => {
            let [right, down, normal] = axes;
            let half = 0.5 * (points[1] - points[0]);
            // In the slice of the second point, where they lie in two.
            let center = points[1] - (half - normal * half.dot(normal));
            let ends = [right, down].map(|axis| axis * half.dot(axis).abs());
            if ends.contains(&DVec3::ZERO) {
                return None;
            }
            vec![center, center + ends[0], center + ends[1]]
        }
    };
    Some(Measurement { kind, points: points.iter().map(DVec3::to_array).collect() })
}

/// A measurement with one of its points moved: half-axes keep their direction, a centre takes them along.
pub fn moved(measurement: &Measurement, index: usize, to: DVec3) -> Measurement {
    let mut points: Vec<DVec3> = measurement.points.iter().copied().map(DVec3::from_array).collect();
    let is_region = measurement.kind == MeasurementKind::Region;
    match index {
        0 if is_region => {
            let by = to - points[0];
            points.iter_mut().for_each(|point| *point += by);
        }
        index if is_region => {
            let axis = (points[index] - points[0]).normalize_or_zero();
            let length = (to - points[0]).dot(axis).max(1e-3);
            points[index] = points[0] + axis * length;
        }
        index => points[index] = to,
    }
    Measurement { kind: measurement.kind, points: points.iter().map(DVec3::to_array).collect() }
}

/// What a kind is called.
pub fn kind_word(kind: MeasurementKind) -> Word {
    match kind {
        MeasurementKind::Distance => Word::Distance,
        MeasurementKind::Angle => Word::Angle,
        MeasurementKind::Region => Word::Region,
    }
}

/// What measurements say, once each: a region reads thousands of voxels, and stands in several views and a list, frame by frame.
#[derive(Default)]
pub struct Said {
    of: Option<(Arc<Volume>, Language)>,
    known: VecDeque<(Measurement, Vec<String>)>,
    /// How many were measured.
    pub count: u64,
}

impl Said {
    /// What a measurement says of a scan, in lines.
    pub fn lines(
        &mut self,
        measurement: &Measurement,
        scan: &Arc<Volume>,
        language: Language,
    ) -> Vec<String> {
        /// One that is drawn or dragged is another in each frame: the oldest are forgotten.
        const MOST: usize = 256;
        if !matches!(&self.of, Some((known, said)) if Arc::ptr_eq(known, scan) && *said == language) {
            self.of = Some((scan.clone(), language));
            self.known.clear();
        }
        if let Some((_, lines)) = self.known.iter().find(|(known, _)| known == measurement) {
            return lines.clone();
        }
        let lines = lines(measurement, scan, language);
        self.count += 1;
        self.known.truncate(MOST - 1);
        self.known.push_front((measurement.clone(), lines.clone()));
        lines
    }
}

/// What a measurement says, in lines: the first is enough for a list.
pub fn lines(measurement: &Measurement, scan: &Volume, language: Language) -> Vec<String> {
    let value = |value: f64| if value.abs() < 100.0 { format!("{value:.1}") } else { format!("{value:.0}") };
    let Some(measured) = measurement.measured(scan) else { return vec![] };
    match measured {
        Measured::Length(mm) => vec![format!("{mm:.1} mm")],
        Measured::Angle(degrees) => vec![format!("{degrees:.1}\u{b0}")],
        Measured::Region { area_mm2, values } => {
            let area = format!("{area_mm2:.0} mm\u{b2}");
            let Some(values) = values else { return vec![area] };
            let unit = match scan.unit() {
                "" => String::new(),
                unit => format!(" {unit}"),
            };
            vec![
                format!(
                    "{} {}{unit} \u{b1} {}",
                    Word::Mean.of(language),
                    value(values.mean),
                    value(values.standard_deviation)
                ),
                format!(
                    "{} {} \u{2026} {}  \u{b7}  {area}",
                    Word::Range.of(language),
                    value(values.min),
                    value(values.max)
                ),
            ]
        }
    }
}

/// All of them as a table, with what it is not for.
pub fn csv(measurements: &[Measurement], scan: &Volume) -> String {
    let mut table = format!("# {}\n", Word::NoDevice.of(Language::English));
    table += "number,kind,length_mm,angle_deg,area_mm2,voxels,mean,sd,min,max,unit,points_lps_mm\n";
    for (index, measurement) in measurements.iter().enumerate() {
        let exact = |x: f64| format!("{x:.4}");
        let none = || vec![String::new(); 5];
        let kind = Word::of(kind_word(measurement.kind), Language::English).to_lowercase();
        let [length, angle, area, values] = match measurement.measured(scan) {
            Some(Measured::Length(mm)) => [vec![exact(mm)], vec![String::new()], vec![String::new()], none()],
            Some(Measured::Angle(degrees)) => {
                [vec![String::new()], vec![exact(degrees)], vec![String::new()], none()]
            }
            Some(Measured::Region { area_mm2, values }) => {
                let values = values.map_or_else(none, |it| {
                    let numbers = [it.mean, it.standard_deviation, it.min, it.max].map(exact);
                    std::iter::once(it.count.to_string()).chain(numbers).collect()
                });
                [vec![String::new()], vec![String::new()], vec![exact(area_mm2)], values]
            }
            None => continue,
        };
        let points: Vec<String> =
            measurement.points.iter().map(|point| point.map(|x| format!("{x:.3}")).join(" ")).collect();
        let unit = if measurement.kind == MeasurementKind::Region { scan.unit() } else { "" };
        let mut row = vec![(index + 1).to_string(), kind];
        row.extend([length, angle, area, values].concat());
        row.extend([unit.to_owned(), points.join("; ")]);
        table += &(row.join(",") + "\n");
    }
    table
}
