//! Label maps as files: numbers, names, colours and places come out as they were written, whatever the format; what is
//! no label map is refused in words.

use std::path::{Path, PathBuf};

use crate::writer::*;
use lumivox_core::{
    CancelToken, Label, Progress,
    color::{linear_from_srgb, srgb_from_linear},
    glam::{DAffine3, DVec3},
};
use lumivox_import::{ImportError, ImportedLabels, LabelOptions, load_labels};

fn load(path: &Path) -> Result<ImportedLabels, ImportError> {
    load_labels(path, &LabelOptions::default(), Progress::SILENT, &CancelToken::new())
}

/// A folder in which label maps are written.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    fn load(&self, name: &str, content: impl AsRef<[u8]>) -> Result<ImportedLabels, ImportError> {
        load(&self.write(name, content))
    }
}

fn names(imported: &ImportedLabels) -> Vec<(u8, &str)> {
    imported.labels.labels().iter().map(|label| (label.value, label.name.as_str())).collect()
}

fn is_told(imported: &ImportedLabels, words: &str) {
    let notes = imported.report.notes.join("; ");
    assert!(notes.contains(words), "'{words}' is missing: {notes}");
}

fn is_color(label: &Label, codes: [f64; 3]) {
    let near = |(a, code): (&f64, f64)| (a - linear_from_srgb(code / 255.0)).abs() < 4e-3;
    assert!(label.color.iter().zip(codes).all(near), "{label:?} is not {codes:?}");
}

/// A NIfTI-1 file of 3 x 2 x 1 voxels of 2 mm, first voxel at (-10, -20, 30) mm RAS.
fn nifti(datatype: i16, data: &[u8]) -> Vec<u8> {
    let mut header = vec![0; 352];
    header[..4].copy_from_slice(&348i32.to_le_bytes());
    for (i, size) in [3i16, 3, 2, 1].into_iter().enumerate() {
        header[40 + 2 * i..][..2].copy_from_slice(&size.to_le_bytes());
    }
    header[70..72].copy_from_slice(&datatype.to_le_bytes());
    header[108..112].copy_from_slice(&352f32.to_le_bytes());
    header[254..256].copy_from_slice(&1i16.to_le_bytes());
    let rows = [[2.0f32, 0.0, 0.0, -10.0], [0.0, 2.0, 0.0, -20.0], [0.0, 0.0, 2.0, 30.0]];
    for (i, number) in rows.as_flattened().iter().enumerate() {
        header[280 + 4 * i..][..4].copy_from_slice(&number.to_le_bytes());
    }
    header[344..348].copy_from_slice(b"n+1\0");
    [&header, data].concat()
}

