//! Samples that a codec gives more bits than are stored (BitsStored): lossy compression overshoots at edges, so that they
//! are numbers just beyond the range. They are clamped to it. Masked, the brightest would become the darkest.

use crate::{
    codec::{Decoded, precision},
    dicom::header::pixel_format::{PixelFormat, SampleKind},
};

/// How decoded samples become stored values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Overshoot {
    /// The sign's bit in a raw sample; 0 where there is none.
    sign: u32,
    /// The bits of a raw sample that count.
    mask: u32,
    /// What may be stored.
    lowest: i64,
    highest: i64,
}

impl Overshoot {
    /// What the samples of a frame need; `None` where they are the stored bits.
    pub(crate) fn of(format: &PixelFormat, stream: &[u8], decoded: &Decoded) -> Option<Self> {
        let stored = format.bits_stored;
        let is_shifted = format.high_bit + 1 != stored;
        if format.kind == SampleKind::Float || is_shifted || format.has_overlay || stored > 16 {
            return None;
        }
        let (precision, stream_signed) = precision(stream, format.encoding)?;
        let width = 8 * decoded.bytes.min(4) as u32;
        let mask = u32::MAX >> (32 - width);
        let sign = match (stream_signed, format.signed) {
            // Decoders extend the sign to the whole word.
            (true, true) => 1 << (width - 1),
            // The same bits, meant otherwise.
            (true, false) if precision <= stored => return None,
            (true, false) => 1 << (width - 1),
            (false, false) => 0,
            // Words of the stored bits alone are bits; where one has more, they are numbers whose sign reaches to the top.
            (false, true) if precision > stored && has_more(decoded, stored) => {
                1 << (precision.min(width) - 1)
            }
            (false, true) => return None,
        };
        let count = 1i64 << stored;
        let lowest = if format.signed { -count / 2 } else { 0 };
        Some(Self { sign, mask, lowest, highest: lowest + count - 1 })
    }

    /// The stored value of a raw sample.
    #[inline]
    pub(crate) fn clamp(self, raw: u32) -> i64 {
        let bits = raw & self.mask;
        let value = i64::from(bits ^ self.sign) - i64::from(self.sign);
        value.clamp(self.lowest, self.highest)
    }
}

/// Whether a sample has bits above the stored ones.
fn has_more(decoded: &Decoded, stored: u32) -> bool {
    decoded.samples.chunks_exact(decoded.bytes).any(|sample| {
        let mut word = [0; 4];
        word[..sample.len().min(4)].copy_from_slice(&sample[..sample.len().min(4)]);
        u32::from_le_bytes(word) >> stored != 0
    })
}
