//! What becomes of places without a slice, and of slices that are damaged.
//!
//! A slice that is missing was never taken or never sent: its neighbours stand in for it, if the user does not say
//! otherwise. What a damaged one showed is not known, and nothing is made up in its place unless the user asks for it.

use lumivox_core::glam::DVec3;

use crate::dicom::series::geometry::{self, Grid};

/// What becomes of places without a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Gaps {
    /// They are filled in from their neighbours.
    Filled,
    /// They stay empty, as the user wants it.
    Left,
    /// They stay empty, for damaged files whose place is not known may belong there.
    MayBeDamaged,
}

impl Grid {
    /// Lets the grid and its notes be as `gaps` say; whether what has no slice stays empty.
    pub(crate) fn settle(&mut self, gaps: Gaps) -> bool {
        if gaps == Gaps::Left
            && let Some(nearest) = self.nearest.take()
        {
            // The first note is about the places; others are about their line.
            self.notes[0] = nearest.note;
            self.sources = Some(nearest.sources);
            self.has_gaps = true;
        }
        // What lies between slices that never were even was not lost, whatever else is damaged.
        let may_be_damaged = gaps == Gaps::MayBeDamaged && !self.is_uneven;
        let left = self.has_gaps && (gaps == Gaps::Left || may_be_damaged);
        if left {
            let why = if may_be_damaged { ", for damaged files may belong there" } else { "" };
            let words = format!("left empty{why}");
            self.notes.iter_mut().for_each(|note| *note = note.replace(geometry::FILLED_IN, &words));
        }
        left
    }
}

/// Where a slice of a grid comes from: a given slice and the part of the way to the next one; `None` if it stays empty.
pub(crate) type GridSource = Option<(usize, f64)>;

/// Runs of empty slices that a note names.
const MOST_NAMED: usize = 8;

/// Where the slices of `grid` come from, given which of its sources are damaged, and whether only given ones count.
pub(crate) fn sources(grid: &Grid, damaged: &[bool], leave_gaps: bool) -> Vec<GridSource> {
    let source = |(slice, part): (usize, f64)| {
        let given = !damaged[slice] && (part == 0.0 || !leave_gaps && !damaged[slice + 1]);
        given.then_some((slice, part))
    };
    match &grid.sources {
        Some(sources) => sources.iter().copied().map(source).collect(),
        None => (0..damaged.len()).map(|slice| source((slice, 0.0))).collect(),
    }
}

/// Whether slice `k` of `grid` is lost with a damaged one: of images also where it lies between two and one is damaged,
/// of labels, which are never between two slices, only that one itself.
pub(crate) fn is_lost(k: usize, damaged: &[bool], grid: &Grid, labels: bool) -> bool {
    match grid.sources.as_ref().map(|all| all[k]) {
        Some((_, part)) if labels && part > 0.0 => false,
        Some((slice, part)) => damaged[slice] || part > 0.0 && damaged[slice + 1],
        None => damaged[k],
    }
}

/// What the report says about damaged slices: `1 of 5 slices is damaged; left empty: slice 3 at (0, 0, 4) mm`. Slices
/// are counted from 1, places are in the patient.
pub(crate) fn note(sources: &[GridSource], damaged: &[bool], grid: &Grid, labels: bool) -> Option<String> {
    let count = damaged.iter().filter(|damaged| **damaged).count();
    if count == 0 {
        return None;
    }
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for k in (0..sources.len()).filter(|&k| sources[k].is_none() && is_lost(k, damaged, grid, labels)) {
        match runs.last_mut() {
            Some(run) if run[1] + 1 == k => run[1] = k,
            _ => runs.push([k, k]),
        }
    }
    let place = |k: usize| {
        let DVec3 { x, y, z } = grid.patient_from_voxel.transform_point3(DVec3::Z * k as f64);
        // No negative zero.
        let [x, y, z] = [x, y, z].map(|mm| (mm * 10.0).round() / 10.0 + 0.0);
        format!("({x}, {y}, {z})")
    };
    let words = |&[first, last]: &[usize; 2]| match last - first {
        0 => format!("slice {} at {} mm", first + 1, place(first)),
        _ => format!("slices {} to {}, from {} to {} mm", first + 1, last + 1, place(first), place(last)),
    };
    let mut named: Vec<String> = runs.iter().take(MOST_NAMED).map(words).collect();
    if runs.len() > MOST_NAMED {
        named.push(format!("and {} more places", runs.len() - MOST_NAMED));
    }
    let verb = if count == 1 { "is" } else { "are" };
    Some(format!("{count} of {} slices {verb} damaged; left empty: {}", damaged.len(), named.join(", ")))
}

#[cfg(test)]
mod tests {
    use lumivox_core::glam::{DAffine3, DMat3};

    use super::*;

    fn grid(sources: Option<Vec<(usize, f64)>>) -> Grid {
        let matrix3 = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 2.5));
        let patient_from_voxel = DAffine3 { matrix3, translation: DVec3::new(-10.0, 0.0, -5.0) };
        Grid { patient_from_voxel, sources, has_gaps: true, ..Grid::default() }
    }

    #[test]
    fn nothing_is_made_of_a_damaged_slice() {
        // Slices 2 and 5 of the grid are missing; the one behind the first gap is damaged.
        let grid = grid(Some(vec![(0, 0.0), (0, 0.5), (1, 0.0), (2, 0.0), (2, 0.5), (3, 0.0)]));
        let damaged = [false, true, false, false];
        let filled = sources(&grid, &damaged, false);
        assert_eq!(filled, [Some((0, 0.0)), None, None, Some((2, 0.0)), Some((2, 0.5)), Some((3, 0.0))]);
        assert_eq!(
            note(&filled, &damaged, &grid, false).unwrap(),
            "1 of 4 slices is damaged; left empty: slices 2 to 3, from (-10, 0, -2.5) to (-10, 0, 0) mm"
        );
        let left = sources(&grid, &[false; 4], true);
        assert_eq!(left.iter().filter(|source| source.is_none()).count(), 2);
        assert_eq!(note(&left, &[false; 4], &grid, false), None);
    }

    #[test]
    fn many_damaged_slices_are_counted() {
        let damaged: Vec<bool> = (0..40).map(|k| k % 2 == 1).collect();
        let grid = grid(None);
        let note = note(&sources(&grid, &damaged, false), &damaged, &grid, false).unwrap();
        assert!(note.starts_with("20 of 40 slices are damaged; left empty: slice 2 at (-10, 0, -2.5) mm, "));
        assert!(note.ends_with(", and 12 more places"), "{note}");
    }
}
