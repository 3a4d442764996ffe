//! From where slices lie in the patient to one even grid.
//!
//! Order and spacing come from ImagePositionPatient alone, projected on the slices' normal (PS3.3 C.7.6.2.1.1);
//! instance numbers, slice locations and file names are not to be trusted with either.

use lumivox_core::glam::{DAffine3, DMat3, DVec2, DVec3};

/// Slices lie evenly if none is farther from its even place than this part of the step; a writer's rounding of
/// positions stays below.
pub(crate) const EVEN: f64 = 0.05;
/// Slices nearer than this part of the usual gap lie at the same place.
pub(crate) const SAME_PLACE: f64 = 0.01;
/// Slices nearer than this lie at the same place, whatever the usual gap is.
const NO_GAP_MM: f64 = 1e-4;
/// The smallest part of the smallest gap that a common step may be.
const FINEST_PART: u32 = 16;
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
    /// [`Frame::thickness_mm`](crate::dicom::frames::frame::Frame::thickness_mm) of the first slice: the step of a single one.
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
    let sorted: Vec<f64> = order.iter().map(|&index| depths[index]).collect();
    let usual = Gaps::of_nonzero(&sorted).map_or(1.0, |gaps| gaps.usual);
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
#[derive(Debug, Default)]
pub(crate) struct Grid {
    /// LPS millimetres from voxel indices.
    pub(crate) patient_from_voxel: DAffine3,
    /// For each slice of the grid, a given slice and how far it is (0 up to 1) towards the next given one; `None` if
    /// the given slices are the grid.
    pub(crate) sources: Option<Vec<(usize, f64)>>,
    /// Whether all that is not given is missing: the given slices themselves lie on the grid.
    pub(crate) has_gaps: bool,
    /// Whether the given slices never were even, so that what lies between them was not lost.
    pub(crate) is_uneven: bool,
    /// What takes the place of `sources` and `notes` where nothing may be made up, though the given slices do not lie on
    /// the grid.
    pub(crate) nearest: Option<Nearest>,
    /// Sentences about what was found and done.
    pub(crate) notes: Vec<String>,
}

/// Slices as they are, each at a place of an even grid that is near its own.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// As those of a [`Grid`]; what has no slice lies [`BETWEEN`].
    pub(crate) sources: Vec<(usize, f64)>,
    /// A sentence about it.
    pub(crate) note: String,
}

/// A part of the way to the next slice where only slices as they are count, so that nothing comes from it.
pub(crate) const BETWEEN: f64 = 0.5;

/// Makes a grid of slices whose first pixels lie at `places`, in order along the normal and no two at one place. Filling
/// gaps makes at most `most_slices` of them.
pub(crate) fn even_grid(plane: &Plane, places: &[DVec3], most_slices: usize) -> Grid {
    grid_of(plane, places, spread(&depths_of(plane, places), most_slices))
}

/// How far slices at `places` lie from the first, along the normal.
pub(crate) fn depths_of(plane: &Plane, places: &[DVec3]) -> Vec<f64> {
    let normal = plane.normal();
    places.iter().map(|place| (*place - places[0]).dot(normal)).collect()
}

/// How slices become even ones.
#[derive(Debug, Default)]
pub(crate) struct Spread {
    /// How many even slices there are.
    pub(crate) slices: usize,
    /// See [`Grid`].
    pub(crate) sources: Option<Vec<(usize, f64)>>,
    pub(crate) has_gaps: bool,
    pub(crate) is_uneven: bool,
    pub(crate) nearest: Option<Nearest>,
    pub(crate) notes: Vec<String>,
}

/// The grid of slices at `places` that become even ones.
pub(crate) fn grid_of(plane: &Plane, places: &[DVec3], spread: Spread) -> Grid {
    let Spread { slices, sources, has_gaps, is_uneven, nearest, mut notes } = spread;
    let normal = plane.normal();
    let (first, last) = (places[0], places[places.len() - 1]);
    let depths = depths_of(plane, places);
    let extent = depths[depths.len() - 1];
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
    let matrix3 = DMat3::from_cols(
        plane.row_direction * plane.spacing_mm.x,
        plane.column_direction * plane.spacing_mm.y,
        step,
    );
    let patient_from_voxel = DAffine3 { matrix3, translation: first };
    Grid { patient_from_voxel, sources, has_gaps, is_uneven, nearest, notes }
}

