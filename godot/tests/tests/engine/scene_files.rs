//! Scene files in the engine: what the command shows of one is what it shows of the one that the engine saves of it.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

use lumivox_core::document::{Backdrop, Entry, Scan, SceneDocument, Surface, Written};
use lumivox_core::glam::{DMat3, DVec3};
use lumivox_core::{CancelToken, EnvironmentMap, SurfaceReflection};
use lumivox_renderer::DisplaySettings;
use lumivox_renderer::display::put_on;
use lumivox_scene::{Opened, Opening, Silent};
use lumivox_testing::hosts;
use lumivox_testing::png_io::SrgbImage;
use lumivox_wgpu::{Gpu, RenderRequest};
use serde::Serialize;
use serde_json::{Value, json};

use crate::case::{Case, Clip, Lamp, LampKind, Light, Place, Volume, look_at};
use crate::engine::{Run, Start, engine, once};
use crate::scans;
use crate::shown::{assert_same, told};

const SIZE: [u32; 2] = [64, 48];

#[derive(Serialize)]
struct Script {
    scene: PathBuf,
    size: [u32; 2],
    case: Case,
    faulty: Value,
    hosts: [&'static str; 5],
    hosts_folder: PathBuf,
    hosts_size: [u32; 2],
}

struct Scenes {
    /// The scene that the engine opened.
    original: PathBuf,
    out: PathBuf,
    project: PathBuf,
    run: Run,
}

/// Two scans with all that scene files have, in numbers that 32 bits round.
fn document(head: &Path, torso: &Path) -> SceneDocument {
    let head_alone = Entry::new(Scan::of_files(vec![head.to_owned()]));
    let scans = lumivox_scene::load_scans(
        &SceneDocument { volumes: vec![head_alone], ..SceneDocument::default() },
        Path::new(""),
        &Opening::default(),
        &Silent,
        &CancelToken::new(),
    );
    let content = lumivox_scene::content_of(&scans.unwrap()[0].volume);
    let words = json!({
        "lumivox_scene": 1,
        "volumes": [
            {
                "scan": {"files": [head], "content": content},
                "look": {"preset": "ct-bone", "density": 3.3, "anisotropy": 0.123},
                "clip": [[0.0, 0.013, 0.0], [1.0, 1.0, 0.987]],
                "clip_shapes": [
                    {"kind": "sphere", "inverted": true, "from_shape":
                        [[60.1, 3.3, 0.0, 40.7], [0.0, 55.5, 0.1, -90.3], [0.2, 0.0, 70.7, 33.3]]},
                    {"kind": "plane", "space": "world", "from_shape":
                        [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, -81.7], [0.0, -1.0, 0.0, 0.0]]},
                ],
                "labels": {"styles": [
                    {"label": "body", "color": [0.31, 0.22, 0.17], "opacity": 0.7,
                        "surface": {"strength": 0.3, "gradient_per_mm": 33.0, "roughness": 0.21, "specular": 0.05}},
                    {"label": "air outside", "visible": false},
                ]},
            },
            {
                "scan": {"files": [torso]},
                "look": {
                    "transfer_function": {
                        "opacity": [[-300.1, 0.0, "in-out"], [300.7, 0.6], [1500.0, 1.0]],
                        "color": [[0.3, [0.9, 0.51, 0.33]], [1200.1, [0.87, 0.9, 0.81]]],
                    },
                    "gradients": [{"per_mm": 51.3, "transfer_function":
                        {"opacity": [[-300.3, 0.1], [300.9, 0.77]], "color": [[0.0, [0.3, 0.7, 0.9]]]}}],
                    "density": 0.21, "albedo": 0.87, "bounces": 30, "filter": "tricubic",
                    "surface": {"strength": 0.3, "gradient_per_mm": 71.3, "roughness": 0.37, "specular": 0.043},
                },
                "world_from_patient":
                    [[0.31, 0.11, 0.02, 140.3], [0.03, 0.05, 0.33, -20.7], [0.1, -0.3, 0.02, -60.1]],
                "layers": 3,
                "peel": 4.3,
            },
        ],
        "environment": {"source": "light.exr", "strength": 0.77, "rotation": 33.3},
        "lights": [
            {"kind": "sun", "direction": [-0.3, -1.0, -0.7], "irradiance": [1.1, 0.9, 0.7], "degrees": 1.3},
            {"kind": "point", "layers": 1, "lamp":
                {"position": [210.3, 150.1, 250.7], "intensity": [0.03, 0.07, 0.11], "radius": 12.3}},
            {"kind": "spot", "direction": [0.4, -0.5, -0.9], "half_angle": 31.3, "cone": {"inner_half_angle": 11.7}, "lamp":
                {"position": [-210.1, 250.3, 350.7], "intensity": [0.3, 0.2, 0.1], "radius": 5.1,
                    "falloff": {"power": {"range": 2100.7, "decay": 1.7}}}},
        ],
        "camera": {"azimuth": 25.3, "elevation": 11.1, "fov": 31.7},
        "film": {"size": SIZE, "samples": 4, "seed": 5},
        "display": {"background": "#1b2c3d", "exposure": 0.35, "tone": "aces", "gamma": 1.15},
    });
    SceneDocument::parse(&words.to_string()).unwrap()
}

