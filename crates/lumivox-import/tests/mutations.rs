//! Damaged files by the thousand: whatever is changed in a file, the result is a volume or an error in words, soon, in
//! bounded memory and without a word about the patient.
//! A round that fails is repeated with `LUMIVOX_FIRST=N LUMIVOX_MUTATIONS=1`; `LUMIVOX_KEEP=FILE` writes its file.
//!
//! `LUMIVOX_MUTATIONS=5000000 cargo test --release -p lumivox-import --test mutations -- --nocapture` runs more of them.

mod common;
#[allow(dead_code, reason = "not every test program uses all of it")]
#[path = "common/writer.rs"]
mod writer;

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use lumivox_core::{CancelToken, Progress};
use lumivox_import::{ImportError, ImportOptions, LabelOptions, Study, load_labels};
use writer::*;

/// A file that takes longer is a finding.
const MOST_TIME: Duration = Duration::from_secs(5);

fn enhanced() -> Elements {
    let frame = |k: u32| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, f64::from(k / 2)]);
        let mut content = Elements::default();
        content.set(0x0020_9128, "UL", Value::Raw(4, (k % 2 + 1).to_le_bytes().to_vec()));
        Elements::default().items(0x0020_9113, vec![place]).items(0x0020_9111, vec![content])
    };
    let measures = Elements::default().decimals(PIXEL_SPACING, &[4.0, 2.0]);
    let orientation =
        Elements::default().decimals(IMAGE_ORIENTATION_PATIENT, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let kind = Elements::default().text(0x0008_9007, "CS", "ORIGINAL\\PRIMARY\\DIFFUSION\\NONE");
    let shared = Elements::default().items(0x0020_9116, vec![orientation]).items(0x0028_9110, vec![measures]);
    let shared = shared.items(0x0018_9226, vec![kind]);
    image("MR", 2, 2, (0..24).collect())
        .text(NUMBER_OF_FRAMES, "IS", "6")
        .items(0x5200_9229, vec![shared])
        .items(0x5200_9230, (0..6).map(frame).collect())
}

fn segmentation() -> Elements {
    let frame = |k: u16| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, f64::from(k)]);
        let which = Elements::default().short(0x0062_000B, k + 1);
        Elements::default().items(0x0020_9113, vec![place]).items(0x0062_000A, vec![which])
    };
    let mut seg = image("SEG", 4, 2, vec![])
        .text(0x0008_0016, "UI", "1.2.840.10008.5.1.4.1.1.66.4")
        .text(0x0062_0001, "CS", "BINARY")
        .short(BITS_ALLOCATED, 1)
        .short(BITS_STORED, 1)
        .short(HIGH_BIT, 0)
        .text(NUMBER_OF_FRAMES, "IS", "3")
        .items(0x0062_0002, vec![Elements::default().short(0x0062_0004, 1).text(0x0062_0005, "LO", "a")])
        .items(0x5200_9230, (0..3).map(frame).collect());
    seg.set(PIXEL_DATA, "OB", Value::Bytes(vec![0xA5, 0x5A, 0xFF]));
    seg
}

/// Two frames of three samples of 12 bits.
fn twelve_bits() -> Elements {
    let mut image = image("CT", 3, 1, vec![])
        .short(BITS_ALLOCATED, 12)
        .short(BITS_STORED, 12)
        .short(HIGH_BIT, 11)
        .text(NUMBER_OF_FRAMES, "IS", "2");
    image.set(PIXEL_DATA, "OW", Value::Bytes((0..9).collect()));
    image
}

/// Three frames of one fragment each, at places of their own.
fn frames() -> Elements {
    let fragment = |k: u8| {
        let mut stream = rle(&[k; 16], 1);
        stream.resize(stream.len().next_multiple_of(2), 0);
        stream
    };
    let group = |k: u8| {
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, f64::from(k)]);
        Elements::default().items(0x0020_9113, vec![place])
    };
    let mut image = image("MR", 4, 4, vec![])
        .short(BITS_ALLOCATED, 8)
        .short(BITS_STORED, 8)
        .short(HIGH_BIT, 7)
        .text(NUMBER_OF_FRAMES, "IS", "3")
        .items(0x5200_9230, (0..3).map(group).collect());
    image.set(PIXEL_DATA, "OB", Value::Fragments((0..3).map(fragment).collect()));
    image
}

