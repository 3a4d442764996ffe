//! Connected sets of cells, and growth along them.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};

use lumivox_core::{CancelToken, Cancelled};
use rayon::prelude::*;

use crate::grid::Grid;

/// Cells visited between two looks at the token: some milliseconds.
const VISITS: usize = 1 << 16;

/// Slices that are searched by one thread.
const SLAB: usize = 16;

/// Sets of cells that share faces, numbered from 1 in the order of their first cells.
pub struct Components {
    /// The number of each cell's component; 0 where there is none.
    pub of: Vec<u32>,
    /// Cells of each component; of 0, which is none, 0.
    pub sizes: Vec<usize>,
}

impl Components {
    /// The components of the cells that are `member`s.
    pub fn new(
        grid: &Grid,
        member: impl Fn(usize) -> bool + Sync,
        cancel: &CancelToken,
    ) -> Result<Self, Cancelled> {
        let slab_len = (SLAB * grid.slice_len()).max(1);
        let mut of = vec![0u32; grid.len()];
        // In slabs beside each other first, each with numbers of its own.
        let slabs = of.par_chunks_mut(slab_len).enumerate();
        let slabs = slabs.map(|(slab, of)| within_slab(grid, slab * slab_len, of, &member, cancel));
        let sizes_of_slabs = slabs.collect::<Result<Vec<_>, _>>()?;
        let before = sizes_of_slabs
            .iter()
            .scan(0, |sum, sizes| Some(std::mem::replace(sum, *sum + sizes.len() as u32)));
        let before: Vec<u32> = before.collect();
        // What meets at their borders is one.
        let mut joined = Joined((0..sizes_of_slabs.iter().map(Vec::len).sum::<usize>() as u32).collect());
        for slab in 1..before.len() {
            let border = slab * slab_len;
            for i in border..(border + grid.slice_len()).min(of.len()) {
                let [low, high] = [of[i - grid.slice_len()], of[i]];
                if low != 0 && high != 0 {
                    joined.join(before[slab - 1] + low - 1, before[slab] + high - 1);
                }
            }
        }
        // Numbers go by the first cells, and in a slab they do already.
        let (mut sizes, mut numbers) = (vec![0], vec![0u32; joined.0.len()]);
        for (own, &size) in sizes_of_slabs.iter().flatten().enumerate() {
            let first = joined.first(own as u32) as usize;
            if first == own {
                numbers[own] = sizes.len() as u32;
                sizes.push(0);
            }
            numbers[own] = numbers[first];
            sizes[numbers[own] as usize] += size;
        }
        of.par_chunks_mut(slab_len).zip(before).for_each(|(of, before)| {
            of.iter_mut().filter(|of| **of != 0).for_each(|of| *of = numbers[(before + *of - 1) as usize]);
        });
        Ok(Self { of, sizes })
    }
}

/// Numbers the components of a slab from 1; how many cells each has.
fn within_slab(
    grid: &Grid,
    start: usize,
    of: &mut [u32],
    member: &impl Fn(usize) -> bool,
    cancel: &CancelToken,
) -> Result<Vec<usize>, Cancelled> {
    let mut sizes = Vec::new();
    let mut stack = Vec::new();
    let mut visits = 0usize;
    for first in 0..of.len() {
        if first.is_multiple_of(VISITS) {
            cancel.check()?;
        }
        if of[first] != 0 || !member(start + first) {
            continue;
        }
        let number = sizes.len() as u32 + 1;
        let mut size = 0;
        of[first] = number;
        stack.push(start + first);
        while let Some(cell) = stack.pop() {
            size += 1;
            visits += 1;
            if visits.is_multiple_of(VISITS) {
                cancel.check()?;
            }
            grid.neighbours(cell, |next| {
                if let Some(of) = next.checked_sub(start).and_then(|next| of.get_mut(next))
                    && *of == 0
                    && member(next)
                {
                    *of = number;
                    stack.push(next);
                }
            });
        }
        sizes.push(size);
    }
    Ok(sizes)
}

/// Which numbers are of one set: each names a smaller one of it, the first itself.
struct Joined(Vec<u32>);

