//! What cells know against the independent f64 reference: the light that is sent on diffusely, and its colour, cell by cell.

use std::collections::HashMap;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Camera, Environment, EnvironmentSource, Ray, Scene};
use lumivox_reference::lights::lights;
use lumivox_reference::medium::place;
use lumivox_reference::path::nearest_collision;
use lumivox_reference::rng::Rng;
use lumivox_reference::sent_diffusely;
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::Gpu;

use super::cells::{self, Block, Cell};
use super::{PIXELS, settings};
use crate::gpu;
use crate::live::Host;

/// A cell of the finest tier.
type Place = [u32; 3];

/// How much is traced.
struct Effort {
    /// Frames, from each of which cells learn what 32 paths a pixel have found.
    frames: u32,
    /// Rays that say where in cells the camera's rays collide.
    rays: u32,
    /// Cells that are compared, and paths of the reference in each.
    cells: usize,
    paths: u32,
}

fn camera_of(test: &TestScene) -> Camera {
    test.camera.with_aspect(1.0)
}

/// Cells of the finest tier by their places, in voxels.
fn finest(blocks: &[Block]) -> HashMap<Place, Cell> {
    let of_block = |block: &Block| {
        let base = block.place.map(|n| 2 * n);
        let cells = block.cells;
        (0..8u32).map(move |i| ([0, 1, 2].map(|axis| base[axis] + ((i >> axis) & 1)), cells[i as usize]))
    };
    blocks.iter().filter(|block| block.tier == 0).flat_map(of_block).collect()
}

/// What cells know when they have seen many points, from one camera.
fn converged_cells(gpu: &mut Gpu, test: &TestScene, frames: u32, seed: u32) -> HashMap<Place, Cell> {
    let mut host = Host::new(gpu, test, settings().with(|it| it.seed = seed));
    for frame in 0..frames {
        // So little that it is seen from the same place, but for a view that takes it for motion.
        let turn = DAffine3::from_rotation_y(1e-7 * f64::from(frame % 2));
        let camera = camera_of(test);
        let camera = Camera { world_from_camera: turn * camera.world_from_camera, ..camera };
        host.frame(gpu, &camera, 32 * PIXELS);
    }
    finest(&cells::read(&host, gpu))
}

/// Where in cells the camera's rays collide, and in which directions of travel.
fn first_collisions(scene: &Scene, camera: &Camera, rays: u32) -> HashMap<Place, Vec<(DVec3, DVec3)>> {
    let media = place(scene);
    let [volume] = &*scene.volumes else { panic!("cells of one volume are compared") };
    let voxel_from_world = DAffine3::from_translation(DVec3::splat(0.5))
        * volume.volume.patient_from_voxel().inverse()
        * volume.world_from_patient.inverse();
    let dims = DVec3::from_array(volume.volume.dims().map(|n| n as f64));
    let mut found: HashMap<Place, Vec<(DVec3, DVec3)>> = HashMap::new();
    for i in 0..rays {
        let mut rng = Rng::new(1, 0, i);
        let ray = camera.ray(rng.uniform_2d());
        let ray = Ray { direction: ray.direction.normalize(), ..ray };
        if let Some((_, t)) = nearest_collision(&media, &ray, &mut rng) {
            let point = ray.origin + t * ray.direction;
            let voxel = voxel_from_world.transform_point3(point).clamp(DVec3::ZERO, dims - 1.0);
            found.entry(voxel.to_array().map(|x| x as u32)).or_default().push((point, ray.direction));
        }
    }
    found
}

/// Means of what the reference says that is sent on from a cell, its colour, and the variance of the light's mean.
struct Known {
    light: f64,
    color: f64,
    variance: f64,
}

fn luminance(c: [f64; 3]) -> f64 {
    0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
}

