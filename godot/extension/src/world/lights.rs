//! The engine's lights, as the core's.

use std::hash::{Hash, Hasher};

use godot::classes::directional_light_3d::SkyMode;
use godot::classes::{DirectionalLight3D, Engine, Light3D};
use godot::prelude::*;
use lumivox_core::light::{Light, LightKind};

use super::Nodes;
use super::lamp_node::LampNode;

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
    let lamp = LampNode::of_node(light)?;
    let (mut in_sky, mut in_scene) = (false, true);
    if let Ok(sun) = light.clone().try_cast::<DirectionalLight3D>() {
        in_sky = sun.get_sky_mode() != SkyMode::LIGHT_ONLY;
        in_scene = sun.get_sky_mode() != SkyMode::SKY_ONLY;
    }
    let light = lamp.exact(light).unwrap_or_else(|| lamp.light());
    Some(WorldLight { light, in_scene, in_sky })
}
