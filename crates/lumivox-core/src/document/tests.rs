use glam::{DAffine3, DVec3};

use super::*;
use crate::{
    Cone, EnvironmentMap, EnvironmentSource, Filter, Label, LabelStyle, LabelVolume, Labelling, Lamp, Light,
    LightKind, Modality, PerspectiveCamera, Preset, Scene, Volume, VolumeInstance, Voxels,
    labels::LabelSource,
};
use std::{path::Path, sync::Arc};

mod schema;
mod words;

const FULL: &str = r##"{
  "lumivox_scene": 1,
  "volumes": [
    {
      "scan": {
        "files": ["scans/head"],
        "series": "1.2.3",
        "taken_off": {"skin": 3}
      },
      "look": {"preset": "ct-bone", "window": [40, 400], "surface": false},
      "labels": {
        "files": ["liver.seg.nrrd"],
        "styles": [
          {"label": "*", "visible": false},
          {"label": "liver", "visible": true, "color": true, "opacity": 0.5}
        ]
      },
      "clip_shapes": [{"kind": "sphere", "space": "world", "from_shape": [[9, 0, 0, 0], [0, 9, 0, 5], [0, 0, 9, 0]]}]
    }
  ],
  "environment": {"source": "sky.hdr", "strength": 0.5},
  "lights": [{"kind": "sun", "direction": [0, -1, 0], "irradiance": [3, 3, 3]}],
  "camera": {"azimuth": 30},
  "film": {"size": [320, 240], "samples": 16},
  "display": {"background": "transparent", "tone": "aces"}
}
"##;

fn error(text: &str) -> (usize, String) {
    let error = SceneDocument::parse(text).unwrap_err();
    (error.line, error.why)
}

#[test]
fn a_document_says_what_is_not_the_default() {
    let document = SceneDocument::parse(FULL).unwrap();
    let entry = &document.volumes[0];
    assert_eq!(entry.scan.taken_off, Some(TakenOff::Skin(3.0)));
    assert_eq!((entry.look.preset, entry.look.window), (Some(Preset::CtBone), Some([40.0, 400.0])));
    assert_eq!((entry.layers, entry.scan.keep), (1, Keep::Patient));
    assert_eq!(document.environment.file(), Some(Path::new("sky.hdr")));
    assert_eq!(
        document.display,
        Display { background: Backdrop::Transparent, tone: Tone::Aces, ..Display::default() }
    );
    assert_eq!(SceneDocument::parse(&document.to_json().unwrap()).unwrap(), document);
    assert_eq!(SceneDocument::parse("{\"lumivox_scene\": 1}").unwrap(), SceneDocument::default());
    assert!(SceneDocument::is_one(FULL.as_bytes()) && !SceneDocument::is_one(b"{\"a\": 1}"));
}

#[test]
fn what_is_wrong_is_told_by_its_line() {
    let without = |old: &str, new: &str| {
        assert!(FULL.contains(old), "{old}");
        error(&FULL.replacen(old, new, 1))
    };
    for (old, new, line, word) in [
        (
            "\"files\": [\"scans/head\"]",
            "\"file\": [\"scans/head\"]",
            6,
            "there is no key 'file' here, did you mean 'files'?",
        ),
        ("\"preset\": \"ct-bone\"", "\"preset\": \"ct-bome\"", 10, "did you mean 'ct-bone'"),
        ("[40, 400]", "[40, 0]", 10, "a width above 0"),
        ("\"opacity\": 0.5", "\"opacity\": 1.5", 15, "opacity is 1.5, and must be 0 to 1"),
        ("[0, 0, 9, 0]]", "[0, 0, 0, 0]]", 18, "from_shape is no place"),
        ("\"source\": \"sky.hdr\"", "\"source\": \"studoi\"", 21, "studio, uniform, gradient"),
        ("\"direction\": [0, -1, 0]", "\"direction\": [0, 0, 0]", 22, "direction is zero"),
        ("\"azimuth\": 30", "\"azimuth\": 30, \"eye\": [1, 2, 3]", 23, "leave azimuth"),
        ("[320, 240]", "[0, 240]", 24, "0 x 240 is no image"),
        ("\"transparent\"", "\"blak\"", 25, "the background 'blak'"),
        ("\"lumivox_scene\": 1", "\"lumivox_scene\": 2", 2, "a newer Lumivox opens it"),
        ("\"lumivox_scene\": 1", "\"lumivox\": 1", 1, "this is no scene of Lumivox's"),
        ("\"files\": [\"scans/head\"],", "", 5, "a scan has files"),
        (
            "\"irradiance\": [3, 3, 3]",
            "\"irradiance\": [3, 3, 3], \"color\": 1",
            22,
            "there is no key 'color' here; there are kind",
        ),
    ] {
        let (at, why) = without(old, new);
        assert!(at == line && why.contains(word), "{new}: line {at}, not {line}: {why}");
    }
    assert_eq!(error("").0, 1);
}

