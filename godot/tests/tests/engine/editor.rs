//! The addon in the real editor, used by `project/editor/driver.gd` as somebody at the editor would use it.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use lumivox_core::glam::DVec3;
use lumivox_phantom::cube;
use serde_json::{Value, json};

use crate::case::{Case, Lamp, LampKind, Volume, look_at};
use crate::engine::{Run, Start, engine, once};
use crate::expected;
use crate::scans;
use crate::shown::{assert_same, run_scene_in_window, told};

/// The file that cannot be read.
const BROKEN: &str = "broken.nrrd";

/// Complaints about the broken file are what is wanted; the others are the engine's own, when it is told to quit and a
/// look for changed files is cut off.
const EXCUSED: &[&str] = &[
    BROKEN,
    "Scan thread aborted",
    "Can't use get_node() with absolute paths from outside the active scene tree",
];

fn case() -> Case {
    Case {
        volumes: vec![Volume::head()],
        camera: look_at(DVec3::new(0.35, 0.1, 0.6), DVec3::ZERO),
        // A scene without a sun would be given one by the editor, to preview it.
        lamps: vec![Lamp {
            color: [0.9, 0.8, 0.6],
            ..Lamp::new(LampKind::Directional, look_at(DVec3::new(0.5, 0.8, 0.3), DVec3::ZERO))
        }],
        // In software the editor's own panels take a multiple of what a frame gets otherwise.
        budget: 300.0,
        // The editor's own viewport has forty times the pixels of the pictures that are compared, and waits for all of them.
        samples: 8,
        // As scenes are by default.
        kept_light: true,
        ..Case::new("edited")
    }
}

/// The editor's log and the folder of its pictures: all tests look at one run.
fn edited() -> &'static (Run, PathBuf) {
    static EDITED: OnceLock<Option<(Run, PathBuf)>> = OnceLock::new();
    once(&EDITED, || {
        let engine = engine();
        let project = engine.copy_project("editor");
        let (folder, file) = engine.write_cases("editor", &[case()]);
        let settings = fs::read_to_string(project.join("project.godot")).unwrap();
        let settings = settings.replace("plugin.cfg\")", "plugin.cfg\", \"res://tests/editor/plugin.cfg\")");
        // The editor would begin with the main scene, and grow its phantom.
        let lines = settings.lines().filter(|line| !line.starts_with("run/main_scene"));
        fs::write(project.join("project.godot"), lines.collect::<Vec<_>>().join("\n")).unwrap();
        write_scans(&project.join("scans"));
        let study = folder.join("study");
        write_study(&study);
        let [path, cases, out, study] = [&project, &file, &folder, &study].map(|path| path.to_str().unwrap());
        let arguments = ["--path", path, "--editor", "--", "--cases", cases, "--out", out, "--study", study];
        let start = Start { excused: EXCUSED, ..Start::default() };
        let run = engine.run_as(&engine.godot, "editor", &arguments, &start);
        (run, folder)
    })
}

pub fn telling(name: &str) -> Value {
    told(&edited().0, name)
}

