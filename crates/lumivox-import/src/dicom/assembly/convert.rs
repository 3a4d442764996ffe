//! From raw samples to those of a volume: junk bits, signs, padding, tables.

use lumivox_core::Modality;

use crate::dicom::{
    assembly::overshoot::Overshoot,
    frames::frame::Frame,
    header::{modality_lut::ModalityLut, pixel_format::PixelFormat},
};

/// A sample of a volume.
pub(crate) trait Sample: bytemuck::Pod + Default + Send + Sync {
    /// The sample of an integer that already has its offset.
    fn from_integer(integer: i32) -> Self;
    /// The sample that is nearest to a stored value.
    fn from_f64(value: f64) -> Self;
    fn to_f64(self) -> f64;
    /// The sample of a raw one.
    fn convert(raw: u32, conversion: &Conversion<'_>) -> Self {
        Self::from_integer(conversion.integer(raw))
    }
}

impl Sample for u8 {
    fn from_integer(integer: i32) -> Self {
        integer as u8
    }
    fn from_f64(value: f64) -> Self {
        value.round() as u8
    }
    fn to_f64(self) -> f64 {
        self.into()
    }
}

impl Sample for u16 {
    fn from_integer(integer: i32) -> Self {
        integer as u16
    }
    fn from_f64(value: f64) -> Self {
        value.round() as u16
    }
    fn to_f64(self) -> f64 {
        self.into()
    }
}

impl Sample for f32 {
    fn from_integer(integer: i32) -> Self {
        integer as f32
    }
    fn from_f64(value: f64) -> Self {
        (value as f32).clamp(f32::MIN, f32::MAX)
    }
    fn to_f64(self) -> f64 {
        self.into()
    }
    fn convert(raw: u32, conversion: &Conversion<'_>) -> Self {
        let [slope, intercept] = conversion.rescale;
        let value = match conversion.lut {
            Some(lut) => lut.get(conversion.wide(raw)).into(),
            None => conversion.wide(raw) as f64,
        };
        Self::from_f64(value * slope + intercept)
    }
}

/// What one slice's raw samples go through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conversion<'a> {
    /// Bits below the stored ones.
    shift: u32,
    /// The stored bits; what lies above them is junk (old overlays, uncleared memory).
    mask: u32,
    /// The sign bit; 0 if unsigned.
    sign: u32,
    /// MONOCHROME1 without a physical scale: what lowest and highest stored value add up to.
    mirror: Option<i32>,
    /// Added to integers.
    offset: i32,
    /// A table in place of mirror and offset.
    lut: Option<&'a ModalityLut>,
    /// For floating-point samples.
    rescale: [f64; 2],
    /// A floating-point sample that is padding.
    float_padding: Option<f64>,
    /// Stored values that are padding.
    padding: Option<[i64; 2]>,
    /// A raw sample that is padding although it has more bits than are stored.
    raw_padding: Option<u32>,
    /// What becomes of samples that a codec gives more bits than are stored.
    overshoot: Option<Overshoot>,
}

impl<'a> Conversion<'a> {
    pub(crate) fn new(format: &'a PixelFormat, frame: &Frame, offset: i32, modality: Modality) -> Self {
        let shift = format.high_bit + 1 - format.bits_stored;
        let mask = u32::MAX >> (32 - format.bits_stored.min(32));
        let sign = if format.signed { 1 << (format.bits_stored.min(32) - 1) } else { 0 };
        // A CT's values are Hounsfield units whichever way they are shown.
        let mirror = (format.inverted && modality != Modality::Ct && format.bits_stored <= 16)
            .then_some(if format.signed { -1 } else { mask as i32 });
        let mut conversion = Self {
            shift,
            mask,
            sign,
            mirror,
            offset,
            lut: format.lut.as_deref(),
            rescale: frame.rescale,
            float_padding: format.float_padding,
            padding: None,
            raw_padding: None,
            overshoot: None,
        };
        if let Some(raw) = format.padding {
            let values = raw.map(|raw| conversion.wide(raw << shift));
            let bits = u32::MAX >> (32 - 8 * format.bytes.min(4));
            // PixelPaddingValue has the sign of the pixels: as 16 bits or as the stored ones it is the same number.
            let fits = |raw: u32, value: i64| value as u32 & bits & 0xFFFF == raw & bits & 0xFFFF;
            if fits(raw[0], values[0]) && fits(raw[1], values[1]) {
                conversion.padding = Some([values[0].min(values[1]), values[0].max(values[1])]);
            } else {
                conversion.raw_padding = Some(raw[0]);
            }
        }
        conversion
    }

    /// Takes raw samples for numbers that may lie beyond what is stored, and not for bits.
    pub(crate) fn clamped(self, overshoot: Option<Overshoot>) -> Self {
        Self { overshoot, ..self }
    }

    /// The stored value of a raw sample.
    #[inline]
    fn wide(&self, raw: u32) -> i64 {
        if let Some(overshoot) = self.overshoot {
            return overshoot.clamp(raw);
        }
        let bits = (raw >> self.shift) & self.mask;
        i64::from(bits ^ self.sign) - i64::from(self.sign)
    }

