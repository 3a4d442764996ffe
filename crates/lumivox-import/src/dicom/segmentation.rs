//! DICOM segmentations as label volumes: frames of single segments are put together, so that each voxel holds the
//! number of its segment, and 0 where there is none. They lie in the patient as their series does.

use lumivox_core::{
    CancelToken, Progress, Stage, Voxels,
    glam::{DAffine3, DVec3},
};

use super::{
    attributes as attr,
    codec::{self, Encoding},
    elements::DataSet,
    geometry::{Grid, Plane},
    header::ImageFile,
    pixels::{Decoded, Failure, allocate},
    scan::Rejected,
    series::Stack,
    stored::{self, NativeFrames},
};
use crate::{ImportError, codec_worker::Codecs};

/// Bytes of a label.
pub(crate) const SAMPLE_BYTES: usize = 2;
/// Labels lie on even places within this part of a step.
const EVEN: f64 = 0.05;
/// Segments that are named in the report.
const MOST_NAMED: usize = 64;

/// What the frames of a segmentation hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// One segment each: in or out.
    Binary,
    /// One segment each: probability or occupancy, up to this.
    Fractional(u32),
    /// Numbers of segments.
    Labels,
}

/// What is not an image, but tells which voxels belong to what.
#[derive(Clone, Debug)]
pub(crate) struct Segmentation {
    kind: Kind,
    /// Number and name of each segment.
    segments: Vec<(u32, String)>,
    /// SeriesInstanceUID of what it was made on.
    pub(crate) referenced_series: Option<String>,
}

impl Segmentation {
    /// The description in a data set. Nothing is required: segments without a name have numbers.
    pub(crate) fn of(data: &DataSet) -> Self {
        let kind = match data.text(attr::SEGMENTATION_TYPE).as_deref() {
            Some("FRACTIONAL") => {
                Kind::Fractional(data.unsigned(attr::MAXIMUM_FRACTIONAL_VALUE).unwrap_or(255).max(1))
            }
            Some("LABELMAP") => Kind::Labels,
            _ => Kind::Binary,
        };
        let name = |item: &DataSet| {
            let number = item.unsigned(attr::SEGMENT_NUMBER)?;
            // No longer than it may be, and of one piece: a damaged one may reach into what is said of the patient.
            let label =
                item.text(attr::SEGMENT_LABEL).filter(|label| label.len() <= 64 && !label.contains('\0'));
            Some((number, label.unwrap_or_default()))
        };
        let series = data.items(attr::REFERENCED_SERIES_SEQUENCE).first();
        Self {
            kind,
            segments: data.items(attr::SEGMENT_SEQUENCE).iter().filter_map(name).collect(),
            referenced_series: series.and_then(|item| item.text(attr::SERIES_INSTANCE_UID)),
        }
    }

    /// Whether values are fractions of the only segment.
    fn is_one_fraction(&self) -> bool {
        matches!(self.kind, Kind::Fractional(_)) && self.segments.len() <= 1
    }

    /// What the report says.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        notes.push(match self.kind {
            _ if self.is_one_fraction() => {
                "a fractional segmentation: values are fractions from 0 to 1".to_owned()
            }
            Kind::Fractional(_) => {
                "a fractional segmentation: values are numbers of segments, where one fills at least half"
                    .to_owned()
            }
            _ => "a segmentation: values are numbers of segments".to_owned(),
        });
        let named: Vec<String> = self
            .segments
            .iter()
            .take(MOST_NAMED)
            .filter(|(_, name)| !name.is_empty())
            .map(|(number, name)| format!("{number} {name}"))
            .collect();
        if !named.is_empty() {
            notes.push(format!("segments: {}", named.join(", ")));
        }
        notes
    }
}

/// The grid of labels whose slices lie at `places`: by the header's own step where they are on it, for slices without a
/// segment are left out of the file.
pub(crate) fn grid(plane: &Plane, stack_grid: Grid, depths: &[f64], most_slices: usize) -> Grid {
    let step = plane.thickness_mm;
    let at: Vec<f64> = depths.iter().map(|depth| depth / step).collect();
    let on_steps = at.iter().all(|at| (at - at.round()).abs() < EVEN);
    let slices = at.last().map_or(1, |last| last.round() as usize + 1);
    if !on_steps || slices > most_slices || slices <= depths.len() {
        return stack_grid;
    }
    let mut sources = vec![(0, EMPTY); slices];
    for (k, at) in at.iter().enumerate() {
        sources[at.round() as usize] = (k, 0.0);
    }
    let mut matrix = stack_grid.patient_from_voxel.matrix3;
    matrix.z_axis = matrix.z_axis.normalize() * step;
    let empty = slices - depths.len();
    let verb = if empty == 1 { "holds" } else { "hold" };
    Grid {
        patient_from_voxel: DAffine3 { matrix3: matrix, ..stack_grid.patient_from_voxel },
        sources: Some(sources),
        has_gaps: true,
        notes: vec![format!("{empty} of {slices} slices {verb} no segment")],
    }
}

