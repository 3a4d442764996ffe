//! What a frame pays for scans that come and go: `cargo bench -p lumivox-wgpu --bench arrivals [SIZE] [WIDTH HEIGHT]`.
//!
//! A live view goes on, one quarter of a sample for each pixel of a still camera, while scans of SIZE voxels a side
//! (512) are added, hidden, shown, replaced and lit anew. Every line is what happened: the frames until the change is
//! whole, the time until then, the longest frame and the median of those before the change, waited for on the CPU; and
//! the most memory that the GPU gave at once, beside what the voxels of all scans shown take. In MB.

use std::sync::Arc;
use std::time::Instant;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Environment, EnvironmentMap, EnvironmentSource, Modality, Preset, Scene, Volume, VolumeInstance, Voxels,
    framing,
};
use lumivox_renderer::pacing::UploadPacer;
use lumivox_renderer::{
    HostFrame, LiveSettings, LiveView, Recording, ResourceId, SceneCache, VoxelStore, prepare_volume,
};
use lumivox_wgpu::{Gpu, wgpu};

/// A ball of bone in flesh, with a little noise.
fn scan(size: usize, seed: usize) -> Arc<Volume> {
    let half = size as f64 / 2.0;
    let values = (0..size * size * size).map(|i| {
        let at = [i % size, i / size % size, i / (size * size)].map(|n| (n as f64 + 0.5) / half - 1.0);
        let away = at.iter().map(|x| x * x).sum::<f64>().sqrt();
        let tissue = if away < 0.4 {
            1800
        } else if away < 0.9 {
            1060
        } else {
            0
        };
        tissue + (i * 7919 + seed * 104_729) % 60
    });
    let place = DAffine3::from_scale(DVec3::splat(200.0 / size as f64));
    let voxels = Voxels::U16(values.map(|value| value as u16).collect());
    Arc::new(Volume::new([size; 3], voxels, [1.0, -1000.0], place, Modality::Ct).expect("it is valid"))
}

fn sky(brightness: f32) -> Environment {
    let texels = (0..512 * 256).map(|i| [brightness * (i % 512) as f32 / 512.0, 0.5, 0.5]).collect();
    let map = EnvironmentMap::new(512, 256, texels).expect("it is valid");
    Environment { source: EnvironmentSource::Map(Arc::new(map)), ..Environment::uniform(1.0) }
}

struct Bench {
    gpu: Gpu,
    store: VoxelStore,
    cache: SceneCache,
    live: LiveView,
    pacer: UploadPacer,
    settings: LiveSettings,
    host: HostFrame,
    peak: u64,
    frame: usize,
}

impl Bench {
    fn frame(&mut self, scene: &Scene) -> f64 {
        let begin = Instant::now();
        let mut recording = Recording::new();
        let granted = self.pacer.budget(16.0);
        let mut budget = granted;
        self.cache.update_within(scene, &mut budget, &mut recording).expect("it fits");
        self.gpu.executor.execute(&recording).expect("a device");
        self.pacer.measured(granted - budget, granted, begin.elapsed().as_secs_f64() * 1e3);
        self.look();
        let mut recording = Recording::new();
        let aspect = f64::from(self.settings.size[0]) / f64::from(self.settings.size[1]);
        let mut camera = framing::frame(scene, 0.4, 0.1, 0.5, aspect).camera().with_aspect(aspect);
        // Each frame is a new image, as dear as any.
        self.frame += 1;
        camera.world_from_camera.translation.x += self.frame as f64 * 1e-6;
        let pixels = u64::from(self.settings.size[0]) * u64::from(self.settings.size[1]);
        self.live
            .record_frame(&self.cache, &camera, &self.settings, &self.host, pixels / 4, &mut recording)
            .expect("it is valid");
        self.gpu.executor.execute(&recording).and_then(|_| self.gpu.executor.wait()).expect("a device");
        begin.elapsed().as_secs_f64() * 1e3
    }

    fn look(&mut self) {
        let report = self.gpu.executor.device().generate_allocator_report();
        self.peak = self.peak.max(report.map_or(0, |report| report.total_allocated_bytes));
    }

    /// `held` is let go with the scene before.
    fn change<T>(&mut self, what: &str, before: Scene, held: T, after: &Scene) {
        // As a host would: elsewhere, before the frame that wants it.
        let begin = Instant::now();
        if let Some(preparation) = self.cache.preparation(after) {
            let maker = self.gpu.executor.texture_maker();
            preparation.run_with(|order| maker.make(order));
        }
        let prepared = begin.elapsed().as_secs_f64() * 1e3;
        let mut usual: Vec<f64> = (0..30).map(|_| self.frame(&before)).collect();
        drop((before, held));
        usual.sort_by(f64::total_cmp);
        self.peak = 0;
        if std::env::var_os("STEPS").is_some() {
            let mut recording = Recording::new();
            let mut budget = self.pacer.budget(16.0);
            self.cache.update_within(after, &mut budget, &mut recording).expect("it fits");
            for step in recording.steps {
                let begin = Instant::now();
                let what = format!("{step:?}");
                let recording = Recording { steps: vec![step] };
                self.gpu
                    .executor
                    .execute(&recording)
                    .and_then(|_| self.gpu.executor.wait())
                    .expect("a device");
                println!("{:.2} ms {}", begin.elapsed().as_secs_f64() * 1e3, &what[..what.len().min(100)]);
            }
        }
        let begin = Instant::now();
        let (mut frames, mut longest, mut first, mut whole) = (0, 0.0f64, 0.0, 0.0);
        loop {
            let took = self.frame(after);
            longest = longest.max(took);
            frames += 1;
            if frames == 1 {
                first = took;
            }
            if whole == 0.0 && self.cache.is_settled() {
                whole = begin.elapsed().as_secs_f64() * 1e3;
            }
            if whole > 0.0 && frames >= 30 {
                break;
            }
        }
        let voxels: usize = after.volumes.iter().map(|v| 2 * v.volume.voxel_count()).sum();
        println!(
            "{what:<22} {prepared:>9.0} {whole:>9.0} {first:>9.2} {longest:>9.2} {:>9.2} {:>9.0} {:>9.0}",
            usual[15],
            self.peak as f64 / 1e6,
            voxels as f64 / 1e6
        );
    }
}

