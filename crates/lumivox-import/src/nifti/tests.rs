use std::io::Write;

use flate2::{Compression, write::GzEncoder};
use lumivox_core::{CancelToken, Modality, Progress};

use super::*;
use crate::Imported;
use crate::values::Told;

fn load(path: &Path) -> Result<Imported, ImportError> {
    open(path)?.load(None, &Told::default(), Progress::SILENT, &CancelToken::new())
}

/// A header under construction, in either version and byte order.
struct Builder {
    header: RawHeader,
    data: Vec<u8>,
}

impl Builder {
    fn new(version: Version, big_endian: bool, dims: &[i64], datatype: i16) -> Self {
        let header = RawHeader { bytes: [0; HEADER_BYTES], version, big_endian, detached: false };
        let mut builder = Self { header, data: Vec::new() };
        let one = version == Version::One;
        let size: i32 = if one { 348 } else { 540 };
        builder.put(0, 0, &size.to_le_bytes());
        let (at, magic) = if one { (344, b"n+1\0") } else { (4, b"n+2\0") };
        builder.header.bytes[at..at + 4].copy_from_slice(magic);
        for (i, n) in [dims.len() as i64].iter().chain(dims).enumerate() {
            builder.dim(i, *n);
        }
        builder.put(70, 12, &datatype.to_le_bytes());
        builder.float(112, 176, &[1.0]);
        builder.float(76, 104, &[1.0; 8]);
        if one {
            builder.put(108, 0, &352f32.to_le_bytes());
        } else {
            builder.put(0, 168, &544i64.to_le_bytes());
        }
        builder
    }

    fn put(&mut self, one: usize, two: usize, bytes: &[u8]) {
        let at = if self.header.version == Version::One { one } else { two };
        let mut bytes = bytes.to_vec();
        if self.header.big_endian {
            bytes.reverse();
        }
        self.header.bytes[at..at + bytes.len()].copy_from_slice(&bytes);
    }

    fn dim(&mut self, i: usize, n: i64) {
        match self.header.version {
            Version::One => self.put(40 + 2 * i, 0, &(n as i16).to_le_bytes()),
            Version::Two => self.put(0, 16 + 8 * i, &n.to_le_bytes()),
        }
    }

    fn float(&mut self, one: usize, two: usize, values: &[f64]) {
        for (i, v) in values.iter().enumerate() {
            match self.header.version {
                Version::One => self.put(one + 4 * i, 0, &(*v as f32).to_le_bytes()),
                Version::Two => self.put(0, two + 8 * i, &v.to_le_bytes()),
            }
        }
    }

    fn code(&mut self, one: usize, two: usize, code: i16) {
        match self.header.version {
            Version::One => self.put(one, 0, &code.to_le_bytes()),
            Version::Two => self.put(0, two, &i32::from(code).to_le_bytes()),
        }
    }

    fn sform(&mut self, rows: [[f64; 4]; 3]) {
        self.code(254, 348, 1);
        for (i, row) in rows.iter().enumerate() {
            self.float(280 + 16 * i, 400 + 32 * i, row);
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let size = if self.header.version == Version::One { 348 } else { 540 };
        [&self.header.bytes[..size], &[0; 4], &self.data].concat()
    }
}

fn load_bytes(bytes: &[u8]) -> Result<Imported, ImportError> {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    load(file.path())
}

fn shorts(values: &[i16], big_endian: bool) -> Vec<u8> {
    values.iter().flat_map(|v| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() }).collect()
}

