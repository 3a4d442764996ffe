//! The engine's fog, for volumes: by its `fog_process`, without what that mixes in of the sky and the sun.

use godot::classes::environment::FogMode;
use godot::classes::{Camera3D, Environment};
use godot::prelude::*;
use lumivox_renderer::{DistanceFog, Fog, HeightFog};

use crate::convert;

/// What the engine takes for no fog by height at all.
const LEAST_HEIGHT_DENSITY: f64 = 1e-4;

/// What an environment lays over what a camera sees.
pub fn of(environment: &Gd<Environment>, camera: &Gd<Camera3D>) -> Option<Fog> {
    if !environment.is_fog_enabled() {
        return None;
    }
    let energy = f64::from(environment.get_fog_light_energy());
    let density = f64::from(environment.get_fog_density());
    let by_distance = if environment.get_fog_mode() == FogMode::DEPTH {
        let end = f64::from(environment.get_fog_depth_end());
        let end = if end > 0.0 { end } else { f64::from(camera.get_far()) };
        let begin = f64::from(environment.get_fog_depth_begin()).min(end - 1e-3);
        let curve = f64::from(environment.get_fog_depth_curve());
        DistanceFog::Between { begin, end, curve, density }
    } else {
        DistanceFog::Exponential { density }
    };
    let by_height = HeightFog {
        height: f64::from(environment.get_fog_height()),
        density: f64::from(environment.get_fog_height_density()),
    };
    Some(Fog {
        color: convert::linear_from_color(environment.get_fog_light_color()).map(|c| c * energy),
        by_distance,
        by_height: (by_height.density.abs() >= LEAST_HEIGHT_DENSITY).then_some(by_height),
    })
}
