//! Scenes that change while they are shown: nothing stale stays, nothing tears, and what did not change goes on.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

use lumivox_core::glam::{DMat3, DVec3};
use lumivox_testing::png_io::SrgbImage;
use serde::Serialize;

use crate::case::{Case, Lamp, LampKind, Light, Mesh, Place, Volume, look_at};
use crate::engine::Run;
use crate::expected;
use crate::shown::{assert_same, distance, run_scene, told};

/// Samples that a pixel may have when it started over in this frame or the one before.
const FIRST_AID: std::ops::RangeInclusive<u32> = 4..=8;

const STEPS: usize = 14;

/// Samples after which nothing of a coarse picture is left.
const AT_REST: u32 = 32;

/// What `project/motion.gd` does.
#[derive(Serialize)]
struct Script {
    /// Each differs from the one before.
    edits: Vec<Case>,
    settings: Vec<Case>,
    /// A case for each frame.
    walks: BTreeMap<&'static str, Vec<Case>>,
    smoothed: [Case; 2],
    animation: Case,
    animation_to: [f64; 3],
    reload: Case,
    compositor: Case,
    still_camera: Case,
    moving_camera: Vec<Case>,
    worlds: Vec<Case>,
    /// A case for each frame.
    kept_light: Vec<Case>,
}

fn script() -> &'static Script {
    static SCRIPT: OnceLock<Script> = OnceLock::new();
    SCRIPT.get_or_init(|| Script {
        edits: edits(),
        settings: settings(),
        walks: BTreeMap::from([
            ("mesh_walk", mesh_walk()),
            ("camera_walk", camera_walk()),
            ("volume_walk", volume_walk()),
        ]),
        smoothed: smoothed(),
        animation: Case { volumes: vec![Volume::solid()], ..opaque("animation") },
        animation_to: [0.012, -0.008, 0.01],
        reload: Case { samples: AT_REST, ..Case::new("reload") },
        compositor: opaque("compositor"),
        still_camera: Case { samples: AT_REST, budget: 1.0, kept_light: true, ..Case::new("still_camera") },
        moving_camera: (0..5)
            .map(|i| {
                let eye = DVec3::new(0.02 * f64::from(i) - 0.04, 0.03, 0.08);
                Case {
                    samples: AT_REST,
                    size: [64, 64],
                    kept_light: true,
                    camera: look_at(eye, DVec3::ZERO),
                    ..Case::new("moving_camera")
                }
            })
            .collect(),
        worlds: worlds(),
        kept_light: kept_light(),
    })
}

/// Where the script leaves its pictures, and its log.
fn shown() -> &'static (std::path::PathBuf, Run) {
    static SHOWN: OnceLock<(std::path::PathBuf, Run)> = OnceLock::new();
    SHOWN.get_or_init(|| run_scene("motion", "motion", script()))
}

fn leaked(name: String) -> &'static str {
    Box::leak(name.into_boxed_str())
}

/// A red volume that nothing shines through, before white.
fn opaque(name: &'static str) -> Case {
    Case {
        light: Light::Color([0.8; 3]),
        volumes: vec![Volume::solid()],
        budget: 2.0,
        samples: AT_REST,
        kept_light: true,
        ..Case::new(name)
    }
}

