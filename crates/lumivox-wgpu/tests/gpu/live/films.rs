//! The film of a live view is that of a still one, and of the reference.

use lumivox_core::glam::DVec2;
use lumivox_core::{Camera, Environment, EnvironmentSource, Projection, Ray};
use lumivox_reference::medium::place;
use lumivox_reference::path::trace;
use lumivox_reference::rng::Rng;
use lumivox_renderer::live::{Grain, LiveImage};
use lumivox_renderer::{Film, LiveSettings, LoopTurns, Recording};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::RenderRequest;

use super::{Host, assert_same, oblique};
use crate::{film, gpu};

#[test]
fn a_finished_live_film_is_the_headless_film() {
    let test = scenes::overlapping_volumes();
    let wanted = film(&test, &RenderRequest::new(24, 24, 12));
    let mut gpu = gpu();
    for budget in [u64::MAX, 1000, 40] {
        let settings = LiveSettings::new(24, 24).with(|it| it.target_samples = 12);
        let mut host = Host::new(&mut gpu, &test, settings);
        host.converge(&mut gpu, &test.camera.with_aspect(1.0), budget);
        assert_same(&host.film(&mut gpu), &wanted, 0..24 * 24);
    }
}

/// Where a driver ends invocations after a few turns of their loops, a view has converged when every path has ended.
#[test]
fn a_live_film_does_not_depend_on_how_many_turns_loops_may_take() {
    let test = scenes::overlapping_volumes();
    let wanted = film(&test, &RenderRequest::new(24, 24, 6));
    let mut gpu = gpu();
    let limits = gpu.executor.limits();
    for shared in [150, 20] {
        let loop_turns = Some(LoopTurns { shared, alone: 64_000 });
        let settings = LiveSettings::new(24, 24).with(|it| it.target_samples = 6);
        let mut host = Host::within(limits.with(|it| it.loop_turns = loop_turns), &mut gpu, &test, settings);
        host.converge(&mut gpu, &test.camera.with_aspect(1.0), 1000);
        assert_eq!(host.live.status().lost_pixels, 0);
        assert_same(&host.film(&mut gpu), &wanted, 0..24 * 24);
    }
    let loop_turns = Some(LoopTurns { shared: 3, alone: 3 });
    let settings = LiveSettings::new(24, 24).with(|it| it.target_samples = 6);
    let mut host = Host::within(limits.with(|it| it.loop_turns = loop_turns), &mut gpu, &test, settings);
    host.converge(&mut gpu, &test.camera.with_aspect(1.0), 1000);
    assert!(host.live.status().lost_pixels > 0, "what is lost is said");
}

/// Where no event fits into the turns that invocations share, pixels have samples long before the view is done.
#[test]
fn a_live_film_fills_however_few_turns_loops_may_take() {
    let test = scenes::overlapping_volumes();
    let mut gpu = gpu();
    let loop_turns = Some(LoopTurns { shared: 3, alone: 64_000 });
    let limits = gpu.executor.limits().with(|it| it.loop_turns = loop_turns);
    let mut host = Host::within(limits, &mut gpu, &test, LiveSettings::new(24, 24));
    let camera = test.camera.with_aspect(1.0);
    for _ in 0..3 {
        host.frame(&mut gpu, &camera, 2 * 24 * 24);
    }
    let film = host.film(&mut gpu);
    let empty = (0..24 * 24).filter(|pixel| film.samples(*pixel) == 0.0).count();
    assert_eq!(empty, 0, "pixels without samples");
}

/// A host may take its picture when a view says that it is done, and then every pixel has its samples.
#[test]
fn a_live_film_in_pieces_is_done_when_it_is_whole() {
    const TARGET: u16 = 4;
    let test = scenes::overlapping_volumes();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    // Where paths starve, and where they lag behind only.
    for shared in [3, 300] {
        let loop_turns = Some(LoopTurns { shared, alone: 64_000 });
        let limits = gpu.executor.limits().with(|it| it.loop_turns = loop_turns);
        let settings = LiveSettings::new(24, 24).with(|it| it.target_samples = u32::from(TARGET));
        let mut host = Host::within(limits, &mut gpu, &test, settings);
        while !host.frame(&mut gpu, &camera, u64::MAX).converged {}
        let film = host.film(&mut gpu);
        let short = (0..24 * 24).filter(|pixel| film.samples(*pixel) < f32::from(TARGET)).count();
        assert_eq!(short, 0, "pixels lack samples, of {shared} turns");
    }
}

