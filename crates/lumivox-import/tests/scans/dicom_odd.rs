//! Odd files of real scanners and programs: mosaics of other makers, lost private headers, wrong bytes, gzipped slices.

use std::io::Write;

use crate::common::{load, load_written, values};
use crate::writer::*;
use lumivox_core::glam::DVec3;
use lumivox_import::Imported;

fn load_as(elements: &Elements, syntax: Syntax) -> Imported {
    load_written(|path| elements.write(path, syntax)).unwrap()
}

/// Samples of a picture of `columns` x `rows` whose tiles of 2 x 2 hold their own number, from 1, row by row.
fn tiles(columns: u16, rows: u16) -> Vec<u16> {
    let tile = |x: u16, y: u16| y / 2 * (columns / 2) + x / 2 + 1;
    (0..rows).flat_map(|y| (0..columns).map(move |x| tile(x, y))).collect()
}

#[test]
fn a_grid_of_united_imaging_is_parted_at_its_positions() {
    // Five slices, three tiles wide and two high.
    let place = |k: usize| {
        Elements::default().decimals(IMAGE_POSITION_PATIENT, &[-10.0, 20.0, 30.0 - 4.0 * k as f64])
    };
    let grid = image("MR", 6, 4, tiles(6, 4))
        .text(IMAGE_TYPE, "CS", "ORIGINAL\\PRIMARY\\M_SE\\VFRAME")
        .decimals(IMAGE_POSITION_PATIENT, &[-10.0, 20.0, 30.0])
        .decimals(PIXEL_SPACING, &[1.5, 1.5])
        .text(0x0065_0010, "LO", "Image Private Header")
        .text(0x0065_1050, "DS", "5")
        .items(0x0065_1051, (0..5).map(place).collect());
    for syntax in [Syntax::Explicit, Syntax::Implicit] {
        let imported = load_as(&grid, syntax);
        let volume = &imported.volume;
        assert_eq!(volume.dims(), [2, 2, 5], "{:?}", imported.report.notes);
        // Along the normal, which is upwards: the last tile is the lowest slice.
        assert_eq!(volume.patient_from_voxel().translation, DVec3::new(-10.0, 20.0, 14.0));
        assert_eq!(volume.spacing_mm(), DVec3::new(1.5, 1.5, 4.0));
        let slices: Vec<f64> = (0..5).map(|z| volume.value([1, 1, z])).collect();
        assert_eq!(slices, [5.0, 4.0, 3.0, 2.0, 1.0]);
    }
    // Positions that are not those of all slices part nothing, and it is said.
    let short = grid.items(0x0065_1051, (0..4).map(place).collect());
    let imported = load_as(&short, Syntax::Explicit);
    assert_eq!(imported.volume.dims(), [6, 4, 1]);
    assert!(imported.report.notes.iter().any(|note| note.contains("shown as one picture")));
}

