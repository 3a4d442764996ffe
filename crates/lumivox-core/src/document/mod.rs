//! A scene as a file: which scans, how they look, in which light and from where; what every host saves and opens.
//!
//! A [`SceneDocument`] is JSON that people read and write. It holds no voxels: scans are files, named as seen from the document's
//! folder, with what was done to them. A host parses one here, opens its files with `lumivox-scene`, and gets a [`Scene`](crate::Scene); the
//! way back is [`SceneDocument::of`].
//!
//! Lengths are millimetres and angles degrees, as in the command's options; colours are linear RGB; the world's y is up. Matrices
//! are three rows of four numbers.

mod color;
mod curve;
mod light;
mod locate;
mod look;
mod measurement;
mod numbers;
mod parts;
pub(crate) mod ranges;
mod read;
mod saved;
mod scan;
mod slices;
mod view;
mod words;

use serde::{Deserialize, Serialize};

use crate::lasso::{Lasso, MOST_LASSOS};

pub use self::{
    color::Color,
    light::{Bulb, Falloff, Lighting, SpotCone, Surroundings},
    locate::{Step, Written},
    look::{Look, Surface},
    measurement::{Measured, Measurement, MeasurementKind, RegionValues},
    numbers::{Rows, affine, rows, world_from_patient, world_rows},
    parts::{Labels, Shape, Space, Style},
    saved::Unsaved,
    scan::{Keep, Scan, TakenOff},
    slices::{Seen, Slab, Slices},
    view::{Backdrop, Display, Film, Tone, View},
    words::DocumentError,
};

/// The version that is written. Whatever an older program would read wrongly counts it up.
pub const VERSION: u32 = 1;

/// A scene as a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SceneDocument {
    /// Where editors find its schema; nobody else looks.
    #[serde(default, rename = "$schema", skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// What tells such a document from other JSON, and its version: 1.
    #[cfg_attr(test, schemars(transform = ranges::schema::version))]
    pub lumivox_scene: u32,
    /// The scans, each with its look. Those without a place share the first one's patient space, its centre at the origin.
    #[serde(default)]
    pub volumes: Vec<Entry>,
    /// The light around.
    #[serde(default)]
    pub environment: Surroundings,
    /// Lights besides.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<Lighting>,
    /// From where it is seen.
    #[serde(default)]
    pub camera: View,
    /// The image that is rendered.
    #[serde(default)]
    pub film: Film,
    /// How light becomes pixels.
    #[serde(default)]
    pub display: Display,
    /// What was measured in the first scan. No picture shows it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measurements: Vec<Measurement>,
    /// How slices of the first scan are seen beside the picture, which shows none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slices: Option<Slices>,
}

impl Default for SceneDocument {
    fn default() -> Self {
        Self {
            schema: None,
            lumivox_scene: VERSION,
            volumes: vec![],
            environment: Surroundings::default(),
            lights: vec![],
            camera: View::default(),
            film: Film::default(),
            display: Display::default(),
            measurements: vec![],
            slices: None,
        }
    }
}

/// A scan in a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Where its voxels are.
    pub scan: Scan,
    /// How it looks.
    #[serde(default)]
    pub look: Look,
    /// Where the patient's millimetres (LPS) lie in the world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::COORDINATE.said()))]
    pub world_from_patient: Option<Rows>,
    /// The lights that share a bit with it shine on it.
    #[serde(default = "first_layer")]
    #[cfg_attr(test, schemars(transform = ranges::WORD.said()))]
    pub layers: u32,
    /// The part that is kept, as fractions along the voxel axes: the low corner, then the high one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::FRACTION.said()))]
    pub clip: Option<[[f64; 3]; 2]>,
    /// What cuts it open.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(test, schemars(length(max = crate::MOST_CLIP_SHAPES)))]
    pub clip_shapes: Vec<Shape>,
    /// Lines that were drawn in pictures of it, and cut away what they enclose.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(test, schemars(length(max = MOST_LASSOS)))]
    pub lassos: Vec<Lasso>,
    /// Which of its voxels are what, and how each looks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<Labels>,
    /// So many millimetres below the skin are not seen, while they stay in the scan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(transform = ranges::PEEL.said()))]
    pub peel: Option<f64>,
}

fn first_layer() -> u32 {
    1
}

impl Entry {
    /// A scan as it looks when nothing is said.
    pub fn new(scan: Scan) -> Self {
        Self { scan, layers: first_layer(), ..Self::default() }
    }
}

/// Only what tells whether the rest can be understood.
#[derive(Deserialize)]
struct Head {
    lumivox_scene: Option<serde_json::Value>,
}

/// A text without the mark by which some editors begin files.
fn without_mark(text: &str) -> &str {
    text.trim_start_matches('\u{feff}')
}

impl SceneDocument {
    /// Whether a file may be a scene document, by how it begins; any part of its beginning will do.
    pub fn is_one(beginning: &[u8]) -> bool {
        let text = String::from_utf8_lossy(beginning);
        text.trim_start_matches('\u{feff}').trim_start().starts_with('{')
            && text.contains("\"lumivox_scene\"")
    }

