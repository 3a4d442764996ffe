//! Exact Euclidean distances in mm, one axis after the other.
//!
//! P. F. Felzenszwalb, D. P. Huttenlocher: Distance transforms of sampled functions. Theory of Computing 8 (2012): along
//! a line, the squared distance is the lower envelope of one parabola per site. Here the sites are the faces of voxels
//! instead of their centres, so that what is measured is the distance to a surface, however thick the slices are.

use lumivox_core::{CancelToken, Cancelled, LabelVolume, Volume};
use rayon::prelude::*;

use crate::grid::{Grid, plane_spacing_mm};

/// Columns that are taken out of a slice together.
const COLUMNS: usize = 16;

/// Working memory for lines.
#[derive(Default)]
struct Lines {
    values: Vec<f32>,
    sites: Vec<(f32, f32)>,
    starts: Vec<f32>,
}

impl Lines {
    /// Replaces `line`, squared distances in mm^2 at voxels `mm` apart, by those that also go along the line. What is
    /// beyond `limit` (squared) counts as infinitely far.
    fn pass(&mut self, line: &mut [f32], mm: f32, limit: f32) {
        if line.iter().all(|&value| value == 0.0) {
            return;
        }
        self.sites.clear();
        self.starts.clear();
        let mut push = |at: f32, height: f32| {
            while let Some(&(other, other_height)) = self.sites.last() {
                // Where the two parabolas meet.
                let meet = 0.5 * ((height - other_height) / (at - other) + at + other);
                if meet > *self.starts.last().expect("one for each site") {
                    self.starts.push(meet);
                    self.sites.push((at, height));
                    return;
                }
                self.sites.pop();
                self.starts.pop();
            }
            self.starts.push(f32::NEG_INFINITY);
            self.sites.push((at, height));
        };
        let mut previous = f32::INFINITY;
        for (i, next) in line.iter().copied().chain([f32::INFINITY]).enumerate() {
            let height = previous.min(next);
            // Between two voxels of distance 0, and where both are, no face matters.
            if height < limit && !(previous == 0.0 && next == 0.0) {
                push((i as f32 - 0.5) * mm, height);
            }
            previous = next;
        }
        if self.sites.is_empty() {
            return;
        }
        let mut k = 0;
        for (i, value) in line.iter_mut().enumerate() {
            let at = i as f32 * mm;
            while k + 1 < self.sites.len() && self.starts[k + 1] < at {
                k += 1;
            }
            let (site, height) = self.sites[k];
            *value = value.min((at - site) * (at - site) + height);
        }
    }

    /// [`Self::pass`] along both axes of a slice.
    fn slice(&mut self, slice: &mut [f32], [nx, ny]: [usize; 2], mm: [f32; 2], limit: f32) {
        for row in slice.chunks_exact_mut(nx) {
            self.pass(row, mm[0], limit);
        }
        // Some columns at a time, so that memory is read in rows.
        let mut columns = std::mem::take(&mut self.values);
        columns.resize(COLUMNS * ny, 0.0);
        for first in (0..nx).step_by(COLUMNS) {
            let wide = COLUMNS.min(nx - first);
            for (y, row) in slice.chunks_exact(nx).enumerate() {
                for (k, &value) in row[first..first + wide].iter().enumerate() {
                    columns[k * ny + y] = value;
                }
            }
            for column in columns.chunks_exact_mut(ny).take(wide) {
                self.pass(column, mm[1], limit);
            }
            for (y, row) in slice.chunks_exact_mut(nx).enumerate() {
                for (k, value) in row[first..first + wide].iter_mut().enumerate() {
                    *value = columns[k * ny + y];
                }
            }
        }
        self.values = columns;
    }
}

/// The distance in mm from each cell's centre to the nearest cell of `sites`, as far as `limit_mm`; 0 inside them,
/// infinite beyond the limit.
pub fn distances(
    grid: &Grid,
    sites: &(impl Fn(usize) -> bool + Sync),
    limit_mm: f32,
    cancel: &CancelToken,
) -> Result<Vec<f32>, Cancelled> {
    measure(grid, sites, limit_mm, true, cancel)
}

/// [`distances`] to cells of the same slice.
pub fn distances_in_slices(
    grid: &Grid,
    sites: &(impl Fn(usize) -> bool + Sync),
    limit_mm: f32,
    cancel: &CancelToken,
) -> Result<Vec<f32>, Cancelled> {
    measure(grid, sites, limit_mm, false, cancel)
}

