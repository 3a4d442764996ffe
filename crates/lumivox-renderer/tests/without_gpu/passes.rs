//! The passes of live views' frames: none uses an image that holds nothing, or one that it does not tell of.

use std::collections::HashSet;
use std::sync::Arc;

use lumivox_core::glam::DVec3;
use lumivox_core::{Falloff, Lamp, Light, LightKind, Scene, Volume};
use lumivox_renderer::live::passes::{Access, FramePass, Use};
use lumivox_renderer::live::{Grain, LiveFrame, LiveImage};
use lumivox_renderer::recording::BindingKind;
use lumivox_renderer::{
    FilmCount, HostDepth, HostFrame, LiveSettings, LiveView, LoopTurns, Recording, ResourceId, SceneCache,
    Step, VoxelStore,
};

use crate::scenes::*;

/// What is known of a view's images after the passes so far.
#[derive(Default)]
struct Images {
    /// Those that hold something, by their places.
    held: HashSet<(ResourceId, u64)>,
    buffers: HashSet<ResourceId>,
    /// Passes by name.
    passes: HashSet<&'static str>,
    names: HashSet<LiveImage>,
}

impl Images {
    fn check(&mut self, frame: &LiveFrame<'_>) {
        let mut used = HashSet::new();
        for pass in &frame.passes {
            self.passes.insert(pass.name());
            for used_by_pass in pass.uses() {
                let image = used_by_pass.image;
                let place = (image.buffer, image.offset);
                if used_by_pass.access == Access::Make {
                    assert!(!used.contains(&place), "{} makes what was used before: {image:?}", pass.name());
                    self.held.insert(place);
                }
                assert!(self.held.contains(&place), "{} uses what holds nothing: {image:?}", pass.name());
                used.insert(place);
                self.buffers.insert(image.buffer);
                self.names.insert(image.name);
            }
            self.check_steps(pass.as_ref());
        }
    }

    /// What its steps bind is what it tells of.
    fn check_steps(&self, pass: &dyn FramePass) {
        let mut recording = Recording::new();
        pass.record(&mut recording);
        let (mut read, mut written) = (HashSet::new(), HashSet::new());
        for step in &recording.steps {
            match step {
                Step::Dispatch { kernel, resources, .. } | Step::Draw { kernel, resources, .. } => {
                    let named = |kind: &&BindingKind| {
                        !matches!(kind, BindingKind::Uniform | BindingKind::LinearSampler)
                    };
                    let kinds: Vec<_> = kernel.bindings().iter().filter(named).collect();
                    assert_eq!(kinds.len(), resources.len());
                    for (kind, id) in kinds.into_iter().zip(resources) {
                        let side =
                            if *kind == BindingKind::StorageReadWrite { &mut written } else { &mut read };
                        side.insert(*id);
                    }
                }
                Step::ClearBuffer { id } | Step::WriteBuffer { id, .. } => _ = written.insert(*id),
                Step::ReadBuffer { id, .. } => _ = read.insert(*id),
                other => panic!("{} makes or frees something: {other:?}", pass.name()),
            }
        }
        let uses = pass.uses();
        let told = |writes: bool| -> HashSet<ResourceId> {
            let uses = uses.iter().filter(|used| !writes || used.access != Access::Read);
            uses.map(|used| used.image.buffer).collect()
        };
        let images = |ids: &HashSet<ResourceId>| -> HashSet<ResourceId> { ids & &self.buffers };
        assert_eq!(told(true), images(&written), "the images that {:?} writes", pass.name());
        assert_eq!(told(false), images(&(&read | &written)), "the images that {:?} uses", pass.name());
    }
}

/// Two lamps, of which the first shines so many times as bright.
fn lit(volume: &Arc<Volume>, brightness: f64) -> Scene {
    let lamp = |x: f64, intensity: f64| Light {
        kind: LightKind::Point(Lamp {
            position: DVec3::new(x, 0.1, 0.3),
            radius: 0.0,
            intensity: [intensity; 3],
            falloff: Falloff::Power { range: f64::INFINITY, decay: 2.0 },
        }),
        layers: u32::MAX,
    };
    Scene { lights: vec![lamp(0.2, brightness), lamp(-0.2, 1.0)], ..scene(std::slice::from_ref(volume)) }
}

/// A view, and a host that changes one thing or another in most frames.
struct Restless {
    cache: SceneCache,
    volume: Arc<Volume>,
    live: LiveView,
    settings: LiveSettings,
    host: HostFrame,
    brightness: f64,
    x: f64,
    random: u32,
    alive: HashSet<ResourceId>,
    /// Bytes of read-backs that have not come.
    awaited: Vec<u64>,
}

