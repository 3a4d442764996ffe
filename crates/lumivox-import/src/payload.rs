//! The image data behind a header: in which files, after how many bytes, in which encoding.
//!
//! NIfTI, NRRD, MetaImage and RAW differ in their headers only. What the header promises is compared with the size of
//! the files before any memory is asked for, and no more than that is ever inflated.

use std::{
    io::{self, BufRead, BufReader, Read, Seek, SeekFrom},
    ops::Range,
    path::{Path, PathBuf},
};

use flate2::bufread::{MultiGzDecoder, ZlibDecoder};
use lumivox_core::{CancelToken, Progress, WorkStage};

use crate::{
    error::ImportError,
    files::File,
    sample::SampleType,
    written_samples::{HexBytes, TextSamples},
};

/// Bytes decoded between two looks at the cancel token; a multiple of every sample's size.
const CHUNK: usize = 1 << 20;

/// Deflate cannot shrink data by more than this factor.
const DEFLATE_LIMIT: u64 = 1032;

/// How samples are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// As they lie in memory.
    Raw,
    /// Deflated, with a gzip or zlib wrapper, whichever is found.
    Deflate,
    /// Decimal numbers between white space or commas.
    Text,
    /// Two hexadecimal digits for each byte, with white space wherever.
    Hex,
}

/// What lies before the samples of each file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ByteSkip {
    /// So many bytes, counted after inflating.
    Bytes(u64),
    /// Whatever leaves the samples at the end of the file, or of what is inflated of it.
    Tail,
}

/// Where the samples of a scan are.
#[derive(Clone, Debug)]
pub(crate) struct Payload {
    /// The files that hold the samples, each the same number, in order.
    pub files: Vec<PathBuf>,
    /// Where the data begins in each file: after the header, where both share one.
    pub start: u64,
    /// Lines to skip from `start`, before inflating.
    pub line_skip: u64,
    /// Bytes to skip then.
    pub byte_skip: ByteSkip,
    pub encoding: Encoding,
    pub sample: SampleType,
    pub big_endian: bool,
    /// Whether the first voxel of every phase comes before the second of any; else phases follow each other.
    pub interleaved: bool,
    /// Samples of each voxel: more than one are a colour.
    pub channels: usize,
}

impl Payload {
    /// Samples of type `sample` that begin at `byte_skip` of one file.
    pub fn in_file(path: &Path, sample: SampleType, big_endian: bool, byte_skip: u64) -> Self {
        Self {
            files: vec![path.to_owned()],
            start: 0,
            line_skip: 0,
            byte_skip: ByteSkip::Bytes(byte_skip),
            encoding: Encoding::Raw,
            sample,
            big_endian,
            interleaved: false,
            channels: 1,
        }
    }

    /// Compares what the header promises, `phases` grids of `dims` voxels, with the sizes of the files. Reads no sample.
    /// `header` is the file that promised them.
    ///
    /// # Errors
    /// When a file is missing, too short or no plain file, and for sizes that nothing has.
    pub fn check(&self, header: &Path, dims: [usize; 3], phases: usize) -> Result<(), ImportError> {
        let per_file = self.bytes_per_file(header, dims, phases)?;
        self.files.iter().try_for_each(|file| self.start_in(header, file, per_file).map(|_| ()))
    }

