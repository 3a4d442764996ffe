//! A scene's file, read.

use std::{
    fs,
    io::{self, Read},
    path::{Path, PathBuf},
};

use lumivox_core::document::{DocumentError, Written};
use lumivox_import::files::{self, File};

/// Why a file could not be read as a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// It is not there, or must not be read.
    #[error("cannot read {}: {error}", .file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system says.
        #[source]
        error: io::Error,
    },
    /// A pipe may never end, nor a device; a folder is no text.
    #[error("cannot read {}: it is not a plain file; name a scene's file", .0.display())]
    NoFile(PathBuf),
    /// A scan, perhaps.
    #[error("{} is no scene of Lumivox's: those are text that begins with {{\"lumivox_scene\": 1", .0.display())]
    NoScene(PathBuf),
    /// What it says is wrong.
    #[error("{}, {error}", .file.display())]
    Wrong {
        /// The file.
        file: PathBuf,
        /// What, and where.
        #[source]
        error: DocumentError,
    },
}

/// Reads a scene. Paths in it are seen from where it stands: of a link, from the folder of the file that it leads to.
///
/// # Errors
/// [`ReadError`] names the file, and the line where there is one.
pub fn read(file: &Path) -> Result<Written, ReadError> {
    /// Enough to tell a scan, which may be large.
    const BEGINNING: u64 = 4096;
    let unreadable = |error| ReadError::Io { file: file.to_owned(), error };
    if !files::metadata(file).map_err(unreadable)?.is_file() {
        return Err(ReadError::NoFile(file.to_owned()));
    }
    let mut opened = File::open(file).map_err(unreadable)?;
    let mut bytes = vec![];
    opened.by_ref().take(BEGINNING).read_to_end(&mut bytes).map_err(unreadable)?;
    let beginning = String::from_utf8_lossy(&bytes);
    let beginning = beginning.trim_start_matches('\u{feff}').trim_start();
    if !beginning.is_empty() && !beginning.starts_with('{') {
        return Err(ReadError::NoScene(file.to_owned()));
    }
    opened.read_to_end(&mut bytes).map_err(unreadable)?;
    let text = String::from_utf8(bytes).map_err(|_| ReadError::NoScene(file.to_owned()))?;
    let written =
        Written::parse(file, text).map_err(|error| ReadError::Wrong { file: file.to_owned(), error })?;
    let folder = followed(file).parent().unwrap_or(Path::new("")).to_owned();
    Ok(written.seen_from(folder))
}

/// The file that a link leads to, and any other file itself.
pub fn followed(file: &Path) -> PathBuf {
    /// As systems follow them.
    const MOST_LINKS: usize = 40;
    let mut file = file.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&file) else { break };
        file = file.parent().unwrap_or(Path::new("")).join(next);
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_scene_is_not_read_as_one() {
        let folder = tempfile::tempdir().unwrap();
        let said = |content: &[u8]| {
            let file = folder.path().join("a.lumivox");
            fs::write(&file, content).unwrap();
            read(&file).map(|_| ()).map_err(|error| error.to_string())
        };
        assert!(said(b"\x1f\x8b\x08scan").unwrap_err().contains("is no scene of Lumivox's"));
        assert!(said(b"{\"lumivox_scene\": 1, \"$schema\": \"\xff\"}").unwrap_err().contains("is no scene"));
        assert!(said(b"").unwrap_err().contains("a.lumivox, line 1, column 1: the file is empty"));
        assert_eq!(said("\u{feff}{\"lumivox_scene\": 1}".as_bytes()), Ok(()));
        assert!(matches!(read(folder.path()), Err(ReadError::NoFile(_))));
        assert!(matches!(read(&folder.path().join("none")), Err(ReadError::Io { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stands_for_the_file_to_which_it_leads() {
        use std::os::unix::fs::symlink;
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        fs::create_dir_all(at("scenes")).unwrap();
        fs::create_dir_all(at("links")).unwrap();
        fs::write(at("scenes/a.lumivox"), "{\"lumivox_scene\": 1}").unwrap();
        symlink("../scenes/a.lumivox", at("links/first")).unwrap();
        symlink(at("links/first"), at("links/second")).unwrap();
        for name in ["first", "second"] {
            let written = read(&at("links").join(name)).unwrap();
            assert_eq!(
                written.folder().canonicalize().unwrap(),
                at("scenes").canonicalize().unwrap(),
                "{name}"
            );
            assert!(written.place(&[]).contains(name), "it is called as it was named");
        }
        symlink("third", at("links/third")).unwrap();
        assert!(matches!(read(&at("links/third")), Err(ReadError::Io { .. })), "it leads nowhere");
        assert_eq!(read(&at("scenes/a.lumivox")).unwrap().folder(), at("scenes"));
    }
}
