//! What a change of a scene costs, seen without a GPU: only what changed is uploaded and computed, and what takes long
//! can be computed ahead, on another thread.

use std::sync::Arc;

use lumivox_core::glam::DVec3;
use lumivox_core::{
    Camera, ClipShape, Environment, EnvironmentMap, EnvironmentSource, Filter, GradientFunction, LabelStyle,
    LabelVolume, Labelling, Light, Peel, PerspectiveCamera, Scene, TransferFunction, Volume,
};
use lumivox_renderer::live::LiveImage;
use lumivox_renderer::recording::{Classes, Kernel};
use lumivox_renderer::{
    Features, HostFrame, LiveSettings, LiveView, Recording, ResourceId, SceneCache, Step, View, ViewKind,
    ViewSettings, VoxelStore, prepare_volume,
};
use lumivox_shaders::PathTraceVariant;

use crate::scenes::{self, *};

fn scene(volumes: &[Arc<Volume>]) -> Scene {
    Scene { environment: Environment::uniform(1.0), ..scenes::scene(volumes) }
}

fn map(brightness: f32) -> Environment {
    let texels = (0..128 * 64).map(|i| [brightness * i as f32, 1.0, 0.5]).collect();
    let map = EnvironmentMap::new(128, 64, texels).unwrap();
    Environment { source: EnvironmentSource::Map(Arc::new(map)), ..Environment::uniform(1.0) }
}

/// What a recording costs.
#[derive(Debug, Default, PartialEq)]
struct Cost {
    textures: usize,
    voxel_bytes: usize,
    /// To buffers.
    bytes: usize,
    value_ranges: usize,
    majorant_grids: usize,
    /// That are made.
    buffers: usize,
}

fn cost(cache: &mut SceneCache, scene: &Scene) -> Cost {
    let mut recording = Recording::new();
    cache.update(scene, &mut recording).unwrap();
    cost_of(&recording)
}

fn cost_of(recording: &Recording) -> Cost {
    let mut cost = Cost::default();
    for step in &recording.steps {
        match step {
            Step::CreateTexture { .. } => cost.textures += 1,
            // Those of the environment are flat.
            Step::WriteTexture { data, size, .. } if size[2] > 1 => cost.voxel_bytes += data.bytes().len(),
            Step::WriteBuffer { data, .. } => cost.bytes += data.bytes().len(),
            Step::CreateBuffer { .. } => cost.buffers += 1,
            Step::Dispatch { kernel: Kernel::MajorantGrid, .. } => cost.majorant_grids += 1,
            Step::Dispatch { kernel: Kernel::ValueRanges { .. }, .. } => cost.value_ranges += 1,
            _ => {}
        }
    }
    cost
}

/// Bytes of a transfer function's tables: opacity, colour, range maxima.
const TABLES: usize = 4096 * (8 + 16 + 13 * 4);

/// Bytes of an instance.
const INSTANCE: usize = size_of::<lumivox_shaders::layout::Instance>();

/// Bytes of a brick of 16-bit voxels, which is what small volumes take.
const BRICK: usize = 2 * 33 * 33 * 33;

/// Bytes that say where a brick is, for a kernel.
const PAGE: usize = 4;

/// Bytes of a style and of a set of labels, as the kernel that makes majorants reads them.
const STYLE: usize = 32 + 8;

#[test]
fn a_swapped_volume_uploads_itself_alone() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut scene = scene(&[volume(16), volume(20), volume(16)]);
    cost(&mut cache, &scene);

    scene.volumes[1].volume = volume(20);
    let swapped = cost(&mut cache, &scene);
    assert_eq!((swapped.textures, swapped.voxel_bytes), (0, BRICK));
    assert_eq!((swapped.value_ranges, swapped.majorant_grids), (1, 1));
    // With what knows it by another number.
    assert!(swapped.bytes <= TABLES + STYLE + 2 * PAGE + 3 * INSTANCE, "{swapped:?}");

    // A smaller one lies where the larger was, and so does the larger again.
    for size in [18, 20] {
        scene.volumes[1].volume = volume(size);
        let swapped = cost(&mut cache, &scene);
        assert_eq!((swapped.textures, swapped.voxel_bytes), (0, BRICK));
    }
    // One of eight bricks takes the one that is free, and a texture for the rest.
    scene.volumes[1].volume = volume(40);
    let swapped = cost(&mut cache, &scene);
    assert_eq!((swapped.textures, swapped.voxel_bytes), (1, 8 * BRICK));
}

