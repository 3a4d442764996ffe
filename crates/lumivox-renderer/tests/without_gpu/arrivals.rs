//! How volumes come, seen without a GPU: within a budget, one after the other, into textures that were made before.

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::Duration;

use lumivox_core::{Environment, Scene, Volume};
use lumivox_renderer::recording::{Kernel, TextureOrder};
use lumivox_renderer::{
    DeviceLimits, Preparation, Recording, ResourceId, SceneCache, Step, View, ViewSettings, VoxelStore,
    prepare_volume,
};
use lumivox_shaders::PathTraceVariant;
use lumivox_shaders::layout::ValueRangeParams;

use crate::scenes::{self, *};

fn scene(volumes: &[Arc<Volume>]) -> Scene {
    Scene { environment: Environment::uniform(1.0), ..scenes::scene(volumes) }
}

/// What is made ahead.
fn run(preparation: &Preparation, succeeds: bool) -> Vec<TextureOrder> {
    let mut orders = vec![];
    preparation.run_with(|order| {
        orders.push(*order);
        succeeds
    });
    orders
}

fn update(cache: &mut SceneCache, scene: &Scene, mut budget: u64) -> Recording {
    let mut recording = Recording::new();
    cache.update_within(scene, &mut budget, &mut recording).unwrap();
    recording
}

/// The textures of voxels that a recording creates, but for small ones.
fn created(recording: &Recording) -> Vec<ResourceId> {
    let large = |step: &Step| match step {
        Step::CreateTexture { id, size: [x, y, z], .. } if x * y * z > 8 << 20 => Some(*id),
        _ => None,
    };
    recording.steps.iter().filter_map(large).collect()
}

fn frees(recording: &Recording, id: ResourceId) -> bool {
    recording.steps.iter().any(|step| matches!(step, Step::Free { id: freed } if *freed == id))
}

fn voxel_bytes(recording: &Recording) -> usize {
    let bytes = |step: &Step| match step {
        Step::WriteTexture { data, size, .. } if size[2] > 1 => data.bytes().len(),
        _ => 0,
    };
    recording.steps.iter().map(bytes).sum()
}

#[test]
fn the_texture_of_a_large_volume_is_made_ahead() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let shown = scene(&[volume(220)]);
    let preparation = cache.preparation(&shown).expect("a texture and a coarse copy");
    let orders = run(&preparation, true);
    let [order] = orders[..] else { panic!("{orders:?}") };
    assert!(cache.preparation(&shown).is_none(), "all is done");
    assert!(run(&preparation, true).is_empty(), "it is made once");
    assert_eq!(created(&update(&mut cache, &shown, 1000)), [order.id]);
    while !cache.is_settled() {
        let recording = update(&mut cache, &shown, 8 << 20);
        assert!(created(&recording).is_empty() && !frees(&recording, order.id));
    }
    assert_eq!(cache.unprepared(), 0);
    assert!(cache.store().bytes() < 2 * 220 * 220 * 220 * 115 / 100 + (128 << 20));
}

/// A frame looks at no more voxels than it brings, whole layers of bricks or not.
#[test]
fn value_ranges_are_computed_a_share_with_every_frame() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let shown = scene(&[volume(220)]);
    shown.volumes.iter().for_each(|instance| prepare_volume(&instance.volume));
    let (budget, bytes) = (1 << 20, 2.0 * 33.0f64.powi(3) * 7.0f64.powi(3));
    // The coarse copy's come with it.
    update(&mut cache, &shown, budget);
    let mut shares = vec![];
    while !cache.is_settled() {
        let recording = update(&mut cache, &shown, budget);
        shares.extend(recording.steps.iter().filter_map(|step| match step {
            Step::Dispatch { kernel: Kernel::ValueRanges { .. }, uniforms, .. } => {
                Some(bytemuck::pod_read_unaligned::<ValueRangeParams>(&uniforms[0]).cell_count)
            }
            _ => None,
        }));
        assert!(shares.len() < 100, "it ends");
    }
    let all = [56u32; 3].iter().product::<u32>();
    assert_eq!(shares.iter().sum::<u32>(), all, "every cell once");
    let most = (f64::from(all) * budget as f64 / bytes).ceil() as u32;
    assert!(shares.len() > 20 && shares.iter().all(|&share| share <= most), "{most}: {shares:?}");
}

#[test]
fn cells_are_larger_where_a_device_binds_few() {
    let bytes = |limit: u64| {
        let mut cache = SceneCache::new(&VoxelStore::new(LIMITS.with(|it| it.max_storage_binding = limit)));
        cache.update(&scene(&[volume(220), volume(100)]), &mut Recording::new()).unwrap();
        cache.majorants().1 * 8
    };
    let usual = bytes(LIMITS.max_storage_binding);
    assert_eq!(usual, 8 * (56 * 56 * 56 + 26 * 26 * 26));
    // Those of the larger one, of 8 voxels instead of 4.
    assert_eq!(bytes(1 << 20), 8 * (29 * 29 * 29 + 26 * 26 * 26));
}

