//! Majorants bound every interpolated sample, for transfer functions of any shape, and are tight.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::medium::{MAX_DENSITY_SCALE, SIGMA_UNIT_PER_MM};
use lumivox_core::{
    Ease, Environment, Filter, LabelStyle, LabelVolume, Medium, Modality, PerspectiveCamera, Scene,
    TransferFunction, Volume, VolumeInstance, Voxels,
};
use lumivox_reference::medium::PlacedMedium;
use lumivox_reference::rng::Rng;
use lumivox_renderer::{CellSize, Recording, SceneCache, Step, VoxelStore};
use lumivox_shaders::constants::CLASS_IS_WHOLE;
use lumivox_testing::scenes::{self, TestScene, noise_volume};
use lumivox_wgpu::{Gpu, RenderRequest};

use crate::{film, gpu};

/// Majorants of a scene, as the GPU makes them of an update at once, volume by volume, x fastest.
fn majorants(scene: &Scene, cell_size: usize) -> Vec<f32> {
    let mut gpu = gpu();
    let mut cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
    cache.set_cell_size(CellSize::Of(cell_size));
    let mut recording = Recording::new();
    cache.update(scene, &mut recording).unwrap();
    read_majorants(&mut gpu, &cache, recording)
}

/// Those that a cache holds after a recording.
fn read_majorants(gpu: &mut Gpu, cache: &SceneCache, recording: Recording) -> Vec<f32> {
    read_cells(gpu, cache, recording).iter().map(|cell| cell.majorant).collect()
}

/// What a cell says of its points.
struct Cell {
    majorant: f32,
    /// Whether nothing is taken off one by one.
    is_whole: bool,
    /// Whether they have one look.
    has_one_look: bool,
}

/// The cells that a cache holds after a recording.
fn read_cells(gpu: &mut Gpu, cache: &SceneCache, mut recording: Recording) -> Vec<Cell> {
    let (id, cells) = cache.majorants();
    recording.push(Step::ReadBuffer { id, range: 0..cells as u64 * 8 });
    let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
    let of = |cell: &[u8]| {
        let [first, second]: [u32; 2] = bytemuck::pod_read_unaligned(cell);
        // The upper half of a word, beside its page; in place of a 0, how far the next one is that is none.
        let majorant = Some(f32::from_bits(first & 0xffff_0000)).filter(|m| m.is_normal()).unwrap_or(0.0);
        let class = second >> 26;
        Cell { majorant, is_whole: class & CLASS_IS_WHOLE != 0, has_one_look: class & !CLASS_IS_WHOLE != 0 }
    };
    bytes.chunks_exact(8).map(of).collect()
}

fn random_volume(rng: &mut Rng, kind: usize) -> Volume {
    let dims = std::array::from_fn(|_| 5 + (rng.uniform() * 25.0) as usize);
    let n = dims.iter().product();
    let voxels = match kind {
        0 => Voxels::U8((0..n).map(|_| (rng.uniform() * 256.0) as u8).collect()),
        1 => Voxels::U16((0..n).map(|_| 30_000 + (rng.uniform() * 4000.0) as u16).collect()),
        _ => Voxels::F32((0..n).map(|_| (rng.uniform() * 3.0 - 1.0) as f32).collect()),
    };
    // A negative slope turns the order of stored values around.
    let rescale = [[1.0, 0.0], [1.0, -32_000.0], [-500.0, 100.0]][kind];
    Volume::new(dims, voxels, rescale, DAffine3::IDENTITY, Modality::Other).unwrap()
}

/// Peaks, notches, jumps: anything but monotone.
fn random_function(rng: &mut Rng, range: [f64; 2]) -> TransferFunction {
    let mut value = || range[0] + (range[1] - range[0]) * (rng.uniform() * 1.2 - 0.1);
    let values: Vec<f64> = (0..9).map(|_| value()).collect();
    let knots: Vec<(f64, f64)> =
        values.iter().enumerate().map(|(i, &v)| (v, if i % 2 == 0 { 0.0 } else { rng.uniform() })).collect();
    // And now and then a step, at the first point or within.
    let mut knots = knots;
    if rng.uniform() < 0.5 {
        let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
        knots.push((if rng.uniform() < 0.5 { lowest } else { values[1] }, 1.0));
    }
    TransferFunction::from_points(Ease::InOut, &knots, &[(0.0, [1.0; 3])]).unwrap()
}

