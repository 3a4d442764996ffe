//! Voxels that arrive, grow, go, and come reduced look like those that were there all the time.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Ease, Environment, Filter, Medium, Modality, PerspectiveCamera, Scene, TransferFunction, Volume,
    VolumeInstance, Voxels,
};
use lumivox_renderer::{
    DeviceLimits, FineTexels, Recording, Resolution, SceneCache, View, ViewSettings, VoxelStore,
    prepare_volume,
};
use lumivox_wgpu::Gpu;

use crate::gpu;

const SIZE: u32 = 24;
const SAMPLES: u32 = 8;

/// A sphere whose value falls to its rim, in a box that is not a multiple of any brick.
fn sphere(dims: [usize; 3], eight_bit: bool) -> Arc<Volume> {
    let center = dims.map(|n| n as f64 / 2.0);
    let value = |i: usize| {
        let at = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
        let away: f64 = (0..3).map(|a| ((at[a] as f64 + 0.5) / center[a] - 1.0).powi(2)).sum();
        (1.0 - away.sqrt()).max(0.0)
    };
    let values = (0..dims.iter().product()).map(value);
    let voxels = match eight_bit {
        true => Voxels::U8(values.map(|v| (v * 255.0) as u8).collect()),
        false => Voxels::U16(values.map(|v| (v * 65535.0) as u16).collect()),
    };
    let slope = if eight_bit { 1.0 / 255.0 } else { 1.0 / 65535.0 };
    // All are as large in the world.
    let spacing = DVec3::from_array(dims.map(|n| 40.0 / n as f64));
    Arc::new(Volume::new(dims, voxels, [slope, 0.0], DAffine3::from_scale(spacing), Modality::Other).unwrap())
}

fn scene(volumes: &[&Arc<Volume>]) -> Scene {
    let function = TransferFunction::from_points(
        Ease::Linear,
        &[(0.1, 0.0), (1.0, 0.6)],
        &[(0.0, [0.2, 0.5, 0.9]), (1.0, [0.9, 0.5, 0.2])],
    );
    let medium = Medium::new(function.unwrap());
    let place = |(i, volume): (usize, &&Arc<Volume>)| {
        let mut instance = VolumeInstance::centered((*volume).clone(), medium.clone());
        let shift = DVec3::X * (i as f64 - (volumes.len() - 1) as f64 / 2.0) * 0.02;
        instance.world_from_patient = DAffine3::from_translation(shift) * instance.world_from_patient;
        instance
    };
    let environment = Environment::uniform(1.0);
    Scene { volumes: volumes.iter().enumerate().map(place).collect(), environment, lights: vec![] }
}

fn execute(gpu: &mut Gpu, record: impl FnOnce(&mut Recording)) {
    let mut recording = Recording::new();
    record(&mut recording);
    gpu.executor.execute(&recording).unwrap();
}

/// Radiance and alpha of each pixel.
fn film(gpu: &mut Gpu, cache: &SceneCache) -> Vec<[f32; 4]> {
    let mut recording = Recording::new();
    let mut view = View::new(ViewSettings::new(SIZE, SIZE), cache, &mut recording).unwrap();
    let camera = PerspectiveCamera::look_at(DVec3::new(0.03, 0.05, 0.12), DVec3::ZERO, DVec3::Y, 0.6);
    view.record_samples(cache, &camera, SAMPLES, u64::MAX, &mut recording);
    view.record_read_film(&mut recording);
    let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
    execute(gpu, |recording| view.free(recording));
    let pixels = (SIZE * SIZE) as usize * 16;
    bytes[..pixels].chunks_exact(16).map(bytemuck::pod_read_unaligned).collect()
}

/// What a store of its own shows at once.
fn film_at_once(gpu: &mut Gpu, limits: DeviceLimits, scene: &Scene) -> Vec<[f32; 4]> {
    let store = VoxelStore::new(limits);
    let mut cache = SceneCache::new(&store);
    execute(gpu, |recording| cache.update(scene, recording).unwrap());
    let film = film(gpu, &cache);
    execute(gpu, |recording| {
        cache.free(recording);
        store.free(recording);
    });
    film
}

/// Asserts that two films are of one image. Voxels at another place are read with another rounding, which sends a path
/// elsewhere once in thousands.
fn assert_same(film: &[[f32; 4]], expected: &[[f32; 4]], what: &str) {
    let lit = expected.iter().filter(|pixel| pixel[3] > 0.0).count();
    assert!(lit > expected.len() / 8, "{what}: there is nothing to see");
    let differs =
        |(a, b): &(&[f32; 4], &[f32; 4])| (0..4).any(|i| (a[i] - b[i]).abs() > 1e-3 * a[i].max(0.1));
    let off = film.iter().zip(expected).filter(differs).count();
    assert!(off <= lit / 50, "{what}: {off} of {lit} pixels differ");
}