/// A volume that is said to come from a file.
fn volume() -> Arc<Volume> {
    let place = DAffine3::from_scale(DVec3::new(50.0, 60.0, 70.0));
    let samples = Voxels::U16((0..64).map(|i| i * 40).collect());
    let volume = Volume::new([4; 3], samples, [1.0, -1000.0], place, Modality::Ct).unwrap();
    Arc::new(volume.with_source(Scan::of_files(vec!["head.nii".into()])))
}

/// A scene with all that scenes can have.
fn scene() -> Scene {
    let volume = volume();
    let mut medium = Preset::CtMuscle.medium(&volume);
    medium.filter = Filter::Nearest;
    medium.density_scale /= 3.0;
    let label = |value, name: &str| Label { value, name: name.into(), color: [0.1, 0.2, 0.3] };
    let labels = vec![label(1, "liver"), label(2, "liver"), label(3, "bone")];
    let labels = LabelVolume::new([1, 1, 3], vec![1, 2, 3], DAffine3::IDENTITY, labels).unwrap();
    let numbers = vec![(100, 1), (2, 2), (7, 3)];
    let labels =
        labels.with_source(LabelSource { files: vec!["l.nrrd".into()], numbers, ..LabelSource::default() });
    let mut labelling = Labelling::new(Arc::new(labels));
    labelling.set_style(1, LabelStyle { color: Some([0.5, 0.25, 1.0 / 3.0]), ..LabelStyle::hidden() });
    labelling.set_style(3, LabelStyle { density_scale: Some(0.7), clipped: false, ..LabelStyle::default() });
    labelling.set_style(0, LabelStyle { opacity: 0.1, ..LabelStyle::default() });
    let lamp = Lamp { radius: 0.013, ..Lamp::new(DVec3::new(0.1, 0.7, -0.3), [1.0, 0.3, 0.1]) };
    let spot = |cone| LightKind::Spot { lamp, direction: DVec3::new(1.0, 2.0, 3.0), half_angle: 0.7, cone };
    let turn = DAffine3::from_rotation_y(0.3) * crate::world_from_patient();
    let instance = VolumeInstance {
        labels: Some(labelling),
        layers: 6,
        clip_box: [DVec3::splat(0.1), DVec3::splat(1.0 / 3.0 + 0.5)],
        clip_shapes: vec![crate::ClipShape::sphere(DVec3::new(1.0, 2.0, 3.0), 17.3).invert()],
        ..VolumeInstance::new(volume.clone(), medium, turn)
    };
    Scene {
        volumes: vec![instance, VolumeInstance::centered(volume.clone(), Preset::CtBone.medium(&volume))],
        environment: crate::Environment { rotation: 0.7, strength: 1.1, ..crate::Environment::uniform(1.0) },
        lights: vec![
            Light::directional(DVec3::new(0.3, -0.2, 0.9), [1.0, 2.0, 3.0]),
            Light { layers: 2, ..Light::point(lamp) },
            spot(Cone::Power { attenuation: 0.5 }).into(),
            spot(Cone::Between { inner_half_angle: 0.3 }).into(),
        ],
    }
}

/// A scene comes back from its document, but for the last bit of what is counted in other units.
#[test]
fn a_scene_comes_back() {
    let scene = scene();
    let document = SceneDocument::of(&scene).unwrap();
    let names: Vec<&str> = document.volumes[0]
        .labels
        .as_ref()
        .unwrap()
        .styles
        .iter()
        .map(|style| style.label.as_str())
        .collect();
    assert_eq!(names, ["#100", "bone", "unlabelled"], "two labels have the name liver");
    let back = SceneDocument::parse(&document.to_json().unwrap()).unwrap();
    assert_eq!(back, document, "no number changes on its way through text");

    for (entry, instance) in back.volumes.iter().zip(&scene.volumes) {
        assert_eq!(entry.look.medium(&instance.volume), instance.medium);
        let world = world_from_patient(entry.world_from_patient.unwrap());
        assert!(world.abs_diff_eq(instance.world_from_patient, 1e-15));
        let shapes: Vec<_> = entry.clip_shapes.iter().map(|shape| shape.placed(world)).collect();
        assert_eq!(shapes, instance.clip_shapes);
    }
    for (lighting, light) in back.lights.iter().zip(&scene.lights) {
        let ([a, b], [c, d]) = ([lighting.light(), *light].map(|l| format!("{:.12?}", l)), ["", ""]);
        assert_eq!((a, c), (b, d));
    }
    let environment = back.environment.environment(None);
    assert!((environment.rotation - 0.7).abs() < 1e-15 && environment.source == scene.environment.source);
    let camera = PerspectiveCamera::look_at(DVec3::new(0.3, 0.2, 0.9), DVec3::ZERO, DVec3::Y, 0.5);
    let back = View::of(&camera).camera(&scene, 1.5).unwrap();
    assert!(back.world_from_camera.abs_diff_eq(camera.world_from_camera, 1e-15));
    assert!((back.vertical_fov - 0.5).abs() < 1e-15);
}

