//! Scene documents: opened, asked for all that they say, and made of a world again.

use lumivox_unity::saving::*;
use lumivox_unity::scene::*;
use lumivox_unity::scene_light::*;

use super::*;

/// 4 x 5 x 6 voxels with a document beside them.
fn write(folder: &Path, document: &str) -> CString {
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 5 6\nspace directions: (1,0,0) \
                  (0,1,0) (0,0,2)\nspace origin: (3,4,5)\nencoding: raw\n\n";
    let voxels = (0..120).collect::<Vec<u8>>();
    std::fs::write(folder.join("scan.nrrd"), [header.as_bytes(), &voxels].concat()).unwrap();
    let path = folder.join("scene.lumivox");
    std::fs::write(&path, document).unwrap();
    CString::new(path.to_str().unwrap()).unwrap()
}

const DOCUMENT: &str = r#"{"lumivox_scene": 1, "volumes": [{"scan": {"files": ["scan.nrrd"], "keep": "everything"},
    "look": {"transfer_function": {"opacity": [[0.1, 0.2], [50, 0.7]], "color": [[0, [0.1, 0.6, 0.9]]]}, "density": 3.3, "albedo": 0.9,
    "anisotropy": 0.1, "bounces": 5, "surface": false}, "clip": [[0.1, 0, 0], [1, 0.8, 0.9]],
    "clip_shapes": [{"kind": "box", "from_shape": [[2, 0, 0, 4], [0, 2, 0, 5], [0, 0, 3, 8]]}]}],
    "lights": [{"kind": "spot", "lamp": {"position": [100, 200, 300], "intensity": [1, 2, 3], "radius": 10}, "direction": [0, -1, 0],
    "half_angle": 20, "cone": {"attenuation": 0.5}, "layers": 3}],
    "environment": {"source": "gradient", "rotation": 30, "strength": 1.5},
    "camera": {"world_from_camera": [[1, 0, 0, 10], [0, 1, 0, 20], [0, 0, 1, 300]], "fov": 25},
    "film": {"size": [30, 20], "samples": 9, "seed": 4, "noise": 0.05, "denoise": true},
    "display": {"background": "environment", "exposure": 0.7, "tone": "aces", "gamma": 1.2}}"#;

fn pose() -> LumivoxPose {
    LumivoxPose { position: [0.0; 3], rotation: [0.0; 4], scale: [0.0; 3] }
}

/// What a job has opened, or why it has not.
fn open(path: &CString) -> Result<*mut LumivoxScene, String> {
    // SAFETY: a live handle, freed once.
    unsafe {
        let job = lumivox_scene_open(path.as_ptr(), 0);
        let state = wait(job);
        let (scene, error) = (lumivox_job_take_scene(job), take_text(lumivox_job_error(job)));
        lumivox_job_free(job);
        if state == LumivoxJobState::Done { Ok(scene) } else { Err(error) }
    }
}

#[test]
fn a_document_goes_through_the_border_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), DOCUMENT);
    let saved = CString::new(folder.path().join("saved.lumivox").to_str().unwrap()).unwrap();
    // SAFETY: all handles are live, and freed once; places can be written.
    unsafe {
        assert_eq!(lumivox_scene_is_one(path.as_ptr()), 1);
        let scene = open(&path).unwrap();
        assert_eq!(lumivox_scene_volume_count(scene), 1);
        assert_eq!(take_text(lumivox_scene_files(scene)).lines().count(), 1);
        take_text(lumivox_scene_notes(scene));
        let (mut own, mut at) = (instance(null()), pose());
        assert_eq!(lumivox_scene_instance(scene, 0, &mut own, &mut at), 0, "{}", last_error());
        assert_eq!((at.position, at.scale, own.clip_count), ([0.0; 3], [1.0; 3], 1));
        let mut shape = LumivoxClipShape { world_from_shape: IDENTITY, kind: 9, inverted: 9 };
        assert_eq!(lumivox_scene_clip(scene, 0, 0, &mut shape, &mut at), 0);
        assert_eq!((shape.kind, shape.inverted), (1, 0));
        assert_eq!(lumivox_scene_clip(scene, 0, 1, &mut shape, &mut at), -1);
        assert_eq!(lumivox_scene_clip(scene, 0, 0, &mut shape, &mut at), 0);
        assert_eq!((lumivox_scene_style_count(scene, 0), lumivox_scene_light_count(scene)), (0, 1));
        let mut light = std::mem::MaybeUninit::<LumivoxLight>::zeroed();
        assert_eq!(lumivox_scene_light(scene, 0, light.as_mut_ptr(), &mut at), 0);
        let light = light.assume_init();
        assert_eq!((light.position, light.direction), ([0.1, 0.2, -0.3], [0.0, -1.0, 0.0]));
        let mut around = studio();
        assert_eq!(lumivox_scene_environment(scene, &mut around), 0);
        let mut view = std::mem::MaybeUninit::<LumivoxSavedView>::zeroed();
        assert_eq!(lumivox_scene_view(scene, view.as_mut_ptr(), &mut at), 0);
        let mut view = view.assume_init();
        assert_eq!((at.position, view.width, view.background), ([0.01, 0.02, -0.3], 30, 1));
        // Unity's cameras look along -z of a space that is right-handed.
        assert_eq!(view.world_from_camera[10], -1.0);
        own.volume = lumivox_scene_volume(scene, 0);
        own.transfer_function = lumivox_scene_transfer_function(scene, 0);
        assert!(lumivox_scene_labels(scene, 0).is_null() && last_error().is_empty());
        lumivox_scene_free(scene);
        let stage = stage();
        assert_eq!(lumivox_stage_set_world(stage, 1, &own, 1, &shape, 1, &light, 1, &around), 0);
        assert_eq!(
            lumivox_stage_save_world(stage, 1, &view, 1.0, null(), saved.as_ptr()),
            0,
            "{}",
            last_error()
        );
        let [before, after] = [&path, &saved].map(|path| {
            let text = std::fs::read_to_string(path.to_str().unwrap()).unwrap();
            lumivox_core::document::SceneDocument::parse(&text).unwrap()
        });
        assert_eq!((after.camera, after.film, after.display), (before.camera, before.film, before.display));
        assert_eq!((&after.lights, &after.environment.strength), (&before.lights, &1.5));
        assert_eq!(after.environment.rotation, 30.0);
        let [old, new] = [&before.volumes[0], &after.volumes[0]];
        assert_eq!((new.clip, &new.scan.files), (old.clip, &old.scan.files));
        assert!(new.scan.content.as_ref().is_some_and(|hash| hash.starts_with("sha256:")));
        assert_eq!(new.look.transfer_function, old.look.transfer_function);
        assert_eq!((new.look.density, new.look.anisotropy), (Some(3.3), Some(0.1)));
        // A bright engine's light is divided.
        assert_eq!(lumivox_stage_save_world(stage, 1, &view, 2.0, null(), saved.as_ptr()), 0);
        let text = std::fs::read_to_string(saved.to_str().unwrap()).unwrap();
        let darker = lumivox_core::document::SceneDocument::parse(&text).unwrap();
        assert_eq!(darker.environment.strength, 0.75);
        // What makes no document is told.
        assert_eq!(lumivox_stage_save_world(stage, 7, &view, 1.0, null(), saved.as_ptr()), -1);
        view.gamma = 99.0;
        assert_eq!(lumivox_stage_save_world(stage, 1, &view, 1.0, null(), saved.as_ptr()), -1);
        assert!(last_error().contains("gamma"), "{}", last_error());
        lumivox_volume_free(own.volume.cast_mut());
        lumivox_transfer_function_free(own.transfer_function.cast_mut());
        lumivox_stage_free(stage);
    }
}

