//! Transfer functions in files: Lumivox's own, and UnityVolumeRendering's `.tf`.
//!
//! Lumivox's own is JSON for people to read and write:
//!
//! ```json
//! {
//!   "lumivox_transfer_function": 1,
//!   "unit": "HU",
//!   "opacity": [
//!     { "value": -200, "opacity": 0 },
//!     { "value": 300, "opacity": 0.8, "ease": "in-out" }
//!   ],
//!   "color": [
//!     { "value": -200, "color": "#b4553c" },
//!     { "value": 300, "color": [0.9, 0.85, 0.7] }
//!   ]
//! }
//! ```
//!
//! Values are physical. A colour in quotes is sRGB, as every colour picker gives it; a list is linear RGB. `ease` says
//! how the curve leaves a knot: `linear` (the default) or `in-out`. `unit` is for the reader only.
//!
//! A function of value and gradient has rows besides: `"gradients": [{ "per_mm": 120, "opacity": [...], "color": [...] }]`,
//! which hold where values change by so much per millimetre; what stands outside of them is for where they do not change.
//!
//! UnityVolumeRendering (<https://github.com/mlavik1/UnityVolumeRendering>, `TransferFunctionDatabase.cs`) writes
//! `version`, `colourPoints` of `dataValue` and `colourValue` (`r`, `g`, `b`, `a`, sRGB), and `alphaPoints` of
//! `dataValue` and `alphaValue`. Its first version's data values run from 0 to 1 over the data set's range, later ones
//! are physical.

mod unity;

use std::{fmt, io::Read, path::Path};

use lumivox_core::color::{linear_from_srgb, srgb_from_linear};
use lumivox_core::medium::MOST_GRADIENTS;
use lumivox_core::{ColorStop, Ease, GradientFunction, OpacityKnot, TransferFunction};
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error as _, SeqAccess, Visitor},
};

use crate::error::ImportError;
use crate::files::File;
use unity::Unity;

/// The version that is written, and the newest that is read.
const VERSION: u64 = 1;

/// Longer than any transfer function.
const LONGEST: u64 = 16 << 20;

/// Loads a transfer function, of Lumivox's or of UnityVolumeRendering's making. `value_range` is the smallest and
/// largest value of the volume that it is for: old `.tf` files are relative to it.
///
/// # Errors
/// [`ImportError`] names the line where the file cannot be understood; a function of gradients, too, is refused.
pub fn load_transfer_function(path: &Path, value_range: [f64; 2]) -> Result<TransferFunction, ImportError> {
    let (function, gradients) = load_transfer_function_2d(path, value_range)?;
    if gradients.is_empty() {
        return Ok(function);
    }
    Err(ImportError::Unsupported {
        path: path.to_owned(),
        what: "a two-dimensional transfer function (over values and gradients)".to_owned(),
        remedy: "Use a one-dimensional one here: the same file without 'gradients'".to_owned(),
    })
}

/// Loads a transfer function with its rows for gradients, if it has any: what
/// [`Medium::gradients`](lumivox_core::Medium::gradients) wants.
///
/// # Errors
/// [`ImportError`] names the line where the file cannot be understood.
pub fn load_transfer_function_2d(
    path: &Path,
    value_range: [f64; 2],
) -> Result<(TransferFunction, Vec<GradientFunction>), ImportError> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(ImportError::io(path))?;
    file.take(LONGEST + 1).read_to_end(&mut bytes).map_err(ImportError::io(path))?;
    if bytes.len() as u64 > LONGEST {
        return Err(not_one(path, "is longer than 16 MiB, more than any transfer function"));
    }
    let text = String::from_utf8(bytes).map_err(|_| not_one(path, "is not text"))?;
    let text = text.trim_start_matches('\u{feff}');
    if text.trim().is_empty() {
        return Err(not_one(path, "is empty"));
    }
    let kind: Kind = parse(path, text)?;
    match kind {
        Kind { lumivox_transfer_function: Some(version), .. } => {
            if version != VERSION {
                return Err(field(
                    path,
                    "lumivox_transfer_function",
                    format!("is {version}, but this Lumivox knows version {VERSION} only"),
                    "Update Lumivox, or save the file with the older one",
                ));
            }
            let own: Own = parse(path, text)?;
            let curve = |opacity: Vec<Knot>, color: Vec<Stop>| {
                let knots = opacity.into_iter().map(|k| OpacityKnot {
                    value: k.value,
                    opacity: k.opacity,
                    ease: k.ease.into(),
                });
                let stops = color.into_iter().map(|s| ColorStop { value: s.value, color: s.color.0 });
                build(path, knots.collect(), stops.collect())
            };
            if own.gradients.len() > MOST_GRADIENTS {
                let problem =
                    format!("are {}, of which {MOST_GRADIENTS} can be told apart", own.gradients.len());
                return Err(field(path, "gradients", problem, "Leave some out"));
            }
            let mut gradients = vec![];
            for Row { per_mm, opacity, color } in own.gradients {
                if !(per_mm > 0.0 && per_mm < 1e12) {
                    let problem = format!("is {per_mm}, and not a number above 0");
                    return Err(field(path, "per_mm", problem, "Correct the file"));
                }
                gradients.push(GradientFunction { per_mm, transfer_function: curve(opacity, color)? });
            }
            Ok((curve(own.opacity, own.color)?, gradients))
        }
        Kind { colour_points: Some(_), alpha_points: Some(_), .. } => {
            let unity: Unity = parse(path, text)?;
            Ok((unity.transfer_function(path, value_range)?, vec![]))
        }
        Kind { boxes: Some(_), .. } => Err(ImportError::Unsupported {
            path: path.to_owned(),
            what: "a two-dimensional transfer function (over values and gradients)".to_owned(),
            remedy: "Use a one-dimensional one".to_owned(),
        }),
        _ => {
            Err(not_one(path, "has neither 'lumivox_transfer_function' nor 'colourPoints' and 'alphaPoints'"))
        }
    }
}

