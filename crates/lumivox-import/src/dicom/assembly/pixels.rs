//! From pixel data to the samples of a volume.
//!
//! [`storage`](crate::dicom::series::storage) says how they are kept.

use std::sync::atomic::{AtomicU64, Ordering};

use lumivox_core::{CancelToken, Progress, Voxels, WorkStage};
use rayon::prelude::*;

use crate::{
    ImportError,
    codec::{self, Encoding},
    codec_worker::Codecs,
    dicom::{
        assembly::{
            convert::{
                Conversion, Outcome, Sample, convert, convert_bytes, convert_floats, join, of_lowest_value,
            },
            overshoot::Overshoot,
            stored::{self, NativeFrames},
        },
        bytes::{fragments, source::Input},
        header::pixel_format::SampleKind,
        images::{
            image_file::{ImageFile, Slice},
            rejected::Rejected,
        },
        series::storage::{Plan, Storage},
    },
};

/// What CT padding becomes: air.
pub(crate) const AIR_HU: f64 = -1000.0;
/// No volume is larger; a file that says so is wrong.
const LARGEST_VOLUME: usize = crate::sizes::at_most(32 << 30);

/// The samples of a stack.
#[derive(Debug)]
pub(crate) struct Decoded {
    pub(crate) voxels: Voxels,
    /// Slope and intercept.
    pub(crate) rescale: [f64; 2],
    /// Slices, by position in the list, that could not be decoded; their samples are meaningless.
    pub(crate) failed: Vec<Failure>,
}

/// Decodes `slices`, all of one stack.
///
/// # Errors
/// On cancel, or where memory does not suffice. A slice that fails is reported in [`Decoded::failed`].
pub(crate) fn decode(
    files: &[ImageFile],
    slices: &[Slice],
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Decoded, ImportError> {
    let plan = Plan::new(files, slices);
    let codecs = Codecs::new(files[slices[0].file].format.frame_len(), cancel);
    let context =
        Context { files, slices, plan: &plan, codecs: &codecs, progress, cancel, done: AtomicU64::new(0) };
    let (voxels, failed) = match plan.storage {
        Storage::U8 => context.run::<u8>().map(|(v, failed)| (Voxels::U8(v), failed))?,
        Storage::U16 => context.run::<u16>().map(|(v, failed)| (Voxels::U16(v), failed))?,
        Storage::F32 => context.run::<f32>().map(|(v, failed)| (Voxels::F32(v), failed))?,
    };
    Ok(Decoded { voxels, rescale: plan.rescale, failed })
}

struct Context<'a> {
    files: &'a [ImageFile],
    slices: &'a [Slice],
    plan: &'a Plan,
    codecs: &'a Codecs,
    progress: Progress<'a>,
    cancel: &'a CancelToken,
    done: AtomicU64,
}

/// A slice to be filled.
struct Target<'a, T> {
    slice: usize,
    /// The frame of the file, as its header counts them.
    frame: usize,
    out: &'a mut [T],
}

/// The samples of a frame.
struct Raw<'a> {
    samples: &'a [u8],
    /// Of each.
    bytes: usize,
    big_endian: bool,
    overshoot: Option<Overshoot>,
}

/// A slice, by position in the list, and why it could not be decoded.
pub(crate) type Failure = (usize, ImportError);
type SliceResult = (usize, Result<Outcome, ImportError>);