fn bytes<const N: usize, T>(values: &[T], to_bytes: impl Fn(&T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(to_bytes).collect()
}

#[test]
fn numbers_of_nifti_are_kept_with_their_place() {
    let folder = Folder::new();
    let imported = folder.load("map.nii", nifti(2, &[0, 1, 1, 7, 255, 0])).unwrap();
    assert_eq!(imported.labels.voxels(), [0, 1, 1, 7, 255, 0]);
    assert_eq!(names(&imported), [(1, "label 1"), (7, "label 7"), (255, "label 255")]);
    let place = DAffine3::from_cols_array(&[-2.0, 0., 0., 0., -2.0, 0., 0., 0., 2.0, 10.0, 20.0, 30.0]);
    assert_eq!(imported.labels.patient_from_voxel(), place);
    assert_eq!(imported.labels.dims(), [3, 2, 1]);
    let colors: Vec<_> = imported.labels.labels().iter().map(|label| label.color).collect();
    assert!(colors[0] != colors[1] && colors[1] != colors[2]);
    assert_eq!(imported.report.format, "NIfTI");
}

#[test]
fn floats_of_whole_numbers_are_labels_and_others_are_not() {
    let folder = Folder::new();
    let floats = |values: &[f32]| nifti(16, &bytes(values, |v| v.to_le_bytes()));
    let imported = folder.load("map.nii", floats(&[0.0, 2.0, 2.0, f32::NAN, 3.0, -0.0])).unwrap();
    assert_eq!(imported.labels.voxels(), [0, 2, 2, 0, 3, 0]);
    is_told(&imported, "whose value is no number have no label");
    let error = folder.load("scan.nii", floats(&[0.0, 0.25, 1.0, 2.0, 3.0, 4.0])).unwrap_err().to_string();
    assert!(error.contains("scan.nii: no label map: it holds 0.25"), "{error}");
    assert!(error.contains("Open it as a scan"), "{error}");
}

#[test]
fn numbers_beyond_a_byte_are_numbered_anew_and_keep_their_number_as_a_name() {
    let folder = Folder::new();
    // FreeSurfer's, and Allen's, which 32-bit floats do not tell apart.
    for (datatype, data) in [
        (4, bytes(&[0i16, 1024, 1024, 17, 2035, 0], |v| v.to_le_bytes())),
        (16, bytes(&[0f32, 1024.0, 1024.0, 17.0, 2035.0, 0.0], |v| v.to_le_bytes())),
    ] {
        let imported = folder.load("map.nii", nifti(datatype, &data)).unwrap();
        assert_eq!(imported.labels.voxels(), [0, 2, 2, 1, 3, 0]);
        assert_eq!(names(&imported), [(1, "label 17"), (2, "label 1024"), (3, "label 2035")]);
        is_told(&imported, "labels 17 to 2035 are numbered 1 to 3, by rising number");
    }
    let large = [312_782_550u32, 312_782_546, 0, 5, 5, 0];
    let imported = folder.load("map.nii", nifti(768, &bytes(&large, |v| v.to_le_bytes()))).unwrap();
    assert_eq!(imported.labels.voxels(), [3, 2, 0, 1, 1, 0]);
    let negative = bytes(&[-1i16, 0, 0, 0, 0, 4], |v| v.to_le_bytes());
    let imported = folder.load("map.nii", nifti(4, &negative)).unwrap();
    assert_eq!(names(&imported), [(1, "label -1"), (2, "label 4")]);
}

#[test]
fn more_labels_than_a_byte_tells_apart_are_refused() {
    let folder = Folder::new();
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 300 1 1\nElementSpacing = 1 1 1\n\
                  ElementType = MET_USHORT\nElementDataFile = LOCAL\n";
    let values = |n: u16| bytes(&(0..300).map(|i| i % n).collect::<Vec<u16>>(), |v| v.to_le_bytes());
    let error = folder.load("ct.mha", [header.as_bytes(), &values(257)].concat()).unwrap_err().to_string();
    assert!(error.contains("ct.mha: no label map: it holds more than 255 different values"), "{error}");
    let imported = folder.load("map.mha", [header.as_bytes(), &values(256)].concat()).unwrap();
    assert_eq!(imported.labels.labels().len(), 255);
    assert_eq!(imported.report.format, "MetaImage");
}

#[test]
fn names_come_from_a_table_beside_it_or_one_that_is_given() {
    let folder = Folder::new();
    let map = folder.write("map.nii", nifti(2, &[0, 1, 1, 7, 0, 0]));
    folder.write(
        "map.txt",
        "1 255 128 0 1 1 1 \"Left lung\"\n7 0 0 255 1 1 1 \"Heart\"\n9 1 1 1 1 1 1 \"x\"\n",
    );
    let imported = load(&map).unwrap();
    assert_eq!(names(&imported), [(1, "Left lung"), (7, "Heart")]);
    is_color(&imported.labels.labels()[0], [255.0, 128.0, 0.0]);
    assert!(!imported.report.notes.join("; ").contains("looks like a scan"));
    is_told(&imported, "names are those of the table beside it (.txt)");

    let mut options = LabelOptions::default();
    options.table = Some(folder.write("lut.txt", "# FreeSurfer\n7 Right-Lung 10 20 30 0\n"));
    let imported = load_labels(&map, &options, Progress::SILENT, &CancelToken::new()).unwrap();
    assert_eq!(names(&imported), [(1, "label 1"), (7, "Right-Lung")]);
    is_color(&imported.labels.labels()[1], [10.0, 20.0, 30.0]);

    // What is no table is told where it was found, and refused where it was given.
    options.table = Some(folder.write("map.txt", "Dear colleague,\n"));
    let imported = load(&map).unwrap();
    assert_eq!(names(&imported), [(1, "label 1"), (7, "label 7")]);
    is_told(&imported, "beside it (.txt) is no table of labels");
    let error = load_labels(&map, &options, Progress::SILENT, &CancelToken::new()).unwrap_err().to_string();
    assert!(error.contains("map.txt: line 1 says no label"), "{error}");
}

const SEGMENTS: &str = "NRRD0004\ntype: unsigned char\nspace: left-posterior-superior\n";

#[test]
fn segments_of_3d_slicer_have_their_names_and_colors() {
    let folder = Folder::new();
    let header = format!(
        "{SEGMENTS}dimension: 3\nsizes: 3 1 1\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n\
         space origin: (1,2,3)\nencoding: raw\n\
         Segment0_Color:=0.5 0.682353 0.392157\nSegment0_ID:=Segment_1\nSegment0_LabelValue:=2\n\
         Segment0_Layer:=0\nSegment0_Name:=right lung\nSegment1_Color:=1 0 0\nSegment1_ID:=Segment_2\n\
         Segment1_LabelValue:=5\nSegment1_Layer:=0\nSegment1_Name:=empty one\n\n"
    );
    let imported = folder.load("a.seg.nrrd", [header.as_bytes(), &[2, 0, 9]].concat()).unwrap();
    assert_eq!(imported.labels.voxels(), [2, 0, 9]);
    assert_eq!(names(&imported), [(2, "right lung"), (9, "label 9")]);
    is_color(&imported.labels.labels()[0], [127.5, 174.0, 100.0]);
    assert_eq!(imported.labels.patient_from_voxel().translation, DVec3::new(1.0, 2.0, 3.0));
    is_told(&imported, "1 of 2 segments have no voxel");
    let bad = header.replace(":=1 0 0", ":=1 0 nan");
    let error = folder.load("a.seg.nrrd", [bad.as_bytes(), &[2, 0, 9]].concat()).unwrap_err().to_string();
    assert!(error.contains("Segment1_Color (line 14) is '1 0 nan'"), "{error}");
}

#[test]
fn segments_in_layers_are_told_apart_and_the_smallest_wins() {
    let folder = Folder::new();
    let segment = |n: usize, value: u8, layer: usize, name: &str| {
        format!("Segment{n}_LabelValue:={value}\nSegment{n}_Layer:={layer}\nSegment{n}_Name:={name}\n")
    };
    let segments = [segment(0, 1, 0, "bone"), segment(1, 1, 1, "tumour"), segment(2, 2, 0, "fat")].concat();
    let list = format!(
        "{SEGMENTS}dimension: 4\nsizes: 2 4 1 1\nkinds: list domain domain domain\n\
         space directions: none (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n{segments}\n"
    );
    let after = list
        .replace("sizes: 2 4 1 1", "sizes: 4 1 1 2")
        .replace("list domain domain domain", "domain domain domain list")
        .replace("none (1,0,0) (0,1,0) (0,0,1)", "(1,0,0) (0,1,0) (0,0,1) none");
    // Bone, bone and tumour, fat, and what nothing names.
    for (header, data) in [(list, [1, 0, 1, 1, 2, 0, 0, 7]), (after, [1, 1, 2, 0, 0, 1, 0, 7])] {
        let imported = folder.load("b.seg.nrrd", [header.as_bytes(), &data].concat()).unwrap();
        assert_eq!(names(&imported), [(1, "bone"), (2, "tumour"), (3, "fat"), (4, "label 7")], "{header}");
        assert_eq!(imported.labels.voxels(), [1, 2, 3, 4]);
        is_told(&imported, "1 voxels belong to several segments; the smallest of these is kept");
        is_told(&imported, "segments in 2 layers");
        // One layer alone.
        let mut options = LabelOptions::default();
        options.import.phase = Some(2);
        let path = folder.0.path().join("b.seg.nrrd");
        let second = load_labels(&path, &options, Progress::SILENT, &CancelToken::new()).unwrap();
        assert_eq!(second.labels.voxels(), [0, 1, 0, 7]);
        assert_eq!(names(&second), [(1, "tumour"), (7, "label 7")]);
        options.import.phase = Some(3);
        let error = load_labels(&path, &options, Progress::SILENT, &CancelToken::new()).unwrap_err();
        assert!(matches!(error, ImportError::NoSuchPhase { wanted: 3, phases: 2, .. }), "{error}");
    }
    // As 3D Slicer wrote them before it knew layers.
    let old = format!(
        "{SEGMENTS}dimension: 4\nsizes: 2 2 1 1\nkinds: list domain domain domain\nencoding: raw\n\
         space directions: none (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n\
         Segment0_Name:=a\nSegment1_Name:=b\n\n"
    );
    let imported = folder.load("c.seg.nrrd", [old.as_bytes(), &[1, 0, 0, 1]].concat()).unwrap();
    assert_eq!(names(&imported), [(1, "a"), (2, "b")]);
    assert_eq!(imported.labels.voxels(), [1, 2]);
}

/// A segmentation of 8 x 1 pixels: its segments, and for each frame segment, height in mm, and pixels.
fn segmentation(segments: Vec<Elements>, frames: &[(u16, f64)]) -> Elements {
    let group = |&(segment, z): &(u16, f64)| {
        let which = Elements::default().short(0x0062_000B, segment);
        let place = Elements::default().decimals(IMAGE_POSITION_PATIENT, &[3.0, 4.0, z]);
        Elements::default().items(0x0062_000A, vec![which]).items(0x0020_9113, vec![place])
    };
    image("SEG", 8, 1, vec![])
        .without(IMAGE_POSITION_PATIENT)
        .decimals(SPACING_BETWEEN_SLICES, &[2.0])
        .text(0x0008_0016, "UI", "1.2.840.10008.5.1.4.1.1.66.4")
        .text(0x0062_0001, "CS", "BINARY")
        .short(BITS_ALLOCATED, 1)
        .short(BITS_STORED, 1)
        .short(HIGH_BIT, 0)
        .text(NUMBER_OF_FRAMES, "IS", &frames.len().to_string())
        .items(0x0062_0002, segments)
        .items(0x5200_9230, frames.iter().map(group).collect())
}

fn segment(number: u16, label: &str, lab: Option<[u16; 3]>) -> Elements {
    let mut item = Elements::default().short(0x0062_0004, number).text(0x0062_0005, "LO", label);
    if let Some(lab) = lab {
        let bytes: Vec<u8> = lab.iter().flat_map(|word| word.to_le_bytes()).collect();
        item.set(0x0062_000D, "US", Value::Raw(6, bytes));
    }
    item
}

#[test]
fn dicom_segments_have_their_names_and_colors_and_the_smallest_wins() {
    let folder = Folder::new();
    // sRGB (221, 130, 101).
    let segments = vec![segment(1, "Liver", Some([41984, 41604, 40995])), segment(2, "Tumour", None)];
    let mut seg = segmentation(segments, &[(1, 0.0), (2, 0.0), (2, 2.0)]);
    seg.set(PIXEL_DATA, "OB", Value::Bytes(vec![0b0000_0111, 0b0000_1100, 0b1000_0000]));
    let path = folder.0.path().join("seg.dcm");
    seg.write(&path, Syntax::Explicit);
    for path in [&path, folder.0.path()] {
        let imported = load(path).unwrap();
        assert_eq!(imported.labels.dims(), [8, 1, 2]);
        assert_eq!(
            imported.labels.voxels(),
            [[1, 1, 2, 2, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 2]].as_flattened()
        );
        assert_eq!(names(&imported), [(1, "Liver"), (2, "Tumour")]);
        is_color(&imported.labels.labels()[0], [221.0, 130.0, 101.0]);
        is_told(&imported, "1 voxels belong to several segments; the smallest of these is kept");
        assert_eq!(imported.labels.patient_from_voxel().translation, DVec3::new(3.0, 4.0, 0.0));
    }
}

#[test]
fn dicom_fractions_count_from_a_half_and_large_numbers_are_numbered_anew() {
    let folder = Folder::new();
    let eight = |seg: Elements| seg.short(BITS_ALLOCATED, 8).short(BITS_STORED, 8).short(HIGH_BIT, 7);
    let mut seg = eight(segmentation(vec![segment(3, "Prostate", None)], &[(3, 0.0)]))
        .text(0x0062_0001, "CS", "FRACTIONAL")
        .short(0x0062_000E, 200);
    seg.set(PIXEL_DATA, "OB", Value::Bytes(vec![0, 99, 100, 101, 200, 1, 0, 150]));
    let path = folder.0.path().join("fraction.dcm");
    seg.write(&path, Syntax::Explicit);
    let imported = load(&path).unwrap();
    assert_eq!(imported.labels.voxels(), [0, 0, 3, 3, 3, 0, 0, 3]);
    assert_eq!(names(&imported), [(3, "Prostate")]);
    is_told(&imported, "voxels that the segment fills at least half belong to it");

    let mut seg =
        segmentation(vec![segment(2, "", None), segment(900, "Vein", None)], &[(2, 0.0), (900, 0.0)]);
    seg.set(PIXEL_DATA, "OB", Value::Bytes(vec![1, 2]));
    let path = folder.0.path().join("large.dcm");
    seg.write(&path, Syntax::Explicit);
    let imported = load(&path).unwrap();
    assert_eq!(imported.labels.voxels()[..3], [1, 2, 0]);
    assert_eq!(names(&imported), [(1, "label 2"), (2, "Vein")]);
}

#[test]
fn dicom_images_are_no_labels() {
    let folder = Folder::new();
    let path = folder.0.path().join("ct.dcm");
    image("CT", 2, 2, vec![1, 2, 3, 4]).write(&path, Syntax::Explicit);
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("ct.dcm: a DICOM series of images, no segmentation"), "{error}");
    assert!(error.contains("segmentation object (SEG)"), "{error}");
}

