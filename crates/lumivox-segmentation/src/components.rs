//! Connected sets of cells, and growth along them.

use std::collections::VecDeque;

use lumivox_core::{CancelToken, Cancelled};

use crate::grid::Grid;

/// Cells visited between two looks at the token: some milliseconds.
const VISITS: usize = 1 << 16;

/// Sets of cells that share faces, numbered from 1 in the order of their first cells.
pub struct Components {
    /// The number of each cell's component; 0 where there is none.
    pub of: Vec<u32>,
    /// Cells of each component; of 0, which is none, 0.
    pub sizes: Vec<usize>,
}

impl Components {
    /// The components of the cells that are `member`s.
    pub fn new(grid: &Grid, member: impl Fn(usize) -> bool, cancel: &CancelToken) -> Result<Self, Cancelled> {
        let mut of = vec![0u32; grid.len()];
        let mut sizes = vec![0];
        let mut stack = Vec::new();
        let mut visits = 0usize;
        for first in 0..grid.len() {
            if first.is_multiple_of(VISITS) {
                cancel.check()?;
            }
            if of[first] != 0 || !member(first) {
                continue;
            }
            let number = sizes.len() as u32;
            sizes.push(0);
            of[first] = number;
            stack.push(first);
            while let Some(cell) = stack.pop() {
                sizes[number as usize] += 1;
                visits += 1;
                if visits.is_multiple_of(VISITS) {
                    cancel.check()?;
                }
                grid.neighbours(cell, |next| {
                    if of[next] == 0 && member(next) {
                        of[next] = number;
                        stack.push(next);
                    }
                });
            }
        }
        Ok(Self { of, sizes })
    }
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

/// The cells that `seeds` reach in at most `limit_mm` through cells that are `passable`, step by step over faces; the
/// seeds are among them. Visits in the order of steps, whatever their lengths: near enough for short ways.
pub fn reach(
    grid: &Grid,
    seeds: impl Iterator<Item = usize>,
    passable: impl Fn(usize) -> bool,
    limit_mm: f32,
    cancel: &CancelToken,
) -> Result<Vec<bool>, Cancelled> {
    let mut best = vec![f32::INFINITY; grid.len()];
    let mut queue: VecDeque<usize> = seeds.collect();
    queue.iter().for_each(|&seed| best[seed] = 0.0);
    let strides = [1, grid.dims[0], grid.slice_len()];
    let mut visits = 0usize;
    while let Some(cell) = queue.pop_front() {
        visits += 1;
        if visits.is_multiple_of(VISITS) {
            cancel.check()?;
        }
        let so_far = best[cell];
        grid.neighbours(cell, |next| {
            let axis = strides.iter().rposition(|&stride| stride == next.abs_diff(cell)).unwrap_or(0);
            let way = so_far + grid.cell_mm[axis];
            if way <= limit_mm && way < best[next] && passable(next) {
                best[next] = way;
                queue.push_back(next);
            }
        });
    }
    Ok(best.into_iter().map(f32::is_finite).collect())
}
