//! What CI runs, in the order that fails soonest.

use std::{
    ffi::OsString,
    io::{BufRead, BufReader},
    path::Path,
    process::Command,
    time::Instant,
};

use crate::{layers, unity_kernels, unity_metas};

/// Runs every check; stops at the first that fails.
pub fn run() -> Result<(), String> {
    step("format", || cargo(&["fmt", "--all", "--check"]))?;
    step("import rules", layers::run)?;
    step("Unity's kernels", unity_kernels::check)?;
    step("Unity's identifiers", unity_metas::check)?;
    step("clippy", || {
        cargo(&["clippy", "--workspace", "--all-targets", "--release", "--quiet", "--", "-D", "warnings"])
    })?;
    let mut summaries = step("tests", tests)?;
    summaries.extend(step("Python", python)?);
    step("examples", examples)?;
    step("documentation", documentation)?;
    step("packages", packages)?;
    step("licences and sources", deny)?;

    println!("\n== results of the test runners");
    for Summary { suite, result } in &summaries {
        println!("{result}  [{suite}]");
    }
    let counts = Counts::parse_all(&summaries);
    println!("all suites: {} passed; {} failed; {} ignored", counts.passed, counts.failed, counts.ignored);
    Ok(())
}

fn step<T>(name: &str, work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    println!("\n== {name}");
    let start = Instant::now();
    let result = work().map_err(|error| format!("{name}: {error}"));
    println!("== {name}: {} in {:.0?}", if result.is_ok() { "ok" } else { "FAILED" }, start.elapsed());
    result
}

fn cargo_command(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments);
    command
}

fn finish(command: &mut Command) -> Result<(), String> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{command:?}: {status}")),
        Err(error) => Err(format!("{command:?}: {error}")),
    }
}

fn cargo(arguments: &[&str]) -> Result<(), String> {
    finish(&mut cargo_command(arguments))
}

/// The examples, which are the manual. The window is small, and on a display that nobody sees where there is a program
/// for that.
fn examples() -> Result<(), String> {
    ["hello_volume", "fake_device"]
        .iter()
        .try_for_each(|name| cargo(&["run", "--release", "--quiet", "--example", name]))?;
    cargo(&["build", "--release", "--quiet", "--package", "lumivox-window"])?;
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    let program = Path::new(&target).join("release").join("lumivox-window");
    let screenshot = std::env::temp_dir().join("lumivox_window.png");
    // One of another run tells nothing.
    let _ = std::fs::remove_file(&screenshot);
    let has_xvfb = Command::new("xvfb-run").arg("--help").output().is_ok();
    let mut command = if has_xvfb { Command::new("xvfb-run") } else { Command::new(&program) };
    if has_xvfb {
        command.args(["--auto-servernum", "--server-args=-screen 0 640x480x24"]).arg(&program);
    }
    command.args(["--size", "320x240", "--frames", "4", "--screenshot"]).arg(&screenshot);
    finish(&mut command)?;
    match screenshot.metadata() {
        Ok(file) if file.len() > 0 => Ok(()),
        _ => Err(format!("{} was not written", screenshot.display())),
    }
}

/// Public documentation with warnings as errors: a link that leads nowhere fails.
fn documentation() -> Result<(), String> {
    let mut flags = std::env::var_os("RUSTDOCFLAGS").unwrap_or_default();
    flags.push(OsString::from(" -D warnings"));
    let arguments = ["doc", "--workspace", "--no-deps", "--release", "--quiet"];
    finish(cargo_command(&arguments).env("RUSTDOCFLAGS", flags))
}

/// The libraries as crates.io would take them, together. Not built again from there.
fn packages() -> Result<(), String> {
    let mut command = cargo_command(&["package", "--quiet", "--no-verify", "--allow-dirty", "--offline"]);
    finish(command.args(layers::LIBRARIES.iter().flat_map(|name| ["--package", name])))
}

/// `cargo deny`, where it is installed. Without advisories: those change with the calendar, not with the code, and
/// need the network.
fn deny() -> Result<(), String> {
    let installed = cargo_command(&["deny", "--version"]).output().is_ok_and(|out| out.status.success());
    if !installed {
        println!("NOT RUN: cargo-deny is not installed (cargo install --locked cargo-deny)");
        return Ok(());
    }
    cargo(&["deny", "--workspace", "check", "bans", "licenses", "sources"])
}

/// The last line of one test runner.
#[derive(Debug, PartialEq)]
struct Summary {
    /// What was tested, as Cargo names it.
    suite: String,
    /// The runner's own words: `test result: ok. 3 passed; ...`.
    result: String,
}