#[test]
fn volumes_in_another_order_or_number_upload_no_voxels_again() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut scene = scene(&[volume(16), volume(20), volume(16)]);
    cost(&mut cache, &scene);
    scene.volumes.swap(0, 2);
    assert_eq!(cost(&mut cache, &scene).voxel_bytes, 0);
    let hidden = scene.volumes.pop().unwrap();
    assert_eq!(cost(&mut cache, &scene).voxel_bytes, 0);
    scene.volumes.push(hidden);
    assert_eq!(cost(&mut cache, &scene).voxel_bytes, 0, "who hid it held it");
    // But the memory of many is not kept for one.
    let store = cache.store().clone();
    let before = store.bytes();
    scene.volumes = vec![instance(&volume(8))];
    assert_eq!(cost(&mut cache, &scene).textures, 1);
    assert!(store.bytes() < before);
}

#[test]
fn what_one_scene_has_brought_another_finds() {
    let store = VoxelStore::new(LIMITS);
    let (mut first, mut second) = (SceneCache::new(&store), SceneCache::new(&store));
    let [a, b] = [volume(16), volume(40)];
    assert_eq!(cost(&mut first, &scene(&[a.clone(), b.clone()])).voxel_bytes, 9 * BRICK);
    let other = Scene { environment: map(1.0), ..scene(&[b.clone(), a.clone()]) };
    let found = cost(&mut second, &other);
    assert_eq!((found.voxel_bytes, found.value_ranges, found.majorant_grids), (0, 0, 2));

    // What a scene has shown stays as long as somebody holds the volume.
    let mut recording = Recording::new();
    first.free(&mut recording);
    second.free(&mut recording);
    store.collect(&mut recording);
    let mut third = SceneCache::new(&store);
    assert_eq!(cost(&mut third, &scene(std::slice::from_ref(&a))).voxel_bytes, 0);
    drop((a, b, other));
    third.free(&mut recording);
    store.collect(&mut recording);
    assert_eq!(store.bytes(), 0, "nobody holds them any more");
}

#[test]
fn a_swapped_preset_uploads_its_tables_alone() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut scene = scene(&[volume(72), volume(72)]);
    cost(&mut cache, &scene);
    for opacity in [0.1, 0.2] {
        scene.volumes[0].medium.transfer_function = TransferFunction::constant(opacity, [0.1; 3]);
        scene.volumes[0].medium.surface.strength = opacity;
        let cost = cost(&mut cache, &scene);
        assert_eq!((cost.textures, cost.voxel_bytes, cost.majorant_grids), (0, 0, 1));
        assert!(cost.bytes <= TABLES + 27 * PAGE + 2 * INSTANCE + STYLE, "{cost:?}");
    }
}

#[test]
fn a_filter_looks_at_its_own_volume_and_once() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut scene = scene(&[volume(72), volume(76)]);
    assert_eq!(cost(&mut cache, &scene).value_ranges, 2);
    for (filter, looks) in [(Filter::Tricubic, 1), (Filter::Trilinear, 0), (Filter::Tricubic, 0)] {
        scene.volumes[0].medium.filter = filter;
        let cost = cost(&mut cache, &scene);
        assert_eq!((cost.voxel_bytes, cost.majorant_grids), (0, 1), "{filter:?}");
        assert_eq!(cost.value_ranges, looks, "{filter:?}");
    }
    // Nor does another scene look at them again.
    let mut other = SceneCache::new(cache.store());
    assert_eq!(cost(&mut other, &scene).value_ranges, 0);
}