#[test]
fn a_cancelled_map_ends_and_a_short_one_is_refused() {
    let folder = Folder::new();
    let cancel = CancelToken::new();
    cancel.cancel();
    let path = folder.write("map.nii", nifti(2, &[0, 1, 1, 7, 255, 0]));
    let error = load_labels(&path, &LabelOptions::default(), Progress::SILENT, &cancel).unwrap_err();
    assert!(matches!(error, ImportError::Cancelled(_)), "{error}");
    let error = folder.load("map.nii", nifti(2, &[0, 1, 1])).unwrap_err();
    assert!(matches!(error, ImportError::Truncated { .. }), "{error}");
    assert!(folder.load("map.txt", "hello").is_err());
    assert!(load(Path::new("nowhere.nii")).is_err());
}

#[test]
fn no_byte_of_a_segmentation_can_do_harm() {
    let header = format!(
        "{SEGMENTS}dimension: 4\nsizes: 2 2 1 1\nkinds: list domain domain domain\nencoding: raw\n\
         space directions: none (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nSegment0_LabelValue:=1\n\
         Segment0_Layer:=0\nSegment0_Color:=0 1 0\nSegment1_Layer:=1\nSegment1_LabelValue:=1\n\n"
    );
    let whole = [header.as_bytes(), &[1, 0, 1, 1]].concat();
    let folder = Folder::new();
    for at in 0..whole.len() {
        for value in [b'\n', b'9', b'-', b'0', 0xff] {
            let mut bytes = whole.clone();
            bytes[at] = value;
            if let Ok(imported) = folder.load("a.seg.nrrd", &bytes) {
                let [x, y, z] = imported.labels.dims();
                assert_eq!(imported.labels.voxels().len(), x * y * z);
            }
        }
    }
}

