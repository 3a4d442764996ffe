//! From the slices of a phase to the voxels of a volume: decoded, without the damaged ones or with their places empty,
//! on an even grid whose gaps are filled or left.

use lumivox_core::{
    CancelToken, Cancelled, Progress, Voxels,
    glam::{DAffine3, DVec3},
};

use crate::{
    ImportError,
    dicom::{
        assembly::{
            alignment::Alignment,
            convert, label_pixels,
            pixels::{self, Failure},
            resample,
        },
        images::image_file::ImageFile,
        series::{
            gaps::{self, Gaps, GridSource},
            geometry::Grid,
            stack::{Phase, Stack},
        },
    },
};

/// Decoded slices, one after the other.
#[derive(Debug)]
pub(crate) struct Slices {
    voxels: Voxels,
    /// Slope and intercept.
    rescale: [f64; 2],
    /// Voxels of a slice along x and y.
    size: [usize; 2],
    /// The place in the patient of each slice.
    places: Vec<DVec3>,
    /// Which of them hold nothing measured.
    damaged: Vec<bool>,
}

impl Slices {
    /// Decodes `phase` of `stack`; also the slices that could not be.
    ///
    /// # Errors
    /// When no slice can be decoded, where memory does not suffice, and on cancel.
    pub(crate) fn decode(
        files: &[ImageFile],
        stack: &Stack,
        phase: &Phase,
        notes: &mut Vec<String>,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<(Self, Vec<Failure>), ImportError> {
        let first = stack.first(files);
        let decoded = if first.segmentation.is_some() {
            let (decoded, more) = label_pixels::decode(files, stack, progress, cancel)?;
            notes.extend(more);
            decoded
        } else {
            pixels::decode(files, &phase.slices, progress, cancel)?
        };
        let mut damaged = vec![false; phase.places.len()];
        decoded.failed.iter().for_each(|(slice, _)| damaged[*slice] = true);
        if !damaged.contains(&false) {
            let (slice, error) = decoded.failed.into_iter().next().expect("every slice failed");
            return Err(files[phase.slices[slice].file].truncation().unwrap_or(error));
        }
        let slices = Self {
            voxels: decoded.voxels,
            rescale: decoded.rescale,
            size: [first.format.columns, first.format.rows],
            places: phase.places.clone(),
            damaged,
        };
        Ok((slices, decoded.failed))
    }

    /// Those that are not damaged: the others count as missing.
    pub(crate) fn without_damaged(self, notes: &mut Vec<String>) -> Self {
        let total = self.damaged.len();
        let keep: Vec<bool> = self.damaged.iter().map(|damaged| !damaged).collect();
        let kept = keep.iter().filter(|keep| **keep).count();
        if kept == total {
            return self;
        }
        notes.push(format!("{} of {total} slices could not be decoded", total - kept));
        let places = self.places.iter().zip(&keep).filter(|(_, keep)| **keep).map(|(place, _)| *place);
        Self {
            voxels: resample::keep_slices(self.voxels, self.size[0] * self.size[1], &keep),
            places: places.collect(),
            damaged: vec![false; kept],
            ..self
        }
    }

    /// The even grid that they lie on, of whose places some may have no slice. Labels that are aligned with a series are
    /// put on its grid.
    ///
    /// # Errors
    /// Where memory does not suffice.
    pub(crate) fn on_grid(
        self,
        files: &[ImageFile],
        stack: &Stack,
        alignment: Option<&Alignment>,
        notes: &mut Vec<String>,
    ) -> Result<OnGrid, ImportError> {
        let first = stack.first(files);
        let (is_hounsfield, is_labels) = (first.is_hounsfield(), first.segmentation.is_some());
        notes.extend(alignment.map(Alignment::note));
        let Some(aligned) = alignment.and_then(|alignment| alignment.grid.as_ref()) else {
            let bytes = self.voxels.bytes_per_sample();
            let grid = stack.grid(files, &self.places, bytes);
            if let Some(sources) = &grid.sources {
                // Nothing else tells in words that memory does not suffice for what is filled in.
                drop(pixels::allocate::<u8>(self.size[0] * self.size[1] * bytes, sources.len(), first)?);
            }
            return Ok(OnGrid { slices: self, grid, is_hounsfield, is_labels });
        };
        let slices = Self {
            voxels: aligned.place(&self.voxels, first)?,
            size: [aligned.dims[0], aligned.dims[1]],
            damaged: aligned.damaged(&self.damaged),
            ..self
        };
        Ok(OnGrid { slices, grid: aligned.as_grid(), is_hounsfield, is_labels })
    }
}

/// Slices, and the even grid that they lie on.
#[derive(Debug)]
pub(crate) struct OnGrid {
    slices: Slices,
    grid: Grid,
    is_hounsfield: bool,
    is_labels: bool,
}

impl OnGrid {
    /// Where the slices of the grid come from.
    pub(crate) fn sources(&mut self, gaps: Gaps, notes: &mut Vec<String>) -> Vec<GridSource> {
        let left = self.grid.settle(gaps);
        let sources = gaps::sources(&self.grid, &self.slices.damaged, left || self.is_labels);
        notes.extend(gaps::note(&sources, &self.slices.damaged, &self.grid, self.is_labels));
        notes.append(&mut self.grid.notes);
        sources
    }

    /// The slices of the grid that hold nothing measured. Where one has no segment, labels are measured: there is none.
    pub(crate) fn empty_slices(&self, sources: &[GridSource]) -> Vec<usize> {
        let is_lost = |k| gaps::is_lost(k, &self.slices.damaged, &self.grid, true);
        let is_empty = |k: &usize| sources[*k].is_none() && (!self.is_labels || is_lost(*k));
        (0..sources.len()).filter(is_empty).collect()
    }

    /// Voxels along x, y and z.
    pub(crate) fn dims(&self) -> [usize; 3] {
        let depth = self.grid.sources.as_ref().map_or(self.slices.damaged.len(), Vec::len);
        [self.slices.size[0], self.slices.size[1], depth]
    }

    /// LPS millimetres from voxel indices.
    pub(crate) fn patient_from_voxel(&self) -> DAffine3 {
        self.grid.patient_from_voxel
    }

    /// All voxels of the grid, with slope and intercept.
    ///
    /// # Errors
    /// On cancel.
    pub(crate) fn filled(
        self,
        sources: &[GridSource],
        cancel: &CancelToken,
    ) -> Result<(Voxels, [f64; 2]), Cancelled> {
        let is_even = self.grid.sources.is_none();
        // Lost labels are 0 already.
        let nothing_to_clear = self.is_labels || !self.slices.damaged.contains(&true);
        if is_even && nothing_to_clear {
            return Ok((self.slices.voxels, self.slices.rescale));
        }
        let empty = self.empty_sample();
        let Slices { voxels, rescale, size, damaged, .. } = self.slices;
        let slice_len = size[0] * size[1];
        let voxels = if is_even {
            resample::clear(voxels, slice_len, &damaged, empty)
        } else {
            resample::resample(&voxels, slice_len, sources, empty, cancel)?
        };
        Ok((voxels, rescale))
    }

    /// The sample of places where nothing was measured: air in a CT, no segment in labels, else of the lowest value.
    fn empty_sample(&self) -> f64 {
        let Slices { voxels, rescale: [slope, intercept], size, damaged, .. } = &self.slices;
        match () {
            () if self.is_labels => 0.0,
            () if self.is_hounsfield => (pixels::AIR_HU - intercept) / slope,
            () => resample::measured_range(voxels, size[0] * size[1], damaged)
                .map_or(0.0, |range| convert::of_lowest_value(range, *slope)),
        }
    }
}