/// Means of alpha over all pixels.
fn alpha(film: &[[f32; 4]]) -> f64 {
    film.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>() / film.len() as f64
}

#[test]
fn a_volume_arrives_coarse_then_whole() {
    let mut gpu = gpu();
    let limits = gpu.executor.limits();
    let [large, small] = [sphere([150, 170, 130], false), sphere([40, 33, 65], false)];
    let scene = scene(&[&large, &small]);
    prepare_volume(&large);
    let store = VoxelStore::new(limits);
    let mut cache = SceneCache::new(&store);
    let mut seen: Vec<(Resolution, Vec<[f32; 4]>)> = vec![];
    let (mut most, mut frames) = (0, 0);
    while seen.is_empty() || !cache.is_settled() {
        let mut budget = 1 << 20;
        let mut recording = Recording::new();
        cache.update_within(&scene, &mut budget, &mut recording).unwrap();
        let brought: usize = recording
            .steps
            .iter()
            .map(|step| match step {
                lumivox_renderer::Step::WriteTexture { data, .. } => data.bytes().len(),
                _ => 0,
            })
            .sum();
        most = most.max(brought);
        gpu.executor.execute(&recording).unwrap();
        let resolution = store.resolution(&large).unwrap();
        let shown = (resolution, film(&mut gpu, &cache));
        match seen.last_mut() {
            Some(before) if before.0 == resolution => *before = shown,
            _ => seen.push(shown),
        }
        frames += 1;
        let small = store.resolution(&small);
        assert!(frames < 3 || small == Some(Resolution { factor: 1, arriving: false }), "{small:?}");
    }
    // The last look at each: the small one comes after the coarse.
    let [(coarse, first), (whole, last)] = &seen[..] else { panic!("{} looks of it", seen.len()) };
    assert_eq!(*coarse, Resolution { factor: 2, arriving: true });
    assert_eq!(*whole, Resolution { factor: 1, arriving: false });
    // The coarse copy is the first to come, with what came at once.
    assert!(most < 3 << 20, "{most} bytes in an update of a budget of 1 MiB");
    let (coarse, whole) = (alpha(first), alpha(last));
    assert!((coarse - whole).abs() < 0.03 * whole, "coarse {coarse}, whole {whole}");
    assert_eq!(cache.unprepared(), 0);
    let at_once = film_at_once(&mut gpu, limits, &scene);
    assert_same(last, &at_once, "arrived");
}

#[test]
fn an_image_does_not_depend_on_where_voxels_lie() {
    let mut gpu = gpu();
    let limits = gpu.executor.limits();
    let volumes = [
        sphere([70, 80, 60], false),
        sphere([33, 90, 64], false),
        sphere([97, 32, 31], false),
        sphere([65, 66, 1], false),
    ];
    let all: Vec<&Arc<Volume>> = volumes.iter().collect();
    let expected = film_at_once(&mut gpu, limits.with(|it| it.one_pool = true), &scene(&all));
    // Pools of three bricks a side at most: none holds all, and they have to grow.
    let small = limits.with(|it| it.max_texture_3d = 3 * 33);
    for (name, limits) in [
        ("many pools", limits.with(|it| it.one_pool = false)),
        ("small pools", small.with(|it| it.one_pool = false)),
    ] {
        let film = film_at_once(&mut gpu, limits, &scene(&all));
        assert_same(&film, &expected, name);
        // One after the other, with some that go again.
        let store = VoxelStore::new(limits);
        let mut cache = SceneCache::new(&store);
        for count in [1, 2, 3, 2, 4] {
            execute(&mut gpu, |recording| cache.update(&scene(&all[..count]), recording).unwrap());
        }
        let film = self::film(&mut gpu, &cache);
        assert_same(&film, &expected, &format!("{name}, one by one"));
        for volume in &all {
            assert_eq!(store.resolution(volume), Some(Resolution { factor: 1, arriving: false }), "{name}");
        }
    }
    // Half floats have eleven bits: another image, but not by much.
    let halves = film_at_once(&mut gpu, limits.with(|it| it.fine_texels = FineTexels::Halves), &scene(&all));
    let (a, b) = (alpha(&halves), alpha(&expected));
    assert!((a - b).abs() < 0.01 * b, "{a} of half floats, {b}");
}

