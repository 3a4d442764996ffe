//! Parts of a `multipart/related` answer (RFC 2046, 5.1; RFC 2387), as they come.

use std::io::{self, ErrorKind, Read, Write};

use memchr::memmem::Finder;

/// What is read at once.
const CHUNK: usize = 64 << 10;
/// Headers of a part are no longer than that.
const MOST_HEADER: usize = 16 << 10;

/// The parts of an answer, one after the other.
pub struct Parts<R> {
    source: R,
    /// What was read, from `begin` on what was not taken yet.
    buffer: Vec<u8>,
    begin: usize,
    delimiter: Finder<'static>,
    /// Whether a delimiter was taken, and what follows it was not.
    is_between: bool,
}

/// The boundary that a content type names.
pub fn boundary(content_type: &str) -> Option<String> {
    // A boundary in quotes may hold semicolons.
    let mut rest = content_type.split_once(';')?.1;
    loop {
        rest = rest.trim_start_matches([' ', '\t', ';']);
        let (name, value) = rest.split_once('=')?;
        let (value, after) = match value.trim_start().strip_prefix('"') {
            Some(quoted) => quoted.split_once('"')?,
            None => value.split_at(value.find(';').unwrap_or(value.len())),
        };
        if name.trim().eq_ignore_ascii_case("boundary") {
            let value = value.trim();
            // The standard has 70; a few more do no harm.
            return (1..=200).contains(&value.len()).then(|| value.to_owned());
        }
        rest = after;
    }
}

/// The media type that a content type begins with.
pub fn media_type(content_type: &str) -> String {
    content_type.split(';').next().unwrap_or_default().trim().to_ascii_lowercase()
}

/// That of the headers of a part.
fn kind_of(headers: &[u8]) -> String {
    let text = String::from_utf8_lossy(headers);
    let of_line = |line: &str| {
        let (name, value) = line.split_once(':')?;
        name.trim().eq_ignore_ascii_case("content-type").then(|| media_type(value))
    };
    text.lines().find_map(of_line).unwrap_or_default()
}

impl<R: Read> Parts<R> {
    /// Those of an answer with that boundary.
    pub fn new(source: R, boundary: &str) -> Self {
        let delimiter = Finder::new(&format!("\r\n--{boundary}")).into_owned();
        // The first boundary may be the first line, which no other ends before.
        Self { source, buffer: b"\r\n".to_vec(), begin: 0, delimiter, is_between: false }
    }

    /// Goes to the next part: its media type in small letters, empty where it names none. `None` where there is no part.
    ///
    /// # Errors
    /// [`ErrorKind::UnexpectedEof`] where the answer ends before it says so, and the source's own.
    pub fn next(&mut self) -> io::Result<Option<String>> {
        self.copy(&mut io::sink())?;
        if self.rest().starts_with(b"--") {
            return Ok(None);
        }
        self.is_between = false;
        // The rest of the boundary's line, and headers, to an empty line.
        let mut seen = 0;
        loop {
            let rest = self.rest();
            let from = seen.max(3) - 3;
            if let Some(end) = memchr::memmem::find(&rest[from..], b"\r\n\r\n") {
                let kind = kind_of(&rest[..from + end]);
                self.begin += from + end + 4;
                return Ok(Some(kind));
            }
            seen = rest.len();
            if seen > MOST_HEADER {
                return Err(io::Error::new(ErrorKind::InvalidData, "a part has no end of its headers"));
            }
            self.fill(seen + 1)?;
        }
    }

    /// Writes what is left of this part; bytes that were written.
    ///
    /// # Errors
    /// [`ErrorKind::UnexpectedEof`] where the answer ends within it, and those of source and sink.
    pub fn copy(&mut self, sink: &mut dyn Write) -> io::Result<u64> {
        let mut written = 0;
        let mut write = |bytes: &[u8]| {
            written += bytes.len() as u64;
            sink.write_all(bytes)
        };
        while !self.is_between {
            let found = self.delimiter.find(self.rest());
            // What may be a delimiter's beginning stays.
            let plain =
                found.unwrap_or((self.rest().len() + 1).saturating_sub(self.delimiter.needle().len()));
            write(&self.buffer[self.begin..self.begin + plain])?;
            self.begin += plain;
            let Some(_) = found else {
                self.fill(self.rest().len() + 1)?;
                continue;
            };
            let length = self.delimiter.needle().len();
            self.fill(length + 2)?;
            // A longer word that begins like it is none.
            let after = &self.rest()[length..];
            if after.starts_with(b"--")
                || after.starts_with(b"\r")
                || after.starts_with(b" ")
                || after.starts_with(b"\t")
            {
                self.is_between = true;
            } else {
                write(&self.buffer[self.begin..self.begin + length])?;
            }
            self.begin += length;
        }
        Ok(written)
    }

