//! What people without a compiler install, made of the tree: `cargo xtask package unity`, `cargo xtask package python`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{unity_branch, unity_kernels, unity_metas};

/// What a Unity package is made with.
#[derive(Debug, Default, PartialEq)]
pub struct Options<'a> {
    /// The folder in which this system's library and program lie.
    from: Option<&'a Path>,
    /// Those of other systems.
    others: Vec<&'a Path>,
    /// The branch that it is committed to.
    branch: Option<&'a str>,
}

/// Of `--from DIR`, `--library FILE` and `--upm BRANCH`; `None` where they are something else.
pub fn options<'a>(words: &[&'a str]) -> Option<Options<'a>> {
    let mut options = Options::default();
    for pair in words.chunks(2) {
        match *pair {
            ["--from", folder] if options.from.is_none() => options.from = Some(Path::new(folder)),
            ["--library", file] => options.others.push(Path::new(file)),
            ["--upm", branch] if options.branch.is_none() && !branch.starts_with('-') => {
                options.branch = Some(branch)
            }
            _ => return None,
        }
    }
    Some(options)
}

/// Makes `com.lumivox-VERSION.tgz` in `out`, as Unity's package manager takes it: the package, with kernels, and the native
/// library and the decoders' program of this system in it, and those of other systems. Those of this system are built for
/// people, or taken from a folder.
pub fn unity(out: &Path, options: &Options<'_>) -> Result<(), String> {
    let root = crate::root()?;
    let version = env!("CARGO_PKG_VERSION");
    let package = root.join("unity/com.lumivox");
    let manifest = read(&package.join("package.json"))?;
    let said: serde_json::Value = serde_json::from_str(&manifest)
        .map_err(|error| format!("unity/com.lumivox/package.json: {error}"))?;
    if said["version"] != version {
        let there = &said["version"];
        return Err(format!("unity/com.lumivox/package.json says version {there}, the workspace {version}"));
    }
    unity_metas::check()?;
    unity_kernels::check()?;
    // Before minutes of building.
    if let Some(branch) = options.branch {
        unity_branch::check(&root, branch)?;
    }
    let others =
        options.others.iter().map(|file| Ok((*file, place_of(file)?))).collect::<Result<Vec<_>, String>>()?;
    let built = match options.from {
        Some(folder) => native_files(folder)?,
        None => build()?,
    };
    fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let staged = out.join("package");
    if staged.exists() {
        fs::remove_dir_all(&staged).map_err(|error| format!("{}: {error}", staged.display()))?;
    }
    copy_all(&package, &staged)?;
    let folder = staged.join("Runtime/Plugins").join(plugin_folder()?);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for file in &built {
        let name = file.file_name().ok_or("a program without a name")?;
        let target = folder.join(name);
        fs::copy(file, &target).map_err(|error| format!("{}: {error}", file.display()))?;
        if options.from.is_some() {
            run(Command::new("strip").arg(&target))?;
        }
    }
    for (file, place) in others {
        let target = staged.join("Runtime/Plugins").join(place);
        if target.exists() {
            return Err(format!("{}: the package has its {place} already", file.display()));
        }
        let folder = target.parent().ok_or("a file without a folder")?;
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        fs::copy(file, &target).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    unity_kernels::complete(&staged)?;
    unity_metas::complete(&staged, &staged)?;
    let name = format!("com.lumivox-{version}.tgz");
    // The same files give the same archive.
    run(Command::new("tar")
        .args(["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=2020-01-01", "-czf"])
        .arg(out.join(&name))
        .arg("-C")
        .arg(out)
        .arg("package"))?;
    if let Some(branch) = options.branch {
        unity_branch::commit(&root, &staged, branch, version)?;
    }
    fs::remove_dir_all(&staged).map_err(|error| format!("{}: {error}", staged.display()))?;
    let size = fs::metadata(out.join(&name)).map_err(|error| error.to_string())?.len();
    println!("{}: {:.1} MB", out.join(&name).display(), size as f64 * 1e-6);
    Ok(())
}

/// Makes the wheel of the Python package in `out`: one for Python 3.10 and newer, for the oldest manylinux that this system's
/// libraries suffice for.
pub fn python(out: &Path) -> Result<(), String> {
    let root = crate::root()?;
    let out = std::path::absolute(out).map_err(|error| format!("{}: {error}", out.display()))?;
    run(Command::new(root.join("script/python")).arg("--wheel-only").arg(&out))?;
    let version = env!("CARGO_PKG_VERSION");
    let made = fs::read_dir(&out).map_err(|error| format!("{}: {error}", out.display()))?.flatten();
    let names: Vec<_> = made.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    match names.iter().find(|name| name.starts_with(&format!("lumivox-{version}-cp310-abi3-"))) {
        Some(_) => Ok(()),
        None => Err(format!("no wheel of version {version} is among {names:?}")),
    }
}

/// Where Unity looks for libraries of this system.
fn plugin_folder() -> Result<&'static str, String> {
    match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => Ok("Linux/x86_64"),
        ("windows", "x86_64") => Ok("Windows/x86_64"),
        ("macos", _) => Ok("macOS"),
        (os, arch) => Err(format!("the package has no place for libraries of {os} on {arch}")),
    }
}