fn note_tilt(step: DVec3, normal: DVec3, notes: &mut Vec<String>) {
    let tilt = step.angle_between(normal).to_degrees();
    if tilt > LEAST_TILT_DEGREES {
        notes.push(format!("gantry tilt {tilt:.1} degrees, kept as shear"));
    }
}

/// How many even slices, `most_slices` at most, cover `depths` (rising from 0), and where they come from.
fn spread(depths: &[f64], most_slices: usize) -> Spread {
    let n = depths.len();
    if n < 3 || is_even(depths, (0..n).collect::<Vec<_>>().as_slice()) {
        return Spread { slices: n, ..Spread::default() };
    }
    let extent = depths[n - 1];
    let Gaps { smallest, largest, .. } = Gaps::of(depths);
    let common = common_steps(depths);
    let slices_of = |places: &[usize]| places[n - 1].saturating_add(1);
    if let Some(places) = common.as_ref().filter(|places| slices_of(places) <= most_slices) {
        let total = slices_of(places);
        let sources = places.windows(2).enumerate().flat_map(|(k, pair)| {
            let length = pair[1] - pair[0];
            (0..length).map(move |i| (k, i as f64 / length as f64))
        });
        let step = extent / (total - 1) as f64;
        // A step that some neighbours keep is the scan's own.
        let is_uneven = smallest > step * 1.5;
        let missing = total - n;
        let note = if is_uneven {
            format!(
                "the slices lie unevenly, {smallest:.3} to {largest:.3} mm apart; they stay as they are on a grid of \
                 {total} slices {step:.3} mm apart, the others of which are {FILLED_IN}"
            )
        } else {
            let verb = if missing == 1 { "is" } else { "are" };
            format!("{missing} of {total} slices {verb} missing; {FILLED_IN}")
        };
        return Spread {
            slices: total,
            sources: Some(sources.chain([(n - 1, 0.0)]).collect()),
            has_gaps: true,
            is_uneven,
            nearest: None,
            notes: vec![note],
        };
    }
    // No common step: as fine as the smallest gap, unless that costs too many slices.
    let steps = ((extent / smallest).ceil() as usize).clamp(n - 1, most_slices.max(n) - 1);
    let (slices, step) = (steps + 1, extent / steps as f64);
    let uneven = format!("the slices lie unevenly, {smallest:.3} to {largest:.3} mm apart");
    let too_fine = common.map_or(String::new(), |places| {
        let slices = slices_of(&places);
        let step = extent / (slices - 1) as f64;
        format!(" (all of them lie on a grid of {slices} slices {step:.3} mm apart, which are too many)")
    });
    let (sources, off) = nearest_places(depths, steps);
    let nearest = Nearest {
        sources,
        note: format!(
            "{uneven}{too_fine}; each is at the nearest of {slices} places {step:.3} mm apart, up to {off:.3} mm beside \
             its own, and the others are left empty"
        ),
    };
    let mut lower = 0;
    let sources = (0..=steps).map(|j| {
        let depth = extent * j as f64 / steps as f64;
        while lower + 2 < n && depths[lower + 1] <= depth {
            lower += 1;
        }
        let part = (depth - depths[lower]) / (depths[lower + 1] - depths[lower]);
        // A slice that is (nearly) hit stays as it is.
        match part {
            ..0.001 => (lower, 0.0),
            0.999.. => (lower + 1, 0.0),
            part => (lower, part),
        }
    });
    Spread {
        slices,
        sources: Some(sources.collect()),
        has_gaps: false,
        is_uneven: true,
        nearest: Some(nearest),
        notes: vec![format!("{uneven}{too_fine}; interpolated to {slices} slices {step:.3} mm apart")],
    }
}

