//! Pictures that a change should not alter unnoticed. `LUMIVOX_UPDATE_GOLDEN=1` writes them anew.

use std::path::Path;

use lumivox_core::{Preset, Scene, framing};
use lumivox_renderer::{Background, DisplaySettings};
use lumivox_testing::golden::assert_golden;
use lumivox_testing::png_io::SrgbImage;
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::RenderRequest;

use crate::film;
use crate::first_pictures::head_scan;

const SIZE: u32 = 96;

/// Drivers round differently, and so take other paths here and there: the noise of that many samples is let pass.
const SAMPLES: u32 = 192;
const THRESHOLD: f64 = 0.08;

fn compare(test: &TestScene) {
    let film = film(test, &RenderRequest::new(SIZE, SIZE, SAMPLES));
    let display = DisplaySettings { background: Background::Color([0.02; 3]), ..Default::default() };
    let pixels = display.pixels(&film, &test.scene.environment, &test.camera);
    let image = SrgbImage {
        width: SIZE as usize,
        height: SIZE as usize,
        pixels: pixels.iter().map(|p| [p[0], p[1], p[2]]).collect(),
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{}.png", test.name));
    assert_golden(&path, &image, THRESHOLD);
}

#[test]
fn a_test_scene_looks_as_it_did() {
    compare(&scenes::overlapping_volumes());
}

#[test]
#[ignore = "slow: script/test --all"]
fn test_scenes_look_as_they_did() {
    [scenes::glossy_surface(), scenes::tricubic()].iter().for_each(compare);
}

fn compare_phantom(name: &'static str, preset: Preset) {
    let volume = head_scan();
    let medium = preset.medium(&volume);
    let scene = Scene::with_volume(volume, medium);
    let camera = framing::frame(&scene, 0.5, 0.1, 0.5, 1.0).camera();
    compare(&TestScene { name, scene, camera });
}

#[test]
fn the_phantom_looks_as_it_did() {
    compare_phantom("phantom_skin", Preset::CtSkin);
}

#[test]
#[ignore = "slow: script/test --all"]
fn the_phantom_looks_as_it_did_in_other_presets() {
    compare_phantom("phantom_muscle", Preset::CtMuscle);
    compare_phantom("phantom_bone", Preset::CtBone);
}
