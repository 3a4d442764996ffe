//! What values are measured in, by DICOM's words for it: RescaleType (PS3.3 C.11.1.1.2), and codes of UCUM.
//!
//! A unit is told to people, and in a damaged file any text may be a patient's name: only what is made of known parts is
//! a unit.

use std::borrow::Cow;

/// The unit of a CT.
pub(crate) const HOUNSFIELD: &str = "HU";

/// A unit, for people.
pub(crate) type Unit = Cow<'static, str>;

/// What the values of an image are, and the factor that makes them so.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Quantity {
    /// What rescaled values are multiplied by.
    pub(crate) factor: f64,
    /// The unit for people; empty where there is none.
    pub(crate) unit: Unit,
    /// A sentence worth telling.
    pub(crate) note: Option<String>,
}

impl Quantity {
    /// Rescaled values as they are, in `unit`.
    pub(crate) fn plain(unit: impl Into<Unit>) -> Self {
        Self { factor: 1.0, unit: unit.into(), note: None }
    }

    /// As [`Quantity::plain`], with something to tell.
    pub(crate) fn told(unit: impl Into<Unit>, note: impl Into<String>) -> Self {
        Self { note: Some(note.into()), ..Self::plain(unit) }
    }
}

/// Whether the code of a unit is UCUM's for a number without one.
pub(crate) fn is_plain_number(code: &str) -> bool {
    code.trim() == "1"
}

/// No unit has more characters.
const LONGEST: usize = 24;

/// The words that units are made of, in lower case.
const PARTS: [&str; 49] = [
    "bq", "kbq", "mbq", "cc", "cm", "cps", "counts", "d", "db", "deg", "e", "g", "gy", "cgy", "h", "hz", "j",
    "k", "kev", "kg", "khz", "kpa", "l", "m", "mg", "min", "ml", "mm", "mmol", "mol", "ms", "mt", "n", "nm",
    "ng", "pa", "ppm", "rad", "s", "sec", "t", "ug", "ul", "um", "umol", "us", "v", "w", "z_eff",
];

/// What a RescaleType, a ModalityLUTType or the code of a unit stands for; `None` where that is nothing, or not known.
pub(crate) fn unit(text: &str) -> Option<Unit> {
    let text = text.trim();
    let term = match text.to_ascii_uppercase().as_str() {
        "HU" | "[HNSF'U]" | "HOUNSFIELD" | "HOUNSFIELD UNIT" | "HOUNSFIELD UNITS" => HOUNSFIELD,
        "HU_MOD" => "modified HU",
        "MGML" => "mg/ml",
        "Z_EFF" => "Z_eff",
        "ED" => "10^23 e/ml",
        "EDW" => "electrons per electron of water",
        "PCT" => "%",
        "OD" => "OD / 1000",
        // Unspecified, and UCUM's for a plain number.
        "US" | "UNSPECIFIED" | "1" | "{NO UNITS}" => return None,
        _ => return is_made_of_parts(text).then(|| text.to_owned().into()),
    };
    Some(term.into())
}

/// Whether every word of it is one that units have: `ml/100ml/s`, `10*-6.mm2/s`.
fn is_made_of_parts(text: &str) -> bool {
    let is_sign = |c: char| c.is_ascii_digit() || " ./()*^-%".contains(c);
    let mut words = text.split(is_sign).filter(|word| !word.is_empty()).peekable();
    // Numbers alone may be anything.
    let has_word = words.peek().is_some() || text.contains('%');
    text.len() <= LONGEST
        && has_word
        && text.bytes().filter(u8::is_ascii_digit).count() <= 6
        && words.all(|word| PARTS.contains(&word.to_ascii_lowercase().as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_told_and_names_are_not() {
        for known in ["ml/100ml/s", "mg/ml", "mm2/s", "mL/(100 mL)/min", "100ug/cc", "10*-6.mm2/s", "%"] {
            assert_eq!(unit(known).as_deref(), Some(known));
        }
        assert_eq!(unit("MGML").as_deref(), Some("mg/ml"));
        assert_eq!(unit("[hnsf'U]").as_deref(), Some(HOUNSFIELD));
        for other in
            ["US", "1", "DOE^JANE", "19500312", "Meg S", "normalized", "", "mg/ml mg/ml mg/ml mg/ml mg/ml"]
        {
            assert_eq!(unit(other), None, "{other}");
        }
    }
}
