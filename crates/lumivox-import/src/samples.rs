//! Where the samples of a file's grid come from: one after the other out of files, or slice by slice out of pictures and
//! chunks.

use std::{
    fmt,
    ops::Range,
    path::{Path, PathBuf},
};

use lumivox_core::{CancelToken, Progress, WorkStage};

use crate::{
    error::ImportError,
    luminance,
    payload::{Payload, too_many_voxels},
    sample::{Decoded, SampleType, VoxelBuilder},
};

/// A grid's slices, decoded one by one.
pub(crate) trait Planes: Send + Sync {
    /// The samples of slice `index`, x fastest, little endian; slices of later phases follow those of the first.
    ///
    /// # Errors
    /// [`ImportError`] names the file, and what is wrong with it.
    fn plane(&self, index: usize, cancel: &CancelToken) -> Result<Vec<u8>, ImportError>;
}

/// Where samples come from.
pub(crate) enum Samples {
    Files(Payload),
    Planes {
        planes: Box<dyn Planes>,
        sample: SampleType,
        /// Of each voxel.
        channels: usize,
        files: Vec<PathBuf>,
    },
}

impl fmt::Debug for Samples {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Samples::Files(payload) => payload.fmt(f),
            Samples::Planes { files, .. } => f.debug_tuple("Planes").field(files).finish(),
        }
    }
}

impl From<Payload> for Samples {
    fn from(payload: Payload) -> Self {
        Samples::Files(payload)
    }
}

impl Samples {
    pub fn sample(&self) -> SampleType {
        match self {
            Samples::Files(payload) => payload.sample,
            Samples::Planes { sample, .. } => *sample,
        }
    }

    pub fn big_endian(&self) -> bool {
        matches!(self, Samples::Files(payload) if payload.big_endian)
    }

    /// Whether the first voxel of every phase comes before the second of any; else phases follow each other.
    pub fn interleaved(&self) -> bool {
        matches!(self, Samples::Files(payload) if payload.interleaved)
    }

    /// Samples of each voxel: more than one are a colour.
    pub fn channels(&self) -> usize {
        match self {
            Samples::Files(payload) => payload.channels,
            Samples::Planes { channels, .. } => *channels,
        }
    }

    /// The files that hold them.
    pub fn files(&self) -> &[PathBuf] {
        match self {
            Samples::Files(payload) => &payload.files,
            Samples::Planes { files, .. } => files,
        }
    }

    /// Compares what the header promises with what is there. Reads no sample.
    ///
    /// # Errors
    /// As [`Payload::check`].
    pub fn check(&self, header: &Path, dims: [usize; 3], phases: usize) -> Result<(), ImportError> {
        match self {
            Samples::Files(payload) => payload.check(header, dims, phases),
            // Those who made them have seen every slice.
            Samples::Planes { .. } => Ok(()),
        }
    }

    /// Reads some voxels of phase `phase`, counted from 0, of `phases` grids of `dims` voxels; `None` when not one is a
    /// number. `header` is the file that promised them.
    ///
    /// # Errors
    /// As [`Samples::check`]; when data are damaged, on cancel, and where memory does not suffice.
    pub fn read(
        &self,
        header: &Path,
        dims: [usize; 3],
        phases: usize,
        (phase, voxels): (usize, Range<usize>),
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<Option<Decoded>, ImportError> {
        let (sample, big_endian, channels) = (self.sample(), self.big_endian(), self.channels());
        // Voxels that are read, and of how many of them each one is taken.
        let (part, every) = if self.interleaved() {
            (voxels.start * phases..voxels.end * phases, phases)
        } else {
            let first = phase * dims.into_iter().product::<usize>();
            (first + voxels.start..first + voxels.end, 1)
        };
        let mut builder =
            VoxelBuilder::new(sample, big_endian, voxels.len()).map_err(|_| too_many_voxels(header, dims))?;
        let mut done = 0;
        let mut grey = Vec::new();
        let take = |chunk: &[u8]| {
            let chunk = if channels > 1 {
                grey.clear();
                luminance::push(sample, big_endian, channels, chunk, &mut grey);
                &grey[..]
            } else {
                chunk
            };
            if every == 1 {
                builder.push(chunk);
                return Ok(());
            }
            let samples = chunk.chunks_exact(sample.bytes()).enumerate();
            let of_phase = samples.filter(|(k, _)| (done + k) % every == phase);
            of_phase.for_each(|(_, sample)| builder.push(sample));
            done += chunk.len() / sample.bytes();
            Ok(())
        };
        self.read_samples(header, dims, phases, part, progress, cancel, take)?;
        let mut decoded = builder.finish();
        if let Some(decoded) = decoded.as_mut().filter(|_| channels > 2) {
            decoded.notes.push(luminance::NOTE.to_owned());
        }
        Ok(decoded)
    }

    /// Reads a part of the voxels of `phases` grids of `dims` voxels, in the order in which the files have them, and
    /// gives their bytes to `take`, whole voxels at a time. `header` is the file that promised them.
    ///
    /// # Errors
    /// As [`Samples::check`]; when data are damaged, on cancel, and those of `take`.
    #[allow(clippy::too_many_arguments, reason = "what is read, and who is told of it")]
    pub fn read_samples(
        &self,
        header: &Path,
        dims: [usize; 3],
        phases: usize,
        part: Range<usize>,
        progress: Progress<'_>,
        cancel: &CancelToken,
        mut take: impl FnMut(&[u8]) -> Result<(), ImportError>,
    ) -> Result<(), ImportError> {
        let planes = match self {
            Samples::Files(payload) => {
                return payload.read_samples(header, dims, phases, part, progress, cancel, take);
            }
            Samples::Planes { planes, .. } => planes,
        };
        let len = dims[0] * dims[1];
        let voxel = self.sample().bytes() * self.channels();
        let count = part.len() as u64;
        for index in part.start / len..part.end.div_ceil(len) {
            cancel.check()?;
            let first = index * len;
            let wanted = part.start.max(first) - first..part.end.min(first + len) - first;
            progress.report(WorkStage::Decoding, (first + wanted.start - part.start) as u64, count);
            let plane = planes.plane(index, cancel)?;
            let bytes = plane.get(wanted.start * voxel..wanted.end * voxel);
            take(bytes.ok_or_else(|| ImportError::Damaged {
                path: header.to_owned(),
                problem: format!("holds fewer samples in slice {} than it promises", index + 1),
            })?)?;
        }
        progress.report(WorkStage::Decoding, count, count);
        Ok(())
    }

    /// As [`Payload::phases_of_cut`].
    ///
    /// # Errors
    /// As [`Samples::read`].
    pub fn phases_of_cut(
        &self,
        header: &Path,
        dims: [usize; 3],
        phases: usize,
        cancel: &CancelToken,
    ) -> Result<Option<usize>, ImportError> {
        match self {
            Samples::Files(payload) => payload.phases_of_cut(header, dims, phases, cancel),
            Samples::Planes { .. } => Ok(None),
        }
    }
}
