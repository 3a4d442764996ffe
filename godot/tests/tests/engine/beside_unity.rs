//! The live scenes that the Unity package is compared by (`TwinLiveTests` of `unity/standin/tests/TwinTests.cs`), in Godot: the
//! same camera, looks, light and size, under a linear tone map.
//!
//! Both are compared with the wgpu host elsewhere; these are of the manual's size, and slow.
//!
//! `script/unity --pictures Godot` keeps what Godot shows beside the package's own pictures.

use std::path::{Path, PathBuf};

use lumivox_core::glam::{DMat3, DVec3};
use lumivox_testing::png_io::{SrgbImage, linear_from_srgb};

use crate::case::{Case, Light, Mesh, Output, Place, Volume, look_at};
use crate::expected;
use crate::shown::Shown;

/// Pixels along a side, and samples of each, as `script/unity --pictures` makes the package's.
const SIDE: u32 = 160;
const SAMPLES: u32 = 64;

/// Unity's rotation by angles in degrees, which is about z, then x, then y; seen in the mirror that z is turned around in.
fn turned(x: f64, y: f64, z: f64) -> DMat3 {
    let [x, y, z] = [-x, -y, z].map(f64::to_radians);
    DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x) * DMat3::from_rotation_z(z)
}

/// A head, and what both scenes have in common.
fn head(name: &'static str, size: usize, look: &'static str, rotation: DMat3) -> Case {
    let volume = Volume {
        phantom: "head",
        size,
        look,
        place: Place::new(rotation, DVec3::ZERO),
        filter: 3,
        ..Volume::soft()
    };
    Case {
        size: [SIDE; 2],
        samples: SAMPLES,
        camera: look_at(DVec3::new(0.05, 0.04, 0.3), DVec3::ZERO),
        fov: 40.0,
        // A colour of Unity's is sRGB.
        light: Light::Color([0.02, 0.05, 0.1].map(linear_from_srgb)),
        studio: true,
        volumes: vec![volume],
        // What the engine converts, it rounds down.
        output: Output { hdr: true, ..Case::new("").output },
        ..Case::new(name)
    }
}

fn cases() -> Vec<Case> {
    // A plane without an end is a large box here, whose face is where the plane is.
    const THICK: f64 = 0.01;
    let normal = DVec3::new(0.4, 0.0, 1.0).normalize();
    let across = DVec3::Y.cross(normal);
    let face = Place::new(
        DMat3::from_cols(across, DVec3::Y, normal),
        DVec3::new(0.05, 0.0, 0.02) - normal * (THICK / 2.0),
    );
    let plane = Mesh { size: [8.0, 8.0, THICK], place: face, color: [0.2, 0.4, 0.1] };
    vec![
        head("head", 48, "ct-skin", turned(0.0, 30.0, 0.0)),
        Case { meshes: vec![plane], ..head("meshes", 32, "ct-bone", turned(10.0, -20.0, 5.0)) },
    ]
}

static SHOWN: Shown = Shown::new("beside_unity", cases);

fn images() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../unity/com.lumivox/Documentation~/images")
}

/// What the package shows: the left half of a picture whose right half is the wgpu host's.
fn packages(name: &str) -> Vec<[f64; 3]> {
    let both = SrgbImage::read(&images().join(format!("live-{name}.png"))).unwrap();
    let side = SIDE as usize;
    assert_eq!((both.width, both.height), (2 * side, side), "{name}");
    both.to_linear().chunks(2 * side).flat_map(|row| row[..side].to_vec()).collect()
}

/// The mean absolute difference, relative to the light.
fn difference(shown: &[[f64; 3]], wanted: &[[f64; 3]]) -> f64 {
    assert_eq!(shown.len(), wanted.len());
    let (mut sum, mut light) = (0.0, 0.0);
    for (a, b) in shown.as_flattened().iter().zip(wanted.as_flattened()) {
        sum += (a - b).abs();
        light += b;
    }
    sum / light
}

/// The means of squares of pixels: noise is less in them.
fn means(pixels: &[[f64; 3]]) -> Vec<[f64; 3]> {
    const SQUARE: usize = 16;
    let side = SIDE as usize;
    let squares = side / SQUARE;
    let mut sums = vec![[0.0; 3]; squares * squares];
    for (i, pixel) in pixels.iter().enumerate() {
        let sum = &mut sums[i / side / SQUARE * squares + i % side / SQUARE];
        *sum = std::array::from_fn(|c| sum[c] + pixel[c] / (SQUARE * SQUARE) as f64);
    }
    sums
}

fn assert_as_in_unity(name: &str) {
    let screenshot = SHOWN.screenshot(name, "");
    if std::env::var_os("UPDATE_UNITY_PICTURES").is_some() {
        screenshot.write(&images().join(format!("live-{name}-godot.png"))).unwrap();
    }
    let shown = screenshot.to_linear();
    // With the same random numbers, which the package counts from the other end of a picture.
    let host = difference(&shown, &expected::picture(&SHOWN.case(name)).to_linear());
    let (unity, all) = (packages(name), |pixels: &[[f64; 3]]| pixels.as_flattened().iter().sum::<f64>());
    let (one, many) = (difference(&shown, &unity), difference(&means(&shown), &means(&unity)));
    let light = all(&shown) / all(&unity) - 1.0;
    println!(
        "{name}: Godot differs by {host:.1e} of the light from the wgpu host; from the Unity package by {one:.3} in pixels, \
         {many:.4} in squares of 16 x 16, {light:.5} in all"
    );
    // Looks, lights and places that are others are off by tenths.
    assert!(host < 2e-3, "{name}: {host}");
    assert!(many < 0.03 && light.abs() < 3e-3, "{name}: {many} in squares, {light} in all");
}

#[test]
#[ignore = "slow: script/test --all"]
fn a_head_looks_as_the_unity_package_shows_it() {
    assert_as_in_unity("head");
}

#[test]
#[ignore = "slow: script/test --all"]
fn a_head_in_a_mesh_looks_as_the_unity_package_shows_it() {
    assert_as_in_unity("meshes");
}
