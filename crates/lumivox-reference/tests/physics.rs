//! The reference integrator against mathematics.
//!
//! An analog path tracer passes the white furnace without effort: nothing it multiplies can be wrong. Its directions
//! are therefore tested by light that is not uniform, against quadrature that draws no random number.

use std::f64::consts::PI;
use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Ease, Environment, EnvironmentMap, EnvironmentSource, ExtinctionSpace, Light as EngineLight, LightKind,
    Medium, Modality, PerspectiveCamera, Ray, Scene, TransferFunction, Volume, VolumeInstance, Voxels,
};
use lumivox_reference::quadrature::{
    Steps, half_space_beam_radiance, half_space_radiance, single_scattering, slab_beam_single_scattering,
    slab_single_scattering, slab_transmittance, transmittance,
};
use lumivox_reference::{EnvironmentLookup, ReferenceImage, ReferenceSettings, render};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_testing::z_test::{Estimate, ZTest};

fn settings(size: usize, samples: u32, seed: u64) -> ReferenceSettings {
    ReferenceSettings { width: size, height: size, samples, seed, environment: EnvironmentLookup::Map }
}

fn radiance(image: &ReferenceImage) -> Estimate {
    Estimate::rgb(image.width, image.height, &image.radiance, &image.radiance_variance)
}

fn alpha(image: &ReferenceImage) -> Estimate {
    Estimate::gray(image.width, image.height, &image.alpha, &image.alpha_variance)
}

fn depth(image: &ReferenceImage) -> Estimate {
    Estimate::gray(image.width, image.height, &image.depth, &image.depth_variance)
}

/// A camera that looks so narrowly from `eye` at `target` that all of its rays are the same.
fn needle(eye: DVec3, target: DVec3) -> PerspectiveCamera {
    PerspectiveCamera::look_at(eye, target, DVec3::Y, 1e-6)
}

/// A homogeneous white plate of one voxel, `size_mm` large.
fn plate(size_mm: DVec3, sigma_t_per_mm: f64, albedo: f64) -> VolumeInstance {
    let place = DAffine3::from_scale(size_mm);
    let volume = Volume::new([1; 3], Voxels::U8(vec![1]), [1.0, 0.0], place, Modality::Other).unwrap();
    let tf = TransferFunction::from_points(Ease::Linear, &[(0.0, 1.0)], &[(0.0, [1.0; 3])]).unwrap();
    let medium = Medium { density_scale: sigma_t_per_mm, albedo, max_bounces: 1000, ..Medium::new(tf) };
    VolumeInstance::centered(Arc::new(volume), medium)
}

/// A plate so wide that nothing reaches its rim, facing +z, lit uniformly.
fn wide_plate(optical_thickness: f64, albedo: f64) -> Scene {
    let plate = plate(DVec3::new(1000.0, 1.0, 1000.0), optical_thickness, albedo);
    Scene { volumes: vec![plate], environment: Environment::uniform(1.0), ..Default::default() }
}

/// Asserts that a mean with its standard error is `expected`, within 4.5 standard errors and `tolerance`.
#[track_caller]
fn assert_mean((mean, error): (f64, f64), expected: f64, tolerance: f64, what: &str) {
    assert!((mean - expected).abs() < 4.5 * error + tolerance, "{what}: {mean} +- {error} is not {expected}");
}

#[test]
fn a_white_furnace_is_white_in_every_scene() {
    for test in scenes::all() {
        let TestScene { name, scene, camera } = scenes::furnace(test);
        let image = render(&scene, &camera, &settings(16, 64, 1));
        assert!(image.alpha.iter().any(|a| *a > 0.3), "{name} shows nothing");
        for (radiance, alpha) in image.radiance.iter().zip(&image.alpha) {
            assert!(radiance.iter().all(|c| (c - alpha).abs() < 1e-12), "{name}: {radiance:?} {alpha}");
        }
    }
}