fn by_reference(scene: &Scene, seed: u64, paths: u32, collisions: &[(DVec3, DVec3)]) -> Known {
    let media = place(scene);
    let lights = lights(scene);
    let environment =
        Environment { source: EnvironmentSource::Map(scene.environment.to_map()), ..scene.environment };
    let (mut light, mut square, mut color) = (0.0, 0.0, 0.0);
    for i in 0..paths {
        let (point, travel) = collisions[i as usize % collisions.len()];
        let mut rng = Rng::new(2, seed, i);
        let sent = sent_diffusely(&media, &environment, &lights, &media[0], point, travel, &mut rng);
        let of_path = luminance(sent.light);
        light += of_path;
        square += of_path * of_path;
        color += luminance(sent.color);
    }
    let n = f64::from(paths);
    let mean = light / n;
    Known { light: mean, color: color / n, variance: (square / n - mean * mean) / n }
}

#[test]
fn cells_know_what_the_reference_says_that_is_sent_on() {
    let effort = Effort { frames: 8, rays: 120 * PIXELS as u32, cells: 200, paths: 300 };
    compare(&mut gpu(), &scenes::surface_reflection(), &effort);
}

#[test]
#[ignore = "slow: script/test --all"]
fn cells_know_to_a_third_of_a_hundredth_what_the_reference_says() {
    let effort = Effort { frames: 40, rays: 200 * PIXELS as u32, cells: 400, paths: 2000 };
    for test in [scenes::noise(), scenes::surface_reflection(), scenes::bulbs(), scenes::glossy_surface()] {
        compare(&mut gpu(), &test, &effort);
    }
}

fn compare(gpu: &mut Gpu, test: &TestScene, effort: &Effort) {
    let [a, b] = [3, 4].map(|seed| converged_cells(gpu, test, effort.frames, seed));
    let mut collisions: Vec<_> =
        first_collisions(&test.scene, &camera_of(test), effort.rays).into_iter().collect();
    // Those that most rays collide in, every second of them: some are seen by few.
    collisions.sort_by_key(|(place, of_cell)| (std::cmp::Reverse(of_cell.len()), *place));
    let (mut known, mut seen, mut colors, mut seen_colors) = (0.0, 0.0, 0.0, 0.0);
    let (mut square, mut expected) = (0.0, 0.0);
    let mut points = 0.0;
    let mut count = 0.0;
    for (i, (place, of_cell)) in collisions.iter().step_by(2).take(effort.cells).enumerate() {
        let [a, b] = [&a, &b].map(|cells| cells[place]);
        let reference = by_reference(&test.scene, i as u64, effort.paths, of_cell);
        let [of_a, of_b] = [a, b].map(|cell| luminance(cell.light));
        let light = 0.5 * (of_a + of_b);
        // Of the mean of two that differ so.
        let noise = 0.25 * (of_a - of_b).powi(2);
        points += f64::from(a.points + b.points);
        known += reference.light;
        seen += light;
        colors += reference.color;
        seen_colors += 0.5 * (luminance(a.color) + luminance(b.color));
        square += (light - reference.light).powi(2);
        expected += reference.variance + noise;
        count += 1.0;
    }
    assert_eq!(count as usize, effort.cells);
    let [bias, of_color] = [seen / known - 1.0, seen_colors / colors - 1.0];
    let error = expected.sqrt() / known;
    let [rms, noise] = [square, expected].map(|sum: f64| (sum / count).sqrt() / (known / count));
    println!(
        "{}: light {:+.2}% +- {:.2}%, colour {:+.2}%; cells differ by {:.1}%, noise is {:.1}%; {:.0} points a cell",
        test.name,
        100.0 * bias,
        100.0 * error,
        100.0 * of_color,
        100.0 * rms,
        100.0 * noise,
        points / count / 2.0
    );
    assert!(bias.abs() < 0.005 + 3.0 * error && error < 0.005, "{}: {bias} +- {error}", test.name);
    assert!(of_color.abs() < 0.005, "{}: {of_color}", test.name);
    assert!(rms < 1.3 * noise, "{}: {rms}, not {noise}", test.name);
}
