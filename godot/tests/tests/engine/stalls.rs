//! What frames wait for: nothing that can be prepared, and meanwhile there is a picture.

use std::sync::OnceLock;

use serde_json::{Value, json};

use crate::case::{Case, Light, Volume};
use crate::engine::{Run, once};
use crate::shown::{run_scene, told};

/// Scenes that want a kernel each: all that the script warms up for.
fn scenes() -> Vec<Case> {
    let base = || Case {
        size: [48, 48],
        samples: 4,
        budget: 20.0,
        kept_light: true,
        light: Light::Color([0.8; 3]),
        volumes: vec![Volume::solid()],
        ..Case::new("plain")
    };
    let glossy = Volume { surface: [0.7, 60.0, 0.4, 0.04, 0.0], ..Volume::solid() };
    let volumes = [vec![glossy.clone()], vec![Volume::solid(); 5], vec![glossy; 5]];
    std::iter::once(base()).chain(volumes.map(|volumes| Case { volumes, ..base() })).collect()
}

fn run() -> &'static Run {
    static RUN: OnceLock<Option<Run>> = OnceLock::new();
    once(&RUN, || run_scene("stalls", "stalls", &json!({ "scenes": scenes() })).1)
}

fn telling(name: &str) -> Value {
    told(run(), name)
}

#[test]
fn a_volume_stays_in_the_picture_while_its_next_kernel_is_made() {
    let told = telling("before");
    println!("before: {told}");
    // Each frame from the change of filter until the new picture is done, and how much of it the volume filled.
    let filled: Vec<f64> = serde_json::from_value(told["filled"].clone()).unwrap();
    assert!(filled.len() > 2 && filled.iter().all(|share| *share > 0.05), "{filled:?}");
    // And from a change of the environment.
    let relit: Vec<f64> = serde_json::from_value(told["relit"].clone()).unwrap();
    assert!(relit.len() > 2 && relit.iter().all(|share| *share > 0.05), "{relit:?}");
    assert_eq!(told["stalls"]["kernels"], 0, "no frame waits for a kernel: {told}");
    assert_eq!(told["stalls"]["computed"], 0, "nor looks at voxels: {told}");
    assert!(told["stalls"]["postponed"].as_u64() > Some(0), "the scene before is shown instead: {told}");
}

#[test]
fn a_scan_that_was_replaced_leaves_the_device_also_after_the_light_changed() {
    let told = telling("replaced");
    println!("replaced: {told}");
    let [before, scan, relit, replaced] =
        ["before", "scan", "relit", "replaced"].map(|name| told[name].as_f64().expect("megabytes"));
    // 200^3 voxels of 16 bits.
    assert!(scan - before > 16.0, "{told}");
    assert!(replaced - relit < 12.0, "both scans are there: {told}");
}

#[test]
fn what_is_drawn_once_is_whole_in_its_only_frame() {
    for name in ["once", "once_under_sky"] {
        let told = telling(name);
        println!("{name}: {told}");
        assert!(told["filled"].as_f64().unwrap() > 0.05, "{name}: {told}");
        assert_eq!(told["samples"], scenes()[0].samples, "{name}: {told}");
    }
}

#[test]
fn after_a_warm_up_no_frame_makes_or_waits_for_a_kernel() {
    let told = telling("warm_up");
    println!("warm_up: {told}");
    assert_eq!(told["progress"], 1.0);
    assert_eq!(told["converged"], json!(vec![true; scenes().len()]), "{told}");
    assert_eq!(told["kept"], json!(vec![true; scenes().len()]), "{told}");
    assert_eq!(told["stalls"], json!({ "kernels": 0, "computed": 0, "postponed": 0 }), "{told}");
}

#[test]
fn a_warm_up_without_anything_to_do_ends_too_and_one_for_nothing_known_is_refused() {
    assert_eq!(telling("again"), json!({ "ended": true }));
    assert_eq!(telling("unknown"), json!({ "progress": 1.0 }));
}
