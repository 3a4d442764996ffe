//! The types of samples that files hold, and their way into [`Voxels`].
//!
//! 8- and 16-bit integers stay what they are; signed ones are shifted into the unsigned range, with the shift in the
//! intercept. Wider types become 16-bit where that loses nothing, 32-bit floats otherwise.

use std::{collections::TryReserveError, fmt, str::FromStr};

use lumivox_core::{Voxels, fill};

/// The type of one stored sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleType {
    /// 8-bit unsigned integer.
    U8,
    /// 8-bit signed integer.
    I8,
    /// 16-bit unsigned integer.
    U16,
    /// 16-bit signed integer.
    I16,
    /// 32-bit unsigned integer.
    U32,
    /// 32-bit signed integer.
    I32,
    /// 64-bit unsigned integer.
    U64,
    /// 64-bit signed integer.
    I64,
    /// 32-bit float.
    F32,
    /// 64-bit float.
    F64,
}

/// A name that is no [`SampleType`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no sample type; it is one of u8, i8, u16, i16, u32, i32, u64, i64, f32, f64")]
pub struct UnknownSampleType(pub String);

impl SampleType {
    /// Bytes of one sample.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    pub(crate) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

impl fmt::Display for SampleType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F32 => "f32",
            Self::F64 => "f64",
        })
    }
}

impl FromStr for SampleType {
    type Err = UnknownSampleType;

    /// Knows Rust's and NumPy's names (`i16`, `int16`) and C's as NRRD spells them (`unsigned short`).
    fn from_str(name: &str) -> Result<Self, UnknownSampleType> {
        let words: Vec<_> = name.split_whitespace().map(str::to_ascii_lowercase).collect();
        Ok(match words.join(" ").as_str() {
            "u8" | "uint8" | "uint8_t" | "uchar" | "unsigned char" | "byte" => Self::U8,
            "i8" | "int8" | "int8_t" | "signed char" => Self::I8,
            "u16" | "uint16" | "uint16_t" | "ushort" | "unsigned short" | "unsigned short int" => Self::U16,
            "i16" | "int16" | "int16_t" | "short" | "short int" | "signed short" | "signed short int" => {
                Self::I16
            }
            "u32" | "uint32" | "uint32_t" | "uint" | "unsigned int" => Self::U32,
            "i32" | "int32" | "int32_t" | "int" | "signed int" => Self::I32,
            "u64" | "uint64" | "uint64_t" | "ulonglong" | "unsigned long long" | "unsigned long long int" => {
                Self::U64
            }
            "i64"
            | "int64"
            | "int64_t"
            | "longlong"
            | "long long"
            | "long long int"
            | "signed long long"
            | "signed long long int" => Self::I64,
            "f32" | "float32" | "float" => Self::F32,
            "f64" | "float64" | "double" => Self::F64,
            _ => return Err(UnknownSampleType(name.to_owned())),
        })
    }
}

/// The samples of a file as a volume takes them.
#[derive(Debug)]
pub(crate) struct Decoded {
    pub voxels: Voxels,
    /// Slope and intercept that give back the file's own numbers.
    pub rescale: [f64; 2],
    /// Whether every number in the file was an integer.
    pub integral: bool,
    pub notes: Vec<String>,
}

/// Collects samples as they are read.
pub(crate) struct VoxelBuilder {
    sample: SampleType,
    big_endian: bool,
    store: Store,
}

enum Store {
    U8(Vec<u8>),
    U16(Vec<u16>),
    Wide(Wide),
}

/// Samples of more than 16 bits, and what is known of them so far.
struct Wide {
    samples: Vec<f32>,
    /// Range of the finite samples.
    range: [f32; 2],
    /// Whether all finite samples are integers that a float holds exactly.
    integral: bool,
    /// Samples that a 32-bit float rounds.
    rounded: u64,
    not_finite: u64,
}

impl VoxelBuilder {
    /// Makes room for `count` samples.
    pub fn new(sample: SampleType, big_endian: bool, count: usize) -> Result<Self, TryReserveError> {
        fn room<T>(count: usize) -> Result<Vec<T>, TryReserveError> {
            let mut samples = Vec::new();
            samples.try_reserve_exact(count)?;
            Ok(samples)
        }
        let store = match sample.bytes() {
            1 => Store::U8(room(count)?),
            2 => Store::U16(room(count)?),
            _ => Store::Wide(Wide {
                samples: room(count)?,
                range: [f32::INFINITY, f32::NEG_INFINITY],
                integral: true,
                rounded: 0,
                not_finite: 0,
            }),
        };
        Ok(Self { sample, big_endian, store })
    }

