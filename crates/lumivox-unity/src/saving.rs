//! A world as a scene document: what C# has gathered for a camera, in the words that every host reads.

use std::ffi::c_char;

use lumivox_core::document::{Backdrop, Display, Film, SceneDocument, Tone, View};
use lumivox_core::{LightKind, PerspectiveCamera, Scene};
use serde_json::Value;

use crate::abi::LumivoxSavedView;
use crate::border::{Outcome, guard_status, known, path};
use crate::convert;
use crate::stage::LumivoxStage;

/// Writes what is in a world, seen so, as a scene document; whole, or not at all. A sky that came from no file is written
/// beside it as OpenEXR, to the bit. `radiance` is what is as bright in this engine as a radiance of 1 in documents.
///
/// # Safety
/// `stage` is a live handle, `view` points to a view, `file` is a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_save_world(
    stage: *const LumivoxStage,
    world: u64,
    view: *const LumivoxSavedView,
    radiance: f32,
    file: *const c_char,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (stage, view, file) =
            unsafe { (known(stage, "stage")?, known(view, "view")?, path(file, "file")?) };
        let scene = stage.scene(world).ok_or_else(|| format!("there is no world {world}"))?;
        let mut scene = (**scene).clone();
        darken(&mut scene, f64::from(radiance));
        lumivox_scene::save_scene(scene, &file, |scene| document(scene, view))
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
fn document(scene: &Scene, view: &LumivoxSavedView) -> Outcome<SceneDocument> {
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
    readable(&document)
}

/// The same document with the numbers of few digits that 32-bit ones of Unity's stand for: its 0.1 is 0.10000000149.
fn readable(document: &SceneDocument) -> Outcome<SceneDocument> {
    let mut value = serde_json::to_value(document).map_err(|error| error.to_string())?;
    few_digits(&mut value);
    serde_json::from_value(value).map_err(|error| error.to_string())
}

/// What never was a 32-bit number of Unity's, or is the place of something in the patient.
const EXACT: [&str; 4] = ["scan", "world_from_patient", "clip_shapes", "files"];

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
    fn what_a_turn_leaves_is_nothing_and_small_numbers_stay() {
        let mut value = serde_json::json!({"a": [1.0, -1.2e-7, 640.0], "b": [2e-7, 1e-7, 0.5e-7], "c": 1e-8});
        few_digits(&mut value);
        assert_eq!(value, serde_json::json!({"a": [1.0, 0.0, 640.0], "b": [2e-7, 1e-7, 0.5e-7], "c": 1e-8}));
    }
}
