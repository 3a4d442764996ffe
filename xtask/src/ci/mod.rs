//! What CI runs, in the order that fails soonest.

mod lanes;
mod suites;
mod summary;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use self::lanes::{Done, Job, capture};
use self::summary::{Counts, Summary};
use crate::{layers, unity_border, unity_kernels, unity_metas};

/// Jobs that take long, the longest first: begun last, one of them would go on when nothing else does.
const LONGEST_FIRST: [&str; 17] = [
    "engine",
    "package",
    "gpu",
    "other systems",
    "Python",
    "studio",
    "documentation",
    "documentation tests",
    "packages",
    "lumivox_phantom",
    "reflection",
    "guide",
    "physics",
    "scene",
    "border under valgrind",
    "organs",
    "torso",
];

/// Which tests are run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scope {
    /// Of slow ones, none: what they test has quick tests, too, of less.
    Usual,
    /// Every one.
    All,
}

/// Runs every check; stops at the first that fails, but for the tests, which all run.
pub fn run(scope: Scope) -> Result<(), String> {
    let programs = Programs::new()?;
    step("format", || cargo(&["fmt", "--all", "--check"]))?;
    step("import rules", layers::run)?;
    step("Unity's border", unity_border::check)?;
    step("Unity's kernels", unity_kernels::check)?;
    step("Unity's identifiers", unity_metas::check)?;
    // In CI, by script/ci/rustc-and-lints; elsewhere apart, and what is compiled serves for all else.
    let wrapper = std::env::var_os("RUSTC_WORKSPACE_WRAPPER").map(PathBuf::from);
    let is_looked_through = wrapper.is_some_and(|path| path.ends_with("script/ci/rustc-and-lints"));
    if !is_looked_through {
        step("clippy", || {
            cargo(&["clippy", "--workspace", "--all-targets", "--release", "--quiet", "--", "-D", "warnings"])
        })?;
    }
    let name = if is_looked_through { "compiling, clippy and documentation" } else { "compiling" };
    let mut jobs = step(name, || {
        let jobs = suites::build(scope, &programs)?;
        let others = ["build", "--workspace", "--release", "--quiet", "--bins", "--examples"];
        cargo(&[&others[..], if is_looked_through { &["--benches"] } else { &[] }].concat())?;
        Ok(jobs)
    })?;
    jobs.push(python(&programs, scope));
    if !is_looked_through {
        jobs.push(Job::of("documentation", documentation()));
    }
    jobs.extend(examples(&programs));
    jobs.push(other_systems(scope, &programs));
    let place = |job: &Job| LONGEST_FIRST.iter().position(|name| *name == job.name);
    jobs.sort_by_key(|job| place(job).unwrap_or(LONGEST_FIRST.len()));
    let summaries = step("tests and examples", || run_all(jobs))?;
    step("packages", packages)?;
    step("licences and sources", deny)?;

    println!("\n== results of the test runners");
    for Summary { suite, result } in &summaries {
        println!("{result}  [{suite}]");
    }
    let counts = Counts::parse_all(&summaries);
    println!("all suites: {} passed; {} failed; {} ignored", counts.passed, counts.failed, counts.ignored);
    match scope {
        Scope::Usual => {
            println!("Slow tests are among the ignored ones: `script/test --all` runs them, too.")
        }
        Scope::All => println!("Slow tests ran, too."),
    }
    Ok(())
}

