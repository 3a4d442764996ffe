//! A world as a scene document: what C# has gathered for a camera, in the words that every host reads.

use std::ffi::c_char;

use lumivox_core::document::{Backdrop, Display, Film, SceneDocument, Tone, View};
use lumivox_core::{LightKind, PerspectiveCamera, Scene};
use serde_json::Value;

use crate::abi::LumivoxSavedView;
use crate::border::{Outcome, guard_status, known, path, text};
use crate::convert;
use crate::stage::LumivoxStage;

/// Writes what is in a world, seen so, as a scene document; whole, or not at all. A sky that came from no file is written
/// beside it as OpenEXR, to the bit. `radiance` is what is as bright in this engine as a radiance of 1 in documents. `opened` is
/// the text of `lumivox_scene_document` where the view is one of a scene that was opened, else null or empty: numbers that are
/// still those of that scene, as far as 32 bits tell, are written with all their digits.
///
/// # Safety
/// `stage` is a live handle, `view` points to a view, `opened` is null or a string, `file` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_save_world(
    stage: *const LumivoxStage,
    world: u64,
    view: *const LumivoxSavedView,
    radiance: f32,
    opened: *const c_char,
    file: *const c_char,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (stage, view, opened, file) = unsafe {
            (known(stage, "stage")?, known(view, "view")?, text(opened, "scene")?, path(file, "file")?)
        };
        let opened = opened.filter(|text| !text.is_empty());
        let opened: Option<Value> =
            opened.map(serde_json::from_str).transpose().map_err(|error| error.to_string())?;
        let scene = stage.scene(world).ok_or_else(|| format!("there is no world {world}"))?;
        let mut scene = (**scene).clone();
        darken(&mut scene, f64::from(radiance));
        lumivox_scene::save_scene(scene, &file, |scene| document(scene, view, opened.as_ref()))
    })
}

/// Divides all light by a number.
fn darken(scene: &mut Scene, by: f64) {
    if by == 1.0 || !by.is_normal() {
        return;
    }
    scene.environment.strength /= by;
    for light in &mut scene.lights {
        let strength = match &mut light.kind {
            LightKind::Directional { irradiance, .. } => irradiance,
            LightKind::Point(lamp) | LightKind::Spot { lamp, .. } => &mut lamp.intensity,
        };
        strength.iter_mut().for_each(|part| *part /= by);
    }
}

/// The document of a scene that is seen so.
fn document(scene: &Scene, view: &LumivoxSavedView, opened: Option<&Value>) -> Outcome<SceneDocument> {
    let mut document = SceneDocument::of(scene).map_err(|error| error.to_string())?;
    let camera = PerspectiveCamera {
        world_from_camera: convert::world_from_camera(&view.world_from_camera),
        vertical_fov: 0.0,
    };
    document.camera = View { fov: f64::from(view.field_of_view), ..View::of(&camera) };
    document.film = Film {
        size: [view.width, view.height],
        samples: (view.samples > 0).then_some(view.samples),
        seed: view.seed,
        noise: (view.noise > 0.0).then(|| f64::from(view.noise)),
        denoise: view.denoise != 0,
    };
    document.display = Display {
        background: match view.background {
            0 => Backdrop::Transparent,
            1 => Backdrop::Environment,
            _ => Backdrop::Color(view.color.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)),
        },
        exposure: f64::from(view.exposure),
        tone: match view.tone {
            1 => Tone::Agx,
            2 => Tone::Aces,
            _ => Tone::Plain,
        },
        gamma: f64::from(view.gamma),
    };
    readable(&document, opened)
}

/// The same document with the numbers of few digits that 32-bit ones of Unity's stand for: its 0.1 is 0.10000000149. Those of
/// a scene that was opened are what they were there.
fn readable(document: &SceneDocument, opened: Option<&Value>) -> Outcome<SceneDocument> {
    let mut value = serde_json::to_value(document).map_err(|error| error.to_string())?;
    few_digits(&mut value);
    if let Some(opened) = opened {
        keep_exact(&mut value, opened);
    }
    serde_json::from_value(value).map_err(|error| error.to_string())
}

/// What never was a 32-bit number of Unity's, or is the place of something in the patient.
const EXACT: [&str; 5] = ["scan", "world_from_patient", "clip_shapes", "lassos", "files"];

/// Of a direction, or a row of a matrix.
const NOTHING: f64 = 5e-7;