#[test]
fn a_siemens_mosaic_is_parted_by_the_protocol_of_its_series() {
    let mosaic = |protocol: &str| {
        let text =
            format!("\0\x05SV10 binary \0\x7f### ASCCONV BEGIN ###\n{protocol}### ASCCONV END ###\0\0");
        let mut mosaic = image("MR", 4, 4, tiles(4, 4))
            .text(IMAGE_TYPE, "CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC")
            .decimals(IMAGE_POSITION_PATIENT, &[-2.0, -2.0, 7.0])
            .decimals(SPACING_BETWEEN_SLICES, &[3.0])
            .text(0x0029_0010, "LO", "SIEMENS CSA HEADER");
        mosaic.set(0x0029_1020, "OB", Value::Bytes(text.into_bytes()));
        load_as(&mosaic, Syntax::Explicit)
    };
    let lines = "sSliceArray.asSlice[0].sNormal.dTra\t = \t1.0\nsSliceArray.lSize\t=\t3\n";
    let imported = mosaic(lines);
    let volume = &imported.volume;
    assert_eq!(volume.dims(), [2, 2, 3], "{:?}", imported.report.notes);
    // The corner of a tile around the same centre.
    assert_eq!(volume.patient_from_voxel().translation, DVec3::new(-1.0, -1.0, 7.0));
    assert_eq!((0..3).map(|z| volume.value([0, 0, z])).collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
    // Numbered from the head down.
    let imported = mosaic(&format!("{lines}sSliceArray.ucImageNumbTra = 0x1\n"));
    let volume = &imported.volume;
    assert_eq!(volume.patient_from_voxel().translation.z, 1.0);
    assert_eq!((0..3).map(|z| volume.value([0, 0, z])).collect::<Vec<_>>(), [3.0, 2.0, 1.0]);
    // Nonsense is no number of slices.
    assert_eq!(mosaic("sSliceArray.lSize = SECRET\n").volume.dims(), [4, 4, 1]);
}

#[test]
fn padding_before_the_end_of_a_jpeg_ls_image_is_no_damage() {
    let samples: Vec<u8> = (0..=255).map(|k: u8| k.wrapping_mul(37)).collect();
    let info = charls::FrameInfo { width: 16, height: 16, bits_per_sample: 8, component_count: 1 };
    let stream = charls::CharLS::default().encode(info, 0, &samples).unwrap();
    let end = stream.len() - 2;
    assert_eq!(stream[end..], [0xFF, 0xD9]);
    for padding in [&[][..], &[0], &[0, 0, 0]] {
        let padded = [&stream[..end], padding, &stream[end..]].concat();
        let mut image =
            image("MR", 16, 16, vec![]).short(BITS_ALLOCATED, 8).short(BITS_STORED, 8).short(HIGH_BIT, 7);
        image.set(PIXEL_DATA, "OB", Value::Fragments(vec![padded]));
        let found = values(&load_as(&image, Syntax::JpegLs).volume);
        assert_eq!(found, samples.iter().map(|&s| f64::from(s)).collect::<Vec<_>>(), "{padding:?}");
    }
}

#[test]
fn bits_in_bytes_have_no_byte_order() {
    let bits = [0b0000_0001u8, 0b1000_0000];
    let image = |vr, value| {
        let mut image =
            image("MR", 16, 1, vec![]).short(BITS_ALLOCATED, 1).short(BITS_STORED, 1).short(HIGH_BIT, 0);
        image.set(PIXEL_DATA, vr, value);
        image
    };
    let mut expected = vec![0.0; 16];
    (expected[0], expected[15]) = (1.0, 1.0);
    let bytes = image("OB", Value::Bytes(bits.to_vec()));
    let words = image("OW", Value::Words(vec![u16::from_le_bytes(bits)]));
    for syntax in [Syntax::Explicit, Syntax::BigEndian] {
        assert_eq!(values(&load_as(&bytes, syntax).volume), expected, "{syntax:?}, bytes");
        assert_eq!(values(&load_as(&words, syntax).volume), expected, "{syntax:?}, words");
    }
}

#[test]
fn ge_private_syntax_has_pixels_in_big_endian() {
    // All but the pixels is little endian; bytes have no order.
    let words = image("CT", 2, 1, vec![1, 0x0203]).short(PIXEL_PADDING_VALUE, 0x0100);
    assert_eq!(values(&load_as(&words, Syntax::GePrivate).volume), [1.0, 515.0]);
    let mut bytes =
        image("MR", 2, 1, vec![]).short(BITS_ALLOCATED, 8).short(BITS_STORED, 8).short(HIGH_BIT, 7);
    bytes.set(PIXEL_DATA, "OB", Value::Bytes(vec![1, 2]));
    assert_eq!(values(&load_as(&bytes, Syntax::GePrivate).volume), [1.0, 2.0]);
}

#[test]
fn a_spacing_of_zero_is_not_known() {
    let zero = |zeros: &str| image("MR", 2, 1, vec![0, 1]).text(PIXEL_SPACING, "DS", zeros);
    for (other, name) in [(0x0018_1164, "ImagerPixelSpacing"), (0x0018_2010, "NominalScannedPixelSpacing")] {
        let imported = load_as(&zero("0\\0").decimals(other, &[0.5, 0.25]), Syntax::Explicit);
        assert_eq!(imported.volume.spacing_mm().truncate().to_array(), [0.25, 0.5]);
        let notes = imported.report.notes.join("; ");
        assert!(notes.contains("PixelSpacing (0028,0030) is zero") && notes.contains(name), "{notes}");
    }
    for (spacing, other) in [("0\\0", "0\\0"), ("0\\1", "-1\\1"), ("-1\\1", "1\\1")] {
        let image = zero(spacing).text(0x0018_1164, "DS", other);
        let error = load_written(|path| image.write(path, Syntax::Explicit)).unwrap_err().to_string();
        assert!(
            error.contains("PixelSpacing (0028,0030) is") && error.contains("positive lengths"),
            "{error}"
        );
    }
}

#[test]
fn a_prefix_in_the_data_of_a_file_without_preamble_is_data() {
    // A comment that has the letters of the prefix where it would be.
    for syntax in [Syntax::Explicit, Syntax::Implicit] {
        let with_comment = |length: usize| {
            let text = format!("{}DICM{}", "x".repeat(length), "y".repeat(20));
            image("MR", 2, 1, vec![3, 5]).text(0x0008_0015, "LT", &text).data_set(syntax)
        };
        let length = (0..128).find(|length| with_comment(*length)[128..132] == *b"DICM").unwrap();
        let imported = load_written(|path| std::fs::write(path, with_comment(length)).unwrap())
            .unwrap_or_else(|error| panic!("{syntax:?}: {error}"));
        assert_eq!(values(&imported.volume), [3.0, 5.0]);
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn folders_of_gzipped_slices_are_read_where_they_lie() {
    let folder = tempfile::tempdir().unwrap();
    let slice = |k: u16, syntax| {
        let image =
            image("MR", 2, 1, vec![k, 100]).decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, f64::from(k)]);
        if syntax == Syntax::Rle {
            let samples = [k.to_le_bytes(), 100u16.to_le_bytes()].concat();
            let mut image = image;
            image.set(PIXEL_DATA, "OB", Value::Fragments(vec![rle(&samples, 2)]));
            return image.file(syntax);
        }
        image.file(syntax)
    };
    let ways = [Syntax::Explicit, Syntax::Implicit, Syntax::Deflated, Syntax::Rle];
    for (k, syntax) in ways.into_iter().enumerate() {
        std::fs::write(folder.path().join(format!("{k}.dcm.gz")), gzip(&slice(k as u16, syntax))).unwrap();
    }
    // In two members, of which the last says its own size only.
    let file = slice(4, Syntax::Explicit);
    let members = [gzip(&file[..file.len() - 3]), gzip(&file[file.len() - 3..])].concat();
    std::fs::write(folder.path().join("4.dcm.gz"), members).unwrap();
    let imported = load(folder.path()).unwrap();
    let volume = &imported.volume;
    assert_eq!(volume.dims(), [2, 1, 5], "{:?}", imported.report.skipped);
    assert_eq!((0..5).map(|z| volume.value([0, 0, z])).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0]);
    // One by itself; a damaged one costs itself; one of something else is named.
    assert_eq!(load(&folder.path().join("1.dcm.gz")).unwrap().volume.dims(), [2, 1, 1]);
    let mut damaged = gzip(&slice(2, Syntax::Explicit));
    let at = damaged.len() - 6;
    damaged[at] ^= 1;
    std::fs::write(folder.path().join("2.dcm.gz"), damaged).unwrap();
    std::fs::write(folder.path().join("notes.gz"), gzip(b"not a scan")).unwrap();
    let imported = load(folder.path()).unwrap();
    assert_eq!(imported.report.empty_slices, [2], "{:?}", imported.report);
    assert_eq!(imported.report.skipped.len(), 2, "{:?}", imported.report.skipped);
}

