//! Skies that change while volumes are shown: the light follows, and never is another's on the way.

use std::sync::OnceLock;

use serde::Deserialize;
use serde_json::json;

use crate::case::{Case, Volume};
use crate::engine::{Run, once};
use crate::shown::{run_scene, told};

/// How much a picture of few samples may be off, where 1 is white.
const NOISE: f64 = 0.02;

/// The same of finished ones, whose random numbers may differ.
const REST: f64 = 0.01;

#[derive(Debug, Deserialize)]
struct Change {
    before: [f64; 3],
    /// From the first frame after the change on; the last is finished.
    frames: Vec<[f64; 3]>,
    fresh: [f64; 3],
}

fn run() -> &'static Run {
    static RUN: OnceLock<Option<Run>> = OnceLock::new();
    once(&RUN, || {
        let case = Case {
            size: [48, 48],
            samples: 32,
            budget: 100.0,
            kept_light: true,
            volumes: vec![Volume::solid()],
            ..Case::new("skies")
        };
        run_scene("skies", "skies", &json!(case)).1
    })
}

fn change(name: &str) -> Change {
    let change: Change = serde_json::from_value(told(run(), name).clone()).unwrap();
    println!("{name}: {change:.3?}");
    change
}

fn off(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
}

fn assert_goes_from_one_to_the_other(name: &str) -> Change {
    let change = change(name);
    let Change { before, frames, fresh } = &change;
    let (before, fresh) = (*before, *fresh);
    for (i, frame) in frames.iter().enumerate() {
        for channel in 0..3 {
            let [low, high] =
                [before[channel].min(fresh[channel]) - NOISE, before[channel].max(fresh[channel]) + NOISE];
            let shown = frame[channel];
            assert!((low..=high).contains(&shown), "{name}, frame {i}: {frame:.3?} is neither's light");
        }
    }
    assert!(off(before, fresh) > 2.0 * NOISE, "{name}: the change changes too little");
    assert!(off(*frames.last().unwrap(), fresh) < REST, "{name}: not the light of a scene made so");
    change
}

#[test]
fn another_sky_lights_volumes_once_it_is_drawn() {
    assert_goes_from_one_to_the_other("new_sky");
}

#[test]
fn another_look_of_a_sky_lights_volumes() {
    assert_goes_from_one_to_the_other("new_properties");
    assert_goes_from_one_to_the_other("new_material_and_energy");
}

/// Looked at every ten frames or so.
#[test]
fn a_sky_that_changes_in_every_frame_is_followed() {
    let Change { before, frames, fresh } = assert_goes_from_one_to_the_other("fade");
    let share = off(frames[20], before) / off(fresh, before);
    assert!(share > 0.2, "{share} of the way after 20 of 24 frames");
}

#[test]
fn another_sky_and_other_layers_in_one_frame_leave_volumes_in_the_picture() {
    assert_goes_from_one_to_the_other("new_sky_and_layers");
}

#[test]
fn viewports_of_one_world_keep_to_their_own_skies() {
    assert_goes_from_one_to_the_other("shared_world");
    // The same sky as of the other viewport before.
    assert!(off(change("shared_world").before, change("new_properties").fresh) < REST);
    let neighbour = change("neighbour");
    assert!(off(neighbour.frames[0], neighbour.fresh) < REST, "{neighbour:.3?}");
}
