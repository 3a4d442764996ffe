//! The Unity package, as its package manager installs it: `cargo xtask package unity`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::archive::{self, File, Files};
use super::binaries::system_of;
use super::options::Options;
use super::works::{self, Graph};
use super::{VERSION, make_empty, read, run};
use crate::{unity_branch, unity_kernels, unity_metas};

/// Makes `com.lumivox-VERSION.tgz` in `out`, as Unity's package manager takes it: the package, with kernels, and the native
/// library and the decoders' program of this system in it, and those of other systems. Those of this system are built for
/// people, or taken from a folder.
pub fn unity(out: &Path, options: &Options<'_>) -> Result<(), String> {
    let root = crate::root()?;
    check(&root, options.branch)?;
    let of_windows = options.windows.map(|folder| WINDOWS_FILES.map(|name| folder.join(name)));
    let of_windows = of_windows.iter().flatten().map(PathBuf::as_path);
    let others: Vec<&Path> = of_windows.chain(options.libraries.iter().copied()).collect();
    check_others(&others)?;
    let native = match options.from {
        Some(folder) => native_files(folder)?,
        None => build()?,
    };
    fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let own = out.join("native");
    make_empty(&own)?;
    let mut built = vec![];
    for file in &native {
        let copy = own.join(file.file_name().ok_or("a program without a name")?);
        fs::copy(file, &copy).map_err(|error| format!("{}: {error}", file.display()))?;
        if options.from.is_some() {
            run(Command::new("strip").arg(&copy))?;
        }
        built.push(copy);
    }
    let roots = ["lumivox-unity", "lumivox-import"];
    let works = Graph::new(&root, &host()?, &roots)?.linked(&roots)?;
    let content = Content { own: &built, others: &others, notice: &works::notice(&works) };
    let archive = pack(&root, &out.join("package"), &content, options.branch, super::date(&root)?)?;
    let file = out.join(format!("com.lumivox-{VERSION}.tgz"));
    super::write(&file, &archive)?;
    fs::remove_dir_all(&own).map_err(|error| format!("{}: {error}", own.display()))?;
    println!("{}: {:.1} MB", file.display(), archive.len() as f64 * 1e-6);
    Ok(())
}

/// What of the package is native on Windows.
pub const WINDOWS_FILES: [&str; 2] = ["lumivox_unity.dll", "lumivox-codecs.exe"];

/// Fails where the package has no place for one of these files: to be known before minutes of building.
pub fn check_others(files: &[&Path]) -> Result<(), String> {
    files.iter().try_for_each(|file| place_of(file).map(drop))
}

/// What is in the package, besides what the tree has.
pub struct Content<'a> {
    /// The library and the program of this system.
    pub own: &'a [PathBuf],
    /// Those of others.
    pub others: &'a [&'a Path],
    /// Whose works are in them.
    pub notice: &'a str,
}

/// Fails where no package can be made of the tree, or not be committed to the branch.
fn check(root: &Path, branch: Option<&str>) -> Result<(), String> {
    let said: serde_json::Value = serde_json::from_str(&read(&root.join("unity/com.lumivox/package.json"))?)
        .map_err(|error| format!("unity/com.lumivox/package.json: {error}"))?;
    if said["version"] != VERSION {
        let there = &said["version"];
        return Err(format!("unity/com.lumivox/package.json says version {there}, the workspace {VERSION}"));
    }
    unity_metas::check()?;
    unity_kernels::check()?;
    match branch {
        Some(branch) => unity_branch::check(root, branch).map(drop),
        None => Ok(()),
    }
}

/// The archive, by way of a folder that is made and removed.
pub fn pack(
    root: &Path,
    staged: &Path,
    content: &Content<'_>,
    branch: Option<&str>,
    date: u64,
) -> Result<Vec<u8>, String> {
    check(root, branch)?;
    make_empty(staged)?;
    let mut files = Files::default();
    files.add_folder("", &root.join("unity/com.lumivox"), &|_| true)?;
    // As Unity's packages call it.
    files.add("Third Party Notices.md", File::text(content.notice));
    let plugins = "Runtime/Plugins";
    for file in content.own {
        let name = file.file_name().and_then(|name| name.to_str()).ok_or("a program without a name")?;
        files.add_copy(format!("{plugins}/{}/{name}", plugin_folder()?), file)?;
    }
    for file in content.others {
        let place = format!("{plugins}/{}", place_of(file)?);
        if files.0.contains_key(&place) {
            return Err(format!("{}: the package has its {place} already", file.display()));
        }
        files.add_copy(place, file)?;
    }
    for (path, file) in &files.0 {
        let target = staged.join(path);
        let folder = target.parent().ok_or("a file without a folder")?;
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        super::write(&target, &file.bytes)?;
    }
    unity_kernels::complete(staged)?;
    unity_metas::complete(staged, staged)?;
    let mut all = Files::default();
    all.add_folder("", staged, &|_| true)?;
    for (path, file) in &mut all.0 {
        let name = path.rsplit('/').next().unwrap_or(path);
        file.is_program = name.starts_with("lumivox-codecs") && !name.ends_with(".meta");
    }
    let archive = archive::gz(&all.within("package").tar("", date)?)?;
    if let Some(branch) = branch {
        unity_branch::commit(root, staged, branch, VERSION)?;
    }
    fs::remove_dir_all(staged).map_err(|error| format!("{}: {error}", staged.display()))?;
    Ok(archive)
}

/// The system that this is built for, as Cargo calls it.
fn host() -> Result<String, String> {
    let said = Command::new("rustc").arg("-vV").output().map_err(|error| format!("rustc: {error}"))?;
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    let host = said.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "rustc does not say what it builds for".to_owned())
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
}
