//! What carries the patient: shells that run along the patient with a constant cross-section.
//!
//! Nothing here knows where a table should be: prone, decubitus and feet-first patients lie on one as well.

use std::collections::VecDeque;

use lumivox_core::{
    CancelToken, Cancelled,
    glam::{DMat3, DVec3},
};

use crate::{
    components::{Components, boxes},
    grid::Grid,
};

/// Length along the patient from which on a shell can be told from ears, noses and folds of skin, in mm.
const RUN_MM: f32 = 60.0;

/// Shortest scan whose shells can be told by their length, in mm.
const SHORTEST_MM: f32 = 30.0;

/// Size across the patient, and volume, from which on a set of runs is a shell and no sliver at the patient's skin.
const SHELL_MM: f32 = 50.0;
const SHELL_ML: f64 = 3.0;

/// Thickness up to which a shell is followed below the patient's back, in mm.
const THICKNESS_MM: f32 = 6.0;

/// How far around a cell its shell is looked at, in mm, and the fewest cells that make a piece of one.
const WINDOW_MM: f32 = 14.0;
const LEAST_CELLS: f64 = 16.0;

/// How much thicker than usual, and how far in HU from what is near of it, a shell is where it is followed.
const THICKER: f64 = 1.25;
const UNLIKE_HU: f32 = 150.0;

/// The cells of shells: `thin` cells in long straight runs along z that are wide across it together, and what goes on
/// of them below the patient's back, where they are as `thin` no more: solid cells that lie at most a shell's thickness
/// below a surface (`depth`).
pub fn shells(
    grid: &Grid,
    means: &[f32],
    thin: &[bool],
    depth: &[f32],
    cancel: &CancelToken,
) -> Result<Vec<bool>, Cancelled> {
    let [nx, ny, nz] = grid.dims;
    let slice_len = grid.slice_len();
    let mut shell = vec![false; grid.len()];
    let long_mm = nz as f32 * grid.cell_mm[2];
    if long_mm < SHORTEST_MM || nz < 4 {
        return Ok(shell);
    }
    let run = ((RUN_MM.min(0.9 * long_mm) / grid.cell_mm[2]).ceil() as usize).max(2);
    // A table bends under a patient: a run may sway by a cell.
    let near = |i: usize| {
        let (x, y) = (i % nx, i / nx % ny);
        thin[i]
            || x > 0 && thin[i - 1]
            || x + 1 < nx && thin[i + 1]
            || y > 0 && thin[i - nx]
            || y + 1 < ny && thin[i + nx]
    };
    // Along the patient: in a field of view that was turned, lines of cells are not parallel to that.
    let drift = |axis: usize, z: usize| (grid.along[axis] * z as f32).round() as i64;
    let ends = |axis: usize, n: usize| {
        let last = drift(axis, nz - 1);
        -last.max(0)..n as i64 - last.min(0)
    };
    for v in ends(1, ny) {
        cancel.check()?;
        for u in ends(0, nx) {
            let at = |z: usize| {
                let (x, y) = (u + drift(0, z), v + drift(1, z));
                let inside = (0..nx as i64).contains(&x) && (0..ny as i64).contains(&y);
                inside.then(|| z * slice_len + y as usize * nx + x as usize)
            };
            let mut first = 0;
            for z in 0..=nz {
                if z < nz && at(z).is_some_and(near) {
                    continue;
                }
                if z - first >= run {
                    for i in (first..z).filter_map(at) {
                        shell[i] = thin[i];
                    }
                }
                first = z + 1;
            }
        }
    }
    // Slanted shells of one cell touch at corners only: join them in the slice.
    let joined = |i: usize| {
        let (x, y) = (i % nx, i / nx % ny);
        shell[i]
            || x > 0 && shell[i - 1]
            || x + 1 < nx && shell[i + 1]
            || y > 0 && shell[i - nx]
            || y + 1 < ny && shell[i + nx]
    };
    let sets = Components::new(grid, joined, cancel)?;
    let mut cells = vec![0usize; sets.sizes.len()];
    for (i, _) in shell.iter().enumerate().filter(|&(_, &shell)| shell) {
        cells[sets.of[i] as usize] += 1;
    }
    let wide: Vec<bool> = boxes(grid, &sets)
        .iter()
        .zip(&cells)
        .map(|([low, high], &cells)| {
            let across = |axis: usize| high[axis].saturating_sub(low[axis]) as f32 * grid.cell_mm[axis];
            across(0).hypot(across(1)) >= SHELL_MM && cells as f64 * grid.cell_ml() >= SHELL_ML
        })
        .collect();
    for (shell, &set) in shell.iter_mut().zip(&sets.of) {
        *shell &= wide[set as usize];
    }
    follow(grid, means, &mut shell, thin, depth, cancel)?;
    Ok(shell)
}

