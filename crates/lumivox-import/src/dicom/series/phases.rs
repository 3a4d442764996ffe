//! Several images at every place: phases of a beating heart, echoes, diffusion weightings, passes of contrast. Each
//! phase is a volume of its own; they never make one tall stack.

use std::collections::BTreeMap;

use crate::dicom::{
    frames::frame::{Field, PhaseKey, STRONG, WEAK},
    series::{
        geometry::AtPlace,
        interleaving::{COVERED, interleaved_scans},
    },
};

/// Parts images, each with its key and its depth along the normal, by what no volume mixes, and where they are scans that
/// lie between each other. `header_step` is the distance of slices by the header's word. Returns the classes, as indices,
/// and what they were told apart by.
pub(crate) fn strong_classes(
    keys: &[PhaseKey],
    depths: &[f64],
    header_step: f64,
) -> (Vec<Vec<usize>>, Vec<&'static str>) {
    let mut classes = vec![(0..keys.len()).collect::<Vec<usize>>()];
    let mut told_by = Vec::new();
    for (name, field) in STRONG {
        let parted: Vec<Vec<Vec<usize>>> =
            classes.iter().map(|class| part(class, keys, depths, field)).collect();
        if parted.iter().any(|parts| parts.len() > 1) {
            told_by.push(name);
            classes = parted.into_iter().flatten().collect();
        }
    }
    let mut parted = Vec::new();
    for class in classes {
        match interleaved_scans(&class, keys, depths, header_step) {
            Some((scans, name)) => {
                parted.extend(scans);
                told_by.push(name);
            }
            None => parted.push(class),
        }
    }
    told_by.dedup();
    (parted, told_by)
}

/// Parts one class by a field; in one part where that makes no phases, but pieces of a volume.
fn part(class: &[usize], keys: &[PhaseKey], depths: &[f64], field: fn(&PhaseKey) -> i64) -> Vec<Vec<usize>> {
    let whole = || vec![class.to_vec()];
    let mut parts: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    for &index in class {
        parts.entry(field(&keys[index])).or_default().push(index);
    }
    if parts.len() < 2 {
        return whole();
    }
    let extent = |part: &[usize]| {
        let (low, high) = part.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &index| {
            (low.min(depths[index]), high.max(depths[index]))
        });
        high - low
    };
    let whole_ones = parts.values().filter(|part| extent(part) >= COVERED * extent(class)).count();
    if are_phases(whole_ones, parts.len()) { parts.into_values().collect() } else { whole() }
}

/// Whether parts are phases, so many of which are (nearly) whole. An odd image with another number makes none.
fn are_phases(whole: usize, parts: usize) -> bool {
    whole >= 2 && whole as f64 >= COVERED * parts as f64
}

/// The phases of one run of places.
#[derive(Debug, PartialEq)]
pub(crate) struct Phases {
    /// Images of each, in order along the normal.
    pub(crate) phases: Vec<Vec<usize>>,
    /// What tells them apart; empty where there is one.
    pub(crate) told_by: &'static str,
    /// Images left out, since they lie at the place of another and belong to no phase.
    pub(crate) repeated: usize,
}

/// Parts a run whose places may have several images each. `keys` are those of all images.
pub(crate) fn phases_of_run(run: &[AtPlace], keys: &[PhaseKey]) -> Phases {
    let all: usize = run.iter().map(Vec::len).sum();
    let each = run[0].len();
    let sorted = |place: &AtPlace| {
        let mut place = place.clone();
        place.sort_by_key(|&index| (keys[index], index));
        place
    };
    if run.iter().all(|place| place.len() == each) {
        let run: Vec<AtPlace> = run.iter().map(sorted).collect();
        let phases: Vec<Vec<usize>> = (0..each).map(|k| run.iter().map(|place| place[k]).collect()).collect();
        let differs = |(_, field): &&Field| {
            run[0].windows(2).all(|pair| field(&keys[pair[0]]) != field(&keys[pair[1]]))
        };
        let told_by = STRONG.iter().chain(&WEAK).find(differs).map_or("order", |(name, _)| name);
        return Phases { phases, told_by: if each > 1 { told_by } else { "" }, repeated: 0 };
    }
    for (name, field) in STRONG.iter().chain(&WEAK) {
        let mut parts: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
        let mut unique = true;
        for place in run {
            let mut seen: Vec<i64> = place.iter().map(|&index| field(&keys[index])).collect();
            seen.sort_unstable();
            unique &= seen.windows(2).all(|pair| pair[0] != pair[1]);
            place.iter().for_each(|&index| parts.entry(field(&keys[index])).or_default().push(index));
        }
        let whole = parts.values().filter(|part| part.len() as f64 >= COVERED * run.len() as f64).count();
        if unique && are_phases(whole, parts.len()) {
            return Phases { phases: parts.into_values().collect(), told_by: name, repeated: 0 };
        }
    }
    let first: Vec<usize> = run.iter().map(|place| sorted(place)[0]).collect();
    let repeated = all - first.len();
    Phases { phases: vec![first], told_by: "", repeated }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(values: &[(i64, i64)]) -> Vec<PhaseKey> {
        values
            .iter()
            .map(|&(b_value, acquisition)| PhaseKey { b_value, acquisition, ..Default::default() })
            .collect()
    }

    #[test]
    fn weightings_part_even_where_places_differ() {
        let keys = keys(&[(0, 0), (1000, 0), (0, 0), (1000, 0), (0, 0), (1000, 0)]);
        let (classes, told_by) = strong_classes(&keys, &[0.0, 0.3, 2.0, 2.3, 4.0, 4.3], 2.0);
        assert_eq!((classes, told_by), (vec![vec![0, 2, 4], vec![1, 3, 5]], vec!["b-value"]));
        // Each slice with a value of its own is one volume.
        let own: Vec<PhaseKey> = (0..4).map(|b_value| PhaseKey { b_value, ..Default::default() }).collect();
        assert_eq!(strong_classes(&own, &[0.0, 1.0, 2.0, 3.0], 1.0).0.len(), 1);
    }

    #[test]
    fn acquisitions_part_only_where_places_repeat() {
        let keys = keys(&[(0, 1), (0, 1), (0, 2), (0, 2), (0, 2)]);
        // The second acquisition has a place more.
        let phases = phases_of_run(&[vec![0, 2], vec![1, 3], vec![4]], &keys);
        assert_eq!(phases.phases, [vec![0, 1], vec![2, 3, 4]]);
        assert_eq!(phases.told_by, "acquisition");
        // Two that meet at one place are one volume.
        let phases = phases_of_run(&[vec![0], vec![1, 2], vec![3], vec![4]], &keys);
        assert_eq!((phases.phases, phases.repeated), (vec![vec![0, 1, 3, 4]], 1));
        // Interleaved slices of two acquisitions are one, too.
        let phases = phases_of_run(&[vec![0], vec![2], vec![1], vec![3]], &keys);
        assert_eq!(phases.phases, [vec![0, 2, 1, 3]]);
    }
}
