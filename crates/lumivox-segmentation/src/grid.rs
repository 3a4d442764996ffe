//! A coarse grid over a scan, about 2 mm, on which everything global is decided: whose neighbourhoods are cheap, and
//! whose cells are means of voxels, so that the noise of a low dose is gone.

use lumivox_core::{CancelToken, Cancelled, Volume, Voxels, glam::DVec3};
use rayon::prelude::*;

/// Edge length that cells come close to, in mm.
const CELL_MM: f64 = 2.0;

/// Most cells: a wide field of view of many slices is decided on coarser ones.
const MOST_CELLS: f64 = 16e6;

/// Values of CT are kept between these, in HU: padding is air, and metal is not worth more than bone.
pub const HU_RANGE: [f64; 2] = [-1024.0, 2000.0];

/// A box of cells. Its z runs along the patient wherever the scan's axes allow, so that its slices are axial.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Cells along x (fastest), y and z.
    pub dims: [usize; 3],
    /// Size of a cell, in mm; slices of a tilted gantry lie as far apart as their planes do.
    pub cell_mm: [f32; 3],
    /// How many cells along x and y the patient's axis goes with each slice: 0 but where the field of view was turned.
    pub along: [f32; 2],
    /// The axis of the scan along each of the grid.
    pub axes: [usize; 3],
    /// Voxels of a cell, along the scan's axes.
    pub factors: [usize; 3],
}

impl Grid {
    /// The grid for a scan.
    pub fn new(volume: &Volume) -> Self {
        let spacing = plane_spacing_mm(volume);
        let directions = volume.directions();
        // Of the scan's axes the one closest to the patient's: slices across it are axial.
        let along = |axis: usize| directions.col(axis).z.abs();
        let z = (0..3).rev().fold(2, |best, axis| if along(axis) > along(best) + 1e-6 { axis } else { best });
        let axes = match z {
            0 => [1, 2, 0],
            1 => [0, 2, 1],
            _ => [0, 1, 2],
        };
        let patient_z = volume.patient_from_voxel().matrix3.inverse() * DVec3::Z;
        let mut cell_mm = CELL_MM;
        loop {
            let factors = [0, 1, 2].map(|axis| ((cell_mm / spacing[axis]).round() as usize).max(1));
            let cells = [0, 1, 2].map(|axis| volume.dims()[axis].div_ceil(factors[axis]));
            if cells.iter().map(|&n| n as f64).product::<f64>() <= MOST_CELLS {
                let step = axes.map(|axis| patient_z[axis] / factors[axis] as f64);
                let slope = |axis: usize| (step[axis] / step[2]) as f32;
                let usable = |slope: f32| if slope.is_finite() && slope.abs() < 4.0 { slope } else { 0.0 };
                return Self {
                    along: [usable(slope(0)), usable(slope(1))],
                    dims: axes.map(|axis| cells[axis]),
                    cell_mm: axes.map(|axis| (spacing[axis] * factors[axis] as f64) as f32),
                    axes,
                    factors,
                };
            }
            cell_mm *= 1.25;
        }
    }

    /// The number of cells.
    pub fn len(&self) -> usize {
        self.dims.iter().product()
    }

    /// The volume of a cell, in ml.
    pub fn cell_ml(&self) -> f64 {
        self.cell_mm.iter().map(|&mm| f64::from(mm)).product::<f64>() / 1000.0
    }

    /// Cells of one slice.
    pub fn slice_len(&self) -> usize {
        self.dims[0] * self.dims[1]
    }

    /// The place of a cell in lists.
    #[inline]
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.dims[1] + y) * self.dims[0] + x
    }

    /// The cell at a place in lists.
    #[inline]
    pub fn cell(&self, index: usize) -> [usize; 3] {
        // Shorter numbers are divided in half the time, and there are fewer cells than that.
        let (index, [nx, ny, _]) = (index as u32, self.dims.map(|n| n as u32));
        let (row, x) = (index / nx, index % nx);
        [x, row % ny, row / ny].map(|at| at as usize)
    }

    /// For each of the scan's axes, how far lists of cells go on with one more cell along it.
    pub fn strides_of_scan(&self) -> [usize; 3] {
        let strides = [1, self.dims[0], self.slice_len()];
        let mut of_scan = [0; 3];
        for (axis, stride) in self.axes.into_iter().zip(strides) {
            of_scan[axis] = stride;
        }
        of_scan
    }

    /// Calls `visit` with the places of the six cells that share a face with one.
    #[inline]
    pub fn neighbours(&self, index: usize, mut visit: impl FnMut(usize)) {
        self.neighbours_along(index, |_, next| visit(next));
    }

    /// The same, with the axis along which each lies.
    #[inline]
    pub fn neighbours_along(&self, index: usize, mut visit: impl FnMut(usize, usize)) {
        let cell = self.cell(index);
        let strides = [1, self.dims[0], self.slice_len()];
        for axis in 0..3 {
            if cell[axis] > 0 {
                visit(axis, index - strides[axis]);
            }
            if cell[axis] + 1 < self.dims[axis] {
                visit(axis, index + strides[axis]);
            }
        }
    }
}