/// Two scans out of files, one of them turned and cut, in the light of a sky that is no file, and a lamp.
fn built() -> Case {
    let clips = vec![
        Clip { shape: 0, place: Place::at(DVec3::new(0.0, -0.05, 0.0)), inverted: false },
        Clip {
            shape: 2,
            place: Place::new(DMat3::from_diagonal(DVec3::splat(0.25)), DVec3::new(0.1, 0.1, 0.1)),
            inverted: true,
        },
    ];
    let turn = DMat3::from_rotation_y(0.7) * DMat3::from_diagonal(DVec3::new(0.5, 0.6, 0.5));
    let turned = Volume {
        place: Place::new(turn, DVec3::new(0.2, 0.1, 0.1)),
        stops: vec![[0.0, 0.2, 0.5, 0.9]],
        clips,
        shown_labels: vec![("air outside", false), ("body", true)],
        ..Volume::table()
    };
    let (width, height) = (32, 16);
    let texel = |i: usize| {
        let up = 1.0 - (i / width) as f32 / height as f32;
        [0.1 + 0.3 * up, 0.1 + 0.4 * up, 0.1 + 0.6 * up]
    };
    let texels = (0..width * height).map(texel).collect();
    Case {
        size: SIZE,
        samples: 64,
        camera: look_at(DVec3::new(0.4, 0.2, 1.1), DVec3::ZERO),
        light: Light::Panorama { width, height, texels, rotation: 0.9, energy: 0.6 },
        volumes: vec![Volume::table(), turned],
        lamps: vec![Lamp {
            energy: 0.6,
            range: 3.0,
            ..Lamp::new(LampKind::Spot, look_at(DVec3::new(-0.4, 0.6, 1.0), DVec3::ZERO))
        }],
        budget: 100.0,
        ..Case::new("built")
    }
}

/// Scenes that cannot be opened as they are meant, with what is wrong.
fn faulty(folder: &Path, original: &SceneDocument) -> Value {
    let write = |name: &str, text: &str| {
        let file = folder.join(format!("{name}.lumivox"));
        fs::write(&file, text).unwrap();
        file
    };
    let mut gone = original.clone();
    gone.volumes[1].scan.files = vec!["gone/torso".into()];
    let mut changed = original.clone();
    changed.volumes.truncate(1);
    changed.environment = Default::default();
    changed.volumes[0].scan.content = Some("sha256:00".into());
    json!({
        "absent": folder.join("absent.lumivox"),
        "gone": write("gone", &gone.to_json().unwrap()),
        "other": write("other", "{\"name\": \"no scene\"}"),
        "newer": write("newer", "{\n\"lumivox_scene\": 99}"),
        "typing": write("typing", "{\n\"lumivox_scene\": 1,\n\"volume\": []}"),
        "changed": write("changed", &changed.to_json().unwrap()),
    })
}