/// A folder of DICOM files, an archive of every other one, a file of each other kind, and one that is cut short. Of the
/// endings that may be anything's, one was imported as a volume by an addon that claimed them all, and one was not.
fn write_scans(folder: &Path) {
    let series = folder.join("ct");
    scans::write_series(&scans::head(24), &series);

    let mut archive = zip::ZipWriter::new(fs::File::create(folder.join("archive.zip")).unwrap());
    let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let mut slices: Vec<_> = fs::read_dir(&series).unwrap().map(|entry| entry.unwrap().path()).collect();
    slices.sort();
    for slice in slices.iter().step_by(2) {
        archive.start_file(slice.file_name().unwrap().to_str().unwrap(), stored).unwrap();
        archive.write_all(&fs::read(slice).unwrap()).unwrap();
    }
    archive.finish().unwrap();
    for (name, made) in
        [("former.zip", "path=\"res://.godot/imported/former.res\""), ("data.zip", "valid=false")]
    {
        let source = folder.join(name);
        fs::copy(folder.join("archive.zip"), &source).unwrap();
        let settings = format!(
            "[remap]\n\nimporter=\"lumivox.volume\"\nimporter_version=1\ntype=\"LumivoxVolume\"\n\
             uid=\"uid://c{}lumivox\"\n{made}\n\n[deps]\n\nsource_file=\"res://scans/{name}\"\n\n\
             [params]\n\nseries=\"\"\nphase=0\ncompress=true\n",
            name.len()
        );
        fs::write(folder.join(format!("{name}.import")), settings).unwrap();
    }

    let voxels: Vec<u8> = (0..210_i16).flat_map(i16::to_le_bytes).collect();
    let header = "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 5 6 7\n\
                  space directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (0,0,0)\nencoding: raw\nendian: little\n\n";
    fs::write(folder.join("grid.nrrd"), [header.as_bytes(), &voxels].concat()).unwrap();
    fs::write(folder.join(BROKEN), [header.as_bytes(), &voxels[..5]].concat()).unwrap();

    let mut nifti = [0; 352];
    let mut put = |at: usize, bytes: &[u8]| nifti[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    for (i, n) in [3_i16, 4, 5, 6, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &n.to_le_bytes());
    }
    // 16-bit integers, spacings in mm, data after the header, no slope.
    put(70, &4_i16.to_le_bytes());
    put(72, &16_i16.to_le_bytes());
    for (i, x) in [1.0_f32, 1.5, 2.0, 2.5].into_iter().enumerate() {
        put(76 + 4 * i, &x.to_le_bytes());
    }
    put(108, &352_f32.to_le_bytes());
    put(123, &[2]);
    put(344, b"n+1\0");
    let nifti = [&nifti[..], &voxels[..240]].concat();
    fs::write(folder.join("grid.nii"), &nifti).unwrap();
    fs::write(folder.join("packed.nii.gz"), gzip(&nifti)).unwrap();
    fs::write(folder.join("level.gz"), gzip(b"a level")).unwrap();
    fs::write(folder.join("texture.raw"), &voxels).unwrap();
    write_phases(&folder.join("phases"));
    write_array(&folder.join("array.npy"));
    let options = "[remap]\n\nimporter=\"lumivox.volume\"\ntype=\"LumivoxVolume\"\n\n[params]\n\nspacing=\"0.5,1,2\"\n\
                   axes=\"RAS\"\nlayout=\"xyz\"\nslope=\"2\"\nintercept=\"-100\"\nmodality=\"MR\"\nunit=\"mg\"\n";
    fs::write(folder.join("array.npy.import"), options).unwrap();
}

/// An array of NumPy of 4 x 5 x 6 values from 0 on, the last axis the fastest.
fn write_array(path: &Path) {
    let header = "{'descr': '<i2', 'fortran_order': False, 'shape': (4, 5, 6), }";
    let header = format!("{header:<117}\n");
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    let values: Vec<u8> = (0..120_i16).flat_map(i16::to_le_bytes).collect();
    fs::write(path, [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), &values].concat()).unwrap();
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(vec![], flate2::Compression::fast());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

/// A series of two phases, whose second is flat, that the import dock is told to take the second of.
fn write_phases(folder: &Path) {
    // Few: the editor draws itself anew for each file that it imports, which takes a second in software.
    scans::write_series_number(&cube(6), folder, 3);
    add_flat_phase(folder);
    let options = "[remap]\n\nimporter=\"lumivox.dicom\"\ntype=\"LumivoxVolume\"\n\n[params]\n\nseries=\"\"\nphase=2\n\
                   compress=true\n";
    fs::write(folder.join("CT0001.dcm.import"), options).unwrap();
}

/// Outside the project: a series of two phases, a smaller one, and files that are none.
fn write_study(folder: &Path) {
    scans::write_series_number(&cube(20), &folder.join("good/large"), 4);
    add_flat_phase(&folder.join("good/large"));
    scans::write_series_number(&cube(12), &folder.join("good/small"), 5);
    fs::create_dir_all(folder.join("bad")).unwrap();
    fs::write(folder.join("bad/notes.txt"), "Nothing to see here.\n").unwrap();
    fs::write(folder.join("bad/page.dcm"), "<html>Not found</html>\n").unwrap();
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n\
                  ElementDataFile = ../samples.raw\n";
    fs::create_dir_all(folder.join("outside/header")).unwrap();
    fs::write(folder.join("outside/header/scan.mhd"), header).unwrap();
    fs::write(folder.join("outside/samples.raw"), [0, 1, 2, 3, 4, 5, 6, 7]).unwrap();
    write_array(&folder.join("array.npy"));
}

