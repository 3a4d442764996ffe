//! The engine's lights: directional, point and spot.
//!
//! They shine on volumes and are not seen themselves. Their colours are linear RGB in the same (relative) watts as an
//! [`Environment`](crate::Environment)'s radiance: a directional light of irradiance E lights a white surface that
//! faces it as an environment of radiance `E / pi` does.
//!
//! What arrives at a point is measured across the beam, not on a surface: a collision there returns
//! `irradiance * f(wo, wi)`, with `wi` towards the light and f the phase function, or a surface's BRDF times cosine.

use glam::DVec3;

/// Least distance, in metres, at which a falloff is evaluated: a light in the midst of a medium stays bounded.
pub const MIN_LIGHT_DISTANCE: f64 = 1e-3;

/// A light and what it reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it shines from, and how brightly.
    pub kind: LightKind,
    /// It lights the instances that share a bit with this mask, see
    /// [`VolumeInstance::layers`](crate::VolumeInstance::layers). It is shadowed by all of them.
    pub layers: u32,
}

/// Where a light shines from, and how brightly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From afar, the same everywhere: a sun.
    Directional {
        /// Where the light travels to, in the world; of any length but zero.
        direction: DVec3,
        /// Linear RGB, summed over all directions that it arrives from: a surface at right angles receives it.
        irradiance: [f64; 3],
        /// Angular radius in radians, 0 to pi: light arrives uniformly over that cone's solid angle. 0 is one direction.
        angular_radius: f64,
    },
    /// From a place in all directions: a bulb.
    Point(Lamp),
    /// From a place into a cone.
    Spot {
        /// The bulb in it.
        lamp: Lamp,
        /// Where the light travels to, in the world; of any length but zero.
        direction: DVec3,
        /// Angle from the axis to the edge of the cone, in radians, 1e-3 to pi.
        half_angle: f64,
        /// How the light falls off towards the edge.
        cone: Cone,
    },
}

/// How a spot's light falls off from its axis to the edge of its cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cone {
    /// `1 - rim^attenuation`, as Godot's lights have it, where `rim = max((1 - cosine) / (1 - cos(half_angle)), 1e-4)`.
    Power {
        /// 0 to 1000; Godot's `spot_angle_attenuation` is its inverse.
        attenuation: f64,
    },
    /// `((cosine - cos(half_angle)) / (cos(inner_half_angle) - cos(half_angle)))^2`, at most 1, as Unity's lights have it.
    Between {
        /// Within this angle to the axis, in radians, it is as bright as on it; less than the half angle.
        inner_half_angle: f64,
    },
}

/// A light at a place.
///
/// At the distance d of its centre its irradiance is `intensity * falloff.at(max(d, radius))`. It arrives from the
/// points of a disc of that `radius` about the centre that faces the point lit, from equal areas equally. Falloff and
/// cone count from the centre, so that the size changes nothing but the softness of shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// The centre, in world metres; each coordinate within 1e9.
    pub position: DVec3,
    /// Linear RGB, irradiance at 1 m where the falloff is physical; 0 to 1e9.
    pub intensity: [f64; 3],
    /// In metres; 0 is a point.
    pub radius: f64,
    /// How light gets weaker with the distance.
    pub falloff: Falloff,
}

/// How light gets weaker with the distance, and where it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Falloff {
    /// `max(1 - (d / range)^4, 0)^2 * d^-decay`, as Godot's lights have it, and with a decay of 2 those of Unity's URP and
    /// HDRP.
    Power {
        /// Distance in metres from where on there is no light; infinite without such an end.
        range: f64,
        /// Exponent of the distance, 0 to 8; 2 is physical.
        decay: f64,
    },
    /// `min(5 (1 - x), 1) / (1 + 25 x^2)` with `x = d / range`, as the lights of Unity's built-in pipeline have it.
    Relative {
        /// Distance in metres from where on there is no light.
        range: f64,
    },
}

impl Default for Falloff {
    fn default() -> Self {
        Self::INVERSE_SQUARE
    }
}

impl Falloff {
    /// What light does: `1 / d^2`.
    pub const INVERSE_SQUARE: Self = Self::Power { range: f64::INFINITY, decay: 2.0 };

