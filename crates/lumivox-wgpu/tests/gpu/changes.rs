//! A scene that was changed piece by piece on the GPU is the scene; what is prepared is not waited for.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Environment, Filter, Medium, Modality, PerspectiveCamera, Scene, TransferFunction, Volume,
    VolumeInstance, Voxels,
};
use lumivox_renderer::{Recording, SceneCache, View, ViewKind, ViewSettings, VoxelStore};
use lumivox_testing::scenes;
use lumivox_wgpu::Gpu;

use crate::gpu;

const SIZE: u32 = 24;

/// Values that differ from voxel to voxel, and from seed to seed.
fn volume(dims: [usize; 3], seed: usize) -> Arc<Volume> {
    let voxels = (0..dims.iter().product()).map(|i: usize| ((i * 7919 + seed * 104_729) % 60_000) as u16);
    let place = DAffine3::from_scale(DVec3::splat(1.5));
    let voxels = Voxels::U16(voxels.collect());
    Arc::new(Volume::new(dims, voxels, [1.0 / 60_000.0, 0.0], place, Modality::Other).unwrap())
}

fn instance(volume: &Arc<Volume>, x: f64, opacity: f64, filter: Filter) -> VolumeInstance {
    let function = TransferFunction::from_points(
        lumivox_core::Ease::Linear,
        &[(0.2, 0.0), (1.0, opacity)],
        &[(0.0, [0.9, 0.6, 0.3])],
    );
    let mut instance = VolumeInstance::centered(volume.clone(), Medium::new(function.unwrap()));
    instance.medium.filter = filter;
    instance.world_from_patient = DAffine3::from_translation(DVec3::X * x) * instance.world_from_patient;
    instance
}

fn film(gpu: &mut Gpu, cache: &SceneCache) -> Vec<u8> {
    let mut recording = Recording::new();
    let mut view = View::new(ViewSettings::new(SIZE, SIZE), cache, &mut recording).unwrap();
    let camera = PerspectiveCamera::look_at(DVec3::Z * 0.15, DVec3::ZERO, DVec3::Y, 0.6);
    view.record_samples(cache, &camera, 4, u64::MAX, &mut recording);
    view.record_read_film(&mut recording);
    let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
    let mut recording = Recording::new();
    view.free(&mut recording);
    gpu.executor.execute(&recording).unwrap();
    bytes
}

fn update(gpu: &mut Gpu, cache: &mut SceneCache, scene: &Scene) {
    let mut recording = Recording::new();
    cache.update(scene, &mut recording).unwrap();
    gpu.executor.execute(&recording).unwrap();
}

/// The shares of numbers that differ, and that are not 0. Volumes at another place of the atlas are read with another
/// rounding, which now and then sends a path elsewhere.
fn difference(a: &[u8], b: &[u8]) -> (f64, f64) {
    let numbers =
        |bytes: &[u8]| -> Vec<f32> { bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect() };
    let (a, b) = (numbers(a), numbers(b));
    let far = a.iter().zip(&b).filter(|(a, b)| (*a - *b).abs() > 1e-3 * a.abs().max(0.1)).count();
    let lit = a.iter().filter(|a| **a != 0.0).count();
    (far as f64 / a.len() as f64, lit as f64 / a.len() as f64)
}

