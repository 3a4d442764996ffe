//! The demo's scenes, each of which takes a picture of itself when asked to, and ends.

use lumivox_testing::png_io::SrgbImage;
use serde_json::json;

use crate::engine::{Start, engine};
use crate::export::PROBE_LEAK;
use crate::shown::{run_scene, told};

#[test]
fn a_scene_takes_a_picture_of_itself() {
    take_pictures(&["scenes/clipping"]);
}

#[test]
#[ignore = "slow: script/test --all"]
fn the_other_scenes_take_pictures_of_themselves() {
    take_pictures(&[
        "main",
        "scenes/occlusion",
        "scenes/many_volumes",
        "scenes/transfer_function",
        "scenes/vr",
    ]);
}

fn take_pictures(scenes: &[&str]) {
    let engine = engine();
    for scene in scenes {
        let name = format!("demo_{}", scene.trim_start_matches("scenes/"));
        let picture = engine.out.join(&name).with_extension("png");
        let [project, path] = [&engine.project, &picture].map(|path| path.to_str().unwrap());
        let scene = format!("res://{scene}.tscn");
        let view = ["--path", project, "--resolution", "160x90", &scene];
        let asked = ["--", "--screenshot", path, "--samples", "1", "--seconds", "500"];
        let start = Start { excused: &[PROBE_LEAK], ..Start::default() };
        let run = engine.run_as(&engine.godot, &name, &[&view[..], &asked].concat(), &start);
        let shown = SrgbImage::read(&picture).unwrap();
        assert_eq!((shown.width, shown.height), (160, 90), "{scene}");
        // What it says in the end: it waited for a volume, and not in vain.
        let said =
            run.log.lines().find_map(|line| line.strip_prefix(path)?.strip_prefix(": ")?.split_once(' '));
        let (samples, _) = said.unwrap_or_else(|| panic!("{scene} says nothing of its picture"));
        assert!(samples.parse::<u32>().unwrap() >= 1, "{scene} shows no volume");
    }
}

#[test]
fn software_gets_time_to_trace_and_a_gpu_stays_fast() {
    let told = told(&run_scene("software", "software", &json!([])).1, "software");
    let cpu = told["cpu"] == true;
    assert_eq!(told["budget_ms"].as_f64().unwrap() >= 100.0, cpu, "{told}");
    assert_eq!(told["ssao"] == true, !cpu, "{told}");
}
