//! The Godot addon in the layout of its Asset Library, and the demo as a project that opens as it is.

use std::fs;
use std::path::{Path, PathBuf};

use super::archive::{File, Files};
use super::{VERSION, binaries, read};

/// Where the addon lies in a project.
const ADDON: &str = "addons/lumivox";

/// Native files of one system: where `lumivox.gdextension` looks for them, and where they lie.
pub struct Libraries {
    pub folder: &'static str,
    pub files: Vec<PathBuf>,
}

/// `lumivox-godot-VERSION.zip`: unpacked into a project, or by the editor's Asset Library.
pub fn addon(root: &Path, libraries: &[Libraries], notice: &str) -> Result<Files, String> {
    let source = root.join("godot/demo").join(ADDON);
    let manifest = read(&source.join("lumivox.gdextension"))?;
    let plugin = read(&source.join("plugin.cfg"))?;
    if !plugin.contains(&format!("version=\"{VERSION}\"")) {
        return Err(format!("godot/demo/{ADDON}/plugin.cfg does not say version=\"{VERSION}\""));
    }
    let mut files = Files::default();
    files.add_folder("", &source, &|path| !path.starts_with("bin/"))?;
    for (name, license) in super::own_licenses(root)?.0 {
        files.add(name, license);
    }
    files.add("THIRD-PARTY-LICENSES.txt", File::text(notice));
    files.add_copy("icon.svg", &root.join("godot/demo/icon.svg"))?;
    for Libraries { folder, files: native } in libraries {
        for file in native {
            let name = file.file_name().and_then(|name| name.to_str()).ok_or("a library without a name")?;
            let place = format!("bin/{folder}/{name}");
            if !manifest.contains(&format!("\"{place}\"")) {
                return Err(format!("lumivox.gdextension has no {place}"));
            }
            let bytes = fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
            // The entry that the manifest calls first.
            if name.contains("lumivox_godot") && binaries::find(&bytes, b"gdext_rust_init").is_none() {
                return Err(format!("{}: it is no extension of Godot's", file.display()));
            }
            files.add(place, File::program(bytes));
        }
    }
    Ok(files.within(ADDON))
}

/// `lumivox-godot-demo-VERSION.zip`: a folder that Godot opens as a project.
pub fn demo(root: &Path, addon: &Files) -> Result<Files, String> {
    let mut files = addon.clone();
    let ours =
        ["export_presets.cfg", "icon.svg", "icon.svg.import", "main.tscn", "project.godot", ".gitignore"];
    files.add_folder("", &root.join("godot/demo"), &|path| {
        ours.contains(&path) || path.starts_with("scenes/")
    })?;
    files.add("README.md", File::text(README.replace("VERSION", VERSION)));
    // Without this list the first import does not know the classes that scenes need.
    files.add(".godot/extension_list.cfg", File::text(format!("res://{ADDON}/lumivox.gdextension\n")));
    Ok(files.within(&format!("lumivox-godot-demo-{VERSION}")))
}

const README: &str = "\
# Lumivox VERSION: the demo for Godot

Unpack the archive, start Godot 4.5 or newer, choose Import, and then the file `project.godot` in this folder. F5 runs the demo: a
scan, path traced on a table, beside meshes and lights. The menu has more scenes; each computes the scan that it shows.

The addon is in `addons/lumivox`; its README says how a project of your own has it. **Not a medical device.**
";