fn main() {
    let sizes: Vec<u32> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let size = sizes.first().copied().unwrap_or(512) as usize;
    let [width, height] = sizes.get(1..3).map_or([1920, 1080], |s| [s[0], s[1]]);
    let gpu = Gpu::open(std::env::var("LUMIVOX_GPU").ok().as_deref()).expect("a GPU or software Vulkan");
    println!("{} ({}), {size}^3, {width} x {height}", gpu.description.name, gpu.description.driver);
    println!(
        "{:<22} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "change", "prepared", "whole ms", "first", "longest", "usual ms", "peak MB", "voxels"
    );
    let color = gpu.executor.device().create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let color_target = ResourceId::external();
    let store = VoxelStore::new(gpu.executor.limits());
    let mut cache = SceneCache::new(&store);
    let small = scan(64, 0);
    let base = scene(&[&small], sky(1.0));
    let mut recording = Recording::new();
    cache.update(&base, &mut recording).expect("it fits");
    let settings = LiveSettings::new(width, height);
    let live = LiveView::new(&settings, &cache, &mut recording).expect("it fits");
    let host = HostFrame { depth: None, color_target, depth_target: None, fog: None };
    let mut bench =
        Bench { gpu, store, cache, live, pacer: UploadPacer::new(), settings, host, peak: 0, frame: 0 };
    bench.gpu.executor.lend_texture(color_target, &color);
    bench.gpu.executor.execute(&recording).expect("a device");

    let (a, b) = (scan(size, 1), scan(size, 2));
    let begin = Instant::now();
    prepare_volume(&b);
    println!("(a coarse copy is made in {:.0} ms, on other threads)", begin.elapsed().as_secs_f64() * 1e3);
    let with_a = scene(&[&small, &a], sky(1.0));
    // Three frames of each, so that no pipeline is new.
    (0..3).for_each(|_| _ = bench.frame(&with_a));
    (0..3).for_each(|_| _ = bench.frame(&base));
    let fresh = scan(size, 3);
    let with_fresh = scene(&[&small, &fresh], sky(1.0));
    bench.change("add", base.clone(), (), &with_fresh);
    bench.change("hide", with_fresh.clone(), (), &base);
    bench.change("show", base.clone(), (), &with_fresh);
    bench.change("swap the light", with_fresh.clone(), (), &scene(&[&small, &fresh], sky(2.0)));
    // Nobody holds the one that goes.
    let with_b = scene(&[&small, &b], sky(2.0));
    let before = scene(&[&small, &fresh], sky(2.0));
    drop((with_a, a, with_fresh));
    bench.change("replace", before, fresh, &with_b);
    println!("the store holds {:.0} MB at the end", bench.store.bytes() as f64 / 1e6);
    if size >= 512 {
        bench.large([512, 512, 3000]);
        bench.large([1024, 1024, 2000]);
    }
}

impl Bench {
    /// What does not fit into a 3D texture of most devices, and hardly into their memory.
    fn large(&mut self, dims: [usize; 3]) {
        let count = dims.iter().product();
        let voxels = Voxels::U16((0..count).map(|i: usize| (i >> 8) as u16 % 3000).collect());
        let place = DAffine3::from_scale(DVec3::splat(0.2));
        let volume = Volume::new(dims, voxels, [1.0, -1000.0], place, Modality::Ct).expect("it is valid");
        let volume = Arc::new(volume);
        let scene = scene(&[&volume], sky(1.0));
        (self.peak, self.pacer) = (0, UploadPacer::new());
        let mut recording = Recording::new();
        let begin = Instant::now();
        self.cache.update(&scene, &mut recording).expect("it fits");
        self.gpu.executor.execute(&recording).and_then(|_| self.gpu.executor.wait()).expect("a device");
        let took = begin.elapsed().as_secs_f64();
        drop(recording);
        self.look();
        self.frame(&scene);
        let factor = self.store.resolution(&volume).map_or(0, |resolution| resolution.factor);
        println!(
            "{dims:?}: there after {took:.1} s, 1/{factor} of its resolution, {:.0} MB for {:.0} MB of voxels",
            self.peak as f64 / 1e6,
            2e-6 * count as f64
        );
    }
}

fn scene(volumes: &[&Arc<Volume>], environment: Environment) -> Scene {
    let place = |(i, volume): (usize, &&Arc<Volume>)| {
        let mut instance = VolumeInstance::centered((*volume).clone(), Preset::CtBone.medium(volume));
        instance.world_from_patient =
            DAffine3::from_translation(DVec3::X * (0.25 * i as f64)) * instance.world_from_patient;
        instance
    };
    Scene { volumes: volumes.iter().enumerate().map(place).collect(), environment, ..Scene::default() }
}
