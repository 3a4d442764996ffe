//! What the addon puts into the real editor to be seen and pressed, as `project/editor/controls.gd` looks at it.

use serde_json::json;

use crate::editor::telling;

#[test]
fn every_node_and_resource_has_an_icon() {
    let told = telling("icons");
    let icons = told.as_object().unwrap();
    let lacking: Vec<_> = icons.iter().filter(|(_, is)| **is != true).map(|(class, _)| class).collect();
    assert!(lacking.is_empty(), "without an icon that exists: {lacking:?}");
    for class in ["LumivoxVolume3D", "LumivoxClip3D", "LumivoxLabels", "LumivoxVolumePanel"] {
        assert!(icons.contains_key(class), "{class} was not looked at: {told}");
    }
}

#[test]
fn handles_never_cover_a_box() {
    let told = telling("handles");
    println!("handles: {told}");
    let pixels = |diagonal: &str, what: &str| told[diagonal][what].as_f64().unwrap();
    let covered = |diagonal: &str| pixels(diagonal, "handles") / pixels(diagonal, "box");
    assert!(pixels("30", "box") > 100.0, "{told}");
    assert!(covered("30") < 0.06, "a box of 30 pixels is covered: {told}");
    assert!(covered("100") > 0.02 && covered("100") < 0.3, "{told}");
    // Where there is room they are as large as the editor's others.
    assert!(pixels("300", "handles") > 200.0, "{told}");
    assert_eq!(told["moved"], false, "what is not seen cannot be dragged: {told}");
}

#[test]
fn galleries_of_presets_stay_on_the_screen_and_are_the_only_list() {
    let told = telling("galleries");
    assert_eq!(told["corners"], json!([true, true, true, true]), "{told}");
    for fact in ["inspector", "listed", "chosen", "undone"] {
        assert_eq!(told[fact], true, "{fact}: {told}");
    }
}

#[test]
fn new_shapes_fit_what_is_kept_of_the_volume_above() {
    let told = telling("fits");
    assert_eq!(told["fitted"], true, "{told}");
    for shape in ["box", "sphere", "plane"] {
        assert!(told[shape].as_f64().unwrap() < 1e-5, "{shape}: {told}");
    }
}

#[test]
fn the_scene_dock_warns_of_paint_that_the_look_hides() {
    let told = telling("parts");
    for fact in ["painted", "content"] {
        assert_eq!(told[fact], true, "{fact}: {told}");
    }
}

#[test]
fn the_import_dock_says_what_an_array_does_not() {
    let told = &telling("scans")["array.npy"];
    // Voxels are in the file's order, and its last axis, the fastest, is z.
    assert_eq!((&told["dims"], &told["spacing"]), (&json!([6, 5, 4]), &json!([2.0, 1.0, 0.5])), "{told}");
    assert_eq!((&told["range"], &told["unit"]), (&json!([-100.0, 138.0]), &json!("mg")), "{told}");
}

#[test]
fn the_import_dialog_asks_for_what_an_array_does_not_say() {
    let told = telling("arrays");
    assert_eq!(told["asks"], true, "{told}");
    assert!(told["refused"].as_str().unwrap().contains("0.5,0.5,2, LPS and zyx"), "{told}");
    assert_eq!((&told["dims"], &told["spacing"]), (&json!([6, 5, 4]), &json!([2.0, 1.0, 0.5])), "{told}");
    assert_eq!(told["asks_of_others"], false, "a series says it: {told}");
    assert_eq!(told["cleared"], true, "nor is one array as the one before: {told}");
}
