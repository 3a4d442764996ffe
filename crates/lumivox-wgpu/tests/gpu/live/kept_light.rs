//! Light that is kept in volumes, for pictures while something moves.

mod cells;
mod changes;
mod hosts;
mod reference;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Camera, Environment};
use lumivox_renderer::live::LiveImage;
use lumivox_renderer::{LiveSettings, Recording};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::{Gpu, RenderRequest};

use super::Host;
use crate::{film, gpu};

const SIZE: u32 = 48;
const PIXELS: u64 = (SIZE * SIZE) as u64;

fn settings() -> LiveSettings {
    LiveSettings::new(SIZE, SIZE).with(|it| it.kept_light = true)
}

/// A camera that has gone around the scene for so many frames.
fn around(test: &TestScene, frame: usize) -> Camera {
    let camera = test.camera.with_aspect(1.0);
    let turn = DAffine3::from_rotation_y(0.01 * frame as f64);
    Camera { world_from_camera: turn * camera.world_from_camera, ..camera }
}

/// Light and alpha, pixel by pixel, as a host is given them.
fn shown(host: &Host, gpu: &mut Gpu) -> Vec<[f32; 4]> {
    let mut recording = Recording::new();
    host.live.record_read(LiveImage::Color, &mut recording).unwrap();
    let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
    bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect()
}

