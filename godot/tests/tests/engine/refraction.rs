//! Materials that look at what is behind them see volumes there, in colour and in depth.

use std::path::PathBuf;
use std::sync::OnceLock;

use lumivox_core::glam::DVec3;
use lumivox_testing::png_io::SrgbImage;

use crate::case::{Case, Lamp, LampKind, Mesh, Output, Place, Volume, look_at};
use crate::engine::{engine, once};
use crate::expected;
use crate::shown::{Shown, assert_same};

static SHOWN: Shown = Shown::new("refraction", cases);

/// Before the volume, over a half of it and of what is beside it.
fn pane(color: [f64; 3]) -> Mesh {
    Mesh { size: [0.03, 0.03, 0.0005], place: Place::at(DVec3::new(0.006, 0.006, 0.03)), color }
}

const GREEN: [f64; 3] = [0.0, 1.0, 0.0];

fn refracting(name: &'static str) -> Case {
    Case { clear_glass: vec![pane(GREEN)], ..Case::new(name) }
}

fn reading(name: &'static str) -> Case {
    Case { volumes: vec![Volume::solid()], depth_readers: vec![pane(GREEN)], ..Case::new(name) }
}

/// Light on skin that the volume hides, and on skin beside it.
fn with_skin(name: &'static str) -> Case {
    let mesh = |x: f64, z: f64| Mesh {
        size: [0.02, 0.02, 0.002],
        place: Place::at(DVec3::new(x, 0.0, z)),
        color: [0.9, 0.7, 0.6],
    };
    let sun = Lamp::new(LampKind::Directional, look_at(DVec3::new(0.02, 0.03, 0.09), DVec3::ZERO));
    Case {
        volumes: vec![Volume::solid()],
        skin: vec![mesh(0.0, -0.03), mesh(0.035, 0.0)],
        lamps: vec![sun],
        ..Case::new(name)
    }
}

fn multisampled(case: Case) -> Case {
    Case { output: Output { msaa: 4, ..case.output }, ..case }
}

fn cases() -> Vec<Case> {
    vec![
        refracting("refracted"),
        multisampled(refracting("refracted_msaa")),
        reading("depth_read"),
        multisampled(reading("depth_read_msaa")),
        with_skin("skin"),
        multisampled(with_skin("skin_msaa")),
    ]
}

/// Whether a pixel and all around it are as `is` says.
fn all_around(case: &Case, is: impl Fn(usize) -> bool) -> Vec<bool> {
    let [width, height] = case.size.map(|n| n as usize);
    let at = |x: usize, y: usize| is(y.min(height - 1) * width + x.min(width - 1));
    let inside =
        |i: usize| (0..9).all(|n| at((i % width + n % 3).max(1) - 1, (i / width + n / 3).max(1) - 1));
    (0..width * height).map(inside).collect()
}

/// Away from edges: a pane shows its colour before the volume, and black beside it.
fn assert_depth_is_read(shown: &SrgbImage, case: &Case) {
    let film = expected::film(case);
    let panes = expected::seen(case, &case.depth_readers);
    let before = all_around(case, |i| panes[i].is_some() && film.alpha(i) > 0.98);
    let beside = all_around(case, |i| panes[i].is_some() && film.alpha(i) < 0.02);
    for (pixels, color, least) in [(before, [0, 255, 0], 200), (beside, [0, 0, 0], 50)] {
        let pixels: Vec<usize> = (0..pixels.len()).filter(|&i| pixels[i]).collect();
        assert!(pixels.len() > least, "{}: {} pixels to look at", case.name, pixels.len());
        let wrong = pixels.iter().filter(|&&i| shown.pixels[i] != color).count();
        assert_eq!(wrong, 0, "{}: of {} pixels not {color:?}", case.name, pixels.len());
    }
}

#[test]
fn refraction_shows_the_volume_behind() {
    for name in ["refracted", "refracted_msaa"] {
        // Glass that bends nothing is not seen.
        SHOWN.assert_as_expected(name);
    }
}

#[test]
fn a_shader_reads_the_depth_of_the_volume_behind() {
    for name in ["depth_read", "depth_read_msaa"] {
        assert_depth_is_read(&SHOWN.screenshot(name, ""), &SHOWN.case(name));
    }
}

#[test]
fn skin_behind_a_volume_shines_through_nowhere_and_volumes_are_no_skin() {
    for name in ["skin", "skin_msaa"] {
        let case = SHOWN.case(name);
        let film = expected::film(&case);
        assert_same(SHOWN.folder(), name, &expected::picture(&case), |i| film.alpha(i) > 0.98);
    }
}

/// Its stages are others.
#[test]
fn the_mobile_renderer_refracts_volumes_too() {
    static MOBILE: OnceLock<Option<PathBuf>> = OnceLock::new();
    let cases = || vec![refracting("refracted"), reading("depth_read")];
    let folder = once(&MOBILE, || {
        let engine = engine();
        let (folder, file) = engine.write_cases("refraction_mobile", &cases());
        let [file, out] = [&file, &folder].map(|path| path.to_str().unwrap());
        let scene =
            ["--resolution", "160x90", "res://tests/show_cases.tscn", "--", "--cases", file, "--out", out];
        engine.run("refraction_mobile", &[&["--rendering-method", "mobile"], &scene[..]].concat());
        folder.clone()
    });
    let [refracted, read] = &cases()[..] else { unreachable!() };
    assert_same(folder, refracted.name, &expected::picture(refracted), |_| true);
    let shown = SrgbImage::read(&folder.join("depth_read.png")).unwrap();
    assert_depth_is_read(&shown, read);
}
