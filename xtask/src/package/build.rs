//! Programs and libraries for Linux: built so that systems of 2018 run them, and so that two builds make the same bytes.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{binaries, make_empty, run, target_folder, works};

/// What is built together, and the system that it is built for.
pub const PACKAGES: [&str; 4] = ["lumivox", "lumivox-import", "lumivox-godot", "lumivox-unity"];
/// And what is built apart, lest the others are of what it alone asks for.
pub const STUDIO: [&str; 1] = ["lumivox-studio"];
pub const LINUX: &str = "x86_64-unknown-linux-gnu";

/// What is native of the packages for Linux.
pub struct Native {
    pub command: PathBuf,
    pub codecs: PathBuf,
    pub godot: PathBuf,
    pub unity: PathBuf,
    pub studio: PathBuf,
    /// What the builder added to it.
    pub extra: Vec<works::Work>,
}

impl Native {
    /// In a folder, by their names.
    fn within(folder: &Path, extra: Vec<works::Work>) -> Self {
        Self {
            command: folder.join("lumivox"),
            codecs: folder.join("lumivox-codecs"),
            godot: folder.join("liblumivox_godot.so"),
            unity: folder.join("liblumivox_unity.so"),
            studio: folder.join("lumivox-studio"),
            extra,
        }
    }

    /// Taken from a folder as they are, without symbols: for tests, which pack what is built anyway.
    pub fn taken(from: &Path, staging: &Path) -> Result<Self, String> {
        make_empty(staging)?;
        let (there, taken) = (Self::within(from, vec![]), Self::within(staging, vec![]));
        for (file, copy) in there.files().into_iter().zip(taken.files()) {
            if file.is_file() {
                fs::copy(file, copy).map_err(|error| format!("{}: {error}", file.display()))?;
                run(Command::new("strip").arg(copy))?;
            }
        }
        Ok(taken)
    }

    fn files(&self) -> [&PathBuf; 5] {
        [&self.command, &self.codecs, &self.godot, &self.unity, &self.studio]
    }

    /// Built for people, against an old glibc: all but the Studio, the Studio, or both.
    pub fn built(root: &Path, has_others: bool, has_studio: bool) -> Result<Self, String> {
        let tools = Tools::installed(root)?;
        let target = target_folder(root);
        println!("building for {LINUX}, glibc 2.28");
        let selections = [(has_others, &PACKAGES[..]), (has_studio, &STUDIO)];
        for (_, packages) in selections.iter().filter(|(is_wanted, _)| *is_wanted) {
            let mut cargo = Command::new("cargo");
            cargo.args(["zigbuild", "--locked", "--quiet", "--profile", "dist", "--lib", "--bins"]);
            cargo.args(["--target", &format!("{LINUX}.2.28")]);
            cargo.args(packages.iter().flat_map(|name| ["--package", name])).current_dir(root);
            tools.prepare(&mut cargo, root)?;
            run(&mut cargo)?;
        }
        let native = Self::within(&target.join(LINUX).join("dist"), vec![tools.cxx()?]);
        let [home, cargo_home] = homes();
        let (others, studio) = (&native.files()[..4], [&native.studio]);
        let wanted = [(has_others, others), (has_studio, &studio)];
        for file in wanted.into_iter().filter(|(is_wanted, _)| *is_wanted).flat_map(|(_, files)| files) {
            binaries::check_glibc(file)?;
            binaries::check_paths(file, &[root, &target, &home, &cargo_home])?;
        }
        Ok(native)
    }
}

/// Zig, by which an old glibc is linked against, in an environment of its own.
pub struct Tools {
    bin: PathBuf,
}

impl Tools {
    /// Installs them where they are not there, as `python/requirements-wheel.txt` says.
    pub fn installed(root: &Path) -> Result<Self, String> {
        let folder = target_folder(root).join("package-tools");
        let (wanted, known) = (root.join("python/requirements-wheel.txt"), folder.join("made-of.txt"));
        let wants = super::read(&wanted)?;
        if fs::read_to_string(&known).ok().as_ref() != Some(&wants) {
            println!("installing Zig, which links against an old glibc (once; 100 MB)");
            make_empty(&folder)?;
            run(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
            let mut pip = Command::new(folder.join("bin/python"));
            pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"]).arg(&wanted);
            run(&mut pip)?;
            super::write(&known, wants.as_bytes())?;
        }
        Ok(Self { bin: folder.join("bin") })
    }

    /// The C++ library that comes with it.
    fn cxx(&self) -> Result<works::Work, String> {
        let said = Command::new(self.bin.join("python"))
            .args(["-c", "import ziglang, importlib.metadata as m; print(ziglang.__path__[0]); print(m.version('ziglang'))"])
            .output()
            .map_err(|error| format!("{}: {error}", self.bin.display()))?;
        let said = String::from_utf8_lossy(&said.stdout).into_owned();
        let (folder, version) = said.trim().split_once('\n').ok_or("there is no ziglang")?;
        works::cxx_of_zig(Path::new(folder), version)
    }

    /// Has a build find them, and say nothing of where it was made.
    pub fn prepare(&self, command: &mut Command, root: &Path) -> Result<(), String> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let path = std::env::join_paths([self.bin.clone()].into_iter().chain(std::env::split_paths(&path)));
        command.env("PATH", path.map_err(|error| error.to_string())?);
        same_bytes(command, root)?;
        // What C compilers write where a program asks for the date of its build. By the commit's, all decoders and what they are
        // linked into would be built anew after each.
        command.env("SOURCE_DATE_EPOCH", super::NO_DATE.to_string());
        Ok(())
    }
}

/// Has a build of `root` make what it makes in any other folder.
pub fn same_bytes(command: &mut Command, root: &Path) -> Result<(), String> {
    let [_, cargo_home] = homes();
    // Of several that match, the last holds: what is built lies within the tree mostly.
    let folders = [
        (root.to_owned(), "lumivox"),
        (cargo_home.join("registry/src"), "crates"),
        (target_folder(root), "target"),
    ];
    let (mut rust, mut c) = (flags("RUSTFLAGS"), [flags("CFLAGS"), flags("CXXFLAGS")]);
    for (folder, name) in folders {
        let folder = folder.to_str().filter(|folder| !folder.contains(' '));
        let folder =
            folder.ok_or("a build that names no folder is not possible in one with a space in its name")?;
        rust.push(format!(" --remap-path-prefix={folder}=/{name}"));
        c.iter_mut().for_each(|flags| flags.push(format!(" -ffile-prefix-map={folder}=/{name}")));
    }
    let [c, cxx] = c;
    command.env("RUSTFLAGS", rust).env("CFLAGS", c).env("CXXFLAGS", cxx);
    command.env("SOURCE_DATE_EPOCH", super::date(root)?.to_string());
    Ok(())
}

fn flags(name: &str) -> OsString {
    std::env::var_os(name).unwrap_or_default()
}

/// The person's home, and Cargo's.
fn homes() -> [PathBuf; 2] {
    let home = PathBuf::from(std::env::var_os("HOME").unwrap_or_default());
    let cargo = std::env::var_os("CARGO_HOME").map_or_else(|| home.join(".cargo"), PathBuf::from);
    [home, cargo]
}
