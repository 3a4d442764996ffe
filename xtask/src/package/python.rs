//! The wheel and the sources of the Python package: `cargo xtask package python`.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::{VERSION, build, run};

/// Makes the wheel, one for Python 3.10 and newer on Linux of glibc 2.28 and newer, and an archive of its sources; returns their
/// names.
pub fn make(root: &Path, out: &Path) -> Result<Vec<String>, String> {
    let out = std::path::absolute(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let mut script = Command::new(root.join("script/python"));
    script.arg("--wheel-only").arg(&out);
    build::same_bytes(&mut script, root)?;
    run(&mut script)?;
    let made = fs::read_dir(&out).map_err(|error| format!("{}: {error}", out.display()))?.flatten();
    let mut names: Vec<_> = made.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    let wheel = format!("lumivox-{VERSION}-cp310-abi3-");
    names.retain(|name| name.starts_with(&wheel) || *name == format!("lumivox-{VERSION}.tar.gz"));
    match names.iter().any(|name| name.ends_with(".whl")) {
        true => Ok(names),
        false => Err(format!("no wheel of version {VERSION} is in {}", out.display())),
    }
}
