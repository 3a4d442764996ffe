//! What a `LumivoxEffect` asks for, wherever it is, whoever frees it and whenever.

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use lumivox_core::glam::DVec3;
use serde_json::{Value, json};

use crate::case::{Case, Lamp, LampKind, Place};
use crate::engine::{Run, Start, engine, once};
use crate::expected;
use crate::shown::{assert_same, run_scene, told};

/// What Godot 4.6 says of a render thread of its own in an empty project, too.
const EXCUSED: &[&str] = &[
    "separate rendering thread",
    "(finalize) can only be called from the render thread",
    "ObjectDB instances leaked",
];

fn soft() -> Case {
    Case { samples: 8, size: [64, 48], ..Case::new("soft") }
}

fn lit() -> Case {
    let place = Place::at(DVec3::new(-0.02, 0.03, 0.03));
    Case { lamps: vec![Lamp { energy: 0.05, ..Lamp::new(LampKind::Omni, place) }], ..soft() }
}

/// What `project/effects.gd` leaves: pictures, and its log.
fn shown() -> &'static (PathBuf, Run) {
    static SHOWN: OnceLock<Option<(PathBuf, Run)>> = OnceLock::new();
    once(&SHOWN, || run_scene("effects", "effects", &json!({"soft": soft(), "lit": lit()})))
}

fn telling(name: &str) -> Value {
    told(&shown().1, name)
}

fn assert_shows(name: &str) {
    assert_same(&shown().0, name, &expected::picture(&soft()), |_| true);
}

#[test]
fn a_volume_hidden_and_shown_is_back_and_so_are_the_scenes_own_effects() {
    let told = telling("hide_and_show");
    assert_eq!(told, json!({"converges": true, "others are called": true, "again": true}));
    assert_shows("shown_again");
    let told = telling("hide_and_show_beside_another");
    for (what, holds) in told.as_object().unwrap() {
        assert_eq!(*holds, true, "{what}: {told}");
    }
}

#[test]
fn the_first_enabled_effect_draws_volumes_once() {
    assert_shows("two_effects");
    for name in ["after_a_disabled_one", "effects_shared", "effects_shared_too"] {
        assert_shows(name);
    }
}

#[test]
fn a_disabled_effect_is_done_and_draws_nothing() {
    let told = telling("disabled");
    let nothing = json!({"status": {}, "converged": true});
    assert_eq!(told["from the start"], nothing);
    assert_eq!(told["later"], nothing);
    for what in ["enabled", "empty", "again"] {
        assert_eq!(told[what], true, "{what}: {told}");
    }
    assert_shows("enabled_again");
}

#[test]
fn nodes_freed_at_once_hold_nothing_up() {
    assert_shows("after_freed_nodes");
}

#[test]
fn an_effect_is_freed_while_a_render_thread_of_its_own_draws() {
    let case = Case { samples: 16, size: [48, 36], budget: 4.0, ..Case::new("swapped") };
    let run = {
        let engine = engine();
        let folder = engine.out.join("swap_effects");
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("cases.json");
        fs::write(&file, serde_json::to_vec(&case).unwrap()).unwrap();
        let [project, cases, out] = [&engine.project, &file, &folder].map(|path| path.to_str().unwrap());
        let scene = "res://tests/swap_effects.tscn";
        let thread = ["--path", project, "--render-thread", "separate"];
        let arguments = [&thread[..], &[scene, "--", "--cases", cases, "--out", out]].concat();
        let start = Start { excused: EXCUSED, ..Start::default() };
        (folder.clone(), engine.run_as(&engine.godot, "swap_effects", &arguments, &start))
    };
    assert_eq!(told(&run.1, "swapped"), 300);
    assert_same(&run.0, "swapped", &expected::picture(&case), |_| true);
}