#[test]
fn a_slab_transmits_what_beer_and_lambert_say() {
    for (thickness_mm, sigma_t) in [(4.0, 0.05), (10.0, 0.2), (3.0, 1.0)] {
        let scene = Scene {
            volumes: vec![plate(DVec3::new(50.0, thickness_mm, 50.0), sigma_t, 0.5)],
            ..Default::default()
        };
        let image = render(&scene, &needle(DVec3::Z, DVec3::ZERO), &settings(8, 4000, 2));
        let expected = slab_transmittance(sigma_t, thickness_mm);
        let (alpha, error) = image.mean_alpha();
        assert_mean((1.0 - alpha, error), expected, 0.0, "transmittance");
        assert!((transmittance(&scene, DVec3::Z, -DVec3::Z, 10) - expected).abs() < 1e-12);
        // At a slant of 60 degrees the way through is twice as long.
        let slanted = DVec3::new(0.0, 3f64.sqrt() / 2.0, 0.5);
        assert!((transmittance(&scene, slanted, -slanted, 10) - expected * expected).abs() < 1e-12);
    }
}

fn assert_transmittance(tests: Vec<TestScene>) {
    for test in tests {
        let eye = test.camera.world_from_camera.translation;
        let forward = -test.camera.world_from_camera.matrix3.z_axis;
        for (i, shift) in [DVec3::ZERO, DVec3::new(0.002, -0.003, 0.001)].into_iter().enumerate() {
            let camera = PerspectiveCamera {
                vertical_fov: 1e-6,
                world_from_camera: DAffine3::from_translation(shift) * test.camera.world_from_camera,
            };
            let image = render(&test.scene, &camera, &settings(4, 1500, i as u64));
            let expected = 1.0 - transmittance(&test.scene, eye + shift, eye + shift + forward, 20_000);
            assert_mean(image.mean_alpha(), expected, 1e-4, test.name);
        }
    }
}

#[test]
fn alpha_is_one_minus_the_transmittance() {
    assert_transmittance(scenes::essential());
}

#[test]
#[ignore = "slow: script/test --all"]
fn alpha_is_one_minus_the_transmittance_of_every_scene() {
    assert_transmittance(scenes::all());
}

/// Light whose three colours grow along the three axes, then turned: every direction counts differently.
fn directional_light() -> Environment {
    let map = EnvironmentMap::from_fn(64, 64, |d| d.to_array().map(|c| 1.0 + 0.9 * c));
    Environment { source: EnvironmentSource::Map(Arc::new(map)), rotation: 0.6, strength: 0.8 }
}

fn assert_single_scattering(tests: Vec<TestScene>) {
    for mut test in tests {
        test.scene.environment = directional_light();
        for instance in &mut test.scene.volumes {
            instance.medium.max_bounces = 1;
        }
        let camera = PerspectiveCamera { vertical_fov: 1e-6, ..test.camera };
        let image = render(&test.scene, &camera, &settings(8, 3000, 4));
        let ray: Ray = camera.ray([0.5, 0.5], 1.0);
        let steps = match test.scene.lights.is_empty() {
            true => Steps { primary: 192, shadow: 24, polar: 32 },
            // Lamps are few where the environment's errors cancel: a jump of the medium has to be met to a hair.
            false => Steps { primary: 2500, shadow: 24, polar: 20 },
        };
        let expected = single_scattering(&test.scene, &ray, steps);
        for (mean, expected) in image.mean_radiance().into_iter().zip(expected) {
            // The quadrature itself is good to half a percent.
            assert_mean(mean, expected, 5e-3 * expected, test.name);
        }
    }
}

/// Lamps need many more steps: beams have formulas of their own below.
#[test]
fn single_scattering_is_its_quadrature() {
    let tests = scenes::essential().into_iter().filter(|test| test.scene.lights.is_empty());
    assert_single_scattering(tests.collect());
}

