//! Every sampler of directions against its own density: chi-square on the sphere.

use std::f64::consts::PI;

use lumivox_core::environment::uv_from_direction;
use lumivox_core::glam::DVec3;
use lumivox_core::{Environment, Scene};
use lumivox_reference::sampling::{cosine_hemisphere, henyey_greenstein};
use lumivox_renderer::recording::Kernel;
use lumivox_renderer::{Recording, ResourceId, SceneCache, Step, VoxelStore};
use lumivox_shaders::layout::{Frame, SampleParams};
use lumivox_testing::chi_square::{SphereTest, Verdict};
use lumivox_testing::scenes;

use crate::gpu;

const COUNT: usize = 400_000;

/// Directions and the densities that the kernel claims for them.
fn draw(environment: &Environment, sampler: u32, axis: DVec3, anisotropy: f64) -> Vec<(DVec3, f64)> {
    let mut gpu = gpu();
    let mut cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
    let mut recording = Recording::new();
    let scene = Scene { environment: environment.clone(), ..Default::default() };
    cache.update(&scene, &mut recording).unwrap();
    let mut frame = Frame { seed: 7, ..Default::default() };
    cache.fill_frame(&mut frame);
    let params = SampleParams {
        axis: axis.as_vec3().to_array(),
        sampler,
        anisotropy: anisotropy as f32,
        count: COUNT as u32,
        ..Default::default()
    };
    let [map, importance] = cache.environment_resources();
    let out = ResourceId(u64::MAX);
    let size = COUNT as u64 * 16;
    recording.push(Step::CreateBuffer { id: out, label: "directions", size });
    recording.push(Step::Dispatch {
        kernel: Kernel::SampleDirections,
        uniforms: vec![bytemuck::bytes_of(&frame).to_vec(), bytemuck::bytes_of(&params).to_vec()],
        resources: vec![map, importance, out],
        workgroups: [(COUNT as u32).div_ceil(64), 1],
    });
    recording.push(Step::ReadBuffer { id: out, range: 0..size });
    recording.push(Step::Free { id: out });
    let read_back = gpu.executor.execute(&recording).unwrap().remove(0);
    let floats: Vec<[f32; 4]> =
        read_back.wait().unwrap().chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
    floats
        .iter()
        .map(|d| {
            let direction = DVec3::new(d[0].into(), d[1].into(), d[2].into());
            // Unit to f32's precision; the test below wants it to f64's.
            assert!((direction.length() - 1.0).abs() < 1e-4, "{direction}");
            (direction.normalize(), f64::from(d[3]))
        })
        .collect()
}

fn assert_fits(name: &str, drawn: &[(DVec3, f64)], cells: usize, density: impl Fn(DVec3) -> f64) {
    let mut directions = drawn.iter().map(|d| d.0);
    let test = SphereTest { samples: COUNT, tests: 14, cells, ..Default::default() };
    let fit = test.run(&density, || directions.next().unwrap());
    assert_eq!(fit.verdict, Verdict::Accepted, "{name}: {fit}");
    // The density that weighs the samples is the one that they follow, but for rounding into a neighbouring cell.
    let off = drawn
        .iter()
        .filter(|(direction, claimed)| {
            let expected = density(*direction);
            (claimed - expected).abs() > 0.01 * expected + 1e-4
        })
        .count();
    assert!(off < COUNT / 200, "{name}: {off} of {COUNT} densities are wrong");
}

#[test]
fn henyey_greenstein_and_cosine_directions_follow_their_densities() {
    let axis = DVec3::new(0.3, -0.8, 0.5).normalize();
    let light = Environment::uniform(1.0);
    for g in [0.0, 0.5, -0.7, 0.9] {
        let drawn = draw(&light, 1, axis, g);
        assert_fits(&format!("Henyey-Greenstein {g}"), &drawn, 16, |d| henyey_greenstein(d.dot(axis), g));
        let cosine = drawn.iter().map(|d| d.0.dot(axis)).sum::<f64>() / COUNT as f64;
        assert!((cosine - g).abs() < 0.005, "the mean cosine is {cosine}, not {g}");
    }
    for axis in [axis, DVec3::NEG_Z] {
        assert_fits("cosine", &draw(&light, 2, axis, 0.0), 16, |d| cosine_hemisphere(d.dot(axis)));
    }
}