/// Where what was built for another system belongs, by what is in it.
fn place_of(file: &Path) -> Result<&'static str, String> {
    let bytes = fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let refuse = |why: String| Err(format!("{}: {why}", file.display()));
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let places: [&'static str; 2] = match system_of(&bytes) {
        Some("linux") => ["Linux/x86_64/liblumivox_unity.so", "Linux/x86_64/lumivox-codecs"],
        Some("windows") => ["Windows/x86_64/lumivox_unity.dll", "Windows/x86_64/lumivox-codecs.exe"],
        Some("macos") => ["macOS/liblumivox_unity.dylib", "macOS/lumivox-codecs"],
        _ => return refuse("it is neither of Linux or Windows on x86-64 nor of macOS".to_owned()),
    };
    let Some(place) = places.into_iter().find(|place| place.rsplit('/').next() == Some(&*name)) else {
        return refuse(format!("on its system Unity looks for {}", places[0]));
    };
    let border = b"lumivox_abi_version";
    if place == places[0] && !bytes.windows(border.len()).any(|window| window == border) {
        return refuse("it has not the functions of lumivox-unity".to_owned());
    }
    Ok(place)
}

/// What a program or library is for, by its headers: ELF's, PE's or Mach-O's.
fn system_of(bytes: &[u8]) -> Option<&'static str> {
    let word = |at: usize| Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?));
    match bytes.get(..4)? {
        [0x7f, b'E', b'L', b'F'] => (bytes.get(4) == Some(&2) && word(18)? == 62).then_some("linux"),
        [b'M', b'Z', ..] => {
            let at = u32::from_le_bytes(bytes.get(0x3c..0x40)?.try_into().ok()?) as usize;
            (bytes.get(at..at.checked_add(4)?)? == b"PE\0\0" && word(at + 4)? == 0x8664).then_some("windows")
        }
        [0xcf, 0xfa, 0xed, 0xfe] | [0xca, 0xfe, 0xba, 0xbe] => Some("macos"),
        _ => None,
    }
}

/// What is native, of a folder.
fn native_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX, EXE_SUFFIX};
    let files = [format!("{DLL_PREFIX}lumivox_unity{DLL_SUFFIX}"), format!("lumivox-codecs{EXE_SUFFIX}")];
    let there = files.map(|name| folder.join(name));
    match there.iter().find(|file| !file.is_file()) {
        Some(file) => Err(format!("there is no {}", file.display())),
        None => Ok(there.to_vec()),
    }
}

/// Builds what is native; returns the files.
fn build() -> Result<Vec<PathBuf>, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["build", "--quiet", "--profile", "dist", "--message-format", "json-render-diagnostics"])
        .args([
            "--package",
            "lumivox-unity",
            "--package",
            "lumivox-import",
            "--lib",
            "--bin",
            "lumivox-codecs",
        ])
        .stderr(std::process::Stdio::inherit())
        .output()
        .map_err(|error| format!("cargo: {error}"))?;
    if !output.status.success() {
        return Err("what is native does not build".to_owned());
    }
    let mut files = vec![];
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let Ok(message) = serde_json::from_str::<serde_json::Value>(line) else { continue };
        let wanted = ["lumivox_unity", "lumivox-codecs"];
        if message["reason"] != "compiler-artifact"
            || !wanted.iter().any(|name| message["target"]["name"] == *name)
        {
            continue;
        }
        let made = message["filenames"].as_array().into_iter().flatten().filter_map(|name| name.as_str());
        files.extend(made.map(PathBuf::from).filter(|path| {
            let extension = path.extension().unwrap_or_default();
            ["so", "dll", "dylib", "exe", ""].iter().any(|known| extension == *known)
        }));
    }
    match files.len() {
        2 => Ok(files),
        _ => Err(format!("a library and a program were to be built, not {files:?}")),
    }
}

