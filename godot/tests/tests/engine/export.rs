//! The demo as an exported Linux game: a program, its pack and the addon's library in a folder of their own.
//!
//! The program that is exported is the engine itself instead of Godot's export template: Debian has no templates, and
//! an editor's program with a pack beside it runs that pack as a template does. What a template lacks, the editor, is
//! there but stays unused; pack, library and where they are looked for are those of every exported game.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use lumivox_testing::png_io::SrgbImage;
use serde_json::{Value, json};

use crate::case::{Case, Volume};
use crate::codecs::{mark, marks, write_jpeg_ls};
use crate::engine::{BIN, CODECS, Engine, Run, Start, engine, once};
use crate::expected;
use crate::scans;
use crate::shown::{assert_same, told};

/// What Debian's loader is called in a program, and what it is called beside the exported one.
const SYSTEM_LOADER: &[u8] = b"/lib64/ld-linux-x86-64.so.2\0";
const OWN_LOADER: &str = "loader.so";

/// What the engine leaks of a scene with one ReflectionProbe, with volumes and without.
pub const PROBE_LEAK: &str = "7 RIDs of type \"Texture\" were leaked";

fn case() -> Case {
    Case { volumes: vec![Volume { anisotropy: 0.5, filter: 2, ..Volume::soft() }], ..Case::new("exported") }
}

/// An engine's program, and what it needs when it is run from elsewhere.
pub struct Program {
    pub path: PathBuf,
    /// The folder of Debian's packages that it came with; a program that is installed needs none.
    root: Option<PathBuf>,
}

impl Program {
    pub fn of(engine: &Engine) -> Self {
        let is_program = |path: &Path| fs::read(path).is_ok_and(|bytes| bytes.starts_with(b"\x7fELF"));
        let path = engine.godot.canonicalize().unwrap_or_else(|_| engine.godot.clone());
        let path = if path.components().count() > 1 { path } else { in_path(&engine.godot) };
        if is_program(&path) {
            return Self { path, root: None };
        }
        // What script/godot.sh fetches is a script before the program.
        let root = path.with_file_name("root");
        let own = root.join("usr/bin/godot");
        assert!(is_program(&own), "{} is no program, and none can be exported from it", path.display());
        Self { path: own, root: Some(root) }
    }

    /// Makes the exported programs find their loader beside them, and says where they find their libraries.
    pub fn settle(&self, exported: &Path, others: &[&Path]) -> Vec<(&'static str, OsString)> {
        let Some(root) = &self.root else { return vec![] };
        for program in others.iter().chain([&exported]) {
            let mut bytes = fs::read(program).unwrap();
            let at = bytes.windows(SYSTEM_LOADER.len()).position(|w| w == SYSTEM_LOADER).expect("a loader");
            bytes[at..at + SYSTEM_LOADER.len()].fill(0);
            bytes[at..at + OWN_LOADER.len()].copy_from_slice(OWN_LOADER.as_bytes());
            fs::write(program, bytes).unwrap();
        }
        let loader = root.join("usr/lib64/ld-linux-x86-64.so.2");
        fs::copy(loader, exported.with_file_name(OWN_LOADER)).unwrap();
        let libraries = root.join("usr/lib/x86_64-linux-gnu");
        let path = [libraries.clone(), libraries.join("pulseaudio"), "/usr/lib/x86_64-linux-gnu".into()];
        let mut environment =
            vec![("LD_LIBRARY_PATH", std::env::join_paths(path).unwrap()), ("NODEVICE_SELECT", "1".into())];
        let has_gpu = Path::new("/dev/nvidia0").exists() || Path::new("/dev/dri").exists();
        if !has_gpu && std::env::var_os("VK_DRIVER_FILES").is_none() {
            environment.push(("VK_DRIVER_FILES", root.join("usr/share/vulkan/icd.d/lvp_icd.json").into()));
        }
        environment
    }
}

fn in_path(name: &Path) -> PathBuf {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|file| file.exists()).unwrap()
}

