//! The light of a document, and its way to and from that of a scene.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize};

use super::{
    color,
    numbers::{Faults, METRES_PER_MM},
    ranges,
    read::{self, Wrong},
};
use crate::{
    environment::{Environment, EnvironmentMap, EnvironmentSource},
    light::{self, Cone, Lamp, Light, LightKind},
};

/// The light around a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Surroundings {
    /// `studio`, `uniform`, `gradient`, or an equirectangular `.hdr` or `.exr` file.
    pub source: PathBuf,
    /// Factor on the light.
    #[cfg_attr(test, schemars(transform = ranges::STRENGTH.said()))]
    pub strength: f64,
    /// Degrees that it turns around the vertical, as the camera's azimuth does.
    #[cfg_attr(test, schemars(transform = ranges::ROTATION.said()))]
    pub rotation: f64,
    /// Radiance from everywhere, if uniform.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "color::some")]
    #[cfg_attr(test, schemars(with = "Option<color::Radiance>"))]
    pub color: Option<[f64; 3]>,
    /// Radiance from straight up, if a gradient.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "color::some")]
    #[cfg_attr(test, schemars(with = "Option<color::Radiance>"))]
    pub zenith: Option<[f64; 3]>,
    /// Radiance from the horizon, if a gradient.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "color::some")]
    #[cfg_attr(test, schemars(with = "Option<color::Radiance>"))]
    pub horizon: Option<[f64; 3]>,
    /// Radiance from straight down, if a gradient.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "color::some")]
    #[cfg_attr(test, schemars(with = "Option<color::Radiance>"))]
    pub nadir: Option<[f64; 3]>,
}

impl Default for Surroundings {
    fn default() -> Self {
        Self {
            source: STUDIO.into(),
            strength: 1.0,
            rotation: 0.0,
            color: None,
            zenith: None,
            horizon: None,
            nadir: None,
        }
    }
}

const STUDIO: &str = "studio";
const UNIFORM: &str = "uniform";
const GRADIENT: &str = "gradient";

impl Surroundings {
    /// The radiances of a gradient where none are given: an overcast sky over dim ground; zenith, horizon, nadir.
    pub const OVERCAST: [[f64; 3]; 3] = [[1.5, 1.6, 1.8], [1.0, 1.0, 1.0], [0.16, 0.15, 0.14]];

    /// Whether its source is one of the words, and no file.
    fn is_word(&self) -> bool {
        [STUDIO, UNIFORM, GRADIENT].iter().any(|word| self.source == Path::new(word))
    }

    /// The file of its map, if that is what it is.
    pub fn file(&self) -> Option<&Path> {
        (!self.is_word()).then_some(self.source.as_path())
    }

    /// The environment; `map` is what was read of [`Self::file`].
    pub fn environment(&self, map: Option<Arc<EnvironmentMap>>) -> Environment {
        let source = match (self.source.to_str(), map) {
            (_, Some(map)) => EnvironmentSource::Map(map),
            (Some(UNIFORM), None) => EnvironmentSource::Uniform(self.color.unwrap_or([1.0; 3])),
            (Some(GRADIENT), None) => {
                let [zenith, horizon, nadir] = Self::OVERCAST;
                EnvironmentSource::Gradient {
                    zenith: self.zenith.unwrap_or(zenith),
                    horizon: self.horizon.unwrap_or(horizon),
                    nadir: self.nadir.unwrap_or(nadir),
                }
            }
            (_, None) => EnvironmentSource::Studio,
        };
        Environment { source, rotation: self.rotation.to_radians(), strength: self.strength }
    }

    /// What an environment is; `None` of a map that no file is known of.
    pub fn of(environment: &Environment) -> Option<Self> {
        let common = Self {
            strength: environment.strength,
            rotation: environment.rotation.to_degrees(),
            ..Self::default()
        };
        Some(match &environment.source {
            EnvironmentSource::Studio => common,
            EnvironmentSource::Uniform(color) => {
                Self { source: UNIFORM.into(), color: Some(*color), ..common }
            }
            EnvironmentSource::Gradient { zenith, horizon, nadir } => Self {
                source: GRADIENT.into(),
                zenith: Some(*zenith),
                horizon: Some(*horizon),
                nadir: Some(*nadir),
                ..common
            },
            EnvironmentSource::Map(map) => Self { source: map.file()?.to_owned(), ..common },
        })
    }

