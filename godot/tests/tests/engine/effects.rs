//! What a `LumivoxEffect` asks for, wherever it is, whoever frees it and whenever.

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use lumivox_core::glam::DVec3;
use serde_json::{Value, json};

use crate::case::{Case, Lamp, LampKind, Mesh, Place, Volume};
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

/// A bar in the midst of the volume, at that x.
fn beside_mesh(x: f64) -> Case {
    let bar = Mesh { size: [0.01, 0.1, 0.004], place: Place::at(DVec3::X * x), color: [0.1, 0.3, 0.1] };
    Case { meshes: vec![bar], samples: 48, ..soft() }
}

/// Opaque, in light of one colour.
fn solid() -> Case {
    Case { volumes: vec![Volume::solid()], ..soft() }
}

/// What `project/effects.gd` leaves: pictures, and its log.
fn shown() -> &'static (PathBuf, Run) {
    static SHOWN: OnceLock<Option<(PathBuf, Run)>> = OnceLock::new();
    let cases = || {
        json!({
            "soft": soft(),
            "lit": lit(),
            "mesh": beside_mesh(-0.008),
            "moved_mesh": beside_mesh(0.008),
            "solid": solid(),
        })
    };
    once(&SHOWN, || run_scene("effects", "effects", &cases()))
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
    for name in ["after_a_disabled_one", "effects_shared", "effects_shared_too", "at_another_stage"] {
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
fn settings_draw_a_frame_of_an_engine_that_idles() {
    let told = telling("redraws");
    let told = told.as_object().unwrap();
    assert_eq!(told.len(), 9);
    for (property, what) in told {
        assert_eq!(what["idle"], true, "before {property}: {told:?}");
        assert!(what["frames"].as_u64().unwrap() > 0, "{property}: {told:?}");
    }
}

/// Nobody but the GPU knows that pixels started over.
#[test]
fn a_mesh_that_moves_once_in_an_engine_that_idles_leaves_a_finished_image() {
    let told = telling("moved_mesh");
    assert_eq!(told, json!({"idle": true, "rests again": true, "converged": true}));
    assert_same(&shown().0, "moved_mesh", &expected::picture(&beside_mesh(0.008)), |_| true);
}

/// The engine shows light of one colour as bright at any exposure, and so is what it falls on.
#[test]
fn cameras_of_different_exposures_see_one_flat_light() {
    assert_eq!(telling("exposures"), json!({"first": true, "second": true}));
    let (wanted, film) = (expected::picture(&solid()), expected::film(&solid()));
    for name in ["exposed_little", "exposed_much"] {
        assert_same(&shown().0, name, &wanted, |pixel| film.alpha(pixel) == 1.0);
    }
}

#[test]
fn settings_keep_to_their_ranges() {
    let told = telling("limits");
    let wanted = json!({
        "exposure": [64.0, -64.0, 3.5],
        "target_samples": [1.0, 65536.0, 77.0],
        "target_noise": [0.0, 1.0, 0.25],
        "frame_budget_ms": [0.5, 10_000.0, 5.0],
        "resolution_scale": [0.1, 1.0, 0.25],
        "environment_source": [0.0, 1.0, 0.0],
    });
    for (property, values) in wanted.as_object().unwrap() {
        let kept = told[property].as_array().unwrap().iter().map(Value::as_f64);
        assert!(kept.eq(values.as_array().unwrap().iter().map(Value::as_f64)), "{property}: {told}");
    }
    for property in ["exposure", "target_noise", "frame_budget_ms", "resolution_scale"] {
        assert_eq!(told[format!("{property} stays")], true, "{property} took what is no number");
        let named = format!("LumivoxEffect.{property}");
        assert_eq!(shown().1.log.matches(&named).count(), 3, "an error names {named}");
    }
}

#[test]
fn sources_of_light_have_names_and_settings_units() {
    let told = telling("constants");
    assert_eq!(told["constants"], json!({"ENVIRONMENT_SCENE": 0, "ENVIRONMENT_STUDIO": 1}));
    assert_eq!(told["units"], json!({"exposure": "EV", "frame_budget_ms": "ms"}));
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