#[test]
fn a_map_keeps_its_file_and_texels() {
    let texels: Vec<f32> = (0..24).map(|i| i as f32).collect();
    let mut size = [0u32; 2];
    // SAFETY: a live handle, freed once; places can be written.
    unsafe {
        let map = lumivox_map_new(4, 2, texels.as_ptr());
        assert_eq!(take_text(lumivox_map_file(map)), "");
        assert_eq!(lumivox_map_set_file(map, c"/light.exr".as_ptr()), 0);
        assert_eq!(take_text(lumivox_map_file(map)), "/light.exr");
        let own = lumivox_map_texels(map, size.as_mut_ptr());
        assert_eq!(std::slice::from_raw_parts(own, 24), texels);
        lumivox_map_free(map);
    }
    assert_eq!(size, [4, 2]);
}

#[test]
fn what_is_wrong_with_a_scene_is_told_by_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(
        folder.path(),
        "{\n\"lumivox_scene\": 1, \"volumes\": [{\n\"scan\": {\"files\": [\"none.nrrd\"]}}]}",
    );
    let error = open(&path).unwrap_err();
    assert!(error.contains("scene.lumivox, line 3, column 19: ") && error.contains("none.nrrd"), "{error}");
    let path = write(folder.path(), "{\"lumivox_scene\": 9}");
    assert!(open(&path).unwrap_err().contains("line 1"));
    std::fs::write(path.to_str().unwrap(), b"LUMIVOX1\xff\xff").unwrap();
    assert!(open(&path).unwrap_err().contains("scene.lumivox is no scene of Lumivox"));
    // SAFETY: null is allowed everywhere.
    unsafe {
        lumivox_scene_free(null_mut());
        assert!(lumivox_scene_open(null(), 0).is_null() && lumivox_job_take_scene(null_mut()).is_null());
        assert_eq!((lumivox_scene_is_one(null()), lumivox_scene_volume_count(null())), (-1, 0));
        assert!(lumivox_scene_volume(null(), 0).is_null() && lumivox_scene_labels(null(), 0).is_null());
        assert!(lumivox_scene_notes(null()).is_null() && lumivox_scene_files(null()).is_null());
        assert!(lumivox_scene_transfer_function(null(), 0).is_null());
        assert_eq!(lumivox_scene_instance(null(), 0, null_mut(), null_mut()), -1);
        assert_eq!(lumivox_scene_clip(null(), 0, 0, null_mut(), null_mut()), -1);
        assert_eq!((lumivox_scene_style_count(null(), 0), lumivox_scene_light_count(null())), (0, 0));
        assert_eq!(lumivox_scene_style(null(), 0, 0, null_mut()), -1);
        assert_eq!(lumivox_scene_light(null(), 0, null_mut(), null_mut()), -1);
        assert_eq!(lumivox_scene_environment(null(), null_mut()), -1);
        assert_eq!(lumivox_scene_view(null(), null_mut(), null_mut()), -1);
        assert_eq!(lumivox_stage_save_world(null(), 1, null(), 1.0, null(), null()), -1);
        assert_eq!(lumivox_map_set_file(null_mut(), null()), -1);
        assert!(lumivox_map_file(null()).is_null() && lumivox_map_texels(null(), null_mut()).is_null());
        assert_eq!(lumivox_stored_copy_nameless(null(), null()), -1);
    }
}