    pub(super) fn check(&self, faults: &mut Faults) {
        // A bare word is a typing error rather than a file.
        let may_be_file = self.source.to_string_lossy().contains(['.', '/']);
        faults.unless(self.is_word() || may_be_file, "source", || {
            let source = self.source.display();
            format!("the light '{source}' is not studio, uniform, gradient or an .hdr or .exr file")
        });
        faults.number("strength", Some(self.strength), ranges::STRENGTH);
        faults.number("rotation", Some(self.rotation), ranges::ROTATION);
        faults.numbers("color", self.color, ranges::RADIANCE);
        faults.numbers("zenith", self.zenith, ranges::RADIANCE);
        faults.numbers("horizon", self.horizon, ranges::RADIANCE);
        faults.numbers("nadir", self.nadir, ranges::RADIANCE);
    }
}

/// A light besides the environment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum Lighting {
    /// From afar.
    Sun {
        /// Where the light travels to, in the world.
        #[cfg_attr(test, schemars(transform = ranges::DIRECTION.said(), transform = ranges::schema::not_all_zero))]
        direction: [f64; 3],
        /// Linear RGB; pi lights a white surface that faces it as an environment of radiance 1 does.
        #[cfg_attr(test, schemars(transform = ranges::RADIANCE.said()))]
        irradiance: [f64; 3],
        /// Its radius in the sky, in degrees.
        #[serde(default)]
        #[cfg_attr(test, schemars(transform = ranges::SUN_DEGREES.said()))]
        degrees: f64,
        /// The volumes that share a bit with it are lit.
        #[serde(default = "all_layers")]
        #[cfg_attr(test, schemars(transform = ranges::WORD.said()))]
        layers: u32,
    },
    /// From a place in all directions.
    Point {
        /// The bulb.
        lamp: Bulb,
        /// The volumes that share a bit with it are lit.
        #[serde(default = "all_layers")]
        #[cfg_attr(test, schemars(transform = ranges::WORD.said()))]
        layers: u32,
    },
    /// From a place into a cone.
    Spot {
        /// The bulb in it; its intensity is that on the axis.
        lamp: Bulb,
        /// Where the light travels to, in the world.
        #[cfg_attr(test, schemars(transform = ranges::DIRECTION.said(), transform = ranges::schema::not_all_zero))]
        direction: [f64; 3],
        /// Degrees from the axis to the edge of the cone.
        #[cfg_attr(test, schemars(transform = ranges::HALF_ANGLE.said()))]
        half_angle: f64,
        /// How it falls off towards the edge.
        #[serde(default)]
        cone: SpotCone,
        /// The volumes that share a bit with it are lit.
        #[serde(default = "all_layers")]
        #[cfg_attr(test, schemars(transform = ranges::WORD.said()))]
        layers: u32,
    },
}

/// What lights of all kinds have. Read first, whatever the kind is, which may be said last, so that what is wrong is told at its
/// own place.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AnyLight {
    kind: Kind,
    direction: Option<[f64; 3]>,
    irradiance: Option<[f64; 3]>,
    degrees: Option<f64>,
    lamp: Option<Bulb>,
    half_angle: Option<f64>,
    cone: Option<SpotCone>,
    #[serde(default = "all_layers")]
    layers: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Sun,
    Point,
    Spot,
}

impl<'de> Deserialize<'de> for Lighting {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read::block(deserializer, "a block of a light, in { }", AnyLight::light)
    }
}

impl AnyLight {
    /// The light, if it has what its kind has and nothing else.
    fn light(self) -> Result<Lighting, Wrong> {
        let any = self;
        let said = [
            ("direction", any.direction.is_some()),
            ("irradiance", any.irradiance.is_some()),
            ("degrees", any.degrees.is_some()),
            ("lamp", any.lamp.is_some()),
            ("half_angle", any.half_angle.is_some()),
            ("cone", any.cone.is_some()),
        ];
        let keys: &'static [&'static str] = match any.kind {
            Kind::Sun => &["kind", "direction", "irradiance", "degrees", "layers"],
            Kind::Point => &["kind", "lamp", "layers"],
            Kind::Spot => &["kind", "lamp", "direction", "half_angle", "cone", "layers"],
        };
        if let Some((key, _)) = said.iter().find(|(key, is_said)| *is_said && !keys.contains(key)) {
            return Err(Wrong::Unknown(key, keys));
        }
        let missing = Wrong::Missing;
        let (layers, direction) = (any.layers, any.direction.ok_or_else(|| missing("direction")));
        let lamp = any.lamp.ok_or_else(|| missing("lamp"));
        Ok(match any.kind {
            Kind::Sun => Lighting::Sun {
                direction: direction?,
                irradiance: any.irradiance.ok_or_else(|| missing("irradiance"))?,
                degrees: any.degrees.unwrap_or_default(),
                layers,
            },
            Kind::Point => Lighting::Point { lamp: lamp?, layers },
            Kind::Spot => Lighting::Spot {
                lamp: lamp?,
                direction: direction?,
                half_angle: any.half_angle.ok_or_else(|| missing("half_angle"))?,
                cone: any.cone.unwrap_or_default(),
                layers,
            },
        })
    }
}