#[test]
fn a_texture_that_another_thread_makes_is_waited_for() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let shown = scene(&[volume(220)]);
    shown.volumes.iter().for_each(|instance| prepare_volume(&instance.volume));
    let preparation = cache.preparation(&shown).expect("a texture");
    let (begun, has_begun) = std::sync::mpsc::channel();
    let (end, may_end) = std::sync::mpsc::channel::<()>();
    let thread = std::thread::spawn(move || {
        let mut made = None;
        preparation.run_with(|order| {
            begun.send(()).unwrap();
            may_end.recv().unwrap();
            made = Some(order.id);
            true
        });
        made.expect("it was ordered")
    });
    has_begun.recv().unwrap();
    let same = cache.preparation(&shown).expect("it is not done");
    end.send(()).unwrap();
    assert!(run(&same, true).is_empty(), "it is made once");
    assert!(cache.preparation(&shown).is_none());
    assert_eq!(created(&update(&mut cache, &shown, 1000)), [thread.join().unwrap()]);
}

/// A small volume has room in a pool that stays, but its value ranges go with the recording.
#[test]
fn nothing_of_what_a_device_refused_is_taken_for_there() {
    let store = VoxelStore::new(LIMITS);
    let mut cache = SceneCache::new(&store);
    let [a, small, large] = [volume(36), volume(16), volume(220)];
    update(&mut cache, &scene(std::slice::from_ref(&a)), u64::MAX);
    let all = scene(&[a.clone(), small.clone(), large.clone()]);
    let refused = update(&mut cache, &all, u64::MAX);
    assert!(store.refused(&refused), "the large one may come smaller");
    assert_eq!(store.resolution(&a).map(|r| r.factor), Some(1), "it was there before");
    assert_eq!([store.resolution(&small), store.resolution(&large)], [None; 2]);
    let mut cache = SceneCache::new(&store);
    let again = update(&mut cache, &all, u64::MAX);
    let writes = again.steps.iter().filter(|step| matches!(step, Step::WriteTexture { .. })).count();
    assert!(writes > 1 && store.resolution(&large).is_some_and(|r| r.factor > 1));

    // One alone, too, until there is nothing left to save.
    let store = VoxelStore::new(LIMITS);
    let alone = scene(&[large]);
    let mut attempts = 0;
    while {
        let refused = update(&mut SceneCache::new(&store), &alone, u64::MAX);
        attempts += 1;
        store.refused(&refused)
    } {}
    assert!((2..40).contains(&attempts), "{attempts}");
}

#[test]
fn a_bound_that_is_raised_brings_volumes_whole_and_none_is_smaller_than_it_need_be() {
    let store = VoxelStore::new(LIMITS);
    let mut cache = SceneCache::new(&store);
    let volume = volume(60);
    let shown = scene(std::slice::from_ref(&volume));
    store.set_capacity(1);
    update(&mut cache, &shown, u64::MAX);
    assert_eq!(store.resolution(&volume).map(|r| r.factor), Some(2), "a brick, which is the least there is");
    assert!(cache.is_settled());
    store.set_capacity(u64::MAX);
    assert!(!cache.is_settled());
    update(&mut cache, &shown, u64::MAX);
    assert_eq!(store.resolution(&volume).map(|r| r.factor), Some(1));
    assert!(cache.is_settled());
}

#[test]
fn what_could_not_be_made_ahead_is_made_when_it_is_wanted() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let shown = scene(&[volume(220)]);
    let orders = run(&cache.preparation(&shown).unwrap(), false);
    assert!(cache.preparation(&shown).is_none(), "it is not tried for ever");
    let created = created(&update(&mut cache, &shown, 1000));
    assert_eq!(created.len(), 1);
    assert_ne!(created, [orders[0].id]);
}

#[test]
fn what_was_made_ahead_for_nothing_is_freed() {
    let store = VoxelStore::new(LIMITS);
    let mut cache = SceneCache::new(&store);
    let shown = scene(&[volume(220)]);
    let preparation = cache.preparation(&shown).unwrap();
    let [order] = run(&preparation, true)[..] else { panic!("one texture") };
    // Another scene is shown after all.
    let small = scene(&[volume(16)]);
    assert!(!frees(&update(&mut cache, &small, 1000), order.id), "somebody holds the volume");
    drop((preparation, shown));
    let mut recording = Recording::new();
    store.collect(&mut recording);
    assert!(frees(&recording, order.id));

    // It comes otherwise than was thought: at once, with another.
    let limits = LIMITS.with(|it| it.max_texture_3d = 2048);
    let mut cache = SceneCache::new(&VoxelStore::new(limits));
    let others = scene(&[volume(220), volume(200)]);
    let one = Scene { volumes: others.volumes[..1].to_vec(), ..others.clone() };
    let [order] = run(&cache.preparation(&one).unwrap(), true)[..] else { panic!("one texture") };
    let recording = update(&mut cache, &others, u64::MAX);
    assert!(frees(&recording, order.id), "room for one is not what two need");
}

