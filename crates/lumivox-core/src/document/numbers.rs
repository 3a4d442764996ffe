//! Numbers of a document: matrices, and which ranges others must be in.

use glam::{DAffine3, DMat3, DVec3};

use super::locate::Step;

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

    /// A number, where there is one, must be from `low` to `high`.
    pub fn number(&mut self, key: &'static str, number: Option<f64>, low: f64, high: f64) {
        let Some(number) = number else { return };
        self.unless((low..=high).contains(&number), key, || {
            format!("{key} is {number}, and must be {low} to {high}")
        });
    }

    /// Three numbers must all be from `low` to `high`.
    pub fn numbers(&mut self, key: &'static str, numbers: Option<[f64; 3]>, low: f64, high: f64) {
        numbers.into_iter().flatten().for_each(|number| self.number(key, Some(number), low, high));
    }

    /// A matrix must be one that can be turned back, within a thousand kilometres.
    pub fn matrix(&mut self, key: &'static str, rows: Option<&Rows>) {
        let Some(rows) = rows else { return };
        let is_there = affine(*rows).matrix3.determinant().is_normal()
            && rows.iter().flatten().all(|x| x.abs() <= FURTHEST_MM);
        self.unless(is_there, key, || {
            format!("{key} is no place: three rows of four numbers, that can be turned back")
        });
    }
}

/// Further away nothing is seen, and 32-bit floats fail.
pub const FURTHEST_MM: f64 = 1e9;

/// Lists of numbers alone, and lists of those, take one line where that is short: a matrix is read row by row.
pub fn compact(json: &str) -> String {
    const SHORT: usize = 100;
    let mut out = String::with_capacity(json.len());
    let mut rest = json;
    while let Some(open) = rest.find('[') {
        out.push_str(&rest[..open]);
        rest = &rest[open..];
        let end = rest.find(|c: char| !(c.is_ascii_digit() || c.is_whitespace() || "[,.eE+-".contains(c)));
        let list = end.filter(|&end| rest[end..].starts_with(']') && rest[1..end].find('[').is_none());
        match list {
            Some(end) => {
                let line: Vec<&str> = rest[1..end].split(',').map(str::trim).collect();
                let line = format!("[{}]", line.join(", "));
                out.push_str(if line.len() <= SHORT { &line } else { &rest[..=end] });
                rest = &rest[end + 1..];
            }
            None => {
                out.push('[');
                rest = &rest[1..];
            }
        }
    }
    out.push_str(rest);
    out
}
