//! Numbers of a document: matrices, and which ranges others must be in.

use std::path::PathBuf;

use glam::{DAffine3, DMat3, DVec3};

use super::{
    locate::{Step, quoted},
    ranges::{COORDINATE, Range},
    words::BACKSLASH,
};

/// Documents have millimetres, scenes metres.
pub const METRES_PER_MM: f64 = 1e-3;

/// The upper three rows of an affine matrix.
pub type Rows = [[f64; 4]; 3];

/// A transform's rows.
pub fn rows(affine: DAffine3) -> Rows {
    let m = affine.matrix3;
    [0, 1, 2].map(|row| [m.x_axis[row], m.y_axis[row], m.z_axis[row], affine.translation[row]])
}

/// The transform of these rows.
pub fn affine(rows: Rows) -> DAffine3 {
    let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
    DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(1), column(2)), column(3))
}

/// Where the patient's millimetres lie in the world: rows of millimetres.
pub fn world_rows(world_from_patient: DAffine3) -> Rows {
    rows(DAffine3::from_scale(DVec3::splat(1.0 / METRES_PER_MM)) * world_from_patient)
}

/// World metres from the patient's millimetres, by rows of millimetres.
pub fn world_from_patient(rows: Rows) -> DAffine3 {
    DAffine3::from_scale(DVec3::splat(METRES_PER_MM)) * affine(rows)
}

/// Where a fault is, and what it is.
pub type Fault = (Vec<Step>, String);

/// Looks for what is out of its range; keeps the first.
#[derive(Default)]
pub struct Faults {
    path: Vec<Step>,
    found: Option<Fault>,
}

impl Faults {
    /// The first fault that was found.
    pub fn first(self) -> Option<Fault> {
        self.found
    }

    /// Looks at what lies further in.
    pub fn within(&mut self, steps: &[Step], look: impl FnOnce(&mut Self)) {
        self.path.extend_from_slice(steps);
        look(self);
        self.path.truncate(self.path.len() - steps.len());
    }

    /// `key` is a fault, unless it is `right`.
    pub fn unless(&mut self, right: bool, key: &'static str, why: impl FnOnce() -> String) {
        if !right && self.found.is_none() {
            let mut path = self.path.clone();
            path.push(key.into());
            self.found = Some((path, why()));
        }
    }

    /// A number, where there is one, must be in its range.
    pub fn number(&mut self, key: &'static str, number: Option<f64>, range: Range) {
        let Some(number) = number else { return };
        self.unless(range.holds(number), key, || {
            format!("{key} is {number}, and must be {} to {}", range.low, range.high)
        });
    }

    /// Three numbers must all be in their range.
    pub fn numbers(&mut self, key: &'static str, numbers: Option<[f64; 3]>, range: Range) {
        numbers.into_iter().flatten().for_each(|number| self.number(key, Some(number), range));
    }

    /// Files have names.
    pub fn files(&mut self, key: &'static str, files: &[PathBuf]) {
        let have_names = files.iter().all(|file| !file.as_os_str().is_empty());
        self.unless(have_names, key, || "a file has no name".into());
        // JSON takes the \n of C:\new for a line break.
        let is_drive = |name: &str| name.get(1..2) == Some(":") || name.starts_with("\\\\");
        let was_path = |file: &PathBuf| {
            let name = file.to_string_lossy();
            (cfg!(windows) || is_drive(&name)) && name.contains(|letter: char| letter.is_ascii_control())
        };
        self.unless(!files.iter().any(was_path), key, || BACKSLASH.into());
    }

    /// A matrix must be one that can be turned back, within a thousand kilometres.
    pub fn matrix(&mut self, key: &'static str, rows: Option<&Rows>) {
        let Some(rows) = rows else { return };
        /// Of a placement in metres, what is smaller than 32 bits hold is nowhere, and what is cut by nothing is whole.
        const MOST_TURNED_BACK: f64 = 1e15;
        let turned_back = affine(*rows).inverse().to_cols_array();
        let is_there = affine(*rows).matrix3.determinant().is_normal()
            && turned_back.iter().all(|number| number.abs() < MOST_TURNED_BACK)
            && rows.iter().flatten().all(|number| COORDINATE.holds(*number));
        self.unless(is_there, key, || {
            format!("{key} is no place: three rows of four numbers, that can be turned back")
        });
    }
}

/// Lists of numbers alone take one line where that is short: a matrix is read row by row. What stands in quotes is left alone.
pub fn compact(json: &str) -> String {
    const SHORT: usize = 100;
    let mut out = String::with_capacity(json.len());
    let mut rest = json;
    while let Some(at) = rest.find(['[', '"']) {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let kept = if rest.starts_with('"') { quoted(rest) } else { numbers(rest).unwrap_or(1) };
        let (part, behind) = rest.split_at(kept);
        let line =
            part.split_whitespace().collect::<Vec<_>>().join(" ").replace("[ ", "[").replace(" ]", "]");
        out.push_str(if part.starts_with('"') || line.len() > SHORT { part } else { &line });
        rest = behind;
    }
    out.push_str(rest);
    out
}

/// How long the list of numbers is that a text begins with; `None` of any other list.
fn numbers(text: &str) -> Option<usize> {
    let is_part = |c: char| c.is_ascii_digit() || c.is_whitespace() || ",.eE+-".contains(c);
    let end = 1 + text[1..].find(|c| !is_part(c))?;
    text[end..].starts_with(']').then_some(end + 1)
}
