//! Light that is kept in volumes, and the memory that it has.

use std::collections::HashMap;

use lumivox_core::glam::DAffine3;
use lumivox_core::{Camera, Scene};
use lumivox_renderer::{
    DeviceLimits, HostFrame, LiveSettings, LiveStatus, LiveView, Recording, ResourceId, SceneCache, Step,
    VoxelStore,
};

use crate::scenes::{LIMITS, camera, scene, volume};

const SIZE: u32 = 64;
const PIXELS: u64 = (SIZE * SIZE) as u64;

/// A view that moves with every frame.
struct Moving {
    store: VoxelStore,
    cache: SceneCache,
    live: LiveView,
    frame: u32,
    /// Bytes of the buffers that there are.
    buffers: HashMap<ResourceId, u64>,
}

impl Moving {
    fn new(shown: &Scene, limits: DeviceLimits) -> Self {
        let store = VoxelStore::new(limits);
        let mut cache = SceneCache::new(&store);
        let mut recording = Recording::new();
        cache.update(shown, &mut recording).unwrap();
        let live = LiveView::new(&LiveSettings::new(SIZE, SIZE), &cache, &mut recording).unwrap();
        let mut moving = Self { store, cache, live, frame: 0, buffers: HashMap::new() };
        moving.replay(&recording);
        moving
    }

    fn replay(&mut self, recording: &Recording) {
        for step in &recording.steps {
            match step {
                Step::CreateBuffer { id, size, .. } => {
                    self.buffers.insert(*id, *size);
                }
                Step::Free { id } => {
                    self.buffers.remove(id);
                }
                _ => {}
            }
        }
    }

    fn bytes(&self) -> u64 {
        self.buffers.values().sum()
    }

    fn update(&mut self, shown: &Scene) {
        let mut recording = Recording::new();
        self.cache.update(shown, &mut recording).unwrap();
        self.replay(&recording);
    }

    fn show(&mut self, settings: &LiveSettings, budget: u64) -> LiveStatus {
        self.frame += 1;
        let seen: Camera = camera().with_aspect(1.0);
        let turn = DAffine3::from_rotation_y(0.01 * f64::from(self.frame));
        let seen = Camera { world_from_camera: turn * seen.world_from_camera, ..seen };
        let host = HostFrame::new(ResourceId::external());
        let mut recording = Recording::new();
        let status =
            self.live.record_frame(&self.cache, &seen, settings, &host, budget, &mut recording).unwrap();
        self.replay(&recording);
        assert_eq!(self.store.light_bytes(), status.light_bytes);
        status
    }
}

/// Of a large volume, so that there are cells to do without.
fn large() -> Scene {
    scene(&[volume(220)])
}

#[test]
fn what_light_takes_is_told_to_the_byte() {
    for limits in
        [LIMITS, LIMITS.with(|it| it.loop_turns = Some(lumivox_renderer::LoopTurns::of_software(16)))]
    {
        let mut moving = Moving::new(&large(), limits);
        let settings = LiveSettings::new(SIZE, SIZE);
        assert!(settings.kept_light, "it is on by default");
        for budget in [PIXELS / 8, 2 * PIXELS, PIXELS / 2] {
            let told = moving.show(&settings, budget).light_bytes;
            let before = moving.bytes();
            let mut recording = Recording::new();
            moving.live.drop_light(&mut recording);
            moving.replay(&recording);
            // Counts, ends of rays and what a buffer's size is rounded up to.
            let taken = before - moving.bytes();
            assert!(taken.abs_diff(told) < 512, "{taken} of {told} told");
            assert!(told > PIXELS * 32);
            assert_eq!(moving.store.light_bytes(), 0);
        }
        assert!(moving.show(&settings, PIXELS).light_bytes > 0, "it begins anew");
        let off = settings.with(|it| it.kept_light = false);
        assert_eq!(moving.show(&off, PIXELS).light_bytes, 0);
    }
}

#[test]
fn light_has_what_voxels_leave_of_the_bound() {
    let settings = LiveSettings::new(SIZE, SIZE);
    let mut moving = Moving::new(&large(), LIMITS);
    let most = moving.show(&settings, PIXELS / 4).light_bytes;
    let voxels = moving.store.bytes();
    let mut bounded = vec![];
    for percent in [100, 80, 60, 1] {
        let mut moving = Moving::new(&large(), LIMITS);
        moving.store.set_capacity(voxels + most * percent / 100);
        let status = moving.show(&settings, PIXELS / 4);
        assert!(status.pixel_samples > 0, "there is a picture in any case");
        assert!(status.light_bytes <= most * percent / 100, "{percent}%: {}", status.light_bytes);
        bounded.push(status.light_bytes);
    }
    // All but a part of the film of points.
    assert!(
        bounded[0] > most / 100 * 99 && bounded[0] > bounded[1] && bounded[1] > bounded[2],
        "{bounded:?}"
    );
    assert!(bounded[2] > 0 && bounded[3] == 0, "{bounded:?}");
}

