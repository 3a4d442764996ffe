//! Gzip files of DICOM files.

use std::{
    io::{self, BufReader, Read, Seek, SeekFrom},
    path::Path,
};

use flate2::bufread::MultiGzDecoder;
use lumivox_core::CancelToken;

use crate::dicom::{
    bytes::source::{BUFFER, CHUNK, Source, check, inflation_limit},
    elements::data_set::is_dicom,
};
use crate::files::File;

/// The least bytes of a gzip file: magic, method, flags, time, system; checksum and size.
const LEAST_GZIP: u64 = 18;

/// Whether a file is a gzip file of a DICOM file, by the first bytes of that.
pub(crate) fn is_gzip_of_dicom(path: &Path) -> io::Result<bool> {
    let compressed = crate::files::metadata(path)?.length();
    let size = inflation_limit(compressed);
    Ok(compressed >= LEAST_GZIP && is_dicom(&Source::Gzip { path: path.to_owned(), size }))
}

/// The source of a gzip file of a DICOM file; `None` of one of something else.
///
/// # Errors
/// When it cannot be read, where it grows beyond any scan's size, and on cancel.
pub(crate) fn gzip(path: &Path, cancel: &CancelToken) -> io::Result<Option<Source>> {
    if !is_gzip_of_dicom(path)? {
        return Ok(None);
    }
    let mut file = File::open(path)?;
    let compressed = file.length()?;
    let limit = inflation_limit(compressed);
    file.seek(SeekFrom::End(-4))?;
    let mut said = [0; 4];
    file.read_exact(&mut said)?;
    let said = u64::from(u32::from_le_bytes(said));
    // Deflate makes nothing much larger; what is said is of the last member only, and anything where a file breaks off.
    let is_believed = (compressed.saturating_sub(LEAST_GZIP) / 2..=limit).contains(&said);
    let size = match is_believed && !may_have_members(&mut file, cancel)? {
        true => said,
        false => unpacked_size(path, limit, cancel)?,
    };
    if size > limit {
        return Err(io::Error::other("it grows beyond any scan's size"));
    }
    Ok(Some(Source::Gzip { path: path.to_owned(), size }))
}

/// Whether what begins a gzip member is found again behind the first one's beginning. In packed data it may be there by
/// chance.
fn may_have_members(file: &mut File, cancel: &CancelToken) -> io::Result<bool> {
    file.seek(SeekFrom::Start(LEAST_GZIP))?;
    let mut buffer = Vec::with_capacity(CHUNK);
    loop {
        check(cancel)?;
        // What a member begins with may lie across two pieces.
        let kept = buffer.len().min(3);
        buffer.drain(..buffer.len() - kept);
        if file.by_ref().take(CHUNK as u64 - kept as u64).read_to_end(&mut buffer)? == 0 {
            return Ok(false);
        }
        // Magic, the only method, and flags of which the upper three are not used.
        if buffer.windows(4).any(|head| head[..3] == [0x1F, 0x8B, 8] && head[3] < 0x20) {
            return Ok(true);
        }
    }
}

/// How many bytes a gzip file unpacks to, as far as it can be; not more than one above `limit`.
fn unpacked_size(path: &Path, limit: u64, cancel: &CancelToken) -> io::Result<u64> {
    let unpacked = MultiGzDecoder::new(BufReader::with_capacity(BUFFER, File::open(path)?));
    let mut unpacked = unpacked.take(limit.saturating_add(1));
    let (mut size, mut buffer) = (0, vec![0; BUFFER]);
    loop {
        check(cancel)?;
        match unpacked.read(&mut buffer) {
            Ok(0) => return Ok(size),
            Ok(n) => size += n as u64,
            Err(e) => match e.kind() {
                io::ErrorKind::Interrupted => {}
                // Who reads its pixels hears of that.
                io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => {
                    return Ok(size);
                }
                _ => return Err(e),
            },
        }
    }
}