/// Mean alpha and luminance over blocks of pixels agree with the independent reference, whose first collisions beyond
/// the host's surface count as none: what free flights that end there are.
fn compare_with_reference(test: &TestScene, camera: &Camera, samples: u32) {
    const SIZE: u32 = 24;
    const BLOCK: u32 = 6;
    let size = [SIZE, SIZE];
    let mut gpu = gpu();
    let settings = LiveSettings::new(SIZE, SIZE).with(|it| it.target_samples = samples);
    let mut host = Host::new(&mut gpu, test, settings);
    host.set_depth(&gpu, |at| oblique(camera, size, at));
    host.converge(&mut gpu, camera, u64::MAX);
    let film = host.film(&mut gpu);
    drop(gpu);

    let media = place(&test.scene);
    // As every host sees it.
    let source = EnvironmentSource::Map(test.scene.environment.to_map());
    let environment = Environment { source, ..test.scene.environment };
    let forward = -camera.world_from_camera.matrix3.z_axis;
    let blocks = SIZE / BLOCK;
    let mut largest = 0.0f64;
    for block in 0..blocks * blocks {
        // Sums and squares of (alpha, luminance) of the reference, and the film's means.
        let (mut sum, mut square, mut ours, mut ours_variance) = (DVec2::ZERO, DVec2::ZERO, DVec2::ZERO, 0.0);
        let mut n = 0.0;
        for i in 0..BLOCK * BLOCK {
            let at = [block % blocks * BLOCK + i % BLOCK, block / blocks * BLOCK + i / BLOCK];
            let pixel = (at[1] * SIZE + at[0]) as usize;
            let limit = oblique(camera, size, at);
            for sample in 0..samples {
                let mut rng = Rng::new(77, pixel as u64, sample);
                let uv = [0, 1].map(|i| (f64::from(at[i]) + rng.uniform()) / f64::from(SIZE));
                let ray: Ray = camera.ray(uv);
                let path = trace(&media, &environment, &[], ray, &mut rng);
                let hit = path.first_hit.filter(|hit| {
                    limit == 0.0 || (hit.point - camera.world_from_camera.translation).dot(forward) < limit
                });
                let [r, g, b] = path.radiance;
                let value =
                    hit.map_or(DVec2::ZERO, |_| DVec2::new(1.0, 0.2126 * r + 0.7152 * g + 0.0722 * b));
                sum += value;
                square += value * value;
                n += 1.0;
            }
            let (luminance, variance) = film.luminance(pixel);
            ours += DVec2::new(film.alpha(pixel), luminance) / f64::from(BLOCK * BLOCK);
            ours_variance += variance / f64::from(BLOCK * BLOCK).powi(2);
        }
        let mean = sum / n;
        let variance = (square / n - mean * mean) / n;
        let z_alpha = (ours.x - mean.x) / (2.0 * variance.x).sqrt().max(1e-3);
        let z_light = (ours.y - mean.y) / (variance.y + ours_variance).sqrt().max(1e-4);
        largest = largest.max(z_alpha.abs()).max(z_light.abs());
        assert!(z_alpha.abs() < 4.5, "{}: block {block}: alpha {} and {}", test.name, ours.x, mean.x);
        assert!(z_light.abs() < 4.5, "{}: block {block}: light {} and {}", test.name, ours.y, mean.y);
    }
    println!("{}: largest z {largest:.2}", test.name);
}

#[test]
fn the_hosts_depth_ends_primary_rays_as_in_the_reference() {
    let test = scenes::overlapping_volumes();
    compare_with_reference(&test, &test.camera.with_aspect(1.0), 48);
}

#[test]
fn an_eye_of_a_headset_and_a_parallel_view_see_what_the_reference_sees() {
    let test = scenes::overlapping_volumes();
    let half = (test.camera.vertical_fov / 2.0).tan();
    let world_from_camera = test.camera.world_from_camera;
    let tangents = [-1.4 * half, 0.7 * half, -0.8 * half, 1.1 * half];
    compare_with_reference(
        &test,
        &Camera { world_from_camera, projection: Projection::Perspective { tangents } },
        32,
    );
    let reach = half * world_from_camera.translation.length();
    let extents = [-0.9 * reach, 1.1 * reach, -reach, reach];
    compare_with_reference(
        &test,
        &Camera { world_from_camera, projection: Projection::Orthographic { extents } },
        32,
    );
}

/// Several invocations share a coarse pixel's samples: they are those of a headless film of its size.
#[test]
fn a_coarse_film_is_a_small_headless_one() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut before = camera;
    before.world_from_camera.translation.x += 1e-3;
    // Of 32 x 32 pixels; a budget that is not much larger than the last keeps it so coarse. Two, two and four
    // invocations share a pixel.
    for samples in [2, 3, 4] {
        let small = film(&test, &RenderRequest::new(32, 32, samples));
        let mut gpu = gpu();
        let settings = LiveSettings::new(128, 128).with(|it| {
            it.target_samples = 64;
            it.kept_light = false;
        });
        let mut host = Host::new(&mut gpu, &test, settings);
        host.frame(&mut gpu, &before, 2 * 32 * 32);
        let status = host.frame(&mut gpu, &camera, 32 * 32 * u64::from(samples));
        assert_eq!(status.pixel_samples, 32 * 32 * u64::from(samples));
        let mut recording = Recording::new();
        let image = host.live.record_read(LiveImage::Film(Grain::Coarse), &mut recording);
        assert_eq!(image.map(|image| image.size), Some([32, 32]));
        let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
        let mut coarse = Film::new(32, 32, false);
        coarse.insert([0, 0], [32, 32], &bytes);
        assert_same(&coarse, &small, 0..32 * 32);
    }
}
