//! Typed access to the values of a data set: numbers that are finite, texts that are short and printable.

use crate::dicom::elements::{attributes::Attribute, data_set::DataSet};

/// A header field that is missing, damaged or impossible; becomes [`crate::ImportError::Field`].
#[derive(Clone, Debug)]
pub(crate) struct FieldFault {
    pub(crate) attribute: Attribute,
    pub(crate) problem: String,
    pub(crate) remedy: &'static str,
}

const EXPORT_AGAIN: &str = "Export the scan again, or correct the field with a DICOM editor";

impl FieldFault {
    /// `attribute` has a problem, said as a verb phrase, that a new export may cure.
    pub(crate) fn new(attribute: Attribute, problem: impl Into<String>) -> Self {
        Self { attribute, problem: problem.into(), remedy: EXPORT_AGAIN }
    }

    /// `attribute` is not there.
    pub(crate) fn missing(attribute: Attribute) -> Self {
        Self::new(attribute, "is missing")
    }
}

/// Bytes of a text or of a few numbers; no list of terms is longer (PS3.5 6.2). Some are looked at in every frame anew.
const LONGEST_TEXT: usize = 4096;

impl DataSet {
    /// A text without its padding; what is not printable ASCII becomes `?`.
    pub(crate) fn text(&self, attribute: Attribute) -> Option<String> {
        self.text_up_to(attribute, LONGEST_TEXT)
    }

    fn text_up_to(&self, attribute: Attribute, longest: usize) -> Option<String> {
        let text: String = self.bytes(attribute)?.iter().take(longest).map(|&b| printable(b)).collect();
        let text = text.trim_matches(|c: char| c == '\0' || c == ' ');
        (!text.is_empty()).then(|| text.to_owned())
    }

    /// The parts of a text with several values.
    pub(crate) fn texts(&self, attribute: Attribute) -> Vec<String> {
        let text = self.text(attribute).unwrap_or_default();
        text.split('\\').map(|part| part.trim().to_owned()).collect()
    }

    /// An unsigned binary integer (US, UL).
    pub(crate) fn unsigned(&self, attribute: Attribute) -> Option<u32> {
        let bytes = self.bytes(attribute)?;
        match (bytes.first_chunk::<4>(), bytes.first_chunk::<2>()) {
            (Some(&four), _) if bytes.len() == 4 => {
                Some(if self.big_endian { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) })
            }
            (_, Some(&two)) => {
                Some(if self.big_endian { u16::from_be_bytes(two) } else { u16::from_le_bytes(two) }.into())
            }
            _ => None,
        }
    }

    /// Binary integers of 16 bits (US, SS), as they are stored.
    pub(crate) fn words(&self, attribute: Attribute) -> Option<Vec<u16>> {
        let word = |pair: &[u8]| {
            let pair = [pair[0], pair[1]];
            if self.big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
        };
        self.bytes(attribute).map(|bytes| bytes.chunks_exact(2).map(word).collect())
    }

    /// A binary floating-point number (FL, FD).
    pub(crate) fn float(&self, attribute: Attribute) -> Option<f64> {
        let bytes = self.bytes(attribute)?;
        let value = if let Ok(mut four) = <[u8; 4]>::try_from(bytes) {
            if self.big_endian {
                four.reverse();
            }
            f32::from_le_bytes(four).into()
        } else {
            let mut eight = <[u8; 8]>::try_from(bytes).ok()?;
            if self.big_endian {
                eight.reverse();
            }
            f64::from_le_bytes(eight)
        };
        value.is_finite().then_some(value)
    }

    /// Exactly `N` binary floating-point numbers (FD), every one finite.
    pub(crate) fn floats<const N: usize>(
        &self,
        attribute: Attribute,
    ) -> Result<Option<[f64; N]>, FieldFault> {
        let Some(bytes) = self.bytes(attribute) else { return Ok(None) };
        let number = |eight: &[u8; 8]| {
            if self.big_endian { f64::from_be_bytes(*eight) } else { f64::from_le_bytes(*eight) }
        };
        let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(number).collect();
        match <[f64; N]>::try_from(numbers) {
            Ok(numbers) if numbers.iter().all(|number| number.is_finite()) => Ok(Some(numbers)),
            Ok(_) => Err(FieldFault::new(attribute, "is not made of finite numbers")),
            Err(_) => {
                Err(FieldFault::new(attribute, format!("has {} bytes where {} belong", bytes.len(), 8 * N)))
            }
        }
    }

    /// A time of day (TM), or that part of a date and time (DT), in seconds.
    pub(crate) fn seconds_of_day(&self, attribute: Attribute) -> Option<f64> {
        let text = self.text(attribute)?;
        let clock =
            if text.bytes().take_while(u8::is_ascii_digit).count() >= 14 { &text[8..] } else { &text };
        let two = |at: usize| clock.get(at..at + 2)?.parse::<f64>().ok();
        let fraction = clock.get(6..).filter(|rest| rest.starts_with('.')).map_or(0.0, |rest| {
            let digits = rest[1..].bytes().take_while(u8::is_ascii_digit).count();
            rest[..=digits].parse().unwrap_or(0.0)
        });
        Some(two(0)? * 3600.0 + two(2).unwrap_or(0.0) * 60.0 + two(4).unwrap_or(0.0) + fraction)
    }

    /// A date (DA), as seconds since 1970 at its midnight.
    pub(crate) fn day(&self, attribute: Attribute) -> Option<f64> {
        days_since_1970(&self.text(attribute)?).map(|days| days as f64 * 86_400.0)
    }

    /// How far a clock is ahead of UTC (`+0100`), in seconds.
    pub(crate) fn zone(&self, attribute: Attribute) -> Option<f64> {
        zone(&self.text(attribute)?)
    }

    /// A date and time (DT) in seconds since 1970, by the clock where it was written; and how far that is ahead of UTC,
    /// in seconds, where it says so.
    pub(crate) fn instant(&self, attribute: Attribute) -> Option<(f64, Option<f64>)> {
        let text = self.text(attribute)?;
        number(&text, 8, 14)?;
        let days = days_since_1970(&text)?;
        Some((days as f64 * 86_400.0 + self.seconds_of_day(attribute)?, zone(&text)))
    }

    /// An integer in text (IS).
    pub(crate) fn integer_text(&self, attribute: Attribute) -> Result<Option<i64>, FieldFault> {
        let Some(text) = self.text(attribute) else { return Ok(None) };
        let first = text.split('\\').next().unwrap_or_default().trim();
        match first.parse() {
            Ok(number) => Ok(Some(number)),
            Err(_) => Err(FieldFault::new(attribute, not_numeric(first, "an integer"))),
        }
    }

    /// All numbers of a text with decimals (DS), every one finite.
    pub(crate) fn decimal_list(&self, attribute: Attribute) -> Result<Option<Vec<f64>>, FieldFault> {
        self.decimals_up_to(attribute, usize::MAX)
    }

    fn decimals_up_to(&self, attribute: Attribute, longest: usize) -> Result<Option<Vec<f64>>, FieldFault> {
        let Some(text) = self.text_up_to(attribute, longest) else { return Ok(None) };
        // A backslash parts values, so a comma can only be the decimal comma of a careless writer.
        let parse = |part: &str| part.trim().replace(',', ".").parse().ok().filter(|x: &f64| x.is_finite());
        match text.split('\\').map(parse).collect() {
            Some(numbers) => Ok(Some(numbers)),
            None => Err(FieldFault::new(attribute, not_numeric(&text, "finite numbers"))),
        }
    }

    /// Exactly `N` decimals.
    pub(crate) fn decimals<const N: usize>(
        &self,
        attribute: Attribute,
    ) -> Result<Option<[f64; N]>, FieldFault> {
        let Some(numbers) = self.decimals_up_to(attribute, LONGEST_TEXT)? else { return Ok(None) };
        let count = numbers.len();
        match numbers.try_into() {
            Ok(array) => Ok(Some(array)),
            Err(_) => Err(FieldFault::new(
                attribute,
                format!("has {count} {} where {N} belong", if count == 1 { "value" } else { "values" }),
            )),
        }
    }

    /// The first of some decimals.
    pub(crate) fn decimal(&self, attribute: Attribute) -> Result<Option<f64>, FieldFault> {
        Ok(self.decimals_up_to(attribute, LONGEST_TEXT)?.and_then(|numbers| numbers.first().copied()))
    }
}

