use std::io::Write;

use flate2::{Compression, write::GzEncoder};

use lumivox_core::{CancelToken, Progress};

use super::*;
use crate::{Imported, values::Told};

fn load(path: &Path) -> Result<Imported, ImportError> {
    open(path, false)?.load(None, &Told::default(), Progress::SILENT, &CancelToken::new())
}

fn load_bytes(bytes: &[u8]) -> Result<Imported, ImportError> {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    load(file.path())
}

fn with(header: &str, data: &[u8]) -> Result<Imported, ImportError> {
    load_bytes(&[format!("NRRD0005\n# a comment\n{header}\n\n").as_bytes(), data].concat())
}

fn values(imported: &Imported) -> Vec<f64> {
    let [x, y, z] = imported.volume.dims();
    (0..x * y * z).map(|i| imported.volume.value([i % x, i / x % y, i / (x * y)])).collect()
}

const GRID: &str = "dimension: 3\nsizes: 2 1 2";

#[test]
fn encodings_and_byte_orders() {
    let data = [1i16, -2, 300, 4];
    let expected = [1.0, -2.0, 300.0, 4.0];
    let little: Vec<u8> = data.iter().flat_map(|v| v.to_le_bytes()).collect();
    let big: Vec<u8> = data.iter().flat_map(|v| v.to_be_bytes()).collect();
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(&big).unwrap();
    let header = |rest: &str| format!("type: signed short int\n{GRID}\n{rest}");
    for (rest, data) in [
        ("endian: little\nencoding: raw", &little[..]),
        ("endian: big\nencoding: raw", &big),
        ("endian: big\nencoding: gzip", &encoder.finish().unwrap()),
        ("encoding: ASCII", b"1 -2 300\n4\n"),
        ("endian: little\nencoding: raw\nbyte skip: -1", &[&[9; 5], &little[..]].concat()),
        ("endian: little\nencoding: raw\nline skip: 1\nbyteskip: 2", &[b"x\nyz", &little[..]].concat()),
    ] {
        assert_eq!(values(&with(&header(rest), data).unwrap()), expected, "{rest}");
    }
    let crlf = header("endian: little\nencoding: raw").replace('\n', "\r\n");
    let bytes = [format!("NRRD0004\r\n{crlf}\r\n\r\n").as_bytes(), &little].concat();
    assert_eq!(values(&load_bytes(&bytes).unwrap()), expected);
}

#[test]
fn left_stays_left_in_every_space() {
    for (space, x, y) in [
        ("left-posterior-superior", 1.0, 1.0),
        ("RAS", -1.0, -1.0),
        ("right-anterior-superior", -1.0, -1.0),
        ("left-anterior-superior", 1.0, -1.0),
        ("scanner-xyz", 1.0, 1.0),
    ] {
        let header = format!(
            "type: uchar\n{GRID}\nspace: {space}\nspace directions: (2,0,0) (0,3,0) (0,1,4)\n\
             space origin: (10,20,30)\nencoding: raw"
        );
        let place = with(&header, &[1, 2, 3, 4]).unwrap().volume.patient_from_voxel();
        assert_eq!(place.translation, DVec3::new(10.0 * x, 20.0 * y, 30.0), "{space}");
        assert_eq!(place.matrix3.x_axis, DVec3::new(2.0 * x, 0.0, 0.0), "{space}");
        assert_eq!(place.matrix3.y_axis, DVec3::new(0.0, 3.0 * y, 0.0), "{space}");
        assert_eq!(place.matrix3.z_axis, DVec3::new(0.0, y, 4.0), "{space}: a tilted gantry shears");
    }
}