fn scenes() -> &'static Scenes {
    static SCENES: OnceLock<Option<Scenes>> = OnceLock::new();
    once(&SCENES, || {
        let engine = engine();
        let project = engine.copy_project("scene_files");
        let [head, torso] = ["head", "torso"].map(|name| project.join("scans").join(name));
        scans::write_series(&scans::head(40), &head);
        scans::write_series(&scans::torso(48), &torso);
        let folder = project.join("scenes");
        fs::create_dir_all(&folder).unwrap();
        let texels =
            (0..512).map(|i| [0.1 + (i % 32) as f32 / 31.0, 0.3, 1.0 / (1 + i / 32) as f32]).collect();
        let map = EnvironmentMap::new(32, 16, texels).unwrap();
        lumivox_import::save_environment(&folder.join("light.exr"), &map).unwrap();
        let document = document(&head, &torso);
        let original = folder.join("both.lumivox");
        lumivox_scene::save(&document, &original).unwrap();
        let path = project.to_str().unwrap();
        let import = ["--path", path, "--headless", "--import"];
        engine.run_as(&engine.godot, "scene_import", &import, &Start::default());
        let faults = engine.out.join("faulty_scenes");
        fs::create_dir_all(&faults).unwrap();
        let faulty = faulty(&faults, &document);
        let hosts_folder = engine.out.join("hosts");
        scans::write_series(&scans::head(hosts::SCAN_SIZE), &hosts_folder.join(hosts::SCAN));
        hosts::copy_scenes(&hosts_folder);
        let script = Script {
            scene: original.clone(),
            size: SIZE,
            case: built(),
            faulty,
            hosts: hosts::HOSTS,
            hosts_folder: hosts_folder.clone(),
            hosts_size: read(&hosts_folder.join("command.lumivox")).document.film.size,
        };
        let (out, cases) = engine.write_cases("scene_files_out", &script);
        let [cases, to] = [&cases, &out].map(|path| path.to_str().unwrap());
        let scene = "res://tests/scene_files.tscn";
        let arguments =
            ["--path", path, "--resolution", "160x90", scene, "--", "--cases", cases, "--out", to];
        let run = engine.run_as(&engine.godot, "scene_files", &arguments, &Start::default());
        Scenes { original, out, project, run }
    })
}

fn read(file: &Path) -> Written {
    let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    Written::parse(file, text).unwrap_or_else(|error| panic!("{}, {error}", file.display()))
}

/// A scene that the engine saved.
fn saved(name: &str) -> SceneDocument {
    read(&scenes().out.join(format!("{name}.lumivox"))).document
}

fn opened(written: &Written) -> Opened {
    let opening = Opening::default();
    lumivox_scene::open(&written.document, written.folder(), &opening, &Silent, &CancelToken::new())
        .unwrap_or_else(|error| panic!("{}: {error}", error.place(written)))
}

/// The picture of a scene file, as the command makes it.
fn rendered(file: &Path) -> SrgbImage {
    static GPU: OnceLock<Mutex<Gpu>> = OnceLock::new();
    let name = std::env::var("LUMIVOX_GPU").ok();
    let gpu = GPU.get_or_init(|| Mutex::new(Gpu::open(name.as_deref()).expect("a GPU or software Vulkan")));
    let mut gpu = gpu.lock().unwrap_or_else(PoisonError::into_inner);
    let written = read(file);
    let Opened { scene, camera } = opened(&written);
    let SceneDocument { film, display, .. } = written.document;
    let [width, height] = film.size;
    let request = RenderRequest::new(width, height, film.samples.unwrap()).with(|it| it.seed = film.seed);
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let image = lumivox_wgpu::render(&mut gpu, &scene, &camera, &request, go_on).unwrap();
    let pixels = DisplaySettings::from(&display).pixels(&image.film, &scene.environment, &camera);
    let mut bytes = pixels.into_flattened();
    if let Backdrop::Color(color) = display.background {
        put_on(&mut bytes, color);
    }
    let pixels = bytes.as_chunks::<4>().0.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
    SrgbImage { width: width as usize, height: height as usize, pixels }
}

#[test]
fn a_scene_that_is_opened_and_saved_unchanged_gives_the_same_picture_to_the_bit() {
    let scenes = scenes();
    let told = told(&scenes.run, "opened");
    assert_eq!(
        (&told["error"], &told["saved"], &told["notes"]),
        (&json!(0), &json!(""), &json!([])),
        "{told}"
    );
    let original = rendered(&scenes.original);
    let again = rendered(&scenes.out.join("saved.lumivox"));
    let _ = original.write(&scenes.out.join("original.png"));
    let _ = again.write(&scenes.out.join("saved.png"));
    let differing = original.pixels.iter().zip(&again.pixels).filter(|(a, b)| a != b).count();
    println!("{differing} of {} pixels differ", original.pixels.len());
    let colors: std::collections::HashSet<_> = original.pixels.iter().collect();
    assert!(colors.len() > 500, "the scene shows next to nothing: {} colours", colors.len());
    assert_eq!(differing, 0);
}

