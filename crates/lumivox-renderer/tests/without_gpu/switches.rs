//! A volume whose filter is switched while scenes show it, seen without a GPU: nothing gets coarse, nothing stays behind.

use std::collections::HashSet;
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use lumivox_core::{Environment, Filter, Scene, Volume};
use lumivox_renderer::{
    DeviceLimits, Recording, Resolution, ResourceId, SceneCache, Step, VoxelStore, prepare_volume,
};

use crate::scenes::{self, *};

/// Bytes of bricks of 16-bit voxels, so many along each axis.
const fn bytes(bricks: u64) -> u64 {
    2 * (33 * bricks).pow(3)
}

/// An update may bring one more than its budget has room for.
const BRICK: usize = bytes(1) as usize;

/// For one update.
const PATIENCE: Duration = Duration::from_secs(20);

const WHOLE: Option<Resolution> = Some(Resolution { factor: 1, arriving: false });
const ARRIVING: Option<Resolution> = Some(Resolution { factor: 1, arriving: true });

/// A volume once for each filter.
fn scene(volume: &Arc<Volume>, filters: &[Filter]) -> Scene {
    let mut scene = scenes::scene(&vec![volume.clone(); filters.len()]);
    for (instance, filter) in scene.volumes.iter_mut().zip(filters) {
        instance.medium.filter = *filter;
    }
    Scene { environment: Environment::uniform(1.0), ..scene }
}

/// A host with its device.
struct Host {
    store: VoxelStore,
    alive: HashSet<ResourceId>,
}

impl Host {
    fn new(limits: DeviceLimits) -> Self {
        Self { store: VoxelStore::new(limits), alive: HashSet::new() }
    }

    /// The first update with something in it: voxels are cut on other threads, and frames wait for none of them.
    fn update(&mut self, cache: &mut SceneCache, scene: &Scene, budget: u64) -> Recording {
        let began = Instant::now();
        loop {
            let mut recording = Recording::new();
            cache.update_within(scene, &mut budget.clone(), &mut recording).unwrap();
            if !recording.is_empty() || cache.is_settled() {
                replay(&recording, &mut self.alive);
                return recording;
            }
            assert!(began.elapsed() < PATIENCE, "something comes");
            sleep(Duration::from_millis(1));
        }
    }

    /// Updates until nothing comes any more; returns the bytes of voxels that every update brought.
    fn settle(&mut self, cache: &mut SceneCache, scene: &Scene, budget: u64) -> Vec<usize> {
        let mut brought = vec![];
        while brought.is_empty() || !cache.is_settled() {
            brought.push(voxel_bytes(&self.update(cache, scene, budget)));
            assert!(brought.len() < 200, "it ends");
        }
        brought
    }

    fn collect(&mut self) {
        let mut recording = Recording::new();
        self.store.collect(&mut recording);
        replay(&recording, &mut self.alive);
    }
}

fn voxel_bytes(recording: &Recording) -> usize {
    let bytes = |step: &Step| match step {
        Step::WriteTexture { data, size, .. } if size[2] > 1 => data.bytes().len(),
        _ => 0,
    };
    recording.steps.iter().map(bytes).sum()
}

