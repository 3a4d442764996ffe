//! What a frame pays for scans that come and go: `cargo bench -p lumivox-wgpu --bench arrivals [SIZE] [WIDTH HEIGHT]`.
//!
//! A live view of a moving camera goes on, BUDGET ms (4) of the GPU's time for tracing in each frame, while scans of SIZE
//! voxels a side (512) are added, hidden, shown, replaced and lit anew, one of them beside a small one; `FRAMES=1` prints
//! every frame. Every line is what happened: the time until the change was whole, the first frame of it, the longest
//! until it was whole (or of 30), the median of those before and the longest of them; and the most memory that the GPU
//! gave at once, beside what the voxels of all scans shown take. In MB. A frame is the time from the end of the one
//! before the last to that of the last: while the GPU is at one, the next is recorded, as engines do.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Camera, Environment, EnvironmentMap, EnvironmentSource, Modality, Preset, Scene, Volume, VolumeInstance,
    Voxels, framing,
};
use lumivox_renderer::stage::{Lent, Recorded, Stage, ViewFrame, WorldState};
use lumivox_renderer::{HostFrame, LiveSettings};
use lumivox_wgpu::{Gpu, GpuTime, wgpu};

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

const WORLD: u8 = 0;
const VIEW: u8 = 0;

/// Of frames before those that are looked at: making scans takes seconds, in which a GPU slows its clocks down.
const WAKING: Duration = Duration::from_secs(2);

/// Frames that are looked at before a change, and at least after it.
const FRAMES: usize = 30;

struct Bench {
    gpu: Gpu,
    stage: Stage<u8, u8>,
    color: wgpu::Texture,
    size: [u32; 2],
    camera: Camera,
    /// Milliseconds of the GPU's time that a frame has for tracing.
    budget: f64,
    /// Of the scene: another one with every change.
    version: u64,
    frame: u64,
    /// What the GPU is at: whether each frame is done.
    under_way: VecDeque<Arc<AtomicBool>>,
    times: Vec<(u64, GpuTime)>,
    last: Instant,
    peak: u64,
}

impl Bench {
    /// Draws a frame, one after another as an engine does, and waits for the one before: milliseconds since that was done.
    fn frame(&mut self, scene: &Scene) -> f64 {
        self.frame += 1;
        self.stage.begin_frame(self.frame);
        let Self { stage, times, .. } = self;
        times.retain_mut(|(ticket, time)| match time.poll() {
            Some(milliseconds) => {
                stage.measured(*ticket, milliseconds);
                false
            }
            None => true,
        });
        let updated = self.stage.update(WORLD, scene, self.version, false, &self.gpu.executor);
        if let Some(recorded) = updated.expect("it fits") {
            self.replay(recorded);
        }
        let mut camera = self.camera;
        // Each frame is a new image, as dear as any.
        camera.world_from_camera.translation.x += self.frame as f64 * 1e-6;
        if let Some(shown) = self.stage.shown(VIEW, WORLD, |_| true) {
            let [width, height] = self.size;
            let frame = |lent: Lent| {
                ViewFrame::new(
                    camera,
                    LiveSettings::new(width, height).with(|it| it.kept_light = false),
                    HostFrame::new(lent.color),
                    self.budget,
                )
            };
            let seen = self.stage.record_view(VIEW, shown, frame).expect("it is valid");
            self.gpu.executor.lend_texture(seen.lent.color, &self.color);
            self.replay(seen.recorded);
        }
        if let Some(swept) = self.stage.sweep(|_| true, |_| true) {
            self.replay(swept);
        }
        self.look();
        let done = Arc::new(AtomicBool::new(false));
        self.under_way.push_back(done.clone());
        self.gpu.executor.queue().on_submitted_work_done(move || done.store(true, Ordering::Release));
        if self.under_way.len() > 1 {
            self.wait();
        }
        let took = self.last.elapsed().as_secs_f64() * 1e3;
        self.last = Instant::now();
        took
    }

    fn replay(&mut self, recorded: Recorded<u8, u8>) {
        let ticket = recorded.ticket();
        let submission = self.gpu.executor.submit(&recorded.recording).expect("a device");
        if ticket > 0 {
            self.times.extend(submission.time.map(|time| (ticket, time)));
        }
        self.stage.executed(recorded, Ok(())).expect("it fits");
    }

    /// Until the frame before is done. Asks again and again: who lets the driver wait waits for it, too, while it makes a
    /// large texture.
    fn wait(&mut self) {
        let Some(done) = self.under_way.pop_front() else { return };
        while !done.load(Ordering::Acquire) {
            self.gpu.executor.device().poll(wgpu::PollType::Poll).expect("a device");
            std::thread::yield_now();
        }
    }