/// What the exported game said and its folder.
fn exported() -> &'static (Run, PathBuf) {
    static EXPORTED: OnceLock<Option<(Run, PathBuf)>> = OnceLock::new();
    once(&EXPORTED, || {
        let engine = engine();
        let project = engine.copy_project("export");
        let (folder, cases) = engine.write_cases("export", &[case()]);
        let program = Program::of(&engine);
        let presets = project.join("export_presets.cfg");
        let template = format!("custom_template/release={:?}\n", program.path.display().to_string());
        let preset = fs::read_to_string(&presets).unwrap();
        let preset =
            preset.replacen("[preset.0.options]\n\n", &format!("[preset.0.options]\n\n{template}"), 1);
        assert!(preset.contains(&template), "the demo's export preset is not as expected");
        let filtered = preset.replacen("include_filter=\"\"", "include_filter=\"own/*\"", 1);
        assert_ne!(filtered, preset, "the demo's export preset is not as expected");
        fs::write(&presets, filtered).unwrap();
        write_own_files(&project);
        let game = folder.join("game");
        fs::create_dir_all(&game).unwrap();
        let file = game.join("lumivox_demo.x86_64");
        let [path, target] = [&project, &file].map(|path| path.to_str().unwrap());
        let arguments = ["--headless", "--path", path, "--export-release", "Linux", target];
        engine.run_as(&engine.godot, "export", &arguments, &Start::default());
        let codecs = game.join(CODECS);
        let original = fs::read(project.join(BIN).join(CODECS)).unwrap();
        assert!(fs::read(&codecs).is_ok_and(|bytes| bytes == original), "{CODECS} was not exported");
        mark(&codecs);
        let environment = program.settle(&file, &[&codecs, &codecs.with_extension("real")]);
        // As an export leaves it; the program behind it is the test's own affair.
        set_mode(&codecs, 0o644);
        set_mode(&codecs.with_extension("real"), 0o755);
        // The game has nothing but its own folder.
        fs::remove_dir_all(&project).unwrap();

        let scan = folder.join("scan");
        scans::write_series(&scans::head(24), &scan);
        let compressed = folder.join("compressed");
        write_jpeg_ls(&compressed);
        let [cases, out, scan, compressed] =
            [&cases, &folder, &scan, &compressed].map(|path| path.to_str().unwrap());
        let start = Start { environment, folder: Some(&game), excused: &[PROBE_LEAK], unseen: false };
        let pictures =
            ["--resolution", "160x90", "res://tests/show_cases.tscn", "--", "--cases", cases, "--out", out];
        engine.run_as(&file, "exported_case", &pictures, &start);
        let game = [
            "--resolution",
            "384x216",
            "res://tests/exported.tscn",
            "--",
            "--scan",
            scan,
            "--compressed",
            compressed,
            "--out",
            out,
        ];
        (engine.run_as(&file, "exported", &game, &start), folder)
    })
}

/// What a game may have: files of its own that end as scans do, and archives that nobody asked to export.
const OWN: [(&str, &[u8]); 3] =
    [("data.zip", b"PK\x05\x06no scan"), ("level.gz", b"\x1f\x8ba level"), ("texture.raw", b"texels")];

fn write_own_files(project: &Path) {
    for folder in ["own", "left"] {
        fs::create_dir_all(project.join(folder)).unwrap();
        for (name, bytes) in OWN {
            fs::write(project.join(folder).join(name), bytes).unwrap();
        }
    }
}

pub fn set_mode(path: &Path, mode: u32) {
    #[cfg(unix)]
    fs::set_permissions(path, std::os::unix::fs::PermissionsExt::from_mode(mode)).unwrap();
    #[cfg(not(unix))]
    panic!("{}: the engine tests run on Linux, not with mode {mode:o}", path.display());
}

fn telling(name: &str) -> Value {
    told(&exported().0, name)
}

#[test]
fn an_exported_game_has_the_library_beside_it_and_no_editor_scripts() {
    let folder = exported().1.join("game");
    for file in ["lumivox_demo.x86_64", "lumivox_demo.pck", "liblumivox_godot.so", CODECS] {
        assert!(folder.join(file).exists(), "{file} was not exported");
    }
    let told = telling("game");
    assert!(told["program"].as_str().unwrap().ends_with("game/lumivox_demo.x86_64"), "{told}");
    assert_eq!(told["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&told["plugin"], &told["dock"]), (&json!(false), &json!(false)), "{told}");
    assert_eq!(told["project_file"], false, "it runs from the project, not from its pack: {told}");
    assert_eq!(told["panel"], true, "{told}");
}

#[test]
fn an_exported_game_has_its_own_archives_and_raw_files() {
    let told = telling("own");
    for (name, bytes) in OWN {
        assert_eq!(told["own"][name], json!(bytes), "{name}: {told}");
        assert_eq!(told["left"][name], Value::Null, "{name} was not asked for: {told}");
    }
}

#[test]
fn an_exported_game_shows_what_the_project_shows() {
    assert_same(&exported().1, "exported", &expected::picture(&case()), |_| true);
}

#[test]
fn an_exported_game_imports_dicom_while_it_runs() {
    let told = telling("import");
    assert_eq!(told["dims"], json!([24, 24, 24]), "{told}");
    assert_eq!(told["unit"], "HU");
    assert!(told["stages"].as_f64().unwrap() > 0.0, "there was no progress: {told}");
}

#[test]
fn an_exported_game_decodes_beside_itself_with_a_file_that_was_no_program() {
    let told = telling("compressed");
    assert_eq!(told["histogram"], json!([0.0, 12.0, 12.0, 12.0, 12.0, 12.0]), "{told}");
    let program = exported().1.join("game").join(CODECS);
    assert!(marks(&program) > 0, "{} was not started for a frame", program.display());
}

#[test]
fn an_exported_demo_shows_its_main_scene() {
    assert!(telling("main")["pixel_samples"].as_f64().unwrap() > 0.0, "nothing is traced");
    let shown = SrgbImage::read(&exported().1.join("main.png")).unwrap();
    let colors: std::collections::HashSet<_> = shown.pixels.iter().collect();
    assert!(colors.len() > 3000, "the main scene has but {} colours", colors.len());
}
