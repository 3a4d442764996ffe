//! JPEG 2000 and High-Throughput JPEG 2000, by OpenJPEG.

use super::{Decoded, FrameShape, jpeg_2000_info};

pub(super) fn decode(stream: &[u8], format: &FrameShape) -> Result<Decoded, String> {
    jpeg_2000_info(stream)?.check(format)?;
    // Strict: a stream that is cut short is an error, not a blurred slice.
    let parameters = jpeg2k::DecodeParameters::new().strict(true);
    let image = jpeg2k::Image::from_bytes_with(stream, parameters)
        .map_err(|e| format!("has a damaged JPEG 2000 stream ({e})"))?;
    let component = image.components().first().ok_or("has an empty JPEG 2000 stream")?;
    if (component.width() as usize, component.height() as usize) != (format.columns, format.rows) {
        return Err("has a subsampled JPEG 2000 stream".to_owned());
    }
    let data = component.data();
    // Never narrower than the file's own samples, since these may have a sign.
    Ok(match component.precision().max(8 * format.bytes as u32) {
        ..=8 => Decoded { samples: data.iter().map(|&s| s as u8).collect(), bytes: 1 },
        9..=16 => {
            Decoded { samples: data.iter().flat_map(|&s| (s as u16).to_le_bytes()).collect(), bytes: 2 }
        }
        _ => Decoded { samples: data.iter().flat_map(|&s| s.to_le_bytes()).collect(), bytes: 4 },
    })
}