/// Unit, integration and documentation tests of the workspace. All run, even after a failure.
fn tests() -> Result<Vec<Summary>, String> {
    let error = |error: std::io::Error| error.to_string();
    // Cargo names the suite on stderr, the runner reports on stdout: one pipe keeps their order.
    let (reader, writer) = std::io::pipe().map_err(error)?;
    let mut command = cargo_command(&["test", "--workspace", "--release", "--no-fail-fast"]);
    command.stdout(writer.try_clone().map_err(error)?).stderr(writer);
    let mut child = command.spawn().map_err(error)?;
    // The command holds our ends of the pipe, which would never run dry.
    drop(command);
    let mut summaries = Vec::new();
    let mut suite = String::new();
    for line in BufReader::new(reader).split(b'\n') {
        let line = line.map_err(error)?;
        let line = String::from_utf8_lossy(&line);
        println!("{line}");
        read_line(line.trim(), &mut suite, &mut summaries);
    }
    let status = child.wait().map_err(error)?;
    if !status.success() {
        let failed: Vec<_> = summaries.iter().filter(|s| !s.result.starts_with("test result: ok")).collect();
        let lines: Vec<_> = failed.iter().map(|s| format!("\n  {}  [{}]", s.result, s.suite)).collect();
        return Err(format!("cargo test: {status}{}", lines.concat()));
    }
    if Counts::parse_all(&summaries).passed == 0 {
        return Err("no test ran".into());
    }
    Ok(summaries)
}

/// The Python package in environments of its own. Its tests compare with the command, which the tests before built.
fn python() -> Result<Option<Summary>, String> {
    if cfg!(windows) {
        println!("NOT RUN: script/python needs a shell");
        return Ok(None);
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    let command = std::path::absolute(Path::new(&target).join("release").join("lumivox"));
    let mut child = Command::new("script/python")
        .env("LUMIVOX_COMMAND", command.map_err(|error| error.to_string())?)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .map_err(|error| format!("script/python: {error}"))?;
    let mut last = String::new();
    for line in BufReader::new(child.stdout.take().expect("a pipe")).lines() {
        let line = line.map_err(|error| error.to_string())?;
        println!("{line}");
        last = line;
    }
    let status = child.wait().map_err(|error| error.to_string())?;
    // pytest's own words: `93 passed in 41.20s`.
    let result = last.trim_matches(['=', ' ']).to_owned();
    if !status.success() {
        return Err(format!("script/python: {status}: {result}"));
    }
    if Counts::parse(&result).passed == 0 {
        return Err("no Python test ran".into());
    }
    Ok(Some(Summary { suite: "pytest".into(), result }))
}

fn read_line(line: &str, suite: &mut String, summaries: &mut Vec<Summary>) {
    if let Some(running) = line.strip_prefix("Running ").or_else(|| line.strip_prefix("Doc-tests ")) {
        // `unittests src/lib.rs (target/release/deps/lumivox_core-0123)`
        let name = running.rsplit_once("deps/").map_or(running, |(_, file)| file.trim_end_matches(')'));
        let name = name.rsplit_once('-').map_or(name, |(name, _hash)| name);
        let kind = if line.starts_with("Doc-tests") { " (documentation)" } else { "" };
        *suite = format!("{name}{kind}");
    } else if line.starts_with("test result: ") {
        summaries.push(Summary { suite: suite.clone(), result: line.to_owned() });
    }
}

#[derive(Debug, Default, PartialEq)]
struct Counts {
    passed: u64,
    failed: u64,
    ignored: u64,
}

impl Counts {
    fn parse(result: &str) -> Self {
        let mut words = result.split([' ', ';', ',']).filter(|word| !word.is_empty()).peekable();
        let mut counts = Self::default();
        while let Some(word) = words.next() {
            let (Ok(number), Some(what)) = (word.parse(), words.peek()) else { continue };
            match *what {
                "passed" => counts.passed = number,
                "failed" => counts.failed = number,
                "ignored" => counts.ignored = number,
                _ => {}
            }
        }
        counts
    }

    fn parse_all(summaries: &[Summary]) -> Self {
        summaries.iter().map(|summary| Self::parse(&summary.result)).sum()
    }
}

impl std::iter::Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(items: I) -> Self {
        items.fold(Self::default(), |a, b| Self {
            passed: a.passed + b.passed,
            failed: a.failed + b.failed,
            ignored: a.ignored + b.ignored,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_carry_the_suite_they_belong_to() {
        let mut summaries = Vec::new();
        let mut suite = String::new();
        for line in [
            "Running unittests src/lib.rs (target/release/deps/lumivox_core-84a3f9a7bd3f1a2b)",
            "test camera::tests::a ... ok",
            "test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.12s",
            "Doc-tests lumivox_core",
            "test result: FAILED. 1 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.00s",
        ] {
            read_line(line, &mut suite, &mut summaries);
        }
        let suites: Vec<_> = summaries.iter().map(|s| s.suite.as_str()).collect();
        assert_eq!(suites, ["lumivox_core", "lumivox_core (documentation)"]);
        let python = Counts { passed: 47, failed: 1, ignored: 0 };
        assert_eq!(Counts::parse("1 failed, 47 passed in 6.40s"), python);
        assert_eq!(Counts::parse_all(&summaries), Counts { passed: 4, failed: 2, ignored: 1 });
    }
}