/// Whose unit, times and dose lie elsewhere than those of [`pet`].
fn enhanced_pet() -> Elements {
    let code = Elements::default().text(0x0008_0100, "SH", "Bq/ml");
    let mut mapping = Elements::default().items(0x0040_08EA, vec![code]);
    mapping.set(0x0040_9224, "FD", Value::Raw(8, 0f64.to_le_bytes().to_vec()));
    mapping.set(0x0040_9225, "FD", Value::Raw(8, 2f64.to_le_bytes().to_vec()));
    let drug = Elements::default().decimals(0x0018_1074, &[370.0]).decimals(0x0018_1075, &[6588.0]).text(
        0x0018_1078,
        "DT",
        "20240229233000.00+0100",
    );
    image("PT", 2, 1, vec![0, 1000])
        .decimals(0x0010_1030, &[70.0])
        .text(0x0018_9701, "DT", "20240301003000+0100")
        .text(0x0018_9758, "CS", "YES")
        .text(0x0018_9759, "CS", "YES")
        .text(0x0043_0010, "LO", "GEMS_PARM_01")
        .text(0x0043_1039, "IS", "1000000500\\8\\0\\0")
        .items(0x0054_0016, vec![drug])
        .items(0x5200_9229, vec![Elements::default().items(0x0040_9096, vec![mapping])])
}

/// A mosaic of 2 x 2 tiles, three of them slices.
fn mosaic() -> Elements {
    let element = |name: &str, items: &[&str]| {
        let mut bytes = name.as_bytes().to_vec();
        bytes.resize(64, 0);
        bytes.extend(1u32.to_le_bytes());
        bytes.extend(b"IS\0\0");
        [0u32, items.len() as u32, 77].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        for item in items {
            [0, item.len() as u32, 77, 0].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
            bytes.extend(item.as_bytes());
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        bytes
    };
    let mut csa = b"SV10\x04\x03\x02\x01".to_vec();
    [2u32, 77].iter().for_each(|n| csa.extend(n.to_le_bytes()));
    csa.extend(element("SliceNormalVector", &["0.0", "0.0", "1.0"]));
    csa.extend(element("NumberOfImagesInMosaic", &["3"]));
    let mut image =
        image("MR", 4, 4, (0..16).collect()).text(IMAGE_TYPE, "CS", "ORIGINAL\\PRIMARY\\M\\MOSAIC");
    image.set(0x0029_1010, "OB", Value::Raw(csa.len() as u32, csa));
    image
}

/// The same, of which only the protocol of the series is left.
fn protocol() -> Elements {
    let text = "\0\x05### ASCCONV BEGIN ###\nsSliceArray.asSlice[0].sNormal.dTra = 1.0\nsSliceArray.lSize = 3\n\
                sSliceArray.ucImageNumbTra = 0x1\n### ASCCONV END ###\0";
    let mut image = mosaic().without(0x0029_1010);
    image.set(0x0029_1020, "OB", Value::Bytes(text.as_bytes().to_vec()));
    image
}

/// A grid of 2 x 2 tiles, three of them slices, with a place for each.
fn grid() -> Elements {
    let place = |k: u8| Elements::default().decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, f64::from(k)]);
    image("MR", 4, 4, (0..16).collect())
        .text(IMAGE_TYPE, "CS", "ORIGINAL\\PRIMARY\\M_SE\\VFRAME")
        .text(0x0065_0010, "LO", "Image Private Header")
        .text(0x0065_1050, "DS", "3")
        .items(0x0065_1051, (0..3).map(place).collect())
}