#[test]
fn what_every_host_saved_is_the_same_picture_saved_by_the_engine() {
    let told = told(&scenes().run, "passed_on");
    let folder = engine().out.join("hosts");
    for host in hosts::HOSTS {
        assert_eq!(told[host], "", "{told}");
        let [one, other] = [format!("{host}.lumivox"), format!("of-{host}.lumivox")]
            .map(|name| rendered(&folder.join(name)));
        let differing = one.pixels.iter().zip(&other.pixels).filter(|(a, b)| a != b).count();
        let colors: std::collections::HashSet<_> = one.pixels.iter().collect();
        assert!(
            differing == 0 && colors.len() > 100,
            "{host}: {differing} of {} pixels differ",
            one.pixels.len()
        );
    }
    assert_eq!(told["own"], "", "{told}");
    hosts::assert_written("godot", &folder.join("own.lumivox"));
}

#[test]
fn a_saved_scene_says_what_the_opened_one_said() {
    let original = read(&scenes().original).document;
    let saved = saved("saved");
    assert_eq!(saved.film, original.film);
    assert_eq!(saved.display, original.display);
    assert_eq!(saved.lights.len(), original.lights.len());
    for (saved, original) in saved.volumes.iter().zip(&original.volumes) {
        let (content, expected) = (saved.scan.content.as_ref(), original.scan.content.as_ref());
        assert!(content.is_some_and(|hash| expected.is_none_or(|expected| hash == expected)), "{content:?}");
        assert_eq!((saved.layers, saved.peel), (original.layers, original.peel));
        assert_eq!(saved.clip, original.clip);
    }
    assert_eq!(saved.volumes[1].look.transfer_function, original.volumes[1].look.transfer_function);
    assert_eq!(saved.volumes[1].look.gradients, original.volumes[1].look.gradients);
    assert_eq!(saved.environment.strength, 0.77);
    for file in [&saved.volumes[0].scan.files[0], &saved.environment.source] {
        assert!(file.is_relative() && scenes().out.join(file).exists(), "{}", file.display());
    }
}

/// Kept in the engine's own file, and imported by its editor.
#[test]
fn scenes_are_the_same_through_files_and_imports() {
    let wanted = saved("saved");
    for name in ["kept", "imported"] {
        let told = told(&scenes().run, name);
        assert_eq!(told["saved"], "", "{told}");
        assert_eq!(saved(name), wanted, "{name}");
    }
}

#[test]
fn an_opened_scene_is_nodes_and_nothing_is_added_before() {
    let told = told(&scenes().run, "opened");
    let classes: Vec<String> = serde_json::from_value(told["nodes"].clone()).unwrap();
    let wanted = [
        "LumivoxVolume3D",
        "LumivoxClip3D",
        "LumivoxClip3D",
        "LumivoxVolume3D",
        "DirectionalLight3D",
        "OmniLight3D",
        "SpotLight3D",
        "Camera3D",
        "WorldEnvironment",
    ];
    assert_eq!(classes, wanted);
    assert_eq!((&told["name"], &told["added"]), (&json!("both"), &json!(1)), "{told}");
    assert!(told["progress"].as_f64().unwrap() > 0.0, "there was no progress: {told}");
    assert_eq!(told["busy"], 44, "ERR_BUSY: {told}");
    let exposure = told["exposure"].as_f64().unwrap();
    assert!((exposure - 0.35f64.exp2()).abs() < 1e-6, "{exposure}");
}

/// What was kept to more digits must not outlive a change.
#[test]
fn what_is_changed_in_the_engine_is_saved() {
    assert_eq!(told(&scenes().run, "edited")["saved"], "");
    let (before, after) = (saved("saved"), saved("edited"));
    let place = |document: &SceneDocument, i: usize| document.volumes[i].world_from_patient.unwrap();
    let moved = place(&after, 0)[0][3] - place(&before, 0)[0][3];
    assert!((moved - 250.0).abs() < 0.01, "{moved}");
    assert_eq!(place(&after, 1), place(&before, 1));
    assert_eq!(after.volumes[0].look.density, Some(0.5));
    let knot = |document: &SceneDocument| {
        document.volumes[0].look.transfer_function.as_ref().unwrap().opacity_knots()[0].value
    };
    assert_eq!(knot(&after), knot(&before) + 10.0);
    let label = |document: &SceneDocument, name: &str| {
        let styles = &document.volumes[0].labels.as_ref().unwrap().styles;
        styles.iter().find(|style| style.label == name).unwrap().clone()
    };
    let body = [&before, &after].map(|document| label(document, "body"));
    assert_eq!(body.each_ref().map(|style| style.opacity), [Some(0.7), Some(0.25)]);
    let surface = |surface: Option<Surface>| match surface {
        Some(Surface::Is(reflection)) => reflection.over(SurfaceReflection::OFF),
        other => panic!("{other:?} is not written out"),
    };
    // Of its surface, what was not changed.
    let [own_before, own_after] = body.map(|style| surface(style.surface));
    assert_eq!(own_before.roughness, 0.21);
    assert_eq!(own_after, SurfaceReflection { roughness: 0.5, ..own_before });
    // A new one is as steep as the volume's.
    let of_volume = surface(after.volumes[0].look.surface);
    let new = surface(label(&after, "air outside").surface);
    let begins =
        SurfaceReflection { strength: 1.0, roughness: 0.4, specular: 0.04, metallic: 0.0, ..of_volume };
    assert_eq!(new, begins);
    assert!(after.volumes[1].clip.is_some());
    assert_eq!((before.lights[0], before.lights[2]), (after.lights[0], after.lights[2]));
    assert_ne!(before.lights[1], after.lights[1]);
    assert_eq!(after.camera.fov, 50.0);
    assert!((after.environment.rotation - 0.5f64.to_degrees()).abs() < 1e-5);
    assert_eq!((after.environment.strength, after.film.samples), (0.77, Some(20)));
    assert_eq!(after.display.exposure, 0.35 + 0.5);
}

