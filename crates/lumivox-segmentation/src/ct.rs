//! CT: values are Hounsfield units, so that tissue, fat, lung and gas are known by them.

use lumivox_core::{CancelToken, Cancelled, Volume};
use rayon::prelude::*;

use crate::{
    Labelled,
    airways::{self, VoxelSet},
    body::{self, HARD_HU, SOLID_HU, Solids},
    class::Class,
    distance::distances,
    grid::{Grid, HU_RANGE, means},
    lungs::{self, AIRY_HU},
    odd_slices::odd_slices,
    outside::Outside,
    progress::Steps,
    refine::{self, Choice},
};

/// Half way between air and skin, in HU.
const SURFACE_HU: f32 = -500.0;

/// The skin's surface where only air is near: a voxel of skin is worth more than one of air, which nobody sees.
const SKIN_HU: f32 = -650.0;

/// Cells in the air are things when they are denser than air by this much, in HU: clothes, foam.
const THING_HU: f32 = 60.0;

/// And by so many standard deviations.
const NOISE_FACTOR: f32 = 3.0;

/// How many times a standard deviation below the median is less than one above it, at most.
const CUT_OFF: f32 = 2.5;

/// Cells closer to the body than this are skin in part, in mm. Further from a table's shell than this nothing is foam of
/// it.
const SKIN_MM: f32 = 3.0;
const FOAM_MM: f32 = 12.0;

/// The smallest body and the largest, in ml.
const LEAST_BODY_ML: f64 = 20.0;
const MOST_BODY_ML: f64 = 500_000.0;

/// Damaged slices that are named; of more it is said how many.
const MOST_NAMED: usize = 5;

/// The labels of a CT.
pub fn labels(volume: &Volume, steps: &Steps<'_>, cancel: &CancelToken) -> Result<Labelled, Cancelled> {
    let grid = Grid::new(volume);
    let means = means(volume, &grid, HU_RANGE, cancel, &|part| steps.report(0.0, 0.25, part))?;
    let Some(mut solids) = body::solids(&grid, &means, cancel)? else {
        let note = "nothing in the scan is thick enough to be a body: everything counts as body".to_owned();
        return Ok(Labelled { labels: Vec::new(), confidence: 0.0, notes: vec![note] });
    };
    steps.report(0.0, 0.5, 1.0);
    let outside = Outside::new(&grid, &means, &solids.class, cancel)?;
    // What is solid and enclosed is the patient's: vessels in lungs, turbinates, what is in the bowel.
    for (class, &outside) in solids.class.iter_mut().zip(&outside.cells) {
        if *class != 0 && !outside {
            *class = Class::Body.value();
        }
    }
    steps.report(0.0, 0.66, 1.0);
    let solid = &solids.class;
    let hollow = |i: usize| !outside.cells[i] && means[i] < AIRY_HU && solid[i] == 0;
    let lung = lungs::lungs(&grid, &means, &hollow, cancel)?;
    let airways = airways::airways(volume, &grid, &means, &hollow, &lung, cancel)?;
    steps.report(0.0, 0.8, 1.0);
    let hollows = Hollows::new(volume, &grid, lung, airways, cancel)?;
    let choices = choices(&grid, &means, &solids, &outside, &hollows, cancel)?;
    steps.report(0.0, 0.86, 1.0);
    let airways = hollows.airways.as_ref();
    let labels =
        refine::label(volume, &grid, &choices, [SKIN_HU, SURFACE_HU, HARD_HU], airways, cancel, &|part| {
            steps.report(0.86, 1.0, part);
        })?;
    let hollow_cells = (0..grid.len()).filter(|&i| hollow(i)).count();
    let odd = odd_slices(volume, grid.axes[2]);
    let (confidence, notes) = judge(&grid, &solids, &outside, &hollows, hollow_cells, &odd);
    Ok(Labelled { labels, confidence, notes })
}

/// The hollows of the body.
struct Hollows {
    lung: Vec<bool>,
    /// Lungs with the vessels in them.
    whole_lung: Vec<bool>,
    /// Cells that hold airways.
    airway: Vec<bool>,
    airways: Option<VoxelSet>,
}

