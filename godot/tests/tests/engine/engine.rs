//! A real Godot: the project it opens, the display it draws to, and the log it must keep clean.

use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;

/// Longest that one run of the engine may take, on two cores and software Vulkan.
const TIME_LIMIT: Duration = Duration::from_secs(1200);

/// Where the addon's library is in a project, with the program that decodes for it.
pub const BIN: &str = if cfg!(target_arch = "aarch64") {
    "addons/lumivox/bin/linux.arm64"
} else {
    "addons/lumivox/bin/linux.x86_64"
};
/// What that program is called.
pub const CODECS: &str = "lumivox-codecs";

/// Words in a log that the addon is not to blame for.
const NOT_OURS: &[&str] = &[
    // Xvfb, and machines without sound, dbus or a user's folders.
    "XDG_RUNTIME_DIR",
    "dbus",
    "Unable to open cursor",
    "libdecor",
    "speech",
    "XRandR",
    "xrandr",
    "Xcursor",
    "IME not supported by this display server",
    "IME or NOTIFICATION_WM_IME_UPDATE not supported by this display server",
    // Drivers in software are slow to compile, and say so.
    "shader cache",
    "No keyring",
    // What is written to is a few pictures.
    "Current available space on disk is low",
];

/// A run of the engine that ended well.
pub struct Run {
    /// Everything it printed.
    pub log: String,
}

/// What a run of a program differs in from others.
#[derive(Default)]
pub struct Start<'a> {
    pub environment: Vec<(&'a str, OsString)>,
    /// The folder it is started in.
    pub folder: Option<&'a Path>,
    /// Words in its log that the addon is not to blame for.
    pub excused: &'a [&'a str],
    /// Whether nobody looks at its windows: in software, most of an editor's time goes into drawing its own panels.
    pub unseen: bool,
}

/// What several tests look at, made once. Where that fails, it is not tried again for each of them.
pub fn once<T>(cell: &'static OnceLock<Option<T>>, make: impl FnOnce() -> T) -> &'static T {
    cell.get_or_init(|| catch_unwind(AssertUnwindSafe(make)).ok())
        .as_ref()
        .expect("this test's run failed, as an earlier test says")
}

/// One engine at a time: two would only slow each other down.
pub fn engine() -> MutexGuard<'static, Engine> {
    static ENGINE: OnceLock<Option<Mutex<Engine>>> = OnceLock::new();
    once(&ENGINE, || Mutex::new(Engine::new())).lock().unwrap_or_else(PoisonError::into_inner)
}

/// Godot, with a project of its own.
pub struct Engine {
    pub godot: PathBuf,
    /// The project's folder: the demo with its addon, and the tests' own scripts under `res://tests`.
    pub project: PathBuf,
    /// Where cases and pictures go.
    pub out: PathBuf,
    /// Held until this process ends, however it does.
    _lock: fs::File,
}

