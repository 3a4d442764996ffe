//! What one of the engine's lights says in its own words, and the core's light of that; and back, for lights of scene files.

use std::f64::consts::PI;

use godot::classes::directional_light_3d::SkyMode;
use godot::classes::light_3d::Param;
use godot::classes::{DirectionalLight3D, Light3D, OmniLight3D, SpotLight3D};
use godot::prelude::*;
use lumivox_core::PerspectiveCamera;
use lumivox_core::document::Lighting;
use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::light::{Cone, Falloff, Lamp, Light, LightKind};

use super::exposure::{SKY_NITS, physical_units};
use crate::convert;

/// Metadata of a light: what a scene file says of it, to more digits than its properties have, and more than they can say. It
/// holds as long as they are as they were then.
const EXACT: &str = "lumivox_light";

/// Metres that a light without an end reaches in the engine.
const FAR: f32 = 4096.0;

/// Which of the engine's lights.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Class {
    Directional,
    Omni,
    Spot,
}

/// The properties that count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampNode {
    class: Class,
    place: Transform3D,
    color: Color,
    energy: f32,
    size: f32,
    range: f32,
    attenuation: f32,
    angle: f32,
    angle_attenuation: f32,
    layers: u32,
    /// Where the project tells lumens and lux: the colour of its temperature, and how many there are.
    physical: Option<(Color, f32)>,
}

impl LampNode {
    /// What a node says; `None` of one that no volume knows.
    pub fn of_node(light: &Gd<Light3D>) -> Option<Self> {
        let class = [
            ("DirectionalLight3D", Class::Directional),
            ("OmniLight3D", Class::Omni),
            ("SpotLight3D", Class::Spot),
        ];
        let class = class.into_iter().find(|(name, _)| light.is_class(*name))?.1;
        let param = |param| light.get_param(param);
        let lamp = Self {
            class,
            place: light.clone().get_global_transform_interpolated(),
            color: light.get_color(),
            energy: param(Param::ENERGY),
            size: param(Param::SIZE),
            range: param(Param::RANGE),
            attenuation: param(Param::ATTENUATION),
            angle: param(Param::SPOT_ANGLE),
            angle_attenuation: param(Param::SPOT_ATTENUATION),
            layers: light.get_cull_mask(),
            physical: physical_units().then(|| (light.get_correlated_color(), param(Param::INTENSITY))),
        };
        Some(lamp.of_its_class())
    }

    /// What a node says that is as near to a light as it can be.
    fn of_light(light: &Light) -> Self {
        let node = Self {
            class: Class::Directional,
            place: Transform3D::IDENTITY,
            color: Color::WHITE,
            energy: 0.0,
            size: 0.0,
            range: FAR,
            attenuation: 1.0,
            angle: 45.0,
            angle_attenuation: 1.0,
            layers: light.layers,
            physical: physical_units().then_some((Color::WHITE, 1.0)),
        };
        let lamp = match light.kind {
            LightKind::Directional { direction, irradiance, angular_radius } => Self {
                place: aimed(DVec3::ZERO, direction),
                size: (2.0 * angular_radius.to_degrees()) as f32,
                ..node.with_strength(irradiance)
            },
            LightKind::Point(lamp) => Self { class: Class::Omni, ..node.with_lamp(&lamp) },
            LightKind::Spot { lamp, direction, half_angle, cone } => Self {
                class: Class::Spot,
                angle: half_angle.to_degrees() as f32,
                angle_attenuation: match cone {
                    Cone::Power { attenuation } => (1.0 / attenuation.max(1e-3)) as f32,
                    Cone::Between { .. } => 1.0,
                },
                ..Self { place: aimed(lamp.position, direction), ..node.with_lamp(&lamp) }
            },
        };
        lamp.of_its_class()
    }

    fn with_lamp(self, lamp: &Lamp) -> Self {
        let (range, attenuation) = match lamp.falloff {
            Falloff::Power { range, decay } => (range, decay),
            Falloff::Relative { range } => (range, 1.0),
        };
        Self {
            place: convert::transform(DAffine3::from_translation(lamp.position)),
            size: lamp.radius as f32,
            range: (range as f32).min(FAR),
            attenuation: attenuation as f32,
            ..self.with_strength(lamp.intensity)
        }
    }

    /// Of a colour whose largest part is 1.
    fn with_strength(self, strength: [f64; 3]) -> Self {
        let largest = strength.into_iter().fold(0.0, f64::max);
        if largest <= 0.0 {
            return Self { energy: 0.0, ..self };
        }
        let color = convert::color_from_linear(strength.map(|c| c / largest));
        Self { color, energy: (largest / PI) as f32, ..self }
    }

