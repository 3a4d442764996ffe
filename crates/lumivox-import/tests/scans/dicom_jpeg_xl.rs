//! JPEG XL frames, encoded here: lossless samples come out exactly, damage is an error.

use crate::common::load_written;
use crate::writer::*;
use lumivox_core::Voxels;
use lumivox_import::{ImportError, Imported};
use zune_core::{bit_depth::BitDepth, colorspace::ColorSpace, options::EncoderOptions};
use zune_jpegxl::JxlSimpleEncoder;

/// Loads one file.
fn load_one(elements: &Elements, syntax: Syntax) -> Result<Imported, ImportError> {
    load_written(|path| elements.write(path, syntax))
}

/// Lossless JPEG XL; bytes of 16-bit samples in native order.
fn jpeg_xl(columns: u16, rows: u16, depth: BitDepth, bytes: &[u8]) -> Vec<u8> {
    let options = EncoderOptions::new(columns.into(), rows.into(), ColorSpace::Luma, depth);
    let mut stream = Vec::new();
    JxlSimpleEncoder::new(bytes, options).encode(&mut stream).unwrap();
    stream
}

fn native_bytes(samples: &[u16]) -> Vec<u8> {
    samples.iter().flat_map(|s| s.to_ne_bytes()).collect()
}

/// A box of an ISO base media file.
fn boxed(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
    [&(content.len() as u32 + 8).to_be_bytes(), &kind[..], content].concat()
}

#[test]
fn jpeg_xl_samples_are_exact() {
    // Every sample of 16 bits, scattered; and every one of 8.
    let sixteen: Vec<u16> = (0..=u16::MAX).map(|k| k.wrapping_mul(40503)).collect();
    let eight: Vec<u8> = (0..=255u8).map(|k| k.wrapping_mul(151)).collect();
    let stream = |k: u16| jpeg_xl(256, 256, BitDepth::Sixteen, &native_bytes(&vec![k; 65536]));
    let mut image16 = image("MR", 256, 256, vec![]);
    let packed = jpeg_xl(256, 256, BitDepth::Sixteen, &native_bytes(&sixteen));
    image16.set(PIXEL_DATA, "OB", Value::Fragments(vec![packed.clone()]));
    let mut image8 =
        image("MR", 16, 16, vec![]).short(BITS_ALLOCATED, 8).short(BITS_STORED, 8).short(HIGH_BIT, 7);
    let packed8 = jpeg_xl(16, 16, BitDepth::Eight, &eight);
    image8.set(PIXEL_DATA, "OB", Value::Fragments(vec![packed8]));
    for signed in [false, true] {
        let values = |image: &Elements| {
            let image = image.clone().short(PIXEL_REPRESENTATION, signed.into());
            let volume =
                load_one(&image.decimals(RESCALE_INTERCEPT, &[-1024.0]), Syntax::JpegXl).unwrap().volume;
            (0..volume.voxel_count())
                .map(|i| volume.voxels().get(i) * volume.slope() + volume.intercept() + 1024.0)
                .collect::<Vec<_>>()
        };
        let of16 = |s: &u16| if signed { f64::from(*s as i16) } else { f64::from(*s) };
        assert!(values(&image16).into_iter().eq(sixteen.iter().map(of16)), "16 bits, signed: {signed}");
        let of8 = |s: &u8| if signed { f64::from(*s as i8) } else { f64::from(*s) };
        assert!(values(&image8).into_iter().eq(eight.iter().map(of8)), "8 bits, signed: {signed}");
    }

    // In the boxes of a file, one of which is no business of ours; whole, and in parts.
    let signature = boxed(b"JXL ", b"\r\n\x87\n");
    let other = boxed(b"brob", b"Exif\xFF\xFF\xFF");
    let (first, second) = packed.split_at(100);
    let part = |number: u32, data: &[u8]| boxed(b"jxlp", &[&number.to_be_bytes(), data].concat());
    let whole = [signature.clone(), other, boxed(b"jxlc", &packed)].concat();
    let parts = [signature, part(0, first), part(0x8000_0001, second)].concat();
    for file in [whole, parts] {
        image16.set(PIXEL_DATA, "OB", Value::Fragments(vec![file]));
        let volume = load_one(&image16, Syntax::JpegXl).unwrap().volume;
        assert_eq!(volume.voxels(), &Voxels::U16(sixteen.clone()));
    }

    // Two frames in three fragments.
    let (a, b) = (stream(7), stream(65535));
    let (b0, b1) = b.split_at(b.len() / 2);
    image16.set(PIXEL_DATA, "OB", Value::Fragments(vec![a, b0.to_vec(), b1.to_vec()]));
    let volume = load_one(&image16.text(NUMBER_OF_FRAMES, "IS", "2"), Syntax::JpegXl).unwrap().volume;
    assert_eq!((volume.value([255, 255, 0]), volume.value([0, 0, 1])), (7.0, 65535.0));
}

#[test]
fn damaged_jpeg_xl_is_an_error() {
    let packed = |columns, rows| {
        let samples: Vec<u16> = (0..columns * rows).map(|k| k * 1000).collect();
        jpeg_xl(columns, rows, BitDepth::Sixteen, &native_bytes(&samples))
    };
    let load = |stream: Vec<u8>| {
        let mut image = image("MR", 8, 6, vec![]);
        image.set(PIXEL_DATA, "OB", Value::Fragments(vec![stream]));
        load_one(&image, Syntax::JpegXl)
    };
    let good = packed(8, 6);
    // Padded to an even length, as it must be.
    assert!(load([&good[..], &[0]].concat()).is_ok());
    for end in 0..good.len() {
        let error = load(good[..end].to_vec()).unwrap_err();
        assert!(matches!(error, ImportError::Damaged { .. }), "{end}: {error}");
    }
    for at in 0..good.len() {
        for flip in [0x01, 0x10, 0x80, 0xFF] {
            let mut bytes = good.clone();
            bytes[at] ^= flip;
            if let Err(error) = load(bytes) {
                assert!(
                    matches!(error, ImportError::Damaged { .. } | ImportError::Unsupported { .. }),
                    "{at}: {error}"
                );
            }
        }
    }
    let error = load(packed(6, 8)).unwrap_err();
    assert!(matches!(error, ImportError::Damaged { .. }), "{error}");
    assert!(error.to_string().contains("codestream of 6 x 8 where Columns and Rows say 8 x 6"), "{error}");
    // Half of a box.
    let file = [boxed(b"JXL ", b"\r\n\x87\n"), boxed(b"jxlc", &good)].concat();
    let error = load(file[..file.len() - 9].to_vec()).unwrap_err();
    assert!(matches!(error, ImportError::Damaged { .. }), "{error}");
    assert!(error.to_string().contains("cut short"), "{error}");
}
