//! Compressed streams, read within bounds.

use std::io::Read;

/// Reads what is there, and one byte more than is wanted at most: memory grows with what comes.
pub(super) fn read(input: impl Read, wanted: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let most = (wanted as u64).saturating_add(1);
    input.take(most).read_to_end(&mut bytes).map_err(|fault| format!("is damaged ({fault})"))?;
    Ok(bytes)
}

pub(super) fn zlib(packed: &[u8], wanted: usize) -> Result<Vec<u8>, String> {
    read(flate2::read::ZlibDecoder::new(packed), wanted)
}

pub(super) fn zstd(packed: &[u8], wanted: usize) -> Result<Vec<u8>, String> {
    let decoder = ruzstd::decoding::StreamingDecoder::new(packed)
        .map_err(|fault| format!("has damaged Zstandard data ({fault})"))?;
    read(decoder, wanted)
}