    /// Without what a light of its class has no use for.
    fn of_its_class(self) -> Self {
        const UNUSED: f32 = 1.0;
        let (range, attenuation) = match self.class {
            Class::Directional => (UNUSED, UNUSED),
            Class::Omni | Class::Spot => (self.range, self.attenuation),
        };
        let (angle, angle_attenuation) = match self.class {
            Class::Directional | Class::Omni => (UNUSED, UNUSED),
            Class::Spot => (self.angle, self.angle_attenuation),
        };
        Self { range, attenuation, angle, angle_attenuation, ..self }
    }

    /// The core's light of it.
    pub fn light(&self) -> Light {
        let mut color = convert::linear_from_color(self.color);
        // A white surface reflects a pi-th of what it receives, and Godot's energies are what it reflects.
        let mut energy = f64::from(self.energy) * PI;
        if let Some((temperature, intensity)) = self.physical {
            let temperature = convert::linear_from_color(temperature);
            color = [0, 1, 2].map(|i| color[i] * temperature[i]);
            energy = f64::from(self.energy) * f64::from(intensity) / self.solid_angle();
        }
        let strength = color.map(|c| c * energy);
        let place = convert::affine(self.place);
        let direction = -place.matrix3.z_axis;
        let lamp = Lamp {
            position: place.translation,
            intensity: strength,
            radius: self.size.into(),
            falloff: Falloff::Power { range: self.range.into(), decay: self.attenuation.into() },
        };
        let kind = match self.class {
            Class::Directional => {
                // Its size is the angle across it.
                let angular_radius = f64::from(self.size).to_radians() / 2.0;
                LightKind::Directional { direction, irradiance: strength, angular_radius }
            }
            Class::Omni => LightKind::Point(lamp),
            Class::Spot => LightKind::Spot {
                lamp,
                direction,
                half_angle: f64::from(self.angle).to_radians(),
                // The engine's shader takes the inverse: more is narrower.
                cone: Cone::Power { attenuation: 1.0 / f64::from(self.angle_attenuation).max(1e-3) },
            },
        };
        Light { kind, layers: self.layers }
    }

    /// Lux of a sun; lumens of a lamp, in all directions or, whatever its cone, in those of half a sphere's lobe.
    fn solid_angle(&self) -> f64 {
        match self.class {
            Class::Directional => 1.0,
            Class::Omni => 4.0 * PI,
            Class::Spot => PI,
        }
    }

    /// The light of a scene file, where its node still says the same.
    pub fn exact(&self, node: &Gd<Light3D>) -> Option<Light> {
        // Physical units have brightnesses of their own.
        if self.physical.is_some() || !node.has_meta(EXACT) {
            return None;
        }
        let kept: Lighting = serde_json::from_str(&node.get_meta(EXACT).stringify().to_string()).ok()?;
        let light = kept.light();
        let lamp = Self::of_light(&light);
        let is_same =
            convert::is_same_place(lamp.place, self.place) && Self { place: self.place, ..lamp } == *self;
        is_same.then_some(light)
    }

    /// The node of a scene file's light, in the world's own space.
    pub fn opened(lighting: &Lighting) -> Gd<Light3D> {
        let lamp = Self::of_light(&lighting.light());
        let mut node: Gd<Light3D> = match lamp.class {
            Class::Directional => {
                let mut sun = DirectionalLight3D::new_alloc();
                // It is no disc in a sky that has its own light.
                sun.set_sky_mode(SkyMode::LIGHT_ONLY);
                sun.upcast()
            }
            Class::Omni => OmniLight3D::new_alloc().upcast(),
            Class::Spot => SpotLight3D::new_alloc().upcast(),
        };
        node.set_transform(lamp.place);
        node.set_color(lamp.color);
        node.set_cull_mask(lamp.layers);
        node.set_param(Param::ENERGY, lamp.energy);
        node.set_param(Param::SIZE, lamp.size);
        if lamp.class != Class::Directional {
            node.set_param(Param::RANGE, lamp.range);
            node.set_param(Param::ATTENUATION, lamp.attenuation);
        }
        if lamp.class == Class::Spot {
            node.set_param(Param::SPOT_ANGLE, lamp.angle);
            node.set_param(Param::SPOT_ATTENUATION, lamp.angle_attenuation);
        }
        if lamp.physical.is_some() {
            let intensity = SKY_NITS * PI * lamp.solid_angle();
            node.set_param(Param::INTENSITY, intensity as f32);
        }
        if let Ok(text) = serde_json::to_string(lighting) {
            node.set_meta(EXACT, &text.to_variant());
        }
        node
    }
}

/// At a point, with -z along a direction.
fn aimed(position: DVec3, direction: DVec3) -> Transform3D {
    let direction = direction.try_normalize().unwrap_or(DVec3::NEG_Z);
    let up = if direction.y.abs() > 0.999 { DVec3::Z } else { DVec3::Y };
    let place = PerspectiveCamera::look_at(position, position + direction, up, 1.0).world_from_camera;
    convert::transform(place)
}
