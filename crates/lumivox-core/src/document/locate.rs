//! Where in a document something stands.

use std::path::{Path, PathBuf};

use super::{DocumentError, SceneDocument};

/// A step into JSON: a key, or a place in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// What stands under a key.
    Key(&'static str),
    /// What stands at a place, from 0.
    Index(usize),
}

impl From<&'static str> for Step {
    fn from(key: &'static str) -> Self {
        Self::Key(key)
    }
}

impl From<usize> for Step {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

/// A document with its file and its words, for errors that are found when its files are opened.
#[derive(Clone, Debug)]
pub struct Written {
    /// What it says.
    pub document: SceneDocument,
    file: PathBuf,
    folder: PathBuf,
    text: String,
}

impl Written {
    /// Reads the text of a file; paths in it are seen from the file's folder.
    ///
    /// # Errors
    /// As [`SceneDocument::parse`].
    pub fn parse(file: &Path, text: String) -> Result<Self, DocumentError> {
        let document = SceneDocument::parse(&text)?;
        let text = super::without_mark(&text).to_owned();
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self { document, file: file.to_owned(), folder, text })
    }

    /// The same, whose paths are seen from another folder: of a link, that of the file to which it leads.
    #[must_use]
    pub fn seen_from(self, folder: PathBuf) -> Self {
        Self { folder, ..self }
    }

    /// The folder that paths are relative to.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// `scene.json, line 12, column 9`: where a part stands that steps lead to; as far as they lead.
    pub fn place(&self, path: &[Step]) -> String {
        let (line, column) = line_and_column(&self.text, start(&self.text, path));
        format!("{}, line {line}, column {column}", self.file.display())
    }
}

/// Line and column, both from 1, of a byte of a text; columns count letters.
pub fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = String::from_utf8_lossy(&text.as_bytes()[..byte.min(text.len())]);
    let line = before.rsplit('\n').next().unwrap_or_default();
    (1 + before.matches('\n').count(), 1 + line.chars().count())
}

/// The byte at which begins what a path leads to; as far as it leads.
pub fn start(text: &str, path: &[Step]) -> usize {
    let mut best = None;
    walk(text, &mut |found, part| {
        let leads = found.len() <= path.len() && found.iter().zip(path).all(|(a, b)| a == b);
        if leads && best.is_none_or(|(steps, _)| steps < found.len()) {
            best = Some((found.len(), part.start));
        }
    });
    best.map_or(0, |(_, start)| start)
}

/// The way to a part of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// Under a key.
    Key(String),
    /// At a place of a list, from 0.
    Index(usize),
}

impl PartialEq<Step> for Found {
    fn eq(&self, step: &Step) -> bool {
        match (self, step) {
            (Self::Key(a), Step::Key(b)) => a == b,
            (Self::Index(a), Step::Index(b)) => a == b,
            _ => false,
        }
    }
}

/// A value in a text.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// The byte at which its key begins, if it has one.
    pub key: Option<usize>,
    /// The byte at which it begins.
    pub start: usize,
    /// The byte behind it.
    pub end: usize,
    /// Whether its bracket is never closed.
    pub is_open: bool,
}

/// A bracket that was opened.
struct Open {
    part: Part,
    is_map: bool,
}

/// Visits every value of a text with the way there, those within others first, as far as it is JSON.
pub fn walk(text: &str, visit: &mut dyn FnMut(&[Found], Part)) {
    let bytes = text.as_bytes();
    let mut opened: Vec<Open> = vec![];
    let mut path: Vec<Found> = vec![];
    // Of the value that comes next, if it is a map's.
    let mut key = None;
    let mut at = 0;
    while let Some(byte) = bytes.get(at) {
        let start = at;
        match byte {
            byte if byte.is_ascii_whitespace() || b",:".contains(byte) => {
                at += 1;
                continue;
            }
            b'{' | b'[' => {
                at += 1;
                let part = Part { key: key.take(), start, end: text.len(), is_open: true };
                opened.push(Open { part, is_map: *byte == b'{' });
                if *byte == b'[' {
                    path.push(Found::Index(0));
                }
                continue;
            }
            b'}' | b']' => {
                at += 1;
                let Some(Open { mut part, is_map }) = opened.pop() else { return };
                // A key without a value, or the place behind the last.
                if !is_map || key.take().is_some() {
                    path.pop();
                }
                (part.end, part.is_open) = (at, false);
                visit(&path, part);
            }
            b'"' => {
                at += quoted(&text[at..]);
                if key.is_none() && opened.last().is_some_and(|open| open.is_map) {
                    let word = &text[start..at];
                    let word =
                        serde_json::from_str(word).unwrap_or_else(|_| word.trim_matches('"').to_owned());
                    path.push(Found::Key(word));
                    key = Some(start);
                    continue;
                }
                visit(&path, Part { key: key.take(), start, end: at, is_open: false });
            }
            _ => {
                let ends = |byte: &u8| byte.is_ascii_whitespace() || b",:{}[]\"".contains(byte);
                at += bytes[at..].iter().position(ends).unwrap_or(bytes.len() - at);
                visit(&path, Part { key: key.take(), start, end: at, is_open: false });
            }
        }
        // The next value of the list or map that this one is in.
        match opened.last() {
            Some(Open { is_map: true, .. }) => drop(path.pop()),
            Some(Open { is_map: false, .. }) => {
                if let Some(Found::Index(index)) = path.last_mut() {
                    *index += 1;
                }
            }
            None => {}
        }
    }
    while let Some(Open { part, is_map }) = opened.pop() {
        if !is_map || key.take().is_some() {
            path.pop();
        }
        visit(&path, part);
        if opened.last().is_some_and(|open| open.is_map) {
            path.pop();
        }
    }
}

/// How long the string is that a text begins with, its quotes included.
pub fn quoted(text: &str) -> usize {
    let mut is_escaped = false;
    let end = text.bytes().enumerate().skip(1).find(|(_, byte)| {
        let ends = *byte == b'"' && !is_escaped;
        is_escaped = *byte == b'\\' && !is_escaped;
        ends
    });
    end.map_or(text.len(), |(at, _)| at + 1)
}