fn measure(
    grid: &Grid,
    sites: &(impl Fn(usize) -> bool + Sync),
    limit_mm: f32,
    across: bool,
    cancel: &CancelToken,
) -> Result<Vec<f32>, Cancelled> {
    let [nx, ny, nz] = grid.dims;
    let limit = limit_mm * limit_mm;
    let slice_len = grid.slice_len();
    let mut squared = vec![f32::INFINITY; grid.len()];
    squared.par_iter_mut().enumerate().for_each(|(i, value)| {
        if sites(i) {
            *value = 0.0;
        }
    });
    cancel.check()?;
    // Along z: steps to the nearest site, as a count.
    for backwards in [false, true] {
        for k in 1..if across { nz } else { 1 } {
            let (z, from) = if backwards { (nz - 1 - k, nz - k) } else { (k, k - 1) };
            let (low, high) = squared.split_at_mut(z.max(from) * slice_len);
            let (to, from) = if backwards {
                (&mut low[z * slice_len..], &high[..slice_len])
            } else {
                (&mut high[..slice_len], &low[from * slice_len..])
            };
            to.iter_mut().zip(from).for_each(|(to, &from)| *to = to.min(from + 1.0));
        }
        cancel.check()?;
    }
    let [mx, my, mz] = grid.cell_mm;
    squared.par_chunks_mut(slice_len).try_for_each_init(Lines::default, |lines, slice| {
        cancel.check()?;
        for value in slice.iter_mut().filter(|value| **value > 0.0) {
            *value = ((*value - 0.5) * mz).powi(2);
        }
        lines.slice(slice, [nx, ny], [mx, my], limit);
        for value in slice.iter_mut() {
            *value = if *value <= limit { value.sqrt() } else { f32::INFINITY };
        }
        Ok(())
    })?;
    Ok(squared)
}

/// The step of [`DepthField`], in mm.
pub const DEPTH_STEP_MM: f32 = 0.25;

/// How deep below the surface of the body every voxel lies.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthField {
    dims: [usize; 3],
    steps: Vec<u8>,
}

impl DepthField {
    /// Voxels along x (fastest), y and z: those of the scan.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Depths in steps of [`DEPTH_STEP_MM`], rounded to the nearest, x fastest, then y, then z; 0 outside the body, 255
    /// from [`Self::MOST_MM`] on.
    pub fn steps(&self) -> &[u8] {
        &self.steps
    }

    /// The largest depth that is told from deeper ones, in mm.
    pub const MOST_MM: f32 = 255.0 * DEPTH_STEP_MM;

    /// The depth of a voxel's centre in mm.
    ///
    /// # Panics
    /// When the index is outside the grid.
    #[inline]
    pub fn mm(&self, [x, y, z]: [usize; 3]) -> f32 {
        let [nx, ny, nz] = self.dims;
        assert!(x < nx && y < ny && z < nz, "voxel {:?} is outside a grid of {:?}", [x, y, z], self.dims);
        f32::from(self.steps[(z * ny + y) * nx + x]) * DEPTH_STEP_MM
    }