impl Engine {
    fn new() -> Self {
        let godot = PathBuf::from(std::env::var_os("GODOT").expect(
            "GODOT must name a Godot 4.5 or newer; script/test finds or fetches one (GODOT=/path/to/godot cargo test)",
        ));
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("godot");
        let lock = lock(&folder.with_extension("lock"));
        let _ = fs::remove_dir_all(&folder);
        let engine = Self { godot, project: folder.join("project"), out: folder.join("out"), _lock: lock };
        fs::create_dir_all(&engine.out).unwrap();
        copy(&root.join("godot/demo"), &engine.project, &[".godot", "bin"]);
        copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("project"), &engine.project.join("tests"), &[]);
        coarsen_phantoms(&engine.project.join("scenes"));
        engine.install_extension();
        // Without this list the first import does not know the extension's classes.
        fs::create_dir_all(engine.project.join(".godot")).unwrap();
        fs::write(
            engine.project.join(".godot/extension_list.cfg"),
            "res://addons/lumivox/lumivox.gdextension\n",
        )
        .unwrap();
        engine.run("import", &["--headless", "--import"]);
        engine
    }

    /// Cargo builds the extension with these tests, as a dependency of theirs, and leaves it beside them; the program
    /// that decodes for it is one of theirs.
    fn install_extension(&self) {
        let test = std::env::current_exe().unwrap();
        let library = test.with_file_name("liblumivox_godot.so");
        let bin = self.project.join(BIN);
        fs::create_dir_all(&bin).unwrap();
        fs::copy(env!("CARGO_BIN_EXE_tests-codecs"), bin.join(CODECS)).unwrap();
        fs::copy(&library, bin.join("liblumivox_godot.so"))
            .unwrap_or_else(|e| panic!("{}: {e}; cargo test builds it", library.display()));
    }

    /// Runs Godot in the project until it quits, and fails if it complains.
    pub fn run(&self, name: &str, arguments: &[&str]) -> Run {
        self.run_program(
            &self.godot,
            name,
            &[&["--path", self.project.to_str().unwrap()], arguments].concat(),
        )
    }

    /// A copy of the project, imported as it is, for what changes it.
    pub fn copy_project(&self, name: &str) -> PathBuf {
        let to = self.out.join(name).join("project");
        let _ = fs::remove_dir_all(&to);
        copy(&self.project, &to, &[]);
        to
    }

    /// Writes what a run is to do. Returns the folder for what it makes, and the file.
    pub fn write_cases(&self, name: &str, what: &impl Serialize) -> (PathBuf, PathBuf) {
        let folder = self.out.join(name);
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("cases.json");
        fs::write(&file, serde_json::to_vec(what).unwrap()).unwrap();
        (folder, file)
    }

    /// Runs another program with the engine's arguments, as an exported game is one.
    pub fn run_program(&self, program: &Path, name: &str, arguments: &[&str]) -> Run {
        self.run_as(program, name, arguments, &Start::default())
    }

    /// The same, in an environment of its own.
    pub fn run_as(&self, program: &Path, name: &str, arguments: &[&str], start: &Start) -> Run {
        let log = self.out.join(format!("{name}.log"));
        let file = fs::File::create(&log).unwrap();
        let display = Display::open(if start.unseen { "480x320x24" } else { "1280x800x24" });
        let mut command = Command::new(program);
        command
            .args(["--audio-driver", "Dummy"])
            .args(arguments)
            .env("DISPLAY", &display.name)
            .env("XDG_DATA_HOME", self.out.join("data"))
            .env("XDG_CONFIG_HOME", self.out.join("config"))
            .env("XDG_CACHE_HOME", self.out.join("cache"))
            .envs(start.environment.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::null())
            .stdout(file.try_clone().unwrap())
            .stderr(file);
        if let Some(folder) = start.folder {
            command.current_dir(folder);
        }
        let mut child = command.spawn().unwrap_or_else(|e| panic!("{}: {e}", program.display()));
        let begin = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break Some(status);
            }
            if begin.elapsed() > TIME_LIMIT {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
            std::thread::sleep(Duration::from_millis(50));
        };
        drop(display);
        let text = String::from_utf8_lossy(&fs::read(&log).unwrap()).into_owned();
        let tail: String = text
            .lines()
            .rev()
            .take(40)
            .collect::<Vec<_>>()
            .into_iter()
            .rev()
            .map(|l| format!("{l}\n"))
            .collect();
        let status =
            status.unwrap_or_else(|| panic!("{name}: not done after {TIME_LIMIT:?}; its log ends\n{tail}"));
        assert!(status.success(), "{name}: Godot ended with {status}; its log ends\n{tail}");
        let run = Run { log: text };
        let complaints = run.complaints(start.excused);
        assert!(complaints.is_empty(), "{name}: the log ({}) complains:\n{complaints}", log.display());
        println!("{name}: {:.0?}", begin.elapsed());
        run
    }
}

