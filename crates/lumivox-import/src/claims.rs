//! Segments that claim the same voxels. Each voxel belongs to one in the end: the smallest of those that claim it, so that a
//! tumour inside of a liver is still there, and the liver around it.

use std::collections::{HashMap, TryReserveError};

/// A voxel for which no set is left keeps those that claimed it before.
const MOST_SETS: usize = u16::MAX as usize;

/// Which of some segments claim each voxel of a grid. Segments are numbers above 0.
#[derive(Debug)]
pub(crate) struct Claims {
    /// For each voxel the place of its set in `sets`.
    voxels: Vec<u16>,
    /// Different sets of segments, in rising order; the first is empty.
    sets: Vec<Vec<u16>>,
    /// The set that another becomes by a segment.
    with: HashMap<(u16, u16), u16>,
    /// Voxels that each segment claims.
    sizes: HashMap<u16, u64>,
}

/// What became of claims.
#[derive(Debug, PartialEq)]
pub(crate) struct Settled {
    /// The segment of each voxel, or 0.
    pub(crate) voxels: Vec<u16>,
    /// Voxels that several segments claimed.
    pub(crate) shared: u64,
    /// Segments all of whose voxels belong to smaller ones.
    pub(crate) covered: Vec<u16>,
}

impl Claims {
    /// Makes room for `count` voxels that nothing claims.
    pub(crate) fn new(count: usize) -> Result<Self, TryReserveError> {
        let mut voxels = Vec::new();
        voxels.try_reserve_exact(count)?;
        voxels.resize(count, 0);
        Ok(Self::on(voxels))
    }

    /// Uses `voxels`, all of which are 0, as its memory.
    pub(crate) fn on(voxels: Vec<u16>) -> Self {
        Self { voxels, sets: vec![Vec::new()], with: HashMap::new(), sizes: HashMap::new() }
    }

    /// Lets `segment` claim a voxel.
    #[inline]
    pub(crate) fn add(&mut self, voxel: usize, segment: u16) {
        let set = self.voxels[voxel];
        let joined = match self.with.get(&(set, segment)) {
            Some(joined) => *joined,
            None => self.join(set, segment),
        };
        if joined != set {
            self.voxels[voxel] = joined;
            *self.sizes.entry(segment).or_default() += 1;
        }
    }

    /// The set of those of `set` and `segment`.
    fn join(&mut self, set: u16, segment: u16) -> u16 {
        let mut members = self.sets[usize::from(set)].clone();
        let joined = match members.binary_search(&segment) {
            Ok(_) => set,
            Err(at) => {
                members.insert(at, segment);
                match self.sets.iter().position(|known| *known == members) {
                    Some(known) => known as u16,
                    None if self.sets.len() < MOST_SETS => {
                        self.sets.push(members);
                        (self.sets.len() - 1) as u16
                    }
                    None => set,
                }
            }
        };
        self.with.insert((set, segment), joined);
        joined
    }

    /// Gives each voxel to the smallest segment that claims it; of equal ones to the one with the highest number.
    pub(crate) fn settle(self) -> Settled {
        let Self { mut voxels, sets, sizes, .. } = self;
        let size = |segment: &u16| (sizes.get(segment).copied().unwrap_or(0), std::cmp::Reverse(*segment));
        let winners: Vec<u16> =
            sets.iter().map(|set| set.iter().copied().min_by_key(size).unwrap_or(0)).collect();
        let mut shared = 0;
        let mut has_any = vec![false; usize::from(u16::MAX) + 1];
        for voxel in &mut voxels {
            let set = usize::from(*voxel);
            shared += u64::from(sets[set].len() > 1);
            *voxel = winners[set];
            has_any[usize::from(*voxel)] = true;
        }
        let mut covered: Vec<u16> =
            sizes.into_keys().filter(|segment| !has_any[usize::from(*segment)]).collect();
        covered.sort_unstable();
        Settled { voxels, shared, covered }
    }
}

impl Settled {
    /// What to tell of voxels that several segments claimed; `name` calls a segment by its name.
    pub(crate) fn notes(&self, name: impl Fn(u16) -> String) -> Vec<String> {
        /// Named ones.
        const MOST: usize = 8;
        let mut notes = Vec::new();
        if self.shared > 0 {
            notes.push(format!(
                "{} voxels belong to several segments; the smallest of these is kept",
                self.shared
            ));
        }
        if !self.covered.is_empty() {
            let mut names: Vec<String> =
                self.covered.iter().take(MOST).map(|segment| name(*segment)).collect();
            names.extend((self.covered.len() > MOST).then(|| format!("{} more", self.covered.len() - MOST)));
            notes.push(format!(
                "no voxel is left of what smaller segments cover wholly: {}",
                names.join(", ")
            ));
        }
        notes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_has_what_several_claim() {
        let mut claims = Claims::new(8).unwrap();
        // In either order: an organ of six, a tumour of two inside it, and a vessel of three that leaves it.
        (0..2).for_each(|voxel| claims.add(voxel + 1, 7));
        (0..6).for_each(|voxel| claims.add(voxel, 3));
        (5..8).for_each(|voxel| claims.add(voxel, 9));
        claims.add(0, 3);
        let settled = claims.settle();
        assert_eq!(settled.voxels, [3, 7, 7, 3, 3, 9, 9, 9]);
        assert_eq!((settled.shared, settled.covered.len()), (3, 0));
    }

    #[test]
    fn what_is_covered_is_told() {
        let mut claims = Claims::new(4).unwrap();
        (0..4).for_each(|voxel| claims.add(voxel, 1));
        (0..2).for_each(|voxel| claims.add(voxel, 2));
        (2..4).for_each(|voxel| claims.add(voxel, 3));
        // The same as another.
        (2..4).for_each(|voxel| claims.add(voxel, 4));
        let settled = claims.settle();
        assert_eq!((&settled.voxels[..], &settled.covered[..]), (&[2, 2, 4, 4][..], &[1, 3][..]));
        let notes = settled.notes(|segment| format!("part {segment}"));
        assert_eq!(notes[1], "no voxel is left of what smaller segments cover wholly: part 1, part 3");
        assert!(notes[0].starts_with("4 voxels"));
    }

    #[test]
    fn sets_without_end_change_nothing_that_was_claimed() {
        let mut claims = Claims::new(1).unwrap();
        (1..=u16::MAX).for_each(|segment| claims.sizes.insert(segment, 1).map_or((), drop));
        claims.sets.resize(MOST_SETS, vec![1]);
        claims.add(0, 5);
        assert_eq!(claims.voxels, [0]);
    }
}
