//! Which cells are outside the patient: air, and what lies in it.
//!
//! Air is followed from the sides of each axial slice, around the body. Lungs, trachea and bowel that are open at the
//! first or last slice are not reached so; a closing keeps out of nostrils and ears. Where limbs enclose air in a slice,
//! it is reached from other slices, through wide passages only.

use lumivox_core::{CancelToken, Cancelled};
use rayon::prelude::*;

use crate::{
    class::Class,
    components::{Components, filled, reach},
    distance::{distances, distances_in_slices},
    grid::Grid,
};

/// Half the width up to which openings of the body are closed, in mm: within a slice, and from slice to slice.
const CLOSING_MM: f32 = 4.0;
const WIDE_MM: f32 = 8.0;

/// How far air is followed into narrower places, along the axes of the grid, in mm.
const INTO_NARROW_MM: f32 = 12.0;

/// Air at the side of a slice is outside when this share of it is darker than lungs are, in HU.
const DARK_SHARE: f64 = 0.25;
const DARK_HU: f32 = -955.0;

/// The smallest such air, in mm^2; smaller ones are reached from other slices.
const LEAST_MM2: f32 = 400.0;

/// Share of the cells of a hollow that touch the outside, from which on it is a groove of the skin.
const GROOVE_SHARE: f64 = 0.025;

/// What is outside.
pub struct Outside {
    /// Cells that are: air and things, those of the table too.
    pub cells: Vec<bool>,
    /// Columns of cells that lie outside a round field of view, where nothing was measured; empty where it is not round.
    pub unmeasured: Vec<bool>,
    /// Share of the rim of the slices at which the body is cut off.
    pub cut: f64,
}

impl Outside {
    /// Finds it, around the cells that `class` says are the body.
    pub fn new(grid: &Grid, means: &[f32], class: &[u8], cancel: &CancelToken) -> Result<Self, Cancelled> {
        let body = |i: usize| class[i] == Class::Body.value();
        let unmeasured = unmeasured(grid, means);
        let measured = |i: usize| unmeasured.is_empty() || !unmeasured[i % grid.slice_len()];
        let rim = rim(grid, &unmeasured);

        let in_slice = distances_in_slices(grid, &body, CLOSING_MM + 1.0, cancel)?;
        let mut core = vec![false; grid.len()];
        core.par_chunks_mut(grid.slice_len()).enumerate().try_for_each(|(z, core)| {
            cancel.check()?;
            let first = z * grid.slice_len();
            let open = |i: usize| in_slice[first + i] > CLOSING_MM && measured(first + i);
            air_at_sides(grid, &means[first..][..core.len()], open, &rim, core);
            Ok(())
        })?;
        let from_body = distances(grid, &body, WIDE_MM + 1.0, cancel)?;
        let wide = |i: usize| from_body[i] > WIDE_MM && measured(i);
        let reached = filled(grid, |i| core[i], wide, cancel)?;
        core.iter_mut().zip(&reached).for_each(|(core, &reached)| *core |= reached);

        let hollow = |i: usize| !body(i) && measured(i);
        let mut cells = reach(grid, |i| core[i], hollow, INTO_NARROW_MM, cancel)?;
        open_grooves(grid, &hollow, &mut cells, cancel)?;
        let at_rim = (0..grid.len()).filter(|&i| rim[i % grid.slice_len()]);
        let (all, of_body) =
            at_rim.fold((0usize, 0usize), |(all, of_body), i| (all + 1, of_body + usize::from(body(i))));
        let slice_len = grid.slice_len();
        cells.iter_mut().enumerate().for_each(|(i, cell)| {
            *cell |= !unmeasured.is_empty() && unmeasured[i % slice_len];
        });
        Ok(Self { cells, unmeasured, cut: of_body as f64 / all.max(1) as f64 })
    }
}

