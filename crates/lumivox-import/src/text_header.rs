//! Headers made of text lines, as NRRD and MetaImage have: reading them from the front of a binary file, naming the line
//! where something is wrong, and what both say of their samples in the same words.

use std::{
    io::{BufRead, BufReader, Read, Take},
    path::{Component, Path, PathBuf},
    str::FromStr,
};

use crate::{
    error::ImportError,
    files::File,
    payload::{ByteSkip, Encoding},
};

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
    /// Whether data files may lie anywhere ([`crate::ImportOptions::allow_outside_data`]).
    pub allow_outside_data: bool,
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

/// What -1 means for the bytes to skip where samples are compressed or text, so that they have no known length to count
/// back from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnknownTail {
    /// No byte is skipped: MetaIO, which looks at its HeaderSize for raw samples only, writes and reads it so.
    IsNothing,
    /// Samples of compressed data lie at their end, as pynrrd reads it, though the definition of NRRD allows it for raw ones
    /// only. Of text it is refused.
    IsCounted,
}

/// Where the samples are.
impl Fields<'_> {
    /// What lies before the samples of each file, by the field that goes by any of `names`.
    ///
    /// # Errors
    /// When it is no number of bytes.
    pub fn byte_skip(
        &self,
        names: &[&str],
        encoding: Encoding,
        tail: UnknownTail,
    ) -> Result<ByteSkip, ImportError> {
        let Some(field) = self.get(names) else { return Ok(ByteSkip::Bytes(0)) };
        let expected = match (encoding, tail) {
            (Encoding::Text | Encoding::Hex, UnknownTail::IsCounted) => "a number of bytes",
            _ => "a number of bytes, or -1",
        };
        match self.number::<i64>(field, expected)? {
            -1 if encoding == Encoding::Raw => Ok(ByteSkip::Tail),
            -1 if tail == UnknownTail::IsNothing => Ok(ByteSkip::Bytes(0)),
            -1 if encoding == Encoding::Deflate => Ok(ByteSkip::Tail),
            skip => u64::try_from(skip).map(ByteSkip::Bytes).map_err(|_| self.bad(field, expected)),
        }
    }

    /// The files that `field` names, in the header's folder: those of the `list` that follows it, those that a pattern
    /// makes (`slice%03d.raw 1 100 1`), or a single one.
    ///
    /// # Errors
    /// When it names none, and one that does not lie beside the header or below it, unless that is allowed.
    pub fn data_files(&self, field: &Field, list: &[String]) -> Result<Vec<PathBuf>, ImportError> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let words: Vec<&str> = field.value.split_whitespace().collect();
        let number = |i: usize| words.get(i).and_then(|word| word.parse::<i64>().ok());
        let names = match (words.first(), number(1), number(2), number(3)) {
            (None, ..) => {
                return Err(self.complain(field, "names no file", "Name the file that holds the samples"));
            }
            (Some(&"LIST"), ..) if list.is_empty() => {
                return Err(self.complain(
                    field,
                    "is followed by no file name",
                    "List one file for each slice",
                ));
            }
            (Some(&"LIST"), ..) => list.to_vec(),
            (Some(pattern), Some(first), Some(last), Some(step)) if pattern.contains('%') => {
                expand_pattern(pattern, [first, last, step])
                    .ok_or_else(|| self.bad(field, "a pattern such as 'slice%03d.raw 1 100 1'"))?
            }
            _ => vec![field.value.clone()],
        };
        let is_beside = |name: &String| self.allow_outside_data || is_below(folder, Path::new(name));
        if !names.iter().all(is_beside) {
            let problem = "names a data file that does not lie beside the header or below it";
            return Err(self.complain(field, problem, OUTSIDE));
        }
        Ok(names.iter().map(|name| folder.join(name)).collect())
    }
}

/// What to do about data files elsewhere.
const OUTSIDE: &str = "Put both into one folder; of a header that you trust, allow it (--allow-outside-data, in Godot \
                       'Allow data outside the scan's folder', in scripts allow_outside_data)";

