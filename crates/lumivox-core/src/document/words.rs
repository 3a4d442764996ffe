//! What is wrong with a document's JSON, in plain words and at its place. The parser's own are for programmers, and of a block they
//! name the end.

use serde::de::IgnoredAny;
use serde_json::error::Category;

use super::locate::{Found, Part, Step, line_and_column, start, walk};
use crate::{color::srgb_from_hex, spelling::edit_distance};

/// Why a text is no scene document, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {why}")]
pub struct DocumentError {
    /// The line, from 1.
    pub line: usize,
    /// The letter of that line, from 1.
    pub column: usize,
    /// What is wrong there.
    pub why: String,
}

impl DocumentError {
    /// What is wrong with what a path leads to.
    pub(super) fn at(text: &str, path: &[Step], why: String) -> Self {
        Self::here(text, start(text, path), why)
    }

    fn here(text: &str, byte: usize, why: String) -> Self {
        let (line, column) = line_and_column(text, byte);
        Self { line, column, why }
    }

    /// What the parser says of a text.
    pub(super) fn of(text: &str, error: &serde_json::Error) -> Self {
        let all = error.to_string();
        // Its own place stands at the end of its words.
        let said = all.rsplit_once(" at line ").map_or(all.as_str(), |(said, _)| said);
        let lines = text.split_inclusive('\n').take(error.line().saturating_sub(1));
        // Of the last letter that it has read, or of the one that it does not take.
        let byte = lines.map(str::len).sum::<usize>() + error.column().saturating_sub(1);
        let byte = byte.min(text.len());
        let is_json = serde_json::from_str::<IgnoredAny>(text).is_ok();
        if is_json || matches!(error.classify(), Category::Data) {
            of_content(text, byte, said)
        } else {
            of_syntax(text, byte, said)
        }
    }
}

/// What is no JSON.
fn of_syntax(text: &str, byte: usize, said: &str) -> DocumentError {
    let here = |why: &str| DocumentError::here(text, byte, why.to_owned());
    let letter = text[floor(text, byte)..].chars().next();
    if said.starts_with("EOF") {
        return unfinished(text);
    }
    let before = text[..floor(text, byte)].trim_end();
    if matches!(letter, Some('}' | ']')) && before.ends_with(',') {
        let why = "a comma before the closing bracket: take it out".to_owned();
        return DocumentError::here(text, before.len() - 1, why);
    }
    let behind = &text[floor(text, byte)..];
    let is_comment = behind.starts_with("//") || behind.starts_with("/*");
    // Not a colour without its quotes.
    let is_colour = behind.get(..7).is_some_and(|word| srgb_from_hex(word).is_some());
    if (is_comment || behind.starts_with('#') && !is_colour) && !said.contains("escape") {
        return here("JSON has no comments: take this out");
    }
    match said {
        _ if said.contains("escape") || said.contains("surrogate") || said.contains("unicode code point") => {
            let backslash = text[..floor(text, byte + 1)].rfind('\\').unwrap_or(byte);
            DocumentError::here(text, backslash, BACKSLASH.to_owned())
        }
        _ if said.starts_with("control character") => here(
            "text ends on the line on which it begins: a closing \" is missing here, or a line break is too many",
        ),
        "key must be a string" => here("a key belongs here, in double quotes, such as \"samples\""),
        "expected `:`" => here("a colon is missing here, between a key and its value"),
        "expected `,` or `}`" | "expected `,` or `]`" => {
            here("a comma is missing before this, or a bracket or quote is not closed before it")
        }
        "invalid number" => {
            here("this is no number as JSON writes them: 0.5 and not .5, 1.0 and not 1., 7 and not 07")
        }
        "number out of range" => here("this number is larger than computers hold"),
        "trailing characters" => {
            here("the scene has ended before this: a bracket is too many, or text behind it")
        }
        "recursion limit exceeded" => here("brackets within brackets, more than any scene has"),
        "expected value" | "expected ident" => here(
            "no value begins so: text stands in double quotes, numbers have digits, and else there are true, false, [ ] and { }",
        ),
        other => here(other),
    }
}