#[test]
fn what_is_prepared_is_not_computed_in_an_update() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut scene = Scene { environment: map(1.0), ..scene(&[volume(132), volume(136)]) };
    let preparation = cache.preparation(&scene).expect("nobody has looked at the volumes");
    std::thread::spawn(move || preparation.run()).join().unwrap();
    assert!(cache.preparation(&scene).is_none());
    cache.update_within(&scene, &mut 1000, &mut Recording::new()).unwrap();
    assert_eq!(cache.unprepared(), 0);

    // What was loaded with care needs nothing.
    let loaded = volume(140);
    prepare_volume(&loaded);
    scene.volumes[0].volume = loaded;
    assert!(cache.preparation(&scene).is_none());
    scene.environment = map(1.0);
    assert!(cache.preparation(&scene).is_none(), "an equal sky");
    scene.environment = map(2.0);
    assert!(cache.preparation(&scene).is_some(), "another sky");
    cache.update(&scene, &mut Recording::new()).unwrap();
    assert_eq!(cache.unprepared(), 1);
    // A small one is quicker looked at than handed over.
    scene.volumes[0].volume = volume(16);
    assert!(cache.preparation(&scene).is_none());
}

/// A scene that holds what `features` says.
fn scene_with(features: Features) -> Scene {
    let count = if features.many_volumes { 4 } else { 1 };
    let mut scene = scene(&vec![volume(8); count]);
    if features.environment {
        scene.environment = map(1.0);
    }
    if features.surface {
        scene.volumes[0].medium.surface.strength = 0.5;
    }
    if features.filters {
        scene.volumes[0].medium.filter = Filter::Nearest;
    }
    if features.lights {
        scene.lights = vec![Light::directional(DVec3::NEG_Y, [1.0; 3])];
    }
    let Classes { labels, functions, gradients, depth, clip_shapes, shares } = features.classes;
    let instance = &mut scene.volumes[0];
    let place = instance.volume.patient_from_voxel();
    if labels {
        let labels = LabelVolume::new([8; 3], vec![0; 512], place, vec![]).unwrap();
        instance.labels = Some(Labelling::new(Arc::new(labels)));
    }
    if functions && !gradients {
        let own = TransferFunction::constant(0.1, [0.5; 3]);
        let style = LabelStyle { transfer_function: Some(own), ..LabelStyle::default() };
        instance.labels.as_mut().unwrap().set_style(1, style);
    }
    if gradients {
        let transfer_function = instance.medium.transfer_function.clone();
        instance.medium.gradients = vec![GradientFunction { per_mm: 1.0, transfer_function }];
    }
    if depth {
        instance.peel = Some(Peel { depth: instance.volume.clone(), mm: 1.0 });
    }
    if clip_shapes {
        instance.clip_shapes = vec![ClipShape::sphere(DVec3::ZERO, 1.0)];
    }
    if shares && !functions && !depth {
        if let Some(labels) = &mut instance.labels {
            labels.set_style(1, LabelStyle { opacity: 0.5, ..LabelStyle::default() });
        } else {
            // Of rays it keeps two parts.
            instance.clip_shapes[0].inverted = true;
        }
    }
    scene
}

/// What majorants are made of stays on the device while a shape moves, and goes with the scene.
#[test]
fn a_shape_that_moves_uploads_what_it_is_like_alone() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let classes = Classes { labels: true, clip_shapes: true, ..Classes::NONE };
    let mut scene = scene_with(Features { classes, ..Features::default() });
    let mut held = vec![];
    let mut hold = |recording: &Recording| {
        for step in &recording.steps {
            match step {
                Step::CreateBuffer { id, label, .. }
                    if ["range maxima", "label sets", "pages", "looks", "distances"].contains(label) =>
                {
                    held.push(*id);
                }
                Step::Free { id } => held.retain(|other| other != id),
                _ => {}
            }
        }
        held.len()
    };
    let mut update = |scene: &Scene, cache: &mut SceneCache| {
        let mut recording = Recording::new();
        cache.update(scene, &mut recording).unwrap();
        (cost_of(&recording), hold(&recording))
    };
    assert_eq!(update(&scene, &mut cache).1, 5);
    for step in 1..3 {
        scene.volumes[0].clip_shapes = vec![ClipShape::sphere(DVec3::ZERO, 1.0 + f64::from(step))];
        let (moved, held) = update(&scene, &mut cache);
        assert_eq!((moved.majorant_grids, moved.buffers, held), (1, 0, 5));
        // The shape, for points and for cells, and the page.
        assert!(moved.bytes < 256, "{moved:?}");
    }
    // Another function, labels gone, the volume gone.
    scene.volumes[0].medium.transfer_function = TransferFunction::constant(0.2, [0.1; 3]);
    assert_eq!(update(&scene, &mut cache).1, 5);
    scene.volumes[0].labels = None;
    assert_eq!(update(&scene, &mut cache).1, 4);
    scene.volumes[0].clip_shapes.clear();
    assert_eq!(update(&scene, &mut cache).1, 0);
    scene.volumes[0].clip_shapes = vec![ClipShape::sphere(DVec3::ZERO, 1.0)];
    assert_eq!(update(&scene, &mut cache).1, 4);
    let mut recording = Recording::new();
    cache.free(&mut recording);
    assert_eq!(hold(&recording), 0);
}

