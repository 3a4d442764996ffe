//! Transfer functions and presets as documents write them: points as lists, presets by their names.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

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
    opacity: Vec<Knot>,
    /// Points of the colour: a value, and linear RGB from 0 to 1.
    color: Vec<(f64, [f64; 3])>,
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a point of the opacity is [value, opacity] or [value, opacity, \"in-out\"]")]
enum Knot {
    Linear(f64, f64),
    Eased(f64, f64, Ease),
}

impl Serialize for TransferFunction {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let knot = |knot: &OpacityKnot| match knot.ease {
            Ease::Linear => Knot::Linear(knot.value, knot.opacity),
            ease => Knot::Eased(knot.value, knot.opacity, ease),
        };
        Curve {
            opacity: self.opacity_knots().iter().map(knot).collect(),
            color: self.color_stops().iter().map(|stop| (stop.value, stop.color)).collect(),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for TransferFunction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let curve = Curve::deserialize(deserializer)?;
        let knot = |knot| match knot {
            Knot::Linear(value, opacity) => OpacityKnot { value, opacity, ease: Ease::Linear },
            Knot::Eased(value, opacity, ease) => OpacityKnot { value, opacity, ease },
        };
        let stop = |(value, color)| ColorStop { value, color };
        Self::new(curve.opacity.into_iter().map(knot).collect(), curve.color.into_iter().map(stop).collect())
            .map_err(D::Error::custom)
    }
}

impl Serialize for Preset {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Preset {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::from_name(&name).map_err(D::Error::custom)
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
