//! The kernel against the independent f64 reference: z-tests of every pixel and of the whole, for every test scene.

use lumivox_reference::{ReferenceImage, ReferenceSettings};
use lumivox_renderer::{EnvironmentSampling, Film};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_testing::z_test::{Estimate, ZTest};
use lumivox_wgpu::RenderRequest;

use crate::film;

const SIZE: u32 = 24;
const PIXELS: usize = (SIZE * SIZE) as usize;
const SAMPLES: u32 = 512;

/// Many more than the kernel's: without light sampling a small sun is a rare event, and the spread of few rare events is
/// badly known.
const REFERENCE_SAMPLES: u32 = 3072;

/// The variance of a difference between film and reference, over the reference's: both have the same per sample.
const JOINT_VARIANCE: f64 = 1.0 + REFERENCE_SAMPLES as f64 / SAMPLES as f64;

fn reference_of(test: &TestScene) -> ReferenceImage {
    let samples = REFERENCE_SAMPLES;
    let settings = ReferenceSettings { width: 24, height: 24, samples, ..Default::default() };
    lumivox_reference::render(&test.scene, &test.camera, &settings)
}

fn luminance_of(reference: &ReferenceImage) -> Estimate {
    // Channels of one path are fully correlated at most: the bound on the variance of their weighted sum.
    let weights = [0.2126, 0.7152, 0.0722];
    let mean: Vec<f64> = reference.radiance.iter().map(|c| (0..3).map(|i| weights[i] * c[i]).sum()).collect();
    let variance: Vec<f64> = reference
        .radiance_variance
        .iter()
        .map(|v| (0..3).map(|i| weights[i] * v[i].sqrt()).sum::<f64>().powi(2))
        .collect();
    Estimate::gray(24, 24, &mean, &variance)
}

fn luminance_of_film(film: &Film) -> Estimate {
    let (mean, variance): (Vec<f64>, Vec<f64>) = (0..PIXELS).map(|p| film.luminance(p)).unzip();
    Estimate::gray(24, 24, &mean, &variance)
}

/// Blocks of four by four pixels: single pixels of rare bright paths are far from normal.
fn test(tests: usize) -> ZTest {
    ZTest { block: 4, tests, relative_tolerance: 0.004, absolute_tolerance: 1e-5, ..ZTest::default() }
}

#[test]
fn radiance_alpha_and_guides_agree_with_the_reference() {
    compare(&scenes::essential());
}

/// Of a volume; of a label it is among the essential ones.
#[test]
fn metal_agrees_with_the_reference() {
    compare(&[scenes::metallic_surface()]);
}

#[test]
#[ignore = "slow: script/test --all"]
fn radiance_alpha_and_guides_agree_with_the_reference_in_every_scene() {
    compare(&scenes::all());
}

fn compare(tests: &[TestScene]) {
    for scene in tests {
        let reference = reference_of(scene);
        for environment_sampling in [EnvironmentSampling::Always, EnvironmentSampling::Never] {
            let request = RenderRequest::new(SIZE, SIZE, SAMPLES).with(|it| {
                it.environment_sampling = environment_sampling;
                it.guides = environment_sampling == EnvironmentSampling::Always;
            });
            let film = film(scene, &request);
            let name = format!("{}_{environment_sampling:?}", scene.name).to_lowercase();
            test(tests.len() * 2).assert_agree(
                &format!("reference_{name}"),
                &luminance_of_film(&film),
                &luminance_of(&reference),
            );
            compare_first_hits(&name, &film, &reference);
        }
    }
}

/// Alpha, depth, albedo and normal are means over first hits of the same distribution.
fn compare_first_hits(name: &str, film: &Film, reference: &ReferenceImage) {
    let mean = |f: &dyn Fn(usize) -> f64| (0..PIXELS).map(f).sum::<f64>() / PIXELS as f64;
    let alpha = mean(&|p| film.alpha(p));
    let (expected, error) = reference.mean_alpha();
    let error = error * JOINT_VARIANCE.sqrt();
    assert!(
        (alpha - expected).abs() < 4.5 * error + 1e-4,
        "{name}: alpha {alpha}, not {expected} +- {error}"
    );

    let hit = |p: usize| film.alpha(p) > 0.2 && reference.alpha[p] > 0.2;
    let depth = mean(&|p| if hit(p) { film.depth(p) - reference.depth[p] } else { 0.0 });
    let error = (0..PIXELS)
        .filter(|&p| hit(p))
        .map(|p| JOINT_VARIANCE * reference.depth_variance[p])
        .sum::<f64>()
        .sqrt()
        / PIXELS as f64;
    assert!(depth.abs() < 4.5 * error + 1e-6, "{name}: depth is off by {depth} +- {error}");

    if film.albedo(0).is_some() {
        for i in 0..3 {
            let albedo = mean(&|p| {
                if hit(p) { film.albedo(p).unwrap()[i] - reference.albedo[p][i] } else { 0.0 }
            });
            assert!(albedo.abs() < 0.005, "{name}: albedo {i} is off by {albedo}");
            let normal = mean(&|p| {
                if hit(p) { film.normal(p).unwrap()[i] - reference.normal[p][i] } else { 0.0 }
            });
            assert!(normal.abs() < 0.02, "{name}: normal {i} is off by {normal}");
        }
    }
}
