//! What was learnt of a scene that is another now: what comes, goes, moves, is hidden, or lit otherwise.

use std::collections::HashSet;
use std::f64::consts::PI;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Camera, Environment, LabelStyle, Scene, VolumeInstance};
use lumivox_testing::scenes::{self, TestScene, noise_volume};
use lumivox_wgpu::Gpu;

use super::cells::{self, Block};
use super::{PIXELS, around, brightness, error, mean, moving, orbit, settings, shown, still};
use crate::gpu;
use crate::live::Host;

/// Half as large, and beside the middle.
fn beside(instance: &VolumeInstance, x: f64) -> VolumeInstance {
    let place = DAffine3::from_translation(DVec3::X * x) * DAffine3::from_scale(DVec3::splat(0.5));
    VolumeInstance { world_from_patient: place * instance.world_from_patient, ..instance.clone() }
}

/// The same look of other voxels.
fn another(instance: &VolumeInstance) -> VolumeInstance {
    VolumeInstance { volume: noise_volume(8, instance.volume.dims()), ..instance.clone() }
}

fn with_volumes(test: &TestScene, volumes: &[&VolumeInstance]) -> Scene {
    Scene { volumes: volumes.iter().map(|volume| (*volume).clone()).collect(), ..test.scene.clone() }
}

/// Whose blocks there are, and where those of one are that have learnt something.
fn numbers(blocks: &[Block]) -> HashSet<u32> {
    blocks.iter().map(|block| block.number).collect()
}

fn places(blocks: &[Block], number: u32) -> HashSet<(u32, [u32; 3])> {
    let knows = |block: &&Block| block.number == number && block.cells.iter().any(|cell| cell.points > 0.0);
    blocks.iter().filter(knows).map(|block| (block.tier, block.place)).collect()
}

/// Some cells are given up because their bucket is full.
fn assert_kept(before: &HashSet<(u32, [u32; 3])>, now: &HashSet<(u32, [u32; 3])>) {
    let kept = before.intersection(now).count();
    assert!(before.len() > 50 && kept * 20 > before.len() * 19, "{kept} of {}", before.len());
}

#[test]
fn volumes_keep_their_cells_while_others_come_and_go() {
    let mut gpu = gpu();
    let gpu = &mut gpu;
    let test = scenes::noise();
    let a = beside(&test.scene.volumes[0], -0.008);
    let b = beside(&another(&test.scene.volumes[0]), 0.008);
    let only_a = TestScene { scene: with_volumes(&test, &[&a]), ..test.clone() };
    let mut host = Host::new(gpu, &only_a, settings());
    orbit(&mut host, gpu, &test, 0..12, PIXELS);
    let blocks = cells::read(&host, gpu);
    let of_a = *numbers(&blocks).iter().next().unwrap();
    let a_before = places(&blocks, of_a);
    assert_eq!(numbers(&blocks).len(), 1);

    // One comes, before it in the scene.
    host.set_scene(gpu, &with_volumes(&test, &[&b, &a]));
    orbit(&mut host, gpu, &test, 12..13, PIXELS);
    let blocks = cells::read(&host, gpu);
    assert_kept(&a_before, &places(&blocks, of_a));
    let of_b = *numbers(&blocks).difference(&HashSet::from([of_a])).next().unwrap();

    // It moves.
    orbit(&mut host, gpu, &test, 13..20, PIXELS);
    let b_before = places(&cells::read(&host, gpu), of_b);
    let moved = beside(&another(&test.scene.volumes[0]), 0.008);
    let moved = VolumeInstance {
        volume: b.volume.clone(),
        world_from_patient: DAffine3::from_translation(DVec3::Y * 1e-3) * moved.world_from_patient,
        ..moved
    };
    host.set_scene(gpu, &with_volumes(&test, &[&moved, &a]));
    orbit(&mut host, gpu, &test, 20..21, PIXELS);
    assert_kept(&b_before, &places(&cells::read(&host, gpu), of_b));

    // The first one goes.
    host.set_scene(gpu, &with_volumes(&test, &[&moved]));
    orbit(&mut host, gpu, &test, 21..22, PIXELS);
    let blocks = cells::read(&host, gpu);
    assert_eq!(numbers(&blocks), HashSet::from([of_b]));
    assert_kept(&b_before, &places(&blocks, of_b));

    // Another of its size takes its place.
    let replaced = another(&moved);
    host.set_scene(gpu, &with_volumes(&test, &[&replaced]));
    drop((moved, b));
    orbit(&mut host, gpu, &test, 22..23, PIXELS);
    let numbers = numbers(&cells::read(&host, gpu));
    assert!(numbers.len() == 1 && numbers.is_disjoint(&HashSet::from([of_a, of_b])), "{numbers:?}");
}

