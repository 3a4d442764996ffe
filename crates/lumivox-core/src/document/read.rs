//! Parts of a document that are read in two steps. What is wrong in the second is told where the part stands, which the parser
//! knows only as long as it is at it.

use std::{fmt, marker::PhantomData};

use serde::{
    Deserialize, Deserializer,
    de::{Error, MapAccess, Visitor, value::MapAccessDeserializer},
};

/// Reads a word in quotes, and makes something of it.
pub fn word<'de, D: Deserializer<'de>, T>(
    deserializer: D,
    expected: &'static str,
    of: impl FnOnce(&str) -> Result<T, String>,
) -> Result<T, D::Error> {
    struct Read<F>(&'static str, F);

    impl<T, F: FnOnce(&str) -> Result<T, String>> Visitor<'_> for Read<F> {
        type Value = T;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str(self.0)
        }

        fn visit_str<E: Error>(self, word: &str) -> Result<T, E> {
            (self.1)(word).map_err(E::custom)
        }
    }

    deserializer.deserialize_str(Read(expected, of))
}

/// What is wrong with a block that could be read.
pub enum Wrong {
    /// A key that does not belong there, and those that do.
    Unknown(&'static str, &'static [&'static str]),
    /// A key that is not there.
    Missing(&'static str),
    /// Something else.
    Says(String),
}

/// Reads a block, and makes something of it.
pub fn block<'de, D: Deserializer<'de>, B: Deserialize<'de>, T>(
    deserializer: D,
    expected: &'static str,
    of: impl FnOnce(B) -> Result<T, Wrong>,
) -> Result<T, D::Error> {
    struct Read<B, F>(&'static str, F, PhantomData<B>);

    impl<'de, B: Deserialize<'de>, T, F: FnOnce(B) -> Result<T, Wrong>> Visitor<'de> for Read<B, F> {
        type Value = T;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str(self.0)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
            (self.1)(B::deserialize(MapAccessDeserializer::new(map))?).map_err(|wrong| match wrong {
                Wrong::Unknown(key, known) => A::Error::unknown_field(key, known),
                Wrong::Missing(key) => A::Error::missing_field(key),
                Wrong::Says(why) => A::Error::custom(why),
            })
        }
    }

    deserializer.deserialize_map(Read(expected, of, PhantomData))
}
