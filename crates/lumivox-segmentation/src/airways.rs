//! Trachea and bronchi: grown from the trachea at full resolution, with a threshold that rises until the growth leaks
//! into a lung.
//!
//! K. Mori et al.: Automated extraction and visualization of bronchus from 3D CT images of lung. CVRMed 1995: the last
//! threshold before the grown volume explodes is the right one.

use lumivox_core::{CancelToken, Cancelled, Volume};
use rayon::prelude::*;

use crate::{
    components::Components,
    grid::{Grid, Values},
};

/// Values of the trachea's cells are below this, in HU.
const TRACHEA_HU: f32 = -920.0;

/// Cross-sections of a trachea, cut across or slanted, in mm^2.
const SECTION_MM2: std::ops::Range<f64> = 30.0..900.0;

/// A trachea is followed from slice to slice at least so far, in mm.
const LEAST_LENGTH_MM: f32 = 16.0;

/// Thresholds of the growth, in HU.
const FIRST_HU: f32 = -960.0;
const LAST_HU: f32 = -840.0;
const STEP_HU: f32 = 10.0;

/// What a growth may come to, in mm^3: of more than `MOST` it leaked for certain, of less than `LEAST` it is no trachea.
const MOST_MM3: f64 = 200_000.0;
const LEAST_MM3: f64 = 1_500.0;

/// A leak: growth by so much at one step of the threshold, as a factor and in mm^3.
const LEAK_FACTOR: f64 = 1.35;
const LEAK_MM3: f64 = 4_000.0;

/// Tracheas that are tried, the longest first.
const TRIES: usize = 6;

/// A set of voxels.
pub struct VoxelSet {
    bits: Vec<u64>,
    members: Vec<u32>,
}

impl VoxelSet {
    fn new(voxels: usize) -> Self {
        Self { bits: vec![0; voxels.div_ceil(64)], members: Vec::new() }
    }

    /// Whether a voxel is in it.
    #[inline]
    pub fn contains(&self, voxel: usize) -> bool {
        self.bits[voxel / 64] >> (voxel % 64) & 1 != 0
    }

    fn insert(&mut self, voxel: usize) -> bool {
        let new = !self.contains(voxel);
        self.bits[voxel / 64] |= 1 << (voxel % 64);
        new
    }

    /// Its voxels.
    pub fn members(&self) -> &[u32] {
        &self.members
    }
}

/// Finds the airways among the cells that are `hollow`s of the body, of which `lungs` says which are lungs; `None` when
/// there is no trachea that leads to a lung.
pub fn airways(
    volume: &Volume,
    grid: &Grid,
    means: &[f32],
    hollow: &(impl Fn(usize) -> bool + Sync),
    lungs: &[bool],
    cancel: &CancelToken,
) -> Result<Option<VoxelSet>, Cancelled> {
    if volume.voxel_count() > u32::MAX as usize || !lungs.contains(&true) {
        return Ok(None);
    }
    let mut best: Option<VoxelSet> = None;
    for seeds in tracheas(grid, means, hollow, lungs, cancel)? {
        if let Some(found) = grow(volume, grid, hollow, lungs, &seeds, cancel)?
            && best.as_ref().is_none_or(|best| found.members.len() > best.members.len())
        {
            best = Some(found);
        }
    }
    Ok(best)
}