pub(super) const BACKSLASH: &str =
    "a backslash in a path is written twice, or use /: \"C:\\\\scans\\\\head\" or \"C:/scans/head\"";

/// A text that ends too early.
fn unfinished(text: &str) -> DocumentError {
    let end = text.trim_end().len();
    let mut open = None;
    walk(text, &mut |_, part: Part| {
        if part.is_open && open.is_none() {
            open = Some(part.start);
        }
    });
    let why = match open {
        Some(byte) => format!(
            "the file ends before it is whole: the {} of line {} is not closed",
            &text[byte..=byte],
            line_and_column(text, byte).0
        ),
        None if end == 0 => "the file is empty".to_owned(),
        None => "the file ends before it is whole".to_owned(),
    };
    DocumentError::here(text, end.saturating_sub(1), why)
}

/// JSON that says what scenes do not.
fn of_content(text: &str, byte: usize, said: &str) -> DocumentError {
    // Behind a key stands what was read of the colon; a list or block that is not taken has not been read.
    let letters = text.as_bytes();
    let next = (byte + 1..letters.len()).find(|at| !letters[*at].is_ascii_whitespace());
    let is_unread = said.starts_with("invalid type: map") || said.starts_with("invalid type: sequence");
    let byte = match next.filter(|at| is_unread && matches!(letters[*at], b'{' | b'[')) {
        Some(next) => next,
        None => (0..=byte.min(letters.len().saturating_sub(1)))
            .rev()
            .find(|at| !letters[*at].is_ascii_whitespace())
            .unwrap_or(0),
    };
    let (path, part) = part_at(text, byte);
    let (path, part) = match said {
        // It is the next of a list that has all.
        "trailing characters" => part_of(text, &path[..path.len().saturating_sub(1)]).unwrap_or((path, part)),
        _ => (path, part),
    };
    let start = match said.strip_prefix("unknown field `").and_then(|rest| rest.split_once('`')) {
        Some((key, _)) => key_of(text, &path, key).or(part.key).unwrap_or(part.start),
        None if said.starts_with("duplicate field") => part.key.unwrap_or(part.start),
        None => part.start,
    };
    DocumentError::here(text, start, in_plain_words(said, &path, &text[part.start..part.end]))
}

/// The innermost value, its key included, that a byte is in.
fn part_at(text: &str, byte: usize) -> (Vec<Found>, Part) {
    let mut found = None;
    walk(text, &mut |path, part| {
        if found.is_none() && (part.key.unwrap_or(part.start)..part.end).contains(&byte) {
            found = Some((path.to_vec(), part));
        }
    });
    found.unwrap_or_else(|| (vec![], Part { key: None, start: 0, end: text.len(), is_open: false }))
}

fn part_of(text: &str, wanted: &[Found]) -> Option<(Vec<Found>, Part)> {
    let mut found = None;
    walk(text, &mut |path, part| {
        if path == wanted {
            found = Some((path.to_vec(), part));
        }
    });
    found
}

/// Where a key stands in a block, or in the one around it.
fn key_of(text: &str, path: &[Found], key: &str) -> Option<usize> {
    let mut found = None;
    walk(text, &mut |here, part| {
        let is_it = matches!(here.last(), Some(Found::Key(name)) if name == key);
        let is_within = here.len() == path.len() + 1 && here.starts_with(path) || here == path;
        if is_it && is_within {
            found = found.or(part.key);
        }
    });
    found
}

