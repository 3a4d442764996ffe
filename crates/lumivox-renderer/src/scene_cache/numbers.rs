//! Which volume is which, for the light that is kept in them: a small number for each, by which cells know whose they are.
//!
//! A volume of the scene is known by its voxels and by how many of them are on the device; of those with the same voxels, by
//! where it stood. It keeps its number while it moves and while others come and go. The number of one that is gone is the last to
//! be given again.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::{Arc, Weak};

use lumivox_core::Volume;
use lumivox_core::glam::DAffine3;

use crate::ids;
use crate::recording::ResourceId;

/// As many as the place of a block has bits for, see `light_cells.wgsl`.
pub(crate) const MOST_LIT_VOLUMES: u32 = 4096;

/// A volume of the scene, as one that was there before is told by.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    /// Not held: but its address is not used again.
    volume: Weak<Volume>,
    dims: [u32; 3],
    world_from_patient: DAffine3,
}

impl Shape {
    pub fn new(volume: &Arc<Volume>, dims: [u32; 3], world_from_patient: DAffine3) -> Self {
        Self { volume: Arc::downgrade(volume), dims, world_from_patient }
    }

    /// The same points of its own space are the same points of the same voxels.
    fn kind(&self) -> (usize, [u32; 3]) {
        (self.volume.as_ptr().addr(), self.dims)
    }

    /// The same, at the same place.
    fn place(&self) -> (usize, [u32; 3], [u64; 12]) {
        let (volume, dims) = self.kind();
        (volume, dims, self.world_from_patient.to_cols_array().map(f64::to_bits))
    }

    fn distance(&self, other: &Self) -> f64 {
        self.world_from_patient.translation.distance_squared(other.world_from_patient.translation)
    }
}

/// A number, and whose it is: of two volumes, the ids are different, though one may have the number that the other had.
pub(crate) type Numbered = (u32, ResourceId);

/// The volumes that rays meet, and their numbers.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    shapes: Vec<Shape>,
    /// Of each of them.
    given: Vec<Option<Numbered>>,
    /// The same by number; none if there are more volumes than numbers.
    list: Option<Vec<Numbered>>,
    next: u32,
}

impl Numbers {
    /// The volumes of the scene as it is now.
    pub fn update(&mut self, shapes: Vec<Shape>) {
        let places = |shapes: &[Shape]| shapes.iter().map(Shape::place).collect::<Vec<_>>();
        if self.list.is_some() && places(&self.shapes) == places(&shapes) {
            return;
        }
        let before = std::mem::replace(&mut self.shapes, shapes);
        let had = std::mem::take(&mut self.given);
        self.given = vec![None; self.shapes.len()];
        // What stands where it stood.
        let mut standing: HashMap<_, Vec<usize>> = HashMap::new();
        for (old, shape) in before.iter().enumerate().rev() {
            standing.entry(shape.place()).or_default().push(old);
        }
        let mut is_left = vec![true; before.len()];
        for (shape, given) in self.shapes.iter().zip(&mut self.given) {
            if let Some(old) = standing.get_mut(&shape.place()).and_then(Vec::pop) {
                is_left[old] = false;
                *given = had[old];
            }
        }
        self.give_to_moved(&before, &had, &is_left);
        // What is new.
        let mut taken: HashSet<u32> = self.given.iter().flatten().map(|(number, _)| *number).collect();
        for given in self.given.iter_mut().filter(|given| given.is_none()) {
            let mut free = (0..MOST_LIT_VOLUMES).map(|i| (self.next + i) % MOST_LIT_VOLUMES);
            let Some(number) = free.find(|number| !taken.contains(number)) else { break };
            taken.insert(number);
            self.next = number + 1;
            *given = Some((number, ids::next()));
        }
        let mut list: Option<Vec<Numbered>> = self.given.iter().copied().collect();
        list.iter_mut().for_each(|list| list.sort_unstable());
        self.list = list;
    }

    /// Numbers of what has left its place, to those that have come to one: in their order, or to the nearest where some of
    /// them came or went.
    fn give_to_moved(&mut self, before: &[Shape], had: &[Option<Numbered>], is_left: &[bool]) {
        let mut gone: HashMap<_, VecDeque<usize>> = HashMap::new();
        for (old, shape) in before.iter().enumerate().filter(|(old, _)| is_left[*old]) {
            gone.entry(shape.kind()).or_default().push_back(old);
        }
        let mut come: HashMap<_, usize> = HashMap::new();
        let is_new = |given: &Option<Numbered>| given.is_none();
        for (shape, _) in self.shapes.iter().zip(&self.given).filter(|(_, given)| is_new(given)) {
            *come.entry(shape.kind()).or_default() += 1;
        }
        for (shape, given) in self.shapes.iter().zip(&mut self.given).filter(|(_, given)| is_new(given)) {
            let Some(of_kind) = gone.get_mut(&shape.kind()) else { continue };
            let left = come.get_mut(&shape.kind()).expect("it was counted");
            let nearest = |of_kind: &VecDeque<usize>| {
                let distance = |i: &usize| shape.distance(&before[of_kind[*i]]);
                (0..of_kind.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
            };
            let which = if *left == of_kind.len() { Some(0) } else { nearest(of_kind) };
            *left -= 1;
            *given = which.and_then(|i| of_kind.remove(i)).and_then(|old| had[old]);
        }
    }

    /// The number of the scene's `index`th volume; 0 where there are more than numbers, and light is not kept.
    pub fn of(&self, index: usize) -> u32 {
        self.given[index].map_or(0, |(number, _)| number)
    }

    /// All of them by number; `None` where there are more volumes than numbers.
    pub fn list(&self) -> Option<&[Numbered]> {
        self.list.as_deref()
    }

    /// Where each of them is; those without a number are not told of.
    pub fn places(&self) -> impl Iterator<Item = (Numbered, DAffine3)> {
        self.given
            .iter()
            .zip(&self.shapes)
            .filter_map(|(given, shape)| Some(((*given)?, shape.world_from_patient)))
    }

    /// Voxels of all volumes, empty ones included.
    pub fn voxels(&self) -> u64 {
        self.shapes.iter().map(|shape| shape.dims.iter().map(|&n| u64::from(n)).product::<u64>()).sum()
    }
}

#[cfg(test)]
mod tests {
    use lumivox_core::glam::DVec3;
    use lumivox_testing::scenes::noise_volume;