#[test]
fn a_scene_built_in_the_engine_is_what_the_command_shows() {
    let scenes = scenes();
    let told = told(&scenes.run, "built");
    assert_eq!(told, json!({"converged": true, "saved": ""}));
    let document = saved("built");
    assert_eq!(document.film.size, SIZE);
    assert_eq!(document.display.background, Backdrop::Environment);
    assert_eq!(document.environment.source, Path::new("built.sky.exr"));
    assert_eq!(document.display.exposure, 0.0);
    let wanted = rendered(&scenes.out.join("built.lumivox"));
    assert_same(&scenes.out, "built", &wanted, |_| true);
}

#[test]
fn imported_scans_know_their_files_until_they_forget_them() {
    let scenes = scenes();
    let told = told(&scenes.run, "imported");
    assert_eq!((&told["files"], &told["with_scan"]), (&json!(["res://scans/head"]), &json!("")), "{told}");
    let scan = &saved("with_scan").volumes[0].scan;
    let file = scenes.out.join(&scan.files[0]).canonicalize().unwrap();
    assert_eq!(file, scenes.project.join("scans/head").canonicalize().unwrap());
    assert!(told["forgotten"][0].as_str().unwrap().contains("was made in memory"), "{told}");
    assert_eq!(told["forgotten"][1], json!([]));
    assert!(!scenes.out.join("forgotten.lumivox").exists());
}

#[test]
fn what_cannot_be_opened_is_told_by_line_and_reason() {
    let told = told(&scenes().run, "faults");
    let failed = |name: &str, words: &[&str]| {
        assert_eq!(told[name][0], "failed", "{name}: {told}");
        let message = told[name][1].as_str().unwrap();
        for word in words {
            assert!(message.contains(word), "{name}: '{word}' is not in: {message}");
        }
    };
    failed("absent", &["cannot read", "absent.lumivox"]);
    failed("gone", &["gone.lumivox, line ", "gone/torso"]);
    failed("other", &["other.lumivox, line 1", "no scene of Lumivox's"]);
    failed("newer", &["newer.lumivox, line 2", "version 99"]);
    failed("typing", &["typing.lumivox, line 3", "volume"]);
    assert_eq!(told["changed"][0], "opened", "{told}");
    assert!(told["changed"][2].to_string().contains("not the scan that the scene was saved with"), "{told}");
    assert_eq!((&told["cancelled"], &told["blocking"]), (&json!(["cancelled"]), &Value::Null), "{told}");
}

#[test]
fn what_cannot_be_saved_is_told_and_leaves_files_alone() {
    let scenes = scenes();
    let told = told(&scenes.run, "faults");
    for (name, words) in [
        ("no_viewport", "it is null"),
        ("empty", "shows no volume"),
        ("made", "Made: scan 1 was made in memory: write it to a file"),
        ("parallel", "not a perspective one"),
        ("nowhere", "none/view.lumivox"),
    ] {
        let message = told[name].as_str().unwrap();
        assert!(message.contains(words), "{name}: '{words}' is not in: {message}");
    }
    // What was to take its place came to nothing.
    assert_eq!(saved("saved").volumes.len(), 2);
    let left: Vec<String> = fs::read_dir(&scenes.out)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.contains(".part") || name.contains("parallel"))
        .collect();
    assert!(left.is_empty(), "{left:?} is left");
}