impl Joined {
    fn first(&mut self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            // Ways are halved while they are gone.
            let next = self.0[self.0[number as usize] as usize];
            self.0[number as usize] = next;
            number = next;
        }
        number
    }

    fn join(&mut self, a: u32, b: u32) {
        let [a, b] = [a, b].map(|number| self.first(number));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// The cells of components with a seed.
pub fn filled(
    grid: &Grid,
    seed: impl Fn(usize) -> bool + Sync,
    member: impl Fn(usize) -> bool + Sync,
    cancel: &CancelToken,
) -> Result<Vec<bool>, Cancelled> {
    let sets = Components::new(grid, member, cancel)?;
    let is_reached: Vec<AtomicBool> = sets.sizes.iter().map(|_| AtomicBool::new(false)).collect();
    sets.of.par_iter().enumerate().filter(|&(i, &set)| set != 0 && seed(i)).for_each(|(_, &set)| {
        is_reached[set as usize].store(true, Ordering::Relaxed);
    });
    Ok(sets.of.par_iter().map(|&set| is_reached[set as usize].load(Ordering::Relaxed)).collect())
}

/// Smallest and largest cell of each component.
pub fn boxes(grid: &Grid, components: &Components) -> Vec<[[usize; 3]; 2]> {
    let mut boxes = vec![[grid.dims, [0; 3]]; components.sizes.len()];
    for (i, &number) in components.of.iter().enumerate().filter(|&(_, &number)| number != 0) {
        let [low, high] = &mut boxes[number as usize];
        for (axis, at) in grid.cell(i).into_iter().enumerate() {
            low[axis] = low[axis].min(at);
            high[axis] = high[axis].max(at);
        }
    }
    boxes
}

/// The cells that seeds reach in at most `limit_mm` through cells that are `passable`, step by step over faces; the
/// seeds are among them.
pub fn reach(
    grid: &Grid,
    is_seed: impl Fn(usize) -> bool + Sync,
    passable: impl Fn(usize) -> bool + Sync,
    limit_mm: f32,
    cancel: &CancelToken,
) -> Result<Vec<bool>, Cancelled> {
    let mut best: Vec<f32> =
        (0..grid.len()).into_par_iter().map(|i| if is_seed(i) { 0.0 } else { f32::INFINITY }).collect();
    cancel.check()?;
    // From seeds among seeds there is no way to anywhere.
    let leads_on = |&i: &usize| {
        let mut leads_on = false;
        if best[i] == 0.0 {
            grid.neighbours(i, |next| leads_on |= best[next] > 0.0 && passable(next));
        }
        leads_on
    };
    let mut queue: VecDeque<usize> =
        (0..grid.len()).into_par_iter().filter(leads_on).collect::<Vec<_>>().into();
    let mut visits = 0usize;
    while let Some(cell) = queue.pop_front() {
        visits += 1;
        if visits.is_multiple_of(VISITS) {
            cancel.check()?;
        }
        let so_far = best[cell];
        grid.neighbours_along(cell, |axis, next| {
            let way = so_far + grid.cell_mm[axis];
            // Ways that are shorter are followed anew: what is found is the shortest.
            if way <= limit_mm && way < best[next] && passable(next) {
                best[next] = way;
                queue.push_back(next);
            }
        });
    }
    Ok(best.into_par_iter().map(f32::is_finite).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(dims: [usize; 3]) -> Grid {
        Grid { dims, cell_mm: [2.0; 3], along: [0.0; 2], axes: [0, 1, 2], factors: [1; 3] }
    }

    /// As many members as neither fill the grid nor fall apart: sets wind through all slabs.
    fn members(grid: &Grid) -> Vec<bool> {
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            state >> 33
        };
        (0..grid.len()).map(|_| next() % 100 < 33).collect()
    }

    /// The same, a cell after the other.
    fn plain(grid: &Grid, member: &[bool]) -> (Vec<u32>, Vec<usize>) {
        let (mut of, mut sizes) = (vec![0; grid.len()], vec![0]);
        for first in 0..grid.len() {
            if !member[first] || of[first] != 0 {
                continue;
            }
            let number = sizes.len() as u32;
            let mut stack = vec![first];
            of[first] = number;
            sizes.push(0);
            while let Some(cell) = stack.pop() {
                sizes[number as usize] += 1;
                grid.neighbours(cell, |next| {
                    if member[next] && of[next] == 0 {
                        of[next] = number;
                        stack.push(next);
                    }
                });
            }
        }
        (of, sizes)
    }

    #[test]
    fn sets_are_the_same_however_many_slabs_they_cross() {
        let never = CancelToken::new();
        for dims in [[17, 13, 5 * SLAB + 3], [9, 7, SLAB], [5, 4, 1], [3, 0, 2]] {
            let grid = grid(dims);
            let member = members(&grid);
            let found = Components::new(&grid, |i| member[i], &never).unwrap();
            assert_eq!((found.of, found.sizes), plain(&grid, &member), "{dims:?}");
        }
    }

    #[test]
    fn what_has_a_seed_is_filled_and_what_is_far_is_not_reached() {
        let never = CancelToken::new();
        let grid = grid([5, 1, 3 * SLAB]);
        // Two columns, of which one is interrupted.
        let member = |i: usize| matches!(grid.cell(i), [0, _, z] if z != 20) || grid.cell(i)[0] == 3;
        let seed = |i: usize| grid.cell(i) == [0, 0, 0];
        let all = filled(&grid, seed, member, &never).unwrap();
        let near = reach(&grid, seed, member, 10.0, &never).unwrap();
        for i in 0..grid.len() {
            let [x, _, z] = grid.cell(i);
            assert_eq!((all[i], near[i]), (x == 0 && z < 20, x == 0 && z <= 5), "{x}, {z}");
        }
    }
}