    fn rest(&self) -> &[u8] {
        &self.buffer[self.begin..]
    }

    /// Reads until so many bytes are there.
    fn fill(&mut self, wanted: usize) -> io::Result<()> {
        self.buffer.drain(..self.begin);
        self.begin = 0;
        while self.buffer.len() < wanted {
            let old = self.buffer.len();
            self.buffer.resize(old + CHUNK, 0);
            let read = loop {
                match self.source.read(&mut self.buffer[old..]) {
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    read => break read,
                }
            };
            self.buffer.truncate(old + *read.as_ref().unwrap_or(&0));
            if read? == 0 {
                return Err(ErrorKind::UnexpectedEof.into());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives so many bytes at once.
    struct Trickle<'a>(&'a [u8], usize);

    impl Read for Trickle<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let count = self.1.min(self.0.len()).min(into.len());
            into[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }

    fn all(text: &[u8], at_once: usize) -> io::Result<Vec<Vec<u8>>> {
        let mut parts = Parts::new(Trickle(text, at_once), "b-1");
        let mut found = vec![];
        while parts.next()?.is_some() {
            let mut part = vec![];
            let written = parts.copy(&mut part)?;
            assert_eq!(written as usize, part.len());
            found.push(part);
        }
        Ok(found)
    }

    const ANSWER: &[u8] = b"preamble\r\n--b-1\r\nContent-Type: application/dicom\r\nContent-Length: 5\r\n\r\none\r\n\r\n--b-1 \r\nX: y\r\n\r\n\r\n--b-\r\n--b\r\n\r\n--b-1\r\n\r\n\r\n--b-1--\r\nepilogue";

    #[test]
    fn parts_are_what_lies_between_boundaries_however_they_come() {
        for at_once in [1, 2, 3, 5, 8, 13, 1000] {
            let parts = all(ANSWER, at_once).unwrap();
            assert_eq!(
                parts,
                [b"one\r\n".to_vec(), b"\r\n--b-\r\n--b\r\n".to_vec(), vec![]],
                "{at_once} at once"
            );
        }
        assert_eq!(all(b"--b-1--", 3).unwrap(), Vec::<Vec<u8>>::new());
    }

    #[test]
    fn an_answer_that_is_cut_anywhere_is_an_error() {
        let end = ANSWER.len() - b"--\r\nepilogue".len();
        for length in 0..end {
            assert_eq!(
                all(&ANSWER[..length], 7).unwrap_err().kind(),
                ErrorKind::UnexpectedEof,
                "{length} bytes"
            );
        }
    }

    #[test]
    fn a_boundary_that_begins_another_word_is_no_boundary() {
        let text = b"--b-1\r\n\r\none\r\n--b-12\r\ntwo\r\n--b-1-2\r\n--b-1--";
        assert_eq!(all(text, 3).unwrap(), [b"one\r\n--b-12\r\ntwo\r\n--b-1-2".to_vec()]);
    }

    #[test]
    fn parts_say_what_they_are() {
        let text = b"--b-1\r\nContent-Length: 1\r\ncontent-TYPE: Application/DICOM; x=y\r\n\r\n1\r\n--b-1\r\n\r\n\r\n--b-1--";
        let mut parts = Parts::new(&text[..], "b-1");
        assert_eq!(parts.next().unwrap().as_deref(), Some("application/dicom"));
        assert_eq!(parts.next().unwrap().as_deref(), Some(""));
        assert_eq!(parts.next().unwrap(), None);
    }

    #[test]
    fn headers_without_end_are_refused() {
        let text = [b"--b-1\r\n".to_vec(), vec![b'x'; 1 << 20]].concat();
        assert_eq!(all(&text, 4096).unwrap_err().kind(), ErrorKind::InvalidData);
    }

    #[test]
    fn boundaries_are_found_in_every_way_of_writing_them() {
        let of = |text: &str| boundary(text);
        assert_eq!(of("multipart/related; boundary=abc").as_deref(), Some("abc"));
        assert_eq!(
            of(r#"multipart/related; type="application/dicom"; boundary="a;b=c" ; start=x"#).as_deref(),
            Some("a;b=c")
        );
        assert_eq!(of("multipart/related;BOUNDARY=abc;type=x").as_deref(), Some("abc"));
        for none in ["application/dicom", "multipart/related; boundary=", "multipart/related; type=\"x", ""] {
            assert_eq!(of(none), None, "{none}");
        }
    }
}
