//! The workloads that peers were timed on: `cargo bench -p lumivox-wgpu --bench peers -- FOLDER [FILTER [check]]`.
//! With `check`, the mean of a small image of each is printed beside the f64 reference's (minutes on a CPU).
//!
//! FOLDER holds `cube.f32`, `ct.i16`, `tf.txt` and `tf_bone.txt` (see benches/README.md). Prints, for each
//! workload, ms per sample, million samples per second, the mean of the image (over its channels), the error of one sample
//! (of luminance, root mean square) and the samples and time to an error of 10% of that mean.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Ease, Environment, EnvironmentMap, EnvironmentSource, Filter, Medium, Modality, PerspectiveCamera, Scene,
    TransferFunction, Volume, Voxels,
};
use lumivox_renderer::EnvironmentSampling;
use lumivox_wgpu::{Gpu, RenderRequest, render};

struct Workload {
    name: String,
    scene: Scene,
    camera: PerspectiveCamera,
    size: [u32; 2],
    /// Whether the mean counts the environment behind the volume.
    background: bool,
    environment_sampling: EnvironmentSampling,
    cell_size: Option<usize>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let Some(folder) = arguments.first() else {
        println!("peers: no folder of volumes given; nothing timed (see benches/README.md)");
        return;
    };
    let filter = arguments.get(1).map_or("", String::as_str);
    let name = std::env::var("LUMIVOX_GPU").ok();
    let mut gpu = Gpu::open(name.as_deref()).expect("a GPU");
    println!("{} ({})", gpu.description.name, gpu.description.driver);
    println!(
        "{:<34} {:>9} {:>9} {:>8} {:>8} {:>9} {:>8}",
        "workload", "ms/sample", "Msample/s", "mean", "rmse@1", "to 10%", "seconds"
    );
    let check = arguments.get(2).is_some_and(|a| a == "check");
    for workload in workloads(Path::new(folder)) {
        if workload.name.contains(filter) {
            time(&mut gpu, &workload);
            if check {
                compare(&mut gpu, &workload);
            }
        }
    }
}

/// The mean of a small image beside the f64 reference's.
fn compare(gpu: &mut Gpu, workload: &Workload) {
    let [width, height] = workload.size.map(|n| n / 12);
    let request = RenderRequest::new(width, height, 2048).with(|it| {
        it.environment_sampling = workload.environment_sampling;
        it.cell_size = workload.cell_size;
    });
    let on_progress = &mut |_: &_| ControlFlow::Continue(());
    let film = render(gpu, &workload.scene, &workload.camera, &request, on_progress).expect("a render").film;
    let settings = lumivox_reference::ReferenceSettings {
        width: width as usize,
        height: height as usize,
        samples: 256,
        ..Default::default()
    };
    let reference = lumivox_reference::render(&workload.scene, &workload.camera, &settings);
    let pixels = (width * height) as usize;
    let mean = (0..pixels).map(|p| film.radiance(p).iter().sum::<f64>() / 3.0).sum::<f64>() / pixels as f64;
    let channels = reference.mean_radiance();
    println!(
        "    mean radiance of {width} x {height}: {mean:.5}, reference {:.5} +- {:.5}",
        channels.iter().map(|c| c.0).sum::<f64>() / 3.0,
        channels.iter().map(|c| c.1).sum::<f64>() / 3.0,
    );
}

fn time(gpu: &mut Gpu, workload: &Workload) {
    let [width, height] = workload.size;
    let mut run = |samples: u32| {
        let request = RenderRequest::new(width, height, samples).with(|it| {
            it.environment_sampling = workload.environment_sampling;
            it.cell_size = workload.cell_size;
            it.seed = 1;
        });
        render(gpu, &workload.scene, &workload.camera, &request, &mut |_| ControlFlow::Continue(()))
            .expect("a render")
    };
    let warm = run(8);
    let per_sample = warm.trace.as_secs_f64() / 8.0;
    let samples = ((1.5 / per_sample) as u32).clamp(8, 512);
    let rendered = run(samples);
    let ms = rendered.trace.as_secs_f64() * 1e3 / f64::from(samples);
    let pixels = (width * height) as usize;
    let (mut sum, mut variance) = (0.0, 0.0);
    for pixel in 0..pixels {
        let (_, v) = rendered.film.luminance(pixel);
        sum += rendered.film.radiance(pixel).iter().sum::<f64>() / 3.0
            + if workload.background { 1.0 - rendered.film.alpha(pixel) } else { 0.0 };
        variance += v * f64::from(samples);
    }
    let mean = sum / pixels as f64;
    let rmse = (variance / pixels as f64).sqrt();
    let needed = (rmse / (0.1 * mean)).powi(2);
    println!(
        "{:<34} {ms:>9.3} {:>9.0} {mean:>8.4} {rmse:>8.4} {needed:>9.0} {:>8.2}",
        workload.name,
        pixels as f64 / ms / 1e3,
        needed * ms / 1e3
    );
}

fn workloads(folder: &Path) -> Vec<Workload> {
    let mut list = vec![];
    if folder.join("cube.f32").exists() {
        list.extend(cubes(folder));
    }
    if folder.join("ct.i16").exists() {
        list.extend(thorax(folder));
    }
    list
}