#[test]
#[ignore = "slow: script/test --all"]
fn single_scattering_is_its_quadrature_in_every_scene() {
    assert_single_scattering(scenes::all());
}

#[test]
fn a_thin_slab_scatters_once_as_the_exponential_integrals_say() {
    for (optical_thickness, albedo) in [(0.1, 1.0), (1.0, 0.6)] {
        let mut scene = wide_plate(optical_thickness, albedo);
        scene.volumes[0].medium.max_bounces = 1;
        let image = render(&scene, &needle(DVec3::Z, DVec3::ZERO), &settings(8, 4000, 5));
        let expected = slab_single_scattering(albedo, optical_thickness);
        assert_mean(image.mean_radiance()[0], expected, 1e-4, "single scattering");
    }
}

fn assert_half_space(samples: u32) {
    for albedo in [0.5, 0.9, 0.98] {
        let scene = wide_plate(60.0, albedo);
        for mu in [1.0, 0.5] {
            let from = DVec3::new((1.0f64 - mu * mu).sqrt(), 0.0, mu) * 0.2;
            let image = render(&scene, &needle(from, DVec3::new(0.0, 0.0, 5e-4)), &settings(8, samples, 6));
            assert_mean(image.mean_radiance()[0], half_space_radiance(albedo, mu), 2e-4, "half-space");
        }
    }
}

#[test]
fn a_half_space_returns_what_chandrasekhar_says() {
    assert_half_space(200);
}

#[test]
#[ignore = "slow: script/test --all"]
fn a_half_space_returns_closely_what_chandrasekhar_says() {
    assert_half_space(1500);
}

/// A plate that faces +z in a beam alone that comes in at cosine `mu_0` to its normal.
fn plate_in_a_beam(optical_thickness: f64, albedo: f64, mu_0: f64) -> Scene {
    let towards = DVec3::new(0.0, (1.0 - mu_0 * mu_0).sqrt(), mu_0);
    Scene {
        environment: Environment::uniform(0.0),
        lights: vec![EngineLight::directional(-towards, [1.0; 3])],
        ..wide_plate(optical_thickness, albedo)
    }
}

#[test]
fn a_slab_scatters_a_beam_once_as_its_formula_says() {
    for (optical_thickness, albedo, mu_0) in [(0.1, 1.0, 1.0), (1.0, 0.6, 0.4), (2.0, 0.9, 0.7)] {
        let mut scene = plate_in_a_beam(optical_thickness, albedo, mu_0);
        scene.volumes[0].medium.max_bounces = 1;
        let image = render(&scene, &needle(DVec3::Z, DVec3::ZERO), &settings(8, 4000, 18));
        let expected = slab_beam_single_scattering(albedo, optical_thickness, 1.0, mu_0);
        assert_mean(image.mean_radiance()[0], expected, 0.0, "single scattering of a beam");
    }
}

fn assert_half_space_in_a_beam(samples: u32) {
    for (albedo, mu_0) in [(0.5, 1.0), (0.9, 0.3), (0.98, 0.7)] {
        let scene = plate_in_a_beam(60.0, albedo, mu_0);
        let image =
            render(&scene, &needle(DVec3::new(0.0, 0.0, 0.2), DVec3::ZERO), &settings(8, samples, 19));
        let expected = half_space_beam_radiance(albedo, 1.0, mu_0);
        assert_mean(image.mean_radiance()[0], expected, 2e-5, "half-space in a beam");
    }
}

#[test]
fn a_half_space_returns_of_a_beam_what_chandrasekhar_says() {
    assert_half_space_in_a_beam(200);
}

#[test]
#[ignore = "slow: script/test --all"]
fn a_half_space_returns_of_a_beam_closely_what_chandrasekhar_says() {
    assert_half_space_in_a_beam(1500);
}