#[test]
fn a_scene_looks_the_same_however_it_came_about() {
    let mut gpu = gpu();
    let [a, b, c, d] =
        [[20, 16, 12], [24, 20, 20], [18, 16, 12], [20, 16, 12]].map(|dims| volume(dims, dims[0]));
    let e = volume([20, 16, 12], 77);
    let scene = |volumes: &[(&Arc<Volume>, f64, Filter)]| Scene {
        volumes: volumes
            .iter()
            .zip([-0.02, 0.0, 0.02])
            .map(|(&(v, opacity, filter), x)| instance(v, x, opacity, filter))
            .collect(),
        environment: Environment::uniform(1.0),
        ..Default::default()
    };
    use Filter::{Tricubic, Trilinear};
    let steps = [
        scene(&[(&a, 0.5, Trilinear), (&b, 0.8, Trilinear)]),
        // Another of the same size, a smaller one, the first again.
        scene(&[(&d, 0.5, Trilinear), (&b, 0.8, Trilinear)]),
        scene(&[(&c, 0.5, Trilinear), (&b, 0.8, Trilinear)]),
        scene(&[(&e, 0.7, Trilinear), (&b, 0.8, Trilinear)]),
        // In another order, with other filters.
        scene(&[(&b, 0.8, Trilinear), (&e, 0.7, Trilinear)]),
        scene(&[(&b, 0.8, Tricubic), (&e, 0.7, Trilinear)]),
        scene(&[(&b, 0.3, Trilinear), (&e, 0.7, Tricubic)]),
        // One more, one less, the same twice.
        scene(&[(&b, 0.3, Trilinear), (&e, 0.7, Trilinear), (&a, 0.4, Trilinear)]),
        scene(&[(&e, 0.7, Trilinear), (&a, 0.4, Trilinear)]),
        scene(&[(&e, 0.7, Trilinear), (&e, 0.2, Trilinear)]),
    ];
    let mut changed = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
    for (i, scene) in steps.iter().enumerate() {
        update(&mut gpu, &mut changed, scene);
        let mut fresh = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
        update(&mut gpu, &mut fresh, scene);
        let (changed, fresh_film) = (film(&mut gpu, &changed), film(&mut gpu, &fresh));
        let (far, lit) = difference(&changed, &fresh_film);
        assert!(lit > 0.2 && far < 0.02, "step {i} differs from a scene of its own in {far} of its numbers");
        let mut recording = Recording::new();
        fresh.free(&mut recording);
        gpu.executor.execute(&recording).unwrap();
    }
}

/// Nothing coarse, nothing of two kinds: the means until all voxels are there.
#[test]
fn a_switched_filter_goes_on_with_what_was_shown() {
    let mut gpu = gpu();
    let limits = gpu.executor.limits();
    let volume = volume([150, 140, 130], 3);
    let [smooth, plain] = [Filter::Smooth, Filter::Trilinear].map(|filter| Scene {
        volumes: vec![instance(&volume, 0.0, 0.3, filter)],
        environment: Environment::uniform(1.0),
        ..Default::default()
    });
    let mut at_once = |scene: &Scene| {
        let mut cache = SceneCache::new(&VoxelStore::new(limits));
        update(&mut gpu, &mut cache, scene);
        film(&mut gpu, &cache)
    };
    let (of_means, of_voxels) = (at_once(&smooth), at_once(&plain));
    let (far, lit) = difference(&of_voxels, &of_means);
    assert!(far > 0.1 && lit > 0.2, "the filters differ in {far} of the numbers");

    let store = VoxelStore::new(limits);
    let mut cache = SceneCache::new(&store);
    update(&mut gpu, &mut cache, &smooth);
    let mut frames = 0;
    while frames == 0 || !cache.is_settled() {
        let mut recording = Recording::new();
        cache.update_within(&plain, &mut (1 << 20), &mut recording).unwrap();
        gpu.executor.execute(&recording).unwrap();
        let arrives = store.resolution(&volume).unwrap().arriving;
        let (shown, expected) = (film(&mut gpu, &cache), if arrives { &of_means } else { &of_voxels });
        let (far, _) = difference(&shown, expected);
        assert!(far < 0.02, "frame {frames} differs in {far} of its numbers");
        frames += 1;
    }
    assert!(frames > 5, "{frames} frames");
}

#[test]
fn prepared_pipelines_are_not_waited_for() {
    let mut gpu = gpu();
    let test = scenes::surface_reflection();
    let mut cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
    let kernels = cache.kernels(&test.scene, ViewKind::Still { guides: true });
    gpu.executor.prepare(kernels.iter().copied());
    while !gpu.executor.is_prepared(kernels.iter().copied()) {
        std::thread::yield_now();
    }
    let waits = gpu.executor.pipeline_waits();
    let mut recording = Recording::new();
    cache.update(&test.scene, &mut recording).unwrap();
    let settings = ViewSettings::new(8, 8).with(|it| it.guides = true);
    let mut view = View::new(settings, &cache, &mut recording).unwrap();
    view.record_samples(&cache, &test.camera, 1, u64::MAX, &mut recording);
    view.record_display(&cache, &Default::default(), &mut recording);
    gpu.executor.execute(&recording).unwrap();
    assert_eq!(gpu.executor.pipeline_waits(), waits);
}