/// Follows shells along themselves: on to where ears and backs touch them. A cell is of the shell when it lies in the
/// plane of what is near of the shell, and looks like that.
fn follow(
    grid: &Grid,
    means: &[f32],
    shell: &mut [bool],
    thin: &[bool],
    depth: &[f32],
    cancel: &CancelToken,
) -> Result<(), Cancelled> {
    let passable = |i: usize| thin[i] || depth[i] > 0.0 && depth[i] <= THICKNESS_MM;
    let mut waiting = VecDeque::new();
    let mut queued = vec![false; shell.len()];
    let mut queue_around = |i: usize, shell: &[bool], waiting: &mut VecDeque<usize>| {
        grid.neighbours(i, |next| {
            if !shell[next] && !queued[next] && passable(next) {
                queued[next] = true;
                waiting.push_back(next);
            }
        });
    };
    for i in 0..shell.len() {
        if shell[i] {
            queue_around(i, shell, &mut waiting);
        }
    }
    // What is usual, by a sample of the whole.
    let known: Vec<usize> = (0..shell.len()).filter(|&i| shell[i]).collect();
    let sample = known.iter().step_by(known.len() / 500 + 1);
    let mut usual: Vec<f64> =
        sample.filter_map(|&i| Some(Sheet::near(grid, means, shell, i)?.deviation)).collect();
    usual.sort_by(f64::total_cmp);
    let Some(&usual) = usual.get(usual.len() / 2) else { return Ok(()) };
    let mut visits = 0u32;
    while let Some(i) = waiting.pop_front() {
        visits += 1;
        if visits.is_multiple_of(256) {
            cancel.check()?;
        }
        // At its faces a shell is air in part; below the back, what is beside it is the patient.
        let mut brightest = means[i];
        if thin[i] {
            grid.neighbours(i, |next| brightest = brightest.max(means[next]));
        }
        let holds = |sheet: Sheet| {
            sheet.deviation <= THICKER * usual && brightest > sheet.hu - UNLIKE_HU && sheet.holds(grid, i)
        };
        if Sheet::near(grid, means, shell, i).is_some_and(holds) {
            shell[i] = true;
            queue_around(i, shell, &mut waiting);
        }
    }
    Ok(())
}

/// A piece of a shell: a plane and a thickness.
struct Sheet {
    centre: DVec3,
    normal: DVec3,
    /// Standard deviation of the cells' distances from the plane, in mm.
    deviation: f64,
    /// The usual value of cells in its middle, in HU.
    hu: f32,
}

fn place(grid: &Grid, i: usize) -> DVec3 {
    let cell = grid.cell(i);
    DVec3::from_array([0, 1, 2].map(|axis| cell[axis] as f64 * f64::from(grid.cell_mm[axis])))
}

impl Sheet {
    /// The plane of the shell's cells near a cell, by their covariance; `None` where they are no sheet.
    fn near(grid: &Grid, means: &[f32], shell: &[bool], i: usize) -> Option<Self> {
        let cell = grid.cell(i);
        let range = |axis: usize| {
            let reach = (WINDOW_MM / grid.cell_mm[axis]).round().max(1.0) as usize;
            cell[axis].saturating_sub(reach)..(cell[axis] + reach + 1).min(grid.dims[axis])
        };
        let (mut count, mut sum, mut squares) = (0.0, DVec3::ZERO, DMat3::ZERO);
        // About the cell: small numbers, which squares need.
        let origin = place(grid, i);
        let mut values = Vec::new();
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let j = grid.index([x, y, z]);
                    if shell[j] {
                        let p = place(grid, j) - origin;
                        count += 1.0;
                        values.push(means[j]);
                        sum += p;
                        squares += DMat3::from_cols(p * p.x, p * p.y, p * p.z);
                    }
                }
            }
        }
        if count < LEAST_CELLS {
            return None;
        }
        let mean = sum / count;
        let outer = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
        let (squares, axes) = eigen(squares * (1.0 / count) - outer);
        let deviation = squares[0].max(0.0).sqrt();
        let flat =
            deviation <= f64::from(THICKNESS_MM) / 2.0 && squares[1].max(0.0).sqrt() >= 2.0 * deviation;
        // Those at its faces are air in part.
        let upper = values.len() * 3 / 4;
        let (_, &mut hu, _) = values.select_nth_unstable_by(upper, f32::total_cmp);
        flat.then(|| Self { centre: origin + mean, normal: axes[0], deviation, hu })
    }

    /// Whether a cell lies in it. What is even reaches sqrt(3) standard deviations from its middle.
    fn holds(&self, grid: &Grid, i: usize) -> bool {
        let half_cell = 0.5 * f64::from(grid.cell_mm[0].min(grid.cell_mm[1]));
        let off = (place(grid, i) - self.centre).dot(self.normal).abs();
        off <= 3f64.sqrt() * self.deviation + half_cell
    }
}

/// Eigenvalues, rising, and eigenvectors of a symmetric matrix, by Jacobi's rotations.
fn eigen(symmetric: DMat3) -> ([f64; 3], [DVec3; 3]) {
    let mut m = symmetric.to_cols_array_2d();
    let mut v = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q].abs() < 1e-12 {
                continue;
            }
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut m {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (m[p][k], m[q][k]) = (c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]);
                (v[p][k], v[q][k]) = (c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]);
            }
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&a: &usize, &b: &usize| m[a][a].total_cmp(&m[b][b]));
    (order.map(|k| m[k][k]), order.map(|k| DVec3::from_array(v[k])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_of_a_symmetric_matrix() {
        let m = DMat3::from_cols_array_2d(&[[4.0, 1.0, -2.0], [1.0, 3.0, 0.5], [-2.0, 0.5, 6.0]]);
        let (values, axes) = eigen(m);
        assert!(values[0] <= values[1] && values[1] <= values[2]);
        for (value, axis) in values.into_iter().zip(axes) {
            assert!((m * axis - axis * value).length() < 1e-9, "{value} {axis}");
            assert!((axis.length() - 1.0).abs() < 1e-9);
        }
    }
}
