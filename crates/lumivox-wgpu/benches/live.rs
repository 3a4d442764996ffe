//! What a live view costs in an engine's frame: `cargo bench -p lumivox-wgpu --bench live [WIDTH HEIGHT] [few]`.
//!
//! With `few`, by the kernels that Unity's package brings, which can do more than a scene needs.
//!
//! Every line is the time of a frame, its recording and its submission included, waited for on the CPU; the median of
//! many. The host is a colour and a depth texture without anything in them.

use std::sync::Arc;
use std::time::Instant;

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{CancelToken, Preset, Progress, Scene, VolumeInstance, framing};
use lumivox_phantom::{AnatomyOptions, anatomy};
use lumivox_renderer::{
    HostDepth, HostFrame, LiveSettings, LiveView, Recording, ResourceId, SceneCache, View, ViewSettings,
    VoxelStore,
};
use lumivox_wgpu::{Gpu, wgpu};

const FRAMES: usize = 24;

fn main() {
    let sizes: Vec<u32> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let [width, height] = sizes.first_chunk().copied().unwrap_or([1920, 1080]);
    let mut gpu = Gpu::open(std::env::var("LUMIVOX_GPU").ok().as_deref()).expect("a GPU or software Vulkan");
    println!("{} ({}), {width} x {height}", gpu.description.name, gpu.description.driver);
    println!("{:<44} {:>10}", "frame", "ms");

    let begin = Instant::now();
    let options = AnatomyOptions { size: 192, ..Default::default() };
    let head = Arc::new(anatomy(options, Progress::SILENT, &CancelToken::new()).expect("nobody cancels"));
    let scene = Scene::with_volume(head.clone(), Preset::CtSkin.medium(&head));
    println!(
        "{:<44} {:>10.0}",
        "(phantom head, 192 voxels, ct-skin: made in)",
        begin.elapsed().as_secs_f64() * 1e3
    );
    bench(&mut gpu, "head", &scene, [width, height]);
    bench(&mut gpu, "100 heads", &crowd(), [width, height]);
}

/// A hundred small heads, turned and stretched, in a cube.
fn crowd() -> Scene {
    let options = AnatomyOptions { size: 48, ..Default::default() };
    let head = Arc::new(anatomy(options, Progress::SILENT, &CancelToken::new()).expect("nobody cancels"));
    let medium = Preset::CtSkin.medium(&head);
    let volumes = (0..100u32).map(|i| {
        let mut instance = VolumeInstance::centered(head.clone(), medium.clone());
        let cell = DVec3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)) - DVec3::splat(2.0);
        let turn = DMat3::from_rotation_y(f64::from(i)) * DMat3::from_rotation_x(0.7 * f64::from(i));
        let stretch = DMat3::from_diagonal(DVec3::new(1.0, 1.0 + 0.1 * f64::from(i % 4), 0.8));
        instance.world_from_patient =
            DAffine3 { matrix3: turn * stretch, translation: cell * 0.25 } * instance.world_from_patient;
        instance
    });
    Scene { volumes: volumes.collect(), ..Scene::default() }
}

fn bench(gpu: &mut Gpu, name: &str, scene: &Scene, [width, height]: [u32; 2]) {
    let orbit = framing::frame(scene, 0.4, 0.1, 0.5, f64::from(width) / f64::from(height));
    let camera = orbit.camera();
    // For those who look at it in an engine.
    println!("{name}: from {:.3} at {:.3}", camera.world_from_camera.translation, orbit.target);
    let texture = |format, usage| {
        gpu.executor.device().create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    let target = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let textures = [
        texture(wgpu::TextureFormat::Depth32Float, target | wgpu::TextureUsages::TEXTURE_BINDING),
        texture(wgpu::TextureFormat::Rgba16Float, target),
        texture(wgpu::TextureFormat::Depth32Float, target),
    ];
    let names = [(); 3].map(|()| ResourceId::external());
    names.iter().zip(&textures).for_each(|(id, texture)| gpu.executor.lend_texture(*id, texture));
    let host = HostFrame::new(names[1])
        .with_depth(HostDepth::new(names[0], [0.0, 0.01, 1.0, 0.0], 0.0))
        .with_depth_target(names[2]);
    let pixels = u64::from(width) * u64::from(height);
    let few_kernels = std::env::args().any(|word| word == "few");
    let limits = gpu.executor.limits().with(|it| it.few_kernels = few_kernels);
    let mut cache = SceneCache::new(&VoxelStore::new(limits));
    let mut recording = Recording::new();
    let begin = Instant::now();
    cache.update(scene, &mut recording).expect("it fits");
    gpu.executor.execute(&recording).and_then(|_| gpu.executor.wait()).expect("a device");
    row(&format!("{name}: upload, once"), begin.elapsed().as_secs_f64() * 1e3);

    let mut recording = Recording::new();
    let mut view = View::new(ViewSettings::new(width, height), &cache, &mut recording).expect("it fits");
    let headless = median(
        gpu,
        |_, recording| {
            let target = view.samples() + 1;
            view.record_samples(&cache, &camera, target, u64::MAX, recording);
        },
        recording,
    );
    row(&format!("{name}: a sample without a host"), headless);
    let mut freed = Recording::new();
    view.free(&mut freed);
    gpu.executor.execute(&freed).expect("a device");

    let mut live_bench = |what: &str, denoise: bool, moving: bool, budget: u64, target: u32| {
        let settings = LiveSettings::new(width, height).with(|it| {
            it.denoise = denoise;
            it.kept_light = false;
            it.target_samples = target;
        });
        let mut recording = Recording::new();
        let mut live = LiveView::new(&settings, &cache, &mut recording).expect("it fits");
        let still = camera.with_aspect(f64::from(width) / f64::from(height));
        let ms = median(
            gpu,
            |frame, recording| {
                let mut camera = still;
                if moving {
                    camera.world_from_camera.translation.x += frame as f64 * 1e-4;
                }
                live.record_frame(&cache, &camera, &settings, &host, budget, recording).expect("it is valid");
            },
            recording,
        );
        row(&format!("{name}: {what}"), ms);
        let mut freed = Recording::new();
        live.free(&mut freed);
        gpu.executor.execute(&freed).expect("a device");
    };
    live_bench("a sample a frame, still", false, false, pixels, u32::MAX);
    live_bench("a sample a frame, still, denoised", true, false, pixels, u32::MAX);
    live_bench("two samples a frame, moving", false, true, 2 * pixels, u32::MAX);
    live_bench("a quarter of a sample a frame, moving", false, true, pixels / 4, u32::MAX);
    live_bench("a quarter of a sample, moving, denoised", true, true, pixels / 4, u32::MAX);
    live_bench("converged", false, false, pixels, 1);
    let mut freed = Recording::new();
    cache.free(&mut freed);
    gpu.executor.execute(&freed).expect("a device");
}

fn row(what: &str, ms: f64) {
    println!("{what:<44} {ms:>10.2}");
}

/// Median milliseconds of a frame, after some that warm up.
fn median(gpu: &mut Gpu, mut record: impl FnMut(usize, &mut Recording), first: Recording) -> f64 {
    gpu.executor.execute(&first).expect("a device");
    let mut times: Vec<f64> = (0..FRAMES + 4)
        .map(|frame| {
            let begin = Instant::now();
            let mut recording = Recording::new();
            record(frame, &mut recording);
            // Read-backs are not waited for, as a host would not.
            let _ = gpu.executor.execute(&recording).expect("a device");
            gpu.executor.wait().expect("a device");
            begin.elapsed().as_secs_f64() * 1e3
        })
        .skip(4)
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