/// The gaps between slices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gaps {
    pub(crate) smallest: f64,
    pub(crate) usual: f64,
    pub(crate) largest: f64,
}

impl Gaps {
    /// Of two slices or more, whose depths rise.
    pub(crate) fn of(depths: &[f64]) -> Self {
        Self::among(depths, |_| true).expect("there are gaps")
    }

    /// Of slices whose depths rise, several of which may lie at one place; `None` where all do.
    pub(crate) fn of_nonzero(depths: &[f64]) -> Option<Self> {
        Self::among(depths, |gap| *gap > NO_GAP_MM)
    }

    fn among(depths: &[f64], counts: impl Fn(&f64) -> bool) -> Option<Self> {
        let gaps: Vec<f64> = depths.windows(2).map(|pair| pair[1] - pair[0]).filter(counts).collect();
        Some(Self {
            smallest: gaps.iter().copied().fold(f64::INFINITY, f64::min),
            largest: gaps.iter().copied().fold(0.0, f64::max),
            usual: median(gaps)?,
        })
    }
}

/// The places, in steps from the first, of slices at `depths` on the coarsest even grid that all of them lie on: its step
/// is the usual gap, the smallest one, or a small part of it. `None` where there is none.
pub(crate) fn common_steps(depths: &[f64]) -> Option<Vec<usize>> {
    let Gaps { smallest, usual, .. } = Gaps::of(depths);
    let parts = (1..=FINEST_PART).map(|part| smallest / f64::from(part));
    [usual].into_iter().chain(parts).map(|base| steps_of(depths, base)).find(|places| is_even(depths, places))
}

/// The places of slices at `depths`, in steps of about `base` and at least one apart. Gaps are counted from the smallest
/// on, each by the mean step so far, lest rounding of `base` adds up in a long one.
pub(crate) fn steps_of(depths: &[f64], base: f64) -> Vec<usize> {
    let gap = |k: usize| depths[k + 1] - depths[k];
    let mut order: Vec<usize> = (0..depths.len() - 1).collect();
    order.sort_by(|&a, &b| gap(a).total_cmp(&gap(b)));
    let (mut mm, mut steps) = (base, 1.0);
    let mut counts = vec![0; order.len()];
    for k in order {
        let count = (gap(k) * steps / mm).round().max(1.0);
        (mm, steps) = (mm + gap(k), steps + count);
        counts[k] = count as usize;
    }
    let mut places = vec![0_usize];
    for count in counts {
        places.push(places[places.len() - 1].saturating_add(count));
    }
    places
}

/// Sources of `steps + 1` even slices in which each slice at `depths`, as it is, is at the nearest place that is free, and
/// how far (in mm) the farthest is from its own.
pub(crate) fn nearest_places(depths: &[f64], steps: usize) -> (Vec<(usize, f64)>, f64) {
    let n = depths.len();
    let step = depths[n - 1] / steps as f64;
    let mut places: Vec<usize> = depths.iter().map(|depth| (depth / step).round() as usize).collect();
    // In order, no two at one place, and none beyond the end.
    for k in 1..n {
        places[k] = places[k].max(places[k - 1] + 1);
    }
    for k in (0..n).rev() {
        places[k] = places[k].min(steps - (n - 1 - k));
    }
    let beside = |k: usize| (depths[k] - places[k] as f64 * step).abs();
    (sources_at(&places), (0..n).map(beside).fold(0.0, f64::max))
}

/// Sources in which each slice is, as it is, at one of `places`, which rise from 0.
pub(crate) fn sources_at(places: &[usize]) -> Vec<(usize, f64)> {
    let from = places.windows(2).enumerate().flat_map(|(k, pair)| {
        let [place, next] = [pair[0], pair[1]];
        (place..next).map(move |at| (k, if at == place { 0.0 } else { BETWEEN }))
    });
    from.chain([(places.len() - 1, 0.0)]).collect()
}

/// Whether each of `depths` is near its place, given as a number of steps, of an even grid.
pub(crate) fn is_even(depths: &[f64], places: &[usize]) -> bool {
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