#[test]
fn majorants_bound_every_interpolated_sample_and_are_tight() {
    let mut rng = Rng::new(11, 0, 0);
    let (mut samples, mut used, mut bound) = (0, 0.0, 0.0);
    for case in 0..24 {
        let volume = random_volume(&mut rng, case % 3);
        let function = random_function(&mut rng, volume.value_range());
        let filter = [Filter::Nearest, Filter::Trilinear, Filter::Tricubic][case / 3 % 3];
        let medium = Medium { filter, ..Medium::new(function) };
        let cell_size = [2, 4, 8][case / 9];
        let volume = Arc::new(volume);
        let mut scene = Scene::with_volume(volume.clone(), medium);
        scene.environment = Environment::uniform(1.0);
        let majorants = majorants(&scene, cell_size);
        let cells = volume.dims().map(|n| (n - 1) / cell_size + 2);
        assert_eq!(majorants.len(), cells.iter().product::<usize>());
        let placed = PlacedMedium::new(&scene.volumes[0]).unwrap();
        let mut largest = vec![0.0f64; majorants.len()];
        for _ in 0..20_000 {
            let p: [f64; 3] = std::array::from_fn(|a| rng.uniform() * volume.dims()[a] as f64);
            // The first cell begins one before the centre of the first voxel.
            let cell =
                std::array::from_fn::<_, 3, _>(|a| (p[a] - 0.5 + cell_size as f64) as usize / cell_size);
            let index = (cell[2] * cells[1] + cell[1]) * cells[0] + cell[0];
            let value = placed.value_at_voxel(DVec3::from_array(p) - 0.5);
            let opacity = scene.volumes[0].medium.transfer_function.opacity(value);
            // A jump is spread over one of 4095 table entries, and the table is linear between curve points.
            assert!(
                opacity <= f64::from(majorants[index]) + 2e-3,
                "case {case}: {opacity} at {p:?} exceeds {}",
                majorants[index]
            );
            largest[index] = largest[index].max(opacity);
            samples += 1;
        }
        used += largest.iter().sum::<f64>();
        bound += majorants.iter().map(|&m| f64::from(m)).sum::<f64>();
    }
    println!("{samples} samples; the largest of a cell is on average {:.3} of its majorant", used / bound);
    assert!(used / bound > 0.6, "majorants are loose: {used} of {bound}");
}

