//! A volume's node as scripts use it: numbers that it does not take, other threads, and an engine that rests.

use std::sync::OnceLock;

use lumivox_core::medium::MAX_DENSITY_SCALE;
use lumivox_core::{CancelToken, Progress};
use lumivox_phantom::{SeriesDescription, cube, write_dicom_series};
use serde_json::{Value, json};

use crate::case::Case;
use crate::engine::{Run, engine, once};
use crate::shown::{run_scene, told};

fn run() -> &'static Run {
    static RUN: OnceLock<Option<Run>> = OnceLock::new();
    once(&RUN, || {
        let series = engine().out.join("use_node_series");
        let description = SeriesDescription::default();
        write_dicom_series(&cube(16), &series, &description, Progress::SILENT, &CancelToken::new()).unwrap();
        let case = Case { size: [32, 32], samples: 4, budget: 5.0, ..Case::new("used") };
        run_scene("use_node", "use_node", &json!({ "case": case, "series": series })).1
    })
}

fn telling(name: &str) -> Value {
    told(run(), name)
}

#[test]
fn scripts_hear_when_an_image_is_done() {
    let told = telling("signals");
    assert_eq!(told, json!({ "converged": 1, "arrived": 1, "other": 0, "progress": 1.0 }));
}

#[test]
fn scripts_hear_what_became_of_a_preparation() {
    let told = telling("prepared");
    assert_eq!(told["prepared"], 0, "{told}");
    assert!(told["failed"].as_str().unwrap().starts_with("No airways were found"), "{told}");
}

#[test]
fn a_label_that_there_is_not_is_an_error_that_names_the_nearest() {
    let told = telling("labels");
    println!("labels: {told}");
    assert_eq!(told["set"], true, "{told}");
    assert_eq!(told["opacity"], json!([0.25, 0.25]), "{told}");
    assert_eq!(
        (&told["lung"], &told["field"], &told["value"]),
        (&json!(false), &json!(false), &json!(false))
    );
    assert_eq!(told["of_nothing"], Value::Null);
    for said in [
        "there is no label 'Lung'; the nearest is 'lungs'",
        "there is no label 'Nope'",
        "a label has no 'opactiy'; the nearest is 'opacity'",
        "'opacity' of the label 'lungs' cannot be much",
        "LumivoxLabels.found_in: there is no volume to look in",
        "% of what is labelled lies beyond the scan: are they of the same patient?",
    ] {
        assert!(run().log.contains(said), "the log does not say: {said}");
    }
}

#[test]
fn a_game_is_told_of_paint_that_the_look_hides_and_of_no_other() {
    let log = &run().log;
    let said = "LumivoxVolume3D: 'lungs' is painted, but the look hides it";
    assert_eq!(log.matches(said).count(), 1, "{log}");
    // Of the body it shows the bones.
    assert_eq!(log.matches("but the look hides").count(), 1, "{log}");
}

#[test]
fn scripts_have_every_phantom_of_the_command() {
    let told = telling("phantoms");
    let lacking: Vec<_> = told.as_object().unwrap().iter().filter(|(_, is)| **is != true).collect();
    assert!(lacking.is_empty(), "{lacking:?}");
    assert_eq!(told.as_object().unwrap().len(), 11);
}

#[test]
fn an_importer_that_a_worker_thread_starts_signals_on_the_main_thread() {
    assert_eq!(telling("importer"), json!({ "finished": true, "on_main": true, "running": false }));
}

#[test]
fn a_worker_thread_may_change_a_transfer_function_that_is_shown() {
    let told = telling("threads");
    println!("threads: {told}");
    assert_eq!(told["heard"], json!({ "main": 3000, "elsewhere": 1 }), "{told}");
    assert_eq!(told["converged"], true, "{told}");
    assert!((told["shift"].as_f64().unwrap() + 29.99).abs() < 1e-9, "{told}");
}

