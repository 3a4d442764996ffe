//! Writing: text to a terminal that may have gone away, and pictures that are whole or not there.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
};

use lumivox_core::CancelToken;
use lumivox_renderer::display::put_on;

use crate::exit::{self, Failure};
use crate::progress::without_controls;

/// Whether anything was printed: of objects for programs there is one.
static HAS_PRINTED: AtomicBool = AtomicBool::new(false);

/// See [`HAS_PRINTED`].
pub fn has_printed() -> bool {
    HAS_PRINTED.load(Ordering::Relaxed)
}

/// Writes to stdout. Whoever reads may stop early (`lumivox presets | head -1`): that is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    HAS_PRINTED.store(true, Ordering::Relaxed);
    match io::stdout().lock().write_all(without_controls(text).as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::other(format!("cannot write to stdout: {error}")))
        }
        _ => Ok(()),
    }
}

/// A picture: rows from the top, red, green, blue and straight alpha, 8 bits each.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// `width * height * 4` bytes.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// Puts an opaque sRGB colour behind the picture. Light adds up, so the blend is linear.
    pub fn put_on(&mut self, color: [u8; 3]) {
        put_on(&mut self.rgba, color);
    }
}

/// A PNG that is going to be written.
pub struct PngOutput {
    path: PathBuf,
    /// What it is called while it is written.
    partial: PathBuf,
}

impl PngOutput {
    /// Checks, before any work is done, that `path` can be written, and is none of the files that will be read.
    pub fn prepare<'a>(path: &Path, inputs: impl IntoIterator<Item = &'a Path>) -> Result<Self, Failure> {
        let path = writable(path, &["png"], inputs)?;
        Ok(Self { partial: partial(&path), path })
    }

    /// For a picture of which parts are missing: where there is an earlier one, `NAME.partial.png` beside it.
    #[must_use]
    pub fn sparing_the_earlier(self) -> Self {
        let path = if self.path.exists() { self.path.with_extension("partial.png") } else { self.path };
        Self { path, ..self }
    }

    /// The file that [`PngOutput::write`] makes.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the picture under another name, then renames it: nobody ever sees half of one. If that fails, the
    /// picture is kept in the system's folder for temporary files, and the failure says where.
    pub fn write(&self, picture: &Picture) -> Result<(), Failure> {
        exit::remove_when_killed(Some(self.partial.clone()));
        let result = write_png(&self.partial, picture).and_then(|()| fs::rename(&self.partial, &self.path));
        if result.is_err() {
            let _ = fs::remove_file(&self.partial);
        }
        exit::remove_when_killed(None);
        let Err(error) = result else { return Ok(()) };
        let problem = format!("cannot write {}: {error}", self.path.display());
        let Ok((rescue, file)) = private() else { return Err(Failure::other(problem)) };
        match write_png_to(file, picture) {
            Ok(()) => Err(Failure::other(format!("{problem}\nThe picture is kept in {}", rescue.display()))),
            Err(_) => {
                let _ = fs::remove_file(&rescue);
                Err(Failure::other(problem))
            }
        }
    }
}

/// What a file is called while it is written.
fn partial(path: &Path) -> PathBuf {
    folder_of(path).join(format!(".lumivox-{}.partial", std::process::id()))
}

/// Checks, before any work is done, that a file of one of those extensions can be written, and is none of those that will be read; the
/// file that it really is.
pub fn writable<'a>(
    path: &Path,
    extensions: &[&str],
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<PathBuf, Failure> {
    let shown = path.display();
    let is_one = |extension: &&str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension));
    if !extensions.iter().any(is_one) {
        let extensions = extensions.join(" or .");
        return Err(Failure::usage(format!("{shown}: the output must end in .{extensions}")));
    }
    check_is_none_of(path, inputs)?;
    // A link is followed: what it points at is replaced, not the link.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let folder = folder_of(&path);
    if !folder.is_dir() {
        return Err(Failure::other(format!(
            "cannot write {shown}: there is no folder {}; make it first",
            folder.display()
        )));
    }
    if path.exists() && !path.is_file() {
        return Err(Failure::other(format!("cannot write {shown}: it exists and is not a file")));
    }
    if fs::metadata(&path).is_ok_and(|file| file.permissions().readonly()) {
        return Err(Failure::other(format!("cannot write {shown}: it is read-only")));
    }
    let partial = partial(&path);
    let probe = File::create(&partial);
    let _ = fs::remove_file(&partial);
    probe.map_err(|error| Failure::other(format!("cannot write {shown}: {error}")))?;
    Ok(path)
}

/// Refuses to write a file that will be read.
pub fn check_is_none_of<'a>(path: &Path, inputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
    let Ok(real) = fs::canonicalize(path) else { return Ok(()) };
    if inputs.into_iter().any(|input| fs::canonicalize(input).is_ok_and(|input| input == real)) {
        return Err(Failure::usage(format!("{}: the output is one of the inputs", path.display())));
    }
    Ok(())
}