impl Hollows {
    fn new(
        volume: &Volume,
        grid: &Grid,
        mut lung: Vec<bool>,
        airways: Option<VoxelSet>,
        cancel: &CancelToken,
    ) -> Result<Self, Cancelled> {
        let [nx, ny, _] = volume.dims();
        let strides = grid.strides_of_scan();
        let mut counts = vec![0u32; if airways.is_some() { grid.len() } else { 0 }];
        for &voxel in airways.as_ref().map_or(&[][..], VoxelSet::members) {
            let voxel = voxel as usize;
            let at = [voxel % nx, voxel / nx % ny, voxel / nx / ny];
            counts[(0..3).map(|axis| at[axis] / grid.factors[axis] * strides[axis]).sum::<usize>()] += 1;
        }
        let quarter = (grid.factors.iter().product::<usize>() as u32 / 4).max(1);
        let airway: Vec<bool> = if counts.is_empty() {
            vec![false; grid.len()]
        } else {
            counts.iter().map(|&count| count >= quarter).collect()
        };
        lung.iter_mut().zip(&airway).for_each(|(lung, &airway)| *lung &= !airway);
        let whole_lung = lungs::with_vessels(grid, &lung, cancel)?;
        Ok(Self { lung, whole_lung, airway, airways })
    }
}

/// What the voxels of each cell can be.
fn choices(
    grid: &Grid,
    means: &[f32],
    solids: &Solids,
    outside: &Outside,
    hollows: &Hollows,
    cancel: &CancelToken,
) -> Result<Vec<Choice>, Cancelled> {
    let solid = &solids.class;
    let [body, air, table, objects] =
        [Class::Body, Class::Air, Class::Table, Class::Objects].map(Class::value);
    let from_body = distances(grid, &|i| solid[i] == body, 2.0 * SKIN_MM, cancel)?;
    let from_table = distances(grid, &|i| solid[i] == table, FOAM_MM + 1.0, cancel)?;
    let hard_table = upper_hu(means, |i| solid[i] == table).is_some_and(|hu| hu > HARD_HU);
    let [low, usual, high] = air_hu(means, &outside.cells);
    // Clothes raise the upper side, a scanner that cuts off its values takes from the lower.
    let noise = (high - usual).min(CUT_OFF * (usual - low));
    let thing = usual + THING_HU.max(NOISE_FACTOR * noise);
    let airy: Vec<u8> = (0..grid.len())
        .into_par_iter()
        .map(|i| {
            if solid[i] != 0 {
                0
            } else if outside.cells[i] {
                match () {
                    () if means[i] < thing || from_body[i] <= SKIN_MM => air,
                    () if from_table[i] <= FOAM_MM => table,
                    () => objects,
                }
            } else if hollows.airway[i] {
                Class::Airways.value()
            } else if hollows.lung[i] {
                Class::Lungs.value()
            } else if means[i] < SOLID_HU {
                Class::Gas.value()
            } else {
                0
            }
        })
        .collect();
    let is_thing = |i: usize| [solid[i], airy[i]].iter().any(|&class| class == table || class == objects);
    let thing_near = |i: usize| {
        let mut near = is_thing(i);
        grid.neighbours(i, |next| {
            near |= is_thing(next);
            grid.neighbours(next, |next| near |= is_thing(next));
        });
        near
    };
    let touches = |i: usize| {
        let mut touches = false;
        grid.neighbours(i, |next| touches |= solid[next] == body);
        touches
    };
    let dense = refine::spread_to_touching(grid, solid);
    let near = refine::spread(grid, airy.clone());
    let [lungs, noise] = [Class::Lungs, Class::Noise].map(Class::value);
    let mut choices: Vec<Choice> = (0..grid.len())
        .into_par_iter()
        .map(|i| {
            let mut choice = Choice::two(near[i], dense[i]);
            if choice.dense == 0 {
                choice.dense = if airy[i] == air { noise } else { airy[i] };
            }
            // A thing in the air is all of its cell.
            if airy[i] == table || airy[i] == objects {
                choice.airy = airy[i];
                if choice.dense == noise || choice.dense == body {
                    choice.dense = airy[i];
                }
            }
            if choice.airy == 0 {
                choice.airy = choice.dense;
            }
            choice.hard = choice.dense;
            choice.faint = choice.airy == air && choice.dense == body && !thing_near(i);
            // An ear that touches a hard shell reaches into its cells.
            if hard_table && solid[i] == table {
                let mut ear = touches(i);
                grid.neighbours(i, |next| ear |= solid[next] == table && means[i] < HARD_HU && touches(next));
                if ear {
                    choice.dense = body;
                }
            }
            // Vessels belong to the lung around them; its border is that of the values.
            if hollows.whole_lung[i] && !hollows.airway[i] {
                let mut inner = true;
                grid.neighbours(i, |next| inner &= hollows.whole_lung[next] || hollows.airway[next]);
                if inner {
                    choice = Choice::two(lungs, lungs);
                }
            }
            choice
        })
        .collect();
    if !outside.unmeasured.is_empty() {
        for (i, choice) in choices.iter_mut().enumerate() {
            if outside.unmeasured[i % grid.slice_len()] {
                *choice = Choice::default();
            }
        }
    }
    Ok(choices)
}

