//! Where files are read: by default where the system has them. A page in a browser has no such system, and a program may have
//! a scan in memory: what they have, [`Files`], takes the system's place with [`set_files`].

use std::{
    collections::BTreeMap,
    ffi::OsString,
    fs,
    io::{self, Cursor, Read, Seek, SeekFrom},
    ops::Bound,
    path::{Component, Path, PathBuf},
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

/// What is at a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileKind {
    /// A file of so many bytes.
    File(u64),
    /// A folder.
    Folder,
}

/// The bytes of an open file.
pub trait Content: Read + Seek + Send {}

impl<T: Read + Seek + Send> Content for T {}

/// Files that are not the system's. Paths are compared by their parts.
pub trait Files: Send + Sync {
    /// What is there.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] where nothing is.
    fn kind(&self, path: &Path) -> io::Result<FileKind>;

    /// Opens a file at its first byte.
    ///
    /// # Errors
    /// Where there is none.
    fn open(&self, path: &Path) -> io::Result<Box<dyn Content>>;

    /// The names of what lies in a folder, not of what lies in folders in it.
    ///
    /// # Errors
    /// Where there is none.
    fn names(&self, folder: &Path) -> io::Result<Vec<OsString>>;
}

static FILES: OnceLock<Box<dyn Files>> = OnceLock::new();

/// Gives the files that this process reads from now on, in place of the system's. Nothing is ever written there.
///
/// # Errors
/// The files, where some were given before.
pub fn set_files(files: Box<dyn Files>) -> Result<(), Box<dyn Files>> {
    FILES.set(files)
}

/// What lies at paths, in order: what [`Files`] that are not the system's look up. Paths are compared without detours.
#[derive(Clone, Debug)]
pub struct ByPath<T>(BTreeMap<PathBuf, T>);

impl<T> ByPath<T> {
    /// Nothing yet.
    pub const fn new() -> Self {
        Self(BTreeMap::new())
    }

    /// Puts a file there; one of that path goes.
    pub fn put(&mut self, path: &Path, file: T) {
        self.0.insert(plain(path), file);
    }

    /// All of them go.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The file that is there.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] where none is.
    pub fn get(&self, path: &Path) -> io::Result<&T> {
        self.0.get(&plain(path)).ok_or(io::ErrorKind::NotFound.into())
    }

    /// What is there; `length` says of how many bytes a file is.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] where nothing is.
    pub fn kind(&self, path: &Path, length: impl FnOnce(&T) -> u64) -> io::Result<FileKind> {
        let path = plain(path);
        match self.0.get(&path) {
            Some(file) => Ok(FileKind::File(length(file))),
            None if self.within(&path).next().is_some() => Ok(FileKind::Folder),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    }

    /// The names of what lies in a folder, not of what lies in folders in it.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] where there is none.
    pub fn names(&self, folder: &Path) -> io::Result<Vec<OsString>> {
        let folder = plain(folder);
        let below =
            |file: &Path| Some(file.strip_prefix(&folder).ok()?.components().next()?.as_os_str().into());
        let mut names: Vec<OsString> = self.within(&folder).filter_map(below).collect();
        names.dedup();
        if names.is_empty() { Err(io::ErrorKind::NotFound.into()) } else { Ok(names) }
    }

    /// The paths that begin with this one: in order they are one after the other.
    fn within<'a>(&'a self, path: &'a Path) -> impl Iterator<Item = &'a Path> {
        let from = (Bound::Included(path), Bound::Unbounded);
        self.0
            .range::<Path, _>(from)
            .map(|(file, _)| file.as_path())
            .take_while(move |file| file.starts_with(path))
    }
}

impl<T> Default for ByPath<T> {
    fn default() -> Self {
        Self::new()
    }
}

/// Files in memory.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles(Arc<Mutex<ByPath<Arc<[u8]>>>>);

impl MemoryFiles {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Puts a file there; one of that name goes.
    pub fn put(&self, path: impl AsRef<Path>, bytes: impl Into<Arc<[u8]>>) {
        self.locked(|files| files.put(path.as_ref(), bytes.into()));
    }

    /// All of them go.
    pub fn clear(&self) {
        self.locked(ByPath::clear);
    }