    /// The integer to keep of a raw sample of up to 16 stored bits. Cannot overflow: [`Plan`](crate::dicom::series::storage::Plan) has seen to it.
    #[inline]
    fn integer(&self, raw: u32) -> i32 {
        if let Some(lut) = self.lut {
            return i32::from(lut.get(self.wide(raw))).wrapping_add(self.offset);
        }
        let value = match self.overshoot {
            Some(overshoot) => overshoot.clamp(raw) as i32,
            None => {
                let bits = (raw >> self.shift) & self.mask;
                ((bits ^ self.sign) as i32).wrapping_sub(self.sign as i32)
            }
        };
        let value = self.mirror.map_or(value, |sum| sum.wrapping_sub(value));
        value.wrapping_add(self.offset)
    }

    fn has_padding(&self) -> bool {
        self.padding.is_some() || self.raw_padding.is_some()
    }

    fn is_padding(&self, raw: u32) -> bool {
        let value = self.wide(raw);
        self.padding.is_some_and(|[low, high]| (low..=high).contains(&value)) || self.raw_padding == Some(raw)
    }
}

/// What a slice was found to hold.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    /// Samples that measured nothing: first and number.
    pub(crate) padded: Vec<(usize, usize)>,
    /// Lowest and highest other sample, where there is padding.
    pub(crate) range: Option<[f64; 2]>,
}

impl Outcome {
    fn add_padding(&mut self, at: usize) {
        match self.padded.last_mut() {
            Some((first, length)) if *first + *length == at => *length += 1,
            _ => self.padded.push((at, 1)),
        }
    }

    fn add_sample(&mut self, sample: f64) {
        self.range = Some(join(self.range.unwrap_or([sample; 2]), [sample; 2]));
    }
}

/// The range that holds both.
pub(crate) fn join(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// The sample of the lowest value, of samples in this range: the highest one where the slope is negative.
pub(crate) fn of_lowest_value([lowest, highest]: [f64; 2], slope: f64) -> f64 {
    if slope < 0.0 { highest } else { lowest }
}

/// Converts raw integers, each read by `raw` from its index and what lies in `out` there.
pub(crate) fn convert<T: Sample>(
    out: &mut [T],
    conversion: &Conversion<'_>,
    raw: impl Fn(usize, T) -> u32,
) -> Outcome {
    let mut outcome = Outcome::default();
    if !conversion.has_padding() {
        for (i, sample) in out.iter_mut().enumerate() {
            *sample = T::convert(raw(i, *sample), conversion);
        }
        return outcome;
    }
    for (i, sample) in out.iter_mut().enumerate() {
        let raw = raw(i, *sample);
        *sample = T::convert(raw, conversion);
        if conversion.is_padding(raw) {
            outcome.add_padding(i);
        } else {
            outcome.add_sample(sample.to_f64());
        }
    }
    outcome
}

/// Converts a decoded frame of integers with `bytes` bytes each.
pub(crate) fn convert_bytes<T: Sample>(
    out: &mut [T],
    conversion: &Conversion<'_>,
    raw: &[u8],
    bytes: usize,
    big: bool,
) -> Outcome {
    let two = |i: usize| [raw[2 * i], raw[2 * i + 1]];
    let four = |i: usize| [raw[4 * i], raw[4 * i + 1], raw[4 * i + 2], raw[4 * i + 3]];
    match (bytes, big) {
        (1, _) => convert(out, conversion, |i, _| raw[i].into()),
        (2, false) => convert(out, conversion, |i, _| u16::from_le_bytes(two(i)).into()),
        (2, true) => convert(out, conversion, |i, _| u16::from_be_bytes(two(i)).into()),
        (_, false) => convert(out, conversion, |i, _| u32::from_le_bytes(four(i))),
        (_, true) => convert(out, conversion, |i, _| u32::from_be_bytes(four(i))),
    }
}

/// Converts a frame of floating-point samples; those that are no numbers count as padding.
pub(crate) fn convert_floats<T: Sample>(
    out: &mut [T],
    conversion: &Conversion<'_>,
    raw: &[u8],
    bytes: usize,
    big: bool,
) -> Outcome {
    let [slope, intercept] = conversion.rescale;
    let mut outcome = Outcome::default();
    for (i, (sample, raw)) in out.iter_mut().zip(raw.chunks_exact(bytes)).enumerate() {
        let mut long = [0; 8];
        long[..bytes].copy_from_slice(raw);
        if big {
            long[..bytes].reverse();
        }
        let stored = match bytes {
            4 => f32::from_bits(u64::from_le_bytes(long) as u32).into(),
            _ => f64::from_bits(u64::from_le_bytes(long)),
        };
        let value = stored * slope + intercept;
        if value.is_finite() && Some(stored) != conversion.float_padding {
            *sample = T::from_f64(value);
            outcome.add_sample(sample.to_f64());
        } else {
            outcome.add_padding(i);
        }
    }
    outcome
}