#[test]
fn a_real_segmentation_has_its_segment() {
    let Some(path) = crate::common::shared("pydicom_files/liver_1frame.dcm") else { return };
    let imported = load(&path).unwrap();
    assert_eq!(names(&imported), [(1, "Liver")]);
    // 3D Slicer's colour of a liver is sRGB (221, 130, 101); its writer takes white for D65, where DICOM means D50.
    let color = imported.labels.labels()[0].color.map(|part| (255.0 * srgb_from_linear(part)).round());
    assert_eq!(color, [217.0, 130.0, 101.0]);
    assert_eq!(imported.labels.dims(), [512, 512, 1]);
    let voxels = imported.labels.counts()[1];
    let scan = crate::common::values(&crate::common::load(&path).unwrap().volume);
    assert_eq!(voxels, scan.iter().filter(|value| **value == 1.0).count() as u64);
}

#[test]
fn real_scans_are_no_label_maps() {
    for (name, words) in [
        ("raw/head_ct_256x256x108_int16_0.957x0.957x1.5mm.raw", "more than 255 different values"),
        ("ct_tilt", "no segmentation"),
        ("syntaxes/1.dcm", "no segmentation"),
    ] {
        let Some(path) = crate::common::shared(name) else { return };
        let error = load(&path).map(|imported| names(&imported).len()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    // Of 8 bits, the numbers alone do not tell.
    let Some(path) = crate::common::shared("nifti/T1_head_ext2.nii.gz") else { return };
    is_told(&load(&path).unwrap(), "this looks like a scan, not like a label map");
}