/// A slice of samples that cannot be packed.
fn noise(k: u16) -> Vec<u8> {
    let mut random = Random(k.into());
    let samples = (0..64 * 64).map(|_| random.below(1 << 16) as u16).collect();
    image("MR", 64, 64, samples)
        .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, f64::from(k)])
        .file(Syntax::Explicit)
}

#[test]
fn what_a_gzip_file_says_at_its_end_is_of_its_last_member_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = |k: u16| folder.path().join(format!("{k}.dcm.gz"));
    for k in 0..3 {
        std::fs::write(path(k), gzip(&noise(k))).unwrap();
    }
    // Nearly all of it lies in the last of two members.
    let file = noise(1);
    std::fs::write(path(1), [gzip(&file[..200]), gzip(&file[200..])].concat()).unwrap();
    let imported = load(folder.path()).unwrap();
    assert!(imported.report.empty_slices.is_empty(), "{:?}", imported.report);
    assert_eq!(imported.volume.dims(), [64, 64, 3], "{:?}", imported.report.skipped);
    // One that breaks off says nothing at its end, and costs itself.
    let cut = gzip(&file);
    std::fs::write(path(1), &cut[..cut.len() / 2]).unwrap();
    let imported = load(folder.path()).unwrap();
    assert_eq!(imported.report.empty_slices, [1], "{:?}", imported.report);
}

#[test]
fn a_gzip_file_that_grows_without_bounds_is_said_to_do_so() {
    let folder = tempfile::tempdir().unwrap();
    let mut bomb = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    bomb.write_all(&image("MR", 2, 1, vec![1, 2]).file(Syntax::Explicit)).unwrap();
    (0..100).for_each(|_| bomb.write_all(&[0; 1 << 20]).unwrap());
    let path = folder.path().join("bomb.dcm.gz");
    std::fs::write(&path, bomb.finish().unwrap()).unwrap();
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("it grows beyond any scan's size"), "{error}");
    // In a folder it costs itself only.
    std::fs::write(folder.path().join("0.dcm.gz"), gzip(&noise(0))).unwrap();
    let report = load(folder.path()).unwrap().report;
    assert!(report.skipped[0].reason.contains("it grows beyond any scan's size"), "{:?}", report.skipped);
}
