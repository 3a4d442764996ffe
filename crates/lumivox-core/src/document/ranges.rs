//! The ranges of a document's numbers, each said once: documents are checked by them, and their schema says them.

use crate::medium::MAX_DENSITY_SCALE;

/// From a number to another, both included.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// The smallest.
    pub low: f64,
    /// The largest.
    pub high: f64,
}

impl Range {
    const fn of(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// Whether a number is one of them.
    pub fn holds(self, number: f64) -> bool {
        (self.low..=self.high).contains(&number)
    }

    /// The nearest of them to a number that is one.
    pub fn nearest(self, number: f64) -> f64 {
        number.clamp(self.low, self.high)
    }
}

/// Further away nothing is seen, and 32-bit floats fail.
pub const FURTHEST_MM: f64 = 1e9;

/// What is a part of a whole: an albedo, an opacity, a colour.
pub const FRACTION: Range = Range::of(0.0, 1.0);
/// A light's radiance, irradiance or intensity.
pub const RADIANCE: Range = Range::of(0.0, 1e9);
/// Whatever has 32 bits, layers among them.
#[cfg(test)]
pub const WORD: Range = Range::of(0.0, u32::MAX as f64);
/// A coordinate, or a number of a matrix.
pub const COORDINATE: Range = Range::of(-FURTHEST_MM, FURTHEST_MM);
/// A part of a direction, whose length says nothing.
pub const DIRECTION: Range = Range::of(-1e9, 1e9);

pub const PHASE: Range = Range::of(1.0, u32::MAX as f64);
pub const SPACING: Range = Range::of(1e-9, 1e9);
pub const SLOPE: Range = Range::of(-1e9, 1e9);
pub const INTERCEPT: Range = Range::of(-1e9, 1e9);
/// Millimetres below the skin: as far as depths are counted.
pub const PEEL: Range = Range::of(0.0, 63.0);

pub const SHIFT: Range = Range::of(-1e9, 1e9);
pub const WINDOW_SCALE: Range = Range::of(0.01, 100.0);
pub const LEVEL: Range = Range::of(-1e9, 1e9);
pub const WIDTH: Range = Range::of(1e-9, 1e9);
pub const THICKNESS: Range = Range::of(1e-3, 1e4);
pub const DENSITY: Range = Range::of(0.0, MAX_DENSITY_SCALE);
pub const ANISOTROPY: Range = Range::of(-0.99, 0.99);
pub const BOUNCES: Range = Range::of(1.0, 1000.0);
/// Gradients, in value units per mm, of a surface.
pub const GRADIENT: Range = Range::of(1e-9, 1e12);
/// Gradients of a row of a two-dimensional transfer function.
pub const PER_MM: Range = Range::of(1e-12, 1e12);

pub const STRENGTH: Range = Range::of(0.0, 1e6);
pub const ROTATION: Range = Range::of(-1e6, 1e6);
pub const SUN_DEGREES: Range = Range::of(0.0, 180.0);
pub const RADIUS: Range = Range::of(0.0, FURTHEST_MM);
pub const LIGHT_RANGE: Range = Range::of(1e-9, FURTHEST_MM);
pub const DECAY: Range = Range::of(0.0, 8.0);
pub const HALF_ANGLE: Range = Range::of(0.06, 180.0);
/// It ends at the half angle, too.
pub const INNER_HALF_ANGLE: Range = Range::of(0.0, 180.0);
pub const ATTENUATION: Range = Range::of(0.0, 1e3);

pub const AZIMUTH: Range = Range::of(-3600.0, 3600.0);
pub const ELEVATION: Range = Range::of(-90.0, 90.0);
pub const ZOOM: Range = Range::of(1e-3, 1e3);
/// Coordinates of a camera, in mm.
pub const EYE: Range = Range::of(-1e6, 1e6);
pub const FOV: Range = Range::of(0.1, 170.0);

/// A side of an image.
pub const SIDE: Range = Range::of(1.0, 32_768.0);
/// Pixels of an image at most.
pub const MOST_PIXELS: u64 = 1 << 28;
/// The film counts in 32-bit floats, which are exact up to here.
pub const SAMPLES: Range = Range::of(1.0, 16_777_216.0);
pub const NOISE: Range = Range::of(1e-4, 1.0);
pub const EXPOSURE: Range = Range::of(-32.0, 32.0);
pub const GAMMA: Range = Range::of(0.1, 10.0);

/// How ranges get into the schema: `#[schemars(transform = ranges::FRACTION.said())]` at the field.
#[cfg(test)]
pub mod schema {
    use schemars::{Schema, transform::Transform};
    use serde_json::{Map, Value, json};

    use super::Range;

    impl Range {
        /// What says a range in a schema.
        pub fn said(self) -> Said {
            Said(self)
        }
    }

    /// A range of a number, or of each number of a list.
    pub struct Said(Range);

    impl Transform for Said {
        fn transform(&mut self, schema: &mut Schema) {
            limit(schema.ensure_object(), self.0);
        }
    }

    /// Says a range of a number, or of each number of a list of them.
    fn limit(schema: &mut Map<String, Value>, range: Range) {
        let is = |word: &str| match &schema["type"] {
            Value::String(one) => one == word,
            Value::Array(several) => several.iter().any(|one| one == word),
            other => panic!("{other} is no type"),
        };
        if is("array") {
            let items = schema.get_mut("items").and_then(Value::as_object_mut);
            return limit(items.expect("a list of numbers"), range);
        }
        let number = |number: f64| if is("integer") { json!(number as u64) } else { json!(number) };
        assert!(is("integer") || is("number"), "{schema:?} is no number");
        let [low, high] = [range.low, range.high].map(number);
        schema.insert("minimum".into(), low);
        schema.insert("maximum".into(), high);
    }

    /// A level and a width.
    pub fn window(schema: &mut Schema) {
        let item =
            schema.remove("items").and_then(|item| item.as_object().cloned()).expect("a list of numbers");
        let limited = [super::LEVEL, super::WIDTH].map(|range| {
            let mut item = item.clone();
            limit(&mut item, range);
            Value::Object(item)
        });
        schema.insert("prefixItems".into(), limited.to_vec().into());
    }

    /// Points by their coordinates.
    pub fn points(schema: &mut Schema) {
        limit(schema.ensure_object(), super::COORDINATE);
    }

    /// A number that is not 0.
    pub fn not_zero(schema: &mut Schema) {
        schema.insert("not".into(), json!({"const": 0}));
    }

    /// A list that is not of zeros alone.
    pub fn not_all_zero(schema: &mut Schema) {
        schema.insert("contains".into(), json!({"not": {"const": 0}}));
    }

    /// The only version.
    pub fn version(schema: &mut Schema) {
        schema.insert("const".into(), json!(crate::document::VERSION));
    }

    /// What has to be said.
    pub fn requires_files(schema: &mut Schema) {
        schema.insert("required".into(), json!(["files"]));
        let files = schema.get_mut("properties").and_then(|all| all.get_mut("files"));
        files.and_then(Value::as_object_mut).expect("files").remove("default");
    }
}