    fn locked<T>(&self, work: impl FnOnce(&mut ByPath<Arc<[u8]>>) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Files for MemoryFiles {
    fn kind(&self, path: &Path) -> io::Result<FileKind> {
        self.locked(|files| files.kind(path, |bytes| bytes.len() as u64))
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn Content>> {
        self.locked(|files| Ok(Box::new(Cursor::new(files.get(path)?.clone())) as _))
    }

    fn names(&self, folder: &Path) -> io::Result<Vec<OsString>> {
        self.locked(|files| files.names(folder))
    }
}

/// A path without detours.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(plain.components().next_back(), Some(Component::Normal(_))) => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}

/// An open file.
pub struct File(Opened);

enum Opened {
    System(fs::File),
    Lent(Box<dyn Content>, u64),
}

impl File {
    /// Opens a file at its first byte.
    ///
    /// # Errors
    /// Where there is none, or it cannot be read.
    pub fn open(path: impl AsRef<Path>) -> io::Result<Self> {
        let path = path.as_ref();
        Ok(Self(match FILES.get() {
            None => Opened::System(fs::File::open(path)?),
            Some(files) => match files.kind(path)? {
                FileKind::File(length) => Opened::Lent(files.open(path)?, length),
                FileKind::Folder => return Err(io::ErrorKind::IsADirectory.into()),
            },
        }))
    }

    /// Its size in bytes.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn length(&self) -> io::Result<u64> {
        match &self.0 {
            Opened::System(file) => file.metadata().map(|metadata| metadata.len()),
            Opened::Lent(_, length) => Ok(*length),
        }
    }
}

impl Read for File {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match &mut self.0 {
            Opened::System(file) => file.read(buffer),
            Opened::Lent(content, _) => content.read(buffer),
        }
    }

    fn read_to_end(&mut self, buffer: &mut Vec<u8>) -> io::Result<usize> {
        match &mut self.0 {
            // It knows how much there is.
            Opened::System(file) => file.read_to_end(buffer),
            Opened::Lent(content, _) => content.read_to_end(buffer),
        }
    }
}

impl Seek for File {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match &mut self.0 {
            Opened::System(file) => file.seek(to),
            Opened::Lent(content, _) => content.seek(to),
        }
    }
}

/// What is at a path, links followed. Pipes and devices are neither file nor folder.
#[derive(Clone, Copy, Debug)]
pub struct Metadata {
    is_dir: bool,
    is_file: bool,
    length: u64,
}

impl Metadata {
    /// Whether it is a folder.
    pub fn is_dir(self) -> bool {
        self.is_dir
    }

    /// Whether it is a file.
    pub fn is_file(self) -> bool {
        self.is_file
    }

    /// A file's size in bytes.
    pub fn length(self) -> u64 {
        self.length
    }
}

/// What is at a path.
///
/// # Errors
/// Where nothing is, or the system does not say.
pub fn metadata(path: impl AsRef<Path>) -> io::Result<Metadata> {
    let path = path.as_ref();
    Ok(match FILES.get() {
        None => {
            let found = fs::metadata(path)?;
            Metadata { is_dir: found.is_dir(), is_file: found.is_file(), length: found.len() }
        }
        Some(files) => match files.kind(path)? {
            FileKind::File(length) => Metadata { is_dir: false, is_file: true, length },
            FileKind::Folder => Metadata { is_dir: true, is_file: false, length: 0 },
        },
    })
}

/// Whether a folder is there.
pub fn is_dir(path: impl AsRef<Path>) -> bool {
    metadata(path).is_ok_and(Metadata::is_dir)
}

/// Whether a file is there.
pub fn is_file(path: impl AsRef<Path>) -> bool {
    metadata(path).is_ok_and(Metadata::is_file)
}

/// The path of what is there, links followed and without detours.
///
/// # Errors
/// Where nothing is, or the system does not say.
pub fn canonicalize(path: impl AsRef<Path>) -> io::Result<PathBuf> {
    let path = path.as_ref();
    match FILES.get() {
        None => fs::canonicalize(path),
        Some(files) => files.kind(path).map(|_| plain(path)),
    }
}

/// A path wherever the program is.
///
/// # Errors
/// When the system does not say where that is.
pub fn absolute(path: impl AsRef<Path>) -> io::Result<PathBuf> {
    match FILES.get() {
        None => std::path::absolute(path),
        Some(_) => Ok(plain(path.as_ref())),
    }
}

/// The bytes of a file.
///
/// # Errors
/// Where there is none, or it cannot be read.
pub(crate) fn read(path: impl AsRef<Path>) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let mut bytes = vec![];
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Something in a folder.
pub(crate) struct Entry {
    pub(crate) path: PathBuf,
    pub(crate) name: OsString,
    /// Itself: a link is neither.
    pub(crate) is_dir: bool,
    pub(crate) is_file: bool,
    pub(crate) is_link: bool,
}

/// What lies in a folder.
///
/// # Errors
/// Where there is none, or it cannot be read; of what is in it each by itself.
pub(crate) fn read_dir(folder: &Path) -> io::Result<Box<dyn Iterator<Item = io::Result<Entry>>>> {
    let Some(files) = FILES.get() else {
        return Ok(Box::new(fs::read_dir(folder)?.map(|entry| {
            let entry = entry?;
            let kind = entry.file_type()?;
            let (is_dir, is_file, is_link) = (kind.is_dir(), kind.is_file(), kind.is_symlink());
            Ok(Entry { path: entry.path(), name: entry.file_name(), is_dir, is_file, is_link })
        })));
    };
    let folder = folder.to_owned();
    let entries = files.names(&folder)?.into_iter().map(move |name| {
        let path = folder.join(&name);
        let is_dir = files.kind(&path)? == FileKind::Folder;
        Ok(Entry { path, name, is_dir, is_file: !is_dir, is_link: false })
    });
    Ok(Box::new(entries))
}
