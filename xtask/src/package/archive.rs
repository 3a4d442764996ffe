//! Archives of which the same files make the same bytes: entries by name, of one date and of nobody.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

use flate2::{Compression, GzBuilder};
use lzma_rust2::{XzOptions, XzWriter};
use sha2::{Digest, Sha256};

/// A file of an archive.
#[derive(Clone, Debug, PartialEq)]
pub struct File {
    pub bytes: Vec<u8>,
    pub is_program: bool,
}

impl File {
    pub fn text(text: impl Into<String>) -> Self {
        Self { bytes: text.into().into_bytes(), is_program: false }
    }

    pub fn program(bytes: Vec<u8>) -> Self {
        Self { bytes, is_program: true }
    }

    fn mode(&self) -> u32 {
        if self.is_program { 0o755 } else { 0o644 }
    }
}

/// Files by their paths in the archive, with `/` between folders.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Files(pub BTreeMap<String, File>);

impl Files {
    /// Adds one; a second of its name is a mistake of ours.
    pub fn add(&mut self, path: impl Into<String>, file: File) {
        let path = path.into();
        assert!(!self.0.contains_key(&path), "two files are called {path}");
        self.0.insert(path, file);
    }

    /// Adds a file as it lies there.
    pub fn add_copy(&mut self, path: impl Into<String>, from: &Path) -> Result<(), String> {
        let bytes = fs::read(from).map_err(|error| format!("{}: {error}", from.display()))?;
        self.add(path, File { bytes, is_program: false });
        Ok(())
    }

    /// Adds all below a folder that `wants` takes by its path there.
    pub fn add_folder(
        &mut self,
        prefix: &str,
        from: &Path,
        wants: &dyn Fn(&str) -> bool,
    ) -> Result<(), String> {
        for path in below(from)? {
            if wants(&path) {
                self.add_copy(format!("{prefix}{path}"), &from.join(&path))?;
            }
        }
        Ok(())
    }

    /// The same below another folder.
    pub fn within(self, folder: &str) -> Self {
        Self(self.0.into_iter().map(|(path, file)| (format!("{folder}/{path}"), file)).collect())
    }

    /// The folders around the files, each before what is in it.
    fn folders(&self) -> Vec<String> {
        let mut folders: Vec<String> = self
            .0
            .keys()
            .flat_map(|path| path.match_indices('/').map(|(at, _)| path[..=at].to_owned()))
            .collect();
        folders.sort();
        folders.dedup();
        folders
    }

    /// A tar archive. `root` comes before every path, such as `./` in Debian's packages.
    pub fn tar(&self, root: &str, date: u64) -> Result<Vec<u8>, String> {
        let failed = |error: std::io::Error| error.to_string();
        let mut made = tar::Builder::new(vec![]);
        let header = |kind, mode, size| {
            let mut header = tar::Header::new_gnu();
            header.set_entry_type(kind);
            header.set_mode(mode);
            header.set_size(size);
            header.set_mtime(date);
            header.set_uid(0);
            header.set_gid(0);
            header
        };
        let top = (!root.is_empty()).then(String::new);
        for folder in top.into_iter().chain(self.folders()) {
            let mut entry = header(tar::EntryType::Directory, 0o755, 0);
            made.append_data(&mut entry, format!("{root}{folder}"), &[][..]).map_err(failed)?;
        }
        for (path, file) in &self.0 {
            let mut entry = header(tar::EntryType::Regular, file.mode(), file.bytes.len() as u64);
            made.append_data(&mut entry, format!("{root}{path}"), &file.bytes[..]).map_err(failed)?;
        }
        made.into_inner().map_err(failed)
    }

    /// A ZIP archive.
    pub fn zip(&self, date: u64) -> Result<Vec<u8>, String> {
        let failed = |path: &str, error: zip::result::ZipError| format!("{path}: {error}");
        let mut made = zip::ZipWriter::new(Cursor::new(vec![]));
        let options = zip::write::SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Deflated)
            .compression_level(Some(9))
            .last_modified_time(dos_time(date)?);
        for (path, file) in &self.0 {
            made.start_file(path.as_str(), options.unix_permissions(file.mode()))
                .map_err(|e| failed(path, e))?;
            made.write_all(&file.bytes).map_err(|error| format!("{path}: {error}"))?;
        }
        Ok(made.finish().map_err(|error| failed("the archive", error))?.into_inner())
    }
}

/// Paths of all files below a folder, in order; what is no file or folder is refused.
pub fn below(folder: &Path) -> Result<Vec<String>, String> {
    let mut found = vec![];
    walk(folder, "", &mut found)?;
    found.sort();
    Ok(found)
}

fn walk(folder: &Path, within: &str, found: &mut Vec<String>) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.join(within).display());
    for entry in fs::read_dir(folder.join(within)).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name().into_string().map_err(|name| format!("{name:?} is no name to pack"))?;
        let path = if within.is_empty() { name } else { format!("{within}/{name}") };
        let kind = entry.file_type().map_err(failed)?;
        if kind.is_dir() {
            walk(folder, &path, found)?;
        } else if kind.is_file() {
            found.push(path);
        } else {
            return Err(format!("{} is neither a file nor a folder", entry.path().display()));
        }
    }
    Ok(())
}

