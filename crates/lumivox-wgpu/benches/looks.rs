//! What the presets cost: `cargo bench -p lumivox-wgpu --bench looks [VOXELS] [FILTER] [WIDTHxHEIGHT] [OPTION ...]`.
//!
//! Options part the cost: `cells=N` (voxels along a side of a majorant cell), `bounces=N` (at most), `matte` (no surfaces),
//! `white` (light of one colour from everywhere).
//!
//! The phantom head, framed and lit as by `lumivox render --azimuth 25`, in every look for CT: milliseconds per sample, and
//! seconds until the noise of the picture is 2% of its brightness. That is computed from the film's own noise, which falls
//! with the square root of the samples.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use lumivox_core::{CancelToken, Environment, Filter, Preset, Progress, Scene, framing};
use lumivox_phantom::{AnatomyOptions, anatomy};
use lumivox_wgpu::{Gpu, Outcome, RenderRequest, render};

const LOOKS: [Preset; 5] =
    [Preset::CtBone, Preset::CtSkin, Preset::CtMuscle, Preset::CtLung, Preset::CtAngiography];

const SAMPLES: u32 = 256;

/// Enough for [`SAMPLES`] on a GPU; without one, fewer have to do.
const LONGEST: Duration = Duration::from_secs(30);

/// A GPU that was idle takes a while until its clock is what it is at work: without this, the first look took a fifth more.
const WARM_UP: Duration = Duration::from_secs(1);

const NOISE: f64 = 0.02;

/// As `lumivox render` has them.
const AZIMUTH: f64 = 25.0;
const FOV: f64 = 28.0;

/// What a look is measured without.
#[derive(Default)]
struct Options {
    cells: Option<usize>,
    bounces: Option<u32>,
    matte: bool,
    white: bool,
}

fn main() {
    let mut voxels = 512;
    let mut filter = Filter::Trilinear;
    let mut sizes = vec![[1920, 1080], [480, 480]];
    let mut options = Options::default();
    // Cargo itself adds `--bench`.
    for word in std::env::args().skip(1).filter(|word| !word.starts_with("--")) {
        let size = word.split_once('x').map(|(width, height)| [width.parse(), height.parse()]);
        match (word.as_str(), word.parse(), size) {
            ("matte", ..) => options.matte = true,
            ("white", ..) => options.white = true,
            (option, ..) if option.starts_with("cells=") => options.cells = option[6..].parse().ok(),
            (option, ..) if option.starts_with("bounces=") => options.bounces = option[8..].parse().ok(),
            ("nearest", ..) => filter = Filter::Nearest,
            ("trilinear", ..) => filter = Filter::Trilinear,
            ("tricubic", ..) => filter = Filter::Tricubic,
            ("smooth", ..) => filter = Filter::Smooth,
            (_, Ok(number), _) => voxels = number,
            (_, _, Some([Ok(width), Ok(height)])) => sizes = vec![[width, height]],
            _ => panic!("'{word}' is no option"),
        }
    }
    let mut gpu = Gpu::open(std::env::var("LUMIVOX_GPU").ok().as_deref()).expect("a GPU or software Vulkan");
    println!("{} ({})", gpu.description.name, gpu.description.driver);
    let begin = Instant::now();
    let head_options = AnatomyOptions { size: voxels, ..Default::default() };
    let head =
        Arc::new(anatomy(head_options, Progress::SILENT, &CancelToken::new()).expect("nobody cancels"));
    let made = begin.elapsed().as_secs_f64();
    println!("phantom head, {voxels} voxels, {filter:?}; made in {made:.1} s");
    for [width, height] in sizes {
        println!(
            "\n{:<16} {:>12} {:>12} {:>16}",
            format!("{width} x {height}"),
            "ms",
            "Msample/s",
            "s to 2% noise"
        );
        for preset in LOOKS {
            let mut scene = Scene::with_volume(head.clone(), preset.medium(&head));
            let medium = &mut scene.volumes[0].medium;
            medium.filter = filter;
            medium.max_bounces = options.bounces.unwrap_or(medium.max_bounces);
            if options.matte {
                medium.surface.strength = 0.0;
            }
            if options.white {
                scene.environment = Environment::uniform(1.0);
            }
            let name = preset.name();
            let [ms, seconds] = measure(&mut gpu, &scene, [width, height], options.cells);
            let rate = f64::from(width) * f64::from(height) / ms / 1e3;
            println!("{name:<16} {ms:>12.2} {rate:>12.2} {seconds:>16.1}");
        }
    }
}

/// Milliseconds of a sample of all pixels, and seconds until the noise is as low as it should be.
fn measure(gpu: &mut Gpu, scene: &Scene, [width, height]: [u32; 2], cells: Option<usize>) -> [f64; 2] {
    let aspect = f64::from(width) / f64::from(height);
    let camera = framing::frame(scene, AZIMUTH.to_radians(), 0.0, FOV.to_radians(), aspect).camera();
    let mut run = |samples, time| {
        let request = RenderRequest::new(width, height, samples).with(|it| {
            it.time = Some(time);
            it.cell_size = cells;
        });
        render(gpu, scene, &camera, &request, &mut |_| ControlFlow::Continue(())).expect("a render")
    };
    // Kernels are made.
    run(1, LONGEST);
    run(SAMPLES, WARM_UP);
    let rendered = run(SAMPLES, LONGEST);
    if let Outcome::Failed(why) = &rendered.outcome {
        panic!("{why}");
    }
    let film = rendered.film;
    let pixels = width as usize * height as usize;
    let samples = (0..pixels).map(|pixel| f64::from(film.samples(pixel))).sum::<f64>() / pixels as f64;
    let ms = rendered.trace.as_secs_f64() * 1e3 / samples;
    let noise = film.noise().unwrap_or(f64::NAN);
    [ms, (noise / NOISE).powi(2) * samples * ms / 1e3]
}