fn gzip(file: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(file).unwrap();
    encoder.finish().unwrap()
}

fn lut() -> Elements {
    let mut item = Elements::default();
    let words = |words: &[u16]| words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    item.set(0x0028_3002, "US", Value::Raw(6, words(&[3, 1, 16])));
    item.set(0x0028_3006, "US", Value::Raw(6, words(&[100, 300, 40_000])));
    image("XA", 5, 1, vec![0, 1, 2, 3, 500]).items(0x0028_3000, vec![item])
}

fn pet() -> Elements {
    let drug = Elements::default()
        .text(0x0018_1072, "TM", "235900.00")
        .decimals(0x0018_1074, &[370e6])
        .decimals(0x0018_1075, &[3600.0]);
    image("PT", 2, 1, vec![0, 1000])
        .text(0x0008_0031, "TM", "005900")
        .decimals(0x0010_1030, &[70.0])
        .text(0x0028_0051, "CS", "DECY\\ATTN\\SCAT")
        .text(0x0054_1001, "CS", "BQML")
        .text(0x0054_1102, "CS", "START")
        .items(0x0054_0016, vec![drug])
}

/// A gated reconstruction of nuclear medicine by two detectors: slices and moments that vectors count.
fn nuclear() -> Elements {
    let detector = |x: f64| {
        Elements::default()
            .decimals(IMAGE_POSITION_PATIENT, &[x, 6.0, 70.0])
            .decimals(IMAGE_ORIENTATION_PATIENT, &[0.0, 1.0, 0.0, -1.0, 0.0, 0.0])
    };
    let vectors: [(u32, [u16; 8]); 4] = [
        (0x0054_0010, [1; 8]),
        (0x0054_0020, [1, 1, 1, 1, 2, 2, 2, 2]),
        (0x0054_0070, [1, 1, 2, 2, 1, 1, 2, 2]),
        (0x0054_0080, [1, 2, 1, 2, 1, 2, 1, 2]),
    ];
    let mut image = image("NM", 2, 1, (0..16).collect())
        .without(IMAGE_POSITION_PATIENT)
        .without(IMAGE_ORIENTATION_PATIENT)
        .text(0x0008_0016, "UI", "1.2.840.10008.5.1.4.1.1.20")
        .text(IMAGE_TYPE, "CS", "ORIGINAL\\PRIMARY\\RECON GATED TOMO\\EMISSION")
        .text(NUMBER_OF_FRAMES, "IS", "8")
        .decimals(SPACING_BETWEEN_SLICES, &[-4.0])
        .items(0x0054_0022, vec![detector(5.0), detector(-50.0)]);
    let words = |words: &[u16]| words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    for (tag, numbers) in vectors {
        image.set(tag, "US", Value::Raw(16, words(&numbers)));
    }
    let tags: Vec<u16> = vectors.iter().flat_map(|(tag, _)| [(tag >> 16) as u16, *tag as u16]).collect();
    image.set(0x0028_0009, "AT", Value::Raw(16, words(&tags)));
    image
}

/// The slices of two scans that lie between each other and are told apart by their times, with words, a kernel and a unit.
fn interleaved() -> Vec<Vec<u8>> {
    let slice = |k: u16| {
        let (scan, place) = (f64::from(k / 4), f64::from(k % 4));
        image("CT", 2, 1, vec![k, 100])
            .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 3.0 * place + 0.7 * scan])
            .text(INSTANCE_NUMBER, "IS", &(k + 1).to_string())
            .text(0x0008_0032, "TM", &format!("10{:02}{:02}", 10 + k / 4, k % 4))
            .text(0x0008_103E, "LO", "Thorax^1.0 B30f SECRET1950 SECRETID")
            .text(0x0018_1210, "SH", "B30f")
            .text(0x0028_1054, "LO", "ml/100ml/s")
            .file(Syntax::Explicit)
    };
    (0..8).map(slice).collect()
}