    /// Reads a part of the voxels of `phases` grids of `dims` voxels, in the order in which the files have them, and
    /// gives their bytes to `take`, whole voxels at a time. `header` is the file that promised them.
    ///
    /// # Errors
    /// As [`Payload::check`]; when data are damaged, on cancel, and those of `take`.
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
        let per_file = self.bytes_per_file(header, dims, phases)?;
        let voxel = self.sample.bytes() * self.channels;
        let wanted = (part.len() * voxel) as u64;
        let mut before = (part.start * voxel) as u64;
        let mut done = 0;
        let chunk = CHUNK / voxel * voxel;
        let mut buffer = vec![0; chunk.min(wanted as usize)];
        for file in &self.files {
            if before >= per_file {
                before -= per_file;
                continue;
            }
            let start = self.start_in(header, file, per_file)?;
            let mut input = self.open(file, start, (before, per_file), cancel)?;
            let mut left = (per_file - before).min(wanted - done);
            let to_its_end = before + left == per_file;
            let mut read = before;
            before = 0;
            while left > 0 {
                cancel.check()?;
                progress.report(WorkStage::Decoding, done, wanted);
                let chunk = &mut buffer[..(chunk as u64).min(left) as usize];
                let got = fill(&mut *input, chunk).map_err(|e| self.damaged(file, e))?;
                read += got as u64;
                if got < chunk.len() {
                    let path = file.clone();
                    return Err(ImportError::Truncated { path, expected: per_file, actual: read });
                }
                take(chunk)?;
                done += got as u64;
                left -= got as u64;
            }
            // Only at its end does a deflated stream compare its checksum.
            if to_its_end && self.encoding == Encoding::Deflate {
                match input.read(&mut [0]) {
                    Err(e) if e.to_string().contains("checksum") => return Err(self.damaged(file, e)),
                    _ => {}
                }
            }
            if done == wanted {
                break;
            }
        }
        progress.report(WorkStage::Decoding, wanted, wanted);
        Ok(())
    }

    /// How many of `phases` grids of `dims` voxels are whole in a deflated file, where these are not all, so that it is
    /// cut short behind one that could be read. `None` too where several files hold them.
    ///
    /// # Errors
    /// As [`Payload::read`].
    pub fn phases_of_cut(
        &self,
        header: &Path,
        dims: [usize; 3],
        phases: usize,
        cancel: &CancelToken,
    ) -> Result<Option<usize>, ImportError> {
        let ([file], Encoding::Deflate, ByteSkip::Bytes(skip)) =
            (&self.files[..], self.encoding, self.byte_skip)
        else {
            return Ok(None);
        };
        let expected = self.bytes_per_file(header, dims, phases)?;
        // Unpacking all is slow, and needless where the size at the end of a gzip file is that of the whole.
        if unpacked_size(file).map_err(ImportError::io(file))? == skip.saturating_add(expected) as u32 {
            return Ok(None);
        }
        let mut input = self.open(file, self.start_in(header, file, expected)?, (0, expected), cancel)?;
        let mut there = 0;
        let mut buffer = vec![0; CHUNK.min(expected as usize)];
        while there < expected {
            cancel.check()?;
            let wanted = buffer.len().min((expected - there) as usize);
            // Damage of later phases is that of what they hold.
            let Ok(got @ 1..) = fill(&mut *input, &mut buffer[..wanted]) else { break };
            there += got as u64;
        }
        Ok((there < expected).then(|| (there / (expected / phases as u64)) as usize))
    }

    /// Bytes of samples in each file.
    fn bytes_per_file(&self, header: &Path, dims: [usize; 3], phases: usize) -> Result<u64, ImportError> {
        let field = |field: &str, problem: String, remedy: &str| ImportError::Field {
            path: header.to_owned(),
            field: field.to_owned(),
            problem,
            remedy: remedy.to_owned(),
        };
        let [x, y, z] = dims;
        let total = dims
            .into_iter()
            .try_fold(phases, usize::checked_mul)
            .and_then(|n| n.checked_mul(self.channels))
            .filter(|n| n.checked_mul(self.sample.bytes()).is_some_and(|bytes| bytes <= isize::MAX as usize))
            .ok_or_else(|| {
                let size = format!("{x} x {y} x {z} x {phases}");
                field("the size of the grid", format!("{size} is impossible"), "The header is damaged")
            })?;
        if total == 0 {
            return Err(field(
                "the size of the grid",
                format!("{x} x {y} x {z} has no voxel"),
                "Export the scan again",
            ));
        }
        if self.files.is_empty() || !total.is_multiple_of(self.files.len()) {
            let problem = format!("names {} files, which cannot share {total} samples", self.files.len());
            return Err(field("the list of data files", problem, "Name one file for each slice"));
        }
        Ok((total / self.files.len() * self.sample.bytes()) as u64)
    }

    /// Compares the size of a data file with what it must hold, and gives the position of its data.
    fn start_in(&self, header: &Path, file: &Path, bytes: u64) -> Result<u64, ImportError> {
        let metadata = match crate::files::metadata(file) {
            Err(e) if e.kind() == io::ErrorKind::NotFound && file != header => {
                return Err(ImportError::Field {
                    path: header.to_owned(),
                    field: "the data file".to_owned(),
                    problem: format!("'{}' is not there", file.display()),
                    remedy: "Keep the header and its data files together, under their own names".to_owned(),
                });
            }
            other => other.map_err(ImportError::io(file))?,
        };
        // Devices and pipes have no end to check against.
        if !metadata.is_file() {
            return Err(ImportError::Unsupported {
                path: file.to_owned(),
                what: "image data that is not in a plain file".to_owned(),
                remedy: "Name a plain file in the header".to_owned(),
            });
        }
        let there = metadata.length().saturating_sub(self.start);
        let skip = match self.byte_skip {
            ByteSkip::Bytes(skip) => skip,
            ByteSkip::Tail => 0,
        };
        let expected = bytes.saturating_add(skip);
        let truncated = || {
            let actual = there.saturating_sub(skip);
            Err(ImportError::Truncated { path: file.to_owned(), expected: bytes, actual })
        };
        match self.encoding {
            Encoding::Raw if there < expected => return truncated(),
            // A digit and a space for each sample but the last.
            Encoding::Text if there < 2 * (bytes / self.sample.bytes() as u64) - 1 => {
                return Err(ImportError::Field {
                    path: file.to_owned(),
                    field: "the image data".to_owned(),
                    problem: format!(
                        "of {there} characters cannot hold the numbers that the header promises"
                    ),
                    remedy: "The file is cut short; copy or export it again".to_owned(),
                });
            }
            Encoding::Hex if there / 2 < expected => return truncated(),
            Encoding::Deflate if there.saturating_mul(DEFLATE_LIMIT) < expected => {
                return Err(ImportError::Field {
                    path: file.to_owned(),
                    field: "the compressed image data".to_owned(),
                    problem: format!("of {there} bytes cannot hold the {expected} bytes the header promises"),
                    remedy: "The file is cut short or damaged; copy or export it again".to_owned(),
                });
            }
            _ => {}
        }
        Ok(match self.byte_skip {
            ByteSkip::Tail if self.encoding == Encoding::Deflate => self.start,
            ByteSkip::Tail => metadata.length().saturating_sub(bytes).max(self.start),
            ByteSkip::Bytes(_) => self.start,
        })
    }

    /// Opens a data file, which holds `per_file` bytes of samples, `before` bytes behind the first of them.
    fn open(
        &self,
        path: &Path,
        start: u64,
        (before, per_file): (u64, u64),
        cancel: &CancelToken,
    ) -> Result<Box<dyn Read>, ImportError> {
        let mut file = BufReader::with_capacity(1 << 16, File::open(path).map_err(ImportError::io(path))?);
        file.seek(SeekFrom::Start(start)).map_err(ImportError::io(path))?;
        for _ in 0..self.line_skip {
            if !skip_line(&mut file, path, cancel)? {
                break;
            }
        }
        let skip = match (self.byte_skip, self.encoding) {
            (ByteSkip::Bytes(skip), _) => skip,
            (ByteSkip::Tail, Encoding::Deflate) => {
                let at = file.stream_position().map_err(ImportError::io(path))?;
                self.inflated_bytes(path, at, cancel)?.saturating_sub(per_file)
            }
            (ByteSkip::Tail, _) => 0,
        };
        let mut left = skip.saturating_add(before);
        let mut input: Box<dyn Read> = match self.encoding {
            Encoding::Raw => {
                file.seek_relative(i64::try_from(left).unwrap_or(i64::MAX)).map_err(ImportError::io(path))?;
                return Ok(Box::new(file));
            }
            Encoding::Deflate => inflate(file).map_err(ImportError::io(path))?,
            Encoding::Text => Box::new(TextSamples::new(file, self.sample, self.big_endian)),
            Encoding::Hex => Box::new(HexBytes(file)),
        };
        while left > 0 {
            cancel.check()?;
            let step = left.min(CHUNK as u64);
            let skipped = io::copy(&mut (&mut input).take(step), &mut io::sink());
            match skipped {
                // What is missing shows where samples are read.
                Ok(skipped) if skipped < step => break,
                Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => break,
                skipped => left -= skipped.map_err(|e| self.damaged(path, e))?,
            }
        }
        Ok(input)
    }

    /// How long deflated data are that begin at `start` of a file: it shows at their end only.
    fn inflated_bytes(&self, path: &Path, start: u64, cancel: &CancelToken) -> Result<u64, ImportError> {
        let mut file = BufReader::new(File::open(path).map_err(ImportError::io(path))?);
        file.seek(SeekFrom::Start(start)).map_err(ImportError::io(path))?;
        let mut input = inflate(file).map_err(ImportError::io(path))?;
        let mut buffer = vec![0; 1 << 16];
        let mut length = 0;
        loop {
            cancel.check()?;
            match fill(&mut *input, &mut buffer).map_err(|e| self.damaged(path, e))? {
                0 => return Ok(length),
                read => length += read as u64,
            }
        }
    }

    /// What a failed read means: the system's trouble, or damaged data.
    fn damaged(&self, path: &Path, source: io::Error) -> ImportError {
        let content = matches!(
            source.kind(),
            io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput | io::ErrorKind::UnexpectedEof
        );
        if self.encoding == Encoding::Raw || !content {
            return ImportError::Io { path: path.to_owned(), source };
        }
        ImportError::Field {
            path: path.to_owned(),
            field: "the image data".to_owned(),
            problem: format!("is damaged ({source})"),
            remedy: "Copy or export the file again".to_owned(),
        }
    }
}