impl Restless {
    fn new(loop_turns: Option<LoopTurns>, seed: u32) -> Self {
        let volume = volume(8);
        let mut cache = SceneCache::new(&VoxelStore::new(LIMITS.with(|it| it.loop_turns = loop_turns)));
        cache.follow_light();
        let mut recording = Recording::new();
        cache.update(&lit(&volume, 1.0), &mut recording).unwrap();
        let settings = LiveSettings::new(96, 64).with(|it| {
            it.target_samples = 40;
            it.denoise = seed.is_multiple_of(2);
            it.target_noise = if seed.is_multiple_of(3) { 0.1 } else { 0.0 };
        });
        let live = LiveView::new(&settings, &cache, &mut recording).unwrap();
        let color_target = ResourceId::external();
        let mut alive = HashSet::from([color_target]);
        replay(&recording, &mut alive);
        let host = HostFrame::new(color_target);
        let (brightness, x, random) = (1.0, 0.0, seed);
        Self { cache, volume, live, settings, host, brightness, x, random, alive, awaited: vec![] }
    }

    fn below(&mut self, end: u32) -> u32 {
        self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.random >> 8) % end
    }

    fn change(&mut self) {
        match self.below(40) {
            0 | 1 => self.x += 0.01,
            2 => self.settings.denoise ^= true,
            3 => self.settings.resolution_scale = [0.5, 1.0][self.below(2) as usize],
            4 => self.settings.size = [[64, 48], [96, 64]][self.below(2) as usize],
            5 | 6 => {
                let texture = ResourceId::external();
                self.alive.insert(texture);
                self.host.depth =
                    (self.below(3) > 0).then_some(HostDepth::new(texture, [0.0, 0.1, 1.0, 0.0], 0.0));
            }
            7 => {
                let target = ResourceId::external();
                self.alive.insert(target);
                self.host.depth_target = (self.below(2) > 0).then_some(target);
            }
            8..=12 => self.brightness *= [3.0, 1.05, 1.05, 1.05, 1.05][self.below(5) as usize],
            13 => self.settings.target_samples = 20 + self.below(40),
            14 => self.settings.guides ^= true,
            15 => self.settings.kept_light ^= true,
            _ => {}
        }
    }

    fn frame(&mut self, images: &mut Images) {
        let mut recording = Recording::new();
        self.cache.update(&lit(&self.volume, self.brightness), &mut recording).unwrap();
        let mut camera = camera().with_aspect(1.0);
        camera.world_from_camera.translation.x = self.x;
        let budget = [300, 700, 2000, 6144, 20000, 1 << 20][self.below(6) as usize];
        let frame = self
            .live
            .plan_frame(&self.cache, &camera, &self.settings, &self.host, budget, &mut recording)
            .unwrap();
        images.check(&frame);
        frame.record(&mut recording);
        replay(&recording, &mut self.alive);
        for step in &recording.steps {
            if let Step::ReadBuffer { range, .. } = step {
                self.awaited.push(range.end);
            }
        }
        self.feed_back();
    }

    /// Some of what is awaited comes, in its order, or is lost.
    fn feed_back(&mut self) {
        while self.awaited.len() > self.below(4) as usize {
            let bytes = self.awaited.remove(0);
            let short = self.below(3) / 2 * self.below(50);
            let starved = self.below(8) / 7 * self.below(9);
            let count = FilmCount { samples: 0, short, aside: short / 2, starved, stuck: 0 };
            match bytes {
                _ if self.below(50) == 0 => self.live.feedback(&[]),
                4 => self.live.feedback(&short.to_le_bytes()),
                20 => self.live.feedback(bytemuck::bytes_of(&count)),
                _ => {
                    let film: Vec<f32> = [0.5, 1.0, 16.0, 3.0].repeat(bytes as usize / 16);
                    self.live.feedback(bytemuck::cast_slice(&film));
                }
            }
        }
    }
}

#[test]
fn passes_use_images_that_hold_something_and_tell_of_all() {
    let mut images = Images::default();
    for loop_turns in [None, Some(LoopTurns { shared: 100, alone: 64_000 })] {
        for seed in 0..12 {
            let mut host = Restless::new(loop_turns, seed);
            for _ in 0..200 {
                host.change();
                host.frame(&mut images);
            }
        }
    }
    // All that there are occurred.
    let mut passes: Vec<_> = images.passes.into_iter().collect();
    passes.sort_unstable();
    let all = [
        "clear",
        "count",
        "denoise",
        "draw",
        "fade",
        "host depth",
        "light cells",
        "light picture",
        "picture",
        "read",
        "trace",
    ];
    assert_eq!(passes, all);
    let films = [Grain::Fine, Grain::Coarse, Grain::Finer, Grain::Points].map(LiveImage::Film);
    for name in films.into_iter().chain([LiveImage::Albedo, LiveImage::Normal, LiveImage::KeptLight]) {
        assert!(images.names.contains(&name), "{name:?}");
    }
}