    /// Reads a document.
    ///
    /// # Errors
    /// [`DocumentError`] with the place of what is wrong: no JSON, an unknown key, a newer version, a number out of its range.
    pub fn parse(text: &str) -> Result<Self, DocumentError> {
        let text = without_mark(text);
        let document = Self::parse_described(text)?;
        match document.volumes.iter().position(|entry| entry.scan.files.is_empty()) {
            Some(index) => {
                let path = ["volumes".into(), index.into(), "scan".into(), "files".into()];
                let why = "a scan has files, such as [\"scans/head\"]".into();
                Err(DocumentError::at(text, &path, why))
            }
            None => Ok(document),
        }
    }

    /// The same of a document whose scans are handed over beside it, see [`Self::described`]: they need no names.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn parse_described(text: &str) -> Result<Self, DocumentError> {
        let text = without_mark(text);
        let none = || {
            let why = format!(
                "this is no scene of Lumivox's: it does not begin with {{\"lumivox_scene\": {VERSION}"
            );
            DocumentError { line: 1, column: 1, why }
        };
        if text.trim_start().starts_with(|letter| letter != '{') {
            return Err(none());
        }
        let head: Head = serde_json::from_str(text).map_err(|error| DocumentError::of(text, &error))?;
        let at = |why: String| DocumentError::at(text, &["lumivox_scene".into()], why);
        match head.lumivox_scene.map(|version| version.as_u64().ok_or(version)) {
            None => return Err(none()),
            Some(Ok(version)) if version == u64::from(VERSION) => {}
            Some(Ok(version)) if version > u64::from(VERSION) => {
                return Err(at(format!(
                    "the scene has version {version}, and this program reads version {VERSION}; a newer Lumivox opens it"
                )));
            }
            Some(Ok(version)) => return Err(at(format!("there is no version {version} of scenes"))),
            Some(Err(version)) => {
                return Err(at(format!("the version is {version}, and not a number such as {VERSION}")));
            }
        }
        let document: Self = serde_json::from_str(text).map_err(|error| DocumentError::of(text, &error))?;
        match document.fault() {
            Some((path, why)) => Err(DocumentError::at(text, &path, why)),
            None => Ok(document),
        }
    }

    /// The document as it is written: indented JSON that ends with a line break. Numbers come back as they were, to the bit.
    ///
    /// # Errors
    /// A file whose name is no Unicode cannot be written down.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        Ok(numbers::compact(&text))
    }

    /// What of a document makes no sense, and its place in it.
    fn fault(&self) -> Option<numbers::Fault> {
        let mut faults = numbers::Faults::default();
        for (index, entry) in self.volumes.iter().enumerate() {
            faults.within(&["volumes".into(), index.into()], |faults| entry.check(faults));
        }
        faults.within(&["environment".into()], |faults| self.environment.check(faults));
        for (index, light) in self.lights.iter().enumerate() {
            faults.within(&["lights".into(), index.into()], |faults| light.check(faults));
        }
        faults.within(&["camera".into()], |faults| self.camera.check(faults));
        faults.within(&["film".into()], |faults| self.film.check(faults));
        faults.within(&["display".into()], |faults| self.display.check(faults));
        for (index, measurement) in self.measurements.iter().enumerate() {
            faults.within(&["measurements".into(), index.into()], |faults| measurement.check(faults));
        }
        if let Some(slices) = &self.slices {
            faults.within(&["slices".into()], |faults| slices.check(faults));
        }
        faults.first()
    }
}

impl Entry {
    fn check(&self, faults: &mut numbers::Faults) {
        faults.within(&["scan".into()], |faults| self.scan.check(faults));
        faults.within(&["look".into()], |faults| self.look.check(faults));
        faults.matrix("world_from_patient", self.world_from_patient.as_ref());
        if let Some([low, high]) = self.clip {
            let inside = low.iter().chain(&high).all(|x| ranges::FRACTION.holds(*x));
            let ordered = low.iter().zip(high).all(|(low, high)| *low < high);
            faults.unless(inside && ordered, "clip", || {
                "clip must be fractions from 0 to 1, each low one below its high one".into()
            });
        }
        for (index, shape) in self.clip_shapes.iter().enumerate() {
            faults.within(&["clip_shapes".into(), index.into()], |faults| shape.check(faults));
        }
        faults.unless(self.clip_shapes.len() <= crate::MOST_CLIP_SHAPES, "clip_shapes", || {
            format!(
                "there are {} shapes, of which {} are possible",
                self.clip_shapes.len(),
                crate::MOST_CLIP_SHAPES
            )
        });
        for (index, lasso) in self.lassos.iter().enumerate() {
            faults.within(&["lassos".into(), index.into()], |faults| parts::check_lasso(lasso, faults));
        }
        faults.unless(self.lassos.len() <= MOST_LASSOS, "lassos", || {
            format!("there are {} lassos, of which {MOST_LASSOS} are possible", self.lassos.len())
        });
        if let Some(labels) = &self.labels {
            faults.within(&["labels".into()], |faults| labels.check(faults));
        }
        faults.number("peel", self.peel, ranges::PEEL);
    }
}

#[cfg(test)]
mod tests;
