//! The grid of a segmentation's slices: labels are never changed and never left out.

use lumivox_core::glam::DVec3;

use crate::dicom::series::geometry::{self, EVEN, Gaps, Grid, Plane, Spread};

/// The grid of labels whose slices lie at `places`, at most `most_slices` where that is more than they are: by the
/// header's own step where they are on it, for slices without a segment are left out of the file; else by one that they
/// have in common. Labels are never changed and never left out.
pub(crate) fn grid(plane: &Plane, places: &[DVec3], most_slices: usize) -> Grid {
    let n = places.len();
    let dense = Spread { slices: n, ..Spread::default() };
    if n < 2 {
        return geometry::grid_of(plane, places, dense);
    }
    let depths = geometry::depths_of(plane, places);
    let slices_of = |steps: &[usize]| steps[n - 1].saturating_add(1);
    let mut note = None;
    let steps = steps_of_header(&depths, plane.thickness_mm).or_else(|| match depths[..] {
        // Any distance is a step that two have in common.
        [_, gap] => {
            let (steps, what) = step_of_two(gap, plane.thickness_mm);
            note = Some(what);
            Some(vec![0, steps])
        }
        _ => geometry::common_steps(&depths),
    });
    let mut spread = match steps.filter(|steps| slices_of(steps) <= most_slices.max(n)) {
        Some(steps) if slices_of(&steps) == n => dense,
        Some(steps) => {
            let slices = slices_of(&steps);
            let empty = slices - n;
            let verb = if empty == 1 { "holds" } else { "hold" };
            Spread {
                slices,
                sources: Some(geometry::sources_at(&steps)),
                has_gaps: true,
                notes: vec![format!("{empty} of {slices} slices {verb} no segment")],
                ..Spread::default()
            }
        }
        None => {
            let Gaps { smallest, largest, .. } = Gaps::of(&depths);
            let extent = depths[n - 1];
            let steps = ((extent / smallest).ceil() as usize).clamp(n - 1, most_slices.max(n) - 1);
            let (sources, off) = geometry::nearest_places(&depths, steps);
            let note = format!(
                "the slices with labels lie unevenly, {smallest:.3} to {largest:.3} mm apart; each is, unchanged, at the \
                 nearest of {} places {:.3} mm apart, up to {off:.3} mm beside its own",
                steps + 1,
                extent / steps as f64
            );
            Spread {
                slices: steps + 1,
                sources: Some(sources),
                has_gaps: true,
                notes: vec![note],
                ..Spread::default()
            }
        }
    };
    spread.notes.extend(note);
    geometry::grid_of(plane, places, spread)
}

/// How many steps two slices are apart that are no multiple of the one expected: the nearest such number where that is
/// near, else one; and a sentence about it.
fn step_of_two(gap: f64, expected: f64) -> (usize, String) {
    /// The part of the step by which another one may differ.
    const NEAR: f64 = 0.05;
    let steps = (gap / expected).round().max(1.0);
    let step = gap / steps;
    let apart = format!("the two slices with labels lie {gap:.3} mm apart");
    if (step - expected).abs() <= NEAR * expected {
        let what =
            format!("{apart}, taken as {steps} steps of {step:.3} mm ({expected:.3} mm were expected)");
        return (steps as usize, what);
    }
    (1, format!("{apart}, which is no multiple of the {expected:.3} mm that were expected"))
}

/// Where slices at `depths` lie in steps of the header, if they all lie on such.
fn steps_of_header(depths: &[f64], step: f64) -> Option<Vec<usize>> {
    let at = depths.iter().map(|depth| depth / step);
    let steps = at.map(|at| ((at - at.round()).abs() < EVEN).then_some(at.round() as usize));
    let steps: Vec<usize> = steps.collect::<Option<_>>()?;
    steps.is_sorted_by(|a, b| a < b).then_some(steps)
}
