//! From where slices lie in the patient to one even grid.
//!
//! Order and spacing come from ImagePositionPatient alone, projected on the slices' normal (PS3.3 C.7.6.2.1.1);
//! instance numbers, slice locations and file names are not to be trusted with either.

use lumivox_core::glam::{DAffine3, DMat3, DVec2, DVec3};

/// Slices lie evenly if none is farther from its even place than this part of the step; a writer's rounding of
/// positions stays below.
const EVEN: f64 = 0.05;
/// Slices nearer than this part of the usual gap lie at the same place.
const SAME_PLACE: f64 = 0.01;
/// A gap this many times the usual one parts two scans.
const APART: f64 = 16.0;
/// A smaller tilt is rounding.
const LEAST_TILT_DEGREES: f64 = 0.5;

/// What a note says of slices in a gap.
pub(crate) const FILLED_IN: &str = "filled in from the neighbours' values";

/// The common plane of a stack of slices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    /// Unit direction of growing column index.
    pub(crate) row_direction: DVec3,
    /// Unit direction of growing row index.
    pub(crate) column_direction: DVec3,
    /// Distance of neighbouring columns (x) and rows (y), in mm.
    pub(crate) spacing_mm: DVec2,
    /// What the step is where there is one slice only, in mm.
    pub(crate) thickness_mm: f64,
}

impl Plane {
    /// Unit normal, towards growing slice index.
    pub(crate) fn normal(&self) -> DVec3 {
        self.row_direction.cross(self.column_direction).normalize()
    }
}

/// Slices at one place, as indices in their own order.
pub(crate) type AtPlace = Vec<usize>;

/// Sorts slices along the normal into places, and parts them where a gap is far too large: each run is a scan of its
/// own.
pub(crate) fn sort_into_runs(plane: &Plane, places: &[DVec3]) -> Vec<Vec<AtPlace>> {
    let normal = plane.normal();
    let depths: Vec<f64> = places.iter().map(|place| place.dot(normal)).collect();
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| depths[a].total_cmp(&depths[b]));
    let gaps = order.windows(2).map(|pair| depths[pair[1]] - depths[pair[0]]);
    let usual = median(gaps.filter(|&gap| gap > 1e-4).collect()).unwrap_or(1.0);
    let mut runs: Vec<Vec<AtPlace>> = Vec::new();
    let mut before = f64::NEG_INFINITY;
    for index in order {
        let gap = depths[index] - before;
        before = depths[index];
        match runs.last_mut() {
            // Nearly equal places sort by rounding; the caller's order counts.
            Some(run) if gap <= usual * SAME_PLACE => {
                let place = run.last_mut().expect("runs are not empty");
                place.push(index);
                place.sort_unstable();
            }
            Some(run) if gap <= usual * APART => run.push(vec![index]),
            _ => runs.push(vec![vec![index]]),
        }
    }
    runs
}

/// What becomes of the slices: an even grid, and where each of its slices comes from.
#[derive(Debug)]
pub(crate) struct Grid {
    /// LPS millimetres from voxel indices.
    pub(crate) patient_from_voxel: DAffine3,
    /// For each slice of the grid, a given slice and how far it is (0 up to 1) towards the next given one; `None` if
    /// the given slices are the grid.
    pub(crate) sources: Option<Vec<(usize, f64)>>,
    /// Whether all that is not given is missing: the given slices themselves lie on the grid.
    pub(crate) has_gaps: bool,
    /// Sentences about what was found and done.
    pub(crate) notes: Vec<String>,
}