/// Writes a transfer function so that [`load_transfer_function`] gives back the same. `unit` is what its values are
/// in, for people: `HU`, or nothing.
///
/// # Errors
/// [`ImportError::Io`] when the file cannot be written.
pub fn save_transfer_function(
    path: &Path,
    transfer_function: &TransferFunction,
    unit: &str,
) -> Result<(), ImportError> {
    save_transfer_function_2d(path, transfer_function, &[], unit)
}

/// The same with rows for gradients, for [`load_transfer_function_2d`].
///
/// # Errors
/// [`ImportError::Io`] when the file cannot be written.
pub fn save_transfer_function_2d(
    path: &Path,
    transfer_function: &TransferFunction,
    gradients: &[GradientFunction],
    unit: &str,
) -> Result<(), ImportError> {
    std::fs::write(path, to_json(transfer_function, gradients, unit)).map_err(ImportError::io(path))
}

fn to_json(transfer_function: &TransferFunction, gradients: &[GradientFunction], unit: &str) -> String {
    let mut rows = String::new();
    for (i, row) in gradients.iter().enumerate() {
        let separator = if i == 0 { "" } else { "," };
        let per_mm = serde_json::Value::from(row.per_mm);
        rows += &format!("{separator}\n  {{ \"per_mm\": {per_mm},\n{} }}", points(&row.transfer_function));
    }
    let rows = if rows.is_empty() { rows } else { format!(",\n  \"gradients\": [{rows}]") };
    format!(
        "{{\n  \"lumivox_transfer_function\": {VERSION},\n  \"unit\": {},\n{}{rows}\n}}\n",
        serde_json::Value::from(unit),
        points(transfer_function),
    )
}

/// One line for each point, so that people can read and compare it.
fn points(transfer_function: &TransferFunction) -> String {
    let knots = transfer_function
        .opacity_knots()
        .iter()
        .map(|k| serde_json::to_string(&Knot { value: k.value, opacity: k.opacity, ease: k.ease.into() }));
    let stops = transfer_function
        .color_stops()
        .iter()
        .map(|s| serde_json::to_string(&Stop { value: s.value, color: Color(s.color) }));
    let list = |points: &mut dyn Iterator<Item = serde_json::Result<String>>| {
        let points: Vec<_> = points.map(|p| p.expect("finite numbers are JSON")).collect();
        format!("[\n    {}\n  ]", points.join(",\n    "))
    };
    format!("  \"opacity\": {},\n  \"color\": {}", list(&mut { knots }), list(&mut { stops }))
}