/// A light at a place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Bulb {
    /// Its centre in the world, in mm.
    #[cfg_attr(test, schemars(transform = ranges::COORDINATE.said()))]
    pub position: [f64; 3],
    /// Linear RGB: irradiance at 1 m, where the falloff is physical.
    #[cfg_attr(test, schemars(transform = ranges::RADIANCE.said()))]
    pub intensity: [f64; 3],
    /// In mm; 0 is a point.
    #[serde(default)]
    #[cfg_attr(test, schemars(transform = ranges::RADIUS.said()))]
    pub radius: f64,
    /// How it gets weaker with the distance.
    #[serde(default)]
    pub falloff: Falloff,
}

fn all_layers() -> u32 {
    u32::MAX
}

/// How a lamp's light gets weaker with the distance; by default by its square, without an end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Falloff {
    /// A power of the distance, faded out before an end.
    Power {
        /// Distance in mm from where on there is no light; none is without an end.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[cfg_attr(test, schemars(transform = ranges::LIGHT_RANGE.said()))]
        range: Option<f64>,
        /// Exponent of the distance; 2 is physical.
        #[cfg_attr(test, schemars(transform = ranges::DECAY.said()))]
        decay: f64,
    },
    /// Of the distance relative to an end, as the lights of Unity's built-in pipeline have it.
    Relative {
        /// Distance in mm from where on there is no light.
        #[cfg_attr(test, schemars(transform = ranges::LIGHT_RANGE.said()))]
        range: f64,
    },
}

impl Default for Falloff {
    fn default() -> Self {
        Self::Power { range: None, decay: 2.0 }
    }
}