/// In place of the part of the way to the next slice: labels never come from between two slices, so this is empty.
const EMPTY: f64 = 0.5;

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
    notes.extend(canvas.overlap_note());
    Ok((canvas.finish(failed), notes))
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
        progress.report(Stage::Decoding, done as u64, frames as u64);
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
        return Ok(lost);
    }
    let codecs = Codecs::new(format.columns * format.rows, cancel);
    let damaged = |problem| ImportError::Damaged { path: file.source.path(), problem };
    let streams = codec::read_frames(&mut input, format.frames, &format.frame_offsets).map_err(damaged);
    cancel.check()?;
    let streams = streams?;
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
    labels: Vec<u16>,
    /// The largest fraction at each voxel so far, where several segments have fractions; else empty.
    best: Vec<u8>,
    /// Voxels that belong to several segments.
    overlaps: u64,
}

impl<'a> Canvas<'a> {
    fn new(file: &'a ImageFile, stack: &Stack) -> Result<Self, ImportError> {
        let segmentation = file.segmentation.as_ref().expect("the caller has seen that it is one");
        let places = &stack.phases[0].places;
        let slice_len = file.format.columns * file.format.rows;
        let labels = allocate::<u16>(slice_len, places.len(), file)?;
        let best = match segmentation.kind {
            Kind::Fractional(_) if !segmentation.is_one_fraction() => {
                allocate::<u8>(slice_len, places.len(), file)?
            }
            _ => Vec::new(),
        };
        let normal = stack.plane.normal();
        let depths = places.iter().map(|place| place.dot(normal)).collect();
        Ok(Self { file, segmentation, slice_len, normal, depths, labels, best, overlaps: 0 })
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
        let out = &mut self.labels[slice * len..][..len];
        let value = |i: usize| match (bytes, big_endian) {
            (2, false) => u16::from_le_bytes([raw[2 * i], raw[2 * i + 1]]),
            (2, true) => u16::from_be_bytes([raw[2 * i], raw[2 * i + 1]]),
            (bytes, _) => raw[i * bytes].into(),
        };
        let segment = self.file.frames[frame].segment.unwrap_or(1);
        match self.segmentation.kind {
            Kind::Labels => (0..len).for_each(|i| out[i] = value(i)),
            Kind::Fractional(_) if self.best.is_empty() => (0..len).for_each(|i| out[i] = value(i)),
            Kind::Fractional(max) => {
                let best = &mut self.best[slice * len..][..len];
                for i in 0..len {
                    let fraction = value(i).min(255) as u8;
                    if 2 * u32::from(fraction) >= max && fraction > best[i] {
                        (out[i], best[i]) = (segment, fraction);
                    }
                }
            }
            Kind::Binary => {
                for i in (0..len).filter(|&i| value(i) != 0) {
                    self.overlaps += u64::from(out[i] != 0 && out[i] != segment);
                    out[i] = out[i].max(segment);
                }
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
        let reason = Rejected { path: self.file.source.path(), error }.reason();
        let fault = || ImportError::Damaged { path: self.file.source.path(), problem: reason.clone() };
        Ok((0..counts.len()).filter(|&k| counts[k][0] == counts[k][1]).map(|k| (k, fault())).collect())
    }

    fn overlap_note(&self) -> Option<String> {
        let overlaps = self.overlaps;
        (overlaps > 0).then(|| {
            format!("{overlaps} voxels belong to several segments; the one with the highest number is kept")
        })
    }

    /// The labels, or the fractions of the only segment.
    fn finish(self, failed: Vec<Failure>) -> Decoded {
        let rescale = match self.segmentation.kind {
            Kind::Fractional(max) if self.best.is_empty() => [1.0 / f64::from(max), 0.0],
            _ => [1.0, 0.0],
        };
        Decoded { voxels: Voxels::U16(self.labels), rescale, failed }
    }
}
