//! Retrieval (WADO-RS, PS3.18, 10.4): the images of a series become files.

use std::fs;
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use lumivox_core::{CancelToken, Progress, WorkStage};
use tempfile::TempDir;
use ureq::http::header::CONTENT_TYPE;

use crate::error::Error;
use crate::multipart::{Parts, boundary, media_type};
use crate::query::{SeriesEntry, Uid};
use crate::server::{PATIENCE, Server};

const DICOM: &str = "application/dicom";
/// How what is not whole yet ends.
const PART: &str = ".part";
/// What nobody wrote to for so long is left over of a program that was killed.
const LEFT_OVER: Duration = Duration::from_secs(24 * 3600);

impl Server {
    /// Fetches a series into a folder below `into`, whose name is the series' identifier, and returns that folder: whole, in place of
    /// one that was there, or not at all. What is made is its owner's alone to read.
    ///
    /// # Errors
    /// [`Error`].
    pub fn fetch(
        &self,
        study: &Uid,
        series: &SeriesEntry,
        into: &Path,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<PathBuf, Error> {
        let disk = |error| Error::Disk { path: into.to_owned(), error };
        make_folder(into).map_err(disk)?;
        sweep(into);
        // One of its own for each: another that was given up may still write.
        let aside = aside(into, &series.uid).map_err(disk)?;
        let count = self.fetch_to(study, series, aside.path(), progress, cancel)?;
        if fs::read_dir(aside.path()).map_err(disk)?.count() as u64 != count {
            return Err(disk(io::Error::other("files that came are gone")));
        }
        let folder = into.join(series.uid.as_str());
        put(aside, into, &folder).map_err(|error| Error::Disk { path: folder.clone(), error })?;
        Ok(folder)
    }

    /// Fetches into that folder; how many images came.
    fn fetch_to(
        &self,
        study: &Uid,
        series: &SeriesEntry,
        folder: &Path,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<u64, Error> {
        // As they are stored: nothing is decoded and coded again, and nothing lost. Not every server knows that.
        const KINDS: [&str; 2] = [
            r#"multipart/related; type="application/dicom"; transfer-syntax=*"#,
            r#"multipart/related; type="application/dicom""#,
        ];
        let nothing = || Error::Nothing { server: self.address().to_owned() };
        let total = series.images.unwrap_or(0);
        progress.report(WorkStage::Receiving, 0, total);
        let answer = match self.get(&format!("studies/{study}/series/{}", series.uid), &[], &KINDS, PATIENCE)
        {
            // The archive answered before: what is missing is the series.
            Err(Error::NoArchive { .. }) => return Err(nothing()),
            answer => answer?,
        };
        let status = answer.status().as_u16();
        if status == 204 {
            return Err(nothing());
        }
        let kind = answer.headers().get(CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
        let (kind, mut reader) =
            (kind.to_owned(), Watched { source: answer.into_body().into_reader(), cancel });
        let mut count = 0;
        let mut write = |copy: &mut dyn FnMut(&mut dyn Write) -> io::Result<u64>| -> Result<(), Error> {
            count += 1;
            let path = folder.join(format!("{count:06}.dcm"));
            let disk = |error| Error::Disk { path: path.clone(), error };
            let file = fs::File::create_new(&path).map_err(disk)?;
            let mut file = Kept { file: BufWriter::with_capacity(1 << 20, file), failed: None };
            let copied = copy(&mut file);
            if let Some(error) = file.failed.take().or_else(|| file.file.flush().err()) {
                return Err(disk(error));
            }
            self.came(copied, cancel)?;
            progress.report(WorkStage::Receiving, count, total.max(count));
            Ok(cancel.check()?)
        };
        match (media_type(&kind).as_str(), boundary(&kind)) {
            ("multipart/related", Some(boundary)) => {
                let mut parts = Parts::new(reader, &boundary);
                while let Some(kind) = self.came(parts.next(), cancel)? {
                    // What is no image is passed over: words of the server's, say, about one that it cannot give.
                    if kind.is_empty() || kind == DICOM {
                        write(&mut |file| parts.copy(file))?;
                    }
                }
            }
            // One image may come by itself.
            (DICOM, _) => write(&mut |mut file| io::copy(&mut reader, &mut file))?,
            _ => {
                let why = format!("'{kind}' came instead of images");
                return Err(Error::NoArchive { server: self.address().to_owned(), why });
            }
        }
        let incomplete = |of| Error::Incomplete { server: self.address().to_owned(), got: count, of };
        match count {
            0 => Err(nothing()),
            // A scan that lacks slices is no scan.
            _ if count < total => Err(incomplete(total.to_string())),
            _ if matches!(status, 202 | 206) => Err(incomplete("more".to_owned())),
            _ => Ok(count),
        }
    }

    /// What a person hears of an answer that breaks off.
    fn came<T>(&self, result: io::Result<T>, cancel: &CancelToken) -> Result<T, Error> {
        result.map_err(|error| match cancel.check() {
            Err(cancelled) => cancelled.into(),
            Ok(()) if error.kind() == ErrorKind::UnexpectedEof => self.cut("the images have no end"),
            Ok(()) => self.cut(&error.to_string()),
        })
    }
}

/// What is read until it is cancelled.
struct Watched<'a, R> {
    source: R,
    cancel: &'a CancelToken,
}

impl<R: Read> Read for Watched<'_, R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.cancel.is_cancelled() {
            return Err(ErrorKind::ConnectionAborted.into());
        }
        self.source.read(into)
    }
}

/// Tells errors of the disk from those of the network.
struct Kept {
    file: BufWriter<fs::File>,
    failed: Option<io::Error>,
}

impl Write for Kept {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes).map_err(|error| {
            let kind = error.kind();
            self.failed = Some(error);
            kind.into()
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Makes a folder that nobody else looks into, with those that lead to it.
fn make_folder(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::DirBuilderExt;
        builder.mode(0o700);
    }
    builder.create(folder)
}

/// A folder for what is not whole yet, which goes with what this returns.
fn aside(into: &Path, series: &Uid) -> io::Result<TempDir> {
    let prefix = format!("{series}.");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(PART);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o700));
    }
    builder.tempdir_in(into)
}

/// Takes away what programs left that were killed. What is in the way stays.
fn sweep(into: &Path) {
    for entry in fs::read_dir(into).into_iter().flatten().flatten() {
        let is_part = entry.file_name().to_str().is_some_and(|name| name.ends_with(PART));
        let written = entry.metadata().and_then(|entry| entry.modified()).ok();
        let is_old = written.and_then(|written| written.elapsed().ok()).is_some_and(|age| age > LEFT_OVER);
        if is_part && is_old {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Puts what is whole where it belongs. What was there before goes, once it is.
fn put(new: TempDir, into: &Path, folder: &Path) -> io::Result<()> {
    let old = tempfile::Builder::new().prefix("old.").suffix(PART).tempdir_in(into)?;
    let before = old.path().join("before");
    let had = match fs::rename(folder, &before) {
        Ok(()) => true,
        Err(error) if error.kind() == ErrorKind::NotFound => false,
        Err(error) => return Err(error),
    };
    let moved = fs::rename(new.path(), folder);
    if moved.is_ok() {
        // It is no longer where it would be deleted.
        let _ = new.keep();
    } else if had && fs::rename(&before, folder).is_err() {
        // The only copy.
        let _ = old.keep();
    }
    moved
}