/// Adds to each slice of a series one of a second acquisition in the same place, all of whose samples are 100.
fn add_flat_phase(folder: &Path) {
    let slices: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    for path in slices {
        let mut file = fs::read(&path).unwrap();
        let value = |file: &[u8], tag: [u8; 4], vr: &[u8]| {
            let head = [&tag[..], vr].concat();
            let at = file.windows(6).position(|bytes| bytes == head).unwrap() + 6;
            at + 2..at + 2 + usize::from(u16::from_le_bytes([file[at], file[at + 1]]))
        };
        let acquisition = value(&file, [0x20, 0, 0x12, 0], b"IS");
        file[acquisition.start] = b'2';
        let uid = file[value(&file, [8, 0, 0x18, 0], b"UI")].to_vec();
        let places: Vec<usize> =
            (0..file.len() - uid.len()).filter(|&i| file[i..].starts_with(&uid)).collect();
        assert_eq!(places.len(), 2, "in the header and in the data");
        for place in places {
            let digit = &mut file[place + 8];
            *digit = if *digit == b'9' { b'1' } else { *digit + 1 };
        }
        let pixels = file.windows(6).position(|bytes| bytes == b"\xe0\x7f\x10\0OW").unwrap() + 12;
        file[pixels..].chunks_exact_mut(2).for_each(|sample| sample.copy_from_slice(&[100, 0]));
        fs::write(path.with_file_name(format!("second_{}", path.file_name().unwrap().display())), file)
            .unwrap();
    }
}

#[test]
fn edit_mode_shows_what_play_mode_shows() {
    let wanted = expected::picture(&case());
    assert_same(&edited().1, "edited", &wanted, |_| true);
    // Again, after edits that were undone.
    assert_same(&edited().1, "undone", &wanted, |_| true);
}

#[test]
fn an_idle_editor_converges_and_then_rests() {
    let told = telling("idle");
    assert_eq!(told["low_processor_mode"], true, "an editor that always draws proves nothing");
    assert_eq!(told["converged"], true, "{told}");
    assert_eq!(told["after"]["samples"], case().samples, "{told}");
    assert!(told["drawn_at_rest"].as_i64().unwrap() < 10, "the editor goes on drawing: {told}");
}

#[test]
fn four_views_converge_each() {
    let told = telling("four");
    let views = told["views"].as_array().unwrap();
    assert_eq!(views.len(), 4);
    for view in views {
        assert_eq!(view["status"]["samples"], case().samples, "{view}");
    }
}

#[test]
fn an_edit_restarts_the_image_and_can_be_undone() {
    let told = telling("undo");
    let density = case().volumes[0].density;
    for (step, wanted) in
        [("before", density), ("after", 4.0 * density), ("undone", density), ("redone", 4.0 * density)]
    {
        assert!((told[step].as_f64().unwrap() - wanted).abs() < 1e-6, "{step}: {told}");
    }
    assert_eq!((&told["restarted"], &told["converged"]), (&json!(true), &json!(true)), "{told}");
}

#[test]
fn the_inspector_groups_and_edits_properties() {
    let told = telling("inspector");
    let strings = |key: &str| -> Vec<&str> {
        told[key].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect()
    };
    assert_eq!(strings("groups")[..4], ["Medium", "Surface", "Parts", "Clip"]);
    let properties = [
        "volume",
        "transfer_function",
        "density",
        "surface_strength",
        "labels",
        "keep_everything",
        "peel_mm",
        "clip_min",
        "clip_max",
    ];
    for property in properties {
        assert!(strings("properties").contains(&property), "{property} is not in the inspector");
    }
    assert_eq!(
        (&told["clipped"], &told["clipped_of_effect"]),
        (&json!([]), &json!([])),
        "names that do not fit"
    );
    assert_eq!(told["edited"], 0.25, "{told}");
    assert_eq!(told["undone"], true, "{told}");
}

#[test]
fn the_dock_edits_the_selected_volume_with_undo() {
    let told = telling("dock");
    for fact in ["visible", "follows", "preset_undone"] {
        assert_eq!(told[fact], true, "{fact}: {told}");
    }
    assert!((told["moved"].as_f64().unwrap() - 0.75).abs() < 1e-6, "{told}");
    assert_eq!(told["undone"], told["knot"], "{told}");
    assert_eq!(told["action"], "Edit Transfer Function");
    assert_eq!((&told["preset"], &told["preset_action"]), (&json!("ct-bone"), &json!("Apply Preset")));
}