/// The largest part of the memory is that of the volume before.
#[test]
fn a_volume_that_replaces_another_takes_its_texture() {
    let store = VoxelStore::new(LIMITS);
    let mut cache = SceneCache::new(&store);
    let before = scene(&[volume(220)]);
    update(&mut cache, &before, u64::MAX);
    let bytes = store.bytes();
    let after = scene(&[volume(216)]);
    let preparation = cache.preparation(&after).expect("a coarse copy");
    assert!(run(&preparation, true).is_empty(), "there will be a texture");
    drop((preparation, before));
    while {
        assert!(created(&update(&mut cache, &after, 4 << 20)).is_empty());
        !cache.is_settled()
    } {}
    assert!(store.bytes() < bytes + (8 << 20), "{} after {bytes}", store.bytes());
}

/// Until nobody holds its last volume: a thread that cuts bricks of it does for a moment.
fn let_go(scene: Scene) {
    let volume = Arc::downgrade(&scene.volumes.last().unwrap().volume);
    drop(scene);
    while volume.strong_count() > 0 {
        sleep(Duration::from_millis(1));
    }
}

/// Its texture would be worth leaving, were there nothing to come.
#[test]
fn a_texture_with_a_small_volume_in_it_takes_the_next_large_one() {
    let limits = LIMITS.with(|it| {
        it.max_texture_3d = 2048;
        it.max_storage_binding = 128 << 20;
    });
    let store = VoxelStore::new(limits);
    let mut cache = SceneCache::new(&store);
    let small = volume(64);
    let mut shown = scene(&[small.clone(), volume(440)]);
    update(&mut cache, &shown, u64::MAX);
    let bytes = store.bytes();
    let alone = scene(std::slice::from_ref(&small));
    for goes_before in [false, true] {
        if goes_before {
            update(&mut cache, &alone, u64::MAX);
            let_go(std::mem::replace(&mut shown, alone.clone()));
            store.collect(&mut Recording::new());
        }
        let next = scene(&[small.clone(), volume(440)]);
        let preparation = cache.preparation(&next).expect("a coarse copy");
        assert!(run(&preparation, true).is_empty(), "there will be a texture");
        // What was shown is on the device as long as somebody holds it.
        (shown, _) = (next, preparation);
        while {
            assert!(created(&update(&mut cache, &shown, 64 << 20)).is_empty());
            !cache.is_settled()
        } {}
        assert!(store.bytes() < bytes + (8 << 20), "{} after {bytes}", store.bytes());
    }
}

#[test]
fn a_volume_arrives_though_other_threads_are_busy() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let shown = scene(&[volume(220)]);
    shown.volumes.iter().for_each(|instance| prepare_volume(&instance.volume));
    // The coarse copy.
    update(&mut cache, &shown, 1 << 20);
    let is_over = Arc::new(AtomicBool::new(false));
    for _ in 0..rayon::current_num_threads() {
        let is_over = is_over.clone();
        rayon::spawn(move || {
            while !is_over.load(Ordering::Relaxed) {
                sleep(Duration::from_millis(1));
            }
        });
    }
    // What was cut before the threads were taken counts for little.
    let brought: usize = (0..200).map(|_| voxel_bytes(&update(&mut cache, &shown, 1 << 20))).sum();
    is_over.store(true, Ordering::Relaxed);
    assert!(brought > 10 << 20, "{brought} bytes in 200 frames");
}

#[test]
fn many_volumes_come_one_after_the_other() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let volumes: Vec<Arc<Volume>> = (0..6).map(|i| volume(100 + 12 * i)).collect();
    volumes.iter().for_each(prepare_volume);
    let shown = scene(&volumes);
    let mut recording = update(&mut cache, &shown, 1000);
    let mut view = View::new(ViewSettings::new(16, 16), &cache, &mut Recording::new()).unwrap();
    let mut frames = 0;
    let mut kernels = vec![];
    loop {
        // What comes at once, and what had begun before within the budget.
        assert!(voxel_bytes(&recording) < 5 << 20, "{} bytes", voxel_bytes(&recording));
        frames += 1;
        let mut trace = Recording::new();
        view.record_samples(&cache, &camera(), frames, u64::MAX, &mut trace);
        kernels.extend(trace.steps.iter().filter_map(|step| match step {
            // More samples are shared, fewer are not.
            Step::Dispatch { kernel: Kernel::PathTrace(variant), .. } => {
                Some(PathTraceVariant { shared: false, ..*variant })
            }
            _ => None,
        }));
        if cache.is_settled() {
            break;
        }
        recording = update(&mut cache, &shown, 1 << 20);
    }
    assert!(frames > 6, "{frames}");
    kernels.dedup();
    assert_eq!(kernels.len(), 1, "no kernel is new on the way");
    for volume in &volumes {
        assert_eq!(cache.store().resolution(volume).map(|r| (r.factor, r.arriving)), Some((1, false)));
    }
}

