//! Whether the command for Windows does what this system's does: the same exit codes, words and files, to the last byte.
//! `script/windows` makes the one, and runs both.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Scans, pictures, documents and mistakes, of files that they make themselves: each line one run of the command. Later ones
/// read what earlier ones wrote.
const OWN: &str = "\
--version
--help
render --help
presets
phantom head --size 64 --quiet --out scans/head
phantom torso --size 96 --quiet --out scans/torso
phantom torso --size 48 --metal pacemaker --arms sides --breasts --blanket --tilt 7 --padding --quiet --out scans/metal
phantom torso-pet --size 48 --quiet --out scans/pet
phantom mr-head --size 48 --seed 3 --quiet --out scans/mr-head
phantom mr-brain --size 48 --quiet --out scans/mr-brain
phantom cube --size 32 --quiet --out scans/cube
phantom sphere --size 32 --quiet --out scans/sphere
import scans
import --json scans
import --json --thumbnails pictures --thumbnail-size 24 scans
info scans/head
info --json scans/torso scans/pet
info --json scans/mr-head
render scans/head -o head.png --size 96x96 --samples 4 --azimuth 35 --quiet
render scans/head -o bone.png --size 64x48 --samples 2 --preset ct-bone --seed 5 --quiet
render scans/torso -o torso.png --size 64x64 --samples 2 --quiet
render scans/torso scans/pet -o fused.png --size 48x48 --samples 2 --quiet
render scans/mr-brain -o brain.png --size 48x48 --samples 2 --denoise --quiet
scene save scene.lumivox scans/head --azimuth 35 --size 48x48 --samples 2
scene check scene.lumivox
render scene.lumivox -o scene.png --quiet
render
render scans/head -o head.txt
render scans/head -o head.png --size 0x48
render scans/head -o no/folder/head.png --size 16x16 --samples 1 --quiet
render scans/head -o head.png --preset no-such-look
render scans/head -o head.png --no-such-option
info no-such-file
info scene.lumivox
import head.png
phantom head --size 7 --out scans/head
phantom head --size 16 --quiet --out scene.lumivox
scene check head.png";

/// Where people keep things: in paths of more than 260 characters, which Windows did not have for long, on another drive, and in
/// folders with spaces and umlauts.
const PLACES: &str = "\
phantom head --size 16 --quiet --out {long}/scan
import --json {long}
info --json {long}/scan
render {long}/scan -o {long}/head.png --size 32x32 --samples 1 --quiet
scene save {long}/scene.lumivox {long}/scan --size 24x32 --samples 1
render {long}/scene.lumivox -o {long}/scene.png --quiet
info {long}/none
phantom head --size 16 --quiet --out {drive}/scan
phantom cube --size 16 --quiet --out {drive}/{words}/cube
import --json {drive}/
info {drive}/{words}/cube
render {drive}/scan -o head-of-the-drive.png --size 32x32 --samples 1 --quiet
render {words}/head -o {drive}/{words}/head.png --size 32x32 --samples 1 --quiet
phantom head --size 16 --quiet --out {words}/head
render {words}/head -o {drive}/{words}/head.png --size 32x32 --samples 1 --quiet
phantom head --size 16 --quiet --out {drive}/case/scan
phantom cube --size 16 --quiet --out {drive}/case/{words}/cube
scene save {drive}/case/{words}/scene.lumivox {drive}/case/scan --size 24x32 --samples 1
scene check {drive}/case/{words}/scene.lumivox
render {drive}/case/{words}/scene.lumivox -o {words}/scene.png --quiet
scene save {drive}/{words}/far.lumivox {drive}/scan {words}/head --size 24x32 --samples 1
scene check {drive}/{words}/far.lumivox
render {drive}/{words}/far.lumivox -o {words}/far.png --quiet";

/// A scene of a scan on another drive has its whole path, which is another on each system; what is rendered of it is the same.
const FAR: &str = "far.lumivox";

/// As games and services run programs: without a console. Only exit codes and files can tell what became of it.
const DETACHED: &str = "\
--version
phantom head --size 16 --out detached/scan
info detached/scan
render detached/scan -o detached/head.png --size 32x32 --samples 1
render no-such-file -o detached/none.png
no-such-command";

/// What is enough to see that it renders, for those who wait.
const FIRST: &str = "\
--version
phantom head --size 32 --quiet --out scans/head
import --json scans
render scans/head -o head.png --size 48x48 --samples 2 --azimuth 35 --quiet
render no-such-file -o none.png";

