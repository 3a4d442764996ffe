//! DICOM segmentations as label volumes: frames of single segments are put together, so that each voxel holds the
//! number of its segment, and 0 where there is none. They lie in the patient as their series does.

use std::collections::{BTreeMap, BTreeSet};

use lumivox_core::{CancelToken, Progress, Stage, Voxels, glam::DVec3};

use super::{
    attributes as attr,
    charset::Charset,
    codec::{self, Encoding},
    elements::DataSet,
    frames::Frame,
    geometry::{self, EVEN, Gaps, Grid, Plane, Spread},
    header::{ImageFile, Refusal},
    names::PatientNames,
    palette,
    pixels::{Decoded, Failure, allocate},
    scan::Rejected,
    series::Stack,
    stored::{self, NativeFrames},
    values::FieldFault,
};
use crate::{ImportError, claims::Claims, codec_worker::Codecs, labels::colors};

/// Bytes of a label.
pub(crate) const SAMPLE_BYTES: usize = 2;
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

impl Kind {
    fn of(data: &DataSet) -> Self {
        match data.text(attr::SEGMENTATION_TYPE).as_deref() {
            Some("FRACTIONAL") => {
                Kind::Fractional(data.unsigned(attr::MAXIMUM_FRACTIONAL_VALUE).unwrap_or(255).max(1))
            }
            Some("LABELMAP") => Kind::Labels,
            _ => Kind::Binary,
        }
    }
}

/// Whether a data set is a segmentation that is made of pixels.
pub(crate) fn is_segmentation(data: &DataSet) -> bool {
    let sop_class = data.text(attr::SOP_CLASS_UID).unwrap_or_default();
    ["1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.66.7"].contains(&sop_class.as_str())
}

/// What is not an image, but tells which voxels belong to what.
#[derive(Clone, Debug)]
pub(crate) struct Segmentation {
    kind: Kind,
    pub(crate) segments: Vec<Segment>,
    /// Whether the file says where its frames lie.
    pub(crate) has_places: bool,
    /// SeriesInstanceUID of what it was made on.
    pub(crate) referenced_series: Option<String>,
}

/// A segment of a segmentation.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    /// The value of its voxels.
    pub(crate) number: u32,
    /// Empty where none may be told.
    pub(crate) name: String,
    /// As it is best shown, by its own word or the palette's; linear, sRGB primaries.
    pub(crate) color: Option<[f64; 3]>,
}

impl Segmentation {
    /// The description in a data set. Nothing is required: segments without a name have numbers.
    pub(crate) fn of(data: &DataSet, has_places: bool) -> Self {
        let names = PatientNames::of(data);
        let label = |item: &DataSet| {
            let number = item.unsigned(attr::SEGMENT_NUMBER)?;
            // No longer than it may be, and of one piece: a damaged one may reach into what is said of the patient.
            let label = Charset::of(item, data).text(item, attr::SEGMENT_LABEL);
            let label = label.filter(|label| label.chars().count() <= 64 && !label.contains('\0'));
            let cielab = item.words(attr::RECOMMENDED_DISPLAY_CIELAB_VALUE);
            let cielab: Option<[u16; 3]> = cielab.and_then(|words| words.try_into().ok());
            let color = cielab.map(colors::from_dicom_lab);
            let color = color.or_else(|| palette::color(data, number).map(colors::from_srgb));
            Some(Segment { number, name: names.without(&label.unwrap_or_default()), color })
        };
        // A label map may describe what belongs to no segment, too.
        let segments = data.items(attr::SEGMENT_SEQUENCE).iter().filter_map(label);
        let segments: Vec<Segment> = segments.filter(|segment| segment.number != 0).collect();
        let series = data.items(attr::REFERENCED_SERIES_SEQUENCE).first();
        Self {
            kind: Kind::of(data),
            has_places,
            segments,
            referenced_series: series.and_then(|item| item.text(attr::SERIES_INSTANCE_UID)),
        }
    }