#[test]
fn a_sun_from_everywhere_is_a_furnace() {
    for test in [scenes::overlapping_volumes(), scenes::glossy_surface()] {
        let TestScene { name, mut scene, camera } = scenes::furnace(test);
        scene.environment = Environment::uniform(0.0);
        let (irradiance, angular_radius) = ([4.0 * PI; 3], PI);
        scene.lights =
            vec![LightKind::Directional { direction: DVec3::Y, irradiance, angular_radius }.into()];
        let image = render(&scene, &camera, &settings(16, 128, 20));
        assert_mean(image.mean_radiance()[1], image.mean_alpha().0, 0.0, name);
    }
}

#[test]
fn overlapping_volumes_are_one_of_their_summed_extinction() {
    let size = DVec3::new(20.0, 12.0, 16.0);
    let environment = scenes::gradient_light();
    let two = Scene {
        volumes: vec![plate(size, 0.04, 0.8), plate(size, 0.11, 0.8)],
        environment: environment.clone(),
        ..Default::default()
    };
    let one = Scene { volumes: vec![plate(size, 0.15, 0.8)], environment, ..Default::default() };
    let camera = lumivox_core::framing::frame(&one, 0.5, 0.3, 0.6, 1.0).camera();
    let [two, one] =
        [(two, 7), (one, 8)].map(|(scene, seed)| render(&scene, &camera, &settings(24, 400, seed)));
    let test = ZTest { tests: 3, block: 3, ..ZTest::default() };
    test.assert_agree("superposition-radiance", &radiance(&two), &radiance(&one));
    test.assert_agree("superposition-alpha", &alpha(&two), &alpha(&one));
    test.assert_agree("superposition-depth", &depth(&two), &depth(&one));
}

#[test]
fn a_scaled_object_looks_the_same() {
    let scaled = |test: &TestScene, scale: f64, space: ExtinctionSpace| {
        let mut scene = test.scene.clone();
        for instance in &mut scene.volumes {
            instance.world_from_patient =
                DAffine3::from_scale(DVec3::splat(scale)) * instance.world_from_patient;
            instance.medium.extinction_space = space;
        }
        let mut camera = test.camera;
        camera.world_from_camera.translation *= scale;
        render(&scene, &camera, &settings(16, 64, 9))
    };
    for test in [scenes::overlapping_volumes(), scenes::surface_reflection()] {
        let small = scaled(&test, 1.0, ExtinctionSpace::Volume);
        let large = scaled(&test, 1000.0, ExtinctionSpace::Volume);
        // The same random numbers: equal but for rounding, which sends a few paths another way.
        let agree = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() < 1e-9).count() as f64 / a.len() as f64
        };
        let same = agree(small.radiance.as_flattened(), large.radiance.as_flattened());
        assert!(same > 0.95, "{}: {same}", test.name);
        assert!((small.mean_alpha().0 - large.mean_alpha().0).abs() < 1e-3, "{}", test.name);
    }
    // In world space, twice as large is twice as opaque; a sheet seen through is then squared.
    let test = TestScene { camera: needle(DVec3::Z, DVec3::ZERO), ..scenes::homogeneous_cube() };
    let once = 1.0 - scaled(&test, 1.0, ExtinctionSpace::World).mean_alpha().0;
    let (alpha, error) = scaled(&test, 2.0, ExtinctionSpace::World).mean_alpha();
    assert_mean((1.0 - alpha, error), once * once, 0.01, "world extinction");
}

#[test]
fn depth_is_the_mean_free_path_into_a_thick_slab() {
    let scene = wide_plate(60.0, 0.5);
    let image = render(&scene, &needle(DVec3::new(0.0, 0.0, 0.1), DVec3::ZERO), &settings(8, 500, 10));
    let n = image.depth.len() as f64;
    let mean = image.depth.iter().sum::<f64>() / n;
    let error = image.depth_variance.iter().sum::<f64>().sqrt() / n;
    // From 100 mm away, the surface lies at 99.5 mm and the mean free path is 1/60 mm.
    assert_mean((mean, error), 0.0995 + 1e-3 / 60.0, 0.0, "depth");
    assert!(image.albedo.iter().flatten().all(|a| (a - 0.5).abs() < 1e-12));
    assert!(image.normal.iter().flatten().all(|n| *n == 0.0), "one voxel has no gradient");
}