/// The files that are damaged: small ones of every kind.
fn seeds() -> Vec<(String, Vec<u8>)> {
    let grey = image("CT", 4, 3, (0..12).collect())
        .short(PIXEL_PADDING_VALUE, 3)
        .short(PIXEL_PADDING_RANGE_LIMIT, 1);
    let eight = |fragment: Vec<u8>| {
        let mut image =
            image("MR", 4, 4, vec![]).short(BITS_ALLOCATED, 8).short(BITS_STORED, 8).short(HIGH_BIT, 7);
        image.set(PIXEL_DATA, "OB", Value::Fragments(vec![fragment]));
        image
    };
    let samples: Vec<u8> = (0..16).collect();
    let info = charls::FrameInfo { width: 4, height: 4, bits_per_sample: 8, component_count: 1 };
    let jpeg_ls = charls::CharLS::default().encode(info, 0, &samples).unwrap();
    let mut seeds = vec![
        ("rle".to_owned(), eight(rle(&samples, 1)).file(Syntax::Rle)),
        ("jpeg_ls".to_owned(), eight(jpeg_ls).file(Syntax::JpegLs)),
        ("lut".to_owned(), lut().file(Syntax::Explicit)),
        ("pet".to_owned(), pet().file(Syntax::Implicit)),
        ("twelve_bits".to_owned(), twelve_bits().file(Syntax::Explicit)),
        ("frames".to_owned(), frames().file(Syntax::Rle)),
        ("enhanced_pet".to_owned(), enhanced_pet().file(Syntax::Explicit)),
        ("nrrd_list".to_owned(), b"NRRD0005\ntype: uint8\ndimension: 4\nsizes: 2 2 1 2\nkinds: list domain domain domain\nspace: RAS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\nencoding: hex\n\n0001 0203\n04050607".to_vec()),
        ("segments".to_owned(), b"NRRD0005\ntype: uint8\ndimension: 4\nsizes: 2 2 1 2\nkinds: list domain domain domain\nspace: RAS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\nencoding: hex\nSegment0_LabelValue:=1\nSegment0_Layer:=0\nSegment0_Color:=1 0 0\nSegment1_LabelValue:=1\nSegment1_Layer:=1\nSegment1_Name:=b\n\n0001 0100\n01020001".to_vec()),
        ("mosaic".to_owned(), mosaic().file(Syntax::Explicit)),
        ("protocol".to_owned(), protocol().file(Syntax::Explicit)),
        ("grid".to_owned(), grid().file(Syntax::Explicit)),
        ("gzip".to_owned(), gzip(&grey.file(Syntax::Explicit))),
        ("bare".to_owned(), grey.data_set(Syntax::Implicit)),
        ("nifti".to_owned(), nifti()),
        ("nrrd".to_owned(), b"NRRD0004\ntype: int16\ndimension: 3\nsizes: 2 2 2\nspace: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\nendian: little\n\n0123456789abcdef".to_vec()),
        ("metaimage".to_owned(), b"ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_SHORT\nElementSpacing = 1 1 1\nElementDataFile = LOCAL\n0123456789abcdef".to_vec()),
    ];
    seeds.push(("npy".to_owned(), npy()));
    seeds.push(("mgh".to_owned(), mgh()));
    seeds.push(("mgz".to_owned(), gzip(&mgh())));
    seeds.push(("tiff".to_owned(), tiff()));
    seeds.push(("nifti_names".to_owned(), nifti_names()));
    for syntax in [Syntax::Explicit, Syntax::Implicit, Syntax::BigEndian, Syntax::Deflated] {
        seeds.push((format!("grey {syntax:?}"), grey.file(syntax)));
        seeds.push((format!("enhanced {syntax:?}"), enhanced().file(syntax)));
        seeds.push((format!("segmentation {syntax:?}"), segmentation().file(syntax)));
    }
    seeds.push(("zip".to_owned(), zip(&[grey.file(Syntax::Explicit)])));
    // Headers are read whatever the checksums are.
    seeds.push(("interleaved".to_owned(), zip(&interleaved())));
    seeds.push(("nuclear".to_owned(), nuclear().file(Syntax::Explicit)));
    // Codestreams that no crate here can write.
    for name in ["MR_small_jp2klossless.dcm", "JPGExtended.dcm"] {
        if let Some(bytes) =
            common::shared(&format!("pydicom_files/{name}")).and_then(|path| std::fs::read(path).ok())
        {
            seeds.push((name.to_owned(), bytes));
        }
    }
    seeds
}