/// Runs the jobs, and gathers what their runners say.
fn run_all(jobs: Vec<Job>) -> Result<Vec<Summary>, String> {
    let done = lanes::run(jobs);
    let summaries: Vec<_> = done.iter().flat_map(|done| summary::find(&done.name, &done.output)).collect();
    let failed: Vec<&Done> = done.iter().filter(|done| done.failure.is_some()).collect();
    if !failed.is_empty() {
        let line = |done: &&Done| {
            let results = summary::find(&done.name, &done.output);
            let last = results.last().map_or("", |summary| &summary.result);
            format!("\n  {}: {}  {last}", done.name, done.failure.as_deref().unwrap_or_default())
        };
        return Err(format!("{} failed:{}", failed.len(), failed.iter().map(line).collect::<String>()));
    }
    if Counts::parse_all(&summaries).passed == 0 {
        return Err("no test ran".into());
    }
    Ok(summaries)
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

/// Where programs are by now, or will be.
struct Programs {
    /// This one, for scripts that would build it.
    xtask: PathBuf,
    /// The folder of the others.
    built: PathBuf,
}

impl Programs {
    fn new() -> Result<Self, String> {
        let error = |error: std::io::Error| error.to_string();
        let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
        let built = std::path::absolute(Path::new(&target).join("release")).map_err(error)?;
        Ok(Self { xtask: std::env::current_exe().map_err(error)?, built })
    }
}

/// The examples, which are the manual. The window is small, and on a display that nobody sees where there is a program
/// for that.
fn examples(programs: &Programs) -> Vec<Job> {
    let example = |name| {
        let program = programs.built.join("examples").join(name);
        Job::of(format!("example {name}"), Command::new(program))
    };
    let [program, command] = ["lumivox-window", "lumivox"].map(|name| programs.built.join(name));
    let window = Job::new("example window", move |output| window_example(&program, &command, output));
    vec![example("hello_volume"), example("fake_device"), window]
}

/// A scene of the command's in the window, which saves it: the command renders what was saved to the same pixels.
fn window_example(program: &Path, command: &Path, output: &mut String) -> Result<(), String> {
    let error = |error: std::io::Error| error.to_string();
    let folder = std::env::temp_dir().join(format!("lumivox-window-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(error)?;
    let file = |name: &str| folder.join(name);
    let lumivox = |arguments: &[&str], output: &mut String| {
        capture(Command::new(command).args(arguments).current_dir(&folder), output)
    };
    lumivox(&["phantom", "head", "--size", "32", "--out", "scan"], output)?;
    let scene =
        ["scene", "save", "scene.lumivox", "scan", "--azimuth", "35", "--size", "320x240", "--samples", "2"];
    lumivox(&scene, output)?;
    let has_xvfb = Command::new("xvfb-run").arg("--help").output().is_ok();
    let mut window = if has_xvfb { Command::new("xvfb-run") } else { Command::new(program) };
    if has_xvfb {
        window.args(["--auto-servernum", "--server-args=-screen 0 640x480x24"]).arg(program);
    }
    window.arg(file("scene.lumivox")).args(["--size", "320x240", "--frames", "4"]);
    window.arg("--screenshot").arg(file("window.png")).arg("--save").arg(file("saved.lumivox"));
    capture(&mut window, output)?;
    if file("window.png").metadata().map_err(error)?.len() == 0 {
        return Err(format!("{} is empty", file("window.png").display()));
    }
    for name in ["scene", "saved"] {
        lumivox(&["render", &format!("{name}.lumivox"), "-o", &format!("{name}.png")], output)?;
    }
    let [scene, saved] = ["scene.png", "saved.png"].map(|name| std::fs::read(file(name)));
    if scene.map_err(error)? != saved.map_err(error)? {
        return Err(format!("the window saved another picture: see {}", folder.display()));
    }
    std::fs::remove_dir_all(&folder).map_err(error)
}

/// Whether what browsers and Windows would compile does, by one compiler that is fetched, into a folder of its own, and the Studio's page
/// shows something in a browser. Where all is tested, the page and the npm package are made as they are shipped and tried, too, the
/// browser's compiler judges every kernel, and `script/test` has made what is for Windows.
fn other_systems(scope: Scope, programs: &Programs) -> Job {
    let is_linux = cfg!(target_os = "linux");
    let is_usual_linux = is_linux && cfg!(target_arch = "x86_64");
    let script = |words: &[&str]| {
        let mut command = Command::new(words[0]);
        command.args(&words[1..]);
        command.env("LUMIVOX_XTASK", &programs.xtask).env("LUMIVOX_COMMAND", programs.built.join("lumivox"));
        command
    };
    // Where no browser is fetched, it is only looked whether what is for them compiles.
    let of_browsers = if is_usual_linux { &["script/wasm", "--smoke"][..] } else { &["script/wasm"] };
    let mut scripts = vec![(is_linux, script(of_browsers))];
    match scope {
        Scope::Usual => scripts.push((is_usual_linux, script(&["script/windows", "--check"]))),
        Scope::All => {
            scripts.push((is_usual_linux, script(&["script/studio", "--web", "--test"])));
            scripts.push((is_usual_linux, script(&["script/js", "--test"])));
            scripts.push((is_usual_linux, script(&["script/wasm", "--kernels"])));
        }
    }
    Job::new("other systems", move |output| {
        for (is_run, mut command) in scripts {
            match is_run {
                true => capture(&mut command, output)?,
                false => {
                    *output +=
                        &format!("NOT RUN: {command:?}, which finds its compilers on Linux by itself\n")
                }
            }
        }
        Ok(())
    })
}

/// Public documentation with warnings as errors: a link that leads nowhere fails.
fn documentation() -> Command {
    let mut flags = std::env::var_os("RUSTDOCFLAGS").unwrap_or_default();
    flags.push(OsString::from(" -D warnings"));
    let mut command = cargo_command(&["doc", "--workspace", "--no-deps", "--release", "--quiet"]);
    command.env("RUSTDOCFLAGS", flags);
    command
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

/// The Python package in environments of its own. Its tests compare with the command.
fn python(programs: &Programs, scope: Scope) -> Job {
    let mut command = Command::new("script/python");
    command.env("LUMIVOX_COMMAND", programs.built.join("lumivox"));
    if scope == Scope::All {
        command.arg("--all");
    }
    Job::new("Python", move |output| {
        if cfg!(windows) {
            output.push_str("NOT RUN: script/python needs a shell\n");
            return Ok(());
        }
        capture(&mut command, output)?;
        let summaries = summary::find("Python", output);
        if Counts::parse_all(&summaries).passed == 0 { Err("no Python test ran".into()) } else { Ok(()) }
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Packages of other people and their features, as a selection of the workspace's own has them.
    fn features(selection: &[&str]) -> BTreeSet<String> {
        let mut command = cargo_command(&["tree", "--locked", "--prefix", "none", "--format", "{p}|{f}"]);
        let output = command.args(selection).output().expect("cargo");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        // Our own have a path, and packages that were listed before a star.
        let lines = text.lines().map(|line| line.trim_end_matches(" (*)"));
        lines.filter(|line| !line.is_empty() && !line.contains('/')).map(str::to_owned).collect()
    }

    /// Else hundreds of crates would be compiled again: for programs without tests, documentation, and the wheel.
    #[test]
    fn what_is_compiled_for_tests_serves_for_all_else() {
        let tested = features(&["--workspace", "--edges", "all"]);
        assert!(tested.len() > 100, "{tested:?}");
        let wheel =
            ["--package", "lumivox-python", "--features", "like-the-workspace", "--edges", "normal,build"];
        for selection in [&["--workspace", "--edges", "normal,build"][..], &wheel] {
            let others = features(selection);
            let again: Vec<_> = others.difference(&tested).collect();
            assert!(
                again.is_empty(),
                "{selection:?} asks for fewer features: ask for those of the tests in \
                 crates/lumivox-testing/Cargo.toml and python/Cargo.toml, as others there: {again:?}"
            );
        }
    }

    /// `script/windows` makes all of one selection but the wheel, which maturin makes.
    #[test]
    fn the_wheel_for_windows_is_made_of_what_is_compiled_for_the_others() {
        let script = std::fs::read_to_string(crate::root().unwrap().join("script/windows")).unwrap();
        let (_, words) = script.split_once("\nbuild=(").unwrap();
        let words: Vec<&str> = words.split_once(')').unwrap().0.split_whitespace().collect();
        let packages = words.windows(2).filter(|pair| pair[0] == "--package").flatten().copied();
        let system = ["--target", "x86_64-pc-windows-gnu", "--edges", "normal,build"];
        let all = features(&system.into_iter().chain(packages).collect::<Vec<_>>());
        let wheel = ["--package", "lumivox-python", "--features", "like-the-windows-packages"];
        assert!(script.contains(wheel[3]) && all.len() > 100, "{all:?}");
        let wheel = features(&system.into_iter().chain(wheel).collect::<Vec<_>>());
        let again: Vec<_> = wheel.difference(&all).collect();
        assert!(
            again.is_empty(),
            "python/Cargo.toml asks for other features than the packages do: {again:?}"
        );
    }
}