/// How something is packed.
#[derive(Clone, Copy, Debug)]
pub struct How {
    /// Of all files, in seconds after 1970.
    pub date: u64,
    /// From 0, which is quick, to 9.
    pub effort: u32,
}

pub fn xz(bytes: &[u8], effort: u32) -> Result<Vec<u8>, String> {
    let made = XzWriter::new(vec![], XzOptions::with_preset(effort)).and_then(|mut writer| {
        writer.write_all(bytes)?;
        writer.finish()
    });
    made.map_err(|error| error.to_string())
}

/// Without a date and a name of its own.
pub fn gz(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let mut writer = GzBuilder::new().mtime(0).write(vec![], Compression::best());
    writer.write_all(bytes).and_then(|()| writer.finish()).map_err(|error| error.to_string())
}

/// An archive of Unix' `ar`, of which Debian's packages are made.
pub fn ar(members: &[(&str, &[u8])], date: u64) -> Vec<u8> {
    let mut made = b"!<arch>\n".to_vec();
    for (name, bytes) in members {
        made.extend(format!("{name:<16}{date:<12}0     0     100644  {:<10}`\n", bytes.len()).into_bytes());
        made.extend(*bytes);
        if bytes.len() % 2 == 1 {
            made.push(b'\n');
        }
    }
    made
}

pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A date as ZIP has them; none is before 1980.
fn dos_time(date: u64) -> Result<zip::DateTime, String> {
    let (year, month, day) = civil(date / 86400);
    let second = date % 86400;
    let part = |value: u64| u8::try_from(value).unwrap_or(0);
    if year < 1980 {
        return Ok(zip::DateTime::default());
    }
    let year =
        u16::try_from(year).map_err(|_| format!("{date} s is too late for a date of a ZIP archive"))?;
    zip::DateTime::from_date_and_time(
        year,
        part(month),
        part(day),
        part(second / 3600),
        part(second / 60 % 60),
        part(second % 60),
    )
    .map_err(|_| format!("{date} s is no date for a ZIP archive"))
}

/// Year, month and day of a day after the first of 1970 (Hinnant, `chrono`-Compatible Low-Level Date Algorithms).
pub fn civil(days: u64) -> (u64, u64, u64) {
    let shifted = days + 719_468;
    let (era, of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    (era * 400 + year_of_era + u64::from(month <= 2), month, day)
}

/// As ISO 8601 writes a date and its time.
pub fn iso(date: u64) -> String {
    let ((year, month, day), second) = (civil(date / 86400), date % 86400);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files() -> Files {
        let mut files = Files::default();
        files.add("b/tool", File::program(b"a program".to_vec()));
        files.add("a.txt", File::text("words\n"));
        files.add(format!("b/{}/c", "long".repeat(40)), File::text("deep"));
        files
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(iso(0), "1970-01-01T00:00:00Z");
        assert_eq!(iso(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(iso(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(iso(1_795_769_085), "2026-11-27T08:44:45Z");
    }

    #[test]
    fn archives_hold_what_was_put_in_and_say_nothing_of_who_made_them() {
        let made = files().tar("./", 1_600_000_000).unwrap();
        assert_eq!(made, files().tar("./", 1_600_000_000).unwrap());
        let mut archive = tar::Archive::new(&made[..]);
        let mut seen = vec![];
        for entry in archive.entries().unwrap() {
            let mut entry = entry.unwrap();
            let header = entry.header();
            let who = (header.uid().unwrap(), header.gid().unwrap(), header.mtime().unwrap());
            assert_eq!(who, (0, 0, 1_600_000_000));
            let mode = header.mode().unwrap();
            let path = entry.path().unwrap().display().to_string();
            let mut text = String::new();
            std::io::Read::read_to_string(&mut entry, &mut text).unwrap();
            seen.push((path, mode, text));
        }
        let long = "long".repeat(40);
        let entry = |path: &str, mode, text: &str| (path.to_owned(), mode, text.to_owned());
        let wanted = [
            entry("./", 0o755, ""),
            entry("./b/", 0o755, ""),
            entry(&format!("./b/{long}/"), 0o755, ""),
            entry("./a.txt", 0o644, "words\n"),
            entry(&format!("./b/{long}/c"), 0o644, "deep"),
            entry("./b/tool", 0o755, "a program"),
        ];
        let plain = |(path, mode, text): &(String, u32, String)| {
            (path.trim_start_matches("./").trim_end_matches('/').to_owned(), *mode, text.clone())
        };
        assert_eq!(seen.iter().map(plain).collect::<Vec<_>>(), wanted.iter().map(plain).collect::<Vec<_>>());

        let made = files().zip(1_600_000_000).unwrap();
        assert_eq!(made, files().zip(1_600_000_000).unwrap());
        let mut archive = zip::ZipArchive::new(Cursor::new(made)).unwrap();
        let tool = archive.by_name("b/tool").unwrap();
        assert_eq!(tool.unix_mode().map(|mode| mode & 0o777), Some(0o755));
        assert_eq!(tool.last_modified().map(|date| (date.year(), date.month())), Some((2020, 9)));
    }

    #[test]
    #[should_panic(expected = "two files are called a")]
    fn no_file_takes_the_place_of_another() {
        let mut files = Files::default();
        files.add("a", File::text(""));
        files.add("a", File::text(""));
    }
}
