//! Files that were given to a page, as its Worker reads them: from where they lie, piece by piece, never all at once.

use std::cell::RefCell;
use std::ffi::OsString;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use js_sys::{Array, Uint8Array};
use lumivox_import::files::ByPath;
use lumivox_import::{Content, FileKind, Files, set_files};
use wasm_bindgen::JsCast;
use web_sys::{File, FileReaderSync};

thread_local! {
    static FILES: RefCell<ByPath<File>> = const { RefCell::new(ByPath::new()) };
}

/// Gives the importer files, as pairs of a path and a browser's `File`, in a Worker: they are read as they are asked for, by a reader
/// that pages have not. Those that were given before stay.
pub fn give_files(pairs: &Array) {
    // A Worker that is given more has it already.
    let _ = set_files(Box::new(Given));
    FILES.with(|files| {
        let mut files = files.borrow_mut();
        for pair in pairs.iter() {
            let pair = Array::from(&pair);
            if let (Some(path), Ok(file)) = (pair.get(0).as_string(), pair.get(1).dyn_into::<File>()) {
                files.put(Path::new(&path), file);
            }
        }
    });
}

fn length(file: &File) -> u64 {
    file.size() as u64
}

/// What was given.
struct Given;

impl Files for Given {
    fn kind(&self, path: &Path) -> io::Result<FileKind> {
        FILES.with(|files| files.borrow().kind(path, length))
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn Content>> {
        let length = FILES.with(|files| files.borrow().get(path).map(length))?;
        let path = path.to_owned();
        Ok(Box::new(Reader { path, length, position: 0, start: 0, piece: vec![], next: LEAST }))
    }

    fn names(&self, folder: &Path) -> io::Result<Vec<OsString>> {
        FILES.with(|files| files.borrow().names(folder))
    }
}

/// Bytes of the first piece of a file: most headers are shorter.
const LEAST: u64 = 1 << 16;
/// Of the longest.
const MOST: u64 = 1 << 22;

/// A file that is read in pieces, each longer than the one before while it is read on.
struct Reader {
    path: PathBuf,
    length: u64,
    position: u64,
    start: u64,
    piece: Vec<u8>,
    next: u64,
}

impl Reader {
    fn fetch(&mut self) -> io::Result<()> {
        let is_next = self.position == self.start + self.piece.len() as u64;
        self.next = if is_next { (self.next * 2).min(MOST) } else { LEAST };
        let end = (self.position + self.next).min(self.length);
        let unread = || io::Error::other("the browser does not read it; it may have been moved or changed");
        let bytes = FILES.with(|files| {
            let files = files.borrow();
            let file = files.get(&self.path).ok()?;
            let part = file.slice_with_f64_and_f64(self.position as f64, end as f64).ok()?;
            FileReaderSync::new().ok()?.read_as_array_buffer(&part).ok()
        });
        let bytes = bytes.ok_or_else(unread)?;
        self.piece = Uint8Array::new(&bytes).to_vec();
        self.start = self.position;
        if self.piece.is_empty() { Err(unread()) } else { Ok(()) }
    }
}

impl Read for Reader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.position >= self.length || buffer.is_empty() {
            return Ok(0);
        }
        let is_there = (self.start..self.start + self.piece.len() as u64).contains(&self.position);
        if !is_there {
            self.fetch()?;
        }
        let there = &self.piece[(self.position - self.start) as usize..];
        let read = there.len().min(buffer.len());
        buffer[..read].copy_from_slice(&there[..read]);
        self.position += read as u64;
        Ok(read)
    }
}

impl Seek for Reader {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
            SeekFrom::Current(by) => self.position.checked_add_signed(by),
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}