/// Tells the formats apart.
#[derive(Deserialize)]
struct Kind {
    lumivox_transfer_function: Option<u64>,
    #[serde(rename = "colourPoints")]
    colour_points: Option<serde::de::IgnoredAny>,
    #[serde(rename = "alphaPoints")]
    alpha_points: Option<serde::de::IgnoredAny>,
    boxes: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Own {
    #[serde(rename = "lumivox_transfer_function")]
    _version: u64,
    #[serde(default, rename = "unit")]
    _unit: String,
    opacity: Vec<Knot>,
    color: Vec<Stop>,
    #[serde(default)]
    gradients: Vec<Row>,
}

/// What holds at a gradient.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    per_mm: f64,
    opacity: Vec<Knot>,
    color: Vec<Stop>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Knot {
    value: f64,
    #[serde(deserialize_with = "unit_interval")]
    opacity: f64,
    #[serde(default, skip_serializing_if = "EaseName::is_default")]
    ease: EaseName,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stop {
    value: f64,
    color: Color,
}

#[derive(Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum EaseName {
    #[default]
    Linear,
    InOut,
}

impl EaseName {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl From<EaseName> for Ease {
    fn from(name: EaseName) -> Self {
        match name {
            EaseName::Linear => Ease::Linear,
            EaseName::InOut => Ease::InOut,
        }
    }
}

impl From<Ease> for EaseName {
    fn from(ease: Ease) -> Self {
        match ease {
            Ease::Linear => EaseName::Linear,
            Ease::InOut => EaseName::InOut,
        }
    }
}

/// Linear RGB, each from 0 to 1.
struct Color([f64; 3]);

impl Serialize for Color {
    /// As `#rrggbb` where that loses nothing, otherwise as numbers.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let bytes = self.0.map(|c| (srgb_from_linear(c) * 255.0).round() as u8);
        if bytes.map(linear_from_byte) == self.0 {
            let [r, g, b] = bytes;
            serializer.serialize_str(&format!("#{r:02x}{g:02x}{b:02x}"))
        } else {
            self.0.serialize(serializer)
        }
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ColorVisitor;

        impl<'de> Visitor<'de> for ColorVisitor {
            type Value = Color;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a color: \"#rrggbb\" (sRGB) or three numbers between 0 and 1 (linear)")
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Color, E> {
                let wrong = || E::custom(format!("color '{text}' is not of the form #rrggbb"));
                let digits =
                    text.strip_prefix('#').filter(|d| d.len() == 6 && d.is_ascii()).ok_or_else(wrong)?;
                let byte = |i: usize| u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).map_err(|_| wrong());
                Ok(Color([byte(0)?, byte(1)?, byte(2)?].map(linear_from_byte)))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Color, A::Error> {
                let mut color = [0.0; 3];
                for (i, component) in color.iter_mut().enumerate() {
                    *component = list.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
                    if !(0.0..=1.0).contains(component) {
                        return Err(A::Error::custom(format!("color {component} is not between 0 and 1")));
                    }
                }
                match list.next_element::<serde::de::IgnoredAny>()? {
                    None => Ok(Color(color)),
                    Some(_) => Err(A::Error::invalid_length(4, &self)),
                }
            }
        }

        deserializer.deserialize_any(ColorVisitor)
    }
}

/// An opacity; checked here, where the line is still known.
fn unit_interval<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let value = f64::deserialize(deserializer)?;
    if (0.0..=1.0).contains(&value) {
        Ok(value)
    } else {
        Err(D::Error::custom(format!("opacity {value} is not between 0 and 1")))
    }
}

fn build(
    path: &Path,
    knots: Vec<OpacityKnot>,
    stops: Vec<ColorStop>,
) -> Result<TransferFunction, ImportError> {
    TransferFunction::new(knots, stops)
        .map_err(|e| field(path, "the transfer function", format!("is impossible: {e}"), "Correct the file"))
}

/// Parses JSON; errors name the line.
fn parse<'de, T: Deserialize<'de>>(path: &Path, text: &'de str) -> Result<T, ImportError> {
    serde_json::from_str(text).map_err(|error| {
        let place = format!(" at line {} column {}", error.line(), error.column());
        let message = error.to_string();
        let message = message.strip_suffix(&place).unwrap_or(&message);
        let place = format!("line {}, column {}", error.line(), error.column());
        let message = plain_words(message);
        field(path, &place, format!("cannot be understood: {message}"), "Correct the file")
    })
}

/// What the parser says of a value of the wrong kind, in the words of JSON instead of those of its program.
fn plain_words(message: &str) -> String {
    let wrong = ["invalid type: ", "invalid value: ", "invalid length "];
    let found = wrong.iter().find_map(|start| Some((*start, message.strip_prefix(start)?)));
    let Some((start, (found, expected))) =
        found.and_then(|(start, rest)| Some((start, rest.split_once(", expected ")?)))
    else {
        return message.to_owned();
    };
    let found = match found {
        length if start == "invalid length " => format!("a list of {length}"),
        "sequence" => "a list".to_owned(),
        "map" => "an object".to_owned(),
        "null" => "null".to_owned(),
        other => format!("the {other}"),
    };
    let expected = match expected {
        "u64" => "a whole number",
        "f64" => "a number",
        "a string" => "a text in quotes",
        "a sequence" => "a list in brackets: [...]",
        expected if expected.starts_with("struct ") => "an object in braces: {...}",
        expected => expected,
    };
    format!("{found} where {expected} belongs")
}