#[test]
fn the_dock_is_raised_by_what_it_edits_and_shows_what_is_in_force() {
    let told = telling("raised");
    for fact in ["hidden", "by_node", "by_function", "edits_it", "by_script", "edits_that", "by_empty"] {
        assert_eq!(told[fact], true, "{fact}: {told}");
    }
    let suited = &told["suited"];
    for fact in ["shown", "as_preset", "adopted", "moved", "undone", "shown_again", "redone", "redone_knot"] {
        assert_eq!(suited[fact], true, "{fact}: {told}");
    }
    assert_eq!(suited["notice"], "Bare: CT muscle, which suits its scan, until you choose or edit");
    assert_eq!(suited["chosen"], "Bare: begun with CT bone");
    assert_eq!(told["clipped"], json!([]), "labels that do not fit");
}

#[test]
fn a_handle_in_the_viewport_moves_the_clip_box() {
    let told = telling("gizmo");
    assert_eq!(told["found"], true);
    assert!((told["dragged"].as_f64().unwrap() - 0.7).abs() < 0.02, "{told}");
    assert_eq!(told["undone"], true);
}

#[test]
fn shapes_that_cut_are_drawn() {
    let told = telling("clip");
    assert_eq!(told["gizmos"], 1, "{told}");
    // Four and twelve edges, three circles; an arrow each.
    assert_eq!(told["lines"], json!([[8, 6], [24, 6], [288, 6]]), "{told}");
}

#[test]
fn a_button_finds_the_parts_of_a_scan_and_can_be_cancelled() {
    let told = telling("parts");
    for fact in ["before", "offered", "cancelled", "found", "file", "undone"] {
        assert_eq!(told[fact], true, "{fact}: {told}");
    }
    assert_eq!(told["path"], "res://scan_labels.res");
    assert!(told["names"].as_array().unwrap().contains(&json!("body")), "{told}");
}

#[test]
fn every_class_has_its_page_of_help() {
    let told = telling("help");
    for (class, words) in [
        ("LumivoxVolume3D", "transfer_function"),
        ("LumivoxVolume", "get_spacing_mm"),
        ("LumivoxTransferFunction", "opacity_knots"),
        ("LumivoxEffect", "frame_budget_ms"),
        ("LumivoxImporter", "finished"),
        ("Lumivox", "is_converged"),
        ("LumivoxLabels", "found_in"),
        ("LumivoxClip3D", "SHAPE_SPHERE"),
    ] {
        let text = told[class].as_str().unwrap();
        assert!(text.contains(words), "the help of {class} does not mention {words}:\n{text}");
        assert!(text.contains("Description"), "{class} is not described:\n{text}");
        let bare = text.matches("There is currently no description").count();
        assert_eq!(bare, 0, "{class} has {bare} members without a description:\n{text}");
    }
}

#[test]
fn files_in_the_project_become_volumes() {
    let told = telling("scans");
    let dims = |file: &str| told[file]["dims"].clone();
    assert_eq!(dims("ct/CT0001.dcm"), json!([24, 24, 24]), "{told}");
    assert_eq!(dims("packed.nii.gz"), json!([4, 5, 6]));
    assert_eq!(dims("grid.nrrd"), json!([5, 6, 7]));
    assert_eq!(dims("grid.nii"), json!([4, 5, 6]));
    assert_eq!(told["grid.nrrd"]["spacing"], json!([1.0, 2.0, 3.0]));
    assert_eq!(told["grid.nrrd"]["range"], json!([0.0, 209.0]));
    assert_eq!(told["grid.nii"]["spacing"], json!([1.5, 2.0, 2.5]));
    assert_eq!(told["ct/CT0002.dcm"]["part_of"], "res://scans/ct/CT0001.dcm");
    // By what they are: folders and archives are often called by the patient's name.
    let names = ["ct/CT0001.dcm", "ct/CT0002.dcm", "former.zip", "grid.nii", "phases/CT0001.dcm"];
    let names = names.map(|file| told[file]["name"].as_str().unwrap().to_owned());
    assert_eq!(
        names,
        ["CT series 1", "Part of a scan", "CT series 1", "NIfTI scan", "CT series 3"],
        "{told}"
    );
    assert_eq!(
        (&told["ct/CT0001.dcm"]["unit"], &told["grid.nii"]["unit"]),
        (&json!("HU"), &json!("")),
        "{told}"
    );
    let phase = &told["phases/CT0001.dcm"];
    assert_eq!(phase["dims"], json!([6, 6, 6]), "{told}");
    assert_eq!(phase["range"][0], phase["range"][1], "the dock's option asks for the flat phase: {phase}");
}