/// Distances between neighbouring planes of voxels, in mm: less than between their centres where the grid is sheared.
pub fn plane_spacing_mm(volume: &Volume) -> [f64; 3] {
    let spacing = volume.spacing_mm();
    let m = volume.patient_from_voxel().matrix3;
    let normal: DVec3 = m.x_axis.cross(m.y_axis);
    [spacing.x, spacing.y, m.z_axis.dot(normal).abs() / normal.length()]
}

/// The physical values of voxels, read without a branch for each on how they are stored.
#[derive(Clone, Copy)]
pub struct Values<'a> {
    voxels: &'a Voxels,
    slope: f32,
    intercept: f32,
}

impl<'a> Values<'a> {
    /// Those of a scan.
    pub fn new(volume: &'a Volume) -> Self {
        Self { voxels: volume.voxels(), slope: volume.slope() as f32, intercept: volume.intercept() as f32 }
    }

    /// Copies a run of values, one after the other in memory.
    pub fn read(&self, first: usize, into: &mut [f32]) {
        let range = first..first + into.len();
        let (slope, intercept) = (self.slope, self.intercept);
        let rescale = |stored: f32| stored * slope + intercept;
        match self.voxels {
            Voxels::U8(v) => into.iter_mut().zip(&v[range]).for_each(|(to, &s)| *to = rescale(f32::from(s))),
            Voxels::U16(v) => into.iter_mut().zip(&v[range]).for_each(|(to, &s)| *to = rescale(f32::from(s))),
            Voxels::F32(v) => into.iter_mut().zip(&v[range]).for_each(|(to, &s)| *to = rescale(s)),
        }
    }
}

/// The mean value of each cell, of values clamped to `range`.
///
/// # Errors
/// [`Cancelled`].
pub fn means(
    volume: &Volume,
    grid: &Grid,
    range: [f64; 2],
    cancel: &CancelToken,
    step: &(dyn Fn(f64) + Sync),
) -> Result<Vec<f32>, Cancelled> {
    let [nx, ny, nz] = volume.dims();
    let [fx, fy, fz] = grid.factors;
    let [cx, cy, cz] = [nx.div_ceil(fx), ny.div_ceil(fy), nz.div_ceil(fz)];
    let [low, high] = range.map(|value| value as f32);
    let values = Values::new(volume);
    let strides = grid.strides_of_scan();
    let done = std::sync::atomic::AtomicUsize::new(0);
    // In the order of the scan's own axes first: that is how its memory is read once.
    let slabs: Vec<Vec<f32>> = (0..cz)
        .into_par_iter()
        .map(|z| {
            cancel.check()?;
            let mut sums = vec![0f32; cx * cy];
            let mut row = vec![0f32; nx];
            for slice in z * fz..((z + 1) * fz).min(nz) {
                for y in 0..ny {
                    values.read((slice * ny + y) * nx, &mut row);
                    let sums = &mut sums[y / fy * cx..][..cx];
                    for (sum, cell) in sums.iter_mut().zip(row.chunks(fx)) {
                        *sum += cell.iter().map(|value| value.clamp(low, high)).sum::<f32>();
                    }
                }
            }
            let deep = fz.min(nz - z * fz);
            for (at, sum) in sums.iter_mut().enumerate() {
                let (x, y) = (at % cx, at / cx);
                *sum /= (deep * fy.min(ny - y * fy) * fx.min(nx - x * fx)) as f32;
            }
            let finished = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            step(finished as f64 / cz as f64);
            Ok(sums)
        })
        .collect::<Result<_, Cancelled>>()?;
    if grid.axes == [0, 1, 2] {
        return Ok(slabs.concat());
    }
    let mut means = vec![0.0; grid.len()];
    for (z, slab) in slabs.iter().enumerate() {
        for (at, &mean) in slab.iter().enumerate() {
            means[at % cx * strides[0] + at / cx * strides[1] + z * strides[2]] = mean;
        }
    }
    Ok(means)
}
