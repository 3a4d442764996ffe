//! Where the bytes of a DICOM file come from: a file, one that stays gzipped, or an entry of a zip archive that stays
//! zipped.

use std::{
    io::{self, BufReader, Read, Seek, SeekFrom},
    path::{Path, PathBuf},
    sync::Arc,
};

use flate2::{Crc, bufread::MultiGzDecoder, read::DeflateDecoder};
use lumivox_core::CancelToken;

use crate::ImportError;
use crate::files::File;

/// Read at a time while a header is walked: few headers are longer.
pub(crate) const BUFFER: usize = 16 << 10;
/// Read at most between two looks at the cancel token.
pub(crate) const CHUNK: usize = 1 << 20;
/// Deflated data may always grow to this size, and beyond it to [`INFLATION`] times its own. A real scan stays far
/// below; a bomb grows 1000 times.
const INFLATED_AT_LEAST: u64 = 64 << 20;
const INFLATION: u64 = 64;

/// The most bytes that `compressed` bytes of deflated data may grow to.
pub(crate) fn inflation_limit(compressed: u64) -> u64 {
    INFLATED_AT_LEAST.saturating_add(compressed.saturating_mul(INFLATION))
}

/// A place that a DICOM file can be read from, again and again and from several threads.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    /// A file of its own.
    File(PathBuf),
    /// A gzip file of one.
    Gzip {
        path: PathBuf,
        /// Its size when unpacked.
        size: u64,
    },
    /// An entry of a zip archive.
    Entry {
        /// The archive.
        archive: Arc<Path>,
        /// The entry's path in the archive.
        name: String,
        /// Where its data start in the archive.
        start: u64,
        /// Its size in the archive.
        compressed: u64,
        /// Its size when unpacked, as the archive says.
        size: u64,
        /// Deflated, or stored as it is.
        deflated: bool,
        /// The checksum of what it is when unpacked, as the archive says.
        crc: u32,
    },
}

impl Source {
    /// The path shown to people; for an entry, the archive's with the entry's appended.
    pub(crate) fn path(&self) -> PathBuf {
        match self {
            Source::File(path) | Source::Gzip { path, .. } => path.clone(),
            Source::Entry { archive, name, .. } => archive.join(name),
        }
    }

    /// Opens it at its first byte, to be read until `cancel` is cancelled.
    pub(crate) fn open_cancellable(&self, cancel: &CancelToken) -> io::Result<Input> {
        Ok(Input { cancel: cancel.clone(), ..self.open()? })
    }

    /// Opens it at its first byte.
    pub(crate) fn open(&self) -> io::Result<Input> {
        match self {
            Source::File(path) => {
                let file = File::open(path)?;
                let length = Some(file.length()?);
                let reader = Reader::File(BufReader::with_capacity(BUFFER, file));
                Ok(Input { reader, position: 0, length, cancel: CancelToken::new() })
            }
            Source::Gzip { path, size } => {
                // The decoder compares the checksums, the last one behind the last byte.
                let unpacked = MultiGzDecoder::new(BufReader::with_capacity(BUFFER, File::open(path)?));
                let unpacked = unpacked.take(size.saturating_add(1));
                let reader = Reader::Stream(Box::new(BufReader::with_capacity(BUFFER, unpacked)));
                Ok(Input { reader, position: 0, length: Some(*size), cancel: CancelToken::new() })
            }
            Source::Entry { archive, start, compressed, size, deflated, crc, .. } => {
                let mut file = File::open(archive)?;
                file.seek(SeekFrom::Start(*start))?;
                let data = file.take(*compressed);
                let unpacked: Box<dyn Read + Send> =
                    if *deflated { Box::new(DeflateDecoder::new(data).take(*size)) } else { Box::new(data) };
                let checked = Checked { inner: unpacked, left: *size, sum: Crc::new(), expected: *crc };
                let reader = Reader::Stream(Box::new(BufReader::with_capacity(BUFFER, checked)));
                Ok(Input { reader, position: 0, length: Some(*size), cancel: CancelToken::new() })
            }
        }
    }
}

/// An open [`Source`] that knows where it is.
pub(crate) struct Input {
    reader: Reader,
    position: u64,
    /// `None` for an inflated data set, whose length shows at its end.
    length: Option<u64>,
    cancel: CancelToken,
}