    /// Distance in metres from where on there is no light.
    pub fn range(self) -> f64 {
        match self {
            Falloff::Power { range, .. } | Falloff::Relative { range } => range,
        }
    }

    /// The share at a distance d in metres, of at least [`MIN_LIGHT_DISTANCE`].
    pub fn at(self, distance: f64) -> f64 {
        let d = distance.max(MIN_LIGHT_DISTANCE);
        let x = d / self.range();
        match self {
            Falloff::Power { decay, .. } => (1.0 - x.powi(4)).max(0.0).powi(2) * d.powf(-decay),
            Falloff::Relative { .. } => (5.0 * (1.0 - x)).clamp(0.0, 1.0) / (1.0 + 25.0 * x * x),
        }
    }
}

impl Lamp {
    /// A point light of inverse-square falloff.
    pub fn new(position: DVec3, intensity: [f64; 3]) -> Self {
        Self { position, intensity, radius: 0.0, falloff: Falloff::INVERSE_SQUARE }
    }

    fn sanitized(self) -> Option<Self> {
        let falloff = match self.falloff {
            Falloff::Power { range, decay } => {
                Falloff::Power { range, decay: finite(decay)?.clamp(0.0, 8.0) }
            }
            Falloff::Relative { range } => Falloff::Relative { range: finite(range)? },
        };
        let there = self.position.is_finite()
            && self.position.abs().max_element() <= 1e9
            && self.radius.is_finite()
            && falloff.range() > 0.0;
        Some(Self {
            intensity: sanitized_color(self.intensity)?,
            radius: self.radius.max(0.0),
            falloff,
            ..self
        })
        .filter(|_| there)
    }
}

impl LightKind {
    /// The share of a spot's light that it sends at an angle of that cosine to its axis.
    pub fn cone_factor(cosine: f64, half_angle: f64, cone: Cone) -> f64 {
        let edge = half_angle.cos();
        match cone {
            Cone::Power { attenuation } => {
                let rim = ((1.0 - cosine.max(edge)) / (1.0 - edge)).max(1e-4);
                1.0 - rim.powf(attenuation)
            }
            Cone::Between { inner_half_angle } => {
                ((cosine - edge) / (inner_half_angle.cos() - edge)).clamp(0.0, 1.0).powi(2)
            }
        }
    }
}

impl Light {
    /// A sun: light of that irradiance travels along `direction` everywhere.
    pub fn directional(direction: DVec3, irradiance: [f64; 3]) -> Self {
        LightKind::Directional { direction, irradiance, angular_radius: 0.0 }.into()
    }

    /// A bulb.
    pub fn point(lamp: Lamp) -> Self {
        LightKind::Point(lamp).into()
    }

    /// A bulb that shines along `direction` into a cone, brightest along its axis.
    pub fn spot(lamp: Lamp, direction: DVec3, half_angle: f64) -> Self {
        LightKind::Spot { lamp, direction, half_angle, cone: Cone::Power { attenuation: 1.0 } }.into()
    }

    /// The same light with every number inside its documented range and directions of unit length. `None` if it is not
    /// there: a number that is not finite, no direction, no range, a place out of this world.
    #[must_use]
    pub fn sanitized(self) -> Option<Self> {
        let unit = |direction: DVec3| direction.try_normalize();
        let kind = match self.kind {
            LightKind::Directional { direction, irradiance, angular_radius } => LightKind::Directional {
                direction: unit(direction)?,
                irradiance: sanitized_color(irradiance)?,
                angular_radius: finite(angular_radius)?.clamp(0.0, std::f64::consts::PI),
            },
            LightKind::Point(lamp) => LightKind::Point(lamp.sanitized()?),
            LightKind::Spot { lamp, direction, half_angle, cone } => {
                let half_angle = finite(half_angle)?.clamp(1e-3, std::f64::consts::PI);
                LightKind::Spot {
                    lamp: lamp.sanitized()?,
                    direction: unit(direction)?,
                    half_angle,
                    cone: match cone {
                        Cone::Power { attenuation } => {
                            Cone::Power { attenuation: finite(attenuation)?.clamp(0.0, 1e3) }
                        }
                        // Nearer to the edge it would be none in 32 bits.
                        Cone::Between { inner_half_angle } => Cone::Between {
                            inner_half_angle: finite(inner_half_angle)?.clamp(0.0, 0.999 * half_angle),
                        },
                    },
                }
            }
        };
        Some(Self { kind, ..self })
    }
}