/// Makes a grid of slices whose first pixels lie at `places`, in order along the normal and no two at one place. Filling
/// gaps makes at most `most_slices` of them.
pub(crate) fn even_grid(plane: &Plane, places: &[DVec3], most_slices: usize) -> Grid {
    let normal = plane.normal();
    let (first, last) = (places[0], places[places.len() - 1]);
    let depths: Vec<f64> = places.iter().map(|place| (*place - first).dot(normal)).collect();
    let extent = depths[depths.len() - 1];
    let mut notes = Vec::new();

    let (slices, sources) = spread(&depths, most_slices, &mut notes);
    let has_gaps = notes.iter().any(|note| note.ends_with(FILLED_IN));
    let step = if slices > 1 { (last - first) / (slices - 1) as f64 } else { normal * plane.thickness_mm };
    if places.len() > 1 {
        note_tilt(step, normal, &mut notes);
        let line = (last - first) / extent;
        let off = places.iter().zip(&depths).map(|(place, depth)| place.distance(first + line * depth));
        let farthest = off.fold(0.0, f64::max);
        if farthest > plane.spacing_mm.min_element() {
            notes.push(format!(
                "the slices do not lie in one line; some are {farthest:.1} mm beside their place"
            ));
        }
    }
    let matrix = DMat3::from_cols(
        plane.row_direction * plane.spacing_mm.x,
        plane.column_direction * plane.spacing_mm.y,
        step,
    );
    Grid { patient_from_voxel: DAffine3 { matrix3: matrix, translation: first }, sources, has_gaps, notes }
}

fn note_tilt(step: DVec3, normal: DVec3, notes: &mut Vec<String>) {
    let tilt = step.angle_between(normal).to_degrees();
    if tilt > LEAST_TILT_DEGREES {
        notes.push(format!("gantry tilt {tilt:.1} degrees, kept as shear"));
    }
}

/// How many even slices, `most_slices` at most, cover `depths` (rising from 0), and where they come from.
fn spread(depths: &[f64], most_slices: usize, notes: &mut Vec<String>) -> (usize, Option<Vec<(usize, f64)>>) {
    let n = depths.len();
    let extent = depths[n - 1];
    if n < 3 || is_even(depths, (0..n).collect::<Vec<_>>().as_slice()) {
        return (n, None);
    }
    let gaps: Vec<f64> = depths.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let smallest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let usual = median(gaps.clone()).expect("there are gaps");
    for base in [usual, smallest] {
        let mut places = vec![0];
        for gap in &gaps {
            places.push(places[places.len() - 1] + (gap / base).round().max(1.0) as usize);
        }
        let total = places[n - 1] + 1;
        if total <= most_slices && is_even(depths, &places) {
            let missing = total - n;
            let verb = if missing == 1 { "is" } else { "are" };
            notes.push(format!("{missing} of {total} slices {verb} missing; {FILLED_IN}"));
            let sources = places.windows(2).enumerate().flat_map(|(k, pair)| {
                let length = pair[1] - pair[0];
                (0..length).map(move |i| (k, i as f64 / length as f64))
            });
            return (total, Some(sources.chain([(n - 1, 0.0)]).collect()));
        }
    }
    // No common step: as fine as the smallest gap, unless that costs too many slices.
    let steps = ((extent / smallest).ceil() as usize).clamp(1, most_slices.max(n) - 1);
    let largest = gaps.iter().copied().fold(0.0, f64::max);
    notes.push(format!(
        "the slices lie unevenly, {smallest:.3} to {largest:.3} mm apart; interpolated to {} slices {:.3} mm apart",
        steps + 1,
        extent / steps as f64
    ));
    let mut lower = 0;
    let sources = (0..=steps).map(|j| {
        let depth = extent * j as f64 / steps as f64;
        while lower + 2 < n && depths[lower + 1] <= depth {
            lower += 1;
        }
        let part = (depth - depths[lower]) / gaps[lower];
        // A slice that is (nearly) hit stays as it is.
        match part {
            ..0.001 => (lower, 0.0),
            0.999.. => (lower + 1, 0.0),
            part => (lower, part),
        }
    });
    (steps + 1, Some(sources.collect()))
}