#[test]
fn what_has_no_file_cannot_be_saved() {
    let mut scene = scene();
    scene.volumes[1].volume = Arc::new(Volume::clone(&scene.volumes[1].volume).edit(|_| ()).unwrap());
    assert!(SceneDocument::of(&scene).is_ok(), "an altered copy is still of its file");
    let map = EnvironmentMap::from_fn(2, 1, |_| [1.0; 3]);
    scene.environment.source = EnvironmentSource::Map(Arc::new(map.clone()));
    assert_eq!(SceneDocument::of(&scene), Err(Unsaved::Map));
    scene.environment.source = EnvironmentSource::Map(Arc::new(map.with_file(Path::new("sky.exr"))));
    assert_eq!(SceneDocument::of(&scene).unwrap().environment.file(), Some(Path::new("sky.exr")));
    let place = DAffine3::IDENTITY;
    let bare = Volume::new([1; 3], Voxels::U8(vec![0]), [1.0, 0.0], place, Modality::Other).unwrap();
    scene.volumes[1].volume = Arc::new(bare);
    let error = SceneDocument::of(&scene).unwrap_err();
    assert!(error.to_string().starts_with("scan 2 was made in memory"), "{error}");
}

#[test]
fn looks_begin_with_what_suits_and_end_with_what_is_said() {
    let volume = volume();
    let suits = Preset::default_for(&volume).medium(&volume);
    let look = Look::default().medium(&volume);
    assert_eq!(look, crate::Medium { filter: Filter::Smooth, ..suits.clone() });
    let look = Look {
        density: Some(0.25),
        shift: Some(10.0),
        surface: Some(Surface::Switched(false)),
        ..Look::default()
    };
    let medium = look.medium(&volume);
    assert_eq!((medium.density_scale, medium.surface.strength), (0.25, 0.0));
    assert_eq!(medium.transfer_function, suits.windowed(10.0, 1.0).transfer_function);
}

#[test]
fn what_is_not_said_of_a_surface_is_as_the_look_has_it() {
    let text = r#"{"$schema": "scene.schema.json", "lumivox_scene": 1, "volumes": [{"scan": {"files": ["a"]},
        "look": {"preset": "ct-bone", "surface": {"metallic": 1}},
        "labels": {"files": ["b"], "styles": [{"label": "*", "surface": {"roughness": 0.1}}]}}]}"#;
    let document = SceneDocument::parse(text).unwrap();
    assert!(document.to_json().unwrap().contains("\"$schema\": \"scene.schema.json\""));
    let entry = &document.volumes[0];
    let (volume, preset) = (volume(), Preset::CtBone.medium(&volume()).surface);
    let surface = entry.look.medium(&volume).surface;
    assert_eq!(surface, crate::SurfaceReflection { metallic: 1.0, ..preset });
    let mut style = crate::LabelStyle::default();
    entry.labels.as_ref().unwrap().styles[0].apply(None, &volume, surface, &mut style);
    assert_eq!(style.surface, Some(crate::SurfaceReflection { roughness: 0.1, ..surface }));
    let all = Look::of_medium(&entry.look.medium(&volume));
    assert_eq!(all.medium(&volume).surface, surface, "written out");
}

#[test]
fn lists_of_numbers_take_a_line() {
    assert_eq!(
        numbers::compact("{\"a\": [\n  1,\n  2.5\n], \"b\": [\n  \"x\"\n]}"),
        "{\"a\": [1, 2.5], \"b\": [\n  \"x\"\n]}"
    );
    assert_eq!(numbers::compact("[\n  [\n    1\n  ],\n  []\n]"), "[\n  [1],\n  []\n]");
    // Names are left alone, whatever they hold.
    let named = r#"{"files": ["a [1,2].nii", "b\"[ 3,  4 ]"], "x": "\\"}"#;
    assert_eq!(numbers::compact(named), named);
    let long = format!("[\n{}0\n]", "1234567,\n".repeat(20));
    assert_eq!(numbers::compact(&long), long);
}

#[cfg(unix)]
#[test]
fn names_that_are_no_unicode_load_and_cannot_be_written_down() {
    use std::os::unix::ffi::OsStrExt;
    let name = std::ffi::OsStr::from_bytes(b"M\xfcller.nii");
    let volumes = vec![Entry::new(Scan::of_files(vec![name.into()]))];
    assert!(SceneDocument { volumes, ..SceneDocument::default() }.to_json().is_err());
}