fn edits() -> Vec<Case> {
    let turned = |angle: f64| {
        let scale = DMat3::from_diagonal(DVec3::new(1.2, 0.6, 0.9));
        Place::new(DMat3::from_rotation_y(angle) * scale, DVec3::new(0.014, 0.004, 0.006))
    };
    // Of a coarse picture: light that is kept needs some frames for another surface, or a volume that comes back.
    let mut case = Case {
        samples: AT_REST,
        budget: 3.0,
        kept_light: false,
        volumes: vec![
            Volume::soft(),
            Volume { place: turned(0.4), stops: vec![[0.0, 0.2, 0.5, 0.9]], ..Volume::soft() },
        ],
        meshes: vec![Mesh {
            size: [0.004, 0.03, 0.004],
            place: Place::at(DVec3::new(-0.01, 0.0, 0.006)),
            color: [0.1, 0.7, 0.2],
        }],
        lamps: vec![Lamp {
            energy: 0.05,
            ..Lamp::new(LampKind::Omni, Place::at(DVec3::new(-0.02, 0.03, 0.01)))
        }],
        ..Case::new("edit_start")
    };
    let mut list = vec![case.clone()];
    let mut edit = |name: &'static str, change: &dyn Fn(&mut Case)| {
        case.name = name;
        change(&mut case);
        list.push(case.clone());
    };
    edit("mesh_moved", &|c| c.meshes[0].place = Place::at(DVec3::new(0.004, 0.002, 0.006)));
    edit("camera_moved", &|c| c.camera = look_at(DVec3::new(-0.03, 0.02, 0.085), DVec3::ZERO));
    edit("field_of_view", &|c| c.fov = 28.0);
    edit("transfer_function_opacity", &|c| {
        c.volumes[0].knots = vec![[0.0, 0.0, 0.0], [900.0, 0.9, 1.0], [1500.0, 0.1, 0.0]];
    });
    edit("transfer_function_color", &|c| {
        c.volumes[0].stops = vec![[0.0, 0.9, 0.1, 0.2], [1500.0, 0.2, 0.9, 0.1]];
    });
    edit("density", &|c| c.volumes[0].density = 0.3);
    edit("albedo", &|c| c.volumes[0].albedo = 0.6);
    edit("surface", &|c| c.volumes[0].surface = [1.0, 5.0, 0.2, 0.3, 0.0]);
    edit("filter", &|c| c.volumes[0].filter = 0);
    edit("clip", &|c| c.volumes[0].clip_max = [0.5, 0.8, 1.0]);
    edit("turned", &|c| c.volumes[1].place = turned(1.3));
    edit("hidden", &|c| c.volumes[1].visible = false);
    edit("back", &|c| c.volumes[1].visible = true);
    edit("scan_swapped", &|c| (c.volumes[1].phantom, c.volumes[1].size) = ("cube", 16));
    edit("lamp", &|c| (c.lamps[0].energy, c.lamps[0].color) = (0.15, [1.0, 0.6, 0.3]));
    edit("lamp_moved", &|c| c.lamps[0].place = Place::at(DVec3::new(0.03, 0.0, 0.02)));
    edit("lamp_layers", &|c| c.lamps[0].layers = 1 << 8);
    edit("background", &|c| c.light = Light::Color([0.1, 0.2, 0.5]));
    edit("resized", &|c| c.size = [72, 90]);
    list
}

fn settings() -> Vec<Case> {
    let base = Case { samples: 16, ..Case::new("setting_start") };
    vec![
        base.clone(),
        Case { name: "setting_exposure", exposure: 0.7, ..base.clone() },
        Case { name: "setting_more_samples", exposure: 0.7, samples: 32, ..base.clone() },
        Case { name: "setting_fewer_samples", exposure: 0.7, samples: 8, ..base },
    ]
}

fn step(i: usize) -> f64 {
    i as f64 / STEPS as f64
}

/// In at the left, through the front, out at the right.
fn mesh_walk() -> Vec<Case> {
    let at = |t: f64| Mesh {
        size: [0.006, 0.02, 0.006],
        place: Place::new(DMat3::from_rotation_y(t), DVec3::new(-0.022 + 0.05 * t, 0.003, 0.014 - 0.012 * t)),
        color: [0.02, 0.35, 0.02],
    };
    (0..=STEPS)
        .map(|i| Case { meshes: vec![at(step(i))], ..opaque(leaked(format!("mesh_walk_{i}"))) })
        .collect()
}

fn camera_walk() -> Vec<Case> {
    let eye = |t: f64| DVec3::new(0.08 * (t - 0.4), 0.028, 0.075 - 0.02 * t);
    (0..=STEPS)
        .map(|i| Case {
            camera: look_at(eye(step(i)), DVec3::ZERO),
            ..opaque(leaked(format!("camera_walk_{i}")))
        })
        .collect()
}