    /// Appends whole samples.
    pub fn push(&mut self, bytes: &[u8]) {
        let be = self.big_endian;
        match (&mut self.store, self.sample) {
            (Store::U8(samples), SampleType::I8) => samples.extend(bytes.iter().map(|b| b ^ 0x80)),
            (Store::U8(samples), _) => samples.extend_from_slice(bytes),
            (Store::U16(samples), sample) => {
                // Flipping the sign bit adds 32768.
                let flip = if sample == SampleType::I16 { 0x8000 } else { 0 };
                let read = if be { u16::from_be_bytes } else { u16::from_le_bytes };
                samples.extend(bytes.as_chunks().0.iter().map(|b| read(*b) ^ flip));
            }
            (Store::Wide(wide), SampleType::U32) => wide.push(bytes, be, |b| u32::from_le_bytes(b) as f64),
            (Store::Wide(wide), SampleType::I32) => wide.push(bytes, be, |b| i32::from_le_bytes(b) as f64),
            (Store::Wide(wide), SampleType::U64) => wide.push(bytes, be, |b| u64::from_le_bytes(b) as f64),
            (Store::Wide(wide), SampleType::I64) => wide.push(bytes, be, |b| i64::from_le_bytes(b) as f64),
            (Store::Wide(wide), SampleType::F64) => wide.push(bytes, be, f64::from_le_bytes),
            (Store::Wide(wide), _) => wide.push(bytes, be, |b| f32::from_le_bytes(b) as f64),
        }
    }

    /// The samples, or `None` when not one is a number.
    pub fn finish(self) -> Option<Decoded> {
        let narrow = |mut voxels: Voxels, offset| {
            let notes = replace_fill(&mut voxels, offset);
            Decoded { voxels, rescale: [1.0, offset], integral: true, notes }
        };
        Some(match (self.store, self.sample) {
            (Store::U8(samples), SampleType::I8) => narrow(Voxels::U8(samples), -128.0),
            (Store::U8(samples), _) => narrow(Voxels::U8(samples), 0.0),
            (Store::U16(samples), SampleType::I16) => narrow(Voxels::U16(samples), -32768.0),
            (Store::U16(samples), _) => narrow(Voxels::U16(samples), 0.0),
            (Store::Wide(wide), sample) => return wide.finish(sample),
        })
    }
}

/// Replaces fill values of samples whose own number is `offset` more; says so.
fn replace_fill(voxels: &mut Voxels, offset: f64) -> Vec<String> {
    let count = voxels.len();
    fill::replace(voxels, [1.0, offset], None).iter().map(|fill| fill.note(count)).collect()
}

/// One of so many samples that are infinite is enough to be a fill value, but for a few.
const FREQUENT: usize = 1000;
const LEAST_FREQUENT: usize = 8;

impl Wide {
    fn push<const N: usize>(&mut self, bytes: &[u8], big_endian: bool, read: impl Fn([u8; N]) -> f64) {
        for chunk in bytes.as_chunks::<N>().0 {
            let mut chunk = *chunk;
            if big_endian {
                chunk.reverse();
            }
            let exact = read(chunk);
            let sample = exact as f32;
            if sample.is_finite() {
                self.range = [self.range[0].min(sample), self.range[1].max(sample)];
                let kept = sample as f64 == exact;
                self.rounded += u64::from(!kept);
                self.integral &= kept && sample.fract() == 0.0;
            } else {
                self.not_finite += 1;
            }
            self.samples.push(sample);
        }
    }