    fn look(&mut self) {
        let report = self.gpu.executor.device().generate_allocator_report();
        self.peak = self.peak.max(report.map_or(0, |report| report.total_allocated_bytes));
    }

    fn is_whole(&self) -> bool {
        self.stage.holds(WORLD, self.version) && self.stage.world_state(WORLD) == WorldState::Done
    }

    /// `held` is let go with the scene before.
    fn change<T>(&mut self, what: &str, before: Scene, held: T, after: &Scene) {
        let woken = Instant::now();
        while woken.elapsed() < WAKING {
            self.frame(&before);
        }
        let mut usual: Vec<f64> = (0..FRAMES).map(|_| self.frame(&before)).collect();
        drop((before, held));
        usual.sort_by(f64::total_cmp);
        self.peak = 0;
        self.version += 1;
        let begin = Instant::now();
        let (mut frames, mut whole) = (vec![], 0.0);
        while whole == 0.0 || frames.len() < FRAMES {
            frames.push(self.frame(after));
            if whole == 0.0 && self.is_whole() {
                whole = begin.elapsed().as_secs_f64() * 1e3;
            }
        }
        if std::env::var_os("FRAMES").is_some() {
            println!("{frames:.2?}");
        }
        let voxels: usize = after.volumes.iter().map(|v| 2 * v.volume.voxel_count()).sum();
        println!(
            "{what:<22} {whole:>9.0} {:>9.2} {:>9.2} {:>9.2} {:>9.2} {:>9.0} {:>9.0}",
            frames[0],
            frames.iter().copied().fold(0.0, f64::max),
            usual[FRAMES / 2],
            usual[FRAMES - 1],
            self.peak as f64 / 1e6,
            voxels as f64 / 1e6
        );
    }
}

fn main() {
    let sizes: Vec<u32> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let size = sizes.first().copied().unwrap_or(512) as usize;
    let [width, height] = sizes.get(1..3).map_or([1920, 1080], |s| [s[0], s[1]]);
    let budget = std::env::var("BUDGET").map_or(4.0, |budget| budget.parse().expect("milliseconds"));
    let gpu = Gpu::open(std::env::var("LUMIVOX_GPU").ok().as_deref()).expect("a GPU or software Vulkan");
    println!(
        "{} ({}), {size}^3, {width} x {height}, {budget} ms",
        gpu.description.name, gpu.description.driver
    );
    println!(
        "{:<22} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "change", "whole ms", "first", "longest", "usual ms", "at most", "peak MB", "voxels"
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
    let small = scan(64, 0);
    let base = scene(&[&small], sky(1.0));
    let stage = Stage::new(gpu.executor.limits());
    // Of both places.
    let both = scene(&[&small, &small], sky(1.0));
    let aspect = f64::from(width) / f64::from(height);
    let mut bench = Bench {
        gpu,
        stage,
        color,
        size: [width, height],
        camera: framing::frame(&both, 0.4, 0.1, 0.5, aspect).camera().with_aspect(aspect),
        budget,
        version: 1,
        frame: 0,
        under_way: VecDeque::new(),
        times: vec![],
        last: Instant::now(),
        peak: 0,
    };

    let (a, b) = (scan(size, 1), scan(size, 2));
    // Once, so that no pipeline is new.
    let with_a = scene(&[&small, &a], sky(1.0));
    for scene in [&base, &with_a, &base] {
        bench.version += 1;
        while !bench.is_whole() {
            bench.frame(scene);
        }
        (0..FRAMES).for_each(|_| _ = bench.frame(scene));
    }
    drop((with_a, a));
    let fresh = scan(size, 3);
    let with_fresh = scene(&[&small, &fresh], sky(1.0));
    bench.change("add", base.clone(), (), &with_fresh);
    bench.change("hide", with_fresh.clone(), (), &base);
    bench.change("show", base.clone(), (), &with_fresh);
    bench.change("swap the light", with_fresh.clone(), (), &scene(&[&small, &fresh], sky(2.0)));
    // Nobody holds the one that goes.
    let with_b = scene(&[&small, &b], sky(2.0));
    let before = scene(&[&small, &fresh], sky(2.0));
    drop(with_fresh);
    bench.change("replace", before, fresh, &with_b);
    println!("the store holds {:.0} MB at the end", bench.stage.store().bytes() as f64 / 1e6);
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
        self.peak = 0;
        self.version += 1;
        let begin = Instant::now();
        let updated = self.stage.update(WORLD, &scene, self.version, true, &self.gpu.executor);
        if let Some(recorded) = updated.expect("it fits") {
            self.replay(recorded);
        }
        self.gpu.executor.wait().expect("a device");
        let took = begin.elapsed().as_secs_f64();
        self.look();
        self.frame(&scene);
        let factor = self.stage.store().resolution(&volume).map_or(0, |resolution| resolution.factor);
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