/// How a spot falls off from its axis to its edge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SpotCone {
    /// By a power of the distance to the edge, as Godot's.
    Attenuation(#[cfg_attr(test, schemars(transform = ranges::ATTENUATION.said()))] f64),
    /// From an inner cone, whose degrees to the axis these are, to the edge, as Unity's.
    InnerHalfAngle(#[cfg_attr(test, schemars(transform = ranges::INNER_HALF_ANGLE.said()))] f64),
}

impl Default for SpotCone {
    fn default() -> Self {
        Self::Attenuation(1.0)
    }
}

impl Falloff {
    fn of(falloff: light::Falloff) -> Self {
        match falloff {
            light::Falloff::Power { range, decay } => {
                // As it shines: what is beyond is no fault of a scene that is saved.
                let decay = decay.clamp(ranges::DECAY.low, ranges::DECAY.high);
                Self::Power { range: range.is_finite().then(|| range / METRES_PER_MM), decay }
            }
            light::Falloff::Relative { range } => Self::Relative { range: range / METRES_PER_MM },
        }
    }

    fn falloff(self) -> light::Falloff {
        match self {
            Self::Power { range, decay } => {
                light::Falloff::Power { range: range.map_or(f64::INFINITY, |mm| mm * METRES_PER_MM), decay }
            }
            Self::Relative { range } => light::Falloff::Relative { range: range * METRES_PER_MM },
        }
    }

    fn check(self, faults: &mut Faults) {
        let (kind, range, decay) = match self {
            Self::Power { range, decay } => ("power", range, Some(decay)),
            Self::Relative { range } => ("relative", Some(range), None),
        };
        faults.within(&["falloff".into(), kind.into()], |faults| {
            faults.number("range", range, ranges::LIGHT_RANGE);
            faults.number("decay", decay, ranges::DECAY);
        });
    }
}

impl Bulb {
    fn of(lamp: Lamp) -> Self {
        Self {
            position: (lamp.position / METRES_PER_MM).to_array(),
            intensity: lamp.intensity,
            radius: lamp.radius / METRES_PER_MM,
            falloff: Falloff::of(lamp.falloff),
        }
    }

    fn lamp(self) -> Lamp {
        Lamp {
            position: DVec3::from_array(self.position) * METRES_PER_MM,
            intensity: self.intensity,
            radius: self.radius * METRES_PER_MM,
            falloff: self.falloff.falloff(),
        }
    }

    fn check(self, faults: &mut Faults) {
        faults.within(&["lamp".into()], |faults| {
            faults.numbers("position", Some(self.position), ranges::COORDINATE);
            faults.numbers("intensity", Some(self.intensity), ranges::RADIANCE);
            faults.number("radius", Some(self.radius), ranges::RADIUS);
            self.falloff.check(faults);
        });
    }
}

impl SpotCone {
    fn of(cone: Cone) -> Self {
        match cone {
            Cone::Power { attenuation } => Self::Attenuation(attenuation),
            Cone::Between { inner_half_angle } => Self::InnerHalfAngle(inner_half_angle.to_degrees()),
        }
    }

    fn cone(self) -> Cone {
        match self {
            Self::Attenuation(attenuation) => Cone::Power { attenuation },
            Self::InnerHalfAngle(degrees) => Cone::Between { inner_half_angle: degrees.to_radians() },
        }
    }
}

impl Lighting {
    /// A light of a scene.
    pub fn of(light: &Light) -> Self {
        let layers = light.layers;
        match light.kind {
            LightKind::Directional { direction, irradiance, angular_radius } => Self::Sun {
                direction: direction.to_array(),
                irradiance,
                degrees: angular_radius.to_degrees(),
                layers,
            },
            LightKind::Point(lamp) => Self::Point { lamp: Bulb::of(lamp), layers },
            LightKind::Spot { lamp, direction, half_angle, cone } => Self::Spot {
                lamp: Bulb::of(lamp),
                direction: direction.to_array(),
                half_angle: half_angle.to_degrees(),
                cone: SpotCone::of(cone),
                layers,
            },
        }
    }

    /// The light in a scene.
    pub fn light(&self) -> Light {
        match *self {
            Self::Sun { direction, irradiance, degrees, layers } => Light {
                kind: LightKind::Directional {
                    direction: DVec3::from_array(direction),
                    irradiance,
                    angular_radius: degrees.to_radians(),
                },
                layers,
            },
            Self::Point { lamp, layers } => Light { kind: LightKind::Point(lamp.lamp()), layers },
            Self::Spot { lamp, direction, half_angle, cone, layers } => Light {
                kind: LightKind::Spot {
                    lamp: lamp.lamp(),
                    direction: DVec3::from_array(direction),
                    half_angle: half_angle.to_radians(),
                    cone: cone.cone(),
                },
                layers,
            },
        }
    }

    pub(super) fn check(&self, faults: &mut Faults) {
        let aim = |faults: &mut Faults, direction: [f64; 3]| {
            faults.numbers("direction", Some(direction), ranges::DIRECTION);
            let is_one = DVec3::from_array(direction).try_normalize().is_some();
            faults.unless(is_one, "direction", || "the light travels nowhere: direction is zero".into());
        };
        match *self {
            Self::Sun { direction, irradiance, degrees, .. } => {
                aim(faults, direction);
                faults.numbers("irradiance", Some(irradiance), ranges::RADIANCE);
                faults.number("degrees", Some(degrees), ranges::SUN_DEGREES);
            }
            Self::Point { lamp, .. } => lamp.check(faults),
            Self::Spot { lamp, direction, half_angle, cone, .. } => {
                lamp.check(faults);
                aim(faults, direction);
                faults.number("half_angle", Some(half_angle), ranges::HALF_ANGLE);
                faults.within(&["cone".into()], |faults| match cone {
                    SpotCone::Attenuation(power) => {
                        faults.number("attenuation", Some(power), ranges::ATTENUATION);
                    }
                    SpotCone::InnerHalfAngle(degrees) => {
                        let range = ranges::Range { high: half_angle, ..ranges::INNER_HALF_ANGLE };
                        faults.number("inner_half_angle", Some(degrees), range);
                    }
                });
            }
        }
    }
}