#[test]
fn an_image_does_not_depend_on_the_number_of_threads() {
    let test = scenes::noise();
    let parallel = render(&test.scene, &test.camera, &settings(12, 8, 11));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let serial = pool.install(|| render(&test.scene, &test.camera, &settings(12, 8, 11)));
    assert_eq!(parallel, serial);
}

fn assert_seeds_agree(tests: Vec<TestScene>) {
    let count = 3 * tests.len();
    for test in tests {
        let [a, b] = [12, 13].map(|seed| render(&test.scene, &test.camera, &settings(20, 64, seed)));
        // The depth of a pixel with a handful of hits is not normal; blocks of pixels are.
        let z_test = ZTest { tests: count, block: 5, ..ZTest::default() };
        let name = |what: &str| format!("seeds-{}-{what}", test.name);
        z_test.assert_agree(&name("radiance"), &radiance(&a), &radiance(&b));
        z_test.assert_agree(&name("alpha"), &alpha(&a), &alpha(&b));
        z_test.assert_agree(&name("depth"), &depth(&a), &depth(&b));
    }
}

#[test]
fn independent_seeds_agree_and_their_variances_are_honest() {
    assert_seeds_agree(scenes::essential());
}

#[test]
#[ignore = "slow: script/test --all"]
fn independent_seeds_agree_in_every_scene() {
    assert_seeds_agree(scenes::all());
}

#[test]
fn a_slightly_wrong_medium_is_found() {
    type Fault = (&'static str, fn(&mut Medium));
    let faults: [Fault; 5] = [
        ("3% denser", |m| m.density_scale *= 1.03),
        ("2% darker", |m| m.albedo *= 0.98),
        ("g is 0.1 less", |m| m.anisotropy -= 0.1),
        ("one bounce more", |m| m.max_bounces = 3),
        ("no surfaces", |m| m.surface.strength = 0.0),
    ];
    let mut right = scenes::overlapping_volumes();
    right.scene.volumes.iter_mut().for_each(|i| i.medium.max_bounces = 2);
    let reference = render(&right.scene, &right.camera, &settings(32, 400, 16));
    let test = ZTest { block: 8, ..ZTest::default() };
    for (fault, apply) in faults {
        let mut wrong = right.scene.clone();
        wrong.volumes.iter_mut().for_each(|i| apply(&mut i.medium));
        let image = render(&wrong, &right.camera, &settings(32, 400, 17));
        let by_radiance = test.run(&radiance(&image), &radiance(&reference));
        let by_alpha = test.run(&alpha(&image), &alpha(&reference));
        assert!(!by_radiance.accepted || !by_alpha.accepted, "{fault}: {by_radiance}\n{by_alpha}");
    }
}

#[test]
fn nothing_is_seen_of_nothing() {
    let camera = needle(DVec3::Z, DVec3::ZERO);
    let empty = render(&Scene::default(), &camera, &settings(2, 4, 14));
    assert!(empty.alpha.iter().all(|a| *a == 0.0) && empty.radiance.iter().flatten().all(|c| *c == 0.0));
    // A clip box inside out, a transform without volume, no density.
    let mut plates = [(); 3].map(|()| plate(DVec3::ONE, 1.0, 1.0));
    plates[0].clip_box = [DVec3::ONE, DVec3::ZERO];
    plates[1].world_from_patient = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    plates[2].medium.density_scale = 0.0;
    let scene = Scene { volumes: plates.to_vec(), ..Default::default() };
    assert!(render(&scene, &camera, &settings(2, 4, 15)).alpha.iter().all(|a| *a == 0.0));
}
