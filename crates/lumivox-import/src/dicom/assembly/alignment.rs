//! Which series a segmentation was made on, and its labels on the voxels of that series.
//!
//! ReferencedSeriesSequence says it (PS3.3 C.8.20.2), or FrameOfReferenceUID where that is of one series alone. Labels go
//! onto the series' own grid if their pixels are pixels of it: they are moved by whole voxels, never interpolated.

use lumivox_core::{
    Voxels,
    glam::{DAffine3, DVec3},
};

use crate::{
    ImportError, SeriesSummary,
    dicom::{
        assembly::pixels::allocate,
        images::image_file::ImageFile,
        series::{geometry::Grid, stack::Stack, storage},
    },
};

/// Pixels that are one lie nearer than this part of a voxel.
const SAME_VOXEL: f64 = 0.1;

/// The series that a segmentation was made on.
#[derive(Debug)]
pub(crate) struct Alignment {
    /// Its position in the list.
    series: usize,
    /// How labels lie on its grid; `None` if their pixels are not those of the series.
    pub(crate) grid: Option<AlignedGrid>,
}

/// The grid of a series, and where the slices of a segmentation lie on it.
#[derive(Debug)]
pub(crate) struct AlignedGrid {
    patient_from_voxel: DAffine3,
    pub(crate) dims: [usize; 3],
    /// For each slice of labels, the voxel of its first pixel.
    corners: Vec<[usize; 3]>,
}

impl Alignment {
    /// What stack `index` was made on, if it is a segmentation and the other is there.
    pub(crate) fn of(index: usize, stacks: &[Stack], files: &[ImageFile]) -> Option<Self> {
        let own = stacks[index].first(files);
        let segmentation = own.segmentation.as_ref().filter(|segmentation| segmentation.has_places)?;
        let images = || (0..stacks.len()).filter(|&k| stacks[k].first(files).segmentation.is_none());
        let of_series = |k: &usize| {
            let uid = stacks[*k].first(files).series_uid.as_ref();
            uid.is_some() && uid == segmentation.referenced_series.as_ref()
        };
        let in_frame = |k: &usize| {
            let frame = stacks[*k].first(files).frame_of_reference.as_ref();
            frame.is_some() && frame == own.frame_of_reference.as_ref()
        };
        let mut candidates: Vec<usize> = images().filter(of_series).collect();
        if candidates.is_empty() && segmentation.referenced_series.is_none() {
            candidates = images().filter(in_frame).collect();
        }
        let grids = candidates.iter().map(|&k| (k, AlignedGrid::new(&stacks[index], &stacks[k], files)));
        let mut found: Vec<_> = grids.collect();
        let best = found.iter().position(|(_, grid)| grid.is_some()).unwrap_or(0);
        (best < found.len()).then(|| found.swap_remove(best)).map(|(series, grid)| Self { series, grid })
    }

    /// What the report says.
    pub(crate) fn note(&self) -> String {
        let series = self.series + 1;
        match &self.grid {
            Some(_) => format!("made on series {series}; its voxels are those of that series"),
            None => format!("made on series {series}, whose voxels lie elsewhere; kept on a grid of its own"),
        }
    }

    /// Completes what the report says about the segmentation.
    pub(crate) fn describe(&self, summary: &mut SeriesSummary) {
        summary.segments_series = Some(self.series);
        summary.notes.push(self.note());
        let Some(grid) = &self.grid else { return };
        summary.bytes = grid.dims.iter().product::<usize>() as u64 * storage::LABEL_BYTES as u64;
        summary.dims = grid.dims;
        let matrix = grid.patient_from_voxel.matrix3;
        summary.spacing_mm = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::length);
    }
}

impl AlignedGrid {
    fn new(labels: &Stack, series: &Stack, files: &[ImageFile]) -> Option<Self> {
        let (phase, format) = (&series.phases[0], &series.first(files).format);
        let grid = series.grid(files, &phase.places, storage::sample_bytes(files, &phase.slices));
        let depth = grid.sources.as_ref().map_or(phase.places.len(), Vec::len);
        let dims = [format.columns, format.rows, depth];
        let own = &labels.first(files).format;
        let (columns, rows) = (own.columns as f64, own.rows as f64);
        let voxel_from_patient = grid.patient_from_voxel.inverse();
        let plane = &labels.plane;
        let is_near = |a: DVec3, b: DVec3| (a - b).abs().max_element() < SAME_VOXEL;
        // From one end of the picture to the other.
        let across = voxel_from_patient.matrix3 * (plane.row_direction * plane.spacing_mm.x * columns);
        let down = voxel_from_patient.matrix3 * (plane.column_direction * plane.spacing_mm.y * rows);
        if !is_near(across, DVec3::X * columns) || !is_near(down, DVec3::Y * rows) {
            return None;
        }
        let corner = |place: &DVec3| {
            let at = voxel_from_patient.transform_point3(*place);
            let voxel = at.round();
            let last = voxel + DVec3::new(columns - 1.0, rows - 1.0, 0.0);
            let size = DVec3::new(dims[0] as f64, dims[1] as f64, dims[2] as f64);
            let inside = voxel.cmpge(DVec3::ZERO).all() && last.cmplt(size).all();
            (inside && is_near(at, voxel)).then(|| voxel.to_array().map(|n| n as usize))
        };
        let corners = labels.phases[0].places.iter().map(corner).collect::<Option<Vec<_>>>()?;
        Some(Self { patient_from_voxel: grid.patient_from_voxel, dims, corners })
    }

    /// The labels of `file` on the grid, and 0 where there are none.
    ///
    /// # Errors
    /// Where memory does not suffice.
    pub(crate) fn place(&self, labels: &Voxels, file: &ImageFile) -> Result<Voxels, ImportError> {
        let (columns, rows) = (file.format.columns, file.format.rows);
        let Voxels::U16(labels) = labels else { unreachable!("labels have 16 bits") };
        let [width, height, depth] = self.dims;
        let mut out = allocate::<u16>(width * height, depth, file)?;
        for (slice, &[x, y, z]) in labels.chunks_exact(columns * rows).zip(&self.corners) {
            for (row, samples) in slice.chunks_exact(columns).enumerate() {
                let start = (z * height + y + row) * width + x;
                out[start..start + columns].copy_from_slice(samples);
            }
        }
        Ok(Voxels::U16(out))
    }

    /// Which of the grid's slices are damaged, given that of the slices of labels.
    pub(crate) fn damaged(&self, of_labels: &[bool]) -> Vec<bool> {
        let mut damaged = vec![false; self.dims[2]];
        let lost = self.corners.iter().zip(of_labels).filter(|(_, damaged)| **damaged);
        lost.for_each(|(&[.., z], _)| damaged[z] = true);
        damaged
    }

    /// What the labels lie on once they are placed.
    pub(crate) fn as_grid(&self) -> Grid {
        Grid { patient_from_voxel: self.patient_from_voxel, ..Grid::default() }
    }
}