/// Whether each of `depths` is near its place, given as a number of steps, of an even grid.
fn is_even(depths: &[f64], places: &[usize]) -> bool {
    let step = depths[depths.len() - 1] / places[places.len() - 1] as f64;
    depths.iter().zip(places).all(|(depth, &place)| (depth - place as f64 * step).abs() <= step * EVEN)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIAL: Plane = Plane {
        row_direction: DVec3::X,
        column_direction: DVec3::Y,
        spacing_mm: DVec2::new(0.5, 0.7),
        thickness_mm: 2.0,
    };

    fn along_z(depths: &[f64]) -> Vec<DVec3> {
        depths.iter().map(|&z| DVec3::new(3.0, 4.0, z)).collect()
    }

    #[test]
    fn even_slices_stay_as_they_are() {
        // Rounded to a tenth of a millimetre, as some scanners write them.
        let grid = even_grid(&AXIAL, &along_z(&[0.0, 1.2, 2.5, 3.7, 5.0]), 40);
        assert!(grid.sources.is_none() && grid.notes.is_empty());
        assert_eq!(grid.patient_from_voxel.matrix3, DMat3::from_diagonal(DVec3::new(0.5, 0.7, 1.25)));
        assert_eq!(grid.patient_from_voxel.translation, DVec3::new(3.0, 4.0, 0.0));
    }

    #[test]
    fn a_single_slice_is_as_thick_as_its_header_says() {
        let grid = even_grid(&AXIAL, &along_z(&[7.0]), 40);
        assert_eq!(grid.patient_from_voxel.matrix3.z_axis, DVec3::new(0.0, 0.0, 2.0));
    }

    #[test]
    fn missing_slices_are_placed_between_their_neighbours() {
        let grid = even_grid(&AXIAL, &along_z(&[0.0, 1.0, 2.0, 4.0, 5.0, 8.0]), 40);
        let third = 1.0 / 3.0;
        let sources = vec![
            (0, 0.0),
            (1, 0.0),
            (2, 0.0),
            (2, 0.5),
            (3, 0.0),
            (4, 0.0),
            (4, third),
            (4, 2.0 * third),
            (5, 0.0),
        ];
        assert_eq!(grid.sources, Some(sources));
        assert_eq!(grid.notes, ["3 of 9 slices are missing; filled in from the neighbours' values"]);
    }

    #[test]
    fn every_other_slice_missing_is_found_by_the_smallest_gap() {
        let grid = even_grid(&AXIAL, &along_z(&[0.0, 1.0, 3.0, 5.0, 7.0]), 40);
        assert_eq!(grid.sources.unwrap().len(), 8);
    }

    #[test]
    fn uneven_slices_are_interpolated_at_true_depths() {
        let depths = [0.0, 4.0, 8.0, 9.1, 16.0, 23.0];
        let grid = even_grid(&AXIAL, &along_z(&depths), 40);
        let sources = grid.sources.unwrap();
        let step = grid.patient_from_voxel.matrix3.z_axis.z;
        assert!(step <= 1.1 && ((sources.len() - 1) as f64 * step - 23.0).abs() < 1e-9);
        for (j, &(k, part)) in sources.iter().enumerate() {
            let next = depths[(k + 1).min(5)];
            let depth = depths[k] + part * (next - depths[k]);
            assert!((depth - j as f64 * step).abs() < 0.01, "slice {j}");
        }
        assert!(grid.notes[0].contains("1.100 to 7.000 mm apart"), "{:?}", grid.notes);
    }

    #[test]
    fn filling_is_bounded() {
        let grid = even_grid(&AXIAL, &along_z(&[0.0, 0.02, 1.01, 2.0, 3.0]), 40);
        assert!(grid.sources.unwrap().len() <= 40);
    }

    #[test]
    fn a_tilted_gantry_shears_the_grid() {
        let places: Vec<_> = (0..4).map(|k| DVec3::new(0.0, k as f64, 3.0 * k as f64)).collect();
        let grid = even_grid(&AXIAL, &places, 40);
        assert_eq!(grid.patient_from_voxel.matrix3.z_axis, DVec3::new(0.0, 1.0, 3.0));
        assert_eq!(grid.notes, ["gantry tilt 18.4 degrees, kept as shear"]);
    }

    #[test]
    fn slices_are_sorted_parted_and_thinned() {
        let places = along_z(&[5.0, 4.0, 500.0, 4.0, 3.0, 501.0]);
        let runs = sort_into_runs(&AXIAL, &places);
        assert_eq!(runs, [vec![vec![4], vec![1, 3], vec![0]], vec![vec![2], vec![5]]]);
        // Against the z axis where the normal points down.
        let flipped = Plane { column_direction: -DVec3::Y, ..AXIAL };
        assert_eq!(sort_into_runs(&flipped, &places[..2]), [vec![vec![0], vec![1]]]);
    }
}
