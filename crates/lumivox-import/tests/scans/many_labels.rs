//! Labels as other programs leave them: a mask for each organ, tables in headers, segments inside of others, masks in which
//! nothing is set, segmentations of old programs.

use std::path::{Path, PathBuf};

use crate::common::shared;
use lumivox_core::{CancelToken, Progress, glam::DVec3};
use lumivox_import::{ImportError, ImportedLabels, LabelOptions, load_label_files, load_labels};

fn load(path: &Path) -> Result<ImportedLabels, ImportError> {
    load_labels(path, &LabelOptions::default(), Progress::SILENT, &CancelToken::new())
}

fn load_all(paths: &[PathBuf]) -> Result<ImportedLabels, ImportError> {
    load_label_files(paths, &LabelOptions::default(), Progress::SILENT, &CancelToken::new())
}

fn names(imported: &ImportedLabels) -> Vec<(u8, &str)> {
    imported.labels.labels().iter().map(|label| (label.value, label.name.as_str())).collect()
}

#[track_caller]
fn is_told(imported: &ImportedLabels, words: &str) {
    let notes = imported.report.notes.join("; ");
    assert!(notes.contains(words), "'{words}' is missing: {notes}");
}

/// A NIfTI-1 file of `dims` voxels of 2 mm whose first lies at `first` mm RAS, with an extension.
fn nifti(dims: [i16; 3], first: [f32; 3], extension: &str, data: &[u8]) -> Vec<u8> {
    let mut header = vec![0u8; 352];
    header[..4].copy_from_slice(&348i32.to_le_bytes());
    for (i, size) in [3, dims[0], dims[1], dims[2], 1, 1, 1, 1].into_iter().enumerate() {
        header[40 + 2 * i..][..2].copy_from_slice(&size.to_le_bytes());
    }
    header[70..72].copy_from_slice(&2i16.to_le_bytes());
    header[72..74].copy_from_slice(&8i16.to_le_bytes());
    header[254..256].copy_from_slice(&1i16.to_le_bytes());
    for axis in 0..3 {
        header[280 + 16 * axis + 4 * axis..][..4].copy_from_slice(&2f32.to_le_bytes());
        header[280 + 16 * axis + 12..][..4].copy_from_slice(&first[axis].to_le_bytes());
    }
    header[344..348].copy_from_slice(b"n+1\0");
    if !extension.is_empty() {
        header[348] = 1;
        let size = (extension.len() + 8).next_multiple_of(16);
        header.extend((size as i32).to_le_bytes());
        header.extend(0i32.to_le_bytes());
        header.extend(extension.as_bytes());
        header.resize(352 + size, 0);
    }
    let offset = header.len() as f32;
    header[108..112].copy_from_slice(&offset.to_le_bytes());
    header.extend(data);
    header
}

#[test]
fn names_in_a_nifti_header_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seg.nii");
    let table = "<?xml version=\"1.0\"?><CaretExtension><VolumeInformation><LabelTable>\
                 <Label Key=\"3\" Red=\"1\" Green=\"0\" Blue=\"0\" Alpha=\"1\"><![CDATA[kidney_left]]></Label>\
                 <Label Key=\"5\" Red=\"0\" Green=\"1\" Blue=\"0\" Alpha=\"1\"><![CDATA[unused]]></Label>\
                 </LabelTable></VolumeInformation></CaretExtension>";
    std::fs::write(&path, nifti([3, 1, 1], [0.0; 3], table, &[0, 3, 4])).unwrap();
    let imported = load(&path).unwrap();
    assert_eq!(names(&imported), [(3, "kidney left"), (4, "label 4")]);
    assert_eq!(imported.labels.labels()[0].color, [1.0, 0.0, 0.0]);
    // By the name that the other program writes, too.
    assert_eq!(imported.labels.values_of("kidney_left", &[]), [3]);
    // A table beside it is for files without names.
    std::fs::write(folder.path().join("seg.txt"), "3 another 1 2 3 4\n").unwrap();
    assert_eq!(names(&load(&path).unwrap())[0].1, "kidney left");

    let Some(totalseg) = shared("cases/import/totalseg_names/example_seg.nii.gz") else { return };
    let imported = load(&totalseg).unwrap();
    assert_eq!(imported.labels.label(1).unwrap().name, "spleen");
    assert_eq!(imported.labels.label(2).unwrap().name, "kidney right");
    assert!(imported.labels.labels().iter().all(|label| !label.name.starts_with("label ")));
}