/// Refuses to write a file that would be read as a slice of a scan the next time, or hinder that.
pub fn check_is_no_slice(path: &Path, scan: &[PathBuf]) -> Result<(), Failure> {
    if lumivox_import::would_be_a_slice(path, scan, &CancelToken::new()) {
        let shown = path.display();
        return Err(Failure::usage(format!(
            "{shown}: the output would lie among the slices of a scan, and be taken for one of them the next time; write it to \
             another folder"
        )));
    }
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

fn write_png(path: &Path, picture: &Picture) -> io::Result<()> {
    write_png_to(File::create(path)?, picture)
}

/// A new file in the system's folder for temporary ones that nobody else may read: it may show a face.
fn private() -> io::Result<(PathBuf, File)> {
    let mut options = File::options();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let process = std::process::id();
    let mut number = 0;
    loop {
        let more = if number == 0 { String::new() } else { format!("-{number}") };
        let path = std::env::temp_dir().join(format!("lumivox-{process}{more}.png"));
        match options.open(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && number < 100 => number += 1,
            opened => return opened.map(|file| (path, file)),
        }
    }
}

fn write_png_to(file: File, picture: &Picture) -> io::Result<()> {
    let opaque = picture.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255);
    let mut file = BufWriter::new(file);
    let mut encoder = png::Encoder::new(&mut file, picture.width, picture.height);
    encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    if opaque {
        let rgb: Vec<u8> = picture.rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
        writer.write_image_data(&rgb)?;
    } else {
        writer.write_image_data(&picture.rgba)?;
    }
    writer.finish()?;
    file.flush()?;
    // A full disk may only show now.
    file.get_ref().sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exit::Exit;

    fn picture(alpha: u8) -> Picture {
        Picture { width: 2, height: 1, rgba: vec![1, 2, 3, 255, 4, 5, 6, alpha] }
    }

    fn read(path: &Path) -> (png::ColorType, Vec<u8>) {
        let decoder = png::Decoder::new(io::BufReader::new(File::open(path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        (reader.info().color_type, pixels)
    }

    #[test]
    fn a_background_shows_exactly_where_nothing_else_is() {
        let rgba = vec![200, 100, 50, 0, 200, 100, 50, 255, 255, 255, 255, 128];
        let mut picture = Picture { width: 3, height: 1, rgba };
        picture.put_on([10, 20, 30]);
        assert_eq!(picture.rgba[..8], [10, 20, 30, 255, 200, 100, 50, 255]);
        // Half of white light, not half of its code.
        assert!((186..=190).contains(&picture.rgba[8]), "{:?}", picture.rgba);
    }

    #[test]
    fn a_picture_survives_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        PngOutput::prepare(&path, []).unwrap().write(&picture(128)).unwrap();
        assert_eq!(read(&path), (png::ColorType::Rgba, vec![1, 2, 3, 255, 4, 5, 6, 128]));
        PngOutput::prepare(&path, []).unwrap().write(&picture(255)).unwrap();
        assert_eq!(read(&path), (png::ColorType::Rgb, vec![1, 2, 3, 4, 5, 6]));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_cannot_be_written_is_refused_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        let exit = |name: &str| PngOutput::prepare(&folder.path().join(name), []).err().map(|f| f.exit);
        assert_eq!(exit("a.jpg"), Some(Exit::Usage));
        assert_eq!(exit("a"), Some(Exit::Usage));
        assert_eq!(exit("missing/a.png"), Some(Exit::Failure));
        fs::create_dir(folder.path().join("folder.png")).unwrap();
        assert_eq!(exit("folder.png"), Some(Exit::Failure));
        assert_eq!(exit("a.PNG"), None);
    }

    #[test]
    fn no_input_is_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let prepare = |input: &Path| PngOutput::prepare(&path, [input]).err().map(|failure| failure.exit);
        assert_eq!(prepare(&path), None, "neither exists");
        fs::write(&path, "a scan").unwrap();
        fs::create_dir(folder.path().join("b")).unwrap();
        assert_eq!(prepare(&path), Some(Exit::Usage));
        assert_eq!(prepare(&folder.path().join("b/../a.png")), Some(Exit::Usage), "by another name");
        assert_eq!(prepare(folder.path()), None, "a picture may lie in the folder of a scan");
    }

    #[test]
    fn a_read_only_file_is_respected() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "dear").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        assert!(PngOutput::prepare(&path, []).is_err_and(|failure| failure.message.contains("read-only")));
    }

    #[cfg(unix)]
    #[test]
    fn what_has_lost_its_folder_is_kept_for_nobody_else_and_over_nothing() {
        use std::os::unix::fs::PermissionsExt;

        let folder = tempfile::tempdir().unwrap();
        let output = PngOutput::prepare(&folder.path().join("a.png"), []).unwrap();
        folder.close().unwrap();
        let kept = [128, 255].map(|alpha| {
            let failure = output.write(&picture(alpha)).unwrap_err();
            PathBuf::from(failure.message.split_once("kept in ").unwrap().1)
        });
        assert_ne!(kept[0], kept[1]);
        assert_eq!(read(&kept[0]).1, [1, 2, 3, 255, 4, 5, 6, 128]);
        for file in kept {
            assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
            fs::remove_file(file).unwrap();
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let [real, link] = ["real.png", "link.png"].map(|name| folder.path().join(name));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink("real.png", &link).unwrap();
        PngOutput::prepare(&link, []).unwrap().write(&picture(255)).unwrap();
        assert!(link.is_symlink());
        assert_eq!(read(&real).1.len(), 6);
    }

    #[test]
    fn a_strip_does_not_replace_a_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let output = PngOutput::prepare(&path, []).unwrap().sparing_the_earlier();
        assert_eq!(output.path(), path);
        fs::write(&path, "good").unwrap();
        let output = PngOutput::prepare(&path, []).unwrap().sparing_the_earlier();
        output.write(&picture(255)).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"good");
        assert_eq!(read(&folder.path().join("a.partial.png")).1.len(), 6);
    }

    #[test]
    fn a_picture_whose_place_vanished_is_kept_elsewhere() {
        let folder = tempfile::tempdir().unwrap();
        let output = PngOutput::prepare(&folder.path().join("a.png"), []).unwrap();
        drop(folder);
        let message = output.write(&picture(255)).unwrap_err().message;
        let kept = Path::new(message.rsplit("kept in ").next().unwrap()).to_owned();
        assert_eq!(read(&kept).1.len(), 6, "{message}");
        fs::remove_file(kept).unwrap();
    }
}
