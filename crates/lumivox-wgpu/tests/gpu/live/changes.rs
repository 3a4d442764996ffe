//! What is shown after the scene changed is of the new scene alone.

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Camera, ClipKind, ClipShape, LightKind, Scene};
use lumivox_renderer::LiveSettings;
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::{Gpu, RenderRequest};

use super::{Host, assert_same};
use crate::{film, first_pictures, gpu};

/// A head, whole and with its front cut away, and a camera that looks into it.
fn heads() -> (Scene, TestScene, Camera) {
    let mut test = first_pictures::head();
    let camera = test.camera.with_aspect(1.0);
    let whole = test.scene.clone();
    let middle = test.scene.volumes[0].volume.center_mm();
    test.scene.volumes[0].clip_shapes = vec![ClipShape {
        kind: ClipKind::Plane,
        patient_from_shape: DAffine3::from_translation(middle - DVec3::Y * 30.0)
            * DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2),
        inverted: false,
    }];
    (whole, test, camera)
}

/// Of a head that was done, by frames of whatever budget.
#[test]
fn a_cut_shows_nothing_of_what_was_before() {
    const SIZE: u32 = 64;
    let (whole, test, camera) = heads();
    let mut gpu = gpu();
    for (denoise, budget) in [(false, 600), (true, 6000)] {
        let settings = LiveSettings::new(SIZE, SIZE).with(|it| {
            it.target_samples = 32;
            it.denoise = denoise;
            // What is known of light changes with the scene.
            it.kept_light = false;
        });
        let mut before = Host::new(&mut gpu, &TestScene { scene: whole.clone(), ..test.clone() }, settings);
        before.converge(&mut gpu, &camera, 200_000);
        before.set_scene(&mut gpu, &test.scene);
        let mut fresh = Host::new(&mut gpu, &test, settings);
        for frame in 0..4 {
            let [a, b] = [&mut before, &mut fresh].map(|host| {
                host.set_color(&gpu, |_| [0.0, 0.0, 0.0, 1.0]);
                host.frame(&mut gpu, &camera, budget);
                host.read_color(&gpu)
            });
            let far = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(far < 1e-6, "denoise {denoise}, budget {budget}, frame {frame}: differs by {far}");
        }
    }
}

/// Where the coarse picture is another than the fine one's samples say, it goes long before these are enough for a picture of
/// their own: an opened socket is not seen through a blur of what is around it.
#[test]
fn a_coarse_picture_goes_where_fine_samples_contradict_it() {
    const SIZE: u32 = 64;
    const SAMPLES: u32 = 8;
    let (_, test, camera) = heads();
    let mut gpu = gpu();
    let settings = LiveSettings::new(SIZE, SIZE).with(|it| {
        it.target_samples = 64;
        it.kept_light = false;
    });
    let mut shown = |budget: u64, samples: u32| {
        let mut host = Host::new(&mut gpu, &test, settings);
        while host.frame(&mut gpu, &camera, budget).samples < samples {}
        host.set_color(&gpu, |_| [0.0, 0.0, 0.0, 1.0]);
        host.frame(&mut gpu, &camera, 1);
        host.read_color(&gpu)
    };
    let truth = shown(u64::MAX, 48);
    // After a coarse picture, and after none.
    let [with, without] = [u64::from(SIZE * SIZE) / 4, u64::from(SIZE * SIZE) * 2].map(|budget| {
        let picture = shown(budget, SAMPLES);
        // Of pixels that are dark in truth: what makes them bright is the blur of their neighbours.
        let light = |picture: &[f32], at: usize| (0..3).map(|i| f64::from(picture[4 * at + i])).sum::<f64>();
        let dark: Vec<usize> = (0..(SIZE * SIZE) as usize).filter(|&at| light(&truth, at) < 0.15).collect();
        let excess = |&at: &usize| light(&picture, at) - light(&truth, at);
        dark.iter().map(excess).sum::<f64>() / dark.len() as f64
    });
    println!("dark pixels are too bright by {with:.4} with a coarse film, by {without:.4} without");
    assert!(with < 0.01, "{with} and {without}");
}