/// A light for every layer.
impl From<LightKind> for Light {
    fn from(kind: LightKind) -> Self {
        Self { kind, layers: u32::MAX }
    }
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn sanitized_color(color: [f64; 3]) -> Option<[f64; 3]> {
    color.iter().all(|c| c.is_finite()).then(|| color.map(|c| c.clamp(0.0, 1e9)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_falloff_is_bounded_near_and_ends_at_its_range() {
        let physical = Falloff::default();
        assert!((physical.at(2.0) - 0.25).abs() < 1e-15);
        assert!(physical.at(0.0) == physical.at(MIN_LIGHT_DISTANCE) && physical.at(0.0) <= 1.000_001e6);
        let relative = Falloff::Relative { range: 2.0 };
        assert!((relative.at(1.0) - 1.0 / 7.25).abs() < 1e-15);
        assert!((relative.at(1.9) - 0.25 / (1.0 + 25.0 * 0.9025)).abs() < 1e-12);
        assert_eq!([relative.at(2.0), relative.at(9.0)], [0.0; 2]);
        let short = Falloff::Power { range: 0.5, decay: 1.0 };
        assert_eq!([short.at(0.5), short.at(9.0)], [0.0; 2]);
        // (1 - 1/16)^2 / 0.25.
        assert!((short.at(0.25) - 0.878_906_25 * 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_cone_is_dark_outside_and_full_on_its_axis() {
        let factor = |angle: f64| LightKind::cone_factor(angle.cos(), 0.5, Cone::Power { attenuation: 1.0 });
        assert!((factor(0.0) - 0.9999).abs() < 1e-12);
        assert!(factor(0.5).abs() < 1e-12 && factor(2.0).abs() < 1e-12);
        assert!(factor(0.2) > factor(0.3));
        assert!((factor(0.25) - (1.0 - (1.0 - 0.25f64.cos()) / (1.0 - 0.5f64.cos()))).abs() < 1e-12);
        let between = Cone::Between { inner_half_angle: 0.3 };
        let factor = |angle: f64| LightKind::cone_factor(angle.cos(), 0.5, between);
        assert_eq!([factor(0.0), factor(0.29), factor(0.51), factor(3.0)], [1.0, 1.0, 0.0, 0.0]);
        let half = (0.4f64.cos() - 0.5f64.cos()) / (0.3f64.cos() - 0.5f64.cos());
        assert!((factor(0.4) - half * half).abs() < 1e-12);
    }

    #[test]
    fn lights_that_are_no_lights_are_not_there() {
        let lamp = Lamp::new(DVec3::X, [1.0; 3]);
        assert_eq!(Light::point(lamp).sanitized(), Some(Light::point(lamp)));
        let not_there = [
            Light::directional(DVec3::ZERO, [1.0; 3]),
            Light::directional(DVec3::X, [f64::NAN, 1.0, 1.0]),
            Light::point(Lamp { position: DVec3::new(f64::INFINITY, 0.0, 0.0), ..lamp }),
            Light::point(Lamp { radius: f64::NAN, ..lamp }),
            Light::point(Lamp { falloff: Falloff::Power { range: f64::NAN, decay: 2.0 }, ..lamp }),
            Light::point(Lamp { falloff: Falloff::Power { range: 0.0, decay: 2.0 }, ..lamp }),
            Light::point(Lamp { position: DVec3::NAN, ..lamp }),
            Light::spot(lamp, DVec3::NAN, 0.5),
            Light::spot(lamp, DVec3::X, f64::NAN),
        ];
        for light in not_there {
            assert_eq!(light.sanitized(), None, "{light:?}");
        }
        let odd = Light::directional(DVec3::X * 7.0, [-1.0, 0.5, 2.0]).sanitized().unwrap();
        assert_eq!(odd, Light::directional(DVec3::X, [0.0, 0.5, 2.0]));
    }
}