fn kernels(recording: &Recording) -> Vec<Kernel> {
    let kernel = |step: &Step| match step {
        Step::Dispatch { kernel, .. } | Step::Draw { kernel, .. } => Some(*kernel),
        _ => None,
    };
    recording.steps.iter().filter_map(kernel).collect()
}

#[test]
fn the_kernels_of_a_scene_are_known_before_it_is_recorded() {
    let host = HostFrame::new(ResourceId::external());
    let mut seen = vec![];
    for features in Features::ALL.subsets() {
        let scene = scene_with(features);
        assert_eq!(Features::of(&scene), features);
        let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
        let live_kernels = cache.kernels(&scene, ViewKind::Live { guides: false, kept_light: false });
        let still_kernels = cache.kernels(&scene, ViewKind::Still { guides: true });
        assert_eq!(
            live_kernels,
            features.kernels(ViewKind::Live { guides: false, kept_light: false }, LIMITS)
        );

        let mut recording = Recording::new();
        cache.update(&scene, &mut recording).unwrap();
        let settings = LiveSettings::new(16, 16).with(|it| {
            it.denoise = true;
            it.kept_light = false;
        });
        let mut live = LiveView::new(&settings, &cache, &mut recording).unwrap();
        let camera_of_live: Camera = camera().with_aspect(1.0);
        live.record_frame(&cache, &camera_of_live, &settings, &host, 1024, &mut recording).unwrap();
        let recorded = kernels(&recording);
        assert!(recorded.iter().all(|kernel| live_kernels.contains(kernel)), "{recorded:?} {live_kernels:?}");
        seen.extend(recorded.into_iter().filter(|kernel| matches!(kernel, Kernel::PathTrace(_))));

        // With guides, in a coarse frame and a fine one.
        let with_guides = cache.kernels(&scene, ViewKind::Live { guides: true, kept_light: false });
        let mut recording = Recording::new();
        let settings = settings.with(|it| it.guides = true);
        for budget in [64, 1024] {
            live.record_frame(&cache, &camera_of_live, &settings, &host, budget, &mut recording).unwrap();
        }
        let recorded = kernels(&recording);
        assert!(recorded.iter().all(|kernel| with_guides.contains(kernel)), "{recorded:?} {with_guides:?}");
        let traces = |wanted: bool| {
            recorded
                .iter()
                .any(|kernel| matches!(kernel, Kernel::PathTrace(variant) if variant.guides == wanted))
        };
        assert!(traces(true) && traces(false), "the fine film alone has guides: {recorded:?}");

        // With kept light.
        let with_light = cache.kernels(&scene, ViewKind::Live { guides: false, kept_light: true });
        let mut recording = Recording::new();
        let settings = LiveSettings::new(16, 16);
        let mut live = LiveView::new(&settings, &cache, &mut recording).unwrap();
        // Of all pixels, and of few.
        for (budget, aspect) in [(1024, 1.0), (1024, 1.1), (64, 1.2), (64, 1.3)] {
            let seen: Camera = camera().with_aspect(aspect);
            live.record_frame(&cache, &seen, &settings, &host, budget, &mut recording).unwrap();
        }
        let recorded = kernels(&recording);
        assert!(recorded.iter().all(|kernel| with_light.contains(kernel)), "{recorded:?} {with_light:?}");
        let is_wanted = |kernel: &&Kernel| !live_kernels.contains(kernel);
        // Of few volumes, the picture of one is ready, too, or that of several.
        let is_other = |kernel: &&Kernel| matches!(kernel, Kernel::LightMarch(of) if of.several != features.many_volumes);
        let is_recorded = |kernel: &Kernel| recorded.contains(kernel);
        let wanted: Vec<_> = with_light.iter().filter(is_wanted).collect();
        assert_eq!(wanted.len(), if features.many_volumes { 8 } else { 9 });
        assert!(wanted.iter().all(|kernel| is_recorded(kernel) != is_other(kernel)), "{recorded:?}");

        let mut recording = Recording::new();
        let settings = ViewSettings::new(16, 16).with(|it| it.guides = true);
        let mut view = View::new(settings, &cache, &mut recording).unwrap();
        view.record_samples(&cache, &camera(), 1, u64::MAX, &mut recording);
        view.record_display(&cache, &Default::default(), &mut recording);
        let recorded = kernels(&recording);
        assert!(
            recorded.iter().all(|kernel| still_kernels.contains(kernel)),
            "{recorded:?} {still_kernels:?}"
        );
    }
    seen.dedup();
    assert_eq!(seen.len(), 32 * 23, "each has a kernel of its own");
    // Where few kernels should do, surfaces, lights and shared pixels make no others, nor does anything of what is classified,
    // nor the surroundings of what is filtered.
    let few = LIMITS.with(|it| it.few_kernels = true);
    for features in Features::ALL.subsets() {
        let can_more = features.classes.any();
        let more = Features {
            surface: true,
            lights: true,
            environment: features.environment || features.filters || can_more,
            filters: features.filters || can_more,
            many_volumes: features.many_volumes || can_more,
            classes: if can_more { Classes::ALL } else { Classes::NONE },
        };
        let live = [false, true].map(|guides| ViewKind::Live { guides, kept_light: guides });
        for view in live.into_iter().chain([ViewKind::Still { guides: true }]) {
            let mut wanted = more.kernels(view, LIMITS);
            if can_more {
                // Nor is light kept in what is classified.
                let of_light = |kernel: &Kernel| match kernel {
                    Kernel::PathTrace(variant) => variant.points,
                    Kernel::LightMarch(_) => true,
                    _ => kernel.name().starts_with("light_"),
                };
                wanted.retain(|kernel| !of_light(kernel));
            }
            if matches!(view, ViewKind::Live { .. }) {
                let can_be_shared = |v: &PathTraceVariant| !v.guides && !v.points;
                let is_alone =
                    |kernel: &Kernel| matches!(kernel, Kernel::PathTrace(v) if !v.shared && can_be_shared(v));
                wanted.retain(|kernel| !is_alone(kernel));
            }
            let made = features.kernels(view, few);
            assert_eq!(made.len(), wanted.len());
            assert!(wanted.iter().all(|kernel| made.contains(kernel)), "{made:?} {wanted:?}");
        }
    }
    let lights = Features { lights: true, ..Features::default() };
    assert_eq!(lights.subsets().count(), 2);
}