#[test]
fn both_versions_in_both_byte_orders() {
    for (version, big) in [Version::One, Version::Two].into_iter().flat_map(|v| [(v, false), (v, true)]) {
        let mut file = Builder::new(version, big, &[2, 1, 3], 4);
        file.data = shorts(&[-1000, 2, 300, 4, 5, 3000], big);
        file.float(112, 176, &[2.0, 10.0]);
        // Axes to the patient's right, front and head, as 3D Slicer writes them.
        file.sform([[2.0, 0.0, 0.0, 10.0], [0.0, 3.0, 0.0, 20.0], [0.0, 0.0, 4.0, 30.0]]);
        let bytes = file.bytes();
        assert!(is_nifti(&bytes));
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&bytes).unwrap();
        for bytes in [bytes, encoder.finish().unwrap()] {
            let volume = load_bytes(&bytes).unwrap().volume;
            assert_eq!(volume.dims(), [2, 1, 3]);
            assert_eq!(volume.value([0, 0, 0]), -1990.0);
            assert_eq!(volume.value([1, 0, 2]), 6010.0);
            // LPS: to the right is -x, to the front is -y.
            let place = volume.patient_from_voxel();
            assert_eq!(place.transform_point3(DVec3::ZERO), DVec3::new(-10.0, -20.0, 30.0));
            assert_eq!(place.transform_vector3(DVec3::X), DVec3::new(-2.0, 0.0, 0.0));
            assert_eq!(place.transform_vector3(DVec3::Y), DVec3::new(0.0, -3.0, 0.0));
            assert_eq!(place.transform_vector3(DVec3::Z), DVec3::new(0.0, 0.0, 4.0));
        }
    }
}

#[test]
fn quaternions_turn_and_mirror() {
    let mut file = Builder::new(Version::One, false, &[1, 1, 1], 2);
    file.data = vec![7];
    file.code(252, 344, 1);
    file.float(76, 104, &[-1.0, 2.0, 3.0, 4.0]);
    // A quarter turn about z: x goes to y.
    file.float(256, 352, &[0.0, 0.0, 0.5f64.sqrt()]);
    file.float(268, 376, &[1.0, 2.0, 3.0]);
    let place = load_bytes(&file.bytes()).unwrap().volume.patient_from_voxel();
    let near = |v: DVec3, x, y, z| assert!(v.distance(DVec3::new(x, y, z)) < 1e-5, "{v}");
    near(place.transform_vector3(DVec3::X), 0.0, -2.0, 0.0);
    near(place.transform_vector3(DVec3::Y), 3.0, 0.0, 0.0);
    near(place.transform_vector3(DVec3::Z), 0.0, 0.0, -4.0);
    near(place.translation, -1.0, -2.0, 3.0);
}

#[test]
fn a_broken_sform_gives_way_and_no_form_is_told() {
    let mut file = Builder::new(Version::One, false, &[2, 2], 2);
    file.data = vec![1, 2, 3, 4];
    file.float(76, 104, &[1.0, 0.5, 0.5, 0.0]);
    file.sform([[0.0; 4]; 3]);
    let imported = load_bytes(&file.bytes()).unwrap();
    assert_eq!(imported.volume.spacing_mm(), DVec3::new(0.5, 0.5, 1.0));
    assert_eq!(imported.report.notes.len(), 3, "{:?}", imported.report.notes);
    assert!(imported.report.notes[2].starts_with("a single slice is not a volume"));
    assert_eq!(imported.volume.directions().x_axis, DVec3::NEG_X);
}

#[test]
fn slope_zero_means_none_and_units_are_mm() {
    let mut file = Builder::new(Version::One, false, &[2, 1, 1], 4);
    file.data = shorts(&[-1000, 2000], false);
    file.float(112, 176, &[0.0, 99.0]);
    file.header.bytes[123] = 3;
    let volume = load_bytes(&file.bytes()).unwrap().volume;
    assert_eq!(volume.value_range(), [-1000.0, 2000.0]);
    assert_eq!(volume.modality(), Modality::Ct);
    assert!((volume.spacing_mm().x - 0.001).abs() < 1e-9);
}

#[test]
fn of_several_phases_the_first_is_shown() {
    let mut file = Builder::new(Version::Two, false, &[2, 1, 1, 3], 2);
    file.data = vec![1, 2, 3, 4, 5, 6];
    let imported = load_bytes(&file.bytes()).unwrap();
    assert_eq!(imported.volume.value_range(), [1.0, 2.0]);
    assert!(imported.report.notes.contains(&"phase 1 of 3 is taken".to_owned()));
}