/// Marks what of a slice is `open` to its rim, and air.
fn air_at_sides(grid: &Grid, means: &[f32], open: impl Fn(usize) -> bool, rim: &[bool], core: &mut [bool]) {
    let [nx, ny, _] = grid.dims;
    let mut seen = vec![false; core.len()];
    let mut members = Vec::new();
    for first in 0..core.len() {
        if seen[first] || !rim[first] || !open(first) {
            continue;
        }
        members.clear();
        members.push(first);
        seen[first] = true;
        let mut at = 0;
        let (mut airy, mut dark) = (0usize, 0usize);
        while at < members.len() {
            let i = members[at];
            at += 1;
            airy += usize::from(means[i] < -500.0);
            dark += usize::from(means[i] < DARK_HU);
            let (x, y) = (i % nx, i / nx);
            let mut visit = |next: usize| {
                if !seen[next] && open(next) {
                    seen[next] = true;
                    members.push(next);
                }
            };
            if x > 0 {
                visit(i - 1);
            }
            if x + 1 < nx {
                visit(i + 1);
            }
            if y > 0 {
                visit(i - nx);
            }
            if y + 1 < ny {
                visit(i + nx);
            }
        }
        // A lung that the field of view cuts touches the rim, too, and an airway may be as dark.
        let mm2 = members.len() as f32 * grid.cell_mm[0] * grid.cell_mm[1];
        if mm2 >= LEAST_MM2 && dark as f64 >= DARK_SHARE * airy as f64 {
            members.iter().for_each(|&i| core[i] = true);
        }
    }
}

/// Hollows that are open to the outside along much of their surface are folds of the skin, and gaps between limbs.
fn open_grooves(
    grid: &Grid,
    hollow: &(impl Fn(usize) -> bool + Sync),
    outside: &mut [bool],
    cancel: &CancelToken,
) -> Result<(), Cancelled> {
    let hollows = Components::new(grid, |i| hollow(i) && !outside[i], cancel)?;
    let mut touching = vec![0usize; hollows.sizes.len()];
    for (i, &number) in hollows.of.iter().enumerate().filter(|&(_, &number)| number != 0) {
        let mut touches = false;
        grid.neighbours(i, |next| touches |= outside[next]);
        touching[number as usize] += usize::from(touches);
    }
    for (i, &number) in hollows.of.iter().enumerate().filter(|&(_, &number)| number != 0) {
        let number = number as usize;
        outside[i] |= touching[number] as f64 >= GROOVE_SHARE * hollows.sizes[number] as f64;
    }
    Ok(())
}

/// The cells of a slice at which what was measured ends.
fn rim(grid: &Grid, unmeasured: &[bool]) -> Vec<bool> {
    let [nx, ny, _] = grid.dims;
    (0..grid.slice_len())
        .map(|i| {
            let (x, y) = (i % nx, i / nx);
            if unmeasured.is_empty() {
                return x == 0 || y == 0 || x + 1 == nx || y + 1 == ny;
            }
            let at = |x: usize, y: usize| x >= nx || y >= ny || unmeasured[y * nx + x];
            !unmeasured[i]
                && (at(x.wrapping_sub(1), y) || at(x + 1, y) || at(x, y.wrapping_sub(1)) || at(x, y + 1))
        })
        .collect()
}

/// The columns outside a round field of view: those that hold the corner's value in every slice, if they are what a
/// disc leaves of the slice.
fn unmeasured(grid: &Grid, means: &[f32]) -> Vec<bool> {
    let [nx, ny, _] = grid.dims;
    let mut same = vec![true; grid.slice_len()];
    let padding = means[0];
    for slice in means.chunks_exact(grid.slice_len()) {
        same.iter_mut().zip(slice).for_each(|(same, &mean)| *same &= (mean - padding).abs() < 1e-2);
    }
    // The disc reaches as far as the nearest side, or a bit less.
    let half = [nx, ny].map(|n| n as f32 / 2.0);
    let radius_of = |i: usize| {
        let offset = [(i % nx) as f32 + 0.5 - half[0], (i / nx) as f32 + 0.5 - half[1]];
        (offset[0] * grid.cell_mm[0]).hypot(offset[1] * grid.cell_mm[1])
    };
    let largest = (half[0] * grid.cell_mm[0]).max(half[1] * grid.cell_mm[1]);
    let inside = same.iter().enumerate().filter(|&(_, &same)| !same).map(|(i, _)| radius_of(i));
    let radius = inside.fold(0f32, f32::max);
    let cell = grid.cell_mm[0].max(grid.cell_mm[1]);
    let beyond = (0..same.len()).filter(|&i| radius_of(i) > radius).count();
    let unlike = (0..same.len()).filter(|&i| same[i] && radius_of(i) < radius - 1.5 * cell).count();
    let round = radius <= largest + cell && radius > 0.8 * largest;
    // Air that is exactly even everywhere, as in phantoms, has no such border.
    if round && beyond * 20 > same.len() && unlike * 100 < same.len() { same } else { Vec::new() }
}