/// Of what is classified a package of few kernels has none for it: views go on without, and say nothing.
#[test]
fn where_few_kernels_should_do_light_is_kept_in_plain_media_alone() {
    let host = HostFrame::new(ResourceId::external());
    let classified = Features { classes: Classes::ALL, ..Features::default() };
    for few_kernels in [false, true] {
        let mut cache = SceneCache::new(&VoxelStore::new(LIMITS.with(|it| it.few_kernels = few_kernels)));
        let mut recording = Recording::new();
        let settings = LiveSettings::new(16, 16);
        let mut live = LiveView::new(&settings, &cache, &mut recording).unwrap();
        for (features, is_plain) in
            [(Features::default(), true), (classified, false), (Features::default(), true)]
        {
            let mut recording = Recording::new();
            cache.update(&scene_with(features), &mut recording).unwrap();
            for x in [0.0, 0.1] {
                let eye = DVec3::new(x, 0.0, 1.0);
                let camera = PerspectiveCamera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.5).with_aspect(1.0);
                live.record_frame(&cache, &camera, &settings, &host, 1024, &mut recording).unwrap();
            }
            let is_kept = is_plain || !few_kernels;
            assert_eq!(live.image(LiveImage::KeptLight).is_some(), is_kept, "{few_kernels} {features:?}");
            let marches = kernels(&recording).iter().any(|kernel| matches!(kernel, Kernel::LightMarch(_)));
            assert_eq!(marches, is_kept, "{few_kernels} {features:?}");
        }
    }
}