/// Tubes along the patient: round dark sections of axial slices, one above the other. The longest first, as lists of
/// cells.
fn tracheas(
    grid: &Grid,
    means: &[f32],
    hollow: &(impl Fn(usize) -> bool + Sync),
    lungs: &[bool],
    cancel: &CancelToken,
) -> Result<Vec<Vec<usize>>, Cancelled> {
    let slice_len = grid.slice_len();
    let cell_mm2 = f64::from(grid.cell_mm[0] * grid.cell_mm[1]);
    // Sections: components of a slice are those of a grid of one slice.
    let flat = Grid { dims: [grid.dims[0], grid.dims[1], 1], ..grid.clone() };
    let mut tubes: Vec<(Vec<usize>, [f32; 2], usize)> = Vec::new();
    let has_lung: Vec<bool> = lungs.chunks_exact(slice_len).map(|slice| slice.contains(&true)).collect();
    let mut finished: Vec<Vec<usize>> = Vec::new();
    let sections_of = |z: usize| {
        let first = z * slice_len;
        let dark = |i: usize| hollow(first + i) && means[first + i] < TRACHEA_HU;
        let sections = Components::new(&flat, dark, cancel)?;
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); sections.sizes.len()];
        for (i, &section) in sections.of.iter().enumerate().filter(|&(_, &section)| section != 0) {
            members[section as usize].push(i);
        }
        members.retain(|members| SECTION_MM2.contains(&(members.len() as f64 * cell_mm2)));
        Ok(members)
    };
    let sections: Vec<Vec<Vec<usize>>> =
        (0..grid.dims[2]).into_par_iter().map(sections_of).collect::<Result<_, Cancelled>>()?;
    for (z, sections) in sections.into_iter().enumerate().rev() {
        let mut next: Vec<(Vec<usize>, [f32; 2], usize)> = Vec::new();
        for section in sections {
            let count = section.len() as f32;
            let sum = section.iter().fold([0.0; 2], |sum: [f32; 2], &i| {
                [sum[0] + (i % grid.dims[0]) as f32, sum[1] + (i / grid.dims[0]) as f32]
            });
            let at = [sum[0] / count * grid.cell_mm[0], sum[1] / count * grid.cell_mm[1]];
            let (mut low, mut high) = ([f32::INFINITY; 2], [0f32; 2]);
            for &i in &section {
                let place = [(i % grid.dims[0]) as f32, (i / grid.dims[0]) as f32];
                for axis in 0..2 {
                    low[axis] = low[axis].min(place[axis]);
                    high[axis] = high[axis].max(place[axis] + 1.0);
                }
            }
            let box_cells = (high[0] - low[0]) * (high[1] - low[1]);
            if count < 0.5 * box_cells {
                continue;
            }
            let section: Vec<usize> = section.into_iter().map(|i| z * slice_len + i).collect();
            let reach = 4.0 + grid.cell_mm[2];
            let before =
                tubes.iter().position(|(_, there, _)| (there[0] - at[0]).hypot(there[1] - at[1]) < reach);
            let (mut cells, _, length) = before.map_or_else(Default::default, |k| tubes.swap_remove(k));
            cells.extend(section);
            next.push((cells, at, length + 1));
        }
        let long = |length: usize| length as f32 * grid.cell_mm[2] >= LEAST_LENGTH_MM;
        finished.extend(tubes.drain(..).filter(|tube| long(tube.2)).map(|tube| tube.0));
        tubes = next;
        if z == 0 {
            finished.extend(tubes.drain(..).filter(|tube| long(tube.2)).map(|tube| tube.0));
        }
    }
    if !has_lung.contains(&true) {
        return Ok(Vec::new());
    }
    finished.sort_by_key(|cells| (std::cmp::Reverse(cells.len()), cells[0]));
    finished.truncate(TRIES);
    Ok(finished)
}

/// The mean of the voxels around one, so that noise neither blocks nor leaks.
struct Around<'a> {
    volume: &'a Volume,
    values: Values<'a>,
    reach: [usize; 3],
}

impl Around<'_> {
    fn mean(&self, [x, y, z]: [usize; 3]) -> f32 {
        let [nx, ny, nz] = self.volume.dims();
        let range = |at: usize, reach: usize, n: usize| at.saturating_sub(reach)..(at + reach + 1).min(n);
        let xs = range(x, self.reach[0], nx);
        let (mut sum, mut count) = (0.0, 0);
        let mut row = [0f32; 3];
        let row = &mut row[..xs.len()];
        for z in range(z, self.reach[2], nz) {
            for y in range(y, self.reach[1], ny) {
                self.values.read((z * ny + y) * nx + xs.start, row);
                sum += row.iter().sum::<f32>();
                count += row.len();
            }
        }
        sum / count as f32
    }
}

