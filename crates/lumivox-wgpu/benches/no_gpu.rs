//! Where there is no GPU: software Vulkan, or tracing on the CPU? `cargo bench -p lumivox-wgpu --bench no_gpu`.
//!
//! Prints, for each scene, the time of a sample on the device Vulkan offers and in the f64 reference, and the time each
//! needs for an error of 5% of the mean luminance: the kernel samples the light, the reference waits to hit it.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use lumivox_core::{CancelToken, Preset, Progress, Scene, framing};
use lumivox_phantom::{AnatomyOptions, anatomy};
use lumivox_reference::ReferenceSettings;
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::{Gpu, RenderRequest, render};

const SIZE: usize = 128;
const SAMPLES: u32 = 24;

fn main() {
    let mut gpu = Gpu::open(std::env::var("LUMIVOX_GPU").ok().as_deref()).expect("a GPU or software Vulkan");
    println!("{} ({}), {SIZE} x {SIZE} pixels", gpu.description.name, gpu.description.driver);
    println!("{:<24} {:>24} {:>24}", "", "ms per sample", "seconds to 5% error");
    println!("{:<24} {:>12}{:>12} {:>12}{:>12}", "scene", "kernel", "reference", "kernel", "reference");
    for test in [scenes::noise(), scenes::peaky_environment(), scenes::surface_reflection(), phantom()] {
        let [kernel_ms, kernel_error] = kernel(&mut gpu, &test);
        let [reference_ms, reference_error] = reference(&test);
        // Errors are of one sample: as many as the squared ratio are needed.
        let seconds = |ms: f64, error: f64| (error / 0.05).powi(2) * ms / 1e3;
        println!(
            "{:<24} {kernel_ms:>12.1}{reference_ms:>12.1} {:>12.1}{:>12.1}",
            test.name,
            seconds(kernel_ms, kernel_error),
            seconds(reference_ms, reference_error)
        );
    }
}

fn phantom() -> TestScene {
    let options = AnatomyOptions { size: 128, ..Default::default() };
    let volume = Arc::new(anatomy(options, Progress::SILENT, &CancelToken::new()).expect("nobody cancels"));
    let scene = Scene::with_volume(volume.clone(), Preset::CtSkin.medium(&volume));
    let camera = framing::frame(&scene, 0.4, 0.0, 0.5, 1.0).camera();
    TestScene { name: "phantom, ct-skin", scene, camera }
}

/// Milliseconds of a sample, and its root mean square error over the mean luminance.
fn kernel(gpu: &mut Gpu, test: &TestScene) -> [f64; 2] {
    let mut run = |samples| {
        let request = RenderRequest::new(SIZE as u32, SIZE as u32, samples);
        render(gpu, &test.scene, &test.camera, &request, &mut |_| ControlFlow::Continue(()))
            .expect("a render")
    };
    run(2);
    let rendered = run(SAMPLES);
    let (mut mean, mut variance) = (0.0, 0.0);
    for pixel in 0..SIZE * SIZE {
        let (m, v) = rendered.film.luminance(pixel);
        mean += m;
        variance += v * f64::from(SAMPLES);
    }
    [rendered.trace.as_secs_f64() * 1e3 / f64::from(SAMPLES), relative(mean, variance)]
}

fn reference(test: &TestScene) -> [f64; 2] {
    let settings = ReferenceSettings { width: SIZE, height: SIZE, samples: SAMPLES, ..Default::default() };
    let begin = Instant::now();
    let image = lumivox_reference::render(&test.scene, &test.camera, &settings);
    let ms = begin.elapsed().as_secs_f64() * 1e3 / f64::from(SAMPLES);
    // Green stands for luminance, of which it is most.
    let mean = image.radiance.iter().map(|c| c[1]).sum();
    let variance = image.radiance_variance.iter().map(|v| v[1] * f64::from(SAMPLES)).sum();
    [ms, relative(mean, variance)]
}

fn relative(sum_of_means: f64, sum_of_variances: f64) -> f64 {
    let pixels = (SIZE * SIZE) as f64;
    (sum_of_variances / pixels).sqrt() / (sum_of_means / pixels)
}
