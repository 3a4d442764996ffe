//! Several scans of one part of the body in one series, each at places a little beside those of the others: arterial and
//! venous, before and after contrast. Sorted by place alone they would make one striped volume.
//!
//! What was taken together, numbers and times tell; but they part a volume that is taken step by step, or every other
//! slice first, just as well. So it is the places that decide. Scans cover the same way, each evenly by itself, and all of
//! them together leave uneven gaps. Where they are even together, too, a volume was interleaved, unless the header's
//! distance of slices is that of each scan.

use std::collections::BTreeMap;

use crate::dicom::{
    frames::frame::{PhaseKey, STRONG, WEAK},
    series::geometry::{self, Gaps, SAME_PLACE},
};

/// A phase covers at least this part of what all cover.
pub(crate) const COVERED: f64 = 0.6;

/// A scan has at least so many slices.
const FEWEST: usize = 3;
/// More scans are not found by pauses and turns.
const MOST_CUTS: usize = 16;
/// Slices whose gaps are filled worse than this part are not even.
const FILLED: f64 = 0.5;
/// Places of all scans that are filled worse by this part than those of each are no volume's.
const WORSE: f64 = 0.1;

/// Parts images, each with its key and its depth along the normal, into scans that lie between each other, as indices; and
/// what they are told apart by. `None` where there is one. `header_step` is the distance of slices by the header's word.
pub(crate) fn interleaved_scans(
    class: &[usize],
    keys: &[PhaseKey],
    depths: &[f64],
    header_step: f64,
) -> Option<(Vec<Vec<usize>>, &'static str)> {
    let all = Comb::of(class.iter().map(|&index| depths[index]).collect())?;
    // Scans have at least twice the step of all.
    if class.len() < 2 * FEWEST || all.filled > 1.0 - WORSE && all.is_step(header_step, 2.0 * all.step) {
        return None;
    }
    let are_scans = |parts: &[Vec<usize>], by_header| are_scans(parts, depths, header_step, by_header);
    for (name, field) in STRONG.iter().chain(&WEAK) {
        let mut parts: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
        class.iter().for_each(|&index| parts.entry(field(&keys[index])).or_default().push(index));
        let mut parts: Vec<Vec<usize>> = parts.into_values().collect();
        if are_scans(&parts, true) {
            let began = |part: &Vec<usize>| part.iter().map(|&index| keys[index].time).min();
            parts.sort_by_key(began);
            return Some((parts, name));
        }
    }
    let mut by_time = class.to_vec();
    by_time.sort_by_key(|&index| keys[index].time);
    let pause = |a: usize, b: usize| keys[b].time as f64 - keys[a].time as f64;
    let mut by_number = class.to_vec();
    by_number.sort_by_key(|&index| keys[index].instance);
    let turn = |a: usize, b: usize| (depths[b] - depths[a]).abs();
    // Numbers alone do not tell an interleaved volume from two scans.
    let found = cuts(&by_time, pause).find(|parts| are_scans(parts, true)).map(|parts| (parts, "time"));
    found.or_else(|| {
        cuts(&by_number, turn).find(|parts| are_scans(parts, false)).map(|parts| (parts, "instance number"))
    })
}

/// Cuts `order` at its largest gap, at its two largest ones, and so on.
fn cuts(order: &[usize], gap: impl Fn(usize, usize) -> f64) -> impl Iterator<Item = Vec<Vec<usize>>> {
    let mut at: Vec<usize> = (1..order.len()).collect();
    let gap = |k: usize| gap(order[k - 1], order[k]);
    at.sort_by(|&a, &b| gap(b).total_cmp(&gap(a)));
    at.truncate(MOST_CUTS);
    at.retain(|&k| gap(k) > 0.0);
    (1..=at.len()).map(move |count| {
        let mut ends = at[..count].to_vec();
        ends.push(order.len());
        ends.sort_unstable();
        let mut start = 0;
        ends.into_iter().map(|end| order[std::mem::replace(&mut start, end)..end].to_vec()).collect()
    })
}

/// Whether parts are scans of one part of the body, by their places, and else by the header's distance of slices if that
/// may decide.
fn are_scans(parts: &[Vec<usize>], depths: &[f64], header_step: f64, by_header: bool) -> bool {
    if parts.len() < 2 || parts.iter().any(|part| part.len() < FEWEST) {
        return false;
    }
    let depths_of = |part: &Vec<usize>| part.iter().map(|&index| depths[index]).collect::<Vec<f64>>();
    let Some(combs) = parts.iter().map(|part| Comb::of(depths_of(part))).collect::<Option<Vec<_>>>() else {
        return false;
    };
    // What all of them cover.
    let low = combs.iter().map(|comb| comb.range[0]).fold(f64::NEG_INFINITY, f64::max);
    let high = combs.iter().map(|comb| comb.range[1]).fold(f64::INFINITY, f64::min);
    let shortest = combs.iter().map(|comb| comb.range[1] - comb.range[0]).fold(f64::INFINITY, f64::min);
    let worst = combs.iter().map(|comb| comb.filled).fold(1.0, f64::min);
    let step = combs.iter().map(|comb| comb.step).fold(0.0, f64::max);
    let within = parts.iter().flat_map(depths_of).filter(|depth| (low..=high).contains(depth));
    let Some(together) = Comb::of(within.collect()) else { return false };
    if high - low < COVERED * shortest || worst < FILLED {
        return false;
    }
    together.filled < worst - WORSE
        || by_header && together.step < step / 1.5 && !together.is_step(header_step, step)
}

/// How evenly slices lie.
#[derive(Clone, Copy, Debug)]
struct Comb {
    /// The lowest and the highest.
    range: [f64; 2],
    /// Distance of neighbours.
    step: f64,
    /// How many of the even places are there, from 0 to 1; 0 where slices lie unevenly.
    filled: f64,
}

impl Comb {
    /// Of slices at `depths`, in any order; `None` where these are fewer than three places.
    fn of(mut depths: Vec<f64>) -> Option<Self> {
        depths.sort_by(f64::total_cmp);
        let range = [*depths.first()?, *depths.last()?];
        let usual = Gaps::of_nonzero(&depths)?.usual;
        depths.dedup_by(|b, a| *b - *a <= usual * SAME_PLACE);
        let depths: Vec<f64> = depths.iter().map(|depth| depth - range[0]).collect();
        let n = depths.len();
        if n < FEWEST {
            return None;
        }
        let Gaps { smallest, usual, .. } = Gaps::of(&depths);
        let even = [usual, smallest].into_iter().map(|base| geometry::steps_of(&depths, base));
        let steps = even.filter(|steps| geometry::is_even(&depths, steps)).map(|steps| steps[n - 1]).next();
        Some(match steps {
            Some(steps) => {
                let filled = n as f64 / (steps as f64 + 1.0);
                Self { range, step: depths[n - 1] / steps as f64, filled }
            }
            None => Self { range, step: usual, filled: 0.0 },
        })
    }

    /// Whether `step` is nearer to the step of these than to `other`, by their ratio.
    fn is_step(&self, step: f64, other: f64) -> bool {
        (step / self.step).ln().abs() <= (step / other).ln().abs()
    }
}
