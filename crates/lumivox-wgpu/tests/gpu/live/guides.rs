//! First-hit albedo and normal of a live view are those of a still one.

use std::num::NonZeroU32;

use lumivox_core::Camera;
use lumivox_renderer::live::{Grain, LiveImage};
use lumivox_renderer::{Film, LiveSettings, LoopTurns, Recording};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::{Gpu, RenderRequest};

use super::{Host, assert_same, oblique};
use crate::{film, gpu};

const SIZE: u32 = 25;
const PIXELS: usize = 25 * 25;
const SAMPLES: u32 = 6;

/// One sample a frame: sums are made in the order of a still film whose passes are of one sample.
const BUDGET: u64 = PIXELS as u64;

fn settings() -> LiveSettings {
    LiveSettings::new(SIZE, SIZE).with(|it| {
        it.target_samples = SAMPLES;
        it.guides = true;
    })
}

/// The fine film, with guides if it has any.
fn film_of(host: &Host, gpu: &mut Gpu) -> Film {
    let mut recording = Recording::new();
    let images = [LiveImage::Film(Grain::Fine), LiveImage::Albedo, LiveImage::Normal];
    let has_guides = images.map(|image| host.live.record_read(image, &mut recording).is_some()) == [true; 3];
    let read_backs = gpu.executor.execute(&recording).unwrap();
    let bytes: Vec<u8> = read_backs.into_iter().flat_map(|read_back| read_back.wait().unwrap()).collect();
    let mut film = Film::new(SIZE, SIZE, has_guides);
    film.insert([0, 0], [SIZE, SIZE], &bytes);
    film
}

fn still(test: &TestScene) -> Film {
    let request = RenderRequest::new(SIZE, SIZE, SAMPLES).with(|it| {
        it.guides = true;
        it.pass_samples = NonZeroU32::new(1);
    });
    film(test, &request)
}

/// Guides and sums, but for the last bits.
fn assert_same_guides(a: &Film, b: &Film) {
    assert!(a.has_guides() && b.has_guides());
    assert_same(a, b, 0..PIXELS);
    for pixel in 0..PIXELS {
        for (x, y) in [(a.albedo(pixel), b.albedo(pixel)), (a.normal(pixel), b.normal(pixel))] {
            let (x, y) = (x.unwrap(), y.unwrap());
            assert!((0..3).all(|i| (x[i] - y[i]).abs() <= 2e-5), "pixel {pixel}: {x:?} {y:?}");
        }
    }
}

#[test]
fn live_guides_are_those_of_a_still_film_to_the_bit() {
    for test in [scenes::overlapping_volumes(), scenes::noise()] {
        let wanted = still(&test);
        let mut gpu = gpu();
        let camera = test.camera.with_aspect(1.0);
        let mut host = Host::new(&mut gpu, &test, settings());
        host.converge(&mut gpu, &camera, BUDGET);
        let live = film_of(&host, &mut gpu);
        assert!(live.has_guides());
        let states_aside = |film: &Film| {
            let mut planes = film.planes().to_vec();
            planes[1].iter_mut().for_each(|moments| moments[3] = 0.0);
            planes
        };
        assert!(states_aside(&live) == states_aside(&wanted), "{}", test.name);
        let hits = (0..PIXELS).filter(|pixel| live.alpha(*pixel) > 0.0);
        assert!(hits.clone().count() > PIXELS / 8);
        assert!(hits.clone().any(|pixel| live.normal(pixel).unwrap().iter().any(|x| x.abs() > 0.1)));
        assert!(hits.clone().all(|pixel| live.albedo(pixel).unwrap().iter().all(|x| *x > 0.0)));
    }
}

/// Where paths are put aside, where few kernels should do, and behind coarse images.
#[test]
fn guides_come_in_pieces_and_behind_coarse_images() {
    let test = scenes::overlapping_volumes();
    let wanted = still(&test);
    let mut gpu = gpu();
    let camera = test.camera.with_aspect(1.0);
    let limits = gpu.executor.limits();
    for (shared, few_kernels, budget) in [(150, false, 1000), (20, false, u64::MAX), (4000, true, 100)] {
        let loop_turns = Some(LoopTurns { shared, alone: 64_000 });
        let limits = limits.with(|it| {
            it.loop_turns = loop_turns;
            it.few_kernels = few_kernels;
        });
        let mut host = Host::within(limits, &mut gpu, &test, settings());
        host.converge(&mut gpu, &camera, budget);
        assert_eq!(host.live.status().lost_pixels, 0);
        assert_same_guides(&film_of(&host, &mut gpu), &wanted);
    }
}