/// W1: a cube of 256 voxels, seen along its axis; one millimetre a voxel, one world unit a metre.
fn cubes(folder: &Path) -> Vec<Workload> {
    let bytes = std::fs::read(folder.join("cube.f32")).expect("cube.f32");
    let voxels: Vec<f32> =
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let volume =
        Volume::new([256; 3], Voxels::F32(voxels), [1.0, 0.0], DAffine3::IDENTITY, Modality::Other).unwrap();
    let volume = Arc::new(volume);
    let ramp =
        TransferFunction::from_points(Ease::Linear, &[(0.0, 0.0), (1.0, 1.0)], &[(0.0, [1.0; 3])]).unwrap();
    let mut list = vec![];
    for sigma in [1.0, 0.1] {
        for distance in [0.0, 128.0, 256.0, 320.0, 512.0, 640.0, 1280.0] {
            let medium = Medium { density_scale: sigma, albedo: 0.9, ..Medium::new(ramp.clone()) };
            let mut scene = Scene::with_volume(volume.clone(), medium);
            scene.environment = Environment::uniform(1.0);
            let eye = DVec3::Z * (distance * 1e-3 + 1e-7);
            list.push(Workload {
                name: format!("W1 sigma {sigma} d {distance}"),
                scene,
                camera: PerspectiveCamera::look_at(eye, eye - DVec3::Z, DVec3::Y, 60f64.to_radians()),
                size: [1000, 1000],
                background: true,
                environment_sampling: EnvironmentSampling::Auto,
                cell_size: None,
            });
        }
    }
    list
}

/// A transfer function of lines `r, g, b, a` over HU -1000 to 3000.
fn table(path: &Path) -> TransferFunction {
    let text = std::fs::read_to_string(path).expect("a transfer function");
    let rows: Vec<[f64; 4]> = text
        .lines()
        .map(|line| {
            let numbers: Vec<f64> = line.split(',').map(|n| n.trim().parse().expect("a number")).collect();
            [numbers[0], numbers[1], numbers[2], numbers[3]]
        })
        .collect();
    let hu = |i: usize| -1000.0 + 4000.0 * i as f64 / (rows.len() - 1) as f64;
    let opacity: Vec<_> = rows.iter().enumerate().map(|(i, r)| (hu(i), r[3])).collect();
    let color: Vec<_> = rows.iter().enumerate().map(|(i, r)| (hu(i), [r[0], r[1], r[2]])).collect();
    TransferFunction::from_points(Ease::Linear, &opacity, &color).unwrap()
}

/// W2: a thorax of 512 x 512 x 400 voxels; one millimetre a voxel.
fn thorax(folder: &Path) -> Vec<Workload> {
    let bytes = std::fs::read(folder.join("ct.i16")).expect("ct.i16");
    let voxels: Vec<u16> =
        bytes.chunks_exact(2).map(|b| (i16::from_le_bytes([b[0], b[1]]) as u16) ^ 0x8000).collect();
    let dims = [512, 512, 400];
    let volume =
        Volume::new(dims, Voxels::U16(voxels), [1.0, -32768.0], DAffine3::IDENTITY, Modality::Ct).unwrap();
    let volume = Arc::new(volume);
    let functions = [("tf", table(&folder.join("tf.txt"))), ("bone", table(&folder.join("tf_bone.txt")))];
    let eye = DVec3::new(0.35, 0.2, 1.42) * 0.512;
    let camera =
        |zoom: f64| PerspectiveCamera::look_at(eye * zoom, DVec3::ZERO, DVec3::Y, 40f64.to_radians());
    let workload = |name: String, function: &TransferFunction, bounces: u32| {
        let medium = Medium { albedo: 0.9, max_bounces: bounces, ..Medium::new(function.clone()) };
        let mut scene = Scene::with_volume(volume.clone(), medium);
        scene.environment = Environment::uniform(1.0);
        Workload {
            name,
            scene,
            camera: camera(1.0),
            size: [1920, 1080],
            background: false,
            environment_sampling: EnvironmentSampling::Auto,
            cell_size: None,
        }
    };
    let mut list = vec![];
    for (name, function) in &functions {
        for bounces in [1, 4, 16, 100] {
            list.push(workload(format!("W2 {name} white {bounces}b"), function, bounces));
        }
    }
    let tf = &functions[0].1;
    let sky = EnvironmentMap::from_fn(1024, 512, |d| {
        let sun = if d.dot(DVec3::new(0.4, 0.7, 0.6).normalize()) > 0.9995 { 2000.0 } else { 0.0 };
        [0.3 + sun, 0.4 + sun, 0.3 + 0.4 * d.y.max(0.0) + sun]
    });
    let mut hdr = workload("W2 tf sky 100b".into(), tf, 100);
    hdr.scene.environment.source = EnvironmentSource::Map(Arc::new(sky));
    list.push(hdr);
    list.push(Workload {
        environment_sampling: EnvironmentSampling::Always,
        ..workload("W2 tf white 100b nee".into(), tf, 100)
    });
    list.push(Workload { camera: camera(0.45), ..workload("W2 tf white 100b close-up".into(), tf, 100) });
    // Without interpolation it does not matter whether values or their colours are interpolated, as peers do that bake
    // the transfer function into grids: the means are comparable to the last digit.
    let mut nearest = workload("W2 tf white 100b nearest".into(), tf, 100);
    nearest.scene.volumes[0].medium.filter = Filter::Nearest;
    list.push(nearest);
    for cell_size in [4, 16] {
        let name = format!("W2 tf white 100b cells of {cell_size}");
        list.push(Workload { cell_size: Some(cell_size), ..workload(name, tf, 100) });
    }
    list
}
