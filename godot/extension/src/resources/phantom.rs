//! Phantoms for scripts: those of the `lumivox phantom` command, by the same names and with the same options.

use godot::prelude::*;
use lumivox_core::{CancelToken, Progress, Volume};
use lumivox_phantom::{AnatomyOptions, Arms, Metal, MrPart, TorsoOptions};

/// Voxels along a side of a phantom whose size nobody gave.
const DEFAULT_SIZE: usize = 128;

/// Most voxels along a side of a phantom.
const MAX_SIZE: usize = 1024;

/// Hounsfield units of the homogeneous bodies: bone, which every CT preset shows.
const BODY_HU: f64 = 1000.0;

/// Voxels of air around a homogeneous body, on both sides together.
const AIR_VOXELS: usize = 6;

const KINDS: [&str; 8] = ["head", "torso", "torso-pet", "mr-head", "mr-brain", "cube", "slab", "sphere"];

const TORSO_OPTIONS: [&str; 8] =
    ["table", "blanket", "breasts", "arms", "metal", "field_of_view", "shift", "tilt"];

/// A phantom of so many voxels along its longest side; 0 stands for the default.
///
/// # Errors
/// A sentence about what cannot be understood.
pub fn compute(kind: &str, size: i64, options: &VarDictionary) -> Result<Volume, String> {
    let size = match usize::try_from(size) {
        Ok(0) => DEFAULT_SIZE,
        Ok(size) if (8..=MAX_SIZE).contains(&size) => size,
        _ => return Err(format!("A phantom has 8 to {MAX_SIZE} voxels along a side, not {size}.")),
    };
    let is_torso = kind.starts_with("torso");
    for (key, _) in options.iter_shared() {
        let key = key.stringify().to_string();
        if key != "seed" && key != "padding" && !TORSO_OPTIONS.contains(&key.as_str()) {
            let known = TORSO_OPTIONS.join("', '");
            return Err(format!(
                "There is no phantom option '{key}'. There are 'seed', 'padding', '{known}'."
            ));
        }
        if key != "seed" && !is_torso {
            return Err(format!("Of the phantoms, only the torso has '{key}'."));
        }
    }
    let seed = option(options, "seed", 1i64)?;
    let seed =
        u64::try_from(seed).map_err(|_| format!("A phantom's 'seed' is 0 or more, and not {seed}."))?;
    let head = AnatomyOptions { size, seed, ..AnatomyOptions::default() };
    let (quiet, never) = (Progress::SILENT, CancelToken::new());
    let inside = size.saturating_sub(AIR_VOXELS).max(1) as f64;
    let made = match kind {
        "head" => lumivox_phantom::anatomy(head, quiet, &never),
        "mr-head" => lumivox_phantom::anatomy_mr(head, MrPart::Head, quiet, &never),
        "mr-brain" => lumivox_phantom::anatomy_mr(head, MrPart::Brain, quiet, &never),
        "torso" => lumivox_phantom::torso(torso(options, size, seed)?, quiet, &never),
        "torso-pet" => lumivox_phantom::torso_pet(torso(options, size, seed)?, quiet, &never),
        "cube" => Ok(lumivox_phantom::cube(size)),
        "slab" => Ok(lumivox_phantom::slab(BODY_HU, inside / 10.0, 1.0)),
        "sphere" => Ok(lumivox_phantom::sphere(BODY_HU, inside / 2.0 - 0.5, 1.0)),
        _ => {
            return Err(format!("There is no phantom '{kind}'. There are '{}'.", KINDS.join("', '")));
        }
    };
    made.map_err(|_| "The phantom was not finished.".to_owned())
}

fn torso(options: &VarDictionary, size: usize, seed: u64) -> Result<TorsoOptions, String> {
    let default = TorsoOptions::default();
    let number = |key, default, [low, high]: [f64; 2]| {
        let number: f64 = option(options, key, default)?;
        let is_within = (low..=high).contains(&number);
        is_within.then_some(number).ok_or(format!("A torso's '{key}' is {low} to {high}, and not {number}."))
    };
    let named = |key: &str| option(options, key, GString::new()).map(|name| name.to_string());
    let shift: Vector3 = option(options, "shift", Vector3::ZERO)?;
    if !shift.is_finite() {
        return Err(format!("A torso's 'shift' is a vector of millimetres, and not {shift}."));
    }
    Ok(TorsoOptions {
        size,
        seed,
        field_of_view_mm: number("field_of_view", default.field_of_view_mm, [50.0, 1000.0])?,
        shift_mm: [shift.x, shift.y, shift.z].map(|mm| f64::from(mm).clamp(-1000.0, 1000.0)),
        tilt_degrees: number("tilt", default.tilt_degrees, [-90.0, 90.0])?,
        padding: option(options, "padding", false)?,
        arms: match named("arms")?.as_str() {
            "" | "raised" => Arms::Raised,
            "sides" => Arms::AtSides,
            other => {
                return Err(format!("A torso's 'arms' are 'raised' or at the 'sides', and not '{other}'."));
            }
        },
        breasts: option(options, "breasts", false)?,
        // A game has the patient alone, unless it asks.
        table: option(options, "table", false)?,
        blanket: option(options, "blanket", false)?,
        metal: match named("metal")?.as_str() {
            "" => Metal::None,
            "sternal-wires" => Metal::SternalWires,
            "pacemaker" => Metal::Pacemaker,
            "rod" => Metal::Rod,
            other => {
                let known = "'sternal-wires', 'pacemaker' or 'rod'";
                return Err(format!("A torso's 'metal' is {known}, and not '{other}'."));
            }
        },
        ..default
    })
}

/// An option, or its default where there is none.
fn option<T: FromGodot>(options: &VarDictionary, key: &str, default: T) -> Result<T, String> {
    let Some(value) = options.get(key) else { return Ok(default) };
    value.try_to_relaxed().map_err(|_| format!("The phantom option '{key}' cannot be {value}."))
}