#[test]
fn spacings_do_without_directions() {
    let with_spacings = |spacings: &str| {
        let header = format!("type: uchar\n{GRID}\nspacings: {spacings}\nencoding: raw");
        with(&header, &[1, 2, 3, 4]).unwrap()
    };
    let imported = with_spacings("0.5 nan 2");
    assert_eq!(imported.volume.spacing_mm(), DVec3::new(0.5, 1.0, 2.0));
    let notes = &imported.report.notes;
    assert!(notes[0].contains("no orientation"));
    assert!(
        notes.contains(&"the spacing of axis 2 is not given (nan): taken as 1 mm".to_owned()),
        "{notes:?}"
    );
    // A negative one counts the other way.
    let place = with_spacings("-0.5 1 -2").volume.patient_from_voxel();
    assert_eq!(place.transform_vector3(DVec3::ONE), DVec3::new(-0.5, 1.0, -2.0));
}

#[test]
fn units_of_length_are_converted_or_refused() {
    let spaced = |units: &str| {
        let header = format!(
            "type: uchar\n{GRID}\nencoding: raw\nspace: LPS\nspace directions: (2,0,0) (0,2,0) (0,0,2)\n\
             space units: {units}"
        );
        with(&header, &[1, 2, 3, 4]).map(|imported| imported.volume.spacing_mm().to_array())
    };
    for (unit, mm) in
        [("mm", 1.0), ("um", 1e-3), ("\u{b5}m", 1e-3), ("m", 1e3), ("inch", 25.4), ("cm", 10.0), ("", 1.0)]
    {
        let found = spaced(&format!("\"{unit}\" \"{unit}\" \"{unit}\"")).unwrap();
        assert!(found.iter().all(|length| (length / (2.0 * mm) - 1.0).abs() < 1e-9), "{unit}: {found:?}");
    }
    // Kilometres are read as such: too far for a scan, which is said, and not as millimetres.
    let far = spaced("\"km\" \"km\" \"km\"").unwrap_err().to_string();
    assert!(far.contains("distance between voxels"), "{far}");
    assert_eq!(spaced("\"mm\" \"mm\" \"cm\"").unwrap(), [2.0, 2.0, 20.0]);
    let error = spaced("\"furlong\" \"furlong\" \"furlong\"").unwrap_err().to_string();
    assert!(error.contains("space units (line 9)") && error.contains("furlong"), "{error}");
    let own = format!("type: uchar\n{GRID}\nencoding: raw\nspacings: 5 5 7\nunits: \"um\" \"um\" \"um\"");
    let found = with(&own, &[1, 2, 3, 4]).unwrap().volume.spacing_mm();
    assert!((found - DVec3::new(5e-3, 5e-3, 7e-3)).length() < 1e-12, "{found}");
}

#[test]
fn phases_are_counted_and_components_refused() {
    let four = |kinds: &str| {
        format!("type: uchar\ndimension: 4\nsizes: 2 1 2 2\n{kinds}\nencoding: raw\nmodality:=MR")
    };
    let imported = with(&four("kinds: domain domain domain list"), &[1, 2, 3, 4, 5, 6, 7, 8]).unwrap();
    assert_eq!(values(&imported), [1.0, 2.0, 3.0, 4.0]);
    assert!(imported.report.notes.contains(&"phase 1 of 2 is taken".to_owned()));
    assert_eq!(imported.volume.modality(), Modality::Mr);
    for kinds in
        ["kinds: vector domain domain domain", "space: LPS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)"]
    {
        let error = with(&four(kinds), &[0; 8]).unwrap_err().to_string();
        assert!(error.contains("2 values for each voxel"), "{error}");
        assert!(error.contains("Export one component"), "{error}");
    }
    let colours = "type: uchar\ndimension: 3\nsizes: 3 2 2\nkinds: RGB-color domain domain\nencoding: raw";
    let grey = with(colours, &[[255; 3], [0, 255, 0], [0; 3], [10; 3]].concat()).unwrap();
    assert_eq!((grey.volume.dims(), values(&grey)), ([2, 2, 1], vec![255.0, 182.0, 0.0, 10.0]));
    assert!(grey.report.notes.iter().any(|note| note.contains("luminance")));
}