fn luminance(pixel: &[f32; 4]) -> f64 {
    let [r, g, b] = [0, 1, 2].map(|i| f64::from(pixel[i]));
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

fn mean(pixels: &[[f32; 4]]) -> f64 {
    pixels.iter().map(luminance).sum::<f64>() / pixels.len() as f64
}

/// Root of the mean square of luminance.
fn error(picture: &[[f32; 4]], converged: &[[f32; 4]]) -> f64 {
    let square = |(a, b): (&[f32; 4], &[f32; 4])| (luminance(a) - luminance(b)).powi(2);
    (picture.iter().zip(converged).map(square).sum::<f64>() / picture.len() as f64).sqrt()
}

/// What a view at rest shows at last, of other random numbers.
fn still(gpu: &mut Gpu, test: &TestScene, camera: &Camera, settings: LiveSettings) -> Vec<[f32; 4]> {
    still_of(96, gpu, test, camera, settings)
}

/// How bright that is: of a whole picture's mean, a few samples know all that there is to know.
fn brightness(gpu: &mut Gpu, test: &TestScene, camera: &Camera, settings: LiveSettings) -> f64 {
    mean(&still_of(48, gpu, test, camera, settings))
}

fn still_of(
    samples: u32,
    gpu: &mut Gpu,
    test: &TestScene,
    camera: &Camera,
    settings: LiveSettings,
) -> Vec<[f32; 4]> {
    let settings = settings.with(|it| {
        it.kept_light = false;
        it.target_samples = samples;
        it.seed = 7;
    });
    let mut host = Host::new(gpu, test, settings);
    host.converge(gpu, camera, 64 * PIXELS);
    shown(&host, gpu)
}

/// What a view shows that has gone around a scene until `frame`.
fn moving(gpu: &mut Gpu, test: &TestScene, frame: usize, settings: LiveSettings) -> Vec<[f32; 4]> {
    let mut host = Host::new(gpu, test, settings);
    orbit(&mut host, gpu, test, 0..frame + 1, PIXELS);
    shown(&host, gpu)
}

fn orbit(host: &mut Host, gpu: &mut Gpu, test: &TestScene, frames: std::ops::Range<usize>, budget: u64) {
    for frame in frames {
        host.frame(gpu, &around(test, frame), budget);
    }
}

/// What loses no light and is lit alike from everywhere is as bright as that: through the phase function, surfaces, labels'
/// looks and overlapping volumes, at any budget.
#[test]
fn a_furnace_in_motion_is_as_bright_as_its_walls() {
    let mut gpu = gpu();
    let all = [
        scenes::noise(),
        scenes::surface_reflection(),
        scenes::overlapping_volumes(),
        scenes::clip_box(),
        scenes::tricubic(),
    ];
    for test in all.map(scenes::furnace) {
        for budget in [PIXELS / 8, 2 * PIXELS] {
            let mut host = Host::new(&mut gpu, &test, settings());
            // What mirrors is seldom met by few points, and what is all but transparent: they need longer. A third of either goes
            // into the picture.
            let frames = if budget < PIXELS { 160 } else { 9 };
            orbit(&mut host, &mut gpu, &test, 0..frames, budget);
            let picture = shown(&host, &mut gpu);
            let (mut of_light, mut of_alpha) = (0.0, 0.0);
            for (i, pixel) in picture.iter().enumerate() {
                let alpha = f64::from(pixel[3]);
                let light = luminance(pixel);
                assert!((light - alpha).abs() < 0.25 * alpha + 1e-3, "{}: pixel {i}: {pixel:?}", test.name);
                of_light += light;
                of_alpha += alpha;
            }
            // Light and its colour have nine bits each, what is read of them eight.
            let ratio = of_light / of_alpha;
            assert!((ratio - 1.0).abs() < 0.01, "{}: {ratio} times as bright", test.name);
        }
    }
}

/// In the mean over the image, and far better than so many samples by themselves.
#[test]
fn a_moving_picture_is_nearly_the_converged_one() {
    let mut gpu = gpu();
    for test in [scenes::noise(), scenes::surface_reflection(), scenes::stage()] {
        assert_nearly_converged(&mut gpu, &test, 0.9, 0.05);
    }
    // Eight first collisions of a pixel are not many: .92 on an H200.
    let most = if gpu.description.software { 0.9 } else { 0.95 };
    assert_nearly_converged(&mut gpu, &scenes::overlapping_volumes(), most, 0.05);
}

#[test]
#[ignore = "slow: script/test --all"]
fn a_moving_picture_is_nearly_the_converged_one_in_every_scene() {
    let mut gpu = gpu();
    for test in scenes::all() {
        // Eight first collisions of a pixel are not many, where there are several volumes.
        assert_nearly_converged(&mut gpu, &test, 1.2, 0.1);
    }
}

/// The error is at most so many times that of as many samples, and the brightness no farther off than that.
fn assert_nearly_converged(gpu: &mut Gpu, test: &TestScene, most: f64, far: f64) {
    let last = 23;
    let converged = still(gpu, test, &around(test, last), settings());
    let [kept, raw] = [true, false]
        .map(|kept_light| moving(gpu, test, last, settings().with(|it| it.kept_light = kept_light)));
    let (of_kept, of_raw) = (error(&kept, &converged), error(&raw, &converged));
    let ratio = mean(&kept) / mean(&converged);
    println!("{}: error {of_kept:.4}, of samples alone {of_raw:.4}, mean {ratio:.4}", test.name);
    assert!(of_kept < most * of_raw, "{}: {of_kept} where samples alone have {of_raw}", test.name);
    assert!((ratio - 1.0).abs() < far, "{}: {ratio} times as bright", test.name);
}

/// A picture at rest is the film's, to the bit, whatever was shown before; of few samples, too. Then nothing is traced any more. On
/// large GPUs several invocations share a pixel of so few: there sums are rounded otherwise.
#[test]
fn at_rest_nothing_is_left_of_it() {
    let mut gpu = gpu();
    let test = scenes::surface_reflection();
    let camera = around(&test, 9);
    for target in [300, 12] {
        nothing_is_left(&mut gpu, &test, &camera, target);
    }
}

fn nothing_is_left(gpu: &mut Gpu, test: &TestScene, camera: &Camera, target: u32) {
    let of = |gpu: &mut Gpu, kept_light: bool| {
        let mut host = Host::new(
            gpu,
            test,
            settings().with(|it| {
                it.kept_light = kept_light;
                it.target_samples = target;
            }),
        );
        orbit(&mut host, gpu, test, 0..10, PIXELS);
        // A sample in each pass, whatever light takes of it: sums are rounded alike.
        host.converge(gpu, camera, 19 * PIXELS / 10);
        assert!(host.live.image(LiveImage::KeptLight).is_none());
        (host.film(gpu), shown(&host, gpu))
    };
    let (film, picture) = of(gpu, true);
    let (other_film, other_picture) = of(gpu, false);
    for pixel in 0..PIXELS as usize {
        let pairs = film.radiance(pixel).into_iter().zip(other_film.radiance(pixel));
        let shown = picture[pixel].map(f64::from).into_iter().zip(other_picture[pixel].map(f64::from));
        let tolerance = if gpu.description.software { 0.0 } else { 1e-6 };
        for (a, b) in pairs.chain(shown) {
            assert!((a - b).abs() <= tolerance * b.abs(), "pixel {pixel}: {a} is not {b}");
        }
    }
}

/// A scene that has gone dark is dark half a second later, though the camera never rests.
#[test]
fn light_that_is_switched_off_leaves_no_glow() {
    let mut gpu = gpu();
    let lit = scenes::noise();
    let mut host = Host::new(&mut gpu, &lit, settings());
    orbit(&mut host, &mut gpu, &lit, 0..40, 2 * PIXELS);
    let before = mean(&shown(&host, &mut gpu));
    let mut scene = lit.scene.clone();
    scene.environment = Environment::uniform(1e-4);
    host.set_scene(&mut gpu, &scene);
    orbit(&mut host, &mut gpu, &lit, 40..70, 2 * PIXELS);
    let after = mean(&shown(&host, &mut gpu));
    assert!(before > 0.01 && after < 0.01 * before, "{after} of {before}");
}

/// What a host draws hides what is behind it, and cuts volumes short.
#[test]
fn a_mesh_hides_kept_light() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let distance = test.camera.world_from_camera.translation.distance(DVec3::ZERO);
    let mut host = Host::new(&mut gpu, &test, settings());
    for frame in 0..12 {
        host.set_depth(&gpu, |[x, _]| if x < SIZE / 2 { 0.3 * distance } else { 0.0 });
        host.frame(&mut gpu, &around(&test, frame), PIXELS);
    }
    let picture = shown(&host, &mut gpu);
    let half = |left: bool| {
        let at = |i: &usize| (*i as u32 % SIZE < SIZE / 2) == left;
        (0..PIXELS as usize).filter(at).map(|i| f64::from(picture[i][3])).sum::<f64>()
    };
    assert_eq!(half(true), 0.0);
    assert!(half(false) > 10.0);
}

/// The film of a view that keeps light is that of any other.
#[test]
fn the_film_is_the_headless_film() {
    let test = scenes::noise();
    let still = film(&test, &RenderRequest::new(SIZE, SIZE, 24));
    let mut gpu = gpu();
    let mut host = Host::new(&mut gpu, &test, settings().with(|it| it.target_samples = 24));
    host.converge(&mut gpu, &test.camera.with_aspect(1.0), 4 * PIXELS);
    super::assert_same(&host.film(&mut gpu), &still, 0..PIXELS as usize);
}
