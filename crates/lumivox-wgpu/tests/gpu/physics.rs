//! What must hold whatever the reference says: energy, Beer's law, scale.

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Environment, Medium, Modality, PerspectiveCamera, Scene, TransferFunction, Volume, VolumeInstance, Voxels,
};
use lumivox_renderer::EnvironmentSampling;
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::RenderRequest;
use std::sync::Arc;

use crate::film;

/// Non-absorbing media in unit light: radiance equals alpha in expectation, for every shading option, with and
/// without light sampling.
#[test]
fn white_furnace() {
    for test in scenes::all().into_iter().map(scenes::furnace) {
        for environment_sampling in [EnvironmentSampling::Never, EnvironmentSampling::Always] {
            let request =
                RenderRequest::new(16, 16, 64).with(|it| it.environment_sampling = environment_sampling);
            let film = film(&test, &request);
            let (mut sum, mut variance) = (0.0, 0.0);
            for pixel in 0..256 {
                let (mean, pixel_variance) = film.luminance(pixel);
                sum += mean - film.alpha(pixel);
                variance += pixel_variance;
                if environment_sampling == EnvironmentSampling::Never {
                    // Every path brings exactly 1 home: no noise, only rounding.
                    let error = (mean - film.alpha(pixel)).abs();
                    assert!(error < 1e-4, "{}: pixel {pixel} is off by {error}", test.name);
                }
            }
            let (mean, error) = (sum / 256.0, variance.sqrt() / 256.0);
            assert!(
                mean.abs() < 4.0 * error + 1e-5,
                "{}: {environment_sampling:?} light sampling is off by {mean} +- {error}",
                test.name
            );
        }
    }
}

/// Paths of hundreds of events, each with next-event estimation, take more turns of loops than some drivers allow an
/// invocation: none may be lost, nor end before its time. What they find in a furnace is 1 still.
#[test]
fn long_paths_lose_no_light() {
    let test = scenes::dense_furnace();
    let environment_sampling = EnvironmentSampling::Always;
    let request = RenderRequest::new(12, 12, 8).with(|it| it.environment_sampling = environment_sampling);
    let film = film(&test, &request);
    let (mut mean, mut alpha, mut variance) = (0.0, 0.0, 0.0);
    for pixel in 0..144 {
        let (pixel_mean, pixel_variance) = film.luminance(pixel);
        assert_eq!(film.samples(pixel), 8.0, "pixel {pixel}");
        mean += pixel_mean / 144.0;
        alpha += film.alpha(pixel) / 144.0;
        variance += pixel_variance / 144.0 / 144.0;
    }
    let error = variance.sqrt();
    assert!(error < 0.03 * alpha, "{error} is too much noise to tell");
    assert!((mean - alpha).abs() < 3.0 * error, "{mean} of {alpha} +- {error}");
}

/// A homogeneous slab, 30 mm thick along the view, and a camera far away from it.
fn slab(opacity: f64, density_scale: f64, world_scale: f64) -> TestScene {
    let place = DAffine3::from_scale(DVec3::splat(1.0));
    let volume =
        Volume::new([64, 30, 64], Voxels::U8(vec![0; 64 * 30 * 64]), [1.0, 0.0], place, Modality::Other)
            .unwrap();
    let mut medium = Medium::new(TransferFunction::constant(opacity, [0.7; 3]));
    medium.density_scale = density_scale;
    let mut instance = VolumeInstance::centered(Arc::new(volume), medium);
    instance.world_from_patient =
        DAffine3::from_scale(DVec3::splat(world_scale)) * instance.world_from_patient;
    let scene =
        Scene { volumes: vec![instance], environment: Environment::uniform(1.0), ..Default::default() };
    let camera = PerspectiveCamera::look_at(DVec3::Z * 50.0 * world_scale, DVec3::ZERO, DVec3::Y, 0.0002);
    TestScene { name: "slab", scene, camera }
}

/// Alpha is one minus Beer's transmittance: `exp(-sigma_t d)`.
#[test]
fn slab_transmittance() {
    for (opacity, density) in [(0.5, 0.02), (1.0, 0.05), (0.25, 0.4)] {
        let film = film(&slab(opacity, density, 1.0), &RenderRequest::new(32, 32, 64));
        let n = 32.0 * 32.0 * 64.0;
        let alpha = (0..1024).map(|p| film.alpha(p)).sum::<f64>() / 1024.0;
        let expected = 1.0 - (-opacity * density * 30.0f64).exp();
        let error = (expected * (1.0 - expected) / n).sqrt();
        assert!((alpha - expected).abs() < 4.0 * error, "{alpha} is not {expected} +- {error}");
    }
}

/// A volume ten times as large, seen from ten times as far, is the same image to the bit of the random numbers, but
/// for rounding: the look does not depend on scale.
#[test]
fn scaling_an_object_does_not_change_its_look() {
    let small = film(&slab(1.0, 0.05, 1.0), &RenderRequest::new(16, 16, 64));
    let large = film(&slab(1.0, 0.05, 10.0), &RenderRequest::new(16, 16, 64));
    let mean = |f: &lumivox_renderer::Film| (0..256).map(|p| f.luminance(p).0).sum::<f64>() / 256.0;
    assert!((mean(&small) - mean(&large)).abs() < 0.01 * mean(&small), "{} {}", mean(&small), mean(&large));
    let depth = |f: &lumivox_renderer::Film| (0..256).map(|p| f.depth(p)).sum::<f64>() / 256.0;
    assert!((depth(&large) / depth(&small) - 10.0).abs() < 1e-3);
}
