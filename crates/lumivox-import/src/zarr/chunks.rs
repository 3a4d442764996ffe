//! Chunks of an array: one file for each, compressed, and none where nothing was written.

use super::{
    blosc,
    streams::{read, zlib, zstd},
};

/// How chunks are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Blosc,
    Gzip,
    Zlib,
    Zstd,
    /// With its length before it, as numcodecs writes it.
    Lz4,
}

impl Compression {
    /// By the names of Zarr 2 and 3.
    pub(super) fn of_name(name: &str) -> Option<Self> {
        Some(match name {
            "blosc" => Self::Blosc,
            "gzip" => Self::Gzip,
            "zlib" | "numcodecs.zlib" => Self::Zlib,
            "zstd" | "numcodecs.zstd" => Self::Zstd,
            "lz4" | "numcodecs.lz4" => Self::Lz4,
            _ => return None,
        })
    }

    /// The bytes of a chunk, `wanted` of them.
    ///
    /// # Errors
    /// Says what is wrong, as a verb phrase.
    pub(super) fn decode(self, file: Vec<u8>, wanted: usize) -> Result<Vec<u8>, String> {
        let bytes = match self {
            Self::None => file,
            Self::Blosc => blosc::decode(&file, wanted)?,
            Self::Gzip => read(flate2::read::MultiGzDecoder::new(&file[..]), wanted)?,
            Self::Zlib => zlib(&file, wanted)?,
            Self::Zstd => zstd(&file, wanted)?,
            Self::Lz4 => blosc::lz4(file.get(4..).unwrap_or_default(), wanted)?,
        };
        if bytes.len() != wanted {
            return Err(format!("holds {} bytes where {wanted} belong", bytes.len()));
        }
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn chunks_are_as_long_as_they_must_be() {
        let data = [5u8; 300];
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gzip.write_all(&data).unwrap();
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        zlib.write_all(&data).unwrap();
        let zstd =
            ruzstd::encoding::compress_to_vec(&data[..], ruzstd::encoding::CompressionLevel::Uncompressed);
        let lz4 = [&300u32.to_le_bytes()[..], &lz4_flex::block::compress(&data)].concat();
        for (compression, packed) in [
            (Compression::None, data.to_vec()),
            (Compression::Gzip, gzip.finish().unwrap()),
            (Compression::Zlib, zlib.finish().unwrap()),
            (Compression::Zstd, zstd),
            (Compression::Lz4, lz4),
        ] {
            assert_eq!(compression.decode(packed.clone(), 300).unwrap(), data, "{compression:?}");
            for wanted in [299, 301] {
                assert!(compression.decode(packed.clone(), wanted).is_err(), "{compression:?} {wanted}");
            }
            for end in 0..packed.len() {
                let _ = compression.decode(packed[..end].to_vec(), 300);
            }
        }
    }
}
