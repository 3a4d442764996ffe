//! Colours of a document: linear RGB, or as screens show them, `#rrggbb`. Written are the numbers.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error, SeqAccess, Visitor, value::SeqAccessDeserializer},
};

use super::ranges::{FRACTION, Range};
use crate::color::{linear_from_srgb, srgb_from_hex};

/// Linear RGB, each from 0 to 1.
#[derive(Clone, Copy, Serialize)]
pub struct Rgb(pub [f64; 3]);

/// A label's colour: linear RGB, or its own, which its file gives it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Color {
    /// Its own, or with `false` the transfer function's.
    Own(bool),
    /// Linear RGB.
    Rgb([f64; 3]),
}

/// A light's colour, which may be brighter than 1.
struct Light([f64; 3]);

/// A light's colour where there is one.
pub fn some<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f64; 3]>, D::Error> {
    Ok(Option::<Light>::deserialize(deserializer)?.map(|Light(color)| color))
}

/// The colour that `#rrggbb` is on a screen.
fn of_screen<E: Error>(text: &str) -> Result<[f64; 3], E> {
    let codes = srgb_from_hex(text).ok_or_else(|| {
        E::custom(format!("'{text}' is no colour; write it as \"#c0503c\", or as [0.6, 0.1, 0.1]"))
    })?;
    Ok(codes.map(|code| linear_from_srgb(f64::from(code) / 255.0)))
}

/// What is written of a colour.
struct Read {
    /// Whether a label's own is one.
    may_be_own: bool,
    /// Where nobody looks later.
    range: Option<Range>,
}

impl<'de> Visitor<'de> for Read {
    type Value = Color;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("three numbers, such as [0.6, 0.1, 0.1], or \"#c0503c\"")?;
        if self.may_be_own { formatter.write_str(", or true for the label's own") } else { Ok(()) }
    }

    fn visit_bool<E: Error>(self, is_own: bool) -> Result<Color, E> {
        if self.may_be_own {
            return Ok(Color::Own(is_own));
        }
        Err(E::invalid_type(serde::de::Unexpected::Bool(is_own), &self))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Color, E> {
        of_screen(text).map(Color::Rgb)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Color, A::Error> {
        let color = <[f64; 3]>::deserialize(SeqAccessDeserializer::new(list))?;
        if let Some(range) = self.range
            && let Some(part) = color.iter().find(|part| !range.holds(**part))
        {
            let Range { low, high } = range;
            return Err(A::Error::custom(format!(
                "a part of the colour is {part}, and must be {low} to {high}"
            )));
        }
        Ok(Color::Rgb(color))
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Read { may_be_own: true, range: None })
    }
}

fn numbers<'de, D: Deserializer<'de>>(deserializer: D, range: Option<Range>) -> Result<[f64; 3], D::Error> {
    match deserializer.deserialize_any(Read { may_be_own: false, range })? {
        Color::Rgb(color) => Ok(color),
        Color::Own(_) => unreachable!("only a label has a colour of its own"),
    }
}

impl<'de> Deserialize<'de> for Light {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        numbers(deserializer, None).map(Self)
    }
}

impl<'de> Deserialize<'de> for Rgb {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        numbers(deserializer, Some(FRACTION)).map(Self)
    }
}

#[cfg(test)]
pub use schema::Radiance;

#[cfg(test)]
mod schema {
    use std::borrow::Cow;

    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema, transform::Transform};

    use super::{Color, Rgb};
    use crate::document::ranges::{FRACTION, RADIANCE, Range};

    /// A light's colour.
    pub struct Radiance;

    fn numbers(generator: &mut SchemaGenerator, range: Range) -> Schema {
        let mut numbers = <[f64; 3]>::json_schema(generator);
        range.said().transform(&mut numbers);
        numbers.insert("description".into(), "Linear RGB.".into());
        numbers
    }

    fn screen() -> Schema {
        json_schema!({
            "description": "As screens show it (sRGB).",
            "type": "string",
            "pattern": "^#[0-9a-fA-F]{6}$"
        })
    }

    impl JsonSchema for Radiance {
        fn schema_name() -> Cow<'static, str> {
            "Radiance".into()
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            json_schema!({ "description": "A light's colour.", "anyOf": [numbers(generator, RADIANCE), screen()] })
        }
    }

    impl JsonSchema for Rgb {
        fn schema_name() -> Cow<'static, str> {
            "Rgb".into()
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            json_schema!({ "description": "A colour.", "anyOf": [numbers(generator, FRACTION), screen()] })
        }
    }

    impl JsonSchema for Color {
        fn schema_name() -> Cow<'static, str> {
            "Color".into()
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            json_schema!({
                "description": "A label's colour: linear RGB, as screens show it, or its own, which its file gives it.",
                "anyOf": [
                    { "description": "Its own, or with `false` the transfer function's.", "type": "boolean" },
                    numbers(generator, FRACTION),
                    screen()
                ]
            })
        }
    }
}