/// Whether a header in `folder` may name a file: nothing that leads out of it, be it by a link. A header comes from
/// strangers; it must not choose which of the user's files are read, nor have another computer asked for one.
pub(crate) fn is_below(folder: &Path, name: &Path) -> bool {
    // Of another system's ways to say where, too.
    let text = name.to_string_lossy();
    let is_plain = text.as_bytes().get(1) != Some(&b':')
        && !text.starts_with('\\')
        && !text.split(['/', '\\']).any(|part| part == "..");
    let leads_down = name.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !is_plain || !leads_down {
        return false;
    }
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match (crate::files::canonicalize(folder), crate::files::canonicalize(folder.join(name))) {
        (Ok(real_folder), Ok(real)) => real.starts_with(real_folder),
        // What is not there is complained about where it is looked for.
        _ => true,
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
fn expand_pattern(pattern: &str, [first, last, step]: [i64; 3]) -> Option<Vec<String>> {
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
    fn bytes_to_skip_are_a_number_or_a_known_tail() {
        let skip = |value: &str, encoding, tail| {
            let field = Field { name: "skip".to_owned(), value: value.to_owned(), line: 7 };
            let fields = Fields { path: Path::new("scan"), fields: vec![field], allow_outside_data: false };
            fields.byte_skip(&["skip"], encoding, tail).map_err(|error| error.to_string())
        };
        for tail in [UnknownTail::IsNothing, UnknownTail::IsCounted] {
            assert_eq!(skip("12", Encoding::Deflate, tail), Ok(ByteSkip::Bytes(12)));
            assert_eq!(skip("-1", Encoding::Raw, tail), Ok(ByteSkip::Tail));
            let error = skip("-2", Encoding::Raw, tail).unwrap_err();
            assert!(error.contains("skip (line 7) is '-2', not a number of bytes, or -1"), "{error}");
        }
        for encoding in [Encoding::Deflate, Encoding::Text] {
            assert_eq!(skip("-1", encoding, UnknownTail::IsNothing), Ok(ByteSkip::Bytes(0)));
        }
        assert_eq!(skip("-1", Encoding::Deflate, UnknownTail::IsCounted), Ok(ByteSkip::Tail));
        let error = skip("-1", Encoding::Text, UnknownTail::IsCounted).unwrap_err();
        assert!(error.contains("'-1', not a number of bytes.") && !error.contains("or -1"), "{error}");
    }

    #[test]
    fn data_files_are_listed_made_or_named() {
        let fields = Fields { path: Path::new("folder/scan"), fields: Vec::new(), allow_outside_data: false };
        let files = |value: &str, list: &[&str]| {
            let field = Field { name: "file".to_owned(), value: value.to_owned(), line: 7 };
            let list: Vec<String> = list.iter().map(|name| (*name).to_owned()).collect();
            let files = fields.data_files(&field, &list).map_err(|error| error.to_string())?;
            Ok(files.iter().map(|file| file.strip_prefix("folder").unwrap().display().to_string()).collect())
        };
        let found = |names: &[&str]| -> Result<Vec<String>, String> {
            Ok(names.iter().map(|name| (*name).to_owned()).collect())
        };
        assert_eq!(files("LIST", &["a", "b c"]), found(&["a", "b c"]));
        assert_eq!(files("s%d.raw 1 3 2", &[]), found(&["s1.raw", "s3.raw"]));
        assert_eq!(files("50% of it.raw", &[]), found(&["50% of it.raw"]));
        for (value, words) in [
            ("", "names no file. Name the file"),
            ("LIST", "is followed by no file name. List"),
            ("s%s.raw 1 3 2", "not a pattern such as"),
        ] {
            let error = files(value, &[]).unwrap_err();
            assert!(error.contains("file (line 7)") && error.contains(words), "{error}");
        }
    }

    #[test]
    fn lists_are_parsed_whole_or_not() {
        assert_eq!(parse_list::<f64>("(1, 2.5,-3)"), Some(vec![1.0, 2.5, -3.0]));
        assert_eq!(parse_list::<usize>("4 -4"), None);
    }
}