fn volume_walk() -> Vec<Case> {
    let place =
        |t: f64| Place::new(DMat3::from_rotation_y(2.0 * t), DVec3::new(0.01 * t, -0.004 * t, 0.02 * t));
    (0..=STEPS)
        .map(|i| Case {
            volumes: vec![Volume { place: place(step(i)), ..Volume::solid() }],
            ..opaque(leaked(format!("volume_walk_{i}")))
        })
        .collect()
}

/// A head before the camera, under temporal antialiasing; and where it is in the next frame.
fn smoothed() -> [Case; 2] {
    let at = |name: &'static str, [x, y]: [f64; 2]| {
        let mut case = Case::new(name);
        case.camera = look_at(DVec3::new(0.0, 0.0, SMOOTHED_FROM), DVec3::ZERO);
        case.volumes = vec![Volume { place: Place::at(DVec3::new(x, y, 0.0)), ..Volume::head() }];
        (case.samples, case.kept_light, case.output.taa) = (AT_REST, true, true);
        case
    };
    [at("smoothed", [0.0; 2]), at("smoothed_moved", SMOOTHED_BY)]
}

/// Metres from the head's middle to the camera, and that it moves to the right and up.
const SMOOTHED_FROM: f64 = 0.7;
const SMOOTHED_BY: [f64; 2] = [0.02, 0.01];

fn worlds() -> Vec<Case> {
    (0..6)
        .map(|i| {
            let t = i as f64 / 6.0;
            Case {
                size: [40 + 8 * i as u32, 48],
                samples: 8,
                light: Light::Color([0.3 + 0.1 * t, 0.5, 0.8 - 0.5 * t]),
                volumes: vec![Volume {
                    place: Place::new(DMat3::from_rotation_y(t), DVec3::ZERO),
                    stops: vec![[0.0, t, 0.5, 1.0 - t]],
                    ..Volume::soft()
                }],
                ..Case::new(leaked(format!("world_{i}")))
            }
        })
        .collect()
}

/// Around a volume that is not dense, with no time for more than a few paths.
fn kept_light() -> Vec<Case> {
    let eye = |angle: f64| DVec3::new(0.08 * angle.sin(), 0.03, 0.08 * angle.cos());
    (0..=STEPS)
        .map(|i| Case {
            camera: look_at(eye(0.02 * i as f64), DVec3::ZERO),
            samples: 4096,
            budget: 1.0,
            ..Case::new("kept_light")
        })
        .collect()
}

fn read(name: &str) -> SrgbImage {
    SrgbImage::read(&shown().0.join(format!("{name}.png"))).unwrap()
}

fn assert_shows(case: &Case, name: &str) {
    assert_same(&shown().0, name, &expected::picture(case), |_| true);
}

/// Means over blocks of 8 by 8 pixels, linear: what a coarse and noisy picture has right.
fn blocks(image: &SrgbImage) -> Vec<[f64; 3]> {
    let linear = image.to_linear();
    let mut means = vec![];
    for top in (0..image.height).step_by(8) {
        for left in (0..image.width).step_by(8) {
            let rows = top..(top + 8).min(image.height);
            let columns = left..(left + 8).min(image.width);
            let count = (rows.len() * columns.len()) as f64;
            let mut sum = DVec3::ZERO;
            for y in rows {
                for x in columns.clone() {
                    sum += DVec3::from_array(linear[y * image.width + x]);
                }
            }
            means.push((sum / count).to_array());
        }
    }
    means
}

/// The largest difference of two pictures' blocks.
fn block_difference(a: &SrgbImage, b: &SrgbImage) -> f64 {
    let pairs = blocks(a).into_iter().zip(blocks(b));
    pairs.flat_map(|(a, b)| [0, 1, 2].map(|i| (a[i] - b[i]).abs())).fold(0.0, f64::max)
}