    /// Whether values are fractions of the only segment.
    pub(crate) fn is_one_fraction(&self) -> bool {
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
            .map(|segment| format!("{} {}", segment.number, segment.name).trim_end().to_owned())
            .collect();
        if self.segments.iter().any(|segment| !segment.name.is_empty()) {
            notes.push(format!("segments: {}", named.join(", ")));
        }
        notes
    }
}

/// Gives frames without the number of a segment that of the only one there is.
///
/// # Errors
/// Where several frames have none, and several segments may be meant. Frames whose pixels are numbers need none.
pub(crate) fn number_frames(frames: &mut [Frame], data: &DataSet) -> Result<(), FieldFault> {
    let (n, missing) = (frames.len(), frames.iter().filter(|frame| frame.segment.is_none()).count());
    if missing == 0 || Kind::of(data) == Kind::Labels {
        return Ok(());
    }
    let number = match data.items(attr::SEGMENT_SEQUENCE) {
        [only] => only.unsigned(attr::SEGMENT_NUMBER).and_then(|number| u16::try_from(number).ok()),
        _ if n > 1 => {
            let problem = format!("is missing in {missing} of {n} frames");
            return Err(FieldFault::new(attr::REFERENCED_SEGMENT_NUMBER, problem));
        }
        _ => None,
    };
    frames.iter_mut().for_each(|frame| frame.segment = frame.segment.or(number));
    Ok(())
}

/// Stacks the frames of a segmentation that says nowhere where they lie, if it tells their order; says so.
///
/// # Errors
/// Where the order is not known, or where only some frames have a place.
pub(crate) fn stack_frames(frames: &mut [Frame], data: &DataSet) -> Result<Option<String>, Refusal> {
    let n = frames.len();
    match frames.iter().filter(|frame| frame.position.is_none()).count() {
        0 => return Ok(None),
        missing if missing == n => {}
        missing => {
            let problem = format!("is missing in {missing} of {n} frames");
            return Err(FieldFault::new(attr::IMAGE_POSITION_PATIENT, problem).into());
        }
    }
    let (slices, by) = match (slices_in_stack(data, n), slices_of_segments(frames)) {
        (Some(slices), _) => (slices, "by InStackPositionNumber"),
        (None, Some(slices)) => (slices, "in the order of the frames"),
        (None, None) => {
            return Err(Refusal::Unsupported(
                "a segmentation without the places of its frames, in an order that does not tell them"
                    .to_owned(),
                "Export it again with ImagePositionPatient for each frame",
            ));
        }
    };
    let first = &frames[0];
    let step = first.row_direction.cross(first.column_direction) * first.thickness_mm;
    let (count, mm) = (slices.iter().collect::<BTreeSet<_>>().len(), first.thickness_mm);
    for (frame, slice) in frames.iter_mut().zip(slices) {
        frame.position = Some(step * slice as f64);
    }
    Ok(Some(match count {
        1 => "the place in the patient is not given; put at the origin".to_owned(),
        _ => format!(
            "the places of the {count} slices are not given; stacked {mm} mm apart at the origin, {by}"
        ),
    }))
}

/// The slice of each of `n` frames, by the file's own count of its stack.
fn slices_in_stack(data: &DataSet, n: usize) -> Option<Vec<usize>> {
    let number = |group: &DataSet| {
        let content = group.items(attr::FRAME_CONTENT_SEQUENCE).first()?;
        content.unsigned(attr::IN_STACK_POSITION_NUMBER).map(|number| number as usize)
    };
    let groups = data.items(attr::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE).iter().take(n);
    let numbers: Vec<usize> = groups.map(number).collect::<Option<_>>()?;
    let lowest = *numbers.iter().min().filter(|_| numbers.len() == n)?;
    Some(numbers.iter().map(|number| number - lowest).collect())
}

/// The slice of each frame where every segment has a frame in each: those of one follow each other.
fn slices_of_segments(frames: &[Frame]) -> Option<Vec<usize>> {
    let mut counts: BTreeMap<Option<u16>, usize> = BTreeMap::new();
    let mut count = |frame: &Frame| {
        let count = counts.entry(frame.segment).or_default();
        *count += 1;
        *count - 1
    };
    let slices: Vec<usize> = frames.iter().map(&mut count).collect();
    let each = frames.len() / counts.len();
    counts.values().all(|count| *count == each).then_some(slices)
}