impl Context<'_> {
    /// All samples, and the slices that failed.
    fn run<T: Sample>(&self) -> Result<(Vec<T>, Vec<Failure>), ImportError> {
        let format = &self.files[self.slices[0].file].format;
        let slice_len = format.columns * format.rows;
        let mut samples = allocate::<T>(slice_len, self.slices.len(), &self.files[self.slices[0].file])?;

        // By file, since a zipped or deflated one can be read in order only.
        let mut by_file: Vec<Vec<Target<'_, T>>> = (0..self.files.len()).map(|_| Vec::new()).collect();
        for (slice, (out, at)) in samples.chunks_exact_mut(slice_len).zip(self.slices).enumerate() {
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

        self.fill_padding(&mut samples, slice_len, &results);
        let failed = results.into_iter().filter_map(|(slice, result)| Some((slice, result.err()?))).collect();
        Ok((samples, failed))
    }

    fn step(&self) -> Result<(), ImportError> {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.report(WorkStage::Decoding, done, self.slices.len() as u64);
        Ok(self.cancel.check()?)
    }

    fn decode_file<T: Sample>(
        &self,
        file: &ImageFile,
        mut targets: Vec<Target<'_, T>>,
    ) -> Result<Vec<SliceResult>, ImportError> {
        self.cancel.check()?;
        targets.sort_by_key(|target| target.frame);
        let mut input = match stored::open_pixels(file, self.cancel) {
            Ok(input) => input,
            Err(error) => return self.fail_all(file, &targets, error),
        };
        // Slices of one mosaic come out of one frame.
        let in_frame = file.format.slices_in_frame();
        let by_frame: Vec<Vec<Target<'_, T>>> = targets.into_iter().fold(Vec::new(), |mut groups, target| {
            match groups.last_mut() {
                Some(group) if group[0].frame / in_frame == target.frame / in_frame => group.push(target),
                _ => groups.push(vec![target]),
            }
            groups
        });
        if file.format.encoding == Encoding::Native {
            let results = self.read_native(file, by_frame, &mut input)?;
            let Err(fault) = input.finish() else { return Ok(results) };
            self.cancel.check()?;
            let fail = |(slice, _)| (slice, Err(stored::reading(file, &fault)));
            return Ok(results.into_iter().map(fail).collect());
        }
        let streams = fragments::read_frames(&mut input, file.format.frames, &file.format.frame_offsets)
            .and_then(|streams| {
                input.finish().map_err(|fault| format!("cannot be unpacked ({fault})"))?;
                Ok(streams)
            });
        self.cancel.check()?;
        let streams = match streams {
            Ok(streams) => streams,
            Err(problem) => {
                let error = ImportError::Damaged { path: file.source.path(), problem };
                let targets: Vec<_> = by_frame.into_iter().flatten().collect();
                return self.fail_all(file, &targets, error);
            }
        };
        let shape = file.format.shape();
        let decode = |targets: Vec<Target<'_, T>>| {
            let frame = targets[0].frame / in_frame;
            let decoded = match streams.get(frame) {
                Some(stream) => self.codecs.decode(stream, &shape).map(|decoded| {
                    let overshoot = Overshoot::of(&file.format, stream, &decoded);
                    (decoded, overshoot)
                }),
                None => Err(codec::cut_off()),
            };
            self.cancel.check()?;
            let results = match decoded {
                Ok((decoded, overshoot)) => {
                    // All codecs give little endian samples; encapsulated data are never big endian.
                    let raw =
                        Raw { samples: &decoded.samples, bytes: decoded.bytes, big_endian: false, overshoot };
                    self.distribute(file, targets, raw)
                }
                Err(fault) => targets
                    .into_iter()
                    .map(|target| (target.slice, Err(stored::decoding(file, fault.clone()))))
                    .collect(),
            };
            results.iter().try_for_each(|_| self.step())?;
            Ok(results)
        };
        let results: Result<Vec<Vec<SliceResult>>, ImportError> =
            by_frame.into_par_iter().map(decode).collect();
        Ok(results?.into_iter().flatten().collect())
    }

    /// Fills the slices of one frame from its decoded samples.
    fn distribute<T: Sample>(
        &self,
        file: &ImageFile,
        targets: Vec<Target<'_, T>>,
        raw: Raw<'_>,
    ) -> Vec<SliceResult> {
        let format = &file.format;
        let Raw { samples: raw, bytes, big_endian, overshoot } = raw;
        let mut tile = Vec::new();
        let fill = |target: Target<'_, T>| {
            let conversion = self.conversion(file, &target).clamped(overshoot);
            let raw = match format.mosaic {
                None => raw,
                Some(mosaic) => {
                    let index = target.frame % mosaic.slices;
                    let row_bytes = format.columns * bytes;
                    let picture_row = row_bytes * mosaic.across;
                    let corner =
                        index / mosaic.across * format.rows * picture_row + index % mosaic.across * row_bytes;
                    tile.clear();
                    for row in 0..format.rows {
                        tile.extend_from_slice(&raw[corner + row * picture_row..][..row_bytes]);
                    }
                    &tile[..]
                }
            };
            let outcome = match format.kind {
                SampleKind::Integer => convert_bytes(target.out, &conversion, raw, bytes, big_endian),
                SampleKind::Float => convert_floats(target.out, &conversion, raw, bytes, big_endian),
            };
            (target.slice, Ok(outcome))
        };
        targets.into_iter().map(fill).collect()
    }

    /// Every slice of a file fails for one reason.
    fn fail_all<T>(
        &self,
        file: &ImageFile,
        targets: &[Target<'_, T>],
        error: ImportError,
    ) -> Result<Vec<SliceResult>, ImportError> {
        let reason = Rejected::new(file.source.path(), error).reason();
        targets
            .iter()
            .map(|target| {
                self.step()?;
                let error = ImportError::Damaged { path: file.source.path(), problem: reason.clone() };
                Ok((target.slice, Err(error)))
            })
            .collect()
    }

    fn conversion<'f, T>(&self, file: &'f ImageFile, target: &Target<'_, T>) -> Conversion<'f> {
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
        by_frame: Vec<Vec<Target<'_, T>>>,
        input: &mut Input,
    ) -> Result<Vec<SliceResult>, ImportError> {
        let format = &file.format;
        // Straight into the volume where samples are as large there.
        let direct = format.kind == SampleKind::Integer
            && (format.bytes, size_of::<T>()) == (2, 2)
            && format.packed.is_none()
            && format.mosaic.is_none();
        let mut frames = NativeFrames::new(format, input);
        let mut results = Vec::new();
        for mut targets in by_frame {
            let frame = targets[0].frame / format.slices_in_frame();
            let slices: Vec<usize> = targets.iter().map(|target| target.slice).collect();
            let of_frame = match &mut targets[..] {
                [target] if direct => {
                    let conversion = self.conversion(file, target);
                    let words: &mut [u16] = bytemuck::cast_slice_mut(target.out);
                    frames.read_words(frame, words).map(|()| {
                        let outcome = if format.big_endian {
                            convert(words, &conversion, |_, word| u16::from_be(word).into())
                        } else {
                            convert(words, &conversion, |_, word| u16::from_le(word).into())
                        };
                        vec![(target.slice, Ok(outcome))]
                    })
                }
                _ => frames.read(frame).map(|samples| {
                    let (bytes, big_endian) = (format.bytes, format.big_endian);
                    self.distribute(file, targets, Raw { samples, bytes, big_endian, overshoot: None })
                }),
            };
            results.extend(of_frame.unwrap_or_else(|fault| {
                slices.iter().map(|&slice| (slice, Err(stored::reading(file, &fault)))).collect()
            }));
            slices.iter().try_for_each(|_| self.step())?;
        }
        Ok(results)
    }

    /// Gives padding a value that does not disturb: air in a CT, else the lowest value that was measured.
    fn fill_padding<T: Sample>(&self, samples: &mut [T], slice_len: usize, results: &[SliceResult]) {
        let outcomes = || results.iter().filter_map(|(slice, result)| Some((slice, result.as_ref().ok()?)));
        let [slope, intercept] = self.plan.rescale;
        let fill = if self.files[self.slices[0].file].is_hounsfield() {
            Some((AIR_HU - intercept) / slope)
        } else {
            let range = outcomes().filter_map(|(_, outcome)| outcome.range).reduce(join);
            range.map(|range| of_lowest_value(range, slope))
        };
        let Some(fill) = fill else { return };
        for (slice, outcome) in outcomes() {
            for &(first, length) in &outcome.padded {
                let start = slice * slice_len + first;
                samples[start..start + length].fill(T::from_f64(fill));
            }
        }
    }
}

/// Room for `slices` slices of the size of `file`'s.
///
/// # Errors
/// Where memory does not suffice.
pub(crate) fn allocate<T: bytemuck::Pod>(
    slice_len: usize,
    slices: usize,
    file: &ImageFile,
) -> Result<Vec<T>, ImportError> {
    let len = slice_len.saturating_mul(slices);
    let bytes = len.saturating_mul(size_of::<T>());
    // Reserving fails where zeroing would abort.
    if bytes > LARGEST_VOLUME || Vec::<T>::new().try_reserve_exact(len).is_err() {
        return Err(ImportError::Unsupported {
            path: file.source.path(),
            what: format!("its series needs {} MB of memory", bytes >> 20),
            remedy: "Choose a smaller series, or export a part of it".to_owned(),
        });
    }
    Ok(vec![T::zeroed(); len])
}
