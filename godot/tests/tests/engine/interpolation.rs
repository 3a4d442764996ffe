//! What physics moves is shown between its ticks, volumes and lights as meshes are.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use lumivox_core::glam::DVec3;
use serde_json::json;

use crate::case::{Case, Lamp, LampKind, Light, Mesh, Place, Volume, look_at};
use crate::engine::{Run, once};
use crate::shown::{run_scene_with, told};

/// A parallel view: a millimetre is as many pixels near as far.
fn base(name: &'static str) -> Case {
    Case {
        camera: look_at(DVec3::new(0.0, 0.0, 0.2), DVec3::ZERO),
        fov: 0.0,
        height: 0.07,
        light: Light::Color([0.8; 3]),
        samples: 4,
        budget: 20.0,
        kept_light: true,
        ..Case::new(name)
    }
}

fn together() -> Case {
    let place = Place::at(DVec3::new(0.0, 0.025, 0.0));
    Case {
        volumes: vec![Volume { place: Place::at(DVec3::new(0.0, -0.008, 0.0)), ..Volume::solid() }],
        meshes: vec![Mesh { size: [0.008; 3], place, color: [0.02, 0.5, 0.02] }],
        ..base("together")
    }
}

fn lamp() -> Case {
    let lamp = Lamp::new(LampKind::Omni, Place::at(DVec3::new(0.0, 0.0, 0.022)));
    Case {
        light: Light::Color([0.0; 3]),
        volumes: vec![Volume { stops: vec![[0.0, 0.8, 0.8, 0.8]], ..Volume::solid() }],
        lamps: vec![Lamp { energy: 0.0005, ..lamp }],
        // How long it takes to follow a light is no business of this test's.
        budget: 1000.0,
        ..base("lamp")
    }
}

/// For each frame the physics tick it follows, and the columns of what is in it.
fn frames(name: &str) -> Vec<(u64, Vec<f64>)> {
    static SHOWN: OnceLock<Option<Run>> = OnceLock::new();
    let run = once(&SHOWN, || {
        // However slow the machine, a tick has twelve frames.
        let options = ["--resolution", "160x90", "--fixed-fps", "24"];
        let cases = json!({"together": together(), "lamp": lamp()});
        run_scene_with(&options, "interpolation", "interpolation", &cases).1
    });
    let frames: Vec<Vec<f64>> = serde_json::from_value(told(run, name)).unwrap();
    frames.into_iter().map(|frame| (frame[0] as u64, frame[1..].to_vec())).collect()
}

/// The longest way between two frames of one tick, and of all.
fn ways(frames: &[(u64, Vec<f64>)], of: usize) -> [f64; 2] {
    let mut ticks: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for (tick, columns) in frames {
        ticks.entry(*tick).or_default().push(columns[of]);
    }
    let way = |columns: &[f64]| {
        columns.iter().copied().fold(f64::MIN, f64::max) - columns.iter().copied().fold(f64::MAX, f64::min)
    };
    let all: Vec<f64> = ticks.values().flatten().copied().collect();
    [ticks.values().map(|columns| way(columns)).fold(0.0, f64::max), way(&all)]
}

#[test]
fn a_volume_keeps_to_the_mesh_beside_it_between_physics_ticks() {
    let frames = frames("together");
    let [within, all] = ways(&frames, 1);
    assert!(all > 15.0 && within > 0.3 * all, "the mesh moves {within} of {all} pixels: {frames:?}");
    for (tick, columns) in &frames {
        let apart = columns[0] - columns[1];
        assert!(apart.abs() < 2.0, "{apart} pixels apart after tick {tick}: {frames:?}");
    }
}

#[test]
fn a_light_moves_on_between_physics_ticks() {
    let frames = frames("lamp");
    let [within, all] = ways(&frames, 0);
    assert!(all > 4.0 && within > 0.3 * all, "the light moves {within} of {all} pixels: {frames:?}");
}
