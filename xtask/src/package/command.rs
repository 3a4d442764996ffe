//! The command with its manual, its licences and what shells complete: an archive for Linux, one for Windows, and a package
//! of Debian's.

use std::path::Path;
use std::process::Command;

use super::archive::{self, File, Files, How};
use super::debian::{self, About};
use super::{VERSION, filled, make_empty, read, run};

const README_LINUX: &str = include_str!("readme-linux.txt");
const README_WINDOWS: &str = include_str!("readme-windows.txt");

/// What goes with the command on every system.
pub struct Manual {
    /// Man pages, by their names.
    pages: Files,
    /// What shells complete.
    completions: Files,
    own_licenses: Files,
}

impl Manual {
    /// Written by the command itself, of a build for this system.
    pub fn new(root: &Path, command: &Path, staging: &Path) -> Result<Self, String> {
        make_empty(staging)?;
        run(Command::new(command).arg("manual").arg(staging))?;
        let mut manual = Self {
            pages: Files::default(),
            completions: Files::default(),
            own_licenses: super::own_licenses(root)?,
        };
        manual.pages.add_folder("", &staging.join("man1"), &|_| true)?;
        manual.completions.add_folder("", &staging.join("completions"), &|_| true)?;
        Ok(manual)
    }

    fn completions(&self, name: &str) -> Result<File, String> {
        self.completions.0.get(name).cloned().ok_or_else(|| format!("'lumivox manual' made no {name}"))
    }

    /// Where Linux's shells and `man` look, below `/usr` or `~/.local`.
    fn shared(&self) -> Result<Files, String> {
        let mut files = Files::default();
        for (name, page) in &self.pages.0 {
            files.add(format!("share/man/man1/{name}"), page.clone());
        }
        files.add("share/bash-completion/completions/lumivox", self.completions("lumivox.bash")?);
        files.add("share/zsh/site-functions/_lumivox", self.completions("_lumivox")?);
        files.add("share/fish/vendor_completions.d/lumivox.fish", self.completions("lumivox.fish")?);
        Ok(files)
    }
}

/// What is said of a version, and whose works are in it.
pub struct Words<'a> {
    pub notes: &'a str,
    pub notice: &'a str,
    pub bill: &'a str,
}

/// `lumivox-VERSION-x86_64-linux.tar.xz`.
pub fn linux(command: &Path, manual: &Manual, words: &Words<'_>, how: How) -> Result<Vec<u8>, String> {
    let mut files = manual.shared()?;
    files.add("bin/lumivox", program(command)?);
    files.add("README.txt", File::text(filled(README_LINUX)));
    add_words(&mut files, &manual.own_licenses, "lumivox", words);
    let tar = files.within(&format!("lumivox-{VERSION}-x86_64-linux")).tar("", how.date)?;
    archive::xz(&tar, how.effort)
}

/// `lumivox-VERSION-x86_64-windows.zip`, of which nothing needs to be installed.
pub fn windows(command: &Path, manual: &Manual, words: &Words<'_>, how: How) -> Result<Vec<u8>, String> {
    let mut files = Files::default();
    files.add("lumivox.exe", program(command)?);
    files.add("README.txt", File::text(filled(README_WINDOWS).replace('\n', "\r\n")));
    files.add("completions/lumivox.ps1", manual.completions("lumivox.ps1")?);
    add_words(&mut files, &manual.own_licenses, "lumivox", words);
    files.within(&format!("lumivox-{VERSION}-x86_64-windows")).zip(how.date)
}

/// What Debian wants to know of it.
const DEBIAN: About = About {
    name: "lumivox",
    depends: "",
    recommends: "libvulkan1, mesa-vulkan-drivers | vulkan-icd",
    description: "photorealistic pictures of CT and MR scans
 Reads DICOM, NIfTI, NRRD, MetaImage and more, and traces light through what
 they show. Needs a Vulkan driver to make pictures: a graphics card's, or
 Mesa's in software.
 .
 Not a medical device.",
};

/// `lumivox_VERSION_amd64.deb`.
pub fn debian(command: &Path, manual: &Manual, words: &Words<'_>, how: How) -> Result<Vec<u8>, String> {
    let mut files = manual.shared()?;
    // Policy 12.1 wants pages compressed.
    for (name, page) in &manual.pages.0 {
        let path = format!("share/man/man1/{name}");
        files.0.remove(&path);
        files.add(format!("{path}.gz"), File { bytes: archive::gz(&page.bytes)?, is_program: false });
    }
    // zsh looks for what packages bring elsewhere.
    let zsh = files.0.remove("share/zsh/site-functions/_lumivox").ok_or("nothing is completed in zsh")?;
    files.add("share/zsh/vendor-completions/_lumivox", zsh);
    files.add("bin/lumivox", program(command)?);
    debian::pack(files, &DEBIAN, &manual.own_licenses, words, how)
}

/// Licences, what is new, and what is in it.
pub fn add_words(files: &mut Files, own_licenses: &Files, name: &str, words: &Words<'_>) {
    for (name, file) in &own_licenses.0 {
        files.add(name.clone(), file.clone());
    }
    files.add("THIRD-PARTY-LICENSES.txt", File::text(words.notice));
    files.add("CHANGES.md", File::text(words.notes));
    files.add(format!("{name}.cdx.json"), File::text(words.bill));
}

/// A file as a program.
pub fn program(file: &Path) -> Result<File, String> {
    std::fs::read(file).map(File::program).map_err(|error| format!("{}: {error}", file.display()))
}

/// What CHANGELOG.md says of this version, or of what has none yet; and of which.
pub fn notes(root: &Path) -> Result<(String, String), String> {
    let log = read(&root.join("CHANGELOG.md"))?;
    for name in [VERSION, "Unreleased"] {
        if let Some(text) = section(&log, name) {
            return Ok((name.to_owned(), format!("# Lumivox {VERSION}\n\n{text}\n")));
        }
    }
    Err(format!("CHANGELOG.md has no section [{VERSION}], and none [Unreleased]"))
}

/// The text below a heading `## [NAME]`.
fn section<'a>(log: &'a str, name: &str) -> Option<&'a str> {
    let start = log.find(&format!("\n## [{name}]"))? + 1;
    let text = log[start..].split_once('\n')?.1;
    let end = text.find("\n## [").unwrap_or(text.len());
    Some(text[..end].trim()).filter(|text| !text.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_those_of_the_version() {
        let log =
            "# Changelog\n\n## [Unreleased]\n\n## [0.2.0] - 2026-01-01\n### Added\n- b\n\n## [0.1.0]\n- a\n";
        assert_eq!(section(log, "0.2.0"), Some("### Added\n- b"));
        assert_eq!(section(log, "0.1.0"), Some("- a"));
        assert_eq!(section(log, "Unreleased"), None);
        assert_eq!(section(log, "0.3.0"), None);
    }
}
