//! DICOM segmentations as label volumes: frames of single segments are put together, so that each voxel holds the
//! number of its segment, and 0 where there is none. They lie in the patient as their series does.

use lumivox_core::{CancelToken, Progress, Voxels, WorkStage, glam::DVec3};

use crate::{
    ImportError,
    claims::Claims,
    codec::{self, Encoding},
    codec_worker::Codecs,
    dicom::{
        assembly::{
            pixels::{Decoded, Failure, allocate},
            stored::{self, NativeFrames},
        },
        bytes::fragments,
        header::segments::{Kind, Segmentation},
        images::{image_file::ImageFile, rejected::Rejected},
        series::stack::Stack,
    },
};

/// Reads the labels of `stack`, whose frames are of one file; also what to tell of them.
///
/// # Errors
/// On cancel, where memory does not suffice, or where nothing of it can be read.
pub(crate) fn decode(
    files: &[ImageFile],
    stack: &Stack,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<(Decoded, Vec<String>), ImportError> {
    let file = stack.first(files);
    let mut canvas = Canvas::new(file, stack)?;
    let lost = read_frames(file, progress, cancel, |frame, raw, bytes| canvas.paint(frame, raw, bytes))?;
    let mut notes = Vec::new();
    let failed = canvas.lost_slices(lost, &mut notes)?;
    Ok((canvas.finish(failed, &mut notes), notes))
}

/// Frames that could not be read, and why the first of them could not.
#[derive(Debug, Default)]
struct Lost {
    frames: Vec<usize>,
    first_error: Option<ImportError>,
}

impl Lost {
    fn add(&mut self, frame: usize, error: impl FnOnce() -> ImportError) {
        self.frames.push(frame);
        self.first_error.get_or_insert_with(error);
    }
}

/// Reads every frame of `file` and gives it to `paint`: its number, its samples and the bytes of one.
///
/// # Errors
/// On cancel, and where no frame can be found. One that is damaged is lost.
fn read_frames(
    file: &ImageFile,
    progress: Progress<'_>,
    cancel: &CancelToken,
    mut paint: impl FnMut(usize, &[u8], usize),
) -> Result<Lost, ImportError> {
    let format = &file.format;
    let frames = file.frames.len();
    let step = |done: usize| {
        progress.report(WorkStage::Decoding, done as u64, frames as u64);
        cancel.check()
    };
    let mut lost = Lost::default();
    let mut input = stored::open_pixels(file, cancel)?;
    if format.encoding == Encoding::Native {
        let mut native = NativeFrames::new(format, &mut input);
        for frame in 0..frames {
            match native.read(frame) {
                Ok(raw) => paint(frame, raw, format.bytes),
                Err(fault) => lost.add(frame, || stored::reading(file, &fault)),
            }
            step(frame + 1)?;
        }
        let finished = input.finish();
        cancel.check()?;
        finished.map_err(|fault| stored::reading(file, &fault))?;
        return Ok(lost);
    }
    let codecs = Codecs::new(format.columns * format.rows, cancel);
    let damaged = |problem| ImportError::Damaged { path: file.source.path(), problem };
    let streams = fragments::read_frames(&mut input, format.frames, &format.frame_offsets);
    let finished = input.finish();
    cancel.check()?;
    let streams = streams.map_err(damaged)?;
    finished.map_err(|fault| stored::reading(file, &fault))?;
    for frame in 0..frames {
        let decoded = match streams.get(frame) {
            Some(stream) => codecs.decode(stream, &format.shape()),
            None => Err(codec::cut_off()),
        };
        match decoded {
            Ok(decoded) => paint(frame, &decoded.samples, decoded.bytes),
            Err(fault) => lost.add(frame, || stored::decoding(file, fault)),
        }
        step(frame + 1)?;
    }
    Ok(lost)
}

/// A volume of labels, on which frames are painted one after the other.
struct Canvas<'a> {
    file: &'a ImageFile,
    segmentation: &'a Segmentation,
    slice_len: usize,
    /// Of the slices, and where they lie along it, rising.
    normal: DVec3,
    depths: Vec<f64>,
    paint: Paint,
}

/// What frames leave on a canvas.
enum Paint {
    /// Their own samples: numbers of segments, or fractions of one.
    Samples(Vec<u16>),
    /// Which segments they show.
    Segments(Claims),
}

impl<'a> Canvas<'a> {
    fn new(file: &'a ImageFile, stack: &Stack) -> Result<Self, ImportError> {
        let segmentation = file.segmentation.as_ref().expect("the caller has seen that it is one");
        let places = &stack.phases[0].places;
        let slice_len = file.format.columns * file.format.rows;
        let samples = allocate::<u16>(slice_len, places.len(), file)?;
        let paint = match segmentation.kind {
            Kind::Labels => Paint::Samples(samples),
            Kind::Fractional(_) if segmentation.is_one_fraction() => Paint::Samples(samples),
            Kind::Fractional(_) | Kind::Binary => Paint::Segments(Claims::on(samples)),
        };
        let normal = stack.plane.normal();
        let depths = places.iter().map(|place| place.dot(normal)).collect();
        Ok(Self { file, segmentation, slice_len, normal, depths, paint })
    }