#[test]
fn directions_of_an_event_follow_the_densities_of_all_its_lobes() {
    let normal = DVec3::new(0.3, -0.8, 0.5).normalize();
    let drawn = draw(&Environment::uniform(1.0), 5, normal, 0.8);
    assert_fits("an event", &drawn, 16, |d| {
        0.2 * henyey_greenstein(d.dot(DVec3::X), 0.3)
            + 0.3 * henyey_greenstein(d.dot(DVec3::Y), 0.8)
            + 0.5 * cosine_hemisphere(d.dot(normal))
    });
}

#[test]
fn light_directions_are_uniform_over_cones_and_discs() {
    let axis = DVec3::new(0.3, -0.8, 0.5).normalize();
    let light = Environment::uniform(1.0);
    for angle in [0.2f64, 1.9] {
        let height = 1.0 - angle.cos();
        let drawn = draw(&light, 3, axis, height);
        assert_fits(&format!("cone of {angle}"), &drawn, 64, |d| {
            if d.dot(axis) >= 1.0 - height { 1.0 / (2.0 * PI * height) } else { 0.0 }
        });
    }
    for radius in [0.3, 2.0] {
        let drawn = draw(&light, 4, axis, radius);
        // A direction of that cosine to the axis meets the disc's plane at its tangent.
        assert_fits(&format!("disc of {radius}"), &drawn, 64, |d| {
            let cosine = d.dot(axis);
            let on_disc = cosine > 0.0 && (1.0 - cosine * cosine).sqrt() / cosine <= radius;
            if on_disc { 1.0 / (cosine.powi(3) * PI * radius * radius) } else { 0.0 }
        });
    }
}

#[test]
fn environment_directions_follow_luminance() {
    for (name, mut light) in [("two suns", scenes::two_suns()), ("gradient", scenes::gradient_light())] {
        light.rotation = 0.7;
        let drawn = draw(&light, 0, DVec3::Y, 0.0);
        // Expected without a word from the sampler: the luminance of the map's texels, spread over neighbours as
        // bilinear interpolation spreads their light, times sin(theta), over its sum.
        let map = light.to_map();
        let (width, height) = (map.width as i64, map.height as i64);
        let mut weights = vec![0.0; map.texels.len()];
        for y in 0..height {
            let sin_theta = ((y as f64 + 0.5) / height as f64 * PI).sin();
            for x in 0..width {
                let [r, g, b] = map.texels[(y * width + x) as usize].map(f64::from);
                let weight = (0.2126 * r + 0.7152 * g + 0.0722 * b) * sin_theta;
                for (dy, share_y) in [(-1, 0.125), (0, 0.75), (1, 0.125)] {
                    for (dx, share_x) in [(-1, 0.125), (0, 0.75), (1, 0.125)] {
                        let row = (y + dy).clamp(0, height - 1);
                        let index = row * width + (x + dx).rem_euclid(width);
                        weights[index as usize] += weight * share_x * share_y;
                    }
                }
            }
        }
        let total: f64 = weights.iter().sum();
        let density = |d: DVec3| {
            let (sin, cos) = light.rotation.sin_cos();
            let d = DVec3::new(d.x * cos - d.z * sin, d.y, d.x * sin + d.z * cos);
            let [u, v] = uv_from_direction(d);
            let x = ((u * width as f64) as i64).min(width - 1);
            let y = ((v * height as f64) as i64).min(height - 1);
            let probability = weights[(y * width + x) as usize] / total * (width * height) as f64;
            probability / (2.0 * PI * PI * (v * PI).sin().max(1e-9))
        };
        assert_fits(name, &drawn, 64, density);
    }
}
