//! What was taken out of a scan, so that it can be brought back: the voxels that [`patient_alone`](crate::patient_alone)
//! changed, as they were. A table is a small part of a scan, and a second scan need not be kept for it.

use lumivox_core::{Volume, Voxels, document::Keep};

/// Voxels of a scan, and what they were, as runs along its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// The first voxel of each run, and their number; by rising place.
    runs: Vec<[usize; 2]>,
    /// The samples of all runs, one after the other.
    samples: Voxels,
}

/// What was taken out of some rows of samples.
#[derive(Debug)]
pub(crate) struct Removed<T> {
    runs: Vec<[usize; 2]>,
    samples: Vec<T>,
}

impl<T> Default for Removed<T> {
    fn default() -> Self {
        Self { runs: vec![], samples: vec![] }
    }
}

impl<T> Removed<T> {
    /// Adds what the voxel in place `at` was; places rise.
    pub fn push(&mut self, at: usize, sample: T) {
        match self.runs.last_mut() {
            Some([first, count]) if *first + *count == at => *count += 1,
            _ => self.runs.push([at, 1]),
        }
        self.samples.push(sample);
    }
}

/// Runs that are not those of a scan's voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("what lies around the patient is of another scan, or damaged")]
pub struct WrongSurroundings;

impl Surroundings {
    /// `None` where nothing was taken.
    pub(crate) fn of<T>(parts: Vec<Removed<T>>, voxels: fn(Vec<T>) -> Voxels) -> Option<Self> {
        let (mut runs, mut samples) = (vec![], vec![]);
        for part in parts {
            runs.extend(part.runs);
            samples.extend(part.samples);
        }
        (!runs.is_empty()).then(|| Self { runs, samples: voxels(samples) })
    }

    /// Of what [`Surroundings::runs`] and [`Surroundings::samples`] gave, from a file.
    ///
    /// # Errors
    /// [`WrongSurroundings`] where runs overlap, do not rise, or are not of so many samples.
    pub fn from_parts(runs: Vec<[usize; 2]>, samples: Voxels) -> Result<Self, WrongSurroundings> {
        let (mut end, mut count) = (0usize, 0usize);
        for &[first, length] in &runs {
            if first < end || length == 0 {
                return Err(WrongSurroundings);
            }
            end = first.checked_add(length).ok_or(WrongSurroundings)?;
            count += length;
        }
        if count == 0 || count != samples.len() { Err(WrongSurroundings) } else { Ok(Self { runs, samples }) }
    }

    /// The first voxel of each run, x fastest, then y, then z, and how many there are.
    pub fn runs(&self) -> &[[usize; 2]] {
        &self.runs
    }

    /// What the voxels of all runs were, as the scan stores them.
    pub fn samples(&self) -> &Voxels {
        &self.samples
    }

    /// How many voxels they are.
    pub fn voxel_count(&self) -> usize {
        self.samples.len()
    }

    /// Whether a scan has these voxels, and samples of the type.
    pub fn fits(&self, scan: &Volume) -> bool {
        let end = self.runs.last().map_or(0, |[first, count]| first + count);
        let is_same_type = std::mem::discriminant(&self.samples) == std::mem::discriminant(scan.voxels());
        end <= scan.voxel_count() && is_same_type
    }

    /// The scan as it was before they were taken out of it.
    ///
    /// # Errors
    /// [`WrongSurroundings`] where they are not [of it](Self::fits).
    pub fn put_back(&self, alone: &Volume) -> Result<Volume, WrongSurroundings> {
        if !self.fits(alone) {
            return Err(WrongSurroundings);
        }
        let whole = alone.clone().edit(|voxels| match (voxels, &self.samples) {
            (Voxels::U8(all), Voxels::U8(were)) => self.copy(all, were),
            (Voxels::U16(all), Voxels::U16(were)) => self.copy(all, were),
            (Voxels::F32(all), Voxels::F32(were)) => self.copy(all, were),
            _ => unreachable!("samples of one type"),
        });
        let whole = whole.map_err(|_| WrongSurroundings)?;
        Ok(whole.with_source_changed(|scan| scan.keep = Keep::Everything))
    }

    fn copy<T: Copy>(&self, all: &mut [T], were: &[T]) {
        let mut rest = were;
        for &[first, count] in &self.runs {
            let (run, behind) = rest.split_at(count);
            all[first..first + count].copy_from_slice(run);
            rest = behind;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumivox_core::{Modality, glam::DAffine3};

    #[test]
    fn runs_hold_what_was_there() {
        let mut removed = Removed::default();
        for (at, sample) in [(2, 7u16), (3, 8), (6, 9)] {
            removed.push(at, sample);
        }
        let mut later = Removed::default();
        later.push(8, 5);
        let all = Surroundings::of(vec![removed, Removed::default(), later], Voxels::U16).unwrap();
        assert_eq!(all.runs(), [[2, 2], [6, 1], [8, 1]]);
        let voxels = Voxels::U16(vec![0, 1, 0, 0, 4, 5, 0, 3, 0]);
        let alone = Volume::new([3, 3, 1], voxels, [1.0, -9.0], DAffine3::IDENTITY, Modality::Ct).unwrap();
        let whole = all.put_back(&alone).unwrap();
        assert_eq!(*whole.voxels(), Voxels::U16(vec![0, 1, 7, 8, 4, 5, 9, 3, 5]));
        assert_eq!((whole.value_range(), whole.unit()), ([-9.0, 0.0], alone.unit()));
        assert_eq!(Surroundings::from_parts(all.runs().to_vec(), all.samples().clone()), Ok(all));
        assert_eq!(Surroundings::of(vec![Removed::<u8>::default()], Voxels::U8), None);
    }

    #[test]
    fn runs_of_another_scan_are_refused() {
        let new = |runs: &[[usize; 2]], samples| Surroundings::from_parts(runs.to_vec(), Voxels::U8(samples));
        for (runs, samples) in [
            (vec![], vec![]),
            (vec![[3, 2], [4, 1]], vec![1, 2, 3]),
            (vec![[3, 0]], vec![]),
            (vec![[3, 2]], vec![1]),
            (vec![[usize::MAX, 2]], vec![1, 2]),
        ] {
            assert_eq!(new(&runs, samples), Err(WrongSurroundings), "{runs:?}");
        }
        let scan = |voxels| Volume::new([2, 1, 1], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct);
        let last = new(&[[1, 1]], vec![9]).unwrap();
        assert!(last.put_back(&scan(Voxels::U8(vec![1, 2])).unwrap()).is_ok());
        assert!(last.put_back(&scan(Voxels::U16(vec![1, 2])).unwrap()).is_err());
        assert!(new(&[[2, 1]], vec![9]).unwrap().put_back(&scan(Voxels::U8(vec![1, 2])).unwrap()).is_err());
    }
}