#[test]
fn every_edit_ends_in_the_picture_of_a_scene_made_so() {
    assert_shows(&edits()[0], "edit_start");
    for pair in edits().windows(2) {
        let [before, after] = pair else { unreachable!() };
        let (old, new) = (expected::picture(before), expected::picture(after));
        if before.size == after.size {
            let (mean, ..) = distance(&old, &new, |_| true);
            assert!(mean > 0.5, "{}: an edit that nobody sees: {mean}", after.name);
        }
        assert_same(&shown().0, after.name, &new, |_| true);
    }
}

#[test]
fn the_frame_after_an_edit_shows_all_of_it() {
    for pair in edits().windows(2) {
        let [before, after] = pair else { unreachable!() };
        let told = told(&shown().1, after.name);
        let first = told["first"]["samples"].as_u64().unwrap();
        let (new, shown) = (expected::picture(after), read(&format!("{}_first", after.name)));
        let off = block_difference(&shown, &new);
        println!("{}: {first} samples in the next frame, blocks differ by {off:.3}", after.name);
        // Noise of few samples: .24 at most with these random numbers, .19 with others.
        assert!(off < 0.3, "{}: a block of the next frame differs by {off}", after.name);
        if before.size == after.size {
            // It is the new picture already, not the old one.
            let old = expected::picture(before);
            let (to_new, to_old) = (mean_block_difference(&shown, &new), mean_block_difference(&shown, &old));
            let change = mean_block_difference(&old, &new);
            if change > 0.01 {
                assert!(to_new < to_old, "{}: {to_new} from the new, {to_old} from the old", after.name);
            }
        }
    }
}

fn mean_block_difference(a: &SrgbImage, b: &SrgbImage) -> f64 {
    let (a, b) = (blocks(a), blocks(b));
    let sum: f64 = a.iter().zip(&b).map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).abs()).sum::<f64>()).sum();
    sum / a.len() as f64
}

#[test]
fn exposure_and_targets_keep_the_samples() {
    let list = settings();
    for (i, case) in list.iter().enumerate().skip(1) {
        let told = told(&shown().1, case.name);
        println!("{}: {told}", case.name);
        assert!(told["least"].as_u64().unwrap() >= 16.min(u64::from(case.samples)), "{}: {told}", case.name);
        assert!(told["last"]["converged"].as_bool().unwrap());
        // Fewer than there are: what there is stays.
        let samples = list[..=i].iter().map(|c| c.samples).max().unwrap();
        assert_shows(&Case { samples, ..case.clone() }, case.name);
    }
}

/// Whether everything within `radius` pixels fulfils `inside`.
fn eroded(case: &Case, radius: usize, inside: impl Fn(usize) -> bool) -> Vec<bool> {
    let [width, height] = case.size.map(|n| n as usize);
    (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            let rows = y.saturating_sub(radius)..=(y + radius).min(height - 1);
            let columns = x.saturating_sub(radius)..=(x + radius).min(width - 1);
            rows.into_iter().all(|y| columns.clone().all(|x| inside(y * width + x)))
        })
        .collect()
}

/// White where the red volume is, and pixels of the volume where the white background is.
fn assert_no_holes(name: &str, case: &Case, radius: usize) {
    let shown = read(name).to_linear();
    let film = expected::film(&Case { meshes: vec![], ..case.clone() });
    let volume = eroded(case, radius, |i| film.alpha(i) > 0.999);
    let empty = eroded(case, radius, |i| film.alpha(i) < 0.001);
    let mesh: Vec<bool> = expected::seen(case, &case.meshes).iter().map(Option::is_some).collect();
    let (mut inside, mut outside, mut holes, mut ghosts) = (0, 0, vec![], vec![]);
    for (i, [r, g, _]) in shown.into_iter().enumerate() {
        if volume[i] {
            inside += 1;
            if g > 0.45 {
                holes.push(i);
            }
        } else if empty[i] && !mesh[i] {
            outside += 1;
            if g < 0.6 || r < 0.6 {
                ghosts.push(i);
            }
        }
    }
    println!(
        "{name}: {} holes in {inside} pixels of the volume, {} ghosts in {outside} of the background",
        holes.len(),
        ghosts.len()
    );
    assert!(inside > 200 && outside > 1000, "{name} shows too little: {inside}, {outside}");
    assert!(holes.is_empty(), "{name}: holes at {holes:?}");
    // The edge of a mesh may fall on another pixel.
    assert!(ghosts.len() <= if case.meshes.is_empty() { 0 } else { 6 }, "{name}: ghosts at {ghosts:?}");
}