enum Reader {
    File(BufReader<File>),
    Stream(Box<dyn Read + Send>),
}

impl Input {
    /// Bytes read or skipped so far.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// Bytes still to come, where that is known.
    pub(crate) fn remaining(&self) -> Option<u64> {
        self.length.map(|length| length.saturating_sub(self.position))
    }

    /// Fills `buffer` as far as there are bytes, and says how far.
    pub(crate) fn read_up_to(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut filled = 0;
        while filled < buffer.len() {
            self.check()?;
            let end = buffer.len().min(filled + CHUNK);
            let result = match &mut self.reader {
                Reader::File(reader) => reader.read(&mut buffer[filled..end]),
                Reader::Stream(reader) => reader.read(&mut buffer[filled..end]),
            };
            match result {
                Ok(0) => break,
                Ok(n) => filled += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
        self.position += filled as u64;
        Ok(filled)
    }

    /// Fills `buffer`; an early end is [`io::ErrorKind::UnexpectedEof`].
    pub(crate) fn read_exact(&mut self, buffer: &mut [u8]) -> io::Result<()> {
        if self.read_up_to(buffer)? < buffer.len() {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(())
    }

    /// Reads `length` bytes without ever holding more memory than there are bytes.
    pub(crate) fn read_vec(&mut self, length: u64) -> io::Result<Vec<u8>> {
        if self.remaining().is_some_and(|remaining| length > remaining) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let mut bytes = Vec::new();
        while (bytes.len() as u64) < length {
            self.check()?;
            let step = (length - bytes.len() as u64).min(CHUNK as u64);
            let taken = match &mut self.reader {
                Reader::File(reader) => reader.take(step).read_to_end(&mut bytes)?,
                Reader::Stream(reader) => reader.take(step).read_to_end(&mut bytes)?,
            };
            self.position += taken as u64;
            if (taken as u64) < step {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
        }
        Ok(bytes)
    }

    /// Steps over `length` bytes; an early end is [`io::ErrorKind::UnexpectedEof`].
    pub(crate) fn skip(&mut self, length: u64) -> io::Result<()> {
        if self.remaining().is_some_and(|remaining| length > remaining) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        match &mut self.reader {
            Reader::File(reader) => {
                let step = i64::try_from(length).map_err(|_| io::ErrorKind::UnexpectedEof)?;
                reader.seek_relative(step)?;
            }
            Reader::Stream(reader) => {
                let mut left = length;
                while left > 0 {
                    check(&self.cancel)?;
                    let step = left.min(CHUNK as u64);
                    if io::copy(&mut reader.take(step), &mut io::sink())? < step {
                        return Err(io::ErrorKind::UnexpectedEof.into());
                    }
                    left -= step;
                }
            }
        }
        self.position += length;
        Ok(())
    }

    fn check(&self) -> io::Result<()> {
        check(&self.cancel)
    }

    /// Reads an entry of an archive to its end, where its checksum is compared.
    pub(crate) fn finish(&mut self) -> io::Result<()> {
        let (Reader::Stream(reader), Some(length)) = (&mut self.reader, self.length) else { return Ok(()) };
        loop {
            check(&self.cancel)?;
            match io::copy(&mut reader.take(CHUNK as u64), &mut io::sink())? {
                0 => break,
                taken => self.position += taken,
            }
        }
        if self.position > length {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "it is longer than it says at its end"));
        }
        Ok(())
    }

    /// `prefix` and what follows, inflated (Deflated Explicit VR Little Endian), as an input that starts at 0.
    pub(crate) fn inflate(self, prefix: Vec<u8>) -> Self {
        let left = inflation_limit(self.remaining().unwrap_or(0));
        let deflated: Box<dyn Read + Send> = match self.reader {
            Reader::File(reader) => Box::new(io::Cursor::new(prefix).chain(reader)),
            Reader::Stream(reader) => Box::new(io::Cursor::new(prefix).chain(reader)),
        };
        let inflated = Limited { inner: DeflateDecoder::new(deflated), left };
        let reader = Reader::Stream(Box::new(BufReader::with_capacity(BUFFER, inflated)));
        Self { reader, position: 0, length: None, cancel: self.cancel }
    }
}

/// Fails once the work was cancelled. What failed so is never told: who cancels hears of nothing else.
pub(crate) fn check(cancel: &CancelToken) -> io::Result<()> {
    cancel.check().map_err(io::Error::other)
}

/// Fails once more than `left` bytes were read, where [`Read::take`] would look like an early end.
struct Limited<R> {
    inner: R,
    left: u64,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.left = self
            .left
            .checked_sub(n as u64)
            .ok_or_else(|| io::Error::other("the deflated data set grows beyond any scan's size"))?;
        Ok(n)
    }
}

/// Fails where the last of `left` bytes is read and the checksum of all is not the expected one.
struct Checked<R> {
    inner: R,
    left: u64,
    sum: Crc,
    expected: u32,
}

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.sum.update(&buffer[..n]);
        self.left = self.left.saturating_sub(n as u64);
        if self.left == 0 && self.sum.sum() != self.expected {
            let problem = "its checksum is not the one in the archive";
            return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
        }
        Ok(n)
    }
}

