//! JPEG baseline, extended and lossless.

use jpeg_decoder::PixelFormat::{L8, L16};

use super::{CodecFault, Decoded, FrameShape, jpeg_extended, jpeg_info, little_endian_16};

pub(super) fn decode(stream: &[u8], format: &FrameShape) -> Result<Decoded, CodecFault> {
    let info = jpeg_info(stream).ok_or("has a JPEG stream without a frame header")?;
    info.check(format)?;
    if info.precision == 12 && matches!(info.marker, 0xFFC0 | 0xFFC1) {
        let samples = jpeg_extended::decode(stream, format.columns, format.rows)?;
        return Ok(Decoded { samples: samples.iter().flat_map(|s| s.to_le_bytes()).collect(), bytes: 2 });
    }
    let mut decoder = jpeg_decoder::Decoder::new(stream);
    decoder.set_max_decoding_buffer_size(format.columns * format.rows * 2);
    let samples = decoder.decode().map_err(|e| match e {
        jpeg_decoder::Error::Unsupported(_) => {
            CodecFault::Unsupported(format!("it is compressed as JPEG of {} bits", info.precision))
        }
        e => CodecFault::Damaged(format!("has a damaged JPEG stream ({e})")),
    })?;
    match decoder.info().map(|info| info.pixel_format) {
        Some(L8) => Ok(Decoded { samples, bytes: 1 }),
        Some(L16) => Ok(Decoded { samples: little_endian_16(samples), bytes: 2 }),
        _ => Err("has a JPEG stream in colour".into()),
    }
}