fn zip(files: &[Vec<u8>]) -> Vec<u8> {
    use std::io::Write;
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let method =
        if files.len() == 1 { zip::CompressionMethod::Deflated } else { zip::CompressionMethod::Stored };
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (k, file) in files.iter().enumerate() {
        zip.start_file(format!("{k}.dcm"), options).unwrap();
        zip.write_all(file).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn seeds_are_what_they_are_meant_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, &seeds().iter().find(|(seed, _)| seed == name).unwrap().1).unwrap();
        common::load(&path).unwrap().report.series
    };
    let interleaved = &of("interleaved")[0];
    assert_eq!(
        (interleaved.phases, interleaved.dims, interleaved.unit.as_str()),
        (2, [2, 1, 4], "ml/100ml/s")
    );
    assert!(interleaved.description.contains("Thorax 1.0 B30f, kernel B30f"), "{}", interleaved.description);
    let nuclear = of("nuclear");
    assert_eq!(nuclear.iter().map(|s| (s.phases, s.dims)).collect::<Vec<_>>(), [(2, [2, 1, 2]); 2]);
}

fn nifti() -> Vec<u8> {
    let mut bytes = vec![0u8; 352];
    bytes[..4].copy_from_slice(&348u32.to_le_bytes());
    for (k, n) in [3u16, 2, 2, 2, 1, 1, 1, 1].iter().enumerate() {
        bytes[40 + 2 * k..42 + 2 * k].copy_from_slice(&n.to_le_bytes());
    }
    bytes[70..72].copy_from_slice(&4u16.to_le_bytes());
    bytes[72..74].copy_from_slice(&16u16.to_le_bytes());
    for k in 0..4 {
        bytes[76 + 4 * k..80 + 4 * k].copy_from_slice(&1f32.to_le_bytes());
    }
    bytes[108..112].copy_from_slice(&352f32.to_le_bytes());
    bytes[344..348].copy_from_slice(b"n+1\0");
    bytes.extend(0..16);
    bytes
}

/// A label table in the header, of which label 7 is set.
fn nifti_names() -> Vec<u8> {
    let table = "<CaretExtension><LabelTable><Label Key=\"7\" Red=\"1\" Green=\"0\" Blue=\"0\"><![CDATA[left_kidney]]></Label>\
                 </LabelTable></CaretExtension>";
    let mut bytes = nifti();
    let samples = bytes.split_off(352);
    bytes[348] = 1;
    let size = (table.len() + 8).next_multiple_of(16);
    bytes.extend((size as i32).to_le_bytes());
    bytes.extend(0i32.to_le_bytes());
    bytes.extend(table.as_bytes());
    bytes.resize(352 + size, 0);
    bytes[108..112].copy_from_slice(&((352 + size) as f32).to_le_bytes());
    bytes.extend(samples);
    bytes
}

fn npy() -> Vec<u8> {
    let text = "{'descr': '<i2', 'fortran_order': False, 'shape': (2, 2, 2), }\n";
    let head = [&b"\x93NUMPY\x01\0"[..], &(text.len() as u16).to_le_bytes(), text.as_bytes()].concat();
    [head, (0..16).collect()].concat()
}