#[test]
fn light_makes_way_for_voxels_that_come() {
    let settings = LiveSettings::new(SIZE, SIZE);
    let (first, second) = (volume(100), volume(101));
    let both = scene(&[first.clone(), second.clone()]);
    let of_both = Moving::new(&both, LIMITS).store.bytes();
    let mut moving = Moving::new(&scene(std::slice::from_ref(&first)), LIMITS);
    moving.store.set_capacity(of_both + (1 << 20));
    // What there is of it before is counted for what it is, and no more.
    let before = moving.show(&settings, PIXELS / 4).light_bytes;
    assert!(before > 1 << 20 && moving.store.bytes() + before <= of_both + (1 << 20), "{before}");
    moving.update(&both);
    assert_eq!(moving.store.resolution(&second).map(|it| it.factor), Some(1), "voxels come first");
    assert_eq!(moving.show(&settings, PIXELS / 4).light_bytes, 0);
    assert!(moving.store.bytes() <= of_both);
    // And comes back where the bound is raised.
    moving.store.set_capacity(u64::MAX);
    assert!(moving.show(&settings, PIXELS / 4).light_bytes > 0);
}

/// A view beside others of a world, from so many radians around the scene.
struct Beside {
    live: LiveView,
    angle: f64,
    settings: LiveSettings,
}

impl Beside {
    fn new(angle: f64, world: &mut Moving) -> Self {
        let settings = LiveSettings::new(SIZE, SIZE);
        let mut recording = Recording::new();
        let live = LiveView::new(&settings, &world.cache, &mut recording).unwrap();
        world.replay(&recording);
        Self { live, angle, settings }
    }

    /// Its frame, in which it has moved on.
    fn show(&mut self, world: &mut Moving) -> u64 {
        self.frame(world).light_bytes
    }

    fn frame(&mut self, world: &mut Moving) -> LiveStatus {
        self.angle += 0.001;
        let seen: Camera = camera().with_aspect(1.0);
        let turn = DAffine3::from_rotation_y(self.angle);
        let seen = Camera { world_from_camera: turn * seen.world_from_camera, ..seen };
        let host = HostFrame::new(ResourceId::external());
        let mut recording = Recording::new();
        let (live, cache) = (&mut self.live, &world.cache);
        let status =
            live.record_frame(cache, &seen, &self.settings, &host, PIXELS / 4, &mut recording).unwrap();
        world.replay(&recording);
        status
    }
}

#[test]
fn views_that_see_the_same_share_what_they_learn() {
    let mut world = Moving::new(&large(), LIMITS);
    let mut views = [0.0, 0.1].map(|angle| Beside::new(angle, &mut world));
    let [of_one, _] = [views[0].show(&mut world), world.store.light_bytes()];
    let shared = |views: &mut [Beside], world: &mut Moving| {
        // What one does the others notice in their next frame.
        let told = [(); 3].map(|()| views.iter_mut().map(|view| view.show(world)).sum::<u64>());
        assert_eq!(told[2], world.store.light_bytes());
        told[2]
    };
    let of_both = shared(&mut views, &mut world);
    // One of them teaches in each frame, and both in turn.
    let waits = [(); 6].map(|()| [0, 1].map(|view| views[view].frame(&mut world).awaits_turn));
    assert!(waits.iter().all(|[first, second]| first != second), "{waits:?}");
    assert!(waits.windows(2).all(|pair| pair[0] != pair[1]), "{waits:?}");
    assert!(of_both < of_one + of_one / 2, "{of_one} for one and {of_both} for both");
    // Another light is none of the first one's, and neither is what is seen from elsewhere: this scene's volumes have surfaces.
    views[1].settings.ambient = [1.0, 0.5, 0.2];
    assert!(shared(&mut views, &mut world) > of_one + of_one / 2, "light of its own");
    views[1].settings.ambient = [0.0; 3];
    views[1].angle = 2.0;
    assert!(shared(&mut views, &mut world) > of_one + of_one / 2, "seen from elsewhere");
    // Those that come to it later find what is there.
    let mut third = Beside::new(2.1, &mut world);
    let before = world.store.light_bytes();
    third.show(&mut world);
    assert!(world.store.light_bytes() < before + of_one / 2);
    // Whoever goes takes nothing of the others along, and the last one all.
    let cells = |world: &Moving| world.store.light_bytes() > of_one / 2;
    for mut view in views.into_iter().chain([third]) {
        assert!(cells(&world));
        assert!(view.show(&mut world) > 0);
        let mut gone = Recording::new();
        view.live.free(&mut gone);
        world.replay(&gone);
    }
    assert_eq!(world.store.light_bytes(), 0);
}

#[test]
fn shared_light_that_makes_way_is_gone_for_all() {
    let mut world = Moving::new(&large(), LIMITS);
    let mut views = [0.0, 0.1, 0.2].map(|angle| Beside::new(angle, &mut world));
    views.iter_mut().for_each(|view| assert!(view.show(&mut world) > 0));
    world.store.set_capacity(world.store.bytes());
    for view in &mut views {
        assert_eq!(view.show(&mut world), 0);
    }
    assert_eq!(world.store.light_bytes(), 0);
    world.store.set_capacity(u64::MAX);
    views.iter_mut().for_each(|view| assert!(view.show(&mut world) > 0));
}