fn copy_all(from: &Path, to: &Path) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", from.display());
    fs::create_dir_all(to).map_err(failed)?;
    for entry in fs::read_dir(from).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let target = to.join(entry.file_name());
        if entry.file_type().map_err(failed)?.is_dir() {
            copy_all(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), &target).map_err(failed)?;
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn run(command: &mut Command) -> Result<(), String> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{command:?}: {status}")),
        Err(error) => Err(format!("{command:?}: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a Windows library of `machine` begins with.
    fn pe(machine: u16) -> Vec<u8> {
        let mut bytes = vec![0; 0x80];
        bytes[..2].copy_from_slice(b"MZ");
        bytes[0x3c] = 0x80;
        bytes.extend(b"PE\0\0");
        bytes.extend(machine.to_le_bytes());
        bytes.extend(b"..lumivox_abi_version..");
        bytes
    }

    #[test]
    fn what_was_built_elsewhere_goes_where_unity_looks_for_it() {
        let folder = std::env::temp_dir().join(format!("lumivox-package-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let place = |name: &str, bytes: &[u8]| {
            let file = folder.join(name);
            fs::write(&file, bytes).unwrap();
            place_of(&file)
        };
        assert_eq!(place("lumivox_unity.dll", &pe(0x8664)), Ok("Windows/x86_64/lumivox_unity.dll"));
        assert_eq!(place("lumivox-codecs.exe", &pe(0x8664)), Ok("Windows/x86_64/lumivox-codecs.exe"));
        let mut elf = b"\x7fELF\x02".to_vec();
        elf.resize(18, 0);
        elf.extend([62, 0]);
        elf.extend(b"lumivox_abi_version");
        assert_eq!(place("liblumivox_unity.so", &elf), Ok("Linux/x86_64/liblumivox_unity.so"));
        let mach = [&[0xcf, 0xfa, 0xed, 0xfe][..], b"lumivox_abi_version"].concat();
        assert_eq!(place("liblumivox_unity.dylib", &mach), Ok("macOS/liblumivox_unity.dylib"));
        let refused = |name: &str, bytes: &[u8], why: &str| {
            let error = place(name, bytes).unwrap_err();
            assert!(error.contains(name) && error.contains(why), "{error}");
        };
        refused("lumivox_unity.dll", &pe(0x14c), "neither of");
        refused("lumivox_unity.dll", b"", "neither of");
        refused("lumivox_unity.dll", &elf, "Linux/x86_64/liblumivox_unity.so");
        refused("lumivox-unity.dll", &pe(0x8664), "Windows/x86_64/lumivox_unity.dll");
        refused("lumivox_unity.dll", &pe(0x8664)[..0x90], "functions");
        fs::remove_dir_all(&folder).unwrap();
        assert!(place_of(&folder.join("gone.dll")).is_err());
    }

    #[test]
    fn options_are_a_folder_and_files_in_any_order() {
        let words = ["--library", "a.dll", "--from", "native", "--library", "b.exe", "--upm", "upm"];
        let all = Options {
            from: Some(Path::new("native")),
            others: vec![Path::new("a.dll"), Path::new("b.exe")],
            branch: Some("upm"),
        };
        assert_eq!(options(&words), Some(all));
        assert_eq!(options(&[]), Some(Options::default()));
        for wrong in [
            &["--library"][..],
            &["--from", "a", "--from", "b"],
            &["--else", "a"],
            &["a.dll"],
            &["--upm", "--from"],
        ] {
            assert_eq!(options(wrong), None, "{wrong:?}");
        }
    }
}