#[test]
fn what_may_be_anything_is_a_volume_only_where_it_was_made_one() {
    let told = telling("scans");
    for file in ["archive.zip", "level.gz", "texture.raw", "data.zip"] {
        assert_eq!(told[file], Value::Null, "{file} was imported: {told}");
    }
    assert_eq!(
        told["former.zip"]["dims"],
        json!([24, 24, 12]),
        "a volume before is one in a fresh copy: {told}"
    );
    let told = telling("listed");
    assert_eq!(told["settings"], json!(["res://scans/former.zip.import"]), "{told}");
    // Godot exports what it lists, but text files.
    for file in ["archive.zip", "level.gz", "texture.raw", "data.zip"] {
        assert_eq!(told["types"][file], "TextFile", "{told}");
    }
    assert_eq!(told["types"]["former.zip"], "LumivoxVolume", "{told}");
}

#[test]
fn the_file_systems_menu_imports_an_archive_and_a_raw_file() {
    let told = telling("menu");
    assert_eq!(told["listed"], telling("listed")["types"], "later, too: {told}");
    assert_eq!(told["offered"], json!({"archive.zip": true, "ct": true, "grid.nrrd": false}), "{told}");
    assert_eq!(told["archive"], json!([24, 24, 12]), "{told}");
    let lacking = told["undescribed"].as_str().unwrap();
    assert!(lacking.contains("texture.raw") && told["asks"] == true, "{told}");
    assert!(told["misdescribed"].as_str().unwrap().contains("'5x6' does not describe"), "{told}");
    assert_eq!((&told["raw"], &told["raw_range"]), (&json!([5, 6, 7]), &json!([0.0, 209.0])), "{told}");
    assert_eq!(told["dropped"], json!([true, false]), "{told}");
}