/// The grid of labels whose slices lie at `places`, at most `most_slices` where that is more than they are: by the
/// header's own step where they are on it, for slices without a segment are left out of the file; else by one that they
/// have in common. Labels are never changed and never left out.
pub(crate) fn grid(plane: &Plane, places: &[DVec3], most_slices: usize) -> Grid {
    let n = places.len();
    let dense = Spread { slices: n, ..Spread::default() };
    if n < 2 {
        return geometry::grid_of(plane, places, dense);
    }
    let depths = geometry::depths_of(plane, places);
    let slices_of = |steps: &[usize]| steps[n - 1].saturating_add(1);
    let mut note = None;
    let steps = steps_of_header(&depths, plane.thickness_mm).or_else(|| match depths[..] {
        // Any distance is a step that two have in common.
        [_, gap] => {
            let (steps, what) = step_of_two(gap, plane.thickness_mm);
            note = Some(what);
            Some(vec![0, steps])
        }
        _ => geometry::common_steps(&depths),
    });
    let mut spread = match steps.filter(|steps| slices_of(steps) <= most_slices.max(n)) {
        Some(steps) if slices_of(&steps) == n => dense,
        Some(steps) => {
            let slices = slices_of(&steps);
            let empty = slices - n;
            let verb = if empty == 1 { "holds" } else { "hold" };
            Spread {
                slices,
                sources: Some(geometry::sources_at(&steps)),
                has_gaps: true,
                notes: vec![format!("{empty} of {slices} slices {verb} no segment")],
                ..Spread::default()
            }
        }
        None => {
            let Gaps { smallest, largest, .. } = Gaps::of(&depths);
            let extent = depths[n - 1];
            let steps = ((extent / smallest).ceil() as usize).clamp(n - 1, most_slices.max(n) - 1);
            let (sources, off) = geometry::nearest_places(&depths, steps);
            let note = format!(
                "the slices with labels lie unevenly, {smallest:.3} to {largest:.3} mm apart; each is, unchanged, at the \
                 nearest of {} places {:.3} mm apart, up to {off:.3} mm beside its own",
                steps + 1,
                extent / steps as f64
            );
            Spread {
                slices: steps + 1,
                sources: Some(sources),
                has_gaps: true,
                notes: vec![note],
                ..Spread::default()
            }
        }
    };
    spread.notes.extend(note);
    geometry::grid_of(plane, places, spread)
}

/// How many steps two slices are apart that are no multiple of the one expected: the nearest such number where that is
/// near, else one; and a sentence about it.
fn step_of_two(gap: f64, expected: f64) -> (usize, String) {
    /// The part of the step by which another one may differ.
    const NEAR: f64 = 0.05;
    let steps = (gap / expected).round().max(1.0);
    let step = gap / steps;
    let apart = format!("the two slices with labels lie {gap:.3} mm apart");
    if (step - expected).abs() <= NEAR * expected {
        let what =
            format!("{apart}, taken as {steps} steps of {step:.3} mm ({expected:.3} mm were expected)");
        return (steps as usize, what);
    }
    (1, format!("{apart}, which is no multiple of the {expected:.3} mm that were expected"))
}

/// Where slices at `depths` lie in steps of the header, if they all lie on such.
fn steps_of_header(depths: &[f64], step: f64) -> Option<Vec<usize>> {
    let at = depths.iter().map(|depth| depth / step);
    let steps = at.map(|at| ((at - at.round()).abs() < EVEN).then_some(at.round() as usize));
    let steps: Vec<usize> = steps.collect::<Option<_>>()?;
    steps.is_sorted_by(|a, b| a < b).then_some(steps)
}

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
        let finished = input.finish();
        cancel.check()?;
        finished.map_err(|fault| stored::reading(file, &fault))?;
        return Ok(lost);
    }
    let codecs = Codecs::new(format.columns * format.rows, cancel);
    let damaged = |problem| ImportError::Damaged { path: file.source.path(), problem };
    let streams = codec::read_frames(&mut input, format.frames, &format.frame_offsets);
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
