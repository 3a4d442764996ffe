//! From pixel data to the samples of a volume.
//!
//! Scans with one rescale keep their stored integers, with an offset in the intercept where they are signed: so they
//! reach a GPU without loss. Where the rescale changes from slice to slice (PET), integers survive if the change is
//! a whole number of steps; else the samples become floating-point values.

use std::{
    io,
    sync::atomic::{AtomicU64, Ordering},
};

use lumivox_core::{CancelToken, Modality, Progress, Stage, Voxels};
use rayon::prelude::*;

use super::{
    codec::{self, CodecFault, Encoding},
    header::{self, Frame, ImageFile, PixelFormat, SampleKind},
    series::{Slice, Stack},
    source::Input,
};
use crate::ImportError;

/// What CT padding becomes: air.
const AIR_HU: f64 = -1000.0;
/// No volume is larger; a file that says so is wrong.
const LARGEST_VOLUME: usize = 32 << 30;

/// The samples of a stack.
#[derive(Debug)]
pub(crate) struct Decoded {
    pub(crate) voxels: Voxels,
    /// Slope and intercept.
    pub(crate) rescale: [f64; 2],
    /// Slices, by position in the stack, that could not be decoded; their samples are meaningless.
    pub(crate) failed: Vec<Failure>,
}

/// Decodes every slice of `stack`.
///
/// # Errors
/// On cancel, or where memory does not suffice. A slice that fails is reported in [`Decoded::failed`].
pub(crate) fn decode(
    files: &[ImageFile],
    stack: &Stack,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Decoded, ImportError> {
    let plan = Plan::new(files, stack);
    let context = Context { files, stack, plan: &plan, progress, cancel, done: AtomicU64::new(0) };
    let (voxels, failed) = match plan.storage {
        Storage::U8 => context.run::<u8>().map(|(v, failed)| (Voxels::U8(v), failed))?,
        Storage::U16 => context.run::<u16>().map(|(v, failed)| (Voxels::U16(v), failed))?,
        Storage::F32 => context.run::<f32>().map(|(v, failed)| (Voxels::F32(v), failed))?,
    };
    Ok(Decoded { voxels, rescale: plan.rescale, failed })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Storage {
    U8,
    U16,
    F32,
}

/// How samples are kept, decided from headers alone.
#[derive(Debug)]
struct Plan {
    storage: Storage,
    /// Slope and intercept of the volume.
    rescale: [f64; 2],
    /// Per slice of the stack, what is added to its integers.
    offsets: Vec<i32>,
}

impl Plan {
    fn new(files: &[ImageFile], stack: &Stack) -> Self {
        let of = |slice: &Slice| (&files[slice.file].format, &files[slice.file].frames[slice.frame]);
        Self::integers(&stack.slices.iter().map(of).collect::<Vec<_>>()).unwrap_or_else(|| Plan {
            storage: Storage::F32,
            rescale: [1.0, 0.0],
            offsets: vec![0; stack.slices.len()],
        })
    }

    /// A plan that keeps integers; `None` if 16 bits cannot hold all slices exactly.
    fn integers(slices: &[(&PixelFormat, &Frame)]) -> Option<Self> {
        let [slope, intercept] = slices[0].1.rescale;
        let (mut lowest, mut highest) = (i64::MAX, i64::MIN);
        let mut steps = Vec::with_capacity(slices.len());
        for (format, frame) in slices {
            if format.kind == SampleKind::Float || format.bits_stored > 16 || frame.rescale[0] != slope {
                return None;
            }
            // Where intercepts differ by whole steps, stored integers can be shifted without loss.
            let step = (frame.rescale[1] - intercept) / slope;
            if step.abs() > 65535.0 || (step - step.round()).abs() > 1e-6 {
                return None;
            }
            let step = step.round() as i64;
            let range = if format.signed { -(1 << (format.bits_stored - 1)) } else { 0 };
            lowest = lowest.min(range + step);
            highest = highest.max(range + (1 << format.bits_stored) - 1 + step);
            steps.push(step);
        }
        let (storage, bias) = match (lowest, highest) {
            (0.., ..=255) => (Storage::U8, 0),
            (-128.., ..=127) => (Storage::U8, 128),
            (0.., ..=65535) => (Storage::U16, 0),
            (-32768.., ..=32767) => (Storage::U16, 32768),
            _ if highest - lowest <= 65535 => (Storage::U16, -lowest),
            _ => return None,
        };
        let offsets = steps.iter().map(|step| (step + bias) as i32).collect();
        Some(Plan { storage, rescale: [slope, intercept - bias as f64 * slope], offsets })
    }
}

/// A sample of a volume.
trait Sample: bytemuck::Pod + Default + Send + Sync {
    /// The sample of an integer that already has its offset.
    fn from_integer(integer: i32) -> Self;
    /// The sample that is nearest to a stored value.
    fn from_f64(value: f64) -> Self;
    fn to_f64(self) -> f64;
    /// The sample of a raw one.
    fn convert(raw: u32, conversion: &Conversion) -> Self {
        Self::from_integer(conversion.integer(raw))
    }
}

impl Sample for u8 {
    fn from_integer(integer: i32) -> Self {
        integer as u8
    }
    fn from_f64(value: f64) -> Self {
        value.round() as u8
    }
    fn to_f64(self) -> f64 {
        self.into()
    }
}

impl Sample for u16 {
    fn from_integer(integer: i32) -> Self {
        integer as u16
    }
    fn from_f64(value: f64) -> Self {
        value.round() as u16
    }
    fn to_f64(self) -> f64 {
        self.into()
    }
}

impl Sample for f32 {
    fn from_integer(integer: i32) -> Self {
        integer as f32
    }
    fn from_f64(value: f64) -> Self {
        (value as f32).clamp(f32::MIN, f32::MAX)
    }
    fn to_f64(self) -> f64 {
        self.into()
    }
    fn convert(raw: u32, conversion: &Conversion) -> Self {
        let [slope, intercept] = conversion.rescale;
        Self::from_f64(conversion.wide(raw) as f64 * slope + intercept)
    }
}

/// What one slice's raw samples go through.
#[derive(Clone, Copy, Debug)]
struct Conversion {
    /// Bits below the stored ones.
    shift: u32,
    /// The stored bits; what lies above them is junk (old overlays, uncleared memory).
    mask: u32,
    /// The sign bit; 0 if unsigned.
    sign: u32,
    /// MONOCHROME1 without a physical scale: what lowest and highest stored value add up to.
    mirror: Option<i32>,
    /// Added to integers.
    offset: i32,
    /// For floating-point samples.
    rescale: [f64; 2],
    /// Stored values that are padding.
    padding: Option<[i64; 2]>,
    /// A raw sample that is padding although it has more bits than are stored.
    raw_padding: Option<u32>,
}

impl Conversion {
    fn new(format: &PixelFormat, frame: &Frame, offset: i32, modality: Modality) -> Self {
        let shift = format.high_bit + 1 - format.bits_stored;
        let mask = u32::MAX >> (32 - format.bits_stored.min(32));
        let sign = if format.signed { 1 << (format.bits_stored.min(32) - 1) } else { 0 };
        // A CT's values are Hounsfield units whichever way they are shown.
        let mirror = (format.inverted && modality != Modality::Ct && format.bits_stored <= 16)
            .then_some(if format.signed { -1 } else { mask as i32 });
        let mut conversion = Self {
            shift,
            mask,
            sign,
            mirror,
            offset,
            rescale: frame.rescale,
            padding: None,
            raw_padding: None,
        };
        if let Some(raw) = format.padding {
            let values = raw.map(|raw| conversion.wide(raw << shift));
            let bits = u32::MAX >> (32 - 8 * format.bytes.min(4));
            // PixelPaddingValue has the sign of the pixels: as 16 bits or as the stored ones it is the same number.
            let fits = |raw: u32, value: i64| value as u32 & bits & 0xFFFF == raw & bits & 0xFFFF;
            if fits(raw[0], values[0]) && fits(raw[1], values[1]) {
                conversion.padding = Some([values[0].min(values[1]), values[0].max(values[1])]);
            } else {
                conversion.raw_padding = Some(raw[0]);
            }
        }
        conversion
    }

    /// The stored value of a raw sample.
    #[inline]
    fn wide(&self, raw: u32) -> i64 {
        let bits = (raw >> self.shift) & self.mask;
        i64::from(bits ^ self.sign) - i64::from(self.sign)
    }

    /// The integer to keep of a raw sample of up to 16 stored bits. Cannot overflow: [`Plan::integers`] has seen to it.
    #[inline]
    fn integer(&self, raw: u32) -> i32 {
        let bits = (raw >> self.shift) & self.mask;
        let value = ((bits ^ self.sign) as i32).wrapping_sub(self.sign as i32);
        let value = self.mirror.map_or(value, |sum| sum.wrapping_sub(value));
        value.wrapping_add(self.offset)
    }

    fn has_padding(&self) -> bool {
        self.padding.is_some() || self.raw_padding.is_some()
    }

    fn is_padding(&self, raw: u32) -> bool {
        let value = self.wide(raw);
        self.padding.is_some_and(|[low, high]| (low..=high).contains(&value)) || self.raw_padding == Some(raw)
    }
}

/// What a slice was found to hold.
#[derive(Debug, Default)]
struct Outcome {
    /// Samples that measured nothing: first and number.
    padded: Vec<(usize, usize)>,
    /// Lowest other sample, where there is padding.
    lowest: Option<f64>,
}

impl Outcome {
    fn add_padding(&mut self, at: usize) {
        match self.padded.last_mut() {
            Some((first, length)) if *first + *length == at => *length += 1,
            _ => self.padded.push((at, 1)),
        }
    }

    fn add_sample(&mut self, sample: f64) {
        self.lowest = Some(self.lowest.map_or(sample, |lowest| lowest.min(sample)));
    }
}

/// Converts raw integers, each read by `raw` from its index and what lies in `out` there.
fn convert<T: Sample>(out: &mut [T], conversion: &Conversion, raw: impl Fn(usize, T) -> u32) -> Outcome {
    let mut outcome = Outcome::default();
    if !conversion.has_padding() {
        for (i, sample) in out.iter_mut().enumerate() {
            *sample = T::convert(raw(i, *sample), conversion);
        }
        return outcome;
    }
    for (i, sample) in out.iter_mut().enumerate() {
        let raw = raw(i, *sample);
        *sample = T::convert(raw, conversion);
        if conversion.is_padding(raw) {
            outcome.add_padding(i);
        } else {
            outcome.add_sample(sample.to_f64());
        }
    }
    outcome
}

/// Converts a decoded frame of integers with `bytes` bytes each.
fn convert_bytes<T: Sample>(
    out: &mut [T],
    conversion: &Conversion,
    raw: &[u8],
    bytes: usize,
    big: bool,
) -> Outcome {
    let two = |i: usize| [raw[2 * i], raw[2 * i + 1]];
    let four = |i: usize| [raw[4 * i], raw[4 * i + 1], raw[4 * i + 2], raw[4 * i + 3]];
    match (bytes, big) {
        (1, _) => convert(out, conversion, |i, _| raw[i].into()),
        (2, false) => convert(out, conversion, |i, _| u16::from_le_bytes(two(i)).into()),
        (2, true) => convert(out, conversion, |i, _| u16::from_be_bytes(two(i)).into()),
        (_, false) => convert(out, conversion, |i, _| u32::from_le_bytes(four(i))),
        (_, true) => convert(out, conversion, |i, _| u32::from_be_bytes(four(i))),
    }
}

/// Converts a frame of floating-point samples; those that are no numbers count as padding.
fn convert_floats<T: Sample>(
    out: &mut [T],
    rescale: [f64; 2],
    raw: &[u8],
    bytes: usize,
    big: bool,
) -> Outcome {
    let mut outcome = Outcome::default();
    for (i, (sample, raw)) in out.iter_mut().zip(raw.chunks_exact(bytes)).enumerate() {
        let mut long = [0; 8];
        long[..bytes].copy_from_slice(raw);
        if big {
            long[..bytes].reverse();
        }
        let value = match bytes {
            4 => f32::from_bits(u64::from_le_bytes(long) as u32).into(),
            _ => f64::from_bits(u64::from_le_bytes(long)),
        } * rescale[0]
            + rescale[1];
        if value.is_finite() {
            *sample = T::from_f64(value);
            outcome.add_sample(sample.to_f64());
        } else {
            outcome.add_padding(i);
        }
    }
    outcome
}

struct Context<'a> {
    files: &'a [ImageFile],
    stack: &'a Stack,
    plan: &'a Plan,
    progress: Progress<'a>,
    cancel: &'a CancelToken,
    done: AtomicU64,
}

/// A slice to be filled.
struct Target<'a, T> {
    slice: usize,
    frame: usize,
    out: &'a mut [T],
}

