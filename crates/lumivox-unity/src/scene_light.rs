//! The light of a scene document, handed over in Unity's conventions: lamps, and what is around.

use lumivox_core::glam::DVec3;
use lumivox_core::{Cone, EnvironmentSource, Falloff, Light, LightKind};

use crate::abi::*;
use crate::border::{guard, guard_status, known, known_mut};
use crate::convert;
use crate::pose::Pose;
use crate::scene::LumivoxScene;

/// How many lights a scene has.
///
/// # Safety
/// `scene` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_light_count(scene: *const LumivoxScene) -> u32 {
    // SAFETY: as the caller promises.
    guard(|| Ok(unsafe { known(scene, "scene") }?.scene.lights.len() as u32)).unwrap_or(0)
}

/// A light of a scene.
///
/// # Safety
/// `scene` is a live handle, `out` and `pose` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_light(
    scene: *const LumivoxScene,
    index: u32,
    out: *mut LumivoxLight,
    pose: *mut LumivoxPose,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (scene, out, pose) = unsafe {
            (known(scene, "scene")?, known_mut(out, "place for it")?, known_mut(pose, "place for its pose")?)
        };
        let found = scene.scene.lights.get(index as usize);
        *out = light(found.ok_or_else(|| format!("the scene has no light {index}"))?);
        let [position, direction] = [out.position, out.direction].map(convert::wide);
        *pose = Pose::towards(position, direction).narrow();
        Ok(())
    })
}

fn light(light: &Light) -> LumivoxLight {
    let mut out = LumivoxLight {
        kind: 0,
        layers: light.layers,
        position: [0.0; 3],
        direction: [0.0, 0.0, 1.0],
        strength: [0.0; 3],
        radius: 0.0,
        range: f32::INFINITY,
        falloff: 0,
        decay: 2.0,
        outer_half_angle: 0.0,
        inner_half_angle: 0.0,
        has_attenuation: 0,
        attenuation: 0.0,
    };
    let narrow = |v: DVec3| convert::narrow(convert::mirrored(v));
    let strength = |rgb: [f64; 3]| rgb.map(|c| c as f32);
    match light.kind {
        LightKind::Directional { direction, irradiance, angular_radius } => {
            out.direction = narrow(direction.normalize_or_zero());
            out.strength = strength(irradiance);
            out.radius = angular_radius as f32;
        }
        LightKind::Point(lamp) | LightKind::Spot { lamp, .. } => {
            out.kind = 1;
            out.position = narrow(lamp.position);
            out.strength = strength(lamp.intensity);
            out.radius = lamp.radius as f32;
            match lamp.falloff {
                Falloff::Power { range, decay } => (out.range, out.decay) = (range as f32, decay as f32),
                Falloff::Relative { range } => (out.falloff, out.range) = (1, range as f32),
            }
        }
    }
    if let LightKind::Spot { direction, half_angle, cone, .. } = light.kind {
        out.kind = 2;
        out.direction = narrow(direction.normalize_or_zero());
        out.outer_half_angle = half_angle as f32;
        match cone {
            Cone::Between { inner_half_angle } => out.inner_half_angle = inner_half_angle as f32,
            Cone::Power { attenuation } => {
                (out.has_attenuation, out.attenuation) = (1, attenuation as f32);
            }
        }
    }
    out
}

/// The light around a scene; its map is the scene's.
///
/// # Safety
/// `scene` is a live handle, `out` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_scene_environment(
    scene: *const LumivoxScene,
    out: *mut LumivoxEnvironment,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (scene, out) = unsafe { (known(scene, "scene")?, known_mut(out, "place for it")?) };
        let environment = &scene.scene.environment;
        *out = LumivoxEnvironment {
            kind: 2,
            zenith: [0.0; 3],
            horizon: [0.0; 3],
            nadir: [0.0; 3],
            // Seen in a mirror, it turns the other way.
            rotation: -environment.rotation as f32,
            strength: environment.strength as f32,
            map: std::ptr::null(),
        };
        let radiance = |rgb: [f64; 3]| rgb.map(|c| c as f32);
        match &environment.source {
            EnvironmentSource::Uniform(color) => (out.kind, out.zenith) = (0, radiance(*color)),
            EnvironmentSource::Gradient { zenith, horizon, nadir } => {
                out.kind = 1;
                (out.zenith, out.horizon, out.nadir) =
                    (radiance(*zenith), radiance(*horizon), radiance(*nadir));
            }
            EnvironmentSource::Studio => {}
            EnvironmentSource::Map(_) => {
                out.kind = 3;
                out.map = scene.map.as_ref().map_or(std::ptr::null(), std::ptr::from_ref);
            }
        }
        Ok(())
    })
}