#[test]
fn a_folder_of_masks_is_one_label_map() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, first: [f32; 3], dims, data: &[u8]| {
        std::fs::write(folder.path().join(name), nifti(dims, first, "", data)).unwrap();
    };
    write("liver.nii", [0.0; 3], [4, 2, 1], &[1, 1, 1, 1, 1, 1, 0, 0]);
    write("kidney_right.nii", [0.0; 3], [4, 2, 1], &[0, 0, 0, 0, 0, 0, 1, 1]);
    write("gallbladder.nii", [0.0; 3], [4, 2, 1], &[0; 8]);
    // Cut to what it holds, as 3D Slicer does, and within another.
    write("liver_lesion.nii", [2.0, 0.0, 0.0], [1, 2, 1], &[1, 1]);
    std::fs::write(folder.path().join("statistics.json"), "{}").unwrap();
    let imported = load(folder.path()).unwrap();
    assert_eq!(
        names(&imported),
        [(1, "gallbladder"), (2, "kidney right"), (3, "liver"), (4, "liver lesion")]
    );
    assert_eq!(imported.labels.voxels(), [3, 4, 3, 3, 3, 4, 2, 2]);
    is_told(&imported, "4 labels of 4 files");
    is_told(&imported, "nothing is set in the masks of gallbladder");
    is_told(&imported, "2 voxels belong to several segments; the smallest of these is kept");
    let colors: Vec<_> = imported.labels.labels().iter().map(|label| label.color).collect();
    assert!(colors.windows(2).all(|pair| pair[0] != pair[1]), "each has a colour of its own");

    // The same given one by one, in that order.
    let at = |name: &str| folder.path().join(name);
    let some = load_all(&[at("liver_lesion.nii"), at("kidney_right.nii")]).unwrap();
    assert_eq!(names(&some), [(1, "liver lesion"), (2, "kidney right")]);
    assert_eq!((some.labels.dims(), some.labels.voxels()), ([4, 2, 1], &[0, 1, 0, 0, 0, 1, 2, 2][..]));

    // On another grid there is no voxel for its labels.
    write("odd.nii", [1.0, 0.0, 0.0], [4, 2, 1], &[1; 8]);
    let error = load_all(&[at("liver.nii"), at("odd.nii")]).unwrap_err().to_string();
    assert!(error.contains("odd.nii") && error.contains("on a grid of its own"), "{error}");
    write("far.nii", [1.9e6, 1.9e6, 0.0], [4, 2, 1], &[1; 8]);
    let error = load_all(&[at("liver.nii"), at("far.nii")]).unwrap_err().to_string();
    assert!(error.contains("so far apart"), "{error}");
}

#[test]
fn a_scan_beside_masks_is_no_label_map_and_masks_have_a_limit() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, dims, data: &[u8]| {
        std::fs::write(folder.path().join(name), nifti(dims, [0.0; 3], "", data)).unwrap();
    };
    let mut scan = nifti([2, 1, 1], [0.0; 3], "", &[]);
    scan[70..72].copy_from_slice(&16i16.to_le_bytes());
    scan.extend([0.5f32, 7.25].iter().flat_map(|value| value.to_le_bytes()));
    std::fs::write(folder.path().join("ct.nii"), scan).unwrap();
    write("a.nii", [2, 1, 1], &[1, 0]);
    write("b.nii", [2, 1, 1], &[0, 1]);
    let imported = load(folder.path()).unwrap();
    assert_eq!(names(&imported), [(1, "a"), (2, "b")]);
    is_told(&imported, "1 of 3 files hold no labels");
    for k in 0..255 {
        write(&format!("m{k}.nii"), [2, 1, 1], &[1, 0]);
    }
    assert!(load(folder.path()).unwrap_err().to_string().contains("more than 255"));
}

