//! What the engine's lights send to a point, by their definitions in `lumivox_core::light`.
//!
//! Nothing here knows of more than one light or of what is in the way: the integrator asks each light in turn.

use std::f64::consts::TAU;

use lumivox_core::glam::DVec3;
use lumivox_core::{Lamp, Light, LightKind, Scene};

/// Light on its way to a point from one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Unit direction towards the light.
    pub wi: DVec3,
    /// How far that place is, in metres; infinite for light from afar.
    pub distance: f64,
    /// Irradiance across the beam if the light all came from that place, with nothing in its way.
    pub irradiance: [f64; 3],
}

/// The lights of a scene that are there.
pub fn lights(scene: &Scene) -> Vec<Light> {
    scene.lights.iter().filter_map(|light| light.sanitized()).collect()
}

/// The beam from the place on a `light` that two numbers in `[0, 1)` stand for: equal shares of the light for equal
/// shares of the unit square.
pub fn beam(light: &Light, point: DVec3, [u, v]: [f64; 2]) -> Beam {
    match light.kind {
        LightKind::Directional { direction, irradiance, angular_radius } => {
            // Archimedes: equal steps of the cosine are equal solid angles.
            let cos = (1.0 - u) + u * angular_radius.cos();
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let (x, y) = direction.any_orthonormal_pair();
            let (sin_phi, cos_phi) = (TAU * v).sin_cos();
            let wi = (sin * (cos_phi * x + sin_phi * y) - cos * direction).normalize();
            Beam { wi, distance: f64::INFINITY, irradiance }
        }
        LightKind::Point(lamp) => from_lamp(&lamp, point, [u, v], |_| 1.0),
        LightKind::Spot { lamp, direction, half_angle, cone } => {
            from_lamp(&lamp, point, [u, v], |outwards| {
                LightKind::cone_factor(outwards.dot(direction), half_angle, cone)
            })
        }
    }
}

/// The beam from a point of the disc; `share` is what the lamp sends in a direction outwards.
fn from_lamp(lamp: &Lamp, point: DVec3, [u, v]: [f64; 2], share: impl Fn(DVec3) -> f64) -> Beam {
    let from_centre = point - lamp.position;
    let outwards = from_centre.try_normalize().unwrap_or(DVec3::Z);
    let strength = lamp.falloff.at(from_centre.length().max(lamp.radius)) * share(outwards);
    let (x, y) = outwards.any_orthonormal_pair();
    let (sin, cos) = (TAU * v).sin_cos();
    let place = lamp.position + lamp.radius * u.sqrt() * (cos * x + sin * y);
    let distance = place.distance(point);
    let wi = (place - point).try_normalize().unwrap_or(-outwards);
    Beam { wi, distance, irradiance: lamp.intensity.map(|i| i * strength) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use lumivox_core::Falloff;
    use lumivox_testing::chi_square::{SphereTest, Verdict};

    #[test]
    fn a_soft_suns_light_is_uniform_over_its_cone() {
        let direction = DVec3::new(0.3, -0.8, 0.2).normalize();
        for (i, angular_radius) in [0.3f64, 2.0].into_iter().enumerate() {
            let kind = LightKind::Directional { direction, irradiance: [1.0; 3], angular_radius };
            let solid_angle = TAU * (1.0 - angular_radius.cos());
            let mut rng = Rng::new(i as u64, 0, 0);
            let test = SphereTest { cells: 64, tests: 2, ..Default::default() };
            let fit = test.run(
                |d| if d.dot(-direction) >= angular_radius.cos() { 1.0 / solid_angle } else { 0.0 },
                || beam(&kind.into(), DVec3::ZERO, rng.uniform_2d()).wi,
            );
            assert_eq!(fit.verdict, Verdict::Accepted, "{fit}");
        }
    }

    #[test]
    fn a_lamps_light_comes_from_its_disc() {
        let position = DVec3::new(0.1, 0.2, -0.3);
        let lamp = Lamp { radius: 0.05, ..Lamp::new(position, [2.0, 1.0, 0.5]) };
        let point = DVec3::new(0.2, -0.1, 0.1);
        let away = position - point;
        let mut rng = Rng::new(3, 0, 0);
        let (mut mean, mut squares, n) = (DVec3::ZERO, 0.0, 20_000);
        for _ in 0..n {
            let beam = beam(&Light::point(lamp), point, rng.uniform_2d());
            let place = point + beam.distance * beam.wi;
            assert!((place - position).dot(away).abs() < 1e-12, "the disc faces the point");
            assert!(place.distance(position) <= 0.05 + 1e-12);
            assert!((beam.irradiance[0] - 2.0 / away.length_squared()).abs() < 1e-9);
            mean += place / f64::from(n);
            squares += place.distance_squared(position) / f64::from(n);
        }
        // Uniform over a disc: its centre, and half its squared radius.
        assert!(mean.distance(position) < 1e-3 && (squares / 0.0025 - 0.5).abs() < 0.01, "{mean} {squares}");
    }

    #[test]
    fn a_spot_lights_what_it_points_at() {
        let lamp =
            Lamp { falloff: Falloff::Power { range: 2.0, decay: 1.0 }, ..Lamp::new(DVec3::ZERO, [1.0; 3]) };
        let spot = Light::spot(lamp, DVec3::NEG_Z, 0.4);
        let at = |point: DVec3| beam(&spot, point, [0.0; 2]);
        let ahead = at(DVec3::new(0.0, 0.0, -0.5));
        assert!(ahead.wi.distance(DVec3::Z) < 1e-12 && (ahead.distance - 0.5).abs() < 1e-12);
        let window = (1.0 - 0.25f64.powi(4)).powi(2);
        assert!((ahead.irradiance[1] - 0.9999 * window / 0.5).abs() < 1e-9, "{:?}", ahead.irradiance);
        assert_eq!(at(DVec3::X).irradiance, [0.0; 3]);
        assert_eq!(at(DVec3::new(0.0, 0.0, -2.5)).irradiance, [0.0; 3]);
    }
}
