//! A project that Godot has never opened, imported once, as build servers do.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::engine::{Start, engine};
use crate::scans::write_series;

/// A scan of one value a voxel, in every format that one file holds.
fn write_scans(folder: &Path) {
    let (dims, spacing) = ([6usize, 5, 4], [1.0f32, 1.0, 2.0]);
    let bytes: Vec<u8> = (0..120i16).flat_map(i16::to_le_bytes).collect();
    let nifti = [crate::scans::nifti_header(dims, spacing), bytes.clone()].concat();
    let nrrd = "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 6 5 4\n\
        space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\nendian: little\nencoding: raw\n\n";
    let mha = "ObjectType = Image\nNDims = 3\nDimSize = 6 5 4\nElementSpacing = 1 1 2\nElementType = MET_SHORT\n\
        BinaryData = True\nBinaryDataByteOrderMSB = False\nElementDataFile = LOCAL\n";
    let mut packed = flate2::write::GzEncoder::new(vec![], flate2::Compression::default());
    packed.write_all(&nifti).unwrap();
    let packed = packed.finish().unwrap();
    fs::create_dir_all(folder.join("deep/er")).unwrap();
    for (name, content) in [
        ("head.nii", nifti),
        ("head.nii.gz", packed.clone()),
        ("deep/er/1.2.NII.GZ", packed),
        ("head.nrrd", [nrrd.as_bytes(), &bytes].concat()),
        ("head.mha", [mha.as_bytes(), &bytes].concat()),
    ] {
        fs::write(folder.join(name), content).unwrap();
    }
    write_series(&lumivox_phantom::cube(8), &folder.join("ct"));
}

#[test]
fn the_first_import_of_a_project_imports_every_scan() {
    let engine = engine();
    for knows_extension in [true, false] {
        let name = if knows_extension { "first_import" } else { "first_import_unknown" };
        let project = engine.copy_project(name);
        if knows_extension {
            fs::remove_dir_all(project.join(".godot/imported")).unwrap();
            fs::remove_dir_all(project.join(".godot/editor")).unwrap();
        } else {
            fs::remove_dir_all(project.join(".godot")).unwrap();
        }
        write_scans(&project.join("scans"));
        let arguments = ["--path", project.to_str().unwrap(), "--headless", "--import"];
        engine.run_as(&engine.godot, name, &arguments, &Start::default());
        let made: Vec<String> = fs::read_dir(project.join(".godot/imported"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|made| made.ends_with(".res"))
            .collect();
        for scan in ["head.nii", "head.nii.gz", "1.2.NII.GZ", "head.nrrd", "head.mha", "CT0001.dcm"] {
            let is_there = made.iter().any(|made| made.starts_with(&format!("{scan}-")));
            assert!(is_there, "{name}: {scan} was not imported: {made:?}");
        }
    }
}
