//! Samples that a codec gives more bits than BitsStored has: clamped, never masked.

use crate::common::{load_written, shared, values};
use crate::writer::*;

/// Four samples of 16 bits in a codestream of JPEG-LS, of which so many bits are stored.
fn jpeg_ls(words: [u16; 4], stored: u16) -> Elements {
    let info = charls::FrameInfo { width: 4, height: 1, bits_per_sample: 16, component_count: 1 };
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_ne_bytes()).collect();
    let stream = charls::CharLS::default().encode(info, 0, &bytes).unwrap();
    let mut image = image("MR", 4, 1, vec![]).short(BITS_STORED, stored).short(HIGH_BIT, stored - 1);
    image.set(PIXEL_DATA, "OB", Value::Fragments(vec![stream]));
    image
}

fn loaded(image: &Elements, syntax: Syntax) -> Vec<f64> {
    values(&load_written(|path| image.write(path, syntax)).unwrap().volume)
}

#[test]
fn what_overshoots_is_the_nearest_value_that_can_be_stored() {
    let twelve = jpeg_ls([4123, 4095, 291, 0], 12);
    assert_eq!(loaded(&twelve, Syntax::JpegLs), [4095.0, 4095.0, 291.0, 0.0]);
    // Below and above, with a sign.
    let signed = jpeg_ls([-2862i16 as u16, 2100, -2048i16 as u16, 5], 12).short(PIXEL_REPRESENTATION, 1);
    assert_eq!(loaded(&signed, Syntax::JpegLs), [-2048.0, 2047.0, -2048.0, 5.0]);
    let ten = jpeg_ls([1024, 1300, 1023, 65535], 10);
    assert_eq!(loaded(&ten, Syntax::JpegLs), [1023.0; 4]);
}

#[test]
fn bits_that_are_no_numbers_stay_bits() {
    // Words of the stored bits alone, whose sign is the uppermost of them.
    let signed = jpeg_ls([0x800, 0xFFF, 0x7FF, 1], 12).short(PIXEL_REPRESENTATION, 1);
    assert_eq!(loaded(&signed, Syntax::JpegLs), [-2048.0, -1.0, 2047.0, 1.0]);
    // An overlay in the upper bits.
    let mut overlay = jpeg_ls([0x1123, 0x1FFF, 291, 0], 12);
    overlay.set(0x6000_0102, "US", Value::Short(12));
    assert_eq!(loaded(&overlay, Syntax::JpegLs), [291.0, 4095.0, 291.0, 0.0]);
    // Run-length coding keeps bytes: what is above is what was not cleared.
    let mut rle = image("MR", 2, 1, vec![]).short(BITS_STORED, 12).short(HIGH_BIT, 11);
    let fragment = rle_words(&[0xF123, 0x8FFF]);
    rle.set(PIXEL_DATA, "OB", Value::Fragments(vec![fragment]));
    assert_eq!(loaded(&rle, Syntax::Rle), [291.0, 4095.0]);
    // Padding of more bits than are stored is still padding.
    let padded = jpeg_ls([63536, 4123, 5, 6], 12).short(PIXEL_PADDING_VALUE, 63536);
    assert_eq!(loaded(&padded, Syntax::JpegLs), [5.0, 4095.0, 5.0, 6.0]);
}

fn rle_words(words: &[u16]) -> Vec<u8> {
    rle(&words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>(), 2)
}

/// Lossy JPEG 2000, as it comes: the values are those of GDCM, clamped.
#[test]
fn jpeg_2000_does_not_wrap() {
    let Some(folder) = shared("cases/import/j2k_overshoot_wraps") else { return };
    let volume = crate::common::load(&folder.join("slice.dcm")).unwrap().volume;
    assert_eq!(volume.value([119, 41, 0]) as i64, 4095);
    let signed = values(&crate::common::load(&folder.join("signed.dcm")).unwrap().volume);
    assert!(signed.contains(&-2048.0) && !signed.contains(&1234.0));
}