/// A mask alone in which nothing is set is a label map without labels.
#[test]
fn an_empty_mask_has_no_label() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("organ.nii");
    std::fs::write(&path, nifti([2, 2, 1], [0.0; 3], "", &[0; 4])).unwrap();
    let imported = load(&path).unwrap();
    assert!(imported.labels.labels().is_empty());
    is_told(&imported, "no voxel has a label");
}

const LAYERS: &str = "NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 3 1 1\nkinds: list domain domain domain\n\
                      space: left-posterior-superior\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n\
                      space origin: (0,0,0)\nencoding: raw\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n\
                      Segment0_Name:=tumour\nSegment1_LabelValue:=1\nSegment1_Layer:=1\nSegment1_Name:=liver\n\n";

#[test]
fn a_segment_inside_of_another_is_kept_whichever_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seg.seg.nrrd");
    std::fs::write(&path, [LAYERS.as_bytes(), &[0, 1, 1, 1, 0, 1]].concat()).unwrap();
    let imported = load(&path).unwrap();
    assert_eq!(names(&imported), [(1, "tumour"), (2, "liver")]);
    assert_eq!(imported.labels.voxels(), [2, 1, 2]);

    let Some(case) = shared("cases/ov2.seg.nrrd") else { return };
    let counts = load(&case).unwrap().labels.counts();
    assert!(counts[1] > 0 && counts[2] > 0, "{:?}", &counts[..3]);
}

/// By itself it is a picture of all its layers.
#[test]
fn a_segmentation_of_layers_is_one_scan() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seg.seg.nrrd");
    std::fs::write(&path, [LAYERS.as_bytes(), &[0, 1, 1, 1, 0, 0]].concat()).unwrap();
    let imported = crate::common::load(&path).unwrap();
    assert_eq!(crate::common::values(&imported.volume), [2.0, 1.0, 0.0]);
    assert_eq!(imported.report.series[0].phases, 1);
    let mut options = lumivox_import::ImportOptions::default();
    options.phase = Some(2);
    let layer = lumivox_import::load(&[path], &options, Progress::SILENT, &CancelToken::new()).unwrap();
    assert_eq!(crate::common::values(&layer.volume), [1.0, 1.0, 0.0]);
}

#[test]
fn old_segmentations_of_3d_slicer_lie_where_it_puts_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.seg.nrrd");
    let header = "NRRD0004\ntype: unsigned char\ndimension: 4\nspace dimension: 4\nsizes: 2 1 1 1\n\
                  space directions: (-2,0,0,0) (0,-3,0,0) (0,0,4,0) (0,0,0,1)\nkinds: domain domain domain domain\n\
                  encoding: raw\nspace origin: (100,90,-80,0)\nSegment0_Extent:=10 11 20 20 5 5\nSegment0_Name:=bladder\n\
                  Segmentation_Extent:=10 11 20 20 5 5\n\n";
    std::fs::write(&path, [header.as_bytes(), &[0, 1]].concat()).unwrap();
    let imported = load(&path).unwrap();
    assert_eq!(names(&imported), [(1, "bladder")]);
    // RAS (100 - 20, 90 - 60, -80 + 20) mm.
    assert_eq!(imported.labels.patient_from_voxel().translation, DVec3::new(-80.0, -30.0, -60.0));
    let wrong = header.replace("Segmentation_Extent:=10 11", "Segmentation_Extent:=10 12");
    std::fs::write(&path, [wrong.as_bytes(), &[0, 1]].concat()).unwrap();
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("Segmentation_Extent") && error.contains("save it again"), "{error}");

    let Some(case) = shared("cases/import/old_slicer_seg/old.seg.nrrd") else { return };
    let first = load(&case).unwrap().labels.patient_from_voxel().translation;
    let expected = DVec3::new(-(250.0 - 223.0 * 0.976562), -(250.0 - 199.0 * 0.976562), -122.5 + 9.0 * 2.5);
    assert!(first.distance(expected) < 1e-6, "{first} {expected}");
}
