//! The addon as people get it: the archive of `cargo xtask package godot`, unpacked into an empty project that is played and
//! exported.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use lumivox_testing::png_io::SrgbImage;

use crate::engine::{BIN, CODECS, Engine, Start, coarsen_phantoms, engine, once};
use crate::export::{Program, set_mode};

const PROJECT: &str = r#"config_version=5

[application]
config/name="Installed"
run/main_scene="res://main.tscn"
config/features=PackedStringArray("4.5", "Forward Plus")

[editor_plugins]
enabled=PackedStringArray("res://addons/lumivox/plugin.cfg")
"#;

/// A camera, light from everywhere, and a script.
const SCENE: &str = r#"[gd_scene load_steps=3 format=3]

[ext_resource type="Script" path="res://main.gd" id="1"]

[sub_resource type="Environment" id="2"]
ambient_light_source = 2
ambient_light_color = Color(1, 1, 1, 1)

[node name="Main" type="Node3D"]
script = ExtResource("1")

[node name="Camera" type="Camera3D" parent="."]
transform = Transform3D(1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0.4)

[node name="World" type="WorldEnvironment" parent="."]
environment = SubResource("2")
"#;

/// As the addon's README begins: a volume, a look, and a picture when there is one.
const SCRIPT: &str = r#"extends Node3D


func _ready() -> void:
	var node := LumivoxVolume3D.new()
	node.volume = LumivoxVolume.phantom("head", 32)
	node.apply_preset("ct-bone")
	add_child(node)
	var begin := Time.get_ticks_msec()
	while Lumivox.get_status(get_viewport()).get("pixel_samples", 0.0) < 2.0:
		await RenderingServer.frame_post_draw
		if Time.get_ticks_msec() - begin > 240_000:
			push_error("no picture comes")
			break
	get_viewport().get_texture().get_image().save_png(OS.get_cmdline_user_args()[0])
	print("VERSION ", Lumivox.version())
	get_tree().quit()
"#;

/// The folder of the archives.
fn packed(engine: &Engine) -> &'static Path {
    static PACKED: OnceLock<Option<PathBuf>> = OnceLock::new();
    once(&PACKED, || pack(engine)).as_path()
}

/// Makes them of the library and the program that these tests were built with.
fn pack(engine: &Engine) -> PathBuf {
    let folder = engine.out.join("installed");
    let _ = fs::remove_dir_all(&folder);
    let [native, nothing, out] = ["native", "nothing", "out"].map(|name| folder.join(name));
    fs::create_dir_all(&native).unwrap();
    let library = std::env::current_exe().unwrap().with_file_name("liblumivox_godot.so");
    fs::copy(library, native.join("liblumivox_godot.so")).unwrap();
    fs::copy(env!("CARGO_BIN_EXE_tests-codecs"), native.join(CODECS)).unwrap();
    let mut xtask = match std::env::var_os("LUMIVOX_XTASK") {
        Some(program) => Command::new(program),
        None => {
            let mut cargo = Command::new(env!("CARGO"));
            cargo.args(["run", "--release", "--quiet", "--package", "xtask", "--"]);
            cargo
        }
    };
    xtask.args(["package", "godot"]).arg(&out).arg("--from").arg(&native).arg("--windows").arg(&nothing);
    let output = xtask.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).output().unwrap();
    assert!(output.status.success(), "{xtask:?}: {}", String::from_utf8_lossy(&output.stderr));
    out
}

fn unpack(archive: &Path, to: &Path) {
    let file = fs::File::open(archive).unwrap_or_else(|error| panic!("{}: {error}", archive.display()));
    zip::ZipArchive::new(file).unwrap().extract(to).unwrap();
}

/// That a run made a picture of a head, and of the version that was packed.
fn assert_shown(log: &str, picture: &Path) {
    assert!(log.contains(concat!("VERSION ", env!("CARGO_PKG_VERSION"))), "{log}");
    let shown = SrgbImage::read(picture).unwrap();
    let colors: HashSet<_> = shown.pixels.iter().collect();
    assert!(colors.len() > 300, "{} has but {} colours", picture.display(), colors.len());
}