#[test]
fn a_filter_that_is_switched_leaves_one_copy() {
    let mut host = Host::new(LIMITS);
    let mut cache = SceneCache::new(&host.store);
    let volume = volume(180);
    host.update(&mut cache, &scene(&volume, &[Filter::Smooth]), u64::MAX);
    assert_eq!(host.store.bytes(), bytes(6));
    // At once.
    for (filter, brought) in [
        (Filter::Trilinear, bytes(6)),
        (Filter::Tricubic, 0),
        (Filter::Nearest, 0),
        (Filter::Smooth, bytes(6)),
    ] {
        let recording = host.update(&mut cache, &scene(&volume, &[filter]), u64::MAX);
        assert_eq!(voxel_bytes(&recording) as u64, brought, "{filter:?}");
        assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (bytes(6), WHOLE), "{filter:?}");
        assert!(cache.is_settled());
    }
    // A little with every frame: what was shown is shown until all is there.
    let budget = 1 << 20;
    for filter in [Filter::Tricubic, Filter::Smooth] {
        let scene = scene(&volume, &[filter]);
        let mut brought = vec![];
        while host.store.bytes() < 2 * bytes(6) || host.store.resolution(&volume) == ARRIVING {
            brought.push(voxel_bytes(&host.update(&mut cache, &scene, budget)));
            assert_eq!(host.store.resolution(&volume).map(|r| r.factor), Some(1));
            assert!(brought.len() < 200, "it ends");
        }
        assert!(!cache.is_settled(), "there is something to free");
        brought.extend(host.settle(&mut cache, &scene, budget));
        assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (bytes(6), WHOLE));
        assert_eq!(brought.iter().sum::<usize>() as u64, bytes(6), "once, and nothing coarse");
        assert!(brought.iter().all(|&brought| brought < budget as usize + BRICK), "{brought:?}");
    }
    assert_eq!(cache.unprepared(), 0);
}

#[test]
fn a_host_that_rests_frees_what_is_left_over_when_it_collects() {
    let mut host = Host::new(LIMITS);
    let [mut first, mut second] = [0; 2].map(|_| SceneCache::new(&host.store));
    let volume = volume(100);
    host.update(&mut first, &scene(&volume, &[Filter::Smooth]), u64::MAX);
    host.update(&mut second, &scene(&volume, &[Filter::Trilinear]), u64::MAX);
    host.collect();
    assert_eq!(host.store.bytes(), 2 * bytes(4), "one scene shows this, the other that");
    let mut recording = Recording::new();
    first.free(&mut recording);
    replay(&recording, &mut host.alive);
    host.collect();
    assert_eq!(host.store.bytes(), bytes(4));
    // The last one stays, as what is hidden does.
    second.free(&mut recording);
    host.collect();
    assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (bytes(4), WHOLE));
}

#[test]
fn what_is_shown_both_ways_stays_both_ways() {
    let mut host = Host::new(LIMITS);
    let mut cache = SceneCache::new(&host.store);
    let volume = volume(100);
    let both = scene(&volume, &[Filter::Smooth, Filter::Trilinear]);
    host.update(&mut cache, &scene(&volume, &[Filter::Trilinear]), u64::MAX);
    for budget in [u64::MAX, 1000] {
        host.update(&mut cache, &both, budget);
        host.collect();
        assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (2 * bytes(4), WHOLE));
        assert!(cache.is_settled());
    }
    // One is switched, and back.
    host.update(&mut cache, &scene(&volume, &[Filter::Smooth; 2]), 1000);
    assert_eq!(host.store.bytes(), bytes(4));
    let brought = host.settle(&mut cache, &both, 1 << 20);
    assert_eq!(brought.iter().sum::<usize>() as u64, bytes(4));
    assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (2 * bytes(4), WHOLE));
}