/// What a zip archive holds.
#[derive(Debug, Default)]
pub(crate) struct ZipEntries {
    /// Entries that may be DICOM files.
    pub(crate) sources: Vec<Source>,
    /// Entries left out, with the reason.
    pub(crate) skipped: Vec<(PathBuf, String)>,
}

/// Lists the entries of a zip archive, without unpacking anything.
///
/// # Errors
/// When the file cannot be read, or is no archive.
pub(crate) fn zip_entries(path: &Path) -> Result<ZipEntries, ImportError> {
    let damaged = |e: zip::result::ZipError| ImportError::Damaged {
        path: path.to_owned(),
        problem: format!("is not a zip archive that can be read ({e})"),
    };
    let mut file = File::open(path).map_err(ImportError::io(path))?;
    let listed = listed_entries(&mut file).map_err(ImportError::io(path))?;
    let mut archive = zip::ZipArchive::new(BufReader::new(file)).map_err(damaged)?;
    let shared: Arc<Path> = path.into();
    let ZipEntries { mut sources, mut skipped } = ZipEntries::default();
    // Of entries with one name the last is found.
    if let Some(lost @ 1..) = listed.and_then(|listed| listed.checked_sub(archive.len())) {
        skipped.push((path.to_owned(), format!("{lost} entries of the archive have the names of others")));
    }
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(damaged)?;
        let name = entry.name().map(|name| name.into_owned()).unwrap_or_else(|_| format!("entry {index}"));
        if entry.is_dir() || name.split('/').any(is_junk) {
            continue;
        }
        let deflated = match entry.compression() {
            zip::CompressionMethod::Stored => false,
            zip::CompressionMethod::Deflated => true,
            other => {
                skipped.push((path.join(&name), format!("packed with {other}, not deflate")));
                continue;
            }
        };
        let (compressed, size) = (entry.compressed_size(), entry.size());
        if entry.encrypted() {
            skipped.push((path.join(&name), "encrypted with a password".to_owned()));
        } else if size > inflation_limit(compressed) || (!deflated && size != compressed) {
            skipped.push((path.join(&name), "a damaged entry of the archive".to_owned()));
        } else if let Some(start) = entry.data_start() {
            let (archive, crc) = (shared.clone(), entry.crc32());
            sources.push(Source::Entry { archive, name, start, compressed, size, deflated, crc });
        }
    }
    Ok(ZipEntries { sources, skipped })
}

/// How many entries the end of a zip archive says that it lists, where that is no more than 16 bits can say.
fn listed_entries(file: &mut File) -> io::Result<Option<usize>> {
    /// The end record, and the longest comment behind it.
    const LONGEST: u64 = 22 + 65535;
    let length = file.length()?;
    file.seek(SeekFrom::Start(length.saturating_sub(LONGEST)))?;
    let mut end = Vec::new();
    file.take(LONGEST).read_to_end(&mut end)?;
    file.rewind()?;
    let record = end.windows(22).rev().find(|record| record.starts_with(b"PK\x05\x06"));
    Ok(record
        .map(|record| u16::from_le_bytes([record[10], record[11]]))
        .filter(|n| *n < u16::MAX)
        .map(usize::from))
}

/// Whether a file or folder of this name is left by an operating system, not a part of a study.
pub(crate) fn is_junk(name: &str) -> bool {
    let is_hidden = name.starts_with('.') && name != "." && name != "..";
    name == "__MACOSX" || is_hidden || name.eq_ignore_ascii_case("Thumbs.db")
}
