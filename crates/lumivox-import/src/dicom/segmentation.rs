//! DICOM segmentations as label volumes: frames of single segments are put together, so that each voxel holds the
//! number of its segment, and 0 where there is none. They lie in the patient as their series does.

use lumivox_core::{CancelToken, Progress, Stage, Voxels, glam::DAffine3};

use super::{
    attributes as attr,
    codec::{self, Encoding},
    elements::DataSet,
    geometry::{Grid, Plane},
    header::ImageFile,
    pixels::{Decoded, allocate},
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

/// Reads the labels of `stack`, whose frames are of one file.
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
    let segmentation = file.segmentation.as_ref().expect("the caller has seen that it is one");
    let (format, phase) = (&file.format, &stack.phases[0]);
    let len = format.columns * format.rows;
    let mut labels = allocate::<u16>(len, phase.places.len(), file)?;
    let mut best = match segmentation.kind {
        Kind::Fractional(_) if !segmentation.is_one_fraction() => {
            allocate::<u8>(len, phase.places.len(), file)?
        }
        _ => Vec::new(),
    };
    let normal = stack.plane.normal();
    let depths: Vec<f64> = phase.places.iter().map(|place| place.dot(normal)).collect();
    let slice_of = |frame: usize| {
        let depth = file.frames[frame].position?.dot(normal);
        let above = depths.partition_point(|d| *d < depth);
        let near = |k: &usize| (depths[*k] - depth).abs();
        let candidates = [above.saturating_sub(1), above.min(depths.len() - 1)];
        candidates.into_iter().min_by(|a, b| near(a).total_cmp(&near(b)))
    };
    let mut overlaps = 0u64;
    let mut paint = |frame: usize, raw: &[u8], bytes: usize| {
        let Some(slice) = slice_of(frame) else { return };
        let out = &mut labels[slice * len..][..len];
        let value = |i: usize| match (bytes, format.big_endian) {
            (2, false) => u16::from_le_bytes([raw[2 * i], raw[2 * i + 1]]),
            (2, true) => u16::from_be_bytes([raw[2 * i], raw[2 * i + 1]]),
            (bytes, _) => raw[i * bytes].into(),
        };
        let segment = file.frames[frame].segment.unwrap_or(1);
        match segmentation.kind {
            Kind::Labels => (0..len).for_each(|i| out[i] = value(i)),
            Kind::Fractional(_) if best.is_empty() => (0..len).for_each(|i| out[i] = value(i)),
            Kind::Fractional(max) => {
                let best = &mut best[slice * len..][..len];
                for i in 0..len {
                    let fraction = value(i).min(255) as u8;
                    if 2 * u32::from(fraction) >= max && fraction > best[i] {
                        (out[i], best[i]) = (segment, fraction);
                    }
                }
            }
            Kind::Binary => {
                for i in (0..len).filter(|&i| value(i) != 0) {
                    overlaps += u64::from(out[i] != 0 && out[i] != segment);
                    out[i] = out[i].max(segment);
                }
            }
        }
    };

    let mut lost: Vec<usize> = Vec::new();
    let mut first_error = None;
    let mut input = stored::open_pixels(file, cancel)?;
    let frames = file.frames.len();
    let step = |done: usize| {
        progress.report(Stage::Decoding, done as u64, frames as u64);
        cancel.check()
    };
    if format.encoding == Encoding::Native {
        let mut native = NativeFrames::new(format, &mut input);
        for frame in 0..frames {
            match native.read(frame) {
                Ok(raw) => paint(frame, raw, format.bytes),
                Err(fault) => {
                    lost.push(frame);
                    first_error.get_or_insert_with(|| stored::reading(file, &fault));
                }
            }
            step(frame + 1)?;
        }
    } else {
        let codecs = Codecs::new(len, cancel);
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
                Err(fault) => {
                    lost.push(frame);
                    first_error.get_or_insert_with(|| stored::decoding(file, fault));
                }
            }
            step(frame + 1)?;
        }
    }
    let mut notes = Vec::new();
    let mut failed = Vec::new();
    if let Some(error) = first_error {
        if lost.len() == frames {
            return Err(error);
        }
        notes.push(format!("{} of {frames} frames could not be read", lost.len()));
        // Frames of each slice, and those of them that are lost.
        let mut counts = vec![[0; 2]; depths.len()];
        (0..frames).filter_map(slice_of).for_each(|slice| counts[slice][0] += 1);
        lost.iter().copied().filter_map(slice_of).for_each(|slice| counts[slice][1] += 1);
        let reason = Rejected { path: file.source.path(), error }.reason();
        let fault = || ImportError::Damaged { path: file.source.path(), problem: reason.clone() };
        failed.extend((0..counts.len()).filter(|&k| counts[k][0] == counts[k][1]).map(|k| (k, fault())));
        let partly = counts.iter().filter(|[all, lost]| *lost > 0 && lost < all).count();
        if partly > 0 {
            notes.push(format!(
                "{partly} of {} slices with labels lack those of frames that could not be read",
                counts.len()
            ));
        }
    }
    if overlaps > 0 {
        notes.push(format!(
            "{overlaps} voxels belong to several segments; the one with the highest number is kept"
        ));
    }
    let rescale = match segmentation.kind {
        Kind::Fractional(max) if best.is_empty() => [1.0 / f64::from(max), 0.0],
        _ => [1.0, 0.0],
    };
    Ok((Decoded { voxels: Voxels::U16(labels), rescale, failed }, notes))
}
