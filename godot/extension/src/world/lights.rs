//! The engine's lights, as the core's.

use std::f64::consts::PI;
use std::hash::{Hash, Hasher};

use godot::classes::directional_light_3d::SkyMode;
use godot::classes::light_3d::Param;
use godot::classes::{DirectionalLight3D, Engine, Light3D};
use godot::prelude::*;
use lumivox_core::light::{Cone, Falloff, Lamp, Light, LightKind};

use super::Nodes;
use super::exposure::physical_units;
use crate::convert;

/// A light of a world.
#[derive(Clone, Copy, Debug)]
pub struct WorldLight {
    /// The light.
    pub light: Light,
    /// Whether it lights anything but the sky.
    pub in_scene: bool,
    /// Whether the sky shows its disk.
    pub in_sky: bool,
}

/// The lights of a world that shine. Negative ones do not: they have no counterpart in nature. Shadows of volumes are
/// always there, and no light fades with the camera's distance: an image that converges cannot follow.
pub fn gather(nodes: &mut Nodes, scenario: Rid) -> Vec<WorldLight> {
    let playing = !Engine::singleton().is_editor_hint();
    nodes.lights().into_iter().filter_map(|light| of(&light, scenario, playing)).collect()
}

/// Changes when the sky may: its sun's place, colour and size.
pub fn sky_fingerprint(lights: &[WorldLight], hasher: &mut impl Hasher) {
    for sun in lights.iter().filter(|sun| sun.in_sky) {
        if let LightKind::Directional { direction, irradiance, angular_radius } = sun.light.kind {
            direction.to_array().map(f64::to_bits).hash(hasher);
            irradiance.map(f64::to_bits).hash(hasher);
            angular_radius.to_bits().hash(hasher);
        }
    }
}

fn of(light: &Gd<Light3D>, scenario: Rid, playing: bool) -> Option<WorldLight> {
    let shines = light.is_visible_in_tree()
        && !light.is_negative()
        && !(playing && light.is_editor_only())
        && light.get_world_3d().is_some_and(|world| world.get_scenario() == scenario);
    if !shines {
        return None;
    }
    let param = |param| f64::from(light.get_param(param));
    let directional = light.is_class("DirectionalLight3D");
    let spot = light.is_class("SpotLight3D");
    let mut color = convert::linear_from_color(light.get_color());
    // A white surface reflects a pi-th of what it receives, and Godot's energies are what it reflects.
    let mut energy = param(Param::ENERGY) * PI;
    if physical_units() {
        let temperature = convert::linear_from_color(light.get_correlated_color());
        color = [0, 1, 2].map(|i| color[i] * temperature[i]);
        // Lux of a sun; lumens of a lamp, in all directions or, whatever its cone, in those of half a sphere's lobe.
        let solid_angle = if directional { 1.0 } else { PI * if spot { 1.0 } else { 4.0 } };
        energy = param(Param::ENERGY) * param(Param::INTENSITY) / solid_angle;
    }
    let strength = color.map(|c| c * energy);
    let place = convert::affine(light.clone().get_global_transform_interpolated());
    let direction = -place.matrix3.z_axis;
    let lamp = Lamp {
        position: place.translation,
        intensity: strength,
        radius: param(Param::SIZE),
        falloff: Falloff::Power { range: param(Param::RANGE), decay: param(Param::ATTENUATION) },
    };
    let (mut in_sky, mut in_scene) = (false, true);
    let kind = if let Ok(sun) = light.clone().try_cast::<DirectionalLight3D>() {
        in_sky = sun.get_sky_mode() != SkyMode::LIGHT_ONLY;
        in_scene = sun.get_sky_mode() != SkyMode::SKY_ONLY;
        // Its size is the angle across it.
        let angular_radius = param(Param::SIZE).to_radians() / 2.0;
        LightKind::Directional { direction, irradiance: strength, angular_radius }
    } else if light.is_class("OmniLight3D") {
        LightKind::Point(lamp)
    } else if spot {
        LightKind::Spot {
            lamp,
            direction,
            half_angle: param(Param::SPOT_ANGLE).to_radians(),
            // The engine's shader takes the inverse: more is narrower.
            cone: Cone::Power { attenuation: 1.0 / param(Param::SPOT_ATTENUATION).max(1e-3) },
        }
    } else {
        return None;
    };
    let light = Light { kind, layers: light.get_cull_mask() };
    Some(WorldLight { light, in_scene, in_sky })
}