/// The layers of texels that a recording copies from one pool's texture to another: the first one, and how many.
fn copied(recording: &Recording) -> Vec<(u32, u32)> {
    let box_of = |step: &Step| match step {
        Step::CopyTexture { origin, size, .. } => Some((origin[2], size[2])),
        _ => None,
    };
    recording.steps.iter().filter_map(box_of).collect()
}

const ONE_POOL: DeviceLimits = {
    let mut limits = LIMITS;
    limits.one_pool = true;
    limits
};

/// Where there can be one pool only, a frame copies no more of what is there than it could bring.
#[test]
fn a_pool_grows_a_little_with_every_frame() {
    let store = VoxelStore::new(ONE_POOL);
    let mut cache = SceneCache::new(&store);
    let volumes = [volume(100), volume(90), volume(80)];
    let mut alive = HashSet::new();
    let replayed = |cache: &mut SceneCache, count: usize, budget: u64, alive: &mut HashSet<ResourceId>| {
        let recording = update(cache, &scene(&volumes[..count]), budget);
        replay(&recording, alive);
        recording
    };
    replayed(&mut cache, 1, u64::MAX, &mut alive);
    let bytes = store.bytes();
    let (mut layers, mut frames) = (0, 0);
    let budget = 1 << 20;
    while {
        // The third comes while the pool grows for the second, and has it grow no more.
        let recording = replayed(&mut cache, if frames < 2 { 2 } else { 3 }, budget, &mut alive);
        for (first, count) in copied(&recording) {
            assert!(first == layers && u64::from(count) * 132 * 132 * 2 <= budget);
            layers += count;
        }
        let is_there = |i: usize| store.resolution(&volumes[i]).is_some();
        assert!(is_there(0) && (layers >= 132 || !is_there(1) && voxel_bytes(&recording) == 0));
        frames += 1;
        layers < 132
    } {}
    assert!((4..10).contains(&frames), "{frames}");
    assert!(store.bytes() > bytes);
    while !cache.is_settled() {
        replayed(&mut cache, 3, budget, &mut alive);
        frames += 1;
        assert!(frames < 200, "it ends");
    }
    for volume in &volumes {
        assert_eq!(store.resolution(volume).map(|r| (r.factor, r.arriving)), Some((1, false)));
    }
    let mut end = Recording::new();
    drop(cache);
    store.free(&mut end);
    replay(&end, &mut alive);
}

/// What was there stays, whether the larger texture, a part of the copies or the last of them came to nothing.
#[test]
fn a_pool_that_may_not_grow_keeps_what_it_has() {
    for refused_at in 0..6 {
        let store = VoxelStore::new(ONE_POOL);
        let mut cache = SceneCache::new(&store);
        let volumes = [volume(100), volume(90)];
        let mut alive = HashSet::new();
        replay(&update(&mut cache, &scene(&volumes[..1]), u64::MAX), &mut alive);
        let discard = |recording: &Recording, alive: &mut HashSet<ResourceId>| {
            for step in &recording.steps {
                if let Step::Free { id } = step {
                    alive.remove(id);
                }
            }
        };
        let mut was_last = false;
        for frame in 0..=refused_at {
            let recording = update(&mut cache, &scene(&volumes), 1 << 20);
            assert_eq!(copied(&recording).len(), 1, "frame {frame}");
            if frame == refused_at {
                discard(&recording, &mut alive);
                was_last = copied(&recording).iter().any(|(first, count)| first + count == 132);
                assert!(store.refused(&recording), "frame {frame}: there may be room for less");
            } else {
                replay(&recording, &mut alive);
            }
        }
        let stays = store.resolution(&volumes[0]).map(|r| r.factor) == Some(1);
        assert_eq!(stays, !was_last, "refused in frame {refused_at}");
        // Anew, as hosts do.
        let mut cache = SceneCache::new(&store);
        let mut frames = 0;
        while {
            replay(&update(&mut cache, &scene(&volumes), 1 << 20), &mut alive);
            frames += 1;
            assert!(frames < 200, "it ends");
            !cache.is_settled()
        } {}
        assert!(volumes.iter().all(|volume| store.resolution(volume).is_some_and(|r| !r.arriving)));
        if was_last {
            return;
        }
    }
    panic!("the pool has not grown");
}