fn not_one(path: &Path, problem: &str) -> ImportError {
    let remedy = "A transfer function is saved by Lumivox, or is a .tf file of UnityVolumeRendering";
    field(path, "the file", problem.to_owned(), remedy)
}

fn field(path: &Path, field: &str, problem: String, remedy: &str) -> ImportError {
    ImportError::Field { path: path.to_owned(), field: field.to_owned(), problem, remedy: remedy.to_owned() }
}

fn linear_from_byte(byte: u8) -> f64 {
    linear_from_srgb(f64::from(byte) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(text: &str) -> Result<TransferFunction, String> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        load_transfer_function(file.path(), [-1000.0, 3000.0]).map_err(|e| {
            let message = e.to_string();
            message.strip_prefix(&format!("{}: ", file.path().display())).unwrap().to_owned()
        })
    }

    #[test]
    fn saving_and_loading_gives_the_same() {
        let knot = |value, opacity, ease| OpacityKnot { value, opacity, ease };
        let original = TransferFunction::new(
            vec![
                knot(-1024.25, 0.0, Ease::InOut),
                knot(1.0 / 3.0, 1.0 / 7.0, Ease::Linear),
                knot(1e-300, 1.0, Ease::Linear),
            ],
            vec![
                ColorStop { value: 0.0, color: [0.1, 0.2, 1.0 / 3.0] },
                ColorStop { value: 5.0, color: [linear_from_byte(18), linear_from_byte(255), 0.0] },
            ],
        )
        .unwrap();
        let file = tempfile::NamedTempFile::new().unwrap();
        save_transfer_function(file.path(), &original, "HU").unwrap();
        assert_eq!(load_transfer_function(file.path(), [0.0, 1.0]).unwrap(), original);
        let text = std::fs::read_to_string(file.path()).unwrap();
        assert!(text.contains(r##""color":"#12ff00""##), "{text}");
    }

    #[test]
    fn every_byte_color_survives_as_hex() {
        for byte in 0..=255u8 {
            let color = Color([linear_from_byte(byte); 3]);
            let text = serde_json::to_string(&color).unwrap();
            assert_eq!(text, format!("\"#{byte:02x}{byte:02x}{byte:02x}\""));
            assert_eq!(serde_json::from_str::<Color>(&text).unwrap().0, color.0);
        }
    }

    #[test]
    fn the_documented_file_loads() {
        let tf = load(
            r##"{ "lumivox_transfer_function": 1, "unit": "HU",
              "opacity": [{ "value": -200, "opacity": 0 }, { "value": 300, "opacity": 0.8, "ease": "in-out" }],
              "color": [{ "value": -200, "color": "#ffffff" }, { "value": 300, "color": [0.9, 0.85, 0.7] }] }"##,
        )
        .unwrap();
        assert_eq!(tf.opacity(50.0), 0.4);
        assert_eq!(tf.color_stops()[0].color, [1.0; 3]);
        assert_eq!(tf.opacity_knots()[1].ease, Ease::InOut);
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        let head = "{ \"lumivox_transfer_function\": 1,\n \"opacity\": [\n";
        let with =
            |knot: &str, stop: &str| load(&format!("{head}{knot}],\n \"color\": [{stop}] }}")).unwrap_err();
        let good = r##"{"value": 0, "color": "#000000"}"##;
        let error = with(r#"{"value": 0, "opacity": 1.5}"#, good);
        assert!(
            error.starts_with("line 3, column") && error.contains("opacity 1.5 is not between 0"),
            "{error}"
        );
        let error = with(r#"{"value": 0}"#, good);
        assert!(error.starts_with("line 3") && error.contains("missing field `opacity`"), "{error}");
        let error = with(r#"{"value": 0, "opacity": 1, "ease": "bouncy"}"#, good);
        assert!(error.contains("unknown variant `bouncy`"), "{error}");
        let error = with(r#"{"value": 0, "opacity": 1}"#, r##"{"value": 0, "color": "#00é00"}"##);
        assert!(error.starts_with("line 4") && error.contains("#rrggbb"), "{error}");
        let error = with(r#"{"value": 0, "opacity": 1}"#, r#"{"value": 0, "color": [0, 1]}"#);
        assert!(error.contains("three numbers"), "{error}");
        let error = with("", good);
        assert!(error.contains("at least one opacity knot"), "{error}");
        assert!(load("").unwrap_err().contains("is empty"));
        let error = with(r#"{"value": null, "opacity": 1}"#, good);
        assert!(error.contains("understood: null where a number belongs"), "{error}");
        let error = with(r#"{"value": 0, "opacity": 1}, 5"#, good);
        assert!(error.contains("the integer `5` where an object in braces: {...} belongs"), "{error}");
        let error = load(r#"{"lumivox_transfer_function": "1"}"#).unwrap_err();
        assert!(error.contains("the string \"1\" where a whole number belongs"), "{error}");
        let error = load("[]").unwrap_err();
        assert!(error.contains("a list of 0 where an object in braces: {...} belongs"), "{error}");
        assert!(load("[1, 2]").is_err());
        assert!(load("{}").unwrap_err().contains("has neither"));
        assert!(load("{\"boxes\": []}").unwrap_err().contains("two-dimensional"));
        assert!(load("hello").unwrap_err().starts_with("line 1"));
        let error = load(r#"{"lumivox_transfer_function": 7, "new": []}"#).unwrap_err();
        assert!(error.contains("is 7, but this Lumivox knows version 1 only"), "{error}");
    }

    #[test]
    fn a_file_that_is_too_long_is_refused_whole() {
        let error = load(&format!("{{}}{}", " ".repeat(LONGEST as usize))).unwrap_err();
        assert!(error.contains("is longer than 16 MiB"), "{error}");
    }

    #[test]
    fn deep_nesting_is_an_error_not_a_stack_overflow() {
        assert!(load(&"[".repeat(1_000_000)).is_err());
        assert!(load(&format!("{{\"opacity\": {}", "[".repeat(1_000_000))).is_err());
    }

    const UNITY: &str = r#"{"version":1,
        "colourPoints":[{"dataValue":0.0,"colourValue":{"r":0.0,"g":0.0,"b":0.0,"a":1.0}},
                        {"dataValue":0.5,"colourValue":{"r":1.0,"g":0.5,"b":0.0,"a":1.0}}],
        "alphaPoints":[{"dataValue":0.25,"alphaValue":0.0},{"dataValue":1.0,"alphaValue":0.5}]}"#;

    #[test]
    fn unity_volume_rendering_is_placed_over_the_value_range() {
        let tf = load(UNITY).unwrap();
        assert_eq!(tf.opacity_knots()[0].value, 0.0);
        assert_eq!(tf.opacity_knots()[1].value, 3000.0);
        assert_eq!(tf.opacity(1500.0), 0.25);
        let [r, g, b] = tf.color(1000.0);
        assert_eq!((r, b), (1.0, 0.0));
        assert!((g - 0.21404).abs() < 1e-5, "{g}");
    }

    #[test]
    fn unity_volume_rendering_in_physical_values_is_kept() {
        let tf = load(&UNITY.replace("\"dataValue\":0.5", "\"dataValue\":400")).unwrap();
        assert_eq!(tf.opacity_knots()[1].value, 1.0);
        assert_eq!(tf.color_stops()[1].value, 400.0);
        let tf = load(&UNITY.replace("\"version\":1", "\"version\":2")).unwrap();
        assert_eq!(tf.opacity_knots()[1].value, 1.0);
        let error = load(&UNITY.replace("\"version\":1", "\"version\":9")).unwrap_err();
        assert!(error.contains("known up to 2"), "{error}");
    }

    #[test]
    fn rows_for_gradients_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("2d.json");
        let curve = |opacity| TransferFunction::constant(opacity, [0.25, 0.5, 1.0]);
        let rows = [(80.0, 0.5), (200.5, 1.0)]
            .map(|(per_mm, opacity)| GradientFunction { per_mm, transfer_function: curve(opacity) });
        save_transfer_function_2d(&path, &curve(0.125), &rows, "HU").unwrap();
        let (function, gradients) = load_transfer_function_2d(&path, [0.0, 1.0]).unwrap();
        assert_eq!((function, gradients.as_slice()), (curve(0.125), &rows[..]));
        let refused = load_transfer_function(&path, [0.0, 1.0]).unwrap_err().to_string();
        assert!(refused.contains("2d.json") && refused.contains("without 'gradients'"), "{refused}");
        let text = std::fs::read_to_string(&path).unwrap();
        for (bad, why) in [("200.5", "-3"), ("200.5", "1e999"), ("\"per_mm\": 80", "\"per_m\": 80")] {
            std::fs::write(&path, text.replacen(bad, why, 1)).unwrap();
            let error = load_transfer_function_2d(&path, [0.0, 1.0]).unwrap_err().to_string();
            assert!(error.contains("2d.json"), "{why}: {error}");
        }
    }
}