    fn finish(mut self, sample: SampleType) -> Option<Decoded> {
        if self.range[0] > self.range[1] {
            return None;
        }
        // Before the range is known, which says what 16 bits can hold.
        let mut voxels = Voxels::F32(self.samples);
        let mut notes = replace_fill(&mut voxels, 0.0);
        let Voxels::F32(mut samples) = voxels else { unreachable!("they stay what they are") };
        let finite = || samples.iter().copied().filter(|sample| sample.is_finite());
        let [min, max] = if notes.is_empty() {
            self.range
        } else {
            self.integral = finite().all(|sample| sample.fract() == 0.0);
            finite().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], s| [low.min(s), high.max(s)])
        };
        if self.not_finite > 0 {
            let infinite = samples.iter().filter(|sample| **sample == f32::INFINITY).count();
            // A few are off the scale, many stand for nothing.
            let is_fill = infinite >= LEAST_FREQUENT && infinite * FREQUENT > samples.len();
            // In a map that goes to both sides of it, 0 is nothing.
            let nothing = fill::nothing(&samples).filter(|nothing| *nothing == 0.0);
            let lowest = nothing.map_or(min, |nothing| nothing as f32);
            let fix = |s: f32| if s == f32::INFINITY && !is_fill { max } else { lowest };
            samples.iter_mut().filter(|s| !s.is_finite()).for_each(|s| *s = fix(*s));
            let largest = if infinite > 0 && !is_fill { " (infinity: the largest)" } else { "" };
            let became = match nothing {
                Some(_) => format!("0{largest}, the middle of a map that goes to both sides of it"),
                None => format!("the smallest{largest} of the others"),
            };
            notes.push(format!(
                "{} of {} samples are NaN, infinite or too large and became {became}",
                self.not_finite,
                samples.len()
            ));
        }
        if self.rounded > 0 && sample.is_integer() {
            notes.push(format!("{} large integers were rounded to 32-bit floats", self.rounded));
        }
        let integral = self.integral || sample.is_integer();
        if self.integral && (max as f64 - min as f64) <= u16::MAX as f64 {
            let voxels = samples.iter().map(|s| (s - min) as u16).collect();
            return Some(Decoded {
                voxels: Voxels::U16(voxels),
                rescale: [1.0, min as f64],
                integral,
                notes,
            });
        }
        Some(Decoded { voxels: Voxels::F32(samples), rescale: [1.0, 0.0], integral, notes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The file's numbers after a way through [`Voxels`].
    fn through(sample: SampleType, big_endian: bool, bytes: &[u8]) -> (Voxels, Vec<f64>) {
        let mut builder = VoxelBuilder::new(sample, big_endian, bytes.len() / sample.bytes()).unwrap();
        builder.push(bytes);
        let decoded = builder.finish().unwrap();
        let [slope, intercept] = decoded.rescale;
        let values = (0..decoded.voxels.len()).map(|i| decoded.voxels.get(i) * slope + intercept).collect();
        (decoded.voxels, values)
    }

    #[test]
    fn every_type_keeps_its_values_in_both_byte_orders() {
        macro_rules! check {
            ($variant:ident, $type:ty, $values:expr) => {
                let values: &[$type] = &$values;
                let expected: Vec<f64> = values.iter().map(|&v| v as f64).collect();
                let le: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
                let be: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
                assert_eq!(through(SampleType::$variant, false, &le).1, expected);
                assert_eq!(through(SampleType::$variant, true, &be).1, expected);
                assert_eq!(stringify!($type).parse(), Ok(SampleType::$variant));
                assert_eq!(SampleType::$variant.to_string(), stringify!($type));
                assert_eq!(SampleType::$variant.bytes(), size_of::<$type>());
            };
        }
        check!(U8, u8, [0, 1, 255]);
        check!(I8, i8, [i8::MIN, -1, 0, i8::MAX]);
        check!(U16, u16, [0, 258, u16::MAX]);
        check!(I16, i16, [i16::MIN, -1000, 0, 258, i16::MAX]);
        check!(U32, u32, [70_000, 70_001, 80_000]);
        check!(I32, i32, [-70_000, 0, 70_000]);
        check!(U64, u64, [5, 6, 1 << 20]);
        check!(I64, i64, [-5, 6, -(1 << 40)]);
        check!(F32, f32, [-0.5, 0.25, 1e30]);
        check!(F64, f64, [-0.5, 0.25, 4096.125]);
    }

    #[test]
    fn wide_integers_of_a_narrow_range_become_16_bit() {
        let bytes: Vec<u8> = [-1024.0f64, 0.0, 3071.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let (voxels, values) = through(SampleType::F64, false, &bytes);
        assert_eq!(voxels, Voxels::U16(vec![0, 1024, 4095]));
        assert_eq!(values, [-1024.0, 0.0, 3071.0]);
    }

    #[test]
    fn what_is_no_number_becomes_the_nearest_end_and_is_told() {
        let samples = [f32::NAN, 0.5, f32::INFINITY, 7.0, f32::NEG_INFINITY];
        let bytes: Vec<u8> = samples.iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut builder = VoxelBuilder::new(SampleType::F32, false, 5).unwrap();
        builder.push(&bytes);
        let decoded = builder.finish().unwrap();
        assert_eq!(decoded.voxels, Voxels::F32(vec![0.5, 0.5, 7.0, 7.0, 0.5]));
        assert!(decoded.notes[0].starts_with("3 of 5 samples"), "{:?}", decoded.notes);

        let mut builder = VoxelBuilder::new(SampleType::F32, false, 1).unwrap();
        builder.push(&f32::NAN.to_le_bytes());
        assert!(builder.finish().is_none());
    }

    #[test]
    fn what_is_no_number_around_a_signed_map_is_nothing() {
        let decode = |value: &dyn Fn(usize) -> f32| {
            let bytes: Vec<u8> = (0..3000).flat_map(|i| value(i).to_le_bytes()).collect();
            let mut builder = VoxelBuilder::new(SampleType::F32, false, 3000).unwrap();
            builder.push(&bytes);
            builder.finish().unwrap()
        };
        let map = |i: usize| (i * 37 % 900) as f32 / 100.0 - 4.003;
        let decoded = decode(&|i| if i.is_multiple_of(3) { f32::NAN } else { map(i) });
        assert_eq!(decoded.voxels.get(0), 0.0);
        assert!(decoded.notes[0].contains("became 0"), "{:?}", decoded.notes);
        // Of integers, too; a scan has its lowest there.
        let decoded = decode(&|i| if i.is_multiple_of(3) { f32::NAN } else { (i * 37 % 90) as f32 - 45.0 });
        assert_eq!(decoded.voxels.get(0) + decoded.rescale[1], 0.0);
        let decoded = decode(&|i| if i.is_multiple_of(3) { f32::NAN } else { 7.0 + (i * 37 % 90) as f32 });
        assert_eq!(decoded.voxels.get(0) + decoded.rescale[1], 8.0, "the lowest of the others");
        let ct = |i: usize| (i * 37 % 2000) as f32 - 1000.0;
        let decoded = decode(&|i| if i.is_multiple_of(3) { f32::NAN } else { ct(i) });
        assert!(decoded.voxels.get(0) + decoded.rescale[1] < -990.0);
    }

    #[test]
    fn fill_values_do_not_stretch_the_range() {
        let decode = |sample: SampleType, bytes: Vec<u8>| {
            let mut builder = VoxelBuilder::new(sample, false, bytes.len() / sample.bytes()).unwrap();
            builder.push(&bytes);
            builder.finish().unwrap()
        };
        let value = |i: usize| (i * 37 % 900) as f64;
        let is_fill = |i: usize| i.is_multiple_of(9);
        let lowest = (0..3000).filter(|i| !is_fill(*i)).map(value).fold(f64::INFINITY, f64::min);
        for fill in [f64::MIN, -3.4e38, -1e20, -9999.0, f64::INFINITY] {
            let bytes = (0..3000).flat_map(|i| if is_fill(i) { fill } else { value(i) }.to_le_bytes());
            let decoded = decode(SampleType::F64, bytes.collect());
            assert!(matches!(decoded.voxels, Voxels::U16(_)), "{fill} of integers in 16 bits");
            assert_eq!((decoded.rescale, decoded.voxels.get(0)), ([1.0, lowest], 0.0), "{fill}");
            assert_eq!(decoded.notes.len(), 1, "{fill}: {:?}", decoded.notes);
        }
        let bytes = (0..3000).flat_map(|i| if is_fill(i) { -9999 } else { value(i) as i16 }.to_le_bytes());
        let decoded = decode(SampleType::I16, bytes.collect());
        assert_eq!(decoded.voxels.get(0) + decoded.rescale[1], lowest);
        assert!(decoded.notes[0].contains("the fill value -9999"), "{:?}", decoded.notes);
    }

    #[test]
    fn absurd_counts_are_an_error_not_an_abort() {
        assert!(VoxelBuilder::new(SampleType::U16, false, usize::MAX / 4).is_err());
    }
}