#[test]
fn detached_data_in_one_file_a_list_and_a_pattern() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.nhdr");
    for (name, data) in [("a.raw", [1, 2]), ("b.raw", [3, 4])] {
        std::fs::write(folder.path().join(name), data).unwrap();
    }
    std::fs::write(folder.path().join("all one.raw"), [1, 2, 3, 4]).unwrap();
    std::fs::write(folder.path().join("s01.raw"), [1, 2]).unwrap();
    std::fs::write(folder.path().join("s02.raw"), [3, 4]).unwrap();
    for data in ["LIST\na.raw\nb.raw\n", "all one.raw", "s%02d.raw 1 2 1"] {
        let header = format!("NRRD0004\ntype: uchar\n{GRID}\nencoding: raw\ndata file: {data}");
        std::fs::write(&path, header).unwrap();
        let imported = load(&path).unwrap();
        assert_eq!(values(&imported), [1.0, 2.0, 3.0, 4.0], "{data}");
    }
    std::fs::write(&path, format!("NRRD0004\ntype: uchar\n{GRID}\nencoding: raw\ndata file: no.raw"))
        .unwrap();
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("no.raw' is not there"), "{error}");
    std::fs::write(&path, format!("NRRD0004\ntype: uchar\n{GRID}\nencoding: raw\ndata file: .")).unwrap();
    assert!(load(&path).is_err(), "a folder is no data");
}

#[test]
fn mistakes_are_named_with_their_line() {
    let error = |header: &str| with(header, &[0; 4]).unwrap_err().to_string();
    assert!(error("type: uchar").contains("dimension is missing"));
    let far = format!("type: uchar\n{GRID}\nspacings: 1 1 1e9\nencoding: raw");
    assert!(error(&far).contains("the distance between voxels is 1 x 1 x 1000000000 mm"));
    assert!(error("dimension: 3\nsizes: 2 2").contains("sizes (line 4) is '2 2'"));
    assert!(error("dimension: 3\nsizes: 2 0 2").contains("sizes (line 4)"));
    assert!(error("dimension: 99").contains("dimension (line 3)"));
    assert!(error("hello").contains("line 3 ('hello') is neither"));
    let full = |rest: &str| format!("{GRID}\n{rest}");
    assert!(error(&full("type: block\nencoding: raw")).contains("type (line 5) is 'block'"));
    assert!(error(&full("type: uchar\nencoding: bzip2")).contains("encoded as bzip2"));
    let mars = "type: uchar\nencoding: raw\nspace: mars\nspace directions: (1,0,0) (0,1,0) (0,0,1)";
    assert!(error(&full(mars)).contains("space (line 7) is 'mars'"));
    let directions = "type: uchar\nencoding: raw\nspace directions: (1,0,0) (2,0,0) (0,0,1)";
    assert!(error(&full(directions)).contains("three independent directions"));
    assert!(
        error("dimension: 3\nsizes: 9999999999 9999999999 99\ntype: uchar\nencoding: raw")
            .contains("impossible")
    );
    assert!(matches!(
        with(&full("type: short\nendian: little\nencoding: raw"), &[0; 7]),
        Err(ImportError::Truncated { expected: 8, actual: 7, .. })
    ));
    assert!(load_bytes(b"NRRD0009\n").unwrap_err().to_string().contains("unknown version"));
}

#[test]
fn no_byte_of_a_header_can_do_harm() {
    let header = format!(
        "NRRD0005\ntype: short\n{GRID}\nspace: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n\
         kinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: (0,0,0)\n\n"
    );
    let whole = [header.as_bytes(), &[0; 8]].concat();
    for length in 0..whole.len() {
        assert!(load_bytes(&whole[..length]).is_err(), "cut to {length}");
    }
    for i in 0..whole.len() {
        for value in [b'\n', b'9', b'-', b'(', b' ', 0xff] {
            let mut bytes = whole.clone();
            bytes[i] = value;
            let _ = load_bytes(&bytes);
        }
    }
}