/// A scene whose lamps and environment shine `of_lamps` and `of_environment` times as bright.
fn lit(test: &TestScene, of_lamps: f64, of_environment: f64) -> Scene {
    let mut scene = test.scene.clone();
    scene.environment.strength *= of_environment;
    for light in &mut scene.lights {
        match &mut light.kind {
            LightKind::Directional { irradiance, .. } => *irradiance = irradiance.map(|c| c * of_lamps),
            LightKind::Point(lamp) | LightKind::Spot { lamp, .. } => {
                lamp.intensity = lamp.intensity.map(|c| c * of_lamps);
            }
        }
    }
    scene
}

/// The film goes on, and what is shown of it is what a film of the brighter light shows.
#[test]
fn light_that_changes_by_a_factor_alone_starts_nothing_over() {
    const SIZE: u32 = 32;
    let test = scenes::bulbs();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(SIZE, SIZE).with(|it| it.target_samples = 8);
    let mut host = Host::new(&mut gpu, &test, settings);
    // A torch in every frame, from the first one on.
    for frame in 0..60 {
        let factor = 1.0 + 0.3 * (f64::from(frame) * 0.7).sin();
        host.set_scene(&mut gpu, &lit(&test, factor, factor));
        host.frame(&mut gpu, &camera, 400);
    }
    let status = host.live.status();
    assert!(status.converged, "the torch keeps the film at {status:?}");
    let picture = |host: &mut Host, gpu: &mut Gpu, scene: &Scene| {
        host.set_scene(gpu, scene);
        let traced = host.converge(gpu, &camera, u64::MAX);
        host.set_color(gpu, |_| [0.0, 0.0, 0.0, 1.0]);
        host.frame(gpu, &camera, u64::MAX);
        (host.read_color(gpu), traced)
    };
    for (of_lamps, of_environment, goes_on) in [(1.3, 1.3, true), (1.3, 1.0, false), (1.0, 0.5, false)] {
        let scene = lit(&test, of_lamps, of_environment);
        let (shown, traced) = picture(&mut host, &mut gpu, &scene);
        assert_eq!(traced == 0, goes_on, "{of_lamps} {of_environment}");
        let mut fresh = Host::new(&mut gpu, &TestScene { scene: scene.clone(), ..test.clone() }, settings);
        let (wanted, _) = picture(&mut fresh, &mut gpu, &scene);
        let far = shown.iter().zip(&wanted).map(|(a, b)| (a - b).abs() / (b.abs() + 0.1)).fold(0.0, f32::max);
        assert!(far < 5e-3, "{of_lamps} {of_environment}: differs by {far}");
    }
}

