//! The guide's commands work: the `sh` blocks of each page run one after the other in an empty folder, with this command
//! first on the PATH. Blocks in other languages need something else (an engine, a scan of the reader's): they are not run.
#![cfg(unix)]

use std::{
    collections::BTreeSet,
    env,
    ffi::OsString,
    fs::{self, File},
    iter,
    path::{Path, PathBuf},
    process::{Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

/// Far more than any block takes in software, far less than forever.
const LIMIT: Duration = Duration::from_secs(120);

/// Where links go that leave the guide, so that they work in the book as well.
const REPOSITORY: &str = "https://github.com/lumivox/lumivox/";

/// A test for each page that shows the command.
macro_rules! pages {
    ($($test:ident: $page:literal,)*) => {
        const PAGES: &[&str] = &[$($page),*];
        $(
            #[test]
            fn $test() {
                run_page($page);
            }
        )*
    };
}

pages! {
    first_picture: "first-picture.md",
    your_own_scan: "your-own-scan.md",
    looks: "looks.md",
    cutting: "cutting.md",
    labels: "labels.md",
    pet_and_fusion: "pet-and-fusion.md",
    scene_files: "scene-files.md",
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn guide() -> PathBuf {
    repository().join("docs/guide/src")
}

fn read(page: &str) -> String {
    fs::read_to_string(guide().join(page)).unwrap_or_else(|error| panic!("{page}: {error}"))
}

/// The names of all pages.
fn pages() -> BTreeSet<String> {
    let entries = fs::read_dir(guide()).expect("the guide is there");
    let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    names.filter(|name| name.ends_with(".md")).collect()
}

/// Text between fences.
struct Block<'a> {
    /// Of the fence before it, counted from 1.
    line: usize,
    language: &'a str,
    text: String,
}

fn blocks(page: &str) -> Vec<Block<'_>> {
    let mut blocks = Vec::new();
    let mut lines = page.lines().zip(1..);
    while let Some((fence, line)) = lines.next() {
        if let Some(language) = fence.strip_prefix("```") {
            let inside = lines.by_ref().map(|(text, _)| text).take_while(|text| *text != "```");
            let text = inside.collect::<Vec<_>>().join("\n");
            blocks.push(Block { line, language, text });
        }
    }
    blocks
}

/// The PATH with the folder of this command before all others.
fn search_path() -> OsString {
    let program = Path::new(env!("CARGO_BIN_EXE_lumivox"));
    let folder = program.parent().expect("a program lies in a folder").to_path_buf();
    let others = env::var_os("PATH").unwrap_or_default();
    env::join_paths(iter::once(folder).chain(env::split_paths(&others)))
        .expect("no folder has a ':' in its name")
}

/// Runs a block, which writes what it says to `said`; nothing where it took too long.
fn run(block: &Block, folder: &Path, said: &Path) -> Option<ExitStatus> {
    let output = File::create(said).expect("a file for what it says");
    let mut child = Command::new("sh")
        .args(["-e", "-x", "-c", &block.text])
        .current_dir(folder)
        .env("PATH", search_path())
        .stdin(Stdio::null())
        .stdout(output.try_clone().expect("the file again"))
        .stderr(output)
        .spawn()
        .expect("sh runs");
    let begin = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("it can be waited for") {
            return Some(status);
        }
        if begin.elapsed() > LIMIT {
            child.kill().expect("it can be ended");
            child.wait().expect("it has ended");
            return None;
        }
        thread::sleep(Duration::from_millis(10));
    }
}

fn run_page(name: &str) {
    let page = read(name);
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let beside = tempfile::tempdir().expect("a folder for temporary files");
    let said = beside.path().join("said.txt");
    let blocks: Vec<Block> = blocks(&page).into_iter().filter(|block| block.language == "sh").collect();
    assert!(!blocks.is_empty(), "docs/guide/src/{name} has no block of commands");
    for block in blocks {
        let status = run(&block, folder.path(), &said);
        let what = match status {
            Some(status) if status.success() => continue,
            Some(status) => status.to_string(),
            None => format!("not done after {} s", LIMIT.as_secs()),
        };
        let said = String::from_utf8_lossy(&fs::read(&said).expect("what it said")).into_owned();
        panic!("docs/guide/src/{name}, the block of line {}: {what}\n{said}", block.line);
    }
}

#[test]
fn every_page_with_commands_is_run_and_every_block_says_what_it_is() {
    let mut with_commands = BTreeSet::new();
    for name in pages() {
        let page = read(&name);
        for block in blocks(&page) {
            let Block { line, language, .. } = block;
            assert!(
                ["sh", "text", "console", "python", "js"].contains(&language),
                "docs/guide/src/{name}, line {line}: sh, text, console, python or js, not '{language}'"
            );
            if language == "sh" {
                with_commands.insert(name.clone());
            }
        }
    }
    let run: BTreeSet<String> = PAGES.iter().map(|&page| page.to_owned()).collect();
    assert_eq!(with_commands, run);
}

#[test]
fn every_page_is_in_the_summary_and_every_link_leads_somewhere() {
    let summary = read("SUMMARY.md");
    for name in pages() {
        assert!(
            name == "SUMMARY.md" || summary.contains(&format!("({name})")),
            "{name} is not in SUMMARY.md"
        );
        let page = read(&name);
        for (link, _) in page.split("](").skip(1).filter_map(|rest| rest.split_once(')')) {
            let target = link.split('#').next().unwrap_or(link);
            let path = if let Some(place) = target.strip_prefix(REPOSITORY) {
                let kinds = ["blob/main/", "tree/main/", "raw/main/"];
                let path = kinds.iter().find_map(|kind| place.strip_prefix(kind));
                repository().join(path.unwrap_or_else(|| panic!("docs/guide/src/{name}: {link}")))
            } else if target.contains("://") {
                continue;
            } else {
                guide().join(target)
            };
            assert!(path.exists(), "docs/guide/src/{name}: nothing is at {link}");
        }
    }
}