/// Grows from the voxels of the cells `seeds`.
fn grow(
    volume: &Volume,
    grid: &Grid,
    hollow: &impl Fn(usize) -> bool,
    lungs: &[bool],
    seeds: &[usize],
    cancel: &CancelToken,
) -> Result<Option<VoxelSet>, Cancelled> {
    let dims = volume.dims();
    let [nx, ny, nz] = dims;
    let spacing = volume.spacing_mm().to_array();
    let around =
        Around { volume, values: Values::new(volume), reach: spacing.map(|mm| usize::from(mm <= 1.6)) };
    let strides = grid.strides_of_scan();
    let cell_of = |voxel: [usize; 3]| {
        (0..3).map(|axis| voxel[axis] / grid.factors[axis] * strides[axis]).sum::<usize>()
    };
    let voxel_mm3 = volume.patient_from_voxel().matrix3.determinant().abs();
    let place = |voxel: usize| [voxel % nx, voxel / nx % ny, voxel / nx / ny];

    let mut seen = VoxelSet::new(volume.voxel_count());
    let mut waiting: Vec<(u32, f32)> = Vec::new();
    for &cell in seeds {
        // The voxel in the cell's middle.
        let [x, y, z] = grid.cell(cell);
        let mut voxel = [0; 3];
        for (axis, at) in grid.axes.into_iter().zip([x, y, z]) {
            voxel[axis] = (at * grid.factors[axis] + grid.factors[axis] / 2).min(dims[axis] - 1);
        }
        let index = (voxel[2] * ny + voxel[1]) * nx + voxel[0];
        if seen.insert(index) {
            waiting.push((index as u32, around.mean(voxel)));
        }
    }
    let mut threshold = FIRST_HU;
    let mut stack: Vec<u32> = Vec::new();
    let mut later: Vec<(u32, f32)> = Vec::new();
    while threshold <= LAST_HU {
        later.clear();
        for (voxel, mean) in waiting.drain(..) {
            if mean < threshold {
                stack.push(voxel);
            } else {
                later.push((voxel, mean));
            }
        }
        let before = seen.members.len();
        while let Some(voxel) = stack.pop() {
            seen.members.push(voxel);
            if seen.members.len().is_multiple_of(4096) {
                cancel.check()?;
            }
            if seen.members.len() as f64 * voxel_mm3 > MOST_MM3 {
                break;
            }
            let at = place(voxel as usize);
            let steps = [1, nx, nx * ny];
            for axis in 0..3 {
                for up in [false, true] {
                    let inside = if up { at[axis] + 1 < [nx, ny, nz][axis] } else { at[axis] > 0 };
                    if !inside {
                        continue;
                    }
                    let mut next_at = at;
                    next_at[axis] = if up { at[axis] + 1 } else { at[axis] - 1 };
                    let next = if up { voxel as usize + steps[axis] } else { voxel as usize - steps[axis] };
                    if !hollow(cell_of(next_at)) || !seen.insert(next) {
                        continue;
                    }
                    let mean = around.mean(next_at);
                    if mean < threshold {
                        stack.push(next as u32);
                    } else {
                        later.push((next as u32, mean));
                    }
                }
            }
        }
        stack.clear();
        let (old, new) = (before as f64 * voxel_mm3, seen.members.len() as f64 * voxel_mm3);
        let leaked = new > MOST_MM3 || before > 0 && new > old * LEAK_FACTOR && new - old > LEAK_MM3;
        if leaked && before as f64 * voxel_mm3 >= LEAST_MM3 {
            seen.members.truncate(before);
            break;
        }
        if new > MOST_MM3 {
            return Ok(None);
        }
        std::mem::swap(&mut waiting, &mut later);
        threshold += STEP_HU;
    }
    if (seen.members.len() as f64 * voxel_mm3) < LEAST_MM3 {
        return Ok(None);
    }
    // What leads to no lung is another tube.
    let leads = seen.members.iter().any(|&voxel| {
        let cell = cell_of(place(voxel as usize));
        let mut lung = lungs[cell];
        grid.neighbours(cell, |next| lung |= lungs[next]);
        lung
    });
    if !leads {
        return Ok(None);
    }
    seen.bits.fill(0);
    seen.members.sort_unstable();
    for k in 0..seen.members.len() {
        let voxel = seen.members[k] as usize;
        seen.bits[voxel / 64] |= 1 << (voxel % 64);
    }
    Ok(Some(seen))
}