    use super::*;

    fn scan() -> Arc<Volume> {
        noise_volume(1, [4; 3])
    }

    fn at(volume: &Arc<Volume>, x: f64) -> Shape {
        Shape::new(volume, [4; 3], DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)))
    }

    fn ids(numbers: &Numbers) -> Vec<Numbered> {
        numbers.given.iter().map(|given| given.unwrap()).collect()
    }

    #[test]
    fn a_volume_keeps_its_number_while_it_moves_and_others_come_and_go() {
        let [a, b, c] = [scan(), scan(), scan()];
        let mut numbers = Numbers::default();
        numbers.update(vec![at(&a, 0.0), at(&b, 1.0)]);
        let [of_a, of_b] = ids(&numbers).try_into().unwrap();
        assert_ne!(of_a.0, of_b.0);
        numbers.update(vec![at(&c, 5.0), at(&b, 2.0), at(&a, 0.0)]);
        let [of_c, still_b, still_a] = ids(&numbers).try_into().unwrap();
        assert_eq!([still_a, still_b], [of_a, of_b]);
        assert!(![of_a.0, of_b.0].contains(&of_c.0));
        numbers.update(vec![at(&b, 2.0)]);
        assert_eq!(ids(&numbers), [of_b]);
        // One that was gone is another when it comes again.
        numbers.update(vec![at(&b, 2.0), at(&a, 0.0)]);
        let [still_b, new_a] = ids(&numbers).try_into().unwrap();
        assert_eq!(still_b, of_b);
        assert!(new_a.1 != of_a.1 && new_a.0 != of_a.0);
    }

    #[test]
    fn a_volume_at_the_address_of_another_is_another() {
        let mut numbers = Numbers::default();
        let mut seen = HashSet::new();
        for _ in 0..64 {
            // Freed before the next is made: only the weak reference keeps its place.
            let volume = scan();
            numbers.update(vec![at(&volume, 0.0)]);
            assert!(seen.insert(ids(&numbers)[0]));
        }
        // Of another grain its points are others, too.
        let volume = scan();
        numbers.update(vec![at(&volume, 0.0)]);
        let before = ids(&numbers);
        numbers.update(vec![Shape { dims: [2; 3], ..at(&volume, 0.0) }]);
        assert_ne!(ids(&numbers), before);
    }

    #[test]
    fn copies_of_a_volume_are_told_by_where_they_stand() {
        let a = scan();
        let row = |places: &[f64]| places.iter().map(|x| at(&a, *x)).collect();
        let mut numbers = Numbers::default();
        numbers.update(row(&[0.0, 1.0, 2.0]));
        let [first, second, third] = ids(&numbers).try_into().unwrap();
        // The first goes, in any order.
        numbers.update(row(&[2.0, 1.0]));
        assert_eq!(ids(&numbers), [third, second]);
        // They all move, and one goes meanwhile.
        numbers.update(row(&[2.1, 1.1]));
        assert_eq!(ids(&numbers), [third, second]);
        numbers.update(row(&[1.2]));
        assert_eq!(ids(&numbers), [second]);
        assert!(!ids(&numbers).contains(&first));
    }

    #[test]
    fn numbers_are_not_given_again_soon_nor_twice() {
        let most = MOST_LIT_VOLUMES as usize;
        let all: Vec<Arc<Volume>> = (0..=most).map(|_| scan()).collect();
        let mut numbers = Numbers::default();
        numbers.update(all[..most - 1].iter().map(|volume| at(volume, 0.0)).collect());
        let last = ids(&numbers)[most - 2].0;
        // The first is gone: its number comes after the one that was never given.
        numbers.update(all[1..most].iter().map(|volume| at(volume, 0.0)).collect());
        assert_eq!(ids(&numbers)[most - 2].0, last + 1);
        let given: HashSet<u32> = ids(&numbers).iter().map(|(number, _)| *number).collect();
        assert_eq!(given.len(), most - 1);
        numbers.update(all[..most].iter().map(|volume| at(volume, 0.0)).collect());
        assert_eq!(numbers.list().unwrap().len(), most);
        // One more than there are numbers; and then not.
        numbers.update(all.iter().map(|volume| at(volume, 0.0)).collect());
        assert_eq!(numbers.list(), None);
        numbers.update(all[1..].iter().map(|volume| at(volume, 0.0)).collect());
        assert_eq!(numbers.list().unwrap().len(), most);
    }
}