/// One that turns over keeps its cells, but what was its lit side is so no longer: of that nothing is left half a second later.
#[test]
fn a_volume_that_turns_over_leaves_no_ghost() {
    let mut gpu = gpu();
    let mut test = scenes::peaky_environment();
    test.scene.volumes[0].medium.density_scale *= 4.0;
    let mut turned = test.clone();
    let volume = &mut turned.scene.volumes[0];
    volume.world_from_patient = DAffine3::from_rotation_x(PI) * volume.world_from_patient;
    let mut host = Host::new(&mut gpu, &test, settings());
    orbit(&mut host, &mut gpu, &test, 0..30, PIXELS);
    let cells = host.made["kept light"];
    host.set_scene(&mut gpu, &turned.scene);
    let converged = still(&mut gpu, &turned, &around(&test, 59), settings());
    let next = {
        orbit(&mut host, &mut gpu, &test, 30..31, PIXELS);
        error(&shown(&host, &mut gpu), &converged)
    };
    orbit(&mut host, &mut gpu, &test, 31..60, PIXELS);
    let picture = error(&shown(&host, &mut gpu), &converged);
    let fresh = error(&moving(&mut gpu, &turned, 59, settings()), &converged);
    println!("error {next:.4}, then {picture:.4}, of cells that know nothing else {fresh:.4}");
    assert_eq!(host.made["kept light"], cells);
    assert!(next > 1.5 * fresh, "nothing was to be forgotten: {next} {fresh}");
    assert!(picture < 1.6 * fresh, "{picture} {fresh}");
}

/// Phase functions send other light to who looks from elsewhere: what was learnt on the other side is worth little here.
#[test]
fn what_scatters_backwards_is_seen_from_where_one_is() {
    let mut gpu = gpu();
    let test = scenes::backward_scattering();
    // A hundred degrees a second.
    let turned = |frame: usize| {
        let turn = DAffine3::from_rotation_y(0.03 * frame as f64 - 0.5);
        let camera = around(&test, 0);
        Camera { world_from_camera: turn * camera.world_from_camera, ..camera }
    };
    let mut host = Host::new(&mut gpu, &test, settings());
    for frame in 0..24 {
        host.frame(&mut gpu, &turned(frame), PIXELS);
    }
    let ratio = mean(&shown(&host, &mut gpu)) / brightness(&mut gpu, &test, &turned(23), settings());
    println!("{ratio:.3} times as bright");
    assert!((ratio - 1.0).abs() < 0.15, "{ratio} times as bright");
}

/// What stood in front of all for a while lets cells be what they were.
#[test]
fn a_mesh_that_was_in_front_leaves_nothing() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let distance = test.camera.world_from_camera.translation.distance(DVec3::ZERO);
    let seen = |gpu: &mut Gpu, has_mesh: bool| {
        let mut host = Host::new(gpu, &test, settings());
        for frame in 0..24 {
            let is_in_front = has_mesh && (8..16).contains(&frame);
            host.set_depth(gpu, |_| if is_in_front { 0.1 * distance } else { 0.0 });
            host.frame(gpu, &around(&test, frame), PIXELS);
            if is_in_front {
                assert!(shown(&host, gpu).iter().all(|pixel| *pixel == [0.0; 4]), "frame {frame}");
            }
            if has_mesh && frame == 16 {
                let still = brightness(gpu, &test, &around(&test, frame), settings());
                let ratio = mean(&shown(&host, gpu)) / still;
                assert!((ratio - 1.0).abs() < 0.05, "{ratio} times as bright");
            }
        }
        shown(&host, gpu)
    };
    let [with, without] = [true, false].map(|has_mesh| seen(&mut gpu, has_mesh));
    let converged = still(&mut gpu, &test, &around(&test, 23), settings());
    let [with, without] = [with, without].map(|picture| error(&picture, &converged));
    println!("error {with:.4}, without the mesh {without:.4}");
    assert!(with < 1.15 * without, "{with} {without}");
}

