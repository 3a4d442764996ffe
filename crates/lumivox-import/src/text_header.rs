//! Headers made of text lines, as NRRD and MetaImage have: reading them from the front of a binary file, and naming
//! the line where something is wrong.

use std::{
    fs::File,
    io::{BufRead, BufReader, Read, Take},
    path::Path,
    str::FromStr,
};

use crate::error::ImportError;

/// No header is longer; a file without line ends must not be read whole.
const LONGEST_HEADER: u64 = 8 << 20;

/// The lines at the front of a file.
pub(crate) struct HeaderLines<'a> {
    path: &'a Path,
    input: Take<BufReader<File>>,
    /// Where the next line begins, in bytes.
    pub offset: u64,
    /// The number of the last line, from 1.
    pub line: usize,
}

impl<'a> HeaderLines<'a> {
    pub fn open(path: &'a Path) -> Result<Self, ImportError> {
        let file = File::open(path).map_err(ImportError::io(path))?;
        Ok(Self { path, input: BufReader::new(file).take(LONGEST_HEADER), offset: 0, line: 0 })
    }

    /// The next line without its end, or `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<String>, ImportError> {
        let mut line = Vec::new();
        let read = self.input.read_until(b'\n', &mut line).map_err(ImportError::io(self.path))?;
        if read == 0 {
            if self.offset >= LONGEST_HEADER {
                return Err(ImportError::Field {
                    path: self.path.to_owned(),
                    field: "the header".to_owned(),
                    problem: "does not end".to_owned(),
                    remedy: "The file is damaged; copy or export it again".to_owned(),
                });
            }
            return Ok(None);
        }
        self.offset += read as u64;
        self.line += 1;
        let text = String::from_utf8_lossy(&line);
        Ok(Some(text.trim_end_matches(['\n', '\r']).to_owned()))
    }
}

/// A field of a header.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub name: String,
    pub value: String,
    pub line: usize,
}

/// The fields of a header, in order.
#[derive(Debug)]
pub(crate) struct Fields<'a> {
    pub path: &'a Path,
    pub fields: Vec<Field>,
}

impl Fields<'_> {
    /// The field that goes by any of these names, whatever their case; the first name is preferred.
    pub fn get(&self, names: &[&str]) -> Option<&Field> {
        names.iter().find_map(|name| self.fields.iter().find(|f| f.name.eq_ignore_ascii_case(name)))
    }

    /// As [`Fields::get`]; an error when there is none.
    pub fn require(&self, names: &[&str]) -> Result<&Field, ImportError> {
        self.get(names).ok_or_else(|| ImportError::Field {
            path: self.path.to_owned(),
            field: names[0].to_owned(),
            problem: "is missing from the header".to_owned(),
            remedy: "Export the scan again".to_owned(),
        })
    }

    /// A complaint about a field; `expected` says what it should be: `three positive lengths`.
    pub fn bad(&self, field: &Field, expected: &str) -> ImportError {
        let mut value: String = field.value.chars().take(60).collect();
        if value.len() < field.value.len() {
            value.push_str("...");
        }
        self.complain(field, format!("is '{value}', not {expected}"), "Correct the header or export again")
    }

    /// A complaint about a field in other words.
    pub fn complain(&self, field: &Field, problem: impl Into<String>, remedy: &str) -> ImportError {
        ImportError::Field {
            path: self.path.to_owned(),
            field: format!("{} (line {})", field.name, field.line),
            problem: problem.into(),
            remedy: remedy.to_owned(),
        }
    }

    /// The `count` numbers of a field.
    pub fn numbers<T: FromStr>(
        &self,
        field: &Field,
        count: usize,
        what: &str,
    ) -> Result<Vec<T>, ImportError> {
        parse_list(&field.value)
            .filter(|list| list.len() == count)
            .ok_or_else(|| self.bad(field, &format!("{count} {what}")))
    }

    /// The number of a field.
    pub fn number<T: FromStr>(&self, field: &Field, what: &str) -> Result<T, ImportError> {
        field.value.trim().parse().map_err(|_| self.bad(field, what))
    }
}

/// Numbers between white space, commas and parentheses.
pub(crate) fn parse_list<T: FromStr>(text: &str) -> Option<Vec<T>> {
    text.split(|c: char| c.is_whitespace() || ",()".contains(c))
        .filter(|word| !word.is_empty())
        .map(|word| word.parse().ok())
        .collect()
}

/// The names that a `printf` pattern with one `%d` makes, as NRRD and MetaImage list slices:
/// `pattern first last step`.
pub(crate) fn expand_pattern(pattern: &str, [first, last, step]: [i64; 3]) -> Option<Vec<String>> {
    /// More slices than any scan has.
    const MOST: i64 = 1 << 16;
    let (before, rest) = pattern.split_once('%')?;
    let (digits, after) = rest.split_once('d')?;
    let width: usize = if digits.is_empty() { 0 } else { digits.parse().ok().filter(|w| *w < 20)? };
    let zeros = digits.starts_with('0');
    let count = last.checked_sub(first)?.checked_div(step).filter(|n| (0..MOST).contains(n))? + 1;
    let names = (0..count).map(|i| {
        let number = first + i * step;
        if zeros {
            format!("{before}{number:0width$}{after}")
        } else {
            format!("{before}{number:width$}{after}")
        }
    });
    Some(names.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_expand_as_printf_does() {
        let names = expand_pattern("slice%03d.raw", [8, 12, 2]).unwrap();
        assert_eq!(names, ["slice008.raw", "slice010.raw", "slice012.raw"]);
        assert_eq!(expand_pattern("%d", [3, 1, -1]).unwrap(), ["3", "2", "1"]);
        for (pattern, range) in [
            ("no number", [0, 1, 1]),
            ("%s", [0, 1, 1]),
            ("%d", [0, 1, 0]),
            ("%d", [0, i64::MAX, 1]),
            ("%d", [i64::MIN, i64::MAX, 1]),
            ("%d", [i64::MIN, 0, -1]),
            ("%d", [5, 1, 1]),
            ("%999999999d", [0, 1, 1]),
        ] {
            assert_eq!(expand_pattern(pattern, range), None, "{pattern} {range:?}");
        }
    }

    #[test]
    fn lists_are_parsed_whole_or_not() {
        assert_eq!(parse_list::<f64>("(1, 2.5,-3)"), Some(vec![1.0, 2.5, -3.0]));
        assert_eq!(parse_list::<usize>("4 -4"), None);
    }
}
