//! On which line of a document something stands.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::{DocumentError, SceneDocument};

/// A step into JSON: a key, or a place in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// What stands under a key.
    Key(&'static str),
    /// What stands at a place, from 0.
    Index(usize),
}

impl From<&'static str> for Step {
    fn from(key: &'static str) -> Self {
        Self::Key(key)
    }
}

impl From<usize> for Step {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

/// A document with its file and its words, for errors that are found when its files are opened.
#[derive(Clone, Debug)]
pub struct Written {
    /// What it says.
    pub document: SceneDocument,
    file: PathBuf,
    text: String,
}

impl Written {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// As [`SceneDocument::parse`].
    pub fn parse(file: &Path, text: String) -> Result<Self, DocumentError> {
        Ok(Self { document: SceneDocument::parse(&text)?, file: file.to_owned(), text })
    }

    /// The folder that paths are relative to.
    pub fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }

    /// `scene.json, line 12`: where a part stands that keys lead to, in the document or in one of its volumes.
    pub fn place(&self, volume: Option<usize>, keys: &[&'static str]) -> String {
        let mut path: Vec<Step> =
            volume.map_or_else(Vec::new, |volume| vec![Step::from("volumes"), volume.into()]);
        path.extend(keys.iter().copied().map(Step::from));
        format!("{}, line {}", self.file.display(), line(&self.text, &path))
    }
}

/// The line, from 1, of what a path leads to; as far as it leads.
pub fn line(text: &str, path: &[Step]) -> usize {
    (0..=path.len()).rev().find_map(|length| found(text, &path[..length])).unwrap_or(1)
}

fn found(text: &str, path: &[Step]) -> Option<usize> {
    let mut json = serde_json::Deserializer::from_str(text);
    let error = Walk(path).deserialize(&mut json).err()?;
    error.to_string().starts_with(HERE).then(|| error.line())
}

/// The walk ends by an error, for errors know their line.
const HERE: &str = "here it is";

struct Walk<'a>(&'a [Step]);

impl Walk<'_> {
    /// A number or a word: the walk ends here, or leads nowhere.
    fn end<E: Error>(self) -> Result<(), E> {
        if self.0.is_empty() { Err(E::custom(HERE)) } else { Ok(()) }
    }
}

impl<'de> DeserializeSeed<'de> for Walk<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Walk<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("JSON")
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<(), E> {
        self.end()
    }

    fn visit_i64<E: Error>(self, _: i64) -> Result<(), E> {
        self.end()
    }

    fn visit_u64<E: Error>(self, _: u64) -> Result<(), E> {
        self.end()
    }

    fn visit_f64<E: Error>(self, _: f64) -> Result<(), E> {
        self.end()
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        self.end()
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.end()
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Some((first, rest)) = self.0.split_first() else { return Err(A::Error::custom(HERE)) };
        while let Some(key) = map.next_key::<String>()? {
            if matches!(first, Step::Key(wanted) if *wanted == key) {
                if rest.is_empty() {
                    return Err(A::Error::custom(HERE));
                }
                return map.next_value_seed(Walk(rest));
            }
            map.next_value::<IgnoredAny>()?;
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let Some((first, rest)) = self.0.split_first() else { return Err(A::Error::custom(HERE)) };
        let mut index = 0;
        loop {
            if *first == Step::Index(index) {
                return list.next_element_seed(Walk(rest)).map(|_| ());
            }
            if list.next_element::<IgnoredAny>()?.is_none() {
                return Ok(());
            }
            index += 1;
        }
    }
}