/// Pixels that start over, because a mesh moved, leave nothing behind in guides.
#[test]
fn guides_end_at_the_hosts_depth() {
    let test = scenes::overlapping_volumes();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let shifted =
        |by: u32| move |camera: &Camera, at: [u32; 2]| oblique(camera, [SIZE; 2], [at[0] + by, at[1]]);
    let mut moved = Host::new(&mut gpu, &test, settings());
    moved.set_depth(&gpu, |at| shifted(8)(&camera, at));
    moved.converge(&mut gpu, &camera, BUDGET);
    let before = film_of(&moved, &mut gpu);
    moved.set_depth(&gpu, |at| shifted(0)(&camera, at));
    moved.converge(&mut gpu, &camera, BUDGET);
    let after = film_of(&moved, &mut gpu);
    assert!(before != after);
    let mut fresh = Host::new(&mut gpu, &test, settings());
    fresh.set_depth(&gpu, |at| shifted(0)(&camera, at));
    fresh.converge(&mut gpu, &camera, u64::MAX);
    assert_same_guides(&after, &film_of(&fresh, &mut gpu));
    // No first hit lies behind its pixel's surface.
    for pixel in 0..PIXELS {
        let limit = oblique(&camera, [SIZE; 2], [pixel as u32 % SIZE, pixel as u32 / SIZE]);
        let depth = after.depth(pixel);
        assert!(limit == 0.0 || !depth.is_finite() || depth <= limit * 1.0001, "{pixel}: {depth}, {limit}");
    }
}

/// While light changes a little, a film keeps a part of its samples, and guides of as many; then a film of the last light
/// alone follows, which had another's room.
#[test]
fn guides_last_while_light_changes() {
    let test = scenes::bulbs();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let lit = |brightness: f64| {
        let mut scene = test.scene.clone();
        let light = scene.lights.iter_mut().find_map(|light| match &mut light.kind {
            lumivox_core::LightKind::Point(lamp) => Some(lamp),
            _ => None,
        });
        let lamp = light.expect("it has lamps");
        lamp.intensity = lamp.intensity.map(|x| x * brightness);
        scene
    };
    let mut host = Host::new(&mut gpu, &test, settings());
    host.converge(&mut gpu, &camera, BUDGET);
    let finished = film_of(&host, &mut gpu);
    let scene = lit(1.03);
    host.set_scene(&mut gpu, &scene);
    host.frame(&mut gpu, &camera, BUDGET);
    let faded = film_of(&host, &mut gpu);
    assert!(faded.has_guides() && (0..PIXELS).all(|pixel| faded.samples(pixel) > 1.5), "the film went on");
    // Means do not fade with their counts.
    let mean = |film: &Film| {
        let hits: Vec<f64> = (0..PIXELS)
            .filter_map(|pixel| film.albedo(pixel).filter(|_| film.alpha(pixel) > 0.9))
            .map(|c| c[0])
            .collect();
        hits.iter().sum::<f64>() / hits.len() as f64
    };
    let (a, b) = (mean(&finished), mean(&faded));
    assert!((a - b).abs() < 0.02 * a, "albedo {a} became {b}");

    host.converge(&mut gpu, &camera, BUDGET);
    let rested = film_of(&host, &mut gpu);
    drop(gpu);
    assert_same_guides(&rested, &still(&TestScene { scene, ..test }));
}

#[test]
fn a_view_that_keeps_no_guides_any_more_is_what_it_was() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let wanted = film(&test, &RenderRequest::new(SIZE, SIZE, SAMPLES));
    let mut gpu = gpu();
    let mut host = Host::new(&mut gpu, &test, settings());
    host.converge(&mut gpu, &camera, BUDGET);
    host.settings.guides = false;
    host.converge(&mut gpu, &camera, BUDGET);
    let plain = film_of(&host, &mut gpu);
    assert!(!plain.has_guides());
    assert_same(&plain, &wanted, 0..PIXELS);
    host.settings.guides = true;
    host.converge(&mut gpu, &camera, BUDGET);
    let again = film_of(&host, &mut gpu);
    drop(gpu);
    assert_same_guides(&again, &still(&test));
}