fn few_digits(value: &mut Value) {
    match value {
        Value::Number(number) if number.is_f64() => {
            let plain = number.as_f64().and_then(|x| serde_json::Number::from_f64(plain(x)));
            *number = plain.unwrap_or_else(|| number.clone());
        }
        Value::Array(all) => {
            // A turn about an axis leaves a little of the others.
            let most = all.iter().filter_map(Value::as_f64).fold(0.0, |most: f64, x| most.max(x.abs()));
            let least = NOTHING * most.min(1.0);
            for part in all.iter_mut() {
                match part.as_f64() {
                    Some(x) if x.abs() < least => *part = 0.0.into(),
                    _ => few_digits(part),
                }
            }
        }
        Value::Object(all) => {
            all.iter_mut()
                .filter(|(key, _)| !EXACT.contains(&key.as_str()))
                .for_each(|(_, of)| few_digits(of));
        }
        _ => {}
    }
}

/// How far a number is from the one that was opened at most, by what it is added to: 32 bits, a few times over.
const NARROWED: f64 = 1e-6;

/// Takes over the numbers that were opened where 32 bits hardly tell those from what there is. What was moved since is no
/// nearer to what it was than that, so that it does not matter whose number is compared with whose.
fn keep_exact(value: &mut Value, opened: &Value) {
    match (value, opened) {
        (Value::Array(all), Value::Array(opened)) if opened.iter().any(Value::is_number) => {
            let size = |of: &[Value]| {
                of.iter().filter_map(Value::as_f64).fold(0.0, |most: f64, x| most.max(x.abs()))
            };
            // A row of a matrix: the way that its axes turn says nothing of its place, and all of it adds up to that.
            let axes = &opened[..opened.len().min(3)];
            for (i, (part, was)) in all.iter_mut().zip(opened).enumerate() {
                keep_number(part, was, size(if i < 3 { axes } else { opened }));
            }
        }
        (Value::Array(all), Value::Array(opened)) => {
            all.iter_mut().zip(opened).for_each(|(part, was)| keep_exact(part, was));
        }
        (Value::Object(all), Value::Object(opened)) => {
            for (key, part) in all.iter_mut().filter(|(key, _)| *key != "scan") {
                if let Some(was) = opened.get(key) {
                    keep_exact(part, was);
                }
            }
        }
        (value, was) => keep_number(value, was, was.as_f64().unwrap_or_default().abs()),
    }
}

fn keep_number(value: &mut Value, was: &Value, size: f64) {
    let is_same = |(x, was): (f64, f64)| (x - was).abs() <= NARROWED * size;
    if was.is_f64() && value.as_f64().zip(was.as_f64()).is_some_and(is_same) {
        value.clone_from(was);
    }
}

/// The number of six digits that is meant, where that is less far away than 32-bit numbers and a way through Unity's colours
/// and angles can tell; else the shortest that is the same 32-bit number.
fn plain(x: f64) -> f64 {
    const ERROR: f64 = 4.0 * f32::EPSILON as f64;
    if x == 0.0 {
        return 0.0;
    }
    let rounded = format!("{x:.5e}").parse().unwrap_or(x);
    if (x - rounded).abs() <= ERROR * x.abs() {
        return rounded;
    }
    let narrow = x as f32;
    if f64::from(narrow) == x { narrow.to_string().parse().unwrap_or(x) } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_were_meant() {
        for meant in [0.1, -87.25, 0.8, 1234.5, 3e-4, 28.0, 640.0] {
            assert_eq!(plain(f64::from(meant as f32)), meant);
            assert_eq!(plain(meant * (1.0 + 2e-7)), meant);
        }
        assert_eq!(plain(f64::from(1.234_567_8_f32)), 1.234_567_8);
        assert_eq!(plain(1.234_567_890_123), 1.234_567_890_123);
        assert!(plain(-0.0).is_sign_positive());
    }

    #[test]
    fn what_was_opened_keeps_its_digits_until_it_is_moved() {
        use serde_json::json;
        let opened =
            json!({"a": [[0.6000000123, 1e-17, -0.8000000321, 123.456789012]], "b": 0.1234567891, "n": 3});
        let after = |mut value: Value| {
            keep_exact(&mut value, &opened);
            value
        };
        assert_eq!(after(json!({"a": [[0.6, 0.0, -0.8, 123.45679]], "b": 0.12345679, "n": 3})), opened);
        let moved = json!({"a": [[0.60001, 0.0, -0.79999, 123.457]], "b": 0.12346, "n": 4, "c": [1.0]});
        let mut kept = moved.clone();
        kept["a"][0][1] = json!(1e-17);
        assert_eq!(after(moved), kept);
    }

    #[test]
    fn what_a_turn_leaves_is_nothing_and_small_numbers_stay() {
        let mut value = serde_json::json!({"a": [1.0, -1.2e-7, 640.0], "b": [2e-7, 1e-7, 0.5e-7], "c": 1e-8});
        few_digits(&mut value);
        assert_eq!(value, serde_json::json!({"a": [1.0, 0.0, 640.0], "b": [2e-7, 1e-7, 0.5e-7], "c": 1e-8}));
    }
}