/// Labels, turned shapes, peeling by depths of another grid: what a cell says holds for all its points, and most of those
/// that it could be said of are told.
#[test]
fn what_a_cell_says_of_its_points_holds_for_all_of_them() {
    let mut rng = Rng::new(17, 0, 0);
    let all_clipped = {
        let mut scene = scenes::clip_shapes();
        scene.scene.volumes[0].labels.as_mut().unwrap().set_style(5, LabelStyle::default());
        scene
    };
    let named =
        [("labels", scenes::labels()), ("one label is not cut", scenes::clip_shapes()), ("cut", all_clipped)];
    for (name, TestScene { mut scene, .. }) in named {
        scene.volumes.truncate(1);
        let instance = &scene.volumes[0];
        let labelling = instance.labels.as_ref().unwrap();
        let cut_all = (0..=u8::MAX).all(|label| labelling.style(label).clipped);
        let placed = PlacedMedium::new(instance).unwrap();
        // Rays are clipped against what keeps one part of them: what is left to ask for is the rest.
        let mut less = instance.clone();
        less.peel = None;
        less.clip_shapes.retain(|shape| cut_all && !shape.inverted);
        let less = PlacedMedium::new(&less).unwrap();
        let dims = instance.volume.dims();
        let world_from_voxel = instance.world_from_patient * instance.volume.patient_from_voxel();
        let labels_from_voxel =
            labelling.labels.patient_from_voxel().inverse() * instance.volume.patient_from_voxel();
        for cell_size in [2, 4] {
            let read = {
                let mut gpu = gpu();
                let mut cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
                cache.set_cell_size(CellSize::Of(cell_size));
                let mut recording = Recording::new();
                cache.update(&scene, &mut recording).unwrap();
                read_cells(&mut gpu, &cache, recording)
            };
            let cells = dims.map(|n| (n - 1) / cell_size + 2);
            let most_per_mm = placed.medium().density_scale * SIGMA_UNIT_PER_MM;
            let (mut of_one, mut told, mut empty) = (0, 0, 0);
            for _ in 0..20_000 {
                let p = DVec3::from_array(std::array::from_fn(|a| rng.uniform() * dims[a] as f64)) - 0.5;
                let cell = ((p + cell_size as f64) / cell_size as f64).floor().to_array().map(|c| c as usize);
                let cell = &read[(cell[2] * cells[1] + cell[1]) * cells[0] + cell[0]];
                let point = world_from_voxel.transform_point3(p);
                let sigma_t = placed.sigma_t_per_mm(point);
                let bound = most_per_mm * f64::from(cell.majorant);
                assert!(
                    sigma_t <= bound * 1.01 + 2e-3 * most_per_mm,
                    "{name}: {sigma_t} at {p} exceeds {bound}"
                );
                let whole = less.sigma_t_per_mm(point);
                let is_whole = (sigma_t - whole).abs() <= 1e-9 * whole;
                assert!(
                    is_whole || !cell.is_whole,
                    "{name}: {sigma_t} of {whole} is left at {p} of a whole cell"
                );
                let looks = drawn(&labelling.labels, labels_from_voxel.transform_point3(p));
                let first = labelling.style(looks[0]);
                let is_of_one = looks.iter().all(|label| labelling.style(*label) == first);
                assert!(is_of_one || !cell.has_one_look, "{name}: {looks:?} at {p} in a cell of one look");
                of_one += u32::from(is_of_one && first.visible);
                told += u32::from(cell.has_one_look);
                empty += u32::from(cell.majorant == 0.0 && whole > 0.0);
            }
            println!("{name}, {cell_size}: {of_one} points of one look, told of {told}; {empty} cut away");
            assert!(told * 10 > of_one, "{told} of {of_one}");
            assert!(empty > 0 || name == "labels", "{name}: cells that are cut away are empty");
        }
    }
}

/// The labels that may be drawn at a point of their voxel space.
fn drawn(labels: &LabelVolume, p: DVec3) -> Vec<u8> {
    let last = DVec3::from_array(labels.dims().map(|n| n as f64)) - 1.0;
    if p.cmplt(DVec3::splat(-0.5)).any() || p.cmpge(last + 0.5).any() {
        return vec![0];
    }
    let tap = |i: usize| {
        let at = p.floor() + DVec3::from_array([i % 4, i / 4 % 4, i / 16].map(|x| x as f64 - 1.0));
        labels.value(at.clamp(DVec3::ZERO, last).to_array().map(|x| x as usize))
    };
    (0..64).map(tap).collect()
}