/// Of as many of 65,536 values, from the `first` on.
fn narrow(first: u16, count: u16) -> Arc<Volume> {
    let wide = sphere([70, 80, 60], false);
    let Voxels::U16(values) = wide.voxels() else { panic!("of 16 bits") };
    let step = (65_536 / u32::from(count)) as u16;
    let narrow = Voxels::U16(values.iter().map(|&v| first + v / step).collect());
    let (slope, place) = (1.0 / f64::from(count), wide.patient_from_voxel());
    let rescale = [slope, -f64::from(first) * slope];
    Arc::new(Volume::new(wide.dims(), narrow, rescale, place, Modality::Other).unwrap())
}

/// Of 1024, among which the first byte changes four times. Half floats tell 64 of them apart.
fn of_four_first_bytes() -> Arc<Volume> {
    narrow(29_700, 1024)
}

#[test]
fn two_bytes_keep_all_of_16_bits() {
    let mut gpu = gpu();
    let limits = gpu.executor.limits();
    let narrow = of_four_first_bytes();
    for (name, one_pool, volumes) in [
        ("alone", true, vec![&narrow]),
        ("beside one of 8 bits", false, vec![&narrow, &sphere([33, 40, 50], true)]),
    ] {
        let mut scene = scene(&volumes);
        scene.volumes.iter_mut().for_each(|volume| volume.medium.filter = Filter::Nearest);
        let mut film = |fine_texels| {
            let limits = limits.with(|it| (it.one_pool, it.fine_texels) = (one_pool, fine_texels));
            film_at_once(&mut gpu, limits, &scene)
        };
        let expected = film(limits.fine_texels);
        assert_same(&film(FineTexels::TwoBytes), &expected, name);
        // Another image, but not by much.
        let halves = film(FineTexels::Halves);
        let off = halves.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert!(off > expected.len() / 16, "{name}: {off} pixels of half floats differ");
        let (a, b) = (alpha(&halves), alpha(&expected));
        assert!((a - b).abs() < 0.1 * b, "{name}: {a} of half floats, {b}");
    }
}

/// How far a picture in two bytes, and one in half floats, is from that of the device's own, as parts of that.
fn two_bytes_and_halves(gpu: &mut Gpu, volume: &Arc<Volume>) -> [f64; 2] {
    let limits = gpu.executor.limits();
    let scene = scene(&[volume]);
    let mut film = |fine_texels| film_at_once(gpu, limits.with(|it| it.fine_texels = fine_texels), &scene);
    let expected = film(limits.fine_texels);
    let light: f64 = expected.iter().map(|pixel| f64::from(pixel[0])).sum();
    [FineTexels::TwoBytes, FineTexels::Halves].map(|fine_texels| {
        let film = film(fine_texels);
        film.iter().zip(&expected).map(|(a, b)| f64::from((a[0] - b[0]).abs())).sum::<f64>() / light
    })
}

#[test]
fn two_bytes_are_filtered_as_numbers_of_16_bits() {
    // Whatever the device rounds to is fine enough where the first byte is the same everywhere.
    let [bytes, halves] = two_bytes_and_halves(&mut gpu(), &narrow(118 << 8, 256));
    println!("of one first byte: {bytes:.4} off in two bytes, {halves:.4} in half floats");
    assert!(halves > 4.0 * bytes, "{bytes} in two bytes, {halves} in half floats");
    // Where it is not, the device is asked; where it has no others.
    let plain = crate::hosts::plain_device();
    let fine_texels = plain.executor.limits().fine_texels;
    let [bytes, halves] = two_bytes_and_halves(&mut gpu(), &of_four_first_bytes());
    println!(
        "{}, {fine_texels:?}: {bytes:.4} off in two bytes, {halves:.4} in half floats",
        plain.description.name
    );
    match fine_texels {
        FineTexels::TwoBytes => {
            assert!(halves > 4.0 * bytes, "{bytes} in two bytes, {halves} in half floats")
        }
        FineTexels::Halves => assert!(halves < bytes, "{bytes} in two bytes, {halves} in half floats"),
        FineTexels::Norms => panic!("a device that was opened without them has 16-bit norms"),
    }
}

#[test]
fn volumes_of_different_formats_stand_side_by_side_at_their_own_cost() {
    let mut gpu = gpu();
    let limits = gpu.executor.limits().with(|it| it.one_pool = false);
    let [fine, plain] = [sphere([64, 64, 96], false), sphere([64, 96, 64], true)];
    let both = scene(&[&fine, &plain]);
    let store = VoxelStore::new(limits);
    let mut cache = SceneCache::new(&store);
    execute(&mut gpu, |recording| cache.update(&scene(&[&fine]), recording).unwrap());
    assert_eq!(store.bytes(), 2 * 12 * 33 * 33 * 33);
    execute(&mut gpu, |recording| cache.update(&both, recording).unwrap());
    assert_eq!(store.bytes(), (2 + 1) * 12 * 33 * 33 * 33);
    // Texture units may filter 8 bits with less precision: the means have to do.
    let mixed = alpha(&film(&mut gpu, &cache));
    let expected = alpha(&film_at_once(&mut gpu, limits.with(|it| it.one_pool = true), &both));
    assert!((mixed - expected).abs() < 0.01 * expected, "{mixed} instead of {expected}");
}