#[test]
fn the_dialog_tells_series_apart_and_imports_the_phase_that_is_asked_for() {
    let told = telling("dialog");
    let rows = told["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2, "{told}");
    assert_eq!((&rows[0][2], &rows[0][3], &rows[0][5]), (&json!("20 × 20 × 20"), &json!("2"), &json!("")));
    assert_eq!(
        (&rows[1][2], &rows[1][3], &rows[1][5]),
        (&json!("12 × 12 × 12"), &json!("1"), &json!("fewer voxels"))
    );
    assert!(told["second"].as_str().unwrap().contains("Not the first choice: fewer voxels"), "{told}");
    let first = told["first"].as_str().unwrap();
    assert!(first.contains("CT, axial") && !first.contains("Not the first choice"), "{told}");
    // After the series, not after the folder, which is often called by the patient's name.
    assert_eq!(told["proposed"], json!(["res://ct_series_4.res", "res://ct_series_5.res"]), "{told}");
    assert_eq!(told["added"], true, "{told}");
    assert_eq!(told["range"][0], told["range"][1], "the second phase is the flat one: {told}");
    assert_eq!(told["undone"], true, "{told}");
    assert!(told["nowhere"].as_str().unwrap().contains("There is no folder or file"), "{told}");
    assert!(!told["bad"].as_str().unwrap().is_empty() && told["bad_step"] == 0, "{told}");
}

#[test]
fn the_dialog_allows_data_outside_of_one_header_s_folder() {
    let told = &telling("dialog")["outside"];
    // Asked for only where a header may name files.
    assert_eq!((&told[0], &told[1]), (&json!(false), &json!(true)), "{told}");
    let refused = told[3].as_str().unwrap();
    assert!(told[2] == 0 && refused.contains("'Allow data outside the scan's folder'"), "{told}");
    assert_eq!(told[4], 2, "allowed, it is ready: {told}");
    assert_eq!((&told[5], &told[6]), (&json!(false), &json!(0)), "the next one is distrusted: {told}");
}

#[test]
fn a_folder_dropped_while_the_dialog_works_is_refused_and_disturbs_nothing() {
    let told = telling("dialog");
    for (i, step) in [3, 4].into_iter().enumerate() {
        let refused = &told["refused"][i];
        assert_eq!((&refused[0], &refused[1]), (&json!(step), &json!(step)), "{told}");
        assert!(refused[2].as_str().unwrap().contains("small was not opened: one scan at a time"), "{told}");
    }
    assert_eq!(told["as_before"], true, "when it is stopped, the series is described again: {told}");
    assert_eq!(told["saved_as"], "res://opened.res", "{told}");
}

#[test]
fn the_dialog_pictures_the_series_that_is_chosen_without_waiting() {
    let told = telling("dialog");
    let [first, second, last, again] = [0, 1, 2, 3].map(|i| &told["pictures"][i]);
    assert!(first.as_array().is_some_and(|picture| picture.len() == 3), "{told}");
    assert_ne!(first, second, "{told}");
    assert_eq!((last, again), (second, first), "{told}");
    assert_eq!(told["waited"], false, "the picture is there when its series is chosen: {told}");
    assert_eq!(told["stopped"], true, "{told}");
}

#[test]
fn a_preset_for_several_volumes_is_one_step_of_undo() {
    let told = telling("several");
    for by in ["inspector", "dock"] {
        for fact in ["applied", "undone", "redone", "undone_again"] {
            assert_eq!(told[by][fact], true, "{by}, {fact}: {told}");
        }
        assert_eq!(told[by]["action"], "Apply Preset to 2 Volumes", "{told}");
    }
}

#[test]
fn the_view_is_saved_as_a_scene_file() {
    let view = telling("view");
    assert!(view["made"].as_str().unwrap().contains("was made in memory"), "{view}");
    assert_eq!((&view["shown"], &view["saved"]), (&json!(true), &json!("")), "{view}");
    let text = fs::read_to_string(view["file"].as_str().unwrap()).unwrap();
    let document = lumivox_core::document::SceneDocument::parse(&text).unwrap();
    assert!(document.volumes[0].scan.files[0].ends_with("scans/grid.nrrd"), "{text}");
    assert!(document.camera.world_from_camera.is_some() && document.film.size[0] > 100, "{text}");
    assert_eq!(document.lights.len(), 1, "{text}");
}

#[test]
fn the_editor_ends_without_a_word_about_signals() {
    let log = &edited().0.log;
    assert!(!log.contains("auto-disconnected"), "{log}");
}

#[test]
fn a_file_that_cannot_be_read_is_named_and_stops_no_other() {
    assert_eq!(telling("scans")[BROKEN], Value::Null);
    let log = &edited().0.log;
    let reason = log.lines().find(|line| line.contains(BROKEN) && line.contains("cut short"));
    assert!(reason.is_some(), "the log does not say what is wrong with {BROKEN}");
    assert!(log.contains(&format!("res://scans/{BROKEN} was not imported")), "nor that it was not imported");
}

#[test]
fn the_plugin_can_be_switched_off_and_on() {
    assert_eq!(telling("plugin"), json!({ "gone": true, "back": true, "warned": true, "content": true }));
}

#[test]
fn a_new_node_says_what_it_lacks_and_offers_ways_to_a_scan() {
    let told = telling("empty");
    assert_eq!(told["offers"], "Give to New", "{told}");
    for fact in ["warned", "gizmo", "given", "content", "undone", "phantom", "saved"] {
        assert_eq!(told[fact], true, "{fact}: {told}");
    }
}

/// What came of the checks of a game that was used with the mouse or with fingers.
fn used(how: &str) -> Value {
    static RUN: OnceLock<Option<Run>> = OnceLock::new();
    told(once(&RUN, || run_scene_in_window("use_editor", "use_editor", &json!([])).1), how)
}

fn assert_all(checks: &Value, count: usize) {
    let checks = checks.as_object().unwrap();
    let failed: Vec<_> = checks.iter().filter(|(_, ok)| **ok != true).map(|(what, _)| what).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert_eq!(checks.len(), count, "some checks were left out: {checks:#?}");
}

#[test]
fn the_transfer_function_editor_works_with_the_mouse_in_a_game() {
    assert_all(&used("mouse"), 17);
}

#[test]
fn the_transfer_function_editor_and_the_camera_work_with_fingers() {
    assert_all(&used("touch"), 13);
}
