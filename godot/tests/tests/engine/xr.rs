//! What a headset's eyes see is what the renderer makes of the scene from there, pixel by pixel.
//!
//! The headset is Monado's simulated one, whose head never rests: every frame is another view of the scene. With few
//! pixels and samples a frame is done at once, so each is a whole picture from a known place, or something is wrong.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use lumivox_core::glam::{DMat3, DVec3};
use lumivox_testing::png_io::SrgbImage;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::case::{Case, Mesh, Place, Volume, look_at};
use crate::engine::{Run, Start, engine, once};
use crate::expected;
use crate::shown::{distance, told};

/// Errors of the engine itself when it ends an OpenXR session.
const AT_EXIT: &[&str] = &[
    "XR_ERROR_SESSION_NOT_STOPPING",
    "Attempt to disconnect a nonexistent connection from '<OpenXR",
    "RID allocations of type 'N9OpenXRAPI",
    // Monado, of what it works around.
    "no_validation_error",
];

/// What a headset's run tells.
#[derive(Deserialize)]
struct Seen {
    views: usize,
    frames: u32,
    /// Frames in which an eye was elsewhere than in the one before.
    moved: u32,
    /// Frames whose image was not done.
    unfinished: u32,
    eyes: Vec<Eye>,
}

#[derive(Deserialize)]
struct Eye {
    size: [u32; 2],
    place: [f64; 12],
    tangents: [f64; 4],
}

/// Half a metre away: soft tissue before and behind a turned block, and a mesh across both.
fn case() -> Case {
    let place = |angle: f64, size: f64, x: f64, z: f64| {
        Place::new(DMat3::from_rotation_y(angle) * size, DVec3::new(x, 0.0, z))
    };
    let volume = |place| Volume { place, ..Volume::soft() };
    Case {
        samples: 8,
        // Time enough on a busy machine, too.
        budget: 2000.0,
        // As scenes are by default.
        kept_light: true,
        camera: look_at(DVec3::new(0.1, 0.12, 0.8), DVec3::ZERO),
        volumes: vec![volume(place(0.3, 24.0, -0.12, 0.0)), volume(place(0.9, 16.0, 0.28, 0.2))],
        meshes: vec![Mesh {
            size: [0.5, 0.03, 0.03],
            place: place(0.5, 1.0, 0.0, 0.05),
            color: [0.8, 0.1, 0.1],
        }],
        ..Case::new("eyes")
    }
}

/// What was seen, and the folder of pictures.
fn seen() -> &'static (Seen, PathBuf) {
    static SEEN: OnceLock<Option<(Seen, PathBuf)>> = OnceLock::new();
    once(&SEEN, || {
        let (_, folder) = run_in_headset("headset", "show_in_headset", &[case()], &["--scale", "0.3"]);
        let seen = serde_json::from_slice(&fs::read(folder.join("eyes.json")).unwrap()).unwrap();
        (seen, folder)
    })
}

/// Runs a scene of `project/` in a simulated headset.
fn run_in_headset(name: &str, scene: &str, cases: &impl Serialize, options: &[&str]) -> (Run, PathBuf) {
    let monado = Monado::find();
    let engine = engine();
    let (folder, file) = engine.write_cases(name, cases);
    let service = monado.start(&folder.join("monado.log"));
    let scene = format!("res://tests/{scene}.tscn");
    let [project, cases, out] = [&engine.project, &file, &folder].map(|path| path.to_str().unwrap());
    let arguments = ["--path", project, "--xr-mode", "on", &scene, "--", "--cases", cases, "--out", out];
    let start = Start {
        environment: vec![
            ("XDG_RUNTIME_DIR", service.folder.clone().into()),
            ("XR_RUNTIME_JSON", monado.manifest.clone().into()),
            ("NODEVICE_SELECT", "1".into()),
        ],
        excused: AT_EXIT,
        ..Start::default()
    };
    let run = engine.run_as(&engine.godot, name, &[&arguments[..], options].concat(), &start);
    (run, folder)
}

/// An OpenXR runtime that simulates a headset.
struct Monado {
    service: PathBuf,
    manifest: PathBuf,
}

impl Monado {
    /// The one that `MONADO` names, its manifest beside it, or the system's.
    fn find() -> Self {
        if let Some(service) = std::env::var_os("MONADO").map(PathBuf::from) {
            let manifest = service.with_file_name("openxr_monado.json");
            assert!(service.exists() && manifest.exists(), "MONADO={} is not there", service.display());
            return Self { service, manifest };
        }
        let path = std::env::var_os("PATH").unwrap_or_default();
        let service = std::env::split_paths(&path).map(|f| f.join("monado-service")).find(|f| f.exists());
        let manifest = PathBuf::from("/usr/share/openxr/1/openxr_monado.json");
        let found = service.filter(|_| manifest.exists()).map(|service| Self { service, manifest });
        found.expect(
            "Monado is needed to simulate a headset. Debian: apt-get install monado-service libopenxr1-monado; \
             or name one (MONADO=/path/to/monado-service cargo test)",
        )
    }