/// That memory does not suffice for a grid.
pub(crate) fn too_many_voxels(header: &Path, [x, y, z]: [usize; 3]) -> ImportError {
    let what = format!("a grid of {x} x {y} x {z} voxels, more than this machine has memory for");
    let remedy = "Resample the scan to fewer voxels".to_owned();
    ImportError::Unsupported { path: header.to_owned(), what, remedy }
}

/// The size that a gzip file gives at its end, of its last member; of other files four bytes.
fn unpacked_size(path: &Path) -> io::Result<u32> {
    let mut file = File::open(path)?;
    file.seek(SeekFrom::End(-4))?;
    let mut size = [0; 4];
    file.read_exact(&mut size)?;
    Ok(u32::from_le_bytes(size))
}

/// Inflates gzip (of one or more members) or zlib data, whichever it is.
pub(crate) fn inflate(mut file: impl BufRead + 'static) -> io::Result<Box<dyn Read>> {
    let gzip = file.fill_buf()?.starts_with(&GZIP_MAGIC[..1]);
    Ok(if gzip { Box::new(MultiGzDecoder::new(file)) } else { Box::new(ZlibDecoder::new(file)) })
}

/// The first bytes of gzip data.
pub(crate) const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Fills `buffer` as far as `input` goes; fewer bytes mean its end. A deflated stream that breaks off ends there.
pub(crate) fn fill(input: &mut dyn Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match input.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => break,
            Err(e) => return Err(e),
        }
    }
    Ok(filled)
}