/// The parser's words in those of people who write scenes.
fn in_plain_words(said: &str, path: &[Found], value: &str) -> String {
    let name = path.iter().rev().find_map(|step| match step {
        Found::Key(key) => Some(key.as_str()),
        Found::Index(_) => None,
    });
    let name = match (name, path.last()) {
        (None, _) => "a scene".to_owned(),
        (Some(name), Some(Found::Index(index))) => format!("entry {} of {name}", index + 1),
        (Some(name), _) => name.to_owned(),
    };
    if let Some((found, expected)) = parts(said, "invalid type: ") {
        // Commas of what stands in quotes are not those between both.
        let hint = match expected {
            "u32" | "f64" if value.trim_matches('"').parse::<f64>().is_ok() => ": leave the quotes out",
            _ => "",
        };
        return format!("{name} has to be {}, not {}{hint}", kind(expected), thing(found, value));
    }
    if let Some((_, expected)) = parts(said, "invalid value: ") {
        return format!("{name} has to be {}, and is {value}", kind(expected));
    }
    if let Some((found, expected)) = parts(said, "invalid length ") {
        return format!("{name} has to be {}, and has {found}", kind(expected));
    }
    if let Some((key, expected)) = parts(said, "unknown field ") {
        let known = words(expected);
        let meant = meant(key.trim_matches('`'), &known);
        return format!("there is no key {key} here{meant} are {}", listed(&known)).replace('`', "'");
    }
    if let Some((word, expected)) = parts(said, "unknown variant ") {
        let known = words(expected);
        let meant = meant(word.trim_matches('`'), &known);
        return format!("{name}: there is no {word}{meant} are {}", listed(&known)).replace('`', "'");
    }
    if let Some(key) = said.strip_prefix("missing field ") {
        return format!("{key} is missing in this block").replace('`', "'");
    }
    if let Some(key) = said.strip_prefix("duplicate field ") {
        return format!("{key} is said twice").replace('`', "'");
    }
    match said {
        "trailing characters" => format!("{name} has more entries than it may have"),
        "expected value" => format!("{name} has to be one word in quotes, or a block of one key"),
        other => other.to_owned(),
    }
}

/// What was found and what was expected, of what the parser says with such a beginning.
fn parts<'a>(said: &'a str, beginning: &str) -> Option<(&'a str, &'a str)> {
    said.strip_prefix(beginning)?.rsplit_once(", expected ").or_else(|| {
        // Of a block without keys there is nothing to expect.
        said.strip_prefix(beginning)?.split_once(", there are no ")
    })
}

/// What was expected.
fn kind(expected: &str) -> String {
    match expected {
        "u32" | "u64" | "usize" => format!("a whole number from 0 to {}", u32::MAX),
        "f64" => "a number".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" => "text in quotes".to_owned(),
        "path string" => "a file's name in quotes".to_owned(),
        "a sequence" => "a list, in [ ]".to_owned(),
        _ if expected.starts_with("struct ") => "a block, in { }".to_owned(),
        _ if expected.starts_with("enum ") || expected == "string or map" => "a word in quotes".to_owned(),
        _ => match expected.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length} entries, in [ ]"),
            None => expected.to_owned(),
        },
    }
}

/// What was found, as it was written where that is short.
fn thing(found: &str, value: &str) -> String {
    const SHORT: usize = 40;
    match found {
        "map" => "a block".to_owned(),
        "sequence" => "a list".to_owned(),
        "null" => "null".to_owned(),
        _ if found.starts_with("string ") && value.len() <= SHORT => format!("text: {value}"),
        _ if found.starts_with("string ") => "text".to_owned(),
        _ if value.len() <= SHORT => value.to_owned(),
        _ => found.to_owned(),
    }
}

/// Names in backquotes.
fn words(expected: &str) -> Vec<&str> {
    expected.split('`').skip(1).step_by(2).collect()
}

fn listed(words: &[&str]) -> String {
    match words {
        [] => "none".to_owned(),
        [one] => (*one).to_owned(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

/// The word that was probably meant, and the beginning of those that there are.
fn meant(word: &str, known: &[&str]) -> String {
    let near = known.iter().map(|name| (edit_distance(word, name), *name)).min();
    match near.filter(|(distance, name)| *distance <= name.len() / 3) {
        Some((_, name)) => format!(", did you mean `{name}`? There"),
        None => "; there".to_owned(),
    }
}

/// The beginning of the letter that a byte is of.
fn floor(text: &str, byte: usize) -> usize {
    (0..=byte.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0)
}
