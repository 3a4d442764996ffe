//! JPEG-LS, by CharLS.

use super::{Decoded, FrameShape, jpeg_info, little_endian_16};

/// JPEG's marker of the end of an image.
const JPEG_END: [u8; 2] = [0xFF, 0xD9];

/// A stream without the zeros at its end.
fn without_zeros(stream: &[u8]) -> &[u8] {
    let end = stream.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    &stream[..end]
}

pub(super) fn decode(stream: &[u8], format: &FrameShape) -> Result<Decoded, String> {
    let info = jpeg_info(stream).ok_or("has a JPEG-LS stream without a frame header")?;
    info.check(format)?;
    // CharLS 2.4.5 reads on for seconds where a scan ends without a marker: it always meets one.
    let samples_of = |stream: &[u8]| charls::CharLS::default().decode(&[stream, &JPEG_END].concat());
    let samples = samples_of(stream)
        .or_else(|fault| {
            // Some writers make the scan's length even before its end, where padding may only follow.
            let padded = without_zeros(stream).strip_suffix(&JPEG_END).ok_or(fault)?;
            samples_of(without_zeros(padded))
        })
        .map_err(|e| format!("has a damaged JPEG-LS stream ({e})"))?;
    if info.precision <= 8 {
        Ok(Decoded { samples, bytes: 1 })
    } else {
        Ok(Decoded { samples: little_endian_16(samples), bytes: 2 })
    }
}