#[test]
fn a_mesh_that_moves_through_a_volume_tears_no_holes() {
    let walk = &script().walks["mesh_walk"];
    let mut frames_with_mesh = 0;
    for case in &walk[1..] {
        assert_no_holes(case.name, case, 2);
        // The mesh is where it is now, and nowhere else.
        let wanted = expected::linear(case);
        let shown = read(case.name).to_linear();
        let is_mesh = |[r, g, _]: [f64; 3]| g > 0.25 && g < 0.45 && r < 0.1;
        let inner = eroded(case, 1, |i| is_mesh(wanted[i]));
        let missing = (0..shown.len()).filter(|&i| inner[i] && !is_mesh(shown[i])).count();
        let near = eroded(case, 1, |i| !is_mesh(wanted[i]));
        let mut stale: Vec<usize> = (0..shown.len()).filter(|&i| near[i] && is_mesh(shown[i])).collect();
        // A pixel's samples are the same in every host. Its first ones may all have passed through tissue to the mesh.
        for samples in FIRST_AID {
            if stale.is_empty() {
                break;
            }
            let first = expected::linear(&Case { samples, ..case.clone() });
            stale.retain(|&i| (0..3).any(|c| (shown[i][c] - first[i][c]).abs() > 0.01));
        }
        let there = inner.iter().filter(|m| **m).count();
        println!("{}: mesh in {there} pixels, missing in {missing}, stale at {stale:?}", case.name);
        assert!(missing == 0 && stale.is_empty(), "{}: {missing} missing, stale at {stale:?}", case.name);
        frames_with_mesh += usize::from(there > 20);
    }
    assert!(frames_with_mesh > STEPS / 2, "the mesh is seen in {frames_with_mesh} frames only");
    assert_shows(walk.last().unwrap(), "mesh_walk");
}

#[test]
fn a_moving_camera_sees_everything_in_every_frame() {
    let walk = &script().walks["camera_walk"];
    for case in &walk[1..] {
        assert_no_holes(case.name, case, 9);
    }
    assert_shows(walk.last().unwrap(), "camera_walk");
}

#[test]
fn a_moving_volume_is_whole_in_every_frame() {
    let walk = &script().walks["volume_walk"];
    for case in &walk[1..] {
        assert_no_holes(case.name, case, 9);
    }
    assert_shows(walk.last().unwrap(), "volume_walk");
}

/// By what the engine keeps of motion: a point's way back to where it was, in parts of the picture.
#[test]
fn temporal_antialiasing_is_told_how_far_volumes_have_moved() {
    let case = &script().smoothed[1];
    let told: Vec<f64> = serde_json::from_value(told(&shown().1, "velocities")).unwrap();
    let film = expected::film(case);
    let [width, height] = case.size.map(|n| n as usize);
    assert_eq!(told.len(), 2 * width * height);
    let inner = eroded(case, 1, |i| film.alpha(i) > 0.9);
    let outer = eroded(case, 2, |i| film.alpha(i) == 0.0);
    let down = 2.0 * (case.fov.to_radians() / 2.0).tan();
    let across = down * width as f64 / height as f64;
    let (mut seen, mut beside) = (0, 0);
    for (i, way) in told.as_chunks::<2>().0.iter().enumerate() {
        if inner[i] {
            // How deep the point lies: within the head.
            let depth = -SMOOTHED_BY[0] / (across * way[0]);
            let up = SMOOTHED_BY[1] / (down * depth);
            assert!((0.5..0.9).contains(&depth) && (way[1] - up).abs() < 1e-3, "pixel {i}: {way:?}");
            seen += 1;
        } else if outer[i] {
            assert!(way.iter().all(|by| by.abs() < 1e-4), "pixel {i}: {way:?}, where nothing moves");
            beside += 1;
        }
    }
    assert!(seen > 300 && beside > 1000, "{seen} {beside}");
}