fn mgh() -> Vec<u8> {
    let mut bytes: Vec<u8> = [1, 2, 2, 2, 1, 4, 0].iter().flat_map(|n: &i32| n.to_be_bytes()).collect();
    bytes.extend([0, 1]);
    let floats = [1.0f32, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    bytes.extend(floats.iter().flat_map(|f| f.to_be_bytes()));
    bytes.resize(284, 0);
    bytes.extend(0..16);
    bytes
}

/// Two pages, deflated, with OME's words.
fn tiff() -> Vec<u8> {
    use tiff::{
        encoder::{Compression, TiffEncoder, colortype::Gray16},
        tags::Tag,
    };
    let ome = "<OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeX=\"2\" SizeY=\"2\" SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\" \
               PhysicalSizeX=\"1\" PhysicalSizeY=\"1\" PhysicalSizeZ=\"2\" PhysicalSizeZUnit=\"mm\"/></Image></OME>";
    let mut file = std::io::Cursor::new(Vec::new());
    let mut encoder =
        TiffEncoder::new(&mut file).unwrap().with_compression(Compression::Deflate(Default::default()));
    for page in [[1u16, 2, 3, 4], [5, 6, 7, 8]] {
        let mut image = encoder.new_image::<Gray16>(2, 2).unwrap();
        image.encoder().write_tag(Tag::ImageDescription, ome).unwrap();
        image.write_data(&page).unwrap();
    }
    file.into_inner()
}

/// Changes a file in one of the ways that hurt readers.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    const WORDS: [u32; 10] =
        [0, 1, 2, 0x7F, 0xFF, 0x7FFF_FFFF, 0xFFFF_FFFE, 0xFFFF_FFFF, 0x8000_0000, 0xE000_FFFE];
    for _ in 0..=random.below(3) {
        if bytes.is_empty() {
            return;
        }
        // Preambles are of no interest.
        let from = if bytes.len() > 132 && &bytes[128..132] == b"DICM" { 132 } else { 0 };
        let at = from + random.below((bytes.len() - from).max(1));
        let at = at.min(bytes.len() - 1);
        match random.below(9) {
            0 => bytes[at] = random.below(256) as u8,
            1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes[at] = bytes[at].wrapping_add(random.one(&[1, 255, 2, 254])),
            3 => bytes.truncate(at),
            4 => {
                let word = random.one(&WORDS).to_le_bytes();
                let count = random.one(&[2, 4]).min(bytes.len() - at);
                bytes[at..at + count].copy_from_slice(&word[..count]);
            }
            // Elements twice, elsewhere, or not at all.
            5 | 6 => {
                let length = 1 + random.below((bytes.len() - at).min(64));
                let piece = bytes[at..at + length].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            7 => {
                let length = 1 + random.below((bytes.len() - at).min(32));
                bytes.drain(at..at + length);
            }
            _ => {
                let digits =
                    random.one(&[&b"1e9"[..], b"-1", b"NaN", b"0", b"99999999", b"1\\2", b"inf", b",5"]);
                let count = digits.len().min(bytes.len() - at);
                bytes[at..at + count].copy_from_slice(&digits[..count]);
            }
        }
    }
}

#[test]
fn damaged_files_are_read_or_refused() {
    let number = |name: &str| std::env::var(name).ok().and_then(|n| n.parse::<u64>().ok());
    let rounds = number("LUMIVOX_MUTATIONS").unwrap_or(20_000);
    let first = number("LUMIVOX_FIRST").unwrap_or(0);
    // In memory where the system has such a folder.
    let shm = PathBuf::from("/dev/shm");
    let folder = if shm.is_dir() { tempfile::tempdir_in(shm) } else { tempfile::tempdir() }.unwrap();
    let path = folder.path().join("scan");
    let paths = [path.clone()];
    let (options, cancel) = (ImportOptions::default(), CancelToken::new());
    let seeds = seeds();
    for (name, seed) in &seeds {
        std::fs::write(&path, seed).unwrap();
        common::load(&path).unwrap_or_else(|e| panic!("{name} is bad before it is damaged: {e}"));
    }
    let (mut read, mut refused, mut slowest) = (0u64, 0u64, Duration::ZERO);
    let begin = Instant::now();
    for round in first..first + rounds {
        let mut random = Random(round);
        let (name, seed) = &seeds[random.below(seeds.len())];
        let mut bytes = seed.clone();
        mutate(&mut bytes, &mut random);
        std::fs::write(&path, &bytes).unwrap();
        if rounds == 1
            && let Some(kept) = std::env::var_os("LUMIVOX_KEEP")
        {
            std::fs::write(kept, &bytes).unwrap();
        }
        let start = Instant::now();
        let result = std::panic::catch_unwind(|| {
            let mut study = Study::open(&paths, &options, Progress::SILENT, &cancel)?;
            if round % 4 == 0 && !study.report().series.is_empty() {
                let _ = study.thumbnail(0, 32, &cancel);
            }
            let imported = study.load(&options, Progress::SILENT, &cancel)?;
            Ok::<_, ImportError>(imported.report)
        });
        let labels = std::panic::catch_unwind(|| {
            load_labels(&path, &LabelOptions::default(), Progress::SILENT, &cancel)
                .map(|labels| labels.report)
        });
        let elapsed = start.elapsed();
        slowest = slowest.max(elapsed);
        match &result {
            Ok(Ok(_)) => read += 1,
            _ => refused += 1,
        }
        let told = [result, labels].map(|result| match result {
            Ok(Ok(report)) => format!("{report:?}"),
            Ok(Err(error)) => error.to_string(),
            Err(_) => panic!("round {round} ({name}) panics: LUMIVOX_FIRST={round} LUMIVOX_MUTATIONS=1"),
        });
        let told = told.join("; ");
        assert!(
            !told.to_uppercase().contains("SECRET"),
            "round {round} ({name}) tells the patient's name: {told}"
        );
        assert!(elapsed < MOST_TIME, "round {round} ({name}) took {elapsed:?}");
    }
    println!(
        "{rounds} damaged files of {} kinds: {read} read, {refused} refused, slowest {slowest:?}, {:.0} a second",
        seeds.len(),
        rounds as f64 / begin.elapsed().as_secs_f64()
    );
    if let Ok(status) = std::fs::read_to_string("/proc/self/status")
        && let Some(line) = status.lines().find(|line| line.starts_with("VmHWM:"))
    {
        println!("{line}");
        let kib: u64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
        assert!(kib < 600 << 10, "peak {} MiB", kib >> 10);
    }
}

/// Found among damaged files: a JPEG-LS scan that ends without a marker kept its decoder busy for ten seconds.
#[test]
fn a_jpeg_ls_scan_without_an_end_is_refused_at_once() {
    const STREAM: [u8; 33] = [
        0xFF, 0xD8, 0xFF, 0xF7, 0, 11, 8, 0, 4, 0, 4, 1, 0, 0x11, 0, 0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 0, 0,
        0xAD, 0xA4, 0xD3, 0x7F, 0, 0, 0, 0xD9,
    ];
    let mut image =
        image("MR", 4, 4, vec![]).short(BITS_ALLOCATED, 8).short(BITS_STORED, 8).short(HIGH_BIT, 7);
    image.set(PIXEL_DATA, "OB", Value::Fragments(vec![STREAM.to_vec()]));
    let file = tempfile::NamedTempFile::new().unwrap();
    image.write(file.path(), Syntax::JpegLs);
    let start = Instant::now();
    let result = common::load(file.path());
    assert!(result.is_err_and(|error| error.to_string().contains("damaged JPEG-LS")));
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
}

/// Writes the undamaged files where `cargo fuzz` looks for them; only if asked to.
#[test]
fn seed_corpus() {
    if !std::env::args().any(|argument| argument == "seed_corpus") {
        return;
    }
    for target in ["dicom", "formats"] {
        let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus")).join(target);
        std::fs::create_dir_all(&folder).unwrap();
        for (name, bytes) in seeds() {
            std::fs::write(folder.join(name.replace(' ', "_")), bytes).unwrap();
        }
    }
}
