//! What a live view records while light changes, and once it rests.

use std::collections::HashSet;
use std::sync::{Arc, LazyLock};

use lumivox_core::glam::DVec3;
use lumivox_core::{Falloff, Lamp, Light, LightKind, Scene, Volume};
use lumivox_renderer::{
    HostFrame, LiveSettings, LiveStatus, LiveView, Recording, ResourceId, SceneCache, Step, VoxelStore,
};
use lumivox_shaders::Kernel;

use crate::scenes::*;

const SIZE: u32 = 64;
const AREA: u64 = (SIZE * SIZE) as u64;
const TARGET: u32 = 64;

/// Frames without a change after which light rests.
const REST: usize = 30;

/// The same in all scenes.
static VOLUME: LazyLock<Arc<Volume>> = LazyLock::new(|| volume(8));

/// Two lamps, of which the first shines so many times as bright.
fn lit(brightness: f64) -> Scene {
    let lamp = |x: f64, intensity: f64| Light {
        kind: LightKind::Point(Lamp {
            position: DVec3::new(x, 0.1, 0.3),
            radius: 0.0,
            intensity: [intensity; 3],
            falloff: Falloff::Power { range: f64::INFINITY, decay: 2.0 },
        }),
        layers: u32::MAX,
    };
    Scene { lights: vec![lamp(0.2, brightness), lamp(-0.2, 1.0)], ..scene(std::slice::from_ref(&*VOLUME)) }
}

struct Host {
    cache: SceneCache,
    live: LiveView,
    settings: LiveSettings,
    color: ResourceId,
    alive: HashSet<ResourceId>,
}

impl Host {
    fn new() -> Self {
        Self::with(false)
    }

    /// With light that is kept, or without.
    fn with(kept_light: bool) -> Self {
        let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
        cache.follow_light();
        let mut recording = Recording::new();
        cache.update(&lit(1.0), &mut recording).unwrap();
        let settings = LiveSettings::new(SIZE, SIZE).with(|it| {
            it.target_samples = TARGET;
            it.kept_light = kept_light;
        });
        let live = LiveView::new(&settings, &cache, &mut recording).unwrap();
        let color = ResourceId::external();
        let mut alive = HashSet::from([color]);
        replay(&recording, &mut alive);
        Self { cache, live, settings, color, alive }
    }

    /// A frame; which films it empties, whether it fades one, and how it is then.
    fn frame(&mut self, scene: &Scene, budget: u64) -> (usize, bool, LiveStatus) {
        let mut recording = Recording::new();
        self.cache.update(scene, &mut recording).unwrap();
        let host = HostFrame::new(self.color);
        let before = recording.steps.len();
        let Self { cache, live, settings, .. } = self;
        let camera = camera().with_aspect(1.0);
        let status = live.record_frame(cache, &camera, settings, &host, budget, &mut recording).unwrap();
        replay(&recording, &mut self.alive);
        let steps = &recording.steps[before..];
        let cleared = steps.iter().filter(|step| matches!(step, Step::ClearBuffer { .. })).count();
        let fades = steps.iter().any(|step| matches!(step, Step::Dispatch { kernel: Kernel::FilmFade, .. }));
        (cleared, fades, status)
    }
}

#[test]
fn one_of_several_lamps_may_flicker() {
    let mut host = Host::new();
    let budget = AREA / 2;
    let (cleared, ..) = host.frame(&lit(1.0), budget);
    assert_eq!(cleared, 2, "the first image, coarse and fine");
    for frame in 0..60 {
        let (cleared, fades, status) = host.frame(&lit(1.0 + 0.05 * f64::from(frame % 3)), budget);
        assert_eq!((cleared, fades), (0, frame > 0), "frame {frame}");
        assert!(!status.converged && (frame < 4 || status.samples > 0), "frame {frame}: {status:?}");
    }
    // It rests. What was traced of it stays to be seen until the film of it alone is as good.
    let last = lit(1.1);
    let films = host.alive.len();
    for frame in 1..=REST {
        let (cleared, fades, status) = host.frame(&last, budget);
        assert_eq!((cleared, fades), (usize::from(frame == REST), false), "frame {frame}");
        assert!(!status.converged);
    }
    let mut frames = 0;
    while !host.frame(&last, budget).2.converged {
        frames += 1;
    }
    assert_eq!(
        frames,
        2 * TARGET as usize - 2,
        "of the frames of a fresh image one is past, and one is the last"
    );
    assert!(host.alive.len() <= films, "what was shown before is freed");
    assert_eq!(host.frame(&last, budget).2.pixel_samples, 0);
}

/// What is seen until a new image is as good is of light that is gone as soon as that changes again.
#[test]
fn an_image_that_was_held_goes_when_light_changes_again() {
    let mut host = Host::new();
    let budget = 4 * AREA;
    host.frame(&lit(1.0), budget);
    host.frame(&lit(1.05), budget);
    let films = host.alive.len();
    let last = lit(1.1);
    host.frame(&last, budget);
    while host.frame(&last, budget).0 == 0 {}
    assert!(host.alive.len() > films, "the image before is held");
    host.frame(&lit(1.15), budget);
    assert_eq!(host.alive.len(), films);
}

#[test]
fn images_that_are_done_at_once_do_not_wait_for_light_to_rest() {
    // Nor is any sample of theirs spent on light that is kept.
    for kept_light in [false, true] {
        let mut host = Host::with(kept_light);
        let all = AREA * u64::from(TARGET);
        assert!(host.frame(&lit(1.0), all).2.converged);
        let (cleared, fades, status) = host.frame(&lit(1.05), all);
        assert_eq!((cleared, fades, status.converged), (0, true, false));
        let (cleared, fades, status) = host.frame(&lit(1.05), all);
        assert_eq!((cleared, fades, status.converged), (1, false, true));
    }
}

#[test]
fn other_light_starts_over() {
    let mut host = Host::new();
    host.frame(&lit(1.0), AREA);
    for (other, scene) in [
        ("much brighter", lit(20.0)),
        ("one lamp more", Scene { lights: [lit(20.0).lights, lit(40.0).lights].concat(), ..lit(20.0) }),
        ("none", Scene { lights: vec![], ..lit(2.0) }),
    ] {
        let (cleared, fades, _) = host.frame(&scene, AREA);
        assert!(cleared > 0 && !fades, "{other}");
    }
    // Ambient light is light, too.
    for (ambient, is_little) in [(1.0, false), (1.1, true), (0.2, false)] {
        host.settings.ambient = [ambient; 3];
        let (cleared, fades, _) = host.frame(&Scene { lights: vec![], ..lit(2.0) }, AREA);
        assert_eq!((cleared == 0, fades), (is_little, is_little), "{ambient}");
    }
}
