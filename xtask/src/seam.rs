//! Who asks the system for the time or for a thread, below the hosts: `lumivox_core::host` alone may, for a browser has no such
//! system. What is written in the sources is looked at, tests left out.

use std::fs;
use std::path::{Path, PathBuf};

/// The crates below the hosts.
const CRATES: [&str; 10] = [
    "core",
    "import",
    "phantom",
    "reference",
    "renderer",
    "scene",
    "segmentation",
    "shaders",
    "viewport",
    "wgpu",
];

/// What asks the system.
const ASKS: [&str; 10] = [
    "Instant::now",
    "SystemTime",
    "thread::spawn",
    "thread::Builder",
    "thread::scope",
    "thread::sleep",
    "available_parallelism",
    "rayon::spawn",
    "rayon::scope",
    "rayon::in_place_scope",
];

/// Who may.
const MAY: [&str; 2] = [
    "crates/lumivox-core/src/host.rs",
    // Where there are processes there are threads that watch them. A feature.
    "crates/lumivox-import/src/codec_worker.rs",
];

/// Checks this workspace.
pub fn run() -> Result<(), String> {
    let mut files = 0;
    let mut broken = vec![];
    for name in CRATES {
        for path in sources(Path::new("crates").join(format!("lumivox-{name}")).join("src"))? {
            let shown = path.to_string_lossy().replace('\\', "/");
            if MAY.contains(&shown.as_str()) {
                continue;
            }
            let text = fs::read_to_string(&path).map_err(|error| format!("{shown}: {error}"))?;
            broken.extend(asks(&text).map(|(line, what)| format!("{shown}:{line} has {what}")));
            files += 1;
        }
    }
    if broken.is_empty() {
        println!("seam: {files} files leave clock and threads to the host");
        return Ok(());
    }
    Err(format!(
        "clock and threads are the host's, by way of lumivox_core::host (docs/adr/0015):\n  {}",
        broken.join("\n  ")
    ))
}

/// Source files in a folder and those below, tests left out.
pub fn sources(folder: PathBuf) -> Result<Vec<PathBuf>, String> {
    let error = |error| format!("{}: {error}", folder.display());
    let mut found = vec![];
    for entry in fs::read_dir(&folder).map_err(error)? {
        let path = entry.map_err(error)?.path();
        if path.file_stem().is_some_and(|name| name == "tests") {
            continue;
        }
        if path.is_dir() {
            found.extend(sources(path)?);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// The lines, counted from 1, that ask the system, but for those of the tests at the end.
fn asks(text: &str) -> impl Iterator<Item = (usize, &'static str)> {
    let lines = text.lines().take_while(|line| *line != "mod tests {").enumerate();
    let code = lines.filter(|(_, line)| !line.trim_start().starts_with("//"));
    code.flat_map(|(at, line)| {
        ASKS.into_iter().filter(|what| line.contains(what)).map(move |what| (at + 1, what))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_asks_the_system_is_found_but_in_tests_and_comments() {
        let text = "//! Nobody calls `Instant::now` here.\nfn f() {\n    std::thread::spawn(g);\n    rayon::spawn_fifo(g);\n}\n\n\
                    #[cfg(test)]\nmod tests {\n    fn t() { Instant::now(); }\n}\n";
        assert_eq!(asks(text).collect::<Vec<_>>(), [(3, "thread::spawn"), (4, "rayon::spawn")]);
        assert_eq!(asks("let began = Moment::now();").count(), 0);
    }
}