/// Steps over a line; whether there was one.
fn skip_line(file: &mut BufReader<File>, path: &Path, cancel: &CancelToken) -> Result<bool, ImportError> {
    loop {
        cancel.check()?;
        let buffer = file.fill_buf().map_err(ImportError::io(path))?;
        let (length, end) = match buffer.iter().position(|byte| *byte == b'\n') {
            Some(end) => (end + 1, true),
            None => (buffer.len(), false),
        };
        file.consume(length);
        if end || length == 0 {
            return Ok(end);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, write::GzEncoder, write::ZlibEncoder};

    use super::*;
    use crate::samples::Samples;

    fn read(payload: &Payload, dims: [usize; 3], phases: usize) -> Result<Vec<f64>, ImportError> {
        let payload = Samples::from(payload.clone());
        let header = Path::new("scan.hdr");
        let part = (0, 0..dims.into_iter().fold(1, usize::wrapping_mul));
        payload.check(header, dims, phases)?;
        let decoded =
            payload.read(header, dims, phases, part, Progress::SILENT, &CancelToken::new())?.unwrap();
        let [slope, intercept] = decoded.rescale;
        Ok((0..decoded.voxels.len()).map(|i| decoded.voxels.get(i) * slope + intercept).collect())
    }

    fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(bytes).unwrap();
        file
    }

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    fn payload(path: &Path, encoding: Encoding) -> Payload {
        Payload { encoding, ..Payload::in_file(path, SampleType::U8, false, 0) }
    }

    #[test]
    fn gzip_of_several_members_and_zlib_are_inflated() {
        let gz = file(&[gzip(&[1, 2, 3]), gzip(&[4])].concat());
        assert_eq!(read(&payload(gz.path(), Encoding::Deflate), [4, 1, 1], 1).unwrap(), [1.0, 2.0, 3.0, 4.0]);
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&[9, 5, 6]).unwrap();
        let zlib = file(&encoder.finish().unwrap());
        let skipping = Payload { byte_skip: ByteSkip::Bytes(1), ..payload(zlib.path(), Encoding::Deflate) };
        assert_eq!(read(&skipping, [2, 1, 1], 1).unwrap(), [5.0, 6.0]);
    }

    #[test]
    fn damaged_and_short_deflated_data_is_refused() {
        let data: Vec<u8> = (0..2000u32).map(|i| (i * i % 251) as u8).collect();
        let whole = gzip(&data);
        let short = file(&whole[..whole.len() / 2]);
        let error = read(&payload(short.path(), Encoding::Deflate), [2000, 1, 1], 1).unwrap_err();
        assert!(matches!(error, ImportError::Truncated { expected: 2000, .. }), "{error}");
        let mut wrong = whole.clone();
        let crc = wrong.len() - 8;
        wrong[crc] ^= 1;
        let wrong = file(&wrong);
        let error = read(&payload(wrong.path(), Encoding::Deflate), [2000, 1, 1], 1).unwrap_err();
        assert!(error.to_string().contains("checksum"), "{error}");
        // A promise that no deflate stream of this size can keep.
        let error = read(&payload(wrong.path(), Encoding::Deflate), [1 << 20, 1 << 10, 64], 1).unwrap_err();
        assert!(error.to_string().contains("cannot hold"), "{error}");
    }

    #[test]
    fn raw_data_is_measured_before_it_is_read() {
        let data = file(&[0; 100]);
        let raw = payload(data.path(), Encoding::Raw);
        let error = read(&raw, [101, 1, 1], 1).unwrap_err();
        assert!(matches!(error, ImportError::Truncated { expected: 101, actual: 100, .. }));
        assert!(read(&raw, [1 << 40, 1, 1], 1).is_err());
        assert!(read(&raw, [usize::MAX, 2, 1], 1).unwrap_err().to_string().contains("impossible"));
        assert!(read(&raw, [0, 2, 1], 1).unwrap_err().to_string().contains("no voxel"));
        assert_eq!(read(&raw, [10, 5, 1], 2).unwrap().len(), 50);
    }

    #[test]
    fn tails_lines_and_several_files() {
        let a = file(b"junk\nmore\n\x01\x02");
        let b = file(b"\n\n\x03\x04tail");
        let lines = Payload {
            files: vec![a.path().to_owned(), b.path().to_owned()],
            line_skip: 2,
            ..payload(a.path(), Encoding::Raw)
        };
        assert_eq!(read(&lines, [2, 2, 1], 1).unwrap(), [1.0, 2.0, 3.0, 4.0]);
        assert!(read(&lines, [3, 1, 1], 1).unwrap_err().to_string().contains("cannot share"));
        let tail = Payload { byte_skip: ByteSkip::Tail, ..payload(a.path(), Encoding::Raw) };
        assert_eq!(read(&tail, [2, 1, 1], 1).unwrap(), [1.0, 2.0]);
        // Of what is inflated, too.
        let gz = file(&gzip(&[9, 9, 9, 5, 6]));
        let tail = Payload { byte_skip: ByteSkip::Tail, ..payload(gz.path(), Encoding::Deflate) };
        assert_eq!(read(&tail, [2, 1, 1], 1).unwrap(), [5.0, 6.0]);
        assert_eq!(read(&tail, [5, 1, 1], 1).unwrap(), [9.0, 9.0, 9.0, 5.0, 6.0]);
        assert!(read(&tail, [6, 1, 1], 1).is_err());
    }

    #[test]
    fn text_is_read_and_nonsense_in_it_is_named() {
        let text = file(b" 1 2,3\n-4 ");
        let numbers = Payload { sample: SampleType::I16, ..payload(text.path(), Encoding::Text) };
        assert_eq!(read(&numbers, [4, 1, 1], 1).unwrap(), [1.0, 2.0, 3.0, -4.0]);
        let text = file(b"1 2 three 4");
        let numbers = Payload { sample: SampleType::F32, ..payload(text.path(), Encoding::Text) };
        let error = read(&numbers, [4, 1, 1], 1).unwrap_err().to_string();
        assert!(error.contains("'three' is no number of type f32"), "{error}");
        let error = read(&numbers, [400, 1, 1], 1).unwrap_err().to_string();
        assert!(error.contains("11 characters"), "{error}");
    }

    #[test]
    fn a_missing_data_file_is_named_with_its_header() {
        let error = read(&payload(Path::new("/nowhere/data.raw"), Encoding::Raw), [1, 1, 1], 1).unwrap_err();
        assert!(error.to_string().starts_with("scan.hdr: the data file '/nowhere/data.raw' is not there"));
    }

    #[test]
    fn cancelling_stops_it() {
        let data = file(&[0; 10]);
        let cancel = CancelToken::new();
        cancel.cancel();
        let result = Samples::from(payload(data.path(), Encoding::Raw)).read(
            data.path(),
            [10, 1, 1],
            1,
            (0, 0..10),
            Progress::SILENT,
            &cancel,
        );
        assert!(matches!(result, Err(ImportError::Cancelled(_))));
    }
}