/// The upper decile of the cells that are `member`s: of shells, most are air in part.
fn upper_hu(means: &[f32], member: impl Fn(usize) -> bool) -> Option<f32> {
    let mut values: Vec<f32> = (0..means.len()).filter(|&i| member(i)).map(|i| means[i]).collect();
    if values.is_empty() {
        return None;
    }
    let upper = values.len() * 9 / 10;
    Some(*values.select_nth_unstable_by(upper, f32::total_cmp).1)
}

/// The values of air a standard deviation below its median, there (-1000 HU but for calibration and for noise that the
/// scanner cuts off), and above.
fn air_hu(means: &[f32], outside: &[bool]) -> [f32; 3] {
    const LOW: f32 = -1050.0;
    let mut counts = [0usize; 300];
    for (&mean, _) in means.iter().zip(outside).filter(|&(&mean, &outside)| outside && mean < LOW + 300.0) {
        counts[((mean - LOW).max(0.0) as usize).min(299)] += 1;
    }
    let total: usize = counts.iter().sum();
    [0.16, 0.5, 0.84].map(|part| {
        let mut below = 0;
        let at = counts.iter().position(|&count| {
            below += count;
            below as f64 > part * total as f64
        });
        at.map_or(-1000.0, |bin| bin as f32 + LOW).clamp(-1024.0, -850.0)
    })
}

/// How sure the result is, and why not more.
fn judge(
    grid: &Grid,
    solids: &Solids,
    outside: &Outside,
    hollows: &Hollows,
    hollow_cells: usize,
    odd_slices: &[usize],
) -> (f64, Vec<String>) {
    let mut confidence = 0.95f64;
    let mut notes = Vec::new();
    let mut lower = |by: f64, why: String| {
        confidence *= by;
        notes.push(why);
    };
    let body = &solids.body;
    let body_ml = body.cells as f64 * grid.cell_ml();
    if body_ml < LEAST_BODY_ML {
        lower(0.2, format!("what was found is small for a body: {body_ml:.0} ml"));
    }
    if body_ml > MOST_BODY_ML {
        let litres = body_ml / 1000.0;
        lower(
            0.2,
            format!(
                "what was found is large for a body, {litres:.0} l: perhaps voxels are smaller than they say"
            ),
        );
    }
    if body.tissue < 0.7 {
        lower(0.4, format!("only {:.0} % of the body has values of tissue", 100.0 * body.tissue));
    }
    if !body.is_mixed() {
        lower(0.6, "the body does not hold both fat and muscle: perhaps a phantom".to_owned());
    }
    if solids.objects_ml > 0.25 * body_ml {
        let share = solids.objects_ml / body_ml;
        let why =
            format!("what lies around is large, {:.0} % of the body: some may belong to it", 100.0 * share);
        lower(0.6 * (0.25 / share), why);
    }
    // Where the body is not cut, that is air around it which has other values than air.
    if outside.cut <= 0.05 && hollow_cells as f64 > 0.8 * body.cells as f64 {
        lower(0.2, "the body is mostly hollow: perhaps its values are no Hounsfield units".to_owned());
    }
    if outside.cut > 0.05 {
        let percent = 100.0 * outside.cut;
        lower(0.9, format!("the field of view cuts the body along {percent:.0} % of its rim"));
    }
    let which: Vec<String> = odd_slices.iter().take(MOST_NAMED).map(|k| (k + 1).to_string()).collect();
    match odd_slices.len() {
        0 => {}
        1 => lower(
            0.5,
            format!(
                "slice {} is unlike both of its neighbours, perhaps damaged: lungs and what else it cuts may be missed",
                which[0]
            ),
        ),
        n => lower(
            0.5,
            format!(
                "{n} slices are unlike both of their neighbours, perhaps damaged ({}{}): lungs and what else they cut may be \
                 missed",
                which.join(", "),
                if n > MOST_NAMED { " and more" } else { "" },
            ),
        ),
    }
    if hollows.lung.contains(&true) && hollows.airways.is_none() {
        notes.push("no trachea was found: airways count as lungs or gas".to_owned());
    }
    (confidence, notes)
}
