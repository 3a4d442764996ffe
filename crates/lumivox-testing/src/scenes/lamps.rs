//! Test scenes in the light of lamps.

use lumivox_core::glam::DVec3;
use lumivox_core::{Cone, Environment, Falloff, Lamp, Light, LightKind};

use super::{
    TestScene, backward_scattering, forward_scattering, noise, overlapping_volumes, surface_reflection,
};

/// Reflecting noise in the light of a sun without extent.
pub fn sun() -> TestScene {
    let test = surface_reflection();
    lit("sun", test, vec![Light::directional(DVec3::new(-1.0, -0.8, -0.6), [3.0, 2.7, 2.2])])
}

/// Forward scattering, in the light of a red sun of 5 degrees' radius and a blue one of 50 that stands opposite.
pub fn soft_sun() -> TestScene {
    let soft = |direction, irradiance, degrees: f64| {
        LightKind::Directional { direction, irradiance, angular_radius: degrees.to_radians() }.into()
    };
    let lights = vec![
        soft(DVec3::new(0.5, -1.0, 0.4), [4.0, 2.0, 1.0], 5.0),
        soft(DVec3::new(-0.2, 1.0, -0.6), [0.5, 1.0, 3.0], 50.0),
    ];
    let mut test = lit("soft_sun", forward_scattering(), lights);
    test.scene.environment.strength = 0.2;
    test
}

/// A point light of inverse-square falloff, a large bulb, and one that ends within the volume.
pub fn bulbs() -> TestScene {
    let lights = vec![
        Light::point(Lamp::new(DVec3::new(0.02, 0.015, 0.012), [8e-4, 6e-4, 4e-4])),
        Light::point(Lamp { radius: 0.008, ..Lamp::new(DVec3::new(-0.025, 0.0, 0.02), [3e-4, 6e-4, 1e-3]) }),
        Light::point(Lamp {
            falloff: Falloff::Power { range: 0.025, decay: 0.7 },
            ..Lamp::new(DVec3::new(0.0, -0.016, 0.008), [0.1, 0.05, 0.1])
        }),
    ];
    lit("bulbs", noise(), lights)
}

/// A bulb of 3 mm in the midst of a ball that scatters backwards, in no other light.
pub fn bulb_inside() -> TestScene {
    let bulb = Lamp { radius: 0.003, ..Lamp::new(DVec3::new(0.002, 0.001, 0.003), [5e-4, 3e-4, 2e-4]) };
    let mut test = lit("bulb_inside", backward_scattering(), vec![Light::point(bulb)]);
    test.scene.environment = Environment::uniform(0.0);
    test
}

/// Two volumes through one another on layers of their own: a spot for the one, a soft spot for the other, a sun for both.
pub fn stage() -> TestScene {
    let spot = |position: DVec3, intensity, radius, half_angle, attenuation| LightKind::Spot {
        lamp: Lamp { radius, ..Lamp::new(position, intensity) },
        direction: DVec3::new(0.004, 0.002, 0.0) - position,
        half_angle,
        cone: Cone::Power { attenuation },
    };
    let first = spot(DVec3::new(0.03, 0.03, 0.03), [8e-3, 5e-3, 2e-3], 0.0, 0.2, 0.5);
    let second = spot(DVec3::new(-0.02, 0.03, 0.02), [2e-3, 3e-3, 6e-3], 0.006, 0.3, 2.0);
    let lights = vec![
        Light { kind: first, layers: 1 },
        Light { kind: second, layers: 6 },
        Light::directional(DVec3::new(0.2, -1.0, -0.5), [0.4; 3]),
        // Nothing is on its layers.
        Light { layers: 8, ..Light::directional(DVec3::NEG_Z, [100.0; 3]) },
    ];
    let mut test = lit("stage", overlapping_volumes(), lights);
    test.scene.volumes[1].layers = 2;
    test
}

/// A scene in the light of lamps, with less of its environment.
fn lit(name: &'static str, mut test: TestScene, lights: Vec<Light>) -> TestScene {
    test.name = name;
    test.scene.environment.strength *= 0.3;
    test.scene.lights = lights;
    test
}