#[test]
fn a_pool_that_is_full_grows_and_keeps_what_it_holds() {
    let mut gpu = gpu();
    let limits = gpu.executor.limits().with(|it| it.one_pool = true);
    let volumes: Vec<Arc<Volume>> = (0..4).map(|i| sphere([40 + 7 * i, 50, 34 + 20 * i], false)).collect();
    let all: Vec<&Arc<Volume>> = volumes.iter().collect();
    let store = VoxelStore::new(limits);
    let mut cache = SceneCache::new(&store);
    let mut bytes = vec![];
    for count in 1..=4 {
        execute(&mut gpu, |recording| cache.update(&scene(&all[..count]), recording).unwrap());
        bytes.push(store.bytes());
    }
    assert!(bytes.is_sorted() && bytes[3] > 2 * bytes[0], "{bytes:?}");
    let expected = film_at_once(&mut gpu, limits, &scene(&all));
    assert_same(&film(&mut gpu, &cache), &expected, "grown");

    // A little with every frame.
    let mut cache = SceneCache::new(&VoxelStore::new(limits));
    let whole = scene(&all);
    let two = Scene { volumes: whole.volumes[..2].to_vec(), ..whole.clone() };
    execute(&mut gpu, |recording| cache.update(&two, recording).unwrap());
    let mut films = vec![];
    while {
        execute(&mut gpu, |recording| {
            cache.update_within(&whole, &mut (64 << 10), recording).unwrap();
        });
        films.push(film(&mut gpu, &cache));
        !cache.is_settled()
    } {}
    assert_same(&films[9], &films[0], "while it grows");
    assert_same(films.last().unwrap(), &expected, "grown slowly");
}

#[test]
fn what_there_is_no_room_for_comes_reduced_and_whole_once_there_is() {
    let mut gpu = gpu();
    let limits = gpu.executor.limits();
    let [a, b] = [sphere([100, 90, 110], false), sphere([130, 120, 100], false)];
    let store = VoxelStore::new(limits);
    let mut cache = SceneCache::new(&store);
    execute(&mut gpu, |recording| cache.update(&scene(&[&a]), recording).unwrap());
    store.set_capacity(store.bytes() + (3 << 20));
    let both = scene(&[&a, &b]);
    execute(&mut gpu, |recording| cache.update(&both, recording).unwrap());
    assert_eq!(store.resolution(&a), Some(Resolution { factor: 1, arriving: false }), "it stays");
    assert_eq!(store.resolution(&b), Some(Resolution { factor: 2, arriving: false }));
    assert_eq!(store.reduced(), 1);
    assert!(cache.is_settled());
    let (reduced, expected) = (alpha(&film(&mut gpu, &cache)), alpha(&film_at_once(&mut gpu, limits, &both)));
    assert!((reduced - expected).abs() < 0.03 * expected, "reduced {reduced}, whole {expected}");

    // The first goes: hidden, it is given up for the one that is shown.
    let alone = scene(&[&b]);
    store.set_capacity(u64::MAX);
    drop((a, both));
    execute(&mut gpu, |recording| cache.update(&alone, recording).unwrap());
    execute(&mut gpu, |recording| cache.update(&alone, recording).unwrap());
    assert_eq!(store.resolution(&b), Some(Resolution { factor: 1, arriving: false }));
    assert!(cache.is_settled());
    assert_same(&film(&mut gpu, &cache), &film_at_once(&mut gpu, limits, &alone), "whole again");

    // A device that refuses what was recorded gets less of it.
    let c = sphere([140, 130, 120], false);
    let other = scene(&[&b, &c]);
    let mut refused = Recording::new();
    cache.update(&other, &mut refused).unwrap();
    let wanted = store.bytes();
    gpu.executor.discard(&refused);
    store.refused(&refused);
    let mut cache = SceneCache::new(&store);
    execute(&mut gpu, |recording| cache.update(&other, recording).unwrap());
    assert_eq!(store.resolution(&b), Some(Resolution { factor: 1, arriving: false }), "it was there before");
    assert_eq!(store.resolution(&c), Some(Resolution { factor: 2, arriving: false }));
    assert!(store.bytes() < wanted, "{} of {wanted}", store.bytes());
    assert!(alpha(&film(&mut gpu, &cache)) > 0.05);
}