    /// The slice that a frame belongs to: the nearest one.
    fn slice_of(&self, frame: usize) -> Option<usize> {
        let depth = self.file.frames[frame].position?.dot(self.normal);
        let above = self.depths.partition_point(|d| *d < depth);
        let near = |k: &usize| (self.depths[*k] - depth).abs();
        let candidates = [above.saturating_sub(1), above.min(self.depths.len() - 1)];
        candidates.into_iter().min_by(|a, b| near(a).total_cmp(&near(b)))
    }

    /// Paints the segment of a frame whose samples have so many bytes.
    fn paint(&mut self, frame: usize, raw: &[u8], bytes: usize) {
        let Some(slice) = self.slice_of(frame) else { return };
        let (len, big_endian) = (self.slice_len, self.file.format.big_endian);
        let value = |i: usize| match (bytes, big_endian) {
            (2, false) => u16::from_le_bytes([raw[2 * i], raw[2 * i + 1]]),
            (2, true) => u16::from_be_bytes([raw[2 * i], raw[2 * i + 1]]),
            (bytes, _) => raw[i * bytes].into(),
        };
        let kind = self.segmentation.kind;
        match &mut self.paint {
            Paint::Samples(samples) => {
                // What stands for no segment may be another number than 0.
                let nothing = self.file.format.padding.map(|[value, _]| value).filter(|value| {
                    kind == Kind::Labels && self.segmentation.segments.iter().all(|own| own.number != *value)
                });
                for (i, out) in samples[slice * len..][..len].iter_mut().enumerate() {
                    *out = Some(value(i)).filter(|value| Some(u32::from(*value)) != nothing).unwrap_or(0);
                }
            }
            Paint::Segments(claims) => {
                let segment = self.file.frames[frame].segment.unwrap_or(1);
                let is_in = |i: &usize| match kind {
                    Kind::Fractional(max) => 2 * u32::from(value(*i)) >= max,
                    _ => value(*i) != 0,
                };
                (0..len).filter(is_in).for_each(|i| claims.add(slice * len + i, segment));
            }
        }
    }

    /// The slices all of whose frames are lost; those that lack some are told.
    ///
    /// # Errors
    /// Where every frame is lost, with the reason of the first.
    fn lost_slices(&self, lost: Lost, notes: &mut Vec<String>) -> Result<Vec<Failure>, ImportError> {
        let Some(error) = lost.first_error else { return Ok(Vec::new()) };
        let frames = self.file.frames.len();
        if lost.frames.len() == frames {
            return Err(error);
        }
        notes.push(format!("{} of {frames} frames could not be read", lost.frames.len()));
        // Frames of each slice, and those of them that are lost.
        let mut counts = vec![[0; 2]; self.depths.len()];
        let slice_of = |frame| self.slice_of(frame);
        (0..frames).filter_map(slice_of).for_each(|slice| counts[slice][0] += 1);
        lost.frames.into_iter().filter_map(slice_of).for_each(|slice| counts[slice][1] += 1);
        let partly = counts.iter().filter(|[all, lost]| *lost > 0 && lost < all).count();
        if partly > 0 {
            notes.push(format!(
                "{partly} of {} slices with labels lack those of frames that could not be read",
                counts.len()
            ));
        }
        let reason = Rejected::new(self.file.source.path(), error).reason();
        let fault = || ImportError::Damaged { path: self.file.source.path(), problem: reason.clone() };
        Ok((0..counts.len()).filter(|&k| counts[k][0] == counts[k][1]).map(|k| (k, fault())).collect())
    }

    /// The labels, or the fractions of the only segment; what to tell of them goes to `notes`.
    fn finish(self, failed: Vec<Failure>, notes: &mut Vec<String>) -> Decoded {
        let labels = match self.paint {
            Paint::Samples(samples) => samples,
            Paint::Segments(claims) => {
                let settled = claims.settle();
                let name = |number: u16| {
                    let own = self.segmentation.segments.iter().find(|own| own.number == u32::from(number));
                    own.map(|own| own.name.clone())
                        .filter(|name| !name.is_empty())
                        .unwrap_or(format!("segment {number}"))
                };
                notes.extend(settled.notes(name));
                settled.voxels
            }
        };
        let rescale = match self.segmentation.kind {
            Kind::Fractional(max) if self.segmentation.is_one_fraction() => [1.0 / f64::from(max), 0.0],
            _ => [1.0, 0.0],
        };
        Decoded { voxels: Voxels::U16(labels), rescale, failed }
    }
}