/// The digits at a place of a text.
fn number(text: &str, from: usize, to: usize) -> Option<i64> {
    let part = text.get(from..to)?;
    part.bytes().all(|b| b.is_ascii_digit()).then(|| part.parse().ok()).flatten()
}

/// The days from 1970 to a date that a text begins with.
fn days_since_1970(text: &str) -> Option<i64> {
    let (year, month, day) = (number(text, 0, 4)?, number(text, 4, 6)?, number(text, 6, 8)?);
    // By years that begin in March.
    let year = if month <= 2 { year - 1 } else { year };
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    Some(year * 365 + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + of_year - 719_468)
}

/// The time zone in a text, in seconds ahead of UTC.
fn zone(text: &str) -> Option<f64> {
    let at = text.find(['+', '-'])?;
    let minutes = 60 * number(text, at + 1, at + 3)? + number(text, at + 3, at + 5)?;
    Some(if text[at..].starts_with('-') { -60.0 } else { 60.0 } * minutes as f64)
}

fn printable(byte: u8) -> char {
    match byte {
        0 => '\0',
        b'\t' | b'\n' | b'\r' => ' ',
        b if b.is_ascii_graphic() || b == b' ' => b.into(),
        _ => '?',
    }
}

/// What is wrong with a text that should be `expected`. It is quoted only where it is made of numbers' characters: in a
/// damaged file any field may hold a patient's name.
fn not_numeric(text: &str, expected: &str) -> String {
    if text.chars().all(|c| c.is_ascii_digit() || "+-.eE\\, ".contains(c)) {
        format!("is '{}', not {expected}", shorten(text))
    } else {
        "is not a number".to_owned()
    }
}

/// A text as a message can quote it.
fn shorten(text: &str) -> String {
    if text.chars().count() <= 40 {
        text.to_owned()
    } else {
        text.chars().take(37).chain("...".chars()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_numbers_are_quoted() {
        assert_eq!(not_numeric("1.2.3\\-4", "finite numbers"), "is '1.2.3\\-4', not finite numbers");
        for name in ["DOE^JANE", "1.5\\Doe", "nan", "12?"] {
            assert_eq!(not_numeric(name, "finite numbers"), "is not a number");
        }
    }
}
