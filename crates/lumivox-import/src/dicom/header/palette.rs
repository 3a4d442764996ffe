//! The palette of a label map, which says how its segments are best shown (PS3.3 C.7.6.3.1.5).

use crate::dicom::elements::{
    attributes::{self as attr, Attribute},
    data_set::DataSet,
};

/// Descriptors and entries of red, green and blue.
const TABLES: [(Attribute, Attribute); 3] = [
    (attr::RED_PALETTE_DESCRIPTOR, attr::RED_PALETTE_DATA),
    (attr::GREEN_PALETTE_DESCRIPTOR, attr::GREEN_PALETTE_DATA),
    (attr::BLUE_PALETTE_DESCRIPTOR, attr::BLUE_PALETTE_DATA),
];

/// The colour of a stored value as sRGB codes from 0 to 1; `None` where there is no palette, or no entry for it.
pub(crate) fn color(data: &DataSet, value: u32) -> Option<[f64; 3]> {
    let mut codes = [0.0; 3];
    for (code, (descriptor, entries)) in codes.iter_mut().zip(TABLES) {
        *code = part(data, descriptor, entries, value)?;
    }
    Some(codes)
}

fn part(data: &DataSet, descriptor: Attribute, entries: Attribute, value: u32) -> Option<f64> {
    let [count, first, bits]: [u16; 3] = data.words(descriptor)?.try_into().ok()?;
    let count = if count == 0 { 1 << 16 } else { usize::from(count) };
    let at = (value as usize).checked_sub(first.into()).filter(|at| *at < count)?;
    // Entries of 8 bits are packed by some, and padded to words by others.
    let bytes = data.bytes(entries)?;
    if bits <= 8 && bytes.len() < 2 * count {
        return bytes.get(at).map(|byte| f64::from(*byte) / 255.0);
    }
    let entry = *data.words(entries)?.get(at)?;
    Some(if bits <= 8 { f64::from(entry & 0xFF) / 255.0 } else { f64::from(entry) / 65535.0 })
}