/// A slice, by position in the stack, and why it could not be decoded.
type Failure = (usize, ImportError);
type SliceResult = (usize, Result<Outcome, ImportError>);

impl Context<'_> {
    /// All samples, and the slices that failed.
    fn run<T: Sample>(&self) -> Result<(Vec<T>, Vec<Failure>), ImportError> {
        let format = &self.stack.first(self.files).format;
        let frame_len = format.columns * format.rows;
        let mut samples = self.allocate::<T>(frame_len)?;

        // By file, since a zipped or deflated one can be read in order only.
        let mut by_file: Vec<Vec<Target<'_, T>>> = (0..self.files.len()).map(|_| Vec::new()).collect();
        for (slice, (out, at)) in samples.chunks_exact_mut(frame_len).zip(&self.stack.slices).enumerate() {
            by_file[at.file].push(Target { slice, frame: at.frame, out });
        }
        let results: Vec<SliceResult> = by_file
            .into_par_iter()
            .enumerate()
            .filter(|(_, targets)| !targets.is_empty())
            .map(|(file, targets)| self.decode_file(&self.files[file], targets))
            .collect::<Result<Vec<_>, _>>()?
            .into_iter()
            .flatten()
            .collect();

        self.fill_padding(&mut samples, frame_len, &results);
        let failed = results.into_iter().filter_map(|(slice, result)| Some((slice, result.err()?))).collect();
        Ok((samples, failed))
    }

    fn allocate<T: Sample>(&self, frame_len: usize) -> Result<Vec<T>, ImportError> {
        let len = frame_len.saturating_mul(self.stack.slices.len());
        let bytes = len.saturating_mul(size_of::<T>());
        // Reserving fails where zeroing would abort.
        if bytes > LARGEST_VOLUME || Vec::<T>::new().try_reserve_exact(len).is_err() {
            return Err(ImportError::Unsupported {
                path: self.stack.first(self.files).source.path(),
                what: format!("its series needs {} MB of memory", bytes >> 20),
                remedy: "Choose a smaller series, or export a part of it".to_owned(),
            });
        }
        Ok(vec![T::default(); len])
    }

    fn step(&self) -> Result<(), ImportError> {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.report(Stage::Decoding, done, self.stack.slices.len() as u64);
        Ok(self.cancel.check()?)
    }

    fn decode_file<T: Sample>(
        &self,
        file: &ImageFile,
        mut targets: Vec<Target<'_, T>>,
    ) -> Result<Vec<SliceResult>, ImportError> {
        self.cancel.check()?;
        targets.sort_by_key(|target| target.frame);
        let damaged = |problem: String| ImportError::Damaged { path: file.source.path(), problem };
        let opened = open_pixels(file).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => damaged("ends before its pixel data".to_owned()),
            _ => ImportError::Io { path: file.source.path(), source: e },
        });
        let mut input = match opened {
            Ok(input) => input,
            Err(e) => return self.fail_all(file, &targets, e),
        };
        if file.format.encoding == Encoding::Native {
            let results = self.read_native(file, targets, &mut input)?;
            let Err(fault) = input.finish() else { return Ok(results) };
            let fail = |(slice, _)| (slice, Err(damaged(format!("cannot be unpacked ({fault})"))));
            return Ok(results.into_iter().map(fail).collect());
        }
        let streams = codec::read_frames(&mut input, file.format.frames).and_then(|streams| {
            input.finish().map_err(|fault| format!("cannot be unpacked ({fault})"))?;
            Ok(streams)
        });
        let streams = match streams {
            Ok(streams) => streams,
            Err(problem) => return self.fail_all(file, &targets, damaged(problem)),
        };
        let decode = |target: Target<'_, T>| {
            let decoded = codec::decode(&streams[target.frame], &file.format).map_err(|fault| match fault {
                CodecFault::Damaged(problem) => damaged(problem),
                CodecFault::Unsupported(what) => header::undecodable(&file.source, what),
            });
            let result = decoded.map(|decoded| {
                let conversion = self.conversion(file, &target);
                // All codecs give little endian samples; encapsulated data are never big endian.
                convert_bytes(target.out, &conversion, &decoded.samples, decoded.bytes, false)
            });
            self.step()?;
            Ok((target.slice, result))
        };
        targets.into_par_iter().map(decode).collect()
    }

    /// Every slice of a file fails for one reason.
    fn fail_all<T>(
        &self,
        file: &ImageFile,
        targets: &[Target<'_, T>],
        error: ImportError,
    ) -> Result<Vec<SliceResult>, ImportError> {
        let reason = super::scan::Rejected { path: file.source.path(), error }.reason();
        targets
            .iter()
            .map(|target| {
                self.step()?;
                let error = ImportError::Damaged { path: file.source.path(), problem: reason.clone() };
                Ok((target.slice, Err(error)))
            })
            .collect()
    }

    fn conversion<T>(&self, file: &ImageFile, target: &Target<'_, T>) -> Conversion {
        Conversion::new(
            &file.format,
            &file.frames[target.frame],
            self.plan.offsets[target.slice],
            file.modality,
        )
    }

    /// Reads frames that are not compressed, one after the other.
    fn read_native<T: Sample>(
        &self,
        file: &ImageFile,
        targets: Vec<Target<'_, T>>,
        input: &mut Input,
    ) -> Result<Vec<SliceResult>, ImportError> {
        let start = input.position();
        let frame_bytes = file.format.frame_bytes();
        let mut buffer = Vec::new();
        let mut results = Vec::with_capacity(targets.len());
        for target in targets {
            let conversion = self.conversion(file, &target);
            let at = start + (target.frame * frame_bytes) as u64;
            let result = input
                .skip(at - input.position())
                .and_then(|()| read_native_frame(input, &file.format, &conversion, target.out, &mut buffer))
                .map_err(|e| match e.kind() {
                    io::ErrorKind::UnexpectedEof => ImportError::Damaged {
                        path: file.source.path(),
                        problem: "ends in the middle of its pixel data".to_owned(),
                    },
                    io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => ImportError::Damaged {
                        path: file.source.path(),
                        problem: format!("cannot be unpacked ({e})"),
                    },
                    _ => ImportError::Io { path: file.source.path(), source: e },
                });
            results.push((target.slice, result));
            self.step()?;
        }
        Ok(results)
    }

    /// Gives padding a value that does not disturb: air in a CT, else the lowest that was measured.
    fn fill_padding<T: Sample>(&self, samples: &mut [T], frame_len: usize, results: &[SliceResult]) {
        let outcomes = || results.iter().filter_map(|(slice, result)| Some((slice, result.as_ref().ok()?)));
        let [slope, intercept] = self.plan.rescale;
        let fill = if self.stack.first(self.files).modality == Modality::Ct {
            Some((AIR_HU - intercept) / slope)
        } else {
            outcomes().filter_map(|(_, outcome)| outcome.lowest).reduce(f64::min)
        };
        let Some(fill) = fill else { return };
        for (slice, outcome) in outcomes() {
            for &(first, length) in &outcome.padded {
                let start = slice * frame_len + first;
                samples[start..start + length].fill(T::from_f64(fill));
            }
        }
    }
}

