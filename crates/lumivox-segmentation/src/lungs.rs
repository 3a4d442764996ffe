//! What kind of hollow a hollow in the body is.

use lumivox_core::{CancelToken, Cancelled};

use crate::{components::Components, distance::distances, grid::Grid};

/// Cells below this hold lung or gas, in HU.
pub const AIRY_HU: f32 = -450.0;

/// The smallest lung, in ml: of a child, or a part of one in the field of view.
const LEAST_LUNG_ML: f64 = 15.0;

/// Median values of lungs: above gas, and below what a partial volume at a surface has.
const LUNG_HU: std::ops::Range<f32> = -955.0..-500.0;

/// Half the thickness of vessels in lungs that belong to them, in mm.
const VESSEL_MM: f32 = 3.0;

/// Finds the lungs among the cells that are `hollow`s of the body; airways are still part of them.
pub fn lungs(
    grid: &Grid,
    means: &[f32],
    hollow: &(impl Fn(usize) -> bool + Sync),
    cancel: &CancelToken,
) -> Result<Vec<bool>, Cancelled> {
    let sets = Components::new(grid, hollow, cancel)?;
    let least = LEAST_LUNG_ML / grid.cell_ml();
    // What is away from walls is neither wall in part.
    let from_wall = distances(grid, &|i| !hollow(i), 5.0, cancel)?;
    let away = grid.cell_mm[0].max(grid.cell_mm[1]);
    let mut values: Vec<Vec<f32>> = vec![Vec::new(); sets.sizes.len()];
    for (i, &set) in sets.of.iter().enumerate() {
        if sets.sizes[set as usize] as f64 >= least && from_wall[i] > away {
            values[set as usize].push(means[i]);
        }
    }
    let is_lung: Vec<bool> = values
        .iter_mut()
        .map(|values| {
            if values.len() < 8 {
                return false;
            }
            let middle = values.len() / 2;
            let (_, median, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
            LUNG_HU.contains(median)
        })
        .collect();
    Ok(sets.of.iter().map(|&set| is_lung[set as usize]).collect())
}

/// A morphological closing that takes the vessels in.
pub fn with_vessels(grid: &Grid, lungs: &[bool], cancel: &CancelToken) -> Result<Vec<bool>, Cancelled> {
    let from_lung = distances(grid, &|i| lungs[i], VESSEL_MM + 1.0, cancel)?;
    let from_rest = distances(grid, &|i| from_lung[i] > VESSEL_MM, VESSEL_MM + 1.0, cancel)?;
    Ok(from_rest.iter().zip(lungs).map(|(&mm, &lung)| lung || mm > VESSEL_MM).collect())
}
