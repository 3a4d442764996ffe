//! The Studio as a program of a desktop, with its entry in menus: an archive for Linux, one for Windows, and a package of Debian's.

use std::path::Path;

use super::archive::{self, File, Files, How};
use super::command::{Words, add_words, program};
use super::debian::{self, About};
use super::{VERSION, filled};

const README_LINUX: &str = include_str!("readme-studio-linux.txt");
const README_WINDOWS: &str = include_str!("readme-studio-windows.txt");

/// For menus and file managers (Desktop Entry Specification 1.5).
const ENTRY: &str = "\
[Desktop Entry]
Type=Application
Name=Lumivox Studio
GenericName=Viewer of CT and MR scans
GenericName[de]=Betrachter für CT- und MR-Scans
Comment=Drop a scan, see the anatomy. Not a medical device.
Comment[de]=Scan ablegen, Anatomie sehen. Kein Medizinprodukt.
Exec=lumivox-studio %F
Icon=lumivox-studio
Terminal=false
Categories=Science;MedicalSoftware;Graphics;3DGraphics;Viewer;
MimeType=application/dicom;
Keywords=DICOM;CT;MRI;NIfTI;anatomy;
";

/// Nothing is linked to a display: which one there is, it finds when it starts.
const DEBIAN: About = About {
    name: "lumivox-studio",
    depends: ", libx11-6, libx11-xcb1, libxcursor1, libxi6, libxkbcommon0, libxkbcommon-x11-0",
    recommends: "ca-certificates, libvulkan1, mesa-vulkan-drivers | vulkan-icd, xdg-desktop-portal",
    description: "CT and MR scans as photorealistic anatomy
 Drop a scan, see the anatomy: a path-traced view beside its slices, looks,
 cuts, structures, measurements and pictures. Reads DICOM, NIfTI, NRRD,
 MetaImage and more. Needs a Vulkan driver: a graphics card's, or Mesa's in
 software.
 .
 Not a medical device.",
};

/// What is packed.
pub struct Content<'a> {
    /// The program, for one of the systems.
    pub studio: &'a Path,
    /// The npm package, of which pages for others are made; none where programs were taken from elsewhere.
    pub viewer: Option<&'a Path>,
    /// Where the sources lie.
    pub root: &'a Path,
}

impl Content<'_> {
    /// Of that package, what such a page takes: `Viewer::FILES` of the Studio's `sharing.rs`.
    fn add_viewer(&self, folder: &str, files: &mut Files) -> Result<(), String> {
        let parts = ["lumivox.js", "lumivox_wasm.js", "lumivox_wasm_bg.wasm"];
        let all = self.viewer.into_iter().flat_map(|viewer| parts.map(|name| (name, viewer.join(name))));
        all.into_iter().try_for_each(|(name, from)| files.add_copy(format!("{folder}/{name}"), &from))
    }
}

/// The program where Linux's menus find it, below `/usr` or `~/.local`.
fn shared(content: &Content<'_>) -> Result<Files, String> {
    let Content { studio, root, .. } = content;
    let mut files = Files::default();
    content.add_viewer("share/lumivox-studio/viewer", &mut files)?;
    files.add("bin/lumivox-studio", program(studio)?);
    files.add("share/applications/lumivox-studio.desktop", File::text(ENTRY));
    let icon = "share/icons/hicolor/scalable/apps/lumivox-studio.svg";
    files.add_copy(icon, &root.join("apps/studio/web/icon.svg"))?;
    Ok(files)
}

/// `lumivox-studio-VERSION-x86_64-linux.tar.xz`.
pub fn linux(content: &Content<'_>, own: &Files, words: &Words<'_>, how: How) -> Result<Vec<u8>, String> {
    let mut files = shared(content)?;
    files.add("README.txt", File::text(filled(README_LINUX)));
    add_words(&mut files, own, "lumivox-studio", words);
    let tar = files.within(&format!("lumivox-studio-{VERSION}-x86_64-linux")).tar("", how.date)?;
    archive::xz(&tar, how.effort)
}

/// `lumivox-studio-VERSION-x86_64-windows.zip`, of which nothing needs to be installed.
pub fn windows(content: &Content<'_>, own: &Files, words: &Words<'_>, how: How) -> Result<Vec<u8>, String> {
    let mut files = Files::default();
    content.add_viewer("viewer", &mut files)?;
    files.add("lumivox-studio.exe", program(content.studio)?);
    files.add("README.txt", File::text(filled(README_WINDOWS).replace('\n', "\r\n")));
    add_words(&mut files, own, "lumivox-studio", words);
    files.within(&format!("lumivox-studio-{VERSION}-x86_64-windows")).zip(how.date)
}

/// `lumivox-studio_VERSION_amd64.deb`.
pub fn debian(content: &Content<'_>, own: &Files, words: &Words<'_>, how: How) -> Result<Vec<u8>, String> {
    debian::pack(shared(content)?, &DEBIAN, own, words, how)
}