/// Opens a file at the value of its pixel data.
fn open_pixels(file: &ImageFile) -> io::Result<Input> {
    let mut input = file.source.open()?;
    if let Some(start) = file.format.deflated_from {
        input.skip(start)?;
        input = input.inflate(Vec::new());
    }
    input.skip(file.format.offset)?;
    Ok(input)
}

fn read_native_frame<T: Sample>(
    input: &mut Input,
    format: &PixelFormat,
    conversion: &Conversion,
    out: &mut [T],
    buffer: &mut Vec<u8>,
) -> io::Result<Outcome> {
    // Straight into the volume where samples are as large there.
    if format.kind == SampleKind::Integer && format.bytes == 2 && size_of::<T>() == 2 {
        let words: &mut [u16] = bytemuck::cast_slice_mut(out);
        input.read_exact(bytemuck::cast_slice_mut(words))?;
        return Ok(if format.big_endian {
            convert(words, conversion, |_, word| u16::from_be(word).into())
        } else {
            convert(words, conversion, |_, word| u16::from_le(word).into())
        });
    }
    buffer.resize(format.frame_bytes(), 0);
    input.read_exact(buffer)?;
    if format.swapped_pairs {
        buffer.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
    }
    Ok(match format.kind {
        SampleKind::Integer => convert_bytes(out, conversion, buffer, format.bytes, format.big_endian),
        SampleKind::Float => convert_floats(out, conversion.rescale, buffer, format.bytes, format.big_endian),
    })
}