impl Run {
    /// Errors and warnings of engine, driver and scripts, with the line after each, where they say who it was.
    fn complaints(&self, excused: &[&str]) -> String {
        let lines: Vec<&str> = self.log.lines().collect();
        let mut found = String::new();
        for (i, line) in lines.iter().enumerate() {
            let words = ["ERROR", "WARNING", "leaked", "panicked", "Validation"];
            let next = lines.get(i + 1).copied().unwrap_or_default();
            let excused = NOT_OURS.iter().chain(excused).any(|w| line.contains(w) || next.contains(w));
            // Errors that a test provokes are announced.
            let expected = i > 0 && lines[..i].iter().rev().take(3).any(|l| l.starts_with("EXPECT "));
            if words.iter().any(|w| line.contains(w)) && !excused && !expected {
                found += &format!("{line}\n{next}\n");
            }
        }
        found
    }
}

/// A display that nobody sees. A real one would show windows for minutes, and be of any size.
struct Display {
    name: String,
    server: Child,
}

impl Display {
    fn open(screen: &str) -> Self {
        // It chooses its number itself, and says it once it can be used.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", screen, "-nolisten", "tcp"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|e| panic!("Xvfb is needed to run Godot ({e}); Debian: apt-get install xvfb"));
        let mut number = String::new();
        let said = server.stdout.take().map(|out| BufReader::new(out).read_line(&mut number));
        if !matches!(said, Some(Ok(1..))) {
            let _ = server.kill();
            let _ = server.wait();
            panic!("Xvfb opens no display; run `Xvfb -displayfd 1` to see why");
        }
        Self { name: format!(":{}", number.trim()), server }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // Asked, not killed: it takes its lock and its socket with it.
        let asked = Command::new("kill").arg(self.server.id().to_string()).status();
        if !asked.is_ok_and(|status| status.success()) {
            let _ = self.server.kill();
        }
        let _ = self.server.wait();
    }
}

/// Waits until no other process runs these tests in the same target folder: each would wipe the other's project.
fn lock(path: &Path) -> fs::File {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    let file = fs::File::create(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    if file.try_lock().is_err() {
        // Past the test's own streams, which are shown when it is over.
        let _ = fs::write("/dev/stderr", "waiting for other engine tests to end\n");
        file.lock().unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }
    file
}

/// Has the demo grow its head in a tenth of the time, as often as it is run: of fewer voxels.
pub fn coarsen_phantoms(scenes: &Path) {
    let mut coarsened = 0;
    for entry in fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path();
        let Ok(text) = fs::read_to_string(&path) else { continue };
        let coarse =
            text.replace("\nsize = 192\n", "\nsize = 64\n").replace("var size := 192", "var size := 64");
        if coarse != text {
            fs::write(&path, coarse).unwrap();
            coarsened += 1;
        }
    }
    assert!(coarsened > 3, "the demo's phantoms have another size than tests know");
}

/// Copies a folder without what is called as in `except`.
fn copy(from: &Path, to: &Path, except: &[&str]) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap_or_else(|e| panic!("{}: {e}", from.display())) {
        let entry = entry.unwrap();
        let name = entry.file_name();
        if except.iter().any(|e| name == *e) {
            continue;
        }
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &to.join(&name), except);
        } else {
            fs::copy(entry.path(), to.join(&name)).unwrap();
        }
    }
}

#[test]
fn a_complaint_is_excused_by_its_own_words_alone() {
    let complains = |line: &str| !Run { log: line.to_owned() }.complaints(&["broken.nrrd"]).is_empty();
    for ours in [
        "ERROR: no TIME left",
        "WARNING: a RUNTIME error",
        "ERROR: PRIME is not bound",
        "thread panicked at x",
    ] {
        assert!(complains(ours), "{ours}");
    }
    for excused in [
        "WARNING: IME not supported by this display server.",
        "ERROR: XDG_RUNTIME_DIR is invalid",
        "ERROR: broken.nrrd is cut short",
        "Lumivox: 24 slices",
    ] {
        assert!(!complains(excused), "{excused}");
    }
}