#[test]
fn a_filter_that_is_switched_back_finds_what_was_there() {
    let mut host = Host::new(LIMITS);
    let mut cache = SceneCache::new(&host.store);
    let volume = volume(180);
    let [smooth, plain] = [Filter::Smooth, Filter::Trilinear].map(|filter| scene(&volume, &[filter]));
    host.update(&mut cache, &smooth, u64::MAX);
    for _ in 0..3 {
        // The very first makes room.
        while voxel_bytes(&host.update(&mut cache, &plain, 1 << 20)) == 0 {}
        assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (2 * bytes(6), ARRIVING));
    }
    let brought = host.settle(&mut cache, &smooth, 1 << 20);
    assert_eq!(brought.iter().sum::<usize>(), 0, "it was there all the time");
    assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (bytes(6), WHOLE));

    // Before the first has arrived: its coarse copy is the other's, too.
    let mut host = Host::new(LIMITS);
    let mut cache = SceneCache::new(&host.store);
    prepare_volume(&volume);
    let first = voxel_bytes(&host.update(&mut cache, &smooth, 1000));
    assert_eq!(host.store.resolution(&volume), Some(Resolution { factor: 2, arriving: true }));
    let mut frames = 0;
    for scene in [&plain, &smooth, &plain].into_iter().cycle().take(9) {
        let brought = voxel_bytes(&host.update(&mut cache, scene, 1 << 20));
        assert!(brought < (1 << 20) + BRICK, "{brought} bytes, {first} of the coarse copy");
        assert!(host.store.resolution(&volume).is_some() && !cache.is_settled());
        assert!(host.store.bytes() < 2 * bytes(6) + (first as u64) * 2, "{}", host.store.bytes());
        frames += 1;
    }
    assert_eq!(frames, 9);
    host.settle(&mut cache, &plain, 1 << 20);
    host.collect();
    assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (bytes(6), WHOLE));
    assert_eq!(cache.unprepared(), 0);
}

/// One has it whole and goes on being updated while it comes for the other.
#[test]
fn what_one_scene_waits_for_another_leaves_alone() {
    let mut host = Host::new(LIMITS);
    let [mut first, mut second] = [0; 2].map(|_| SceneCache::new(&host.store));
    let volume = volume(180);
    let [smooth, plain] = [Filter::Smooth, Filter::Trilinear].map(|filter| scene(&volume, &[filter]));
    host.update(&mut first, &smooth, u64::MAX);
    let (mut brought, mut frames) = (0, 0);
    while brought == 0 || !second.is_settled() {
        brought += voxel_bytes(&host.update(&mut second, &plain, 1 << 20));
        host.update(&mut first, &smooth, 1 << 20);
        host.collect();
        frames += 1;
        assert!(frames < 200, "it ends");
    }
    assert_eq!(brought as u64, bytes(6));
    assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (2 * bytes(6), WHOLE));
}

/// There the one goes first, and the other comes as any volume does.
#[test]
fn where_there_is_no_room_for_both_a_switch_brings_one_anew() {
    let mut host = Host::new(LIMITS);
    let mut cache = SceneCache::new(&host.store);
    let volume = volume(180);
    prepare_volume(&volume);
    host.update(&mut cache, &scene(&volume, &[Filter::Smooth]), u64::MAX);
    host.store.set_capacity(bytes(6) + bytes(6) / 3);
    let plain = scene(&volume, &[Filter::Trilinear]);
    host.update(&mut cache, &plain, 1 << 20);
    assert_eq!(host.store.resolution(&volume), Some(Resolution { factor: 2, arriving: true }));
    host.settle(&mut cache, &plain, 1 << 20);
    host.collect();
    assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (bytes(6), WHOLE));
}

/// The texture of what is shown is not free yet.
#[test]
fn a_switch_has_its_texture_made_ahead() {
    let mut host = Host::new(LIMITS);
    let mut cache = SceneCache::new(&host.store);
    let volume = volume(220);
    host.update(&mut cache, &scene(&volume, &[Filter::Smooth]), u64::MAX);
    let plain = scene(&volume, &[Filter::Trilinear]);
    let preparation = cache.preparation(&plain).expect("a texture");
    let mut orders = vec![];
    preparation.run_with(|order| {
        orders.push(order.id);
        true
    });
    let [order] = orders[..] else { panic!("{orders:?}") };
    assert!(cache.preparation(&plain).is_none(), "nothing coarse has to be made");
    let recording = host.update(&mut cache, &plain, 1 << 20);
    let takes = |step: &Step| matches!(step, Step::CreateTexture { id, .. } if *id == order);
    assert!(recording.steps.iter().any(takes));
    host.settle(&mut cache, &plain, 16 << 20);
    assert_eq!((host.store.bytes(), host.store.resolution(&volume)), (bytes(7), WHOLE));
}
