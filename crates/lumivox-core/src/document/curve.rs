//! Transfer functions and presets as documents write them: points as lists, presets by their names.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, SeqAccess, Visitor},
};

use super::{
    color::Rgb,
    ranges::FRACTION,
    read::{self, Wrong},
};
use crate::{
    presets::Preset,
    transfer_function::{ColorStop, Ease, OpacityKnot, TransferFunction},
};

/// `{"opacity": [[-50, 0], [150, 0.8, "in-out"]], "color": [[0, [1, 0.9, 0.8]]]}`.
#[derive(Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(rename = "TransferFunction"))]
#[serde(deny_unknown_fields)]
struct Curve {
    /// Points of the opacity: a value, the opacity there from 0 to 1, and how it goes on, which is `linear` where nothing is said.
    #[cfg_attr(test, schemars(length(min = 1)))]
    opacity: Vec<Knot>,
    /// Points of the colour: a value, and linear RGB from 0 to 1, or the colour that screens show: `#rrggbb`.
    #[cfg_attr(test, schemars(length(min = 1)))]
    color: Vec<(f64, Rgb)>,
}

#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
enum Knot {
    Linear(f64, #[cfg_attr(test, schemars(transform = FRACTION.said()))] f64),
    Eased(f64, #[cfg_attr(test, schemars(transform = FRACTION.said()))] f64, Ease),
}

/// One after the other, so that what is wrong in it is told at its own place.
impl<'de> Deserialize<'de> for Knot {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = Knot;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("[value, opacity] or [value, opacity, \"in-out\"]")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Knot, A::Error> {
                let value: f64 = list.next_element()?.ok_or_else(|| A::Error::invalid_length(0, &self))?;
                let opacity = list.next_element()?.ok_or_else(|| A::Error::invalid_length(1, &self))?;
                if !FRACTION.holds(opacity) {
                    return Err(A::Error::custom(format!(
                        "the opacity at {value} is {opacity}, and must be 0 to 1"
                    )));
                }
                Ok(match list.next_element()? {
                    Some(ease) => Knot::Eased(value, opacity, ease),
                    None => Knot::Linear(value, opacity),
                })
            }
        }

        deserializer.deserialize_seq(Read)
    }
}

impl Serialize for TransferFunction {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let knot = |knot: &OpacityKnot| match knot.ease {
            Ease::Linear => Knot::Linear(knot.value, knot.opacity),
            ease => Knot::Eased(knot.value, knot.opacity, ease),
        };
        Curve {
            opacity: self.opacity_knots().iter().map(knot).collect(),
            color: self.color_stops().iter().map(|stop| (stop.value, Rgb(stop.color))).collect(),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for TransferFunction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read::block(deserializer, "a block of opacity and color, in { }", Curve::function)
    }
}

impl Curve {
    fn function(self) -> Result<TransferFunction, Wrong> {
        let knot = |knot| match knot {
            Knot::Linear(value, opacity) => OpacityKnot { value, opacity, ease: Ease::Linear },
            Knot::Eased(value, opacity, ease) => OpacityKnot { value, opacity, ease },
        };
        let stop = |(value, Rgb(color))| ColorStop { value, color };
        let (opacity, color) = (self.opacity.into_iter().map(knot), self.color.into_iter().map(stop));
        TransferFunction::new(opacity.collect(), color.collect())
            .map_err(|error| Wrong::Says(error.to_string()))
    }
}

impl Serialize for Preset {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Preset {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read::word(deserializer, "a preset's name in quotes", |name| {
            Self::from_name(name).map_err(|error| error.to_string())
        })
    }
}

#[cfg(test)]
mod schema {
    use std::borrow::Cow;

    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

    use super::{Curve, Preset, TransferFunction};

    impl JsonSchema for TransferFunction {
        fn schema_name() -> Cow<'static, str> {
            "TransferFunction".into()
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            Curve::json_schema(generator)
        }
    }

    impl JsonSchema for Preset {
        fn schema_name() -> Cow<'static, str> {
            "Preset".into()
        }

        fn json_schema(_: &mut SchemaGenerator) -> Schema {
            json_schema!({ "description": "A named look.", "enum": Preset::names() })
        }
    }
}