/// Between the grids of two opaque volumes that no ray meets lies that of an empty one that every ray meets before it
/// sees anything, and leaves by a face beyond which the neighbours' majorants lie. A walk that read one of those would
/// collide there, for nothing but random numbers: the film would be another than beside empty volumes.
#[test]
fn walks_stay_within_their_volumes_majorants() {
    let volume = noise_volume(5, [64; 3]);
    let look = |opacity: f64| {
        let function = TransferFunction::from_points(Ease::Linear, &[(0.0, opacity)], &[(0.0, [1.0; 3])]);
        // However short the way through a foreign cell is, something happens there.
        Medium { albedo: 0.0, density_scale: MAX_DENSITY_SCALE, ..Medium::new(function.unwrap()) }
    };
    let at = |z: f64, opacity: f64| {
        let mut instance = VolumeInstance::centered(volume.clone(), look(opacity));
        let turn = DMat3::from_rotation_y(0.3 + z) * DMat3::from_rotation_x(1.8);
        let place = DAffine3::from_mat3_translation(turn, DVec3::new(0.0, 0.0, z));
        instance.world_from_patient = place * instance.world_from_patient;
        instance
    };
    let film_beside = |opacity: f64| {
        let volumes = vec![at(50.0, opacity), at(0.0, 0.0), at(60.0, opacity), at(-0.2, 2e-5)];
        let scene = Scene { volumes, environment: Environment::uniform(1.0), lights: vec![] };
        let camera = PerspectiveCamera::look_at(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, DVec3::Y, 0.03);
        film(&TestScene { name: "beside", scene, camera }, &RenderRequest::new(96, 96, 8))
    };
    let (beside_opaque, beside_empty) = (film_beside(1.0), film_beside(0.0));
    let pixels = 0..96 * 96;
    assert!(
        pixels.clone().filter(|&i| beside_empty.alpha(i) > 0.0).count() > 5000,
        "there is nothing to see"
    );
    let other = pixels.filter(|&i| beside_opaque.alpha(i) != beside_empty.alpha(i)).count();
    assert_eq!(other, 0, "pixels that saw other volumes' majorants");
}

/// A volume that is too large to come in one piece, several bricks deep: some few voxels of a cell decide its range.
fn deep_volume(rng: &mut Rng) -> Arc<Volume> {
    let dims = [70, 66, 500];
    let mut sample = || match rng.uniform() {
        spike if spike < 0.005 => (spike / 0.005 * 40_000.0) as u16,
        _ => 20_000,
    };
    let samples = (0..dims.iter().product()).map(|_| sample()).collect();
    let volume = Volume::new(dims, Voxels::U16(samples), [1.0, 0.0], DAffine3::IDENTITY, Modality::Other);
    Arc::new(volume.unwrap())
}

#[test]
fn majorants_of_volumes_that_arrive_are_those_of_volumes_that_came_at_once() {
    let mut rng = Rng::new(12, 0, 0);
    let volumes = [deep_volume(&mut rng), deep_volume(&mut rng)];
    // One falls and one rises, so that the smallest value of each cell counts as well as the largest.
    let looks = [[1.0, 0.0], [0.0, 1.0]].map(|[low, high]| {
        TransferFunction::from_points(Ease::Linear, &[(0.0, low), (4e4, high)], &[(0.0, [1.0; 3])]).unwrap()
    });
    for (filter, cell_size, budget) in [
        (Filter::Trilinear, 8, 1 << 20),
        (Filter::Trilinear, 4, 200 << 10),
        (Filter::Trilinear, 16, 3 << 20),
        (Filter::Tricubic, 2, 1 << 20),
        (Filter::Smooth, 8, 700 << 10),
    ] {
        let place = |(volume, look): (&Arc<Volume>, &TransferFunction)| {
            VolumeInstance::centered(volume.clone(), Medium { filter, ..Medium::new(look.clone()) })
        };
        let volumes = volumes.iter().zip(&looks).map(place).collect();
        let scene = Scene { volumes, environment: Environment::uniform(1.0), lights: vec![] };
        let mut gpu = gpu();
        let mut cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
        cache.set_cell_size(CellSize::Of(cell_size));
        let mut updates = 0;
        while !cache.is_settled() {
            let mut recording = Recording::new();
            cache.update_within(&scene, &mut { budget }, &mut recording).unwrap();
            gpu.executor.execute(&recording).unwrap();
            updates += 1;
        }
        assert!(updates > 3, "they arrive");
        let arrived = read_majorants(&mut gpu, &cache, Recording::new());
        // One test has the GPU at a time.
        drop(gpu);
        let at_once = majorants(&scene, cell_size);
        assert_eq!(arrived.len(), at_once.len());
        let other = arrived.iter().zip(&at_once).filter(|(a, b)| a != b).count();
        assert_eq!(other, 0, "of {}, {filter:?}, cells of {cell_size}, {updates} updates", at_once.len());
    }
}