/// Folders of the shared scans whose files are scans of their own.
const FOLDERS_OF_SCANS: [&str; 7] = ["bad", "cases", "nifti", "nrrd", "pydicom_files", "raw", "syntaxes"];

/// One of the two commands.
struct Side {
    /// What runs the program, where it does not run by itself.
    runner: Option<PathBuf>,
    program: PathBuf,
    /// Where it runs.
    folder: PathBuf,
    /// A folder somewhere else, and how the program calls it: on Windows, as a drive.
    drive: PathBuf,
    drive_name: String,
    /// On Windows, what runs it without a console.
    detached: Option<PathBuf>,
}

/// What a run left to see.
#[derive(Debug, PartialEq)]
struct Seen {
    exit: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Side {
    /// A copy of the program, which lies where many people's lie.
    fn new(runner: Option<PathBuf>, program: &Path, scratch: PathBuf) -> Result<Self, String> {
        let error = |path: &Path, error| format!("{}: {error}", path.display());
        let [folder, drive, programs] = ["here", "drive", WORDS].map(|name| scratch.join(name));
        for folder in [&folder, &drive, &programs] {
            fs::create_dir_all(folder).map_err(|e| error(folder, e))?;
        }
        let copy = programs.join(program.file_name().ok_or("the command has no name")?);
        fs::copy(program, &copy).map_err(|e| error(program, e))?;
        let drive_name = match (&runner, std::env::var_os("WINEPREFIX")) {
            (Some(_), Some(prefix)) => {
                let at = Path::new(&prefix).join("dosdevices").join(DRIVE);
                let _ = fs::remove_file(&at);
                link(&drive, &at)?;
                DRIVE.to_uppercase()
            }
            _ => drive.display().to_string(),
        };
        let detached = std::env::var_os("LUMIVOX_DETACHED").filter(|_| runner.is_some()).map(PathBuf::from);
        Ok(Self { runner, program: copy, folder, drive, drive_name, detached })
    }

    fn run(&self, words: &[String], manner: Manner) -> Result<Seen, String> {
        if manner == Manner::Detached && self.runner.is_some() && self.detached.is_none() {
            return Err("LUMIVOX_DETACHED names no program that runs others without a console".to_owned());
        }
        let first = [self.runner.as_ref(), self.detached.as_ref().filter(|_| manner == Manner::Detached)];
        let mut line = first.into_iter().flatten().chain([&self.program]);
        let mut command = Command::new(line.next().unwrap_or(&self.program));
        command.args(line).args(words.iter().map(|word| word.replace("{drive}", &self.drive_name)));
        command.current_dir(&self.folder).stdin(Stdio::null());
        let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
        let text = |bytes: &[u8]| match manner {
            Manner::Usual => String::from_utf8_lossy(bytes).replace(&self.drive_name, "{drive}"),
            // Windows' has nowhere to say it.
            Manner::Detached if self.runner.is_none() => String::new(),
            Manner::Detached => String::from_utf8_lossy(bytes).into_owned(),
        };
        Ok(Seen { exit: output.status.code(), stdout: text(&output.stdout), stderr: text(&output.stderr) })
    }

    /// What is in its files, whichever drive they are on.
    fn files(&self) -> Result<BTreeMap<PathBuf, Vec<u8>>, String> {
        let mut files = files_in(&self.folder)?;
        let there = files_in(&self.drive)?.into_iter();
        files.extend(there.map(|(path, bytes)| (Path::new("{drive}").join(path), bytes)));
        files.retain(|path, _| !path.ends_with(FAR));
        Ok(files)
    }
}

/// What Wine calls another drive, and a name as many folders of people have.
const DRIVE: &str = "x:";
const WORDS: &str = "Köpfe und Füße";

/// How the command is run.
#[derive(Clone, Copy, PartialEq)]
enum Manner {
    Usual,
    /// Without a console.
    Detached,
}

/// The words of a line, with what stands for a place filled in, but for the drive, which has another name on each side.
fn words(line: &str) -> Vec<String> {
    let long = ["l".repeat(120), "o".repeat(120), "ng".repeat(60)].join("/");
    line.split(' ').map(|word| word.replace("{long}", &long).replace("{words}", WORDS)).collect()
}

/// Compares the commands `here` and `windows`, which `LUMIVOX_WINE` names the runner of; on a few runs, or on all and on the
/// shared scans where they are.
pub fn compare(here: &Path, windows: &Path, all: bool) -> Result<(), String> {
    let wine = std::env::var_os("LUMIVOX_WINE").map(PathBuf::from);
    let scratch = std::env::temp_dir().join(format!("lumivox-windows-{}", std::process::id()));
    let sides =
        [Side::new(None, here, scratch.join("here"))?, Side::new(wine, windows, scratch.join("windows"))?];
    let runs_of = |lines: &str, manner| lines.lines().map(|line| (words(line), manner)).collect::<Vec<_>>();
    let mut runs = runs_of(if all { OWN } else { FIRST }, Manner::Usual);
    if all {
        runs.extend(runs_of(PLACES, Manner::Usual));
        runs.extend(runs_of(DETACHED, Manner::Detached));
    }
    let own = runs.len();
    if all {
        runs.extend(of_shared_scans(&sides)?);
    }
    let mut differences = vec![];
    for (at, (words, manner)) in runs.iter().enumerate() {
        let [here, windows] = [sides[0].run(words, *manner)?, sides[1].run(words, *manner)?];
        if let Some(what) = difference(here, windows) {
            println!("lumivox {}\n{what}", words.join(" "));
            differences.push(words.join(" "));
        }
        if at + 1 == own {
            println!("{own} runs on files of their own: {} differ", differences.len());
        }
    }
    let [here, windows] = [sides[0].files()?, sides[1].files()?];
    differences.extend(different_files(&here, &windows));
    if !differences.is_empty() {
        return Err(format!(
            "the command for Windows does something else, in {} cases; the files are in {}:\n  {}",
            differences.len(),
            scratch.display(),
            differences.join("\n  ")
        ));
    }
    println!(
        "{} runs of the command for Windows: exit codes, words and {} files are the same",
        runs.len(),
        here.len()
    );
    fs::remove_dir_all(&scratch).map_err(|error| error.to_string())
}

/// What tells the two apart.
fn difference(here: Seen, windows: Seen) -> Option<String> {
    let windows = Seen {
        exit: windows.exit,
        stdout: windows.stdout.replace("\r\n", "\n"),
        stderr: as_here(&windows.stderr.replace("\r\n", "\n")),
    };
    let here = Seen { stderr: as_here(&here.stderr), ..here };
    (here != windows).then(|| {
        let mut text = String::new();
        if here.exit != windows.exit {
            text += &format!("  exit codes: {:?} here, {:?} on Windows\n", here.exit, windows.exit);
        }
        for (name, here, windows) in
            [("stdout", &here.stdout, &windows.stdout), ("stderr", &here.stderr, &windows.stderr)]
        {
            let same = here.lines().zip(windows.lines()).take_while(|(a, b)| a == b).count();
            if here != windows {
                let [here, windows] =
                    [here, windows].map(|text| text.lines().nth(same).unwrap_or("(nothing)"));
                text += &format!("  {name} here:       {here}\n  {name} on Windows: {windows}\n");
            }
        }
        text
    })
}

/// Messages name files as the system does, and end with the system's own words, in whatever language. How long something took
/// is said where it took long: `reading headers: 1.1 s`.
fn as_here(messages: &str) -> String {
    let is_time = |line: &str| {
        let time = line.rsplit_once(": ").and_then(|(_, time)| time.strip_suffix(" s"));
        time.is_some_and(|seconds| seconds.parse::<f64>().is_ok())
    };
    let line = |line: &str| {
        let line = line.replace('\\', "/");
        match line.split_once(" (os error ") {
            Some((before, _)) => format!("{}\n", before.rsplit_once(": ").map_or(before, |(what, _)| what)),
            None => format!("{line}\n"),
        }
    };
    messages.lines().filter(|line| !is_time(line)).map(line).collect()
}

/// Runs that read the shared scans, by a link in the folders of both. A compressed one is read without a console, too: that takes a
/// process of its own.
fn of_shared_scans(sides: &[Side; 2]) -> Result<Vec<(Vec<String>, Manner)>, String> {
    let shared = crate::root()?.join("../shared/data");
    if !shared.is_dir() {
        println!("NOT RUN: the shared scans are not here");
        return Ok(vec![]);
    }
    let mut scans = vec![];
    for name in names_in(&shared)? {
        if FOLDERS_OF_SCANS.contains(&&*name) {
            scans.extend(names_in(&shared.join(&name))?.into_iter().map(|file| format!("{name}/{file}")));
        } else if shared.join(&name).is_dir() || name.ends_with(".zip") {
            scans.push(name);
        }
    }
    let shared = fs::canonicalize(&shared).map_err(|error| error.to_string())?;
    for side in sides {
        link(&shared, &side.folder.join("data"))?;
    }
    println!("{} of the shared scans are read by both", scans.len());
    let run = |scan: &String| vec!["info".to_owned(), "--json".to_owned(), format!("data/{scan}")];
    let mut runs: Vec<_> = scans.iter().map(|scan| (run(scan), Manner::Usual)).collect();
    let compressed = scans.iter().filter(|scan| scan.starts_with("syntaxes/"));
    runs.extend(compressed.take(3).map(|scan| (run(scan), Manner::Detached)));
    Ok(runs)
}

#[cfg(unix)]
fn link(to: &Path, at: &Path) -> Result<(), String> {
    std::os::unix::fs::symlink(to, at).map_err(|error| error.to_string())
}

#[cfg(not(unix))]
fn link(_: &Path, _: &Path) -> Result<(), String> {
    Err("commands are compared on Linux".into())
}

fn names_in(folder: &Path) -> Result<Vec<String>, String> {
    let error = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut names = vec![];
    for entry in fs::read_dir(folder).map_err(error)? {
        names.push(entry.map_err(error)?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// What is in the files below a folder, links left out.
fn files_in(folder: &Path) -> Result<BTreeMap<PathBuf, Vec<u8>>, String> {
    let (mut files, mut folders) = (BTreeMap::new(), vec![folder.to_owned()]);
    while let Some(at) = folders.pop() {
        for name in names_in(&at)? {
            let path = at.join(name);
            if path.is_symlink() {
            } else if path.is_dir() {
                folders.push(path);
            } else {
                let bytes = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
                files.insert(path.strip_prefix(folder).unwrap_or(&path).to_owned(), bytes);
            }
        }
    }
    Ok(files)
}

/// A line for each file that is not the same on both sides.
fn different_files(here: &BTreeMap<PathBuf, Vec<u8>>, windows: &BTreeMap<PathBuf, Vec<u8>>) -> Vec<String> {
    let mut lines = vec![];
    for (path, bytes) in here {
        let name = path.display();
        match windows.get(path) {
            None => lines.push(format!("{name} is not written on Windows")),
            Some(other) if other != bytes => {
                let count = bytes.iter().zip(other).filter(|(a, b)| a != b).count();
                lines.push(format!("{name} is another: {count} of {} bytes differ", bytes.len()));
            }
            Some(_) => {}
        }
    }
    let only = windows.keys().filter(|path| !here.contains_key(*path));
    lines.extend(only.map(|path| format!("{} is written on Windows only", path.display())));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(exit: i32, stdout: &str, stderr: &str) -> Seen {
        Seen { exit: Some(exit), stdout: stdout.into(), stderr: stderr.into() }
    }

    #[test]
    fn what_the_systems_say_themselves_is_no_difference() {
        let here = seen(3, "a\nb\n", "error: cannot read a/b: No such file or directory (os error 2)\n");
        let messages =
            "reading headers: 1.1 s\r\nerror: cannot read a\\b: Datei nicht gefunden. (os error 2)\r\n";
        let windows = seen(3, "a\r\nb\r\n", messages);
        assert_eq!(difference(here, windows), None);
    }

    #[test]
    fn other_exit_codes_words_and_files_are() {
        let here = || seen(3, "1 series\n", "error: no scan\n");
        let exit = difference(here(), seen(1, "1 series\n", "error: no scan\n")).unwrap();
        assert!(exit.contains("exit codes: Some(3) here, Some(1) on Windows"), "{exit}");
        // Paths on standard output are for programs, which read both systems'.
        for stdout in ["2 series\n", "1 series\nmore\n", ""] {
            assert!(difference(here(), seen(3, stdout, "error: no scan\n")).unwrap().contains("stdout"));
        }
        assert!(difference(here(), seen(3, "1 series\n", "error: none\n")).unwrap().contains("error: none"));

        let files = |files: &[(&str, &[u8])]| {
            files.iter().map(|(name, bytes)| (PathBuf::from(name), bytes.to_vec())).collect()
        };
        let here = files(&[("a", b"same"), ("b", b"0123"), ("c", b"")]);
        let lines = different_files(&here, &files(&[("a", b"same"), ("b", b"0129"), ("d", b"")]));
        assert_eq!(
            lines,
            [
                "b is another: 1 of 4 bytes differ",
                "c is not written on Windows",
                "d is written on Windows only"
            ]
        );
        assert!(different_files(&here, &here).is_empty());
    }
}