/// What a host can bind is there as long as it is promised.
#[test]
fn images_are_there_while_they_hold_something() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    cache.update(&scene(&[volume(8)]), &mut Recording::new()).unwrap();
    let settings = LiveSettings::new(128, 96).with(|it| {
        it.kept_light = false;
        it.target_samples = 64;
        it.resolution_scale = 0.5;
    });
    let mut live = LiveView::new(&settings, &cache, &mut Recording::new()).unwrap();
    let host = HostFrame::new(ResourceId::external());
    let frame = |live: &mut LiveView, denoise, budget| {
        let settings = settings.with(|it| it.denoise = denoise);
        let camera = camera().with_aspect(1.0);
        live.record_frame(&cache, &camera, &settings, &host, budget, &mut Recording::new()).unwrap()
    };
    use Grain::{Coarse, Fine};
    use LiveImage::{Color, Denoised, Depth, Film, RayLimits};
    // A coarse image, in answer.
    frame(&mut live, false, 400);
    let size = |live: &LiveView, name| live.image(name).map(|image| image.size);
    assert_eq!([Film(Fine), RayLimits(Fine)].map(|name| size(&live, name)), [Some([64, 48]); 2]);
    let coarse = [Film(Coarse), RayLimits(Coarse), Denoised(Coarse)];
    assert_eq!(coarse.map(|name| size(&live, name)), [Some([16, 12]); 3]);
    assert_eq!([Color, Depth].map(|name| size(&live, name)), [Some([128, 96]); 2]);
    assert_eq!(size(&live, Denoised(Fine)), None);
    let mut recording = Recording::new();
    assert_eq!(live.record_read(Denoised(Fine), &mut recording), None);
    assert!(recording.is_empty());
    let limits = live.record_read(RayLimits(Coarse), &mut recording).unwrap();
    assert_eq!(limits.bytes(), 2 * 16 * 192..2 * 16 * 192 + 4 * 192);
    assert!(matches!(&recording.steps[..], [Step::ReadBuffer { range, .. }] if *range == limits.bytes()));
    // The fine one alone, and denoised.
    while !frame(&mut live, true, 1 << 20).converged {}
    assert_eq!(coarse.map(|name| size(&live, name)), [None; 3]);
    assert_eq!(size(&live, Denoised(Fine)), Some([64, 48]));
    frame(&mut live, false, 1 << 20);
    assert_eq!(size(&live, Denoised(Fine)), None);
}

/// When a host wants guides, or wants them no more, the image starts over once; nothing of what was is left.
#[test]
fn guides_come_and_go_with_one_start() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut recording = Recording::new();
    cache.update(&scene(&[volume(8)]), &mut recording).unwrap();
    let color_target = ResourceId::external();
    let host = HostFrame::new(color_target);
    let mut settings = LiveSettings::new(63, 37).with(|it| {
        it.kept_light = false;
        it.target_samples = 8;
        it.denoise = true;
    });
    let mut live = LiveView::new(&settings, &cache, &mut recording).unwrap();
    let mut alive = HashSet::from([color_target]);
    replay(&recording, &mut alive);
    let mut converge = |live: &mut LiveView, settings: &LiveSettings, budget| {
        let mut cleared = 0;
        loop {
            let mut recording = Recording::new();
            let camera = camera().with_aspect(1.0);
            let frame = live.plan_frame(&cache, &camera, settings, &host, budget, &mut recording).unwrap();
            let fine =
                |used: Use| used.image.name == LiveImage::Film(Grain::Fine) && used.access == Access::Make;
            cleared += frame.passes.iter().filter(|pass| pass.uses().into_iter().any(fine)).count();
            let status = frame.status;
            frame.record(&mut recording);
            replay(&recording, &mut alive);
            if status.converged {
                return (cleared, alive.clone());
            }
        }
    };
    let (_, before) = converge(&mut live, &settings, 1 << 20);
    assert_eq!(live.image(LiveImage::Albedo), None);
    for budget in [300, 1 << 20] {
        settings.guides = true;
        let (cleared, _) = converge(&mut live, &settings, budget);
        assert_eq!(cleared, 1);
        let guides = [LiveImage::Albedo, LiveImage::Normal].map(|name| live.image(name).unwrap());
        // An odd number of pixels: limits fill their last entry but in part.
        let pixels = 63 * 37;
        assert_eq!(guides[0].bytes(), 32 * pixels + 4 * (pixels + 1)..48 * pixels + 4 * (pixels + 1));
        assert_eq!(guides[1].offset, guides[0].bytes().end);
        let film = live.image(LiveImage::Film(Grain::Fine)).unwrap();
        assert_eq!((film.planes, film.buffer), (2, guides[0].buffer));
        settings.guides = false;
        let (cleared, after) = converge(&mut live, &settings, 1 << 20);
        assert_eq!((cleared, after.len()), (1, before.len()));
        assert_eq!(live.image(LiveImage::Normal), None);
    }
}
