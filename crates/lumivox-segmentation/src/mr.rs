//! MR: values have no scale, so that only air and body are told apart, by Otsu's threshold and by shape.

use lumivox_core::{CancelToken, Cancelled, Volume};
use rayon::prelude::*;

use crate::{
    Labelled,
    class::Class,
    components::{Components, filled, reach},
    distance::distances,
    grid::{Grid, means},
    progress::Steps,
    refine::{self, Choice},
};

/// Bins of the values, and the share of the brightest that do not count: a coil's nearest fat would stretch the scale.
const BINS: usize = 512;
const BRIGHTEST: f64 = 0.02;

/// Where between the means of air and body the surface lies: signal fades away from the coil.
const SURFACE: f32 = 0.25;

/// Half the width up to which openings of the body are closed, and how far air goes into narrower places, in mm.
const CLOSING_MM: f32 = 6.0;
const INTO_NARROW_MM: f32 = 10.0;

/// A part of the body has at least this share of its largest.
const LEAST_PART: f64 = 0.02;

/// How much brighter than air the body is in a scan that is understood, and shares of the scan that a body takes.
const CONTRAST: f32 = 4.0;
const BODY_SHARE: std::ops::Range<f64> = 0.02..0.95;

/// The labels of an MR.
pub fn labels(volume: &Volume, steps: &Steps<'_>, cancel: &CancelToken) -> Result<Labelled, Cancelled> {
    let grid = Grid::new(volume);
    let means = means(volume, &grid, volume.value_range(), cancel, &|part| steps.report(0.0, 0.33, part))?;
    let (air, body) = levels(&means);
    let surface = air + SURFACE * (body - air);
    let bright: Vec<bool> = means.par_iter().map(|&mean| mean > surface).collect();
    let parts = Components::new(&grid, |i| bright[i], cancel)?;
    let largest = parts.sizes.iter().copied().max().unwrap_or(0);
    let least = ((largest as f64 * LEAST_PART) as usize).max(1);
    let solid = |i: usize| parts.sizes[parts.of[i] as usize] >= least;
    steps.report(0.0, 0.5, 1.0);

    let from_body = distances(&grid, &solid, CLOSING_MM + 1.0, cancel)?;
    let open = |i: usize| from_body[i] > CLOSING_MM;
    let at_side = |i: usize| {
        let cell = grid.cell(i);
        (0..3).any(|axis| cell[axis] == 0 || cell[axis] + 1 == grid.dims[axis])
    };
    let core = filled(&grid, at_side, open, cancel)?;
    let outside = reach(&grid, |i| core[i], |i| !solid(i), INTO_NARROW_MM, cancel)?;
    steps.report(0.0, 0.75, 1.0);

    let class = |i: usize| if outside[i] { 0 } else { Class::Body.value() };
    let near = refine::spread(&grid, (0..grid.len()).map(class).collect());
    let air_near = |i: usize| {
        let mut near = outside[i];
        grid.neighbours(i, |next| near |= outside[next]);
        near
    };
    let choices: Vec<Choice> = (0..grid.len())
        .into_par_iter()
        .map(|i| {
            // What is dark in the body, bone and gas, is its own but at the surface.
            let airy = if air_near(i) { Class::Air } else { Class::Body };
            Choice::two(airy.value(), if near[i] == 0 { Class::Noise.value() } else { near[i] })
        })
        .collect();
    let labels =
        refine::label(volume, &grid, &choices, [surface, surface, f32::INFINITY], None, cancel, &|part| {
            steps.report(0.75, 1.0, part);
        })?;
    let share = outside.iter().filter(|&&outside| !outside).count() as f64 / grid.len() as f64;
    let (confidence, notes) = judge(air, body, share);
    Ok(Labelled { labels, confidence, notes })
}

/// The mean values of air and body: below and above Otsu's threshold (IEEE Trans. SMC 9, 1979).
fn levels(means: &[f32]) -> (f32, f32) {
    let mut sorted = means.to_vec();
    let at = ((1.0 - BRIGHTEST) * (sorted.len() - 1) as f64) as usize;
    let (_, &mut high, _) = sorted.select_nth_unstable_by(at, f32::total_cmp);
    let low = means.iter().copied().fold(f32::INFINITY, f32::min);
    let width = ((high - low) / BINS as f32).max(f32::MIN_POSITIVE);
    let mut counts = [0f64; BINS];
    for mean in means {
        counts[(((mean - low) / width) as usize).min(BINS - 1)] += 1.0;
    }
    let total: f64 = counts.iter().sum();
    let sum: f64 = counts.iter().enumerate().map(|(bin, count)| bin as f64 * count).sum();
    let (mut below, mut partial, mut best) = (0.0, 0.0, (-1.0, 0.0, 0.0));
    for (bin, count) in counts.iter().enumerate() {
        below += count;
        partial += bin as f64 * count;
        if below > 0.0 && below < total {
            let [dark, bright] = [partial / below, (sum - partial) / (total - below)];
            let between = below * (total - below) * (bright - dark).powi(2);
            if between > best.0 {
                best = (between, dark, bright);
            }
        }
    }
    (low + width * best.1 as f32, low + width * best.2 as f32)
}

/// How sure the result is, and why not more.
fn judge(air: f32, body: f32, share: f64) -> (f64, Vec<String>) {
    let mut confidence = 0.85;
    let mut notes = vec!["MR: only body and air are told apart".to_owned()];
    // Without offset; an average of scans, or one that was filtered, has no noise in its air at all.
    if body < CONTRAST * air.max(0.0) || body <= 0.0 {
        confidence *= 0.3;
        notes.push("the body is hardly brighter than air".to_owned());
    }
    if !BODY_SHARE.contains(&share) {
        confidence *= 0.3;
        notes.push(format!("the body fills {:.0} % of the scan", 100.0 * share));
    }
    (confidence, notes)
}