    /// The depth below the faces of voxels whose label `is_outside`. Voxels whose label `is_unknown` are neither
    /// inside nor outside: a body that the field of view cuts has no skin there, nor has it at the ends of the scan.
    ///
    /// Exact but for the rounding; in a sheared scan, whose slices are moved by whole voxels for this, to within the
    /// diagonal of a pixel.
    pub(crate) fn new(
        labels: &LabelVolume,
        volume: &Volume,
        is_outside: impl Fn(u8) -> bool + Sync,
        is_inside: impl Fn(u8) -> bool + Sync,
        cancel: &CancelToken,
        step: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, Cancelled> {
        let dims = volume.dims();
        let [nx, ny, nz] = dims;
        let slice_len = nx * ny;
        let [mx, my, mz] = plane_spacing_mm(volume).map(|mm| mm as f32);
        let shifts = shifts(volume);
        let outside: Vec<u8> = (0..=255).map(|label| if is_outside(label) { 0 } else { u8::MAX }).collect();
        let inside: Vec<bool> = (0..=255).map(&is_inside).collect();
        let mut steps = vec![0u8; slice_len * nz];
        steps.par_chunks_mut(slice_len).zip(labels.voxels().par_chunks(slice_len)).try_for_each(
            |(to, from)| {
                cancel.check()?;
                to.iter_mut().zip(from).for_each(|(to, &label)| *to = outside[usize::from(label)]);
                Ok(())
            },
        )?;
        // Along z, in slices: at most 255, which fits beside each voxel.
        for backwards in [false, true] {
            for k in 1..nz {
                cancel.check()?;
                let (z, from) = if backwards { (nz - 1 - k, nz - k) } else { (k, k - 1) };
                let (low, high) = steps.split_at_mut(z.max(from) * slice_len);
                let (to, source) = if backwards {
                    (&mut low[z * slice_len..], &high[..slice_len])
                } else {
                    (&mut high[..slice_len], &low[from * slice_len..])
                };
                let shift = [0, 1].map(|axis| shifts[z][axis] - shifts[from][axis]);
                step_along_z(to, source, [nx, ny], shift);
            }
        }
        step(0.2);
        let limit = Self::MOST_MM * Self::MOST_MM;
        let done = std::sync::atomic::AtomicUsize::new(0);
        steps.par_chunks_mut(slice_len).zip(labels.voxels().par_chunks(slice_len)).try_for_each_init(
            || (Lines::default(), vec![0f32; slice_len]),
            |(lines, squared), (steps, labels)| {
                cancel.check()?;
                for (to, &slices) in squared.iter_mut().zip(steps.iter()) {
                    *to = match slices {
                        0 => 0.0,
                        u8::MAX => f32::INFINITY,
                        _ => ((f32::from(slices) - 0.5) * mz).powi(2),
                    };
                }
                lines.slice(squared, [nx, ny], [mx, my], limit);
                for ((to, &squared), &label) in steps.iter_mut().zip(squared.iter()).zip(labels) {
                    // Whatever touches the surface lies below it.
                    let depth = (squared.sqrt() / DEPTH_STEP_MM + 0.5).clamp(1.0, 255.0) as u8;
                    *to = if inside[usize::from(label)] { depth } else { 0 };
                }
                let finished = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                step(0.2 + 0.8 * finished as f64 / nz as f64);
                Ok(())
            },
        )?;
        Ok(Self { dims, steps })
    }
}

/// By how many voxels along x and y each slice of a sheared scan is off the first, to the nearest whole one.
fn shifts(volume: &Volume) -> Vec<[i64; 2]> {
    let m = volume.patient_from_voxel().matrix3;
    let slant = [m.x_axis, m.y_axis].map(|axis| m.z_axis.dot(axis) / axis.length_squared());
    (0..volume.dims()[2]).map(|z| slant.map(|by| (by * z as f64).round() as i64)).collect()
}

/// One step of the pass along z: a voxel is a slice further than the one beside it in the slice before.
fn step_along_z(to: &mut [u8], from: &[u8], [nx, ny]: [usize; 2], [dx, dy]: [i64; 2]) {
    if [dx, dy] == [0, 0] {
        to.iter_mut().zip(from).for_each(|(to, &from)| *to = (*to).min(from.saturating_add(1)));
        return;
    }
    for y in 0..ny as i64 {
        let (source, first, end) = (y + dy, (-dx).max(0), (nx as i64 - dx).min(nx as i64));
        if !(0..ny as i64).contains(&source) || first >= end {
            continue;
        }
        let to = &mut to[y as usize * nx..][first as usize..end as usize];
        let from = &from[source as usize * nx..][(first + dx) as usize..(end + dx) as usize];
        to.iter_mut().zip(from).for_each(|(to, &from)| *to = (*to).min(from.saturating_add(1)));
    }
}

#[cfg(test)]
mod tests {
    use lumivox_core::{
        Modality, Voxels,
        glam::{DAffine3, DMat3, DVec3},
    };

    use super::*;
    use crate::class::Class;

    fn hash(i: usize) -> u64 {
        let mut x = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x ^ (x >> 29)
    }