#[test]
fn an_animation_of_a_parent_moves_the_volume() {
    let base = &script().animation;
    let at = |position: DVec3| Case {
        volumes: vec![Volume { place: Place::at(position), ..Volume::solid() }],
        ..base.clone()
    };
    let positions: Vec<[f64; 3]> = serde_json::from_value(told(&shown().1, "animation")).unwrap();
    assert!(positions.len() >= 4, "{positions:?}");
    assert_shows(base, "animation_begin");
    for (i, position) in positions.iter().enumerate() {
        assert_no_holes(&format!("animation_{i}"), &at(DVec3::from_array(*position)), 9);
    }
    assert_shows(&at(DVec3::from_array(script().animation_to)), "animation_end");
}

#[test]
fn a_scene_that_is_freed_leaves_nothing_and_comes_back() {
    let (folder, run) = shown();
    let empty = told(run, "reload_empty");
    assert_eq!(empty["status"], serde_json::json!({}));
    assert_eq!(empty["converged"], true);
    for name in ["reload", "reload_again"] {
        assert_same(folder, name, &expected::picture(&script().reload), |_| true);
    }
    let without = read("reload_without");
    let first = without.pixels[0];
    assert!(without.pixels.iter().all(|p| *p == first), "something is left of the volume");
}

#[test]
fn volumes_stay_when_the_owner_of_a_compositor_sets_its_effects() {
    let told = told(&shown().1, "compositor");
    let told = told.as_object().unwrap();
    assert_eq!(told.len(), 8);
    for (effects, is_shown) in told {
        assert_eq!(*is_shown, effects != "hidden", "{effects}: {told:?}");
    }
}

#[test]
fn a_camera_that_moves_leaves_the_other_viewport_alone() {
    let (folder, run): &(_, _) = shown();
    let folder: &Path = folder;
    let told = told(run, "two_cameras");
    println!("two_cameras: {told}");
    assert_eq!(told["stays"], true, "the still camera started over");
    // The first place is where it has been already.
    assert!(told["restarts"].as_u64().unwrap() > 0, "the camera moved without anything to trace");
    assert_same(folder, "still_camera", &expected::picture(&script().still_camera), |_| true);
    let last = script().moving_camera.last().unwrap();
    assert_same(folder, "moving_camera", &expected::picture(last), |_| true);
}

#[test]
fn what_moves_is_nearer_to_its_picture_at_rest_with_kept_light() {
    let told = told(&shown().1, "kept_light");
    println!("kept_light: {told}");
    assert_eq!((&told["default"], &told["plain"]), (&serde_json::json!(true), &serde_json::json!(0)));
    assert!(told["kept"].as_u64().unwrap() > 0, "{told}");
    let last = script().kept_light.last().unwrap();
    let wanted = expected::picture(&Case { samples: 256, ..last.clone() });
    let [kept, plain] =
        ["kept", "plain"].map(|what| distance(&read(&format!("kept_light_{what}")), &wanted, |_| true).0);
    println!("off by {kept:.2} codes of 255 with kept light, by {plain:.2} without");
    assert!(kept < 0.8 * plain, "off by {kept} with kept light, by {plain} without");
}

#[test]
fn worlds_side_by_side_do_not_mix() {
    let (folder, run) = shown();
    for (i, case) in script().worlds.iter().enumerate() {
        let wanted = expected::picture(case);
        if i % 2 == 1 {
            assert_same(folder, case.name, &wanted, |_| true);
            assert_eq!(told(run, case.name)["converged"], true);
        }
        assert_same(folder, &format!("{}_anew", case.name), &wanted, |_| true);
    }
}
