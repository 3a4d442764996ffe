//! The Unity package without Unity: its C# in what stands in for the engine, its kernels before Microsoft's compilers, its
//! native border under valgrind, and the package that people install, unpacked in an empty place.
//!
//! `script/unity` is the same for people. Nothing here skips: what a machine lacks is fetched, or it fails and says why.

use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use lumivox_core::{CancelToken, Progress};
use lumivox_phantom::TorsoOptions;

fn main() -> ExitCode {
    let (options, filters): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|argument| argument.starts_with('-'));
    // As libtest calls it.
    let scope = match options.iter().any(|option| option == "--include-ignored") {
        true => Scope::All,
        false => Scope::Usual,
    };
    let mut counts = Counts::default();
    let checks: [(&str, Check); 5] = [
        ("documentation", documentation),
        ("kernels", kernels),
        ("package", package),
        ("installed", installed),
        ("border", border),
    ];
    let named = |name: &str| filters.iter().any(|filter| filter == name);
    let any_named = checks.iter().any(|(name, _)| named(name));
    for (name, check) in checks {
        // Other words choose among the package's tests.
        if any_named && !named(name) || !any_named && !filters.is_empty() && name != "package" {
            continue;
        }
        println!("\n== {name}");
        let words: Vec<String> = if any_named { vec![] } else { filters.clone() };
        let Counts { passed, failed, ignored } = check(scope, &words);
        counts.passed += passed;
        counts.failed += failed;
        counts.ignored += ignored;
    }
    let Counts { passed, failed, ignored } = counts;
    let is_fine = failed == 0 && passed > 0;
    let word = if is_fine { "ok" } else { "FAILED" };
    println!(
        "\ntest result: {word}. {passed} passed; {failed} failed; {ignored} ignored; 0 measured; 0 filtered out"
    );
    if is_fine { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Whether slow tests are run.
#[derive(Clone, Copy, PartialEq)]
enum Scope {
    Usual,
    All,
}

/// Given the words that tests were asked for by.
type Check = fn(Scope, &[String]) -> Counts;

#[derive(Clone, Copy, Default)]
struct Counts {
    passed: u64,
    failed: u64,
    ignored: u64,
}

impl Counts {
    const FAILED: Self = Self { passed: 0, failed: 1, ignored: 0 };

    fn one(is_fine: bool) -> Self {
        if is_fine { Self { passed: 1, ..Self::default() } } else { Self::FAILED }
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Where Cargo leaves libraries and tests.
fn built() -> PathBuf {
    let own = std::env::current_exe().expect("this program lies somewhere");
    own.parent().expect("in a folder").to_owned()
}

fn script(name: &str) -> Command {
    let mut command = Command::new("bash");
    command.arg(root().join("script").join(name)).current_dir(root());
    // Whoever builds has what they build with in PATH.
    command.env("CARGO", std::env::var_os("CARGO").unwrap_or_else(|| env!("CARGO").into()));
    command
}

/// The project's chores, by the program that runs these tests where it is one of them.
fn xtask() -> Command {
    if let Some(program) = std::env::var_os("LUMIVOX_XTASK") {
        return Command::new(program);
    }
    let mut command = Command::new(env!("CARGO"));
    command.args(["run", "--release", "--quiet", "--package", "xtask", "--"]);
    command
}

/// Runs a program whose last line counts its tests, and shows all that it says.
fn counted(command: &mut Command) -> Counts {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().expect("bash");
    let mut counts = Counts::default();
    for line in BufReader::new(child.stdout.take().expect("a pipe")).lines().map_while(Result::ok) {
        println!("{line}");
        let words: Vec<&str> = line.split([' ', ',']).filter(|word| !word.is_empty()).collect();
        if let [passed, "passed", failed, "failed", ignored, "ignored"] = words[..]
            && let (Ok(passed), Ok(failed), Ok(ignored)) = (passed.parse(), failed.parse(), ignored.parse())
        {
            counts = Counts { passed, failed, ignored };
        }
    }
    let is_fine = child.wait().is_ok_and(|status| status.success());
    if !is_fine && counts.failed == 0 || counts.passed + counts.failed == 0 { Counts::FAILED } else { counts }
}

fn succeeds(command: &mut Command) -> bool {
    command.stdin(Stdio::null()).status().is_ok_and(|status| status.success())
}

/// Pictures that the manual names are there, small enough for a manual, and no others.
fn documentation(_: Scope, _: &[String]) -> Counts {
    const LARGEST: u64 = 200 << 10;
    let folder = root().join("unity/com.lumivox/Documentation~");
    let entries = |folder: &Path| -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect()
    };
    let mut named = std::collections::BTreeSet::new();
    for page in entries(&folder).into_iter().filter(|path| path.extension() == Some(OsStr::new("md"))) {
        let text = fs::read_to_string(page).unwrap_or_default();
        let words = text.split(|c: char| !c.is_ascii_alphanumeric() && !matches!(c, '-' | '.'));
        named.extend(words.filter(|word| word.len() > 4 && word.ends_with(".png")).map(str::to_owned));
    }
    let there: std::collections::BTreeSet<String> = entries(&folder.join("images"))
        .iter()
        .filter_map(|path| Some(path.file_name()?.to_str()?.to_owned()))
        .collect();
    let mut faults: Vec<String> =
        named.difference(&there).map(|name| format!("{name} is named, and not there")).collect();
    faults.extend(there.difference(&named).map(|name| format!("{name} is there, and no page names it")));
    for name in &there {
        let size = fs::metadata(folder.join("images").join(name)).map_or(0, |data| data.len());
        if !(1..LARGEST).contains(&size) {
            faults.push(format!("{name} has {size} bytes"));
        }
    }
    faults.iter().for_each(|fault| println!("documentation: {fault}"));
    println!("{} pictures are named", named.len());
    Counts::one(faults.is_empty() && !named.is_empty())
}

/// FXC and DXC take every kernel that is shipped.
fn kernels(_: Scope, _: &[String]) -> Counts {
    Counts::one(succeeds(&mut script("hlsl")))
}

/// All C# compiles as in every Unity, in the editor and for players, and the tests pass in the newest editor.
fn package(scope: Scope, filters: &[String]) -> Counts {
    let all = (scope == Scope::All).then_some("--all");
    counted(script("unity").arg("--libraries").arg(built()).args(all).args(filters))
}

/// What people install: made of the tree, unpacked elsewhere, with the library that is in it.
fn installed(_: Scope, _: &[String]) -> Counts {
    // Unity sees no folder whose name begins with a dot.
    let place = tempfile::Builder::new().prefix("lumivox").tempdir().expect("a folder of our own");
    let (native, out) = (place.path().join("native"), place.path().join("out"));
    fs::create_dir(&native).expect("a folder");
    let files = [
        (built().join("liblumivox_unity.so"), "liblumivox_unity.so"),
        (PathBuf::from(env!("CARGO_BIN_EXE_unity-codecs")), "lumivox-codecs"),
    ];
    for (from, name) in files {
        fs::copy(&from, native.join(name)).unwrap_or_else(|error| panic!("{}: {error}", from.display()));
    }
    // As if it had been built elsewhere: all that the archive's maker looks at.
    let elsewhere = place.path().join("lumivox_unity.dll");
    let mut library = vec![0; 0x80];
    library[..2].copy_from_slice(b"MZ");
    library[0x3c] = 0x80;
    library.extend(b"PE\0\0\x64\x86lumivox_abi_version");
    fs::write(&elsewhere, library).expect("a file");
    // What comes of a git URL: committed to a branch, and cloned into an empty place, as Unity does it.
    let (repository, cloned) = (place.path().join("repository"), place.path().join("cloned"));
    let mut init = Command::new("git");
    init.args(["init", "--quiet", "--bare"]).arg(&repository);
    let mut xtask = xtask();
    xtask
        .args(["package", "unity"])
        .arg(&out)
        .arg("--from")
        .arg(&native)
        .arg("--library")
        .arg(&elsewhere)
        .args(["--upm", "upm"]);
    for person in ["AUTHOR", "COMMITTER"] {
        xtask
            .env(format!("GIT_{person}_NAME"), "a test")
            .env(format!("GIT_{person}_EMAIL"), "test@example.org");
    }
    xtask.current_dir(root()).env("GIT_DIR", &repository);
    let mut clone = Command::new("git");
    clone.args(["clone", "--quiet", "--branch", "upm"]).arg(&repository).arg(&cloned);
    let archive = out.join(format!("com.lumivox-{}.tgz", env!("CARGO_PKG_VERSION")));
    let unpacked = place.path().join("package");
    let mut unpack = Command::new("tar");
    unpack.arg("-xzf").arg(&archive).arg("-C").arg(place.path());
    let mut compare = Command::new("diff");
    compare.args(["--recursive", "--brief", "--exclude=.git"]).args([&unpacked, &cloned]);
    if ![&mut init, &mut xtask, &mut unpack, &mut clone, &mut compare].into_iter().all(succeeds) {
        return Counts::FAILED;
    }
    let missing = missing(&cloned);
    if !missing.is_empty() {
        println!("the package has not {}", missing.join(", "));
        return Counts::FAILED;
    }
    let meta = fs::read_to_string(cloned.join("Runtime/Plugins/Windows/x86_64/lumivox_unity.dll.meta"))
        .unwrap_or_default();
    if !meta.contains("Standalone: Win64") || meta.contains("Linux") {
        println!("the library of another system is not where Unity looks for it: {meta}");
        return Counts::FAILED;
    }
    counted(script("unity").arg("--libraries").arg(built()).arg("--installed").arg(&cloned).args([
        "RuntimeComponentTests",
        "RuntimeWorldTests",
        "TheScanIsSeenInTheMiddle",
        "DecodersThatMayCrash",
    ]))
}

/// What an installed package lacks: files of the tree, kernels of its table, and identifiers of files.
fn missing(package: &Path) -> Vec<String> {
    // Those that Unity does not see, too: the manual, samples, what the self-check expects.
    let tree = root().join("unity/com.lumivox");
    let mut missing: Vec<String> = vec![];
    let mut places = vec![PathBuf::new()];
    while let Some(place) = places.pop() {
        for entry in fs::read_dir(tree.join(&place)).expect("a folder").map(|entry| entry.expect("a file")) {
            let within = place.join(entry.file_name());
            if entry.path().is_dir() {
                places.push(within);
            } else if !package.join(&within).is_file() {
                missing.push(within.display().to_string());
            }
        }
    }
    let mut files = vec![];
    let mut folders = vec![package.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("a file").path()) {
            let name = entry.file_name().and_then(OsStr::to_str).expect("a name");
            if name.starts_with('.') || name.ends_with('~') {
                continue;
            }
            if entry.is_dir() {
                folders.push(entry.clone());
            }
            files.push(entry);
        }
    }
    let table = fs::read_to_string(package.join("Runtime/Gpu/KernelTable.cs")).unwrap_or_default();
    let named = table.lines().filter_map(|line| line.trim().strip_prefix("new Entry(\"")?.split('"').next());
    let kernels: Vec<&str> = named.collect();
    let is_there = |kernel: &&&str| files.iter().any(|file| file.file_stem() == Some(OsStr::new(**kernel)));
    missing.extend(kernels.iter().filter(|kernel| !is_there(kernel)).map(|kernel| (*kernel).to_owned()));
    if kernels.is_empty() {
        missing.push("a table of kernels".to_owned());
    }
    let is_meta = |file: &&PathBuf| file.extension() == Some(OsStr::new("meta"));
    for file in files.iter().filter(|file| !is_meta(file)) {
        let meta = PathBuf::from(format!("{}.meta", file.display()));
        if !files.contains(&meta) {
            missing.push(meta.display().to_string());
        }
    }
    missing
}

/// The tests of the C ABI under valgrind: no byte is read that is not there, none is lost.
fn border(_: Scope, _: &[String]) -> Counts {
    let is_test = |path: &PathBuf| {
        let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
        name.starts_with("border-") && path.extension().is_none()
    };
    let all =
        fs::read_dir(built()).expect("the folder of the tests").filter_map(|entry| Some(entry.ok()?.path()));
    let newest = all.filter(is_test).max_by_key(|path| path.metadata().and_then(|file| file.modified()).ok());
    let Some(test) = newest else {
        eprintln!("the border's tests are not built: run `cargo test --release --workspace --no-run`");
        return Counts::FAILED;
    };
    let torso = tempfile::Builder::new().prefix("lumivox").tempdir().expect("a folder of our own");
    write_torso(torso.path());
    let options = ["--quiet", "--error-exitcode=9", "--leak-check=full", "--show-leak-kinds=definite"];
    let mut valgrind = Command::new("valgrind");
    valgrind.args(options).arg("--errors-for-leak-kinds=definite").arg(test).current_dir(root());
    valgrind.env("LUMIVOX_TEST_TORSO", torso.path());
    Counts::one(succeeds(&mut valgrind))
}

/// A torso on a table, as slices of DICOM: few voxels, for valgrind takes fifty times as long, and looks at bytes and not at bodies.
/// Grown here, for there it would take most of the time.
fn write_torso(folder: &Path) {
    let (silent, never) = (Progress::SILENT, CancelToken::new());
    let options = TorsoOptions { size: 24, ..Default::default() };
    let torso = lumivox_phantom::torso(options, silent, &never).expect("nobody cancels");
    let series = lumivox_phantom::SeriesDescription::default();
    lumivox_phantom::write_dicom_series(&torso, folder, &series, silent, &never).expect("room for it");
}