#[test]
fn every_property_has_an_engine_that_rests_draw_again() {
    let told = telling("redraws");
    println!("redraws: {told}");
    let told = told.as_object().unwrap();
    let still: Vec<_> = told.iter().filter(|(_, frames)| **frames == 0).map(|(name, _)| name).collect();
    assert!(still.is_empty(), "nothing was drawn after a change of {still:?}");
    assert_eq!(told.len(), 20);
}

#[test]
fn numbers_stay_in_the_range_that_the_inspector_shows() {
    let told = telling("numbers");
    let properties = told["properties"].as_object().unwrap();
    assert_eq!(properties.len(), 12, "{told}");
    for (name, one) in properties {
        let hint: Vec<&str> = one["hint"].as_str().unwrap().split(',').collect();
        let (low, high) = (one["low"].as_f64().unwrap(), one["high"].as_f64().unwrap());
        let (least, most) = if one["enum"] == true {
            (0.0, (hint.len() - 1) as f64)
        } else {
            (hint[0].parse().unwrap(), hint[1].parse().unwrap())
        };
        let most = match name.as_str() {
            "density" => MAX_DENSITY_SCALE,
            "surface_gradient" => 1e12,
            _ => most,
        };
        assert_eq!(low, least, "{name}: {one}");
        assert_eq!(high, most, "{name}: {one}");
        assert!(hint.contains(&"or_greater") == ["density", "surface_gradient"].contains(&name.as_str()));
        if let Some(none) = one.get("none") {
            assert_eq!(*none, json!([high, high, high]), "{name}: {one}");
            let said = format!("LumivoxVolume3D.{name} takes neither NaN nor infinity");
            assert!(run().log.contains(&said), "the log does not name {name}");
        }
    }
    assert_eq!(told["kept"], json!([true, true, true, true]));
    for name in ["LumivoxVolume3D.clip_min", "LumivoxVolume3D.clip_max", "LumivoxTransferFunction.shift"] {
        assert!(run().log.contains(&format!("{name} takes neither")), "the log does not name {name}");
    }
}

#[test]
fn colours_that_are_none_leave_the_others() {
    assert_eq!(telling("colors"), json!(["00ff00", "0000ff"]));
}

#[test]
fn scans_of_one_patient_are_aligned() {
    let told = telling("aligned");
    println!("aligned: {told}");
    assert!(told["before"].as_f64().unwrap() > 0.1 && told["after"].as_f64().unwrap() < 1e-5, "{told}");
    assert_eq!((&told["aligned"], &told["refused"]), (&json!(true), &json!([false, false, false])));
}

#[test]
fn filters_and_spaces_have_names() {
    let names = json!({
        "FILTER_NEAREST": 0, "FILTER_TRILINEAR": 1, "FILTER_TRICUBIC": 2, "FILTER_SMOOTH": 3,
        "EXTINCTION_VOLUME": 0, "EXTINCTION_WORLD": 1,
    });
    assert_eq!(telling("constants"), names);
}

#[test]
fn a_scene_keeps_the_preset_and_what_was_changed_after_it() {
    const STORAGE: u64 = 2;
    const EDITOR: u64 = 4;
    const INTERNAL: u64 = 8;
    let told = telling("preset");
    assert_eq!((&told["preset"], &told["density"]), (&json!("ct-bone"), &json!(7.0)), "{told}");
    assert_eq!(told["filter"], 2, "a preset has no filter: {told}");
    let usage = |name: &str| told[name].as_u64().unwrap() & (STORAGE | EDITOR | INTERNAL);
    assert_eq!(usage("preset_usage"), EDITOR, "{told}");
    assert_eq!(usage("chosen_preset_usage"), STORAGE | INTERNAL, "{told}");
}

#[test]
fn a_game_that_shows_one_slice_of_a_series_is_told_of_the_whole() {
    assert_eq!(telling("slice"), true);
    let said = "one slice of a scan, and shows nothing: load res://scans/ct/CT0001.dcm";
    assert!(run().log.contains(said), "the log does not say where the scan is");
}