    fn start(&self, log: &Path) -> Service {
        // A socket's path must be short, and its folder nobody else's.
        let folder = std::env::temp_dir().join(format!("lumivox-headset-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir(&folder).unwrap();
        #[cfg(unix)]
        fs::set_permissions(&folder, std::os::unix::fs::PermissionsExt::from_mode(0o700)).unwrap();
        let file = fs::File::create(log).unwrap();
        let process = Command::new(&self.service)
            .env("XDG_RUNTIME_DIR", &folder)
            .env("XRT_COMPOSITOR_NULL", "1")
            .env("SIMULATED_ENABLE", "1")
            .env("XRT_NO_STDIN", "1")
            .env("NODEVICE_SELECT", "1")
            .stdin(Stdio::null())
            .stdout(file.try_clone().unwrap())
            .stderr(file)
            .spawn()
            .unwrap_or_else(|e| panic!("{}: {e}", self.service.display()));
        let mut service = Service { process, folder };
        let begin = Instant::now();
        while !service.folder.join("monado_comp_ipc").exists() {
            let ended = service.process.try_wait().unwrap().is_some();
            let late = begin.elapsed() > Duration::from_secs(30);
            assert!(!ended && !late, "Monado does not start; it says\n{}", fs::read_to_string(log).unwrap());
            std::thread::sleep(Duration::from_millis(20));
        }
        service
    }
}

/// Monado at work.
struct Service {
    process: Child,
    folder: PathBuf,
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// A picture of linear RGB in single precision, as the script writes it.
fn read_linear(path: &Path, [width, height]: [u32; 2]) -> SrgbImage {
    let bytes = fs::read(path).unwrap();
    let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(|&b| f32::from_le_bytes(b).into()).collect();
    SrgbImage::from_linear(width as usize, height as usize, numbers.as_chunks().0)
}

#[test]
fn each_eye_sees_the_volumes_from_where_it_is() {
    let (seen, folder) = seen();
    assert_eq!((seen.views, seen.eyes.len()), (2, 2));
    let mut pictures = vec![];
    for (i, eye) in seen.eyes.iter().enumerate() {
        let case = Case { size: eye.size, camera: Place(eye.place), tangents: Some(eye.tangents), ..case() };
        let shown = read_linear(&folder.join(format!("eyes_{i}.f32")), eye.size);
        let wanted = expected::picture(&case);
        shown.write(&folder.join(format!("eyes_{i}.png"))).unwrap();
        wanted.write(&folder.join(format!("eyes_{i}_wanted.png"))).unwrap();
        let (mean, far, _) = distance(&shown, &wanted, |_| true);
        println!("eye {i}: differs by {mean:.3} of 255 on average, by more than 2 in {:.2}%", far * 100.0);
        // The engine tells an eye's place in single precision, so a few more edges fall on another pixel.
        assert!(mean < 1.0 && far < 0.02, "eye {i}: differs by {mean} of 255, in {far} of all pixels");
        pictures.push((shown, wanted));
    }
    let (mean, far, _) = distance(&pictures[0].0, &pictures[1].1, |_| true);
    assert!(far > 0.04, "the left eye's picture would pass as the right eye's: {mean}, {far}");
}

#[test]
fn a_moving_head_gets_whole_pictures() {
    let (seen, _) = seen();
    assert!(seen.moved * 10 >= seen.frames * 9, "the head moved in {} of {} frames", seen.moved, seen.frames);
    assert!(
        seen.unfinished * 2 < seen.frames,
        "{} of {} frames were not done, though each fits into its time",
        seen.unfinished,
        seen.frames
    );
}

#[test]
fn the_vr_scene_is_grabbed_scaled_and_cut_and_can_be_left() {
    let (run, _) = run_in_headset("vr", "use_vr", &json!([]), &[]);
    let told = told(&run, "vr");
    let eyes = told["eyes"].as_array().unwrap();
    assert_eq!(eyes.len(), 2, "{told}");
    let [left, right] = [0, 1].map(|eye| {
        // 20 cm by 30 cm of them in a picture of about 160 cm by 160 cm at that distance.
        let share = eyes[eye]["share"].as_f64().unwrap();
        assert!(share > 0.01 && share < 0.1, "eye {eye} sees the head in {share} of its picture");
        eyes[eye]["middle"].as_f64().unwrap()
    });
    // The eyes are 6.3 cm apart, the head is 80 cm away: it stands farther to the right for the left one.
    println!("the head is seen at {left:.4} and {right:.4}");
    assert!((left - right - 0.063 / 0.8).abs() < 0.01, "{told}");
    let checks = told.as_object().unwrap();
    let failed: Vec<_> =
        checks.iter().filter(|(what, ok)| *what != "eyes" && **ok != true).map(|(what, _)| what).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert_eq!(checks.len(), 13, "some checks were left out: {checks:#?}");
}