/// Its matter is gone from the next picture, and light falls on what is behind it within frames.
#[test]
fn a_label_that_is_hidden_is_gone_at_once() {
    let mut gpu = gpu();
    let with = |style: LabelStyle| {
        let mut test = scenes::labels();
        let labels = test.scene.volumes[0].labels.as_mut().unwrap();
        for value in [4, 5, 6] {
            labels.set_style(value, style.clone());
        }
        test
    };
    let test = with(LabelStyle { density_scale: Some(8.0), ..Default::default() });
    let hidden = with(LabelStyle::hidden());
    let mut host = Host::new(&mut gpu, &test, settings());
    orbit(&mut host, &mut gpu, &test, 0..12, PIXELS);
    let alpha = |picture: &[[f32; 4]]| picture.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>();
    let before = alpha(&shown(&host, &mut gpu));
    host.set_scene(&mut gpu, &hidden.scene);
    orbit(&mut host, &mut gpu, &test, 12..13, PIXELS);
    let next = shown(&host, &mut gpu);
    let converged = still(&mut gpu, &hidden, &around(&test, 12), settings());
    let all = alpha(&converged);
    println!("alpha {before:.1}, then {:.1}, and at last {all:.1}", alpha(&next));
    assert!(before > 1.1 * all && (alpha(&next) / all - 1.0).abs() < 0.02);
    orbit(&mut host, &mut gpu, &test, 13..37, PIXELS);
    let converged = still(&mut gpu, &hidden, &around(&test, 36), settings());
    let fresh = moving(&mut gpu, &hidden, 36, settings());
    let picture = shown(&host, &mut gpu);
    let [kept, fresh] = [&picture, &fresh].map(|picture| error(picture, &converged));
    let ratio = mean(&picture) / mean(&converged);
    println!("error {kept:.4}, of cells that know nothing else {fresh:.4}; {ratio:.3} times as bright");
    assert!(kept < 1.2 * fresh && (ratio - 1.0).abs() < 0.05, "{kept} {fresh} {ratio}");
}

/// However little it changes from frame to frame, and though the camera never rests.
#[test]
fn light_that_fades_slowly_leaves_no_glow() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let mut host = Host::new(&mut gpu, &test, settings().with(|it| it.ambient = [2.0; 3]));
    orbit(&mut host, &mut gpu, &test, 0..12, PIXELS);
    for frame in 12..72 {
        // One that is not of the environment, which stays. It is gone after 40 frames.
        host.settings.ambient = [(2.0 - 0.05 * (frame - 11) as f64).max(0.0); 3];
        orbit(&mut host, &mut gpu, &test, frame..frame + 1, PIXELS);
    }
    let converged = brightness(&mut gpu, &test, &around(&test, 71), settings());
    let ratio = mean(&shown(&host, &mut gpu)) / converged;
    println!("{ratio:.3} times as bright");
    assert!((ratio - 1.0).abs() < 0.1, "{ratio} times as bright");
}

#[test]
fn ambient_light_that_is_switched_off_leaves_no_glow() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let mut host = Host::new(&mut gpu, &test, settings().with(|it| it.ambient = [8.0; 3]));
    orbit(&mut host, &mut gpu, &test, 0..40, PIXELS);
    let before = mean(&shown(&host, &mut gpu));
    host.settings.ambient = [0.0; 3];
    orbit(&mut host, &mut gpu, &test, 40..70, PIXELS);
    let converged = brightness(&mut gpu, &test, &around(&test, 69), settings());
    let after = mean(&shown(&host, &mut gpu));
    println!("{after:.4}, not {converged:.4}, of {before:.4}");
    assert!(before > 5.0 * converged && (after - converged).abs() < 0.012 * before, "{after} {converged}");
}

/// Where all light became weaker alike, films go on and are shown so many times as dark. When it is another then, what cells
/// know is of the stronger one.
#[test]
fn light_that_became_weaker_and_then_another_does_not_flash() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let mut host = Host::new(&mut gpu, &test, settings());
    orbit(&mut host, &mut gpu, &test, 0..12, PIXELS);
    let mut scene = test.scene.clone();
    scene.environment.strength *= 0.01;
    host.set_scene(&mut gpu, &scene);
    orbit(&mut host, &mut gpu, &test, 12..13, PIXELS);
    scene.environment = Environment { rotation: 2.0, ..scene.environment };
    host.set_scene(&mut gpu, &scene);
    orbit(&mut host, &mut gpu, &test, 13..14, PIXELS);
    let turned = TestScene { scene, ..test.clone() };
    let converged = brightness(&mut gpu, &turned, &around(&test, 13), settings());
    let ratio = mean(&shown(&host, &mut gpu)) / converged;
    println!("{ratio:.3} times as bright");
    assert!((ratio - 1.0).abs() < 0.3, "{ratio} times as bright");
}
