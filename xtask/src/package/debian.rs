//! Packages of Debian's, in its own layout (Debian Policy 3.9, 5 and 12).

use super::archive::{self, File, Files, How};
use super::command::Words;
use super::{VERSION, filled};

/// What Debian wants to know of a package.
pub struct About {
    pub name: &'static str,
    /// Packages that it cannot do without, besides the C library.
    pub depends: &'static str,
    pub recommends: &'static str,
    /// A line, and the text below it as control files have it.
    pub description: &'static str,
}

/// `NAME_VERSION_amd64.deb` of files below `/usr`.
pub fn pack(
    mut files: Files,
    about: &About,
    own_licenses: &Files,
    words: &Words<'_>,
    how: How,
) -> Result<Vec<u8>, String> {
    let doc = format!("share/doc/{}", about.name);
    let text = |file: &File| String::from_utf8_lossy(&file.bytes).trim().to_owned();
    let own: Vec<String> = own_licenses.0.values().map(text).collect();
    let copyright = format!(
        "Lumivox {VERSION}\nhttps://github.com/lumivox/lumivox\n\nMIT or Apache-2.0, at your option.\n\n{}\n\n{}",
        own.join("\n\n"),
        words.notice
    );
    files.add(format!("{doc}/copyright"), File::text(copyright));
    let notes = archive::gz(words.notes.as_bytes())?;
    files.add(format!("{doc}/changelog.gz"), File { bytes: notes, is_program: false });
    files.add(format!("{doc}/{}.cdx.json", about.name), File::text(words.bill));
    let files = files.within("usr");
    let size: usize = files.0.values().map(|file| file.bytes.len().div_ceil(1024)).sum();
    let mut control = Files::default();
    control.add("control", File::text(about.control(size)));
    let control = archive::xz(&control.tar("./", how.date)?, how.effort)?;
    let data = archive::xz(&files.tar("./", how.date)?, how.effort)?;
    let members: [(&str, &[u8]); 3] =
        [("debian-binary", b"2.0\n"), ("control.tar.xz", &control), ("data.tar.xz", &data)];
    Ok(archive::ar(&members, how.date))
}

impl About {
    /// Of a package that takes `size` KiB.
    fn control(&self, size: usize) -> String {
        let Self { name, depends, recommends, description } = self;
        filled(&format!(
            "Package: {name}
Version: VERSION
Architecture: amd64
Maintainer: The Lumivox contributors
Installed-Size: {size}
Depends: libc6 (>= 2.28){depends}
Recommends: {recommends}
Section: science
Priority: optional
Homepage: https://github.com/lumivox/lumivox
Description: {description}
"
        ))
    }
}