    /// The distance from a centre to the nearest box of a site, by looking at them all.
    fn brute(sites: &[DVec3], at: DVec3, size: DVec3) -> f64 {
        let to_box = |&site: &DVec3| ((site - at).abs() - size / 2.0).max(DVec3::ZERO).length();
        sites.iter().map(to_box).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn distances_are_those_to_the_nearest_box() {
        let grid = Grid {
            dims: [17, 13, 9],
            cell_mm: [1.5, 0.7, 4.0],
            along: [0.0; 2],
            axes: [0, 1, 2],
            factors: [1; 3],
        };
        let size = DVec3::new(1.5, 0.7f32.into(), 4.0);
        let place = |i: usize| DVec3::from_array(grid.cell(i).map(|at| at as f64)) * size;
        for one_in in [3, 40, 900] {
            let site = |i: usize| hash(i).is_multiple_of(one_in);
            let sites: Vec<DVec3> = (0..grid.len()).filter(|&i| site(i)).map(place).collect();
            let limit = 9.0;
            let found = distances(&grid, &site, limit, &CancelToken::new()).unwrap();
            let flat = distances_in_slices(&grid, &site, limit, &CancelToken::new()).unwrap();
            for i in 0..grid.len() {
                let near: Vec<DVec3> = sites.iter().copied().filter(|site| site.z == place(i).z).collect();
                for (found, sites) in [(found[i], &sites), (flat[i], &near)] {
                    let truth = if site(i) { 0.0 } else { brute(sites, place(i), size) };
                    if truth < f64::from(limit) - 1e-3 {
                        assert!((f64::from(found) - truth).abs() < 1e-3, "{i}: {found} is not {truth}");
                    } else {
                        assert!(f64::from(found) >= f64::from(limit) - 1e-2, "{i}: {found}, not {truth}");
                    }
                }
            }
        }
    }

    /// Labels with a few cavities and two unknown columns, in a grid that the matrix places.
    fn depths(dims: [usize; 3], matrix: DMat3, label: impl Fn(usize) -> u8) -> (DepthField, Vec<u8>) {
        let count = dims.iter().product();
        let place = DAffine3::from_mat3(matrix);
        let volume = Volume::new(dims, Voxels::U8(vec![0; count]), [1.0, 0.0], place, Modality::Ct).unwrap();
        let voxels: Vec<u8> = (0..count).map(label).collect();
        let table = Class::ALL.map(Class::label).to_vec();
        let labels = LabelVolume::new(dims, voxels.clone(), place, table).unwrap();
        let air = Class::Air.value();
        let depth = DepthField::new(
            &labels,
            &volume,
            |label| label == air,
            |label| label == Class::Body.value(),
            &CancelToken::new(),
            &|_| (),
        );
        (depth.unwrap(), voxels)
    }

    #[test]
    fn depth_is_exact_to_its_step_and_knows_no_surface_at_what_was_not_measured() {
        let dims = [20, 16, 7];
        let size = DVec3::new(0.8, 0.8, 5.0);
        let label = |i: usize| match hash(i) % 50 {
            0 => Class::Air.value(),
            _ if i % 20 < 2 => 0,
            _ => Class::Body.value(),
        };
        let (depth, labels) = depths(dims, DMat3::from_diagonal(size), label);
        let place = |i: usize| DVec3::new((i % 20) as f64, (i / 20 % 16) as f64, (i / 320) as f64) * size;
        let sites: Vec<DVec3> =
            (0..labels.len()).filter(|&i| labels[i] == Class::Air.value()).map(place).collect();
        for (i, &label) in labels.iter().enumerate() {
            let found = f64::from(depth.mm([i % 20, i / 20 % 16, i / 320]));
            if label == Class::Body.value() {
                let truth = brute(&sites, place(i), size).max(f64::from(DEPTH_STEP_MM));
                assert!(
                    (found - truth).abs() <= f64::from(DEPTH_STEP_MM) / 2.0 + 1e-4,
                    "{i}: {found}, {truth}"
                );
            } else {
                assert_eq!(found, 0.0);
            }
        }
    }

    #[test]
    fn depth_in_a_sheared_scan_is_off_by_a_pixel_at_most() {
        let dims = [12, 40, 20];
        let (sine, cosine) = 20f64.to_radians().sin_cos();
        let matrix = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cosine, -sine), DVec3::new(0.0, 0.0, 3.0));
        // Air in front of a plane of the patient.
        let place = |i: usize| matrix * DVec3::new((i % 12) as f64, (i / 12 % 40) as f64, (i / 480) as f64);
        let label = |i: usize| if place(i).y < 14.0 { Class::Air.value() } else { Class::Body.value() };
        let (depth, labels) = depths(dims, matrix, label);
        for (i, _) in labels.iter().enumerate().filter(|&(_, &label)| label == Class::Body.value()) {
            // What a neighbour of another slice would be nearest to may lie outside of the scan.
            let at = [i % 12, i / 12 % 40, i / 480];
            let truth = place(i).y - 14.0;
            if truth < 15.0 && (4..16).contains(&at[2]) {
                let found = f64::from(depth.mm(at));
                assert!((found - truth).abs() < 2f64.sqrt() + 0.2, "{at:?}: {found}, {truth}");
            }
        }
    }
}