#[test]
fn phases_that_a_packed_file_lacks_are_told() {
    let mut file = Builder::new(Version::One, false, &[64, 32, 2, 3], 2);
    // What does not pack, so that half a file is half of the voxels.
    let mut state = 1u32;
    let mut noise = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as u8
    };
    file.data = (0..3 * 4096).map(|_| noise()).collect();
    let gzip = |bytes: &[u8]| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let bytes = file.bytes();
    let whole = gzip(&bytes);
    let is_told = |bytes: &[u8]| {
        let notes = load_bytes(bytes).unwrap().report.notes;
        notes.contains(&"the file is cut short: 1 of 3 phases is there".to_owned())
    };
    assert!(is_told(&whole[..whole.len() / 2]));
    assert!(is_told(&gzip(&bytes[..bytes.len() - 5000])));
    assert!(!is_told(&whole));
    // Of several members the last one says its own size only.
    assert!(!is_told(&[gzip(&bytes[..9000]), gzip(&bytes[9000..])].concat()));
}

#[test]
fn pairs_of_hdr_and_img() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.hdr");
    let mut file = Builder::new(Version::One, false, &[3, 1, 1], 2);
    file.header.bytes[344..348].copy_from_slice(b"ni1\0");
    file.float(108, 168, &[0.0]);
    std::fs::write(&path, file.bytes()).unwrap();
    let load = || load(&path);
    assert!(load().unwrap_err().to_string().contains("scan.img' is not there"));
    std::fs::write(path.with_extension("img"), [5, 6, 7]).unwrap();
    assert_eq!(load().unwrap().volume.value_range(), [5.0, 7.0]);
}

#[test]
fn what_is_no_scan_of_numbers_is_refused() {
    let error = |file: &Builder| load_bytes(&file.bytes()).unwrap_err().to_string();
    let complex = Builder::new(Version::One, false, &[1, 1, 1], 32);
    assert!(error(&complex).contains("complex numbers (datatype 32)"));
    let vectors = Builder::new(Version::One, false, &[1, 1, 1, 1, 3], 16);
    assert!(error(&vectors).contains("several values for each voxel"));
    let negative = Builder::new(Version::One, false, &[1, -5, 1], 2);
    assert!(error(&negative).contains("dim[2] is -5"));
    let mut spacing = Builder::new(Version::One, false, &[1, 2, 1], 2);
    spacing.float(76, 104, &[1.0, 1.0, f64::NAN]);
    assert!(error(&spacing).contains("pixdim[2] is NaN"));
    let mut far = Builder::new(Version::One, false, &[1, 2, 1], 2);
    far.data = vec![1, 2];
    far.float(76, 104, &[1.0, 1.0, 1e7]);
    assert!(error(&far).contains("not from 0.000001 to 1000000 mm"), "{}", error(&far));
    let huge = Builder::new(Version::Two, false, &[1 << 40, 1 << 40, 1], 2);
    assert!(error(&huge).contains("impossible"));
    let long = Builder::new(Version::Two, false, &[1 << 40, 1, 1], 2);
    assert!(matches!(load_bytes(&long.bytes()), Err(ImportError::Truncated { .. })));
}

#[test]
fn no_byte_of_a_header_can_do_harm() {
    for version in [Version::One, Version::Two] {
        let mut file = Builder::new(version, false, &[2, 2, 2], 4);
        file.sform([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
        file.data = vec![0; 16];
        let whole = file.bytes();
        for length in 0..whole.len() {
            assert!(load_bytes(&whole[..length]).is_err(), "cut to {length}");
        }
        for i in 0..whole.len() {
            for value in [0x00, 0x7f, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[i] = value;
                let _ = load_bytes(&bytes);
            }
        }
    }
}

#[test]
fn colours_become_their_luminance() {
    for (datatype, data) in
        [(128, &[255, 255, 255, 0, 255, 0][..]), (2304, &[255, 255, 255, 0, 0, 255, 0, 9])]
    {
        let file = Builder::new(Version::One, false, &[2, 1, 1], datatype);
        let bytes = [&file.bytes()[..], data].concat();
        let imported = load_bytes(&bytes).unwrap();
        assert_eq!(imported.volume.value([0, 0, 0]), 255.0);
        assert_eq!(imported.volume.value([1, 0, 0]), 182.0);
        assert!(imported.report.notes.iter().any(|note| note.contains("luminance")));
        let short = [&file.bytes()[..], &data[1..]].concat();
        assert!(matches!(load_bytes(&short), Err(ImportError::Truncated { .. })));
    }
}