#[test]
fn the_packed_addon_plays_in_an_empty_project_and_is_exported_from_it() {
    let engine = engine();
    let out = packed(&engine);
    let version = env!("CARGO_PKG_VERSION");
    let folder = out.with_file_name("place");
    let project = folder.join("project");
    fs::create_dir_all(&project).unwrap();
    for (name, text) in [("project.godot", PROJECT), ("main.tscn", SCENE), ("main.gd", SCRIPT)] {
        fs::write(project.join(name), text).unwrap();
    }
    unpack(&out.join(format!("lumivox-godot-{version}.zip")), &project);
    let addon = project.join("addons/lumivox");
    for name in
        ["plugin.cfg", "README.md", "LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY-LICENSES.txt", "icon.svg"]
    {
        assert!(addon.join(name).is_file(), "the archive has no {name}");
    }
    // The library has no lines for debuggers in it: people do not load what they do not use.
    let size = fs::metadata(project.join(BIN).join("liblumivox_godot.so")).unwrap().len();
    assert!(size < 40 << 20, "{size} bytes");
    // As the README says for build servers.
    fs::create_dir_all(project.join(".godot")).unwrap();
    fs::write(project.join(".godot/extension_list.cfg"), "res://addons/lumivox/lumivox.gdextension\n")
        .unwrap();

    let [path, picture] =
        [&project, &folder.join("played.png")].map(|path| path.to_str().unwrap().to_owned());
    let import = ["--path", &path, "--headless", "--import"];
    engine.run_as(&engine.godot, "installed_import", &import, &Start::default());
    let play = ["--path", &path, "--resolution", "160x90", "--", &picture];
    let run = engine.run_as(&engine.godot, "installed_play", &play, &Start::default());
    assert_shown(&run.log, Path::new(&picture));

    let program = Program::of(&engine);
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/export_presets.cfg");
    let template = format!("custom_template/release={:?}\n", program.path.display().to_string());
    let preset = fs::read_to_string(demo).unwrap();
    let preset = preset.replacen("[preset.0.options]\n\n", &format!("[preset.0.options]\n\n{template}"), 1);
    assert!(preset.contains(&template), "the demo's export preset is not as expected");
    fs::write(project.join("export_presets.cfg"), preset).unwrap();
    let game = folder.join("game");
    fs::create_dir_all(&game).unwrap();
    let file = game.join("installed.x86_64");
    let export = ["--headless", "--path", &path, "--export-release", "Linux", file.to_str().unwrap()];
    engine.run_as(&engine.godot, "installed_export", &export, &Start::default());
    fs::remove_dir_all(&project).unwrap();
    let codecs = game.join(CODECS);
    assert!(codecs.is_file(), "{CODECS} was not exported");
    let environment = program.settle(&file, &[]);
    set_mode(&file, 0o755);
    let picture = folder.join("exported.png");
    let start = Start { environment, folder: Some(&game), ..Start::default() };
    let game = ["--resolution", "160x90", "--", picture.to_str().unwrap()];
    let run = engine.run_as(&file, "installed_game", &game, &start);
    assert_shown(&run.log, &picture);
}

#[test]
#[ignore = "slow: script/test --all"]
fn the_packed_demo_opens_as_it_is() {
    let engine = engine();
    let out = packed(&engine);
    let version = env!("CARGO_PKG_VERSION");
    let folder = out.with_file_name("demo");
    unpack(&out.join(format!("lumivox-godot-demo-{version}.zip")), &folder);
    let project = folder.join(format!("lumivox-godot-demo-{version}"));
    coarsen_phantoms(&project.join("scenes"));
    let path = project.to_str().unwrap();
    engine.run_as(
        &engine.godot,
        "installed_demo_import",
        &["--path", path, "--headless", "--import"],
        &Start::default(),
    );
    let picture = folder.join("demo.png");
    let view = [
        "--path",
        path,
        "--resolution",
        "160x90",
        "res://scenes/transfer_function.tscn",
        "--",
        "--screenshot",
    ];
    let asked = [picture.to_str().unwrap(), "--samples", "1", "--seconds", "500"];
    engine.run_as(&engine.godot, "installed_demo", &[&view[..], &asked].concat(), &Start::default());
    assert!(SrgbImage::read(&picture).unwrap().width == 160);
}
