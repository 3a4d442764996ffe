//! The engine's lights on the GPU.

use lumivox_core::glam::DVec3;
use lumivox_core::light::MIN_LIGHT_DISTANCE;
use lumivox_core::{Cone, Falloff, Lamp, Light, LightKind};
use lumivox_shaders::{constants, layout};

use super::hierarchy::Bounds;
use super::{Placed, check_binding};
use crate::error::RenderError;

// The kernels know nothing of the core.
const _: () = assert!(constants::MIN_LIGHT_DISTANCE == MIN_LIGHT_DISTANCE as f32);

/// The lights that reach a volume, every number in its documented range. The others are not there: whatever they do, no
/// image changes, and no collision asks them.
pub(crate) fn effective(lights: &[Light], placed: &[Placed<'_>]) -> Vec<Light> {
    let volumes: Vec<(u32, Bounds)> =
        placed.iter().map(|p| (p.instance.layers, Bounds::of(p.instance, DVec3::ZERO))).collect();
    lights
        .iter()
        .filter_map(|light| light.sanitized())
        .filter(|light| color(light) != [0.0; 3])
        .filter(|light| {
            volumes.iter().any(|(layers, bounds)| light.layers & layers != 0 && reaches(&light.kind, bounds))
        })
        .collect()
}

/// Whether light falls into a box at all: a lamp's ends at its range.
fn reaches(kind: &LightKind, bounds: &Bounds) -> bool {
    match kind {
        LightKind::Directional { .. } => true,
        LightKind::Point(lamp) | LightKind::Spot { lamp, .. } => {
            bounds.distance(lamp.position) < lamp.falloff.range()
        }
    }
}

/// Whether the device binds that many lights.
pub(super) fn check(lights: &[Light], limit: u64) -> Result<(), RenderError> {
    check_binding("lights", size_of_val(&*twins(lights, DVec3::ZERO)) as u64, limit, "Leave some out")
}

fn color(light: &Light) -> [f64; 3] {
    match light.kind {
        LightKind::Directional { irradiance, .. } => irradiance,
        LightKind::Point(lamp) | LightKind::Spot { lamp, .. } => lamp.intensity,
    }
}

/// As the GPU has them. Positions count from `origin`.
pub(super) fn twins(lights: &[Light], origin: DVec3) -> Vec<layout::Light> {
    lights.iter().map(|light| twin(light, origin)).collect()
}

fn twin(light: &Light, origin: DVec3) -> layout::Light {
    let base =
        layout::Light { color: color(light).map(|c| c as f32), layers: light.layers, ..Default::default() };
    let at = |lamp: &Lamp| layout::Light {
        position: (lamp.position - origin).as_vec3().to_array(),
        size: lamp.radius as f32,
        inverse_range: (1.0 / lamp.falloff.range()) as f32,
        decay: match lamp.falloff {
            Falloff::Power { decay, .. } => decay as f32,
            Falloff::Relative { .. } => -1.0,
        },
        ..base
    };
    match &light.kind {
        LightKind::Directional { direction, angular_radius, .. } => layout::Light {
            kind: constants::LIGHT_DIRECTIONAL,
            axis: direction.as_vec3().to_array(),
            size: one_minus_cosine(*angular_radius) as f32,
            ..base
        },
        LightKind::Point(lamp) => layout::Light { kind: constants::LIGHT_POINT, ..at(lamp) },
        LightKind::Spot { lamp, direction, half_angle, cone } => layout::Light {
            kind: constants::LIGHT_SPOT,
            axis: direction.as_vec3().to_array(),
            inverse_cone: (1.0 / one_minus_cosine(*half_angle)) as f32,
            cone_attenuation: match cone {
                Cone::Power { attenuation } => *attenuation as f32,
                Cone::Between { inner_half_angle } => {
                    let edge = one_minus_cosine(*half_angle);
                    -(edge / (edge - one_minus_cosine(*inner_half_angle))) as f32
                }
            },
            ..at(lamp)
        },
    }
}

/// `1 - cos(angle)` without losing the digits of a small angle.
fn one_minus_cosine(angle: f64) -> f64 {
    2.0 * (angle / 2.0).sin().powi(2)
}
