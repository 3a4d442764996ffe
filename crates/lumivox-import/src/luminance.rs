//! Colours to values: red, green and blue of a voxel become its luminance, which is the one number that a transfer function
//! can stand on.

use crate::sample::SampleType;

/// Parts of red, green and blue in luminance (ITU-R BT.709).
const PARTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// What to tell of colours that became values.
pub(crate) const NOTE: &str =
    "colours became their luminance (0.21 red, 0.72 green, 0.07 blue), from 0 to the largest sample";

/// Appends the luminance of whole voxels of `channels` samples each, in the same type and byte order: of two channels the
/// first, which is grey beside its opacity; of more the first three.
pub(crate) fn push(sample: SampleType, big_endian: bool, channels: usize, voxels: &[u8], out: &mut Vec<u8>) {
    let bytes = sample.bytes();
    for voxel in voxels.chunks_exact(channels * bytes) {
        if channels < 3 {
            out.extend_from_slice(&voxel[..bytes]);
            continue;
        }
        let part = |k: usize| read(sample, big_endian, &voxel[k * bytes..][..bytes]);
        let value = PARTS.iter().enumerate().map(|(k, weight)| weight * part(k)).sum();
        write(sample, big_endian, value, out);
    }
}

fn read(sample: SampleType, big_endian: bool, bytes: &[u8]) -> f64 {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    if big_endian {
        wide[..bytes.len()].reverse();
    }
    let [a, b, c, d, ..] = wide;
    match sample {
        SampleType::U8 => a.into(),
        SampleType::I8 => (a as i8).into(),
        SampleType::U16 => u16::from_le_bytes([a, b]).into(),
        SampleType::I16 => i16::from_le_bytes([a, b]).into(),
        SampleType::U32 => u32::from_le_bytes([a, b, c, d]).into(),
        SampleType::I32 => i32::from_le_bytes([a, b, c, d]).into(),
        SampleType::U64 => u64::from_le_bytes(wide) as f64,
        SampleType::I64 => i64::from_le_bytes(wide) as f64,
        SampleType::F32 => f32::from_le_bytes([a, b, c, d]).into(),
        SampleType::F64 => f64::from_le_bytes(wide),
    }
}

fn write(sample: SampleType, big_endian: bool, value: f64, out: &mut Vec<u8>) {
    let from = out.len();
    let rounded = value.round();
    match sample {
        SampleType::U8 => out.push(rounded as u8),
        SampleType::I8 => out.push(rounded as i8 as u8),
        SampleType::U16 => out.extend((rounded as u16).to_le_bytes()),
        SampleType::I16 => out.extend((rounded as i16).to_le_bytes()),
        SampleType::U32 => out.extend((rounded as u32).to_le_bytes()),
        SampleType::I32 => out.extend((rounded as i32).to_le_bytes()),
        SampleType::U64 => out.extend((rounded as u64).to_le_bytes()),
        SampleType::I64 => out.extend((rounded as i64).to_le_bytes()),
        SampleType::F32 => out.extend((value as f32).to_le_bytes()),
        SampleType::F64 => out.extend(value.to_le_bytes()),
    }
    if big_endian {
        out[from..].reverse();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_stays_and_colours_are_as_bright_as_they_look() {
        let of = |channels: usize, voxels: &[u8]| {
            let mut out = Vec::new();
            push(SampleType::U8, false, channels, voxels, &mut out);
            out
        };
        assert_eq!(of(3, &[7, 7, 7, 255, 0, 0, 0, 255, 0, 0, 0, 255, 9]), [7, 54, 182, 18]);
        assert_eq!(of(4, &[255, 255, 255, 0]), [255]);
        assert_eq!(of(2, &[5, 200, 6, 0]), [5, 6]);
        let big: Vec<u8> = [1000u16, 1000, 1000].iter().flat_map(|n| n.to_be_bytes()).collect();
        let mut out = Vec::new();
        push(SampleType::U16, true, 3, &big, &mut out);
        assert_eq!(out, 1000u16.to_be_bytes());
        let floats: Vec<u8> = [1.0f32, 0.0, 0.0].iter().flat_map(|n| n.to_le_bytes()).collect();
        let mut out = Vec::new();
        push(SampleType::F32, false, 3, &floats, &mut out);
        assert_eq!(out, 0.2126f32.to_le_bytes());
    }
}