/// Light that flickers: the image goes on, fine, and is of its last light alone once that rests.
#[test]
fn light_that_changes_a_little_keeps_the_image() {
    const SIZE: u32 = 32;
    const SAMPLES: u32 = 48;
    // A third of a sample for each pixel.
    const BUDGET: u64 = 341;
    let test = scenes::bulbs();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(SIZE, SIZE).with(|it| {
        it.target_samples = SAMPLES;
        it.kept_light = false;
    });
    let shown = |host: &mut Host, gpu: &mut Gpu, budget: u64| {
        host.set_color(gpu, |_| [0.0, 0.0, 0.0, 1.0]);
        host.frame(gpu, &camera, budget);
        host.read_color(gpu)
    };
    // Of one that comes and goes in waves, and one that jumps in every frame.
    let wave = |frame: u32| 1.0 + 0.2 * (f64::from(frame) * 0.15).sin();
    let jumps = |frame: u32| 1.0 + 0.2 * (f64::from(frame.wrapping_mul(0x9e37_79b9) >> 16) / 32768.0 - 1.0);
    let mut last = (None, test.scene.clone());
    for (flicker, name, far) in [(&wave as &dyn Fn(u32) -> f64, "a wave", 0.05), (&jumps, "jumps", 0.1)] {
        let mut host = Host::new(&mut gpu, &test, settings);
        for frame in 0..80 {
            host.set_scene(&mut gpu, &lit(&test, flicker(frame), 1.0));
            let status = host.frame(&mut gpu, &camera, BUDGET);
            assert!(!status.converged && (frame < 12 || status.samples > 0), "{name}, {frame}: {status:?}");
        }
        let now = lit(&test, flicker(80), 1.0);
        host.set_scene(&mut gpu, &now);
        let picture = shown(&mut host, &mut gpu, BUDGET);

        let fresh = TestScene { scene: now.clone(), ..test.clone() };
        let truth = {
            let settings = settings.with(|it| it.target_samples = 320);
            let mut host = Host::new(&mut gpu, &fresh, settings);
            host.converge(&mut gpu, &camera, u64::MAX);
            shown(&mut host, &mut gpu, u64::MAX)
        };
        let anew = shown(&mut Host::new(&mut gpu, &fresh, settings), &mut gpu, BUDGET);
        let error = |a: &[f32]| {
            let squares = a.iter().zip(&truth).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
            (squares / truth.iter().map(|b| f64::from(*b).powi(2)).sum::<f64>()).sqrt()
        };
        let sum = |a: &[f32]| a.chunks(4).flat_map(|c| &c[..3]).map(|c| f64::from(*c)).sum::<f64>();
        println!("{name}: errors {} and, anew, {}", error(&picture), error(&anew));
        println!("  light {}", sum(&picture) / sum(&truth));
        assert!(error(&picture) < 0.8 * error(&anew), "{name}: {} and {}", error(&picture), error(&anew));
        assert!((sum(&picture) / sum(&truth) - 1.0).abs() < far, "{name}");

        // While the new film fills, the one before is seen: the picture gets no worse.
        let mut before = error(&picture);
        for frame in 0..200 {
            let now = error(&shown(&mut host, &mut gpu, BUDGET));
            assert!(now < before + 0.05, "{name}, frame {frame}: {now} after {before}");
            before = now;
        }
        host.converge(&mut gpu, &camera, BUDGET);
        last = (Some(host.film(&mut gpu)), now);
    }
    drop(gpu);
    let (live, scene) = last;
    let still = film(&TestScene { scene, ..test }, &RenderRequest::new(SIZE, SIZE, SAMPLES));
    assert_same(&live.unwrap(), &still, 0..(SIZE * SIZE) as usize);
}

/// However long an image was traced before: a lamp that is dimmed once is seen to be, and no new image has to begin for that.
#[test]
fn a_lamp_that_is_dimmed_under_a_finished_image_is_dimmed_soon() {
    const SIZE: u32 = 32;
    const BUDGET: u64 = 1024;
    let test = scenes::bulbs();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings::new(SIZE, SIZE).with(|it| it.target_samples = 256);
    let light = |host: &mut Host, gpu: &mut Gpu, budget: u64| {
        host.set_color(gpu, |_| [0.0, 0.0, 0.0, 1.0]);
        host.frame(gpu, &camera, budget);
        host.read_color(gpu).chunks(4).flat_map(|c| &c[..3]).map(|c| f64::from(*c)).sum::<f64>()
    };
    let finished = |gpu: &mut Gpu, scene: Scene| {
        let mut host = Host::new(gpu, &TestScene { scene, ..test.clone() }, settings);
        host.converge(gpu, &camera, u64::MAX);
        let light = light(&mut host, gpu, u64::MAX);
        (host, light)
    };
    let dimmed = lit(&test, 0.7, 1.0);
    let (_, wanted) = finished(&mut gpu, dimmed.clone());
    let (mut host, before) = finished(&mut gpu, test.scene.clone());
    host.set_scene(&mut gpu, &dimmed);
    // Less than it takes light to rest.
    let shown: Vec<f64> = (0..20).map(|_| light(&mut host, &mut gpu, BUDGET)).collect();
    let left = (shown[19] - wanted) / (before - wanted);
    println!("of {} that are to go {left} are left", before - wanted);
    assert!(host.live.status().samples > 0 && (before - wanted) / wanted > 0.03);
    assert!(left.abs() < 0.6, "{before} to {wanted}: {shown:?}");
}
