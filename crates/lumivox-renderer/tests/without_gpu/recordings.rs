//! What is recorded, seen without a GPU: only what changed, in an order that makes sense, and nothing after an error.

use std::collections::HashSet;
use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    ClipShape, EnvironmentMap, EnvironmentSource, Falloff, Filter, Lamp, Light, Scene, TransferFunction,
};
use lumivox_renderer::{
    DisplaySettings, FilmCount, HostDepth, HostFrame, LiveSettings, LiveView, Recording, RenderError,
    ResourceId, SceneCache, Step, View, ViewSettings, VoxelStore,
};
use lumivox_shaders::{Kernel, layout};

use crate::scenes::*;

/// Records an update and checks that it makes sense on its own, given what exists.
fn update(cache: &mut SceneCache, scene: &Scene, alive: &mut HashSet<ResourceId>) -> Recording {
    let mut recording = Recording::new();
    cache.update(scene, &mut recording).unwrap();
    replay(&recording, alive);
    recording
}

fn texture_writes(recording: &Recording) -> usize {
    recording.steps.iter().filter(|s| matches!(s, Step::WriteTexture { .. })).count()
}

#[test]
fn an_unchanged_scene_records_nothing_and_a_moved_knob_little() {
    let mut alive = HashSet::new();
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut scene = scene(&[volume(16), volume(20)]);
    update(&mut cache, &scene, &mut alive);
    let version = cache.version();
    assert!(update(&mut cache, &scene, &mut alive).is_empty());
    assert_eq!(cache.version(), version);

    scene.volumes[1].medium.transfer_function = TransferFunction::constant(0.1, [0.5; 3]);
    let recording = update(&mut cache, &scene, &mut alive);
    assert_eq!(texture_writes(&recording), 0, "a knob does not upload voxels again");
    let dispatches = recording.steps.iter().filter(|s| matches!(s, Step::Dispatch { .. })).count();
    assert_eq!(dispatches, 4, "only the majorants of the instance that changed, and the way between them");
    assert_ne!(cache.version(), version);

    // What is no longer cut is another picture, though nothing has to be written for it.
    scene.volumes.truncate(1);
    update(&mut cache, &scene, &mut alive);
    for shapes in [vec![ClipShape::sphere(DVec3::ZERO, 1.0)], vec![]] {
        scene.volumes[0].clip_shapes = shapes;
        let version = cache.version();
        update(&mut cache, &scene, &mut alive);
        assert_ne!(cache.version(), version);
    }

    scene.volumes[0].world_from_patient = DAffine3::from_scale(DVec3::splat(2.0));
    let recording = update(&mut cache, &scene, &mut alive);
    assert!(matches!(recording.steps[..], [Step::WriteBuffer { .. }]), "{:?}", recording.steps);

    scene.volumes[0].medium.filter = Filter::Tricubic;
    assert_eq!(texture_writes(&update(&mut cache, &scene, &mut alive)), 0, "a filter needs no voxels again");

    scene.volumes.pop();
    update(&mut cache, &scene, &mut alive);
    let mut recording = Recording::new();
    let store = cache.store().clone();
    cache.free(&mut recording);
    store.free(&mut recording);
    replay(&recording, &mut alive);
    assert!(alive.is_empty(), "{alive:?} leak");
}

#[test]
fn a_changed_light_writes_the_lights_and_nothing_else() {
    let mut alive = HashSet::new();
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut scene = scene(&[volume(16)]);
    scene.lights = vec![
        Light::directional(DVec3::NEG_Y, [1.0; 3]),
        Light::point(Lamp::new(DVec3::X, [1.0; 3])),
        Light::directional(DVec3::NAN, [1.0; 3]),
    ];
    let recording = update(&mut cache, &scene, &mut alive);
    let tables = recording.steps.iter().find_map(|step| match step {
        Step::CreateBuffer { id, label: "tables", .. } => Some(*id),
        _ => None,
    });
    assert!(update(&mut cache, &scene, &mut alive).is_empty(), "a NaN is no change");

    let mut version = cache.version();
    let mut changed =
        |cache: &SceneCache| std::mem::replace(&mut version, cache.version()) != cache.version();
    scene.lights[1] = Light::point(Lamp::new(DVec3::Y, [1.0; 3]));
    let recording = update(&mut cache, &scene, &mut alive);
    let [Step::WriteBuffer { id, data, .. }] = &recording.steps[..] else { panic!("{:?}", recording.steps) };
    assert_eq!((Some(*id), data.bytes().len()), (tables, 2 * 64), "the lights there are");
    assert!(changed(&cache));

    scene.lights[0].layers = 2;
    let recording = update(&mut cache, &scene, &mut alive);
    let [Step::WriteBuffer { id, data, .. }] = &recording.steps[..] else { panic!("{:?}", recording.steps) };
    assert_eq!((Some(*id), data.bytes().len()), (tables, 64), "the light that is left");
    assert!(changed(&cache), "one light less");

    scene.lights[0] = Light { layers: 4, ..Light::directional(DVec3::X, [5.0; 3]) };
    assert!(update(&mut cache, &scene, &mut alive).is_empty(), "nothing is on that layer");
    assert!(!changed(&cache));

    scene.volumes[0].layers = 1 | 4;
    assert_eq!(texture_writes(&update(&mut cache, &scene, &mut alive)), 0);
    assert!(changed(&cache));
    let mut recording = Recording::new();
    let store = cache.store().clone();
    cache.free(&mut recording);
    store.free(&mut recording);
    replay(&recording, &mut alive);
    assert!(alive.is_empty(), "{alive:?} leak");
}

/// A lamp whose range ends before the volumes is not there, whatever it does.
#[test]
fn a_light_that_reaches_no_volume_changes_nothing() {
    let mut alive = HashSet::new();
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    // The volume is 16 mm wide, about the origin.
    let mut scene = scene(&[volume(16)]);
    let lamp = |x: f64, range: f64, brightness: f64| Lamp {
        falloff: Falloff::Power { range, decay: 2.0 },
        ..Lamp::new(DVec3::X * x, [brightness; 3])
    };
    let near = Light::point(lamp(0.1, f64::INFINITY, 1.0));
    let spot = |lamp| Light::spot(lamp, DVec3::NEG_X, 0.5);
    scene.lights = vec![near];
    update(&mut cache, &scene, &mut alive);
    let version = cache.version();
    for brightness in [0.3, 0.0, 0.7] {
        scene.lights =
            vec![Light::point(lamp(5.0, 4.9, brightness)), near, spot(lamp(-5.0, 4.9, 2.0 * brightness))];
        assert!(update(&mut cache, &scene, &mut alive).is_empty(), "a lamp of {brightness} out of reach");
        assert_eq!(cache.version(), version);
    }
    let mut version = version;
    for light in [
        Light::point(lamp(5.0, 5.1, 1.0)),
        spot(lamp(5.0, 5.1, 1.0)),
        Light::point(lamp(5.0, f64::INFINITY, 1.0)),
        Light::directional(DVec3::X, [1.0; 3]),
    ] {
        scene.lights = vec![near, light];
        update(&mut cache, &scene, &mut alive);
        assert_ne!(std::mem::replace(&mut version, cache.version()), cache.version(), "{light:?} reaches it");
    }
    // Only what the light's layers hold counts, and only what is kept of it.
    scene.volumes.push(instance(&volume(16)));
    scene.volumes[1].world_from_patient.translation.x += 5.0;
    scene.volumes[1].layers = 2;
    let beside = |layers| Light { layers, ..Light::point(lamp(5.1, 0.2, 1.0)) };
    scene.lights = vec![near, beside(1)];
    update(&mut cache, &scene, &mut alive);
    let version = cache.version();
    scene.lights = vec![near];
    update(&mut cache, &scene, &mut alive);
    assert_eq!(cache.version(), version, "it shines on another layer");
    scene.lights = vec![near, beside(2)];
    update(&mut cache, &scene, &mut alive);
    assert_ne!(cache.version(), version);
}

#[test]
fn a_scene_that_does_not_fit_changes_nothing() {
    let mut alive = HashSet::new();
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let small = scene(&[volume(16)]);
    update(&mut cache, &small, &mut alive);
    let version = cache.version();

    let mut lit = small.clone();
    let texels = vec![[1.0; 3]; 2000];
    lit.environment.source = EnvironmentSource::Map(Arc::new(EnvironmentMap::new(2000, 1, texels).unwrap()));
    lit.volumes.push(instance(&volume(12)));
    let mut many_lights = small.clone();
    many_lights.lights = vec![Light::directional(DVec3::X, [1.0; 3]); (4 << 20) / 64 + 1];
    let many_volumes = scene(&(0..80).map(|_| volume(8)).collect::<Vec<_>>());
    let cases = [many_volumes, lit, many_lights];
    for case in cases {
        let mut recording = Recording::new();
        let error = cache.update(&case, &mut recording).unwrap_err();
        assert!(recording.is_empty(), "{error}: nothing is recorded");
        assert_eq!(cache.version(), version);
        assert!(update(&mut cache, &small, &mut alive).is_empty(), "{error}: the old scene is still there");
    }
}

#[test]
fn volumes_that_are_flattened_are_left_out() {
    let mut alive = HashSet::new();
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut scene = scene(&vec![volume(8); 5]);
    scene.volumes[0].world_from_patient = DAffine3::from_scale(DVec3::ZERO);
    scene.volumes[1].world_from_patient.translation.x = f64::NAN;
    // Numbers of 32 bits, and the squares of them, would be infinite.
    scene.volumes[2].world_from_patient.matrix3.x_axis.x = 1e30;
    scene.volumes[3].world_from_patient = DAffine3::from_scale(DVec3::splat(1e-30));
    scene.volumes[4].world_from_patient.translation.y = 1e40;
    update(&mut cache, &scene, &mut alive);
    assert_eq!(cache.majorants().1, 0);
}

/// 32 bits tell a tenth of a voxel apart near the origin, and no voxels at all as far away as one of the volumes is.
#[test]
fn a_volume_that_is_far_away_leaves_the_others_their_precision() {
    for far in [DVec3::X * 1e9, DVec3::new(-1e12, 0.0, 1e12)] {
        let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
        let mut scene = scene(&vec![volume(8); 2]);
        scene.volumes[1].world_from_patient.translation += far;
        let mut recording = Recording::new();
        cache.update(&scene, &mut recording).unwrap();
        let instances = recording.steps.iter().find_map(|step| match step {
            Step::WriteBuffer { data, .. } if data.bytes().len() == 2 * size_of::<layout::Instance>() => {
                Some(bytemuck::pod_collect_to_vec::<u8, layout::Instance>(data.bytes()))
            }
            _ => None,
        });
        let near = instances.expect("two instances")[0].voxel_from_world;
        assert!(near.iter().all(|row| row[3].abs() < 100.0), "{near:?}");
    }
}

#[test]
fn a_view_starts_over_for_another_scene_and_frees_what_it_made() {
    let mut alive = HashSet::new();
    let (mut first, mut second) =
        (SceneCache::new(&VoxelStore::new(LIMITS)), SceneCache::new(&VoxelStore::new(LIMITS)));
    update(&mut first, &scene(&[volume(8)]), &mut alive);
    update(&mut second, &scene(&[volume(8)]), &mut alive);
    let mut recording = Recording::new();
    let mut view = View::new(ViewSettings::new(10, 10), &first, &mut recording).unwrap();
    assert_eq!(view.record_samples(&first, &camera(), 3, u64::MAX, &mut recording), 300);
    assert_eq!(view.record_samples(&first, &camera(), 3, u64::MAX, &mut recording), 0);
    assert_eq!(view.record_samples(&second, &camera(), 2, u64::MAX, &mut recording), 200);
    view.record_display(&second, &DisplaySettings::default(), &mut recording);
    view.free(&mut recording);
    let before = alive.clone();
    replay(&recording, &mut alive);
    assert_eq!(alive, before);
}

#[test]
fn invocations_share_the_pixels_of_a_small_image() {
    let limits = LIMITS.with(|it| it.max_storage_binding = 1 << 30);
    let mut cache = SceneCache::new(&VoxelStore::new(limits));
    let mut recording = Recording::new();
    cache.update(&scene(&[volume(8)]), &mut recording).unwrap();
    // Width, guides, samples that a submission has time for: samples of the first pass, sharers.
    let cases = [
        ([100, 100], false, u64::MAX, (512, 8)),
        ([100, 100], false, 40 * 10_000, (40, 2)),
        ([100, 100], false, 15 * 10_000, (15, 1)),
        ([100, 100], true, u64::MAX, (64, 1)),
        ([700, 700], false, u64::MAX, (128, 2)),
        ([1920, 1080], false, u64::MAX, (64, 1)),
    ];
    for ([width, height], guides, budget, expected) in cases {
        let settings = ViewSettings::new(width, height).with(|it| it.guides = guides);
        let mut view = View::new(settings, &cache, &mut recording).unwrap();
        let mut traced = Recording::new();
        view.record_samples(&cache, &camera(), 1000, budget, &mut traced);
        let Some(Step::Dispatch { uniforms, workgroups, .. }) = traced.steps.first() else {
            panic!("nothing")
        };
        let frame: layout::Frame = bytemuck::pod_read_unaligned(&uniforms[0]);
        assert_eq!((frame.sample_limit, frame.sharers), expected, "{width} {guides} {budget}");
        assert_eq!(*workgroups, [(width * frame.sharers).div_ceil(8), height.div_ceil(8)]);
    }
}

/// Where a film begins behind another's samples, and has passes of a fixed number, no budget changes what is added up.
#[test]
fn a_view_goes_on_behind_anothers_samples_in_passes_of_its_own() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut recording = Recording::new();
    cache.update(&scene(&[volume(8)]), &mut recording).unwrap();
    let settings = ViewSettings::new(8, 8).with(|it| {
        it.first_sample = 32;
        it.pass_samples = std::num::NonZeroU32::new(16);
        it.window_size = [8, 4];
    });
    for budget in [1, 8 * 16, u64::MAX] {
        let mut begun = Recording::new();
        let mut view = View::new(settings, &cache, &mut begun).unwrap();
        let Some(Step::WriteBuffer { offset, data, .. }) = begun.steps.last() else { panic!("no counts") };
        assert_eq!(*offset, 8 * 4 * 16, "the plane of the counts");
        let counts: Vec<f32> = data.bytes().chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
        assert_eq!(counts.len(), 8 * 4 * 4);
        assert!(counts.chunks_exact(4).all(|count| count == [0.0, 0.0, 32.0, 0.0]));
        assert_eq!(view.samples(), 32);
        let mut limits = vec![];
        loop {
            let mut traced = Recording::new();
            if view.record_samples(&cache, &camera(), 72, budget, &mut traced) == 0 {
                break;
            }
            for step in &traced.steps {
                let Step::Dispatch { uniforms, .. } = step else { panic!("{step:?}") };
                let frame: layout::Frame = bytemuck::pod_read_unaligned(&uniforms[0]);
                limits.push(frame.sample_limit);
                assert_eq!(frame.sharers, 1, "as the image has, however small the window is");
            }
        }
        limits.dedup();
        assert_eq!(limits, [48, 64, 72], "budget {budget}");
        assert_eq!(view.samples(), 72);
    }
}

/// A film that holds less than was asked for is traced again, once; what a driver keeps cutting short is said.
#[test]
fn what_a_film_lacks_is_traced_again_or_said() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let mut recording = Recording::new();
    cache.update(&scene(&[volume(8)]), &mut recording).unwrap();
    let mut view = View::new(ViewSettings::new(10, 10), &cache, &mut recording).unwrap();
    view.record_samples(&cache, &camera(), 3, u64::MAX, &mut recording);
    let count = |samples, short| {
        let count = FilmCount { samples, short, ..Default::default() };
        bytemuck::bytes_of(&count).to_vec()
    };
    view.counted(&count(3, 0)).unwrap();
    assert!(!view.record_missing(&cache, &mut recording), "nothing is missing");
    view.counted(&count(1, 7)).unwrap();
    let before = recording.steps.len();
    assert!(view.record_missing(&cache, &mut recording));
    assert!(recording.steps.len() > before);
    let error = view.counted(&count(1, 7)).unwrap_err();
    assert_eq!(error, RenderError::SamplesLost { pixels: 7 });
}

#[test]
fn a_film_that_is_too_large_names_the_limit() {
    let cache = SceneCache::new(&VoxelStore::new(LIMITS));
    let error = View::new(ViewSettings::new(4096, 4096), &cache, &mut Recording::new()).unwrap_err();
    assert!(matches!(error, RenderError::BufferTooLarge { what: "film", .. }), "{error}");
    assert!(View::new(ViewSettings::new(0, 5), &cache, &mut Recording::new()).is_err());
}

/// Kernels of a recording, by the first letters of their entry points.
fn kernels(recording: &Recording) -> String {
    recording
        .steps
        .iter()
        .filter_map(|step| match step {
            Step::Dispatch { kernel, .. } | Step::Draw { kernel, .. } => Some(kernel.entry_point()),
            _ => None,
        })
        .collect::<Vec<_>>()
        .join(" ")
}

/// With a coarse picture while something moves.
fn plain(size: u32) -> LiveSettings {
    LiveSettings::new(size, size).with(|it| it.kept_light = false)
}

#[test]
fn a_live_view_answers_at_once_and_keeps_to_its_budget() {
    let mut alive = HashSet::new();
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    update(&mut cache, &scene(&[volume(8)]), &mut alive);
    let [depth, color] = [ResourceId::external(), ResourceId::external()];
    alive.extend([depth, color]);
    let host = HostFrame::new(color).with_depth(HostDepth::new(depth, [0.0, 0.1, 1.0, 0.0], 0.0));
    let mut settings = plain(64).with(|it| it.target_samples = 4);
    let mut recording = Recording::new();
    let mut live = LiveView::new(&settings, &cache, &mut recording).unwrap();
    let mut frame = |live: &mut LiveView, settings: &LiveSettings, x: f64, budget, alive: &mut HashSet<_>| {
        let mut recording = std::mem::take(&mut recording);
        let mut camera = camera().with_aspect(1.0);
        camera.world_from_camera.translation.x = x;
        let status = live.record_frame(&cache, &camera, settings, &host, budget, &mut recording).unwrap();
        replay(&recording, alive);
        (status, kernels(&recording))
    };
    // A quarter of a sample per pixel: a coarse image of all of it, at once.
    let (status, steps) = frame(&mut live, &settings, 0.0, 1024, &mut alive);
    assert_eq!(
        steps,
        "host_depth host_depth path_trace denoise_prepare denoise_wavelet live_picture composite_color"
    );
    assert!(status.pixel_samples <= 1024 && !status.converged);
    // Then the fine one, a quarter a frame.
    let mut frames = 0;
    loop {
        let (status, _) = frame(&mut live, &settings, 0.0, 1024, &mut alive);
        assert!(status.pixel_samples <= 1024);
        frames += 1;
        if status.converged {
            break;
        }
    }
    assert_eq!(frames, 16);
    let (status, steps) = frame(&mut live, &settings, 0.0, 1024, &mut alive);
    assert_eq!(
        (status.pixel_samples, steps.matches("path_trace").count()),
        (0, 1),
        "only a look for pixels that started over"
    );

    // Ten pixels started over: the whole film is looked at again, at the cost of ten pixels.
    live.feedback(&10u32.to_le_bytes());
    let (status, _) = frame(&mut live, &settings, 0.0, 1024, &mut alive);
    assert_eq!((status.pixel_samples, status.converged), (40, true));

    // A budget that buys a fine image at once needs no coarse one.
    let (status, steps) = frame(&mut live, &settings, 0.1, 4 * 64 * 64, &mut alive);
    assert_eq!(
        (status.samples, steps),
        (4, "host_depth path_trace film_count live_picture composite_color".to_owned())
    );
    // Another size makes new films and frees the old.
    settings.size = [32, 16];
    frame(&mut live, &settings, 0.1, 1 << 20, &mut alive);
    let mut recording = Recording::new();
    live.free(&mut recording);
    replay(&recording, &mut alive);
    let mut rest = Recording::new();
    let store = cache.store().clone();
    cache.free(&mut rest);
    store.free(&mut rest);
    replay(&rest, &mut alive);
    assert_eq!(alive, HashSet::from([depth, color]));
}

#[test]
fn a_moving_live_view_does_not_jump_between_resolutions() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    cache.update(&scene(&[volume(8)]), &mut Recording::new()).unwrap();
    let host = HostFrame::new(ResourceId::external());
    let settings = plain(64);
    let mut live = LiveView::new(&settings, &cache, &mut Recording::new()).unwrap();
    let mut sizes = vec![];
    for (i, budget) in [2100, 2000, 2100, 2000, 2100, 5000].into_iter().enumerate() {
        let mut camera = camera().with_aspect(1.0);
        camera.world_from_camera.translation.x = i as f64;
        let mut recording = Recording::new();
        live.record_frame(&cache, &camera, &settings, &host, budget, &mut recording).unwrap();
        let trace = recording.steps.iter().find_map(|step| match step {
            Step::Dispatch { workgroups, .. } => Some(workgroups[1] * 8),
            _ => None,
        });
        sizes.push(trace.unwrap());
    }
    assert_eq!(sizes, [32, 16, 16, 16, 16, 32]);
}

/// What a frame may trace of pixels that have so many samples: not only what it says.
fn most_pixel_samples(recording: &Recording, have: u32) -> u64 {
    let mut most = 0;
    for step in &recording.steps {
        if let Step::Dispatch { kernel: Kernel::PathTrace(_), uniforms, .. } = step {
            let frame: layout::Frame = bytemuck::pod_read_unaligned(&uniforms[0]);
            // No pixel of a coarse film starts over here.
            let is_coarse = frame.film_size != [64, 64];
            let is_looked_at_only = frame.only_below > 0 && (is_coarse || have >= frame.only_below);
            let samples = frame.samples.min(frame.sample_limit.saturating_sub(have));
            let samples = if is_looked_at_only { 0 } else { samples };
            let rows = (frame.row_end - frame.row_begin).min(frame.film_size[1]);
            most += u64::from(samples) * u64::from(rows) * u64::from(frame.film_size[0]);
        }
    }
    most
}

/// Where a mesh moves before the image is done, or more samples are wanted after one moved.
#[test]
fn a_frame_keeps_to_its_budget_after_pixels_started_over() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    cache.update(&scene(&[volume(8)]), &mut Recording::new()).unwrap();
    let depth = HostDepth::new(ResourceId::external(), [0.0, 0.1, 1.0, 0.0], 0.0);
    let host = HostFrame::new(ResourceId::external()).with_depth(depth);
    let mut settings = plain(64).with(|it| it.target_samples = 256);
    let mut live = LiveView::new(&settings, &cache, &mut Recording::new()).unwrap();
    let frame = |live: &mut LiveView, settings: &LiveSettings, budget| {
        let mut recording = Recording::new();
        let camera = camera().with_aspect(1.0);
        let status = live.record_frame(&cache, &camera, settings, &host, budget, &mut recording).unwrap();
        (status, recording)
    };
    // A quarter of a sample a frame, until all have one; the coarse frame comes first.
    while frame(&mut live, &settings, 1024).0.samples < 1 {}
    let (_, recording) = frame(&mut live, &settings, 1024);
    assert!(most_pixel_samples(&recording, 1) <= 1024, "when the first image is whole");
    while frame(&mut live, &settings, 1024).0.samples < 3 {}
    live.feedback(&10u32.to_le_bytes());
    for _ in 0..4 {
        let (_, recording) = frame(&mut live, &settings, 1024);
        assert!(most_pixel_samples(&recording, 3) <= 1024, "when pixels started over");
    }
    live.feedback(&[]);
    let (_, recording) = frame(&mut live, &settings, 1024);
    assert!(most_pixel_samples(&recording, 4) <= 1024, "when nobody knows which");

    settings.target_samples = 4;
    while !frame(&mut live, &settings, 1 << 20).0.converged {}
    live.feedback(&10u32.to_le_bytes());
    assert!(frame(&mut live, &settings, 1024).0.converged);
    settings.target_samples = 256;
    let (_, recording) = frame(&mut live, &settings, 1024);
    assert!(most_pixel_samples(&recording, 4) <= 1024, "when more samples are wanted");
}

/// Sharp rows in a coarse picture would wander through it.
#[test]
fn a_slow_first_image_is_shown_when_it_is_whole() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    cache.update(&scene(&[volume(8)]), &mut Recording::new()).unwrap();
    let host = HostFrame::new(ResourceId::external());
    let settings = plain(128).with(|it| it.target_samples = 64);
    let mut live = LiveView::new(&settings, &cache, &mut Recording::new()).unwrap();
    // Of 32 x 32 and of 128 x 128 pixels: the first is made in one frame, the second in many more.
    let budget = 2048;
    let (mut shown, mut coarse_samples) = (vec![], 0.0);
    for _ in 0..24 {
        let mut recording = Recording::new();
        live.record_frame(&cache, &camera().with_aspect(1.0), &settings, &host, budget, &mut recording)
            .unwrap();
        for step in &recording.steps {
            match step {
                Step::Dispatch { kernel: Kernel::PathTrace(_), uniforms, .. } => {
                    let frame: layout::Frame = bytemuck::pod_read_unaligned(&uniforms[0]);
                    // But for those that only look for pixels that started over.
                    if frame.film_size == [32, 32] && frame.samples == 1 {
                        coarse_samples += f64::from(frame.samples * (frame.row_end - frame.row_begin)) / 32.0;
                    }
                }
                Step::Dispatch { kernel: Kernel::LivePicture, uniforms, .. } => {
                    let params: layout::LivePictureParams = bytemuck::pod_read_unaligned(&uniforms[0]);
                    shown.push((params.first_size[0], params.second_size[0]));
                }
                _ => {}
            }
        }
    }
    // One of 64 x 64 comes in between.
    let better = shown.iter().position(|&sizes| sizes == (64, 0)).expect("the coarse image gets better");
    let whole = shown.iter().position(|&sizes| sizes == (128, 64)).expect("the fine image gets done");
    assert!((3..8).contains(&better) && (9..20).contains(&whole), "{better} and {whole} frames");
    assert!(shown[..better].iter().all(|&sizes| sizes == (32, 0)), "{shown:?}");
    assert!(shown[better..whole].iter().all(|&sizes| sizes == (64, 0)), "{shown:?}");
    assert!(shown[whole..].iter().all(|&sizes| sizes == (128, 64)), "{shown:?}");
    // Besides the two that all got at once.
    assert_eq!(coarse_samples, 2.0);
}

#[test]
fn a_live_view_refuses_what_it_cannot_show() {
    let mut cache = SceneCache::new(&VoxelStore::new(LIMITS));
    cache.update(&scene(&[volume(8)]), &mut Recording::new()).unwrap();
    let host = HostFrame::new(ResourceId::external());
    let settings = LiveSettings::new(64, 64);
    assert!(LiveView::new(&LiveSettings::new(0, 64), &cache, &mut Recording::new()).is_err());
    let mut live = LiveView::new(&settings, &cache, &mut Recording::new()).unwrap();
    let mut recording = Recording::new();
    let large = LiveSettings::new(4096, 4096);
    let good = camera().with_aspect(1.0);
    let mut blind = good;
    blind.world_from_camera.translation.y = f64::NAN;
    let error = live.record_frame(&cache, &good, &large, &host, 1, &mut recording).unwrap_err();
    assert!(matches!(error, RenderError::BufferTooLarge { .. }));
    let error = live.record_frame(&cache, &blind, &settings, &host, 1, &mut recording).unwrap_err();
    assert_eq!(error, RenderError::Camera);
    assert!(recording.is_empty());
    live.record_frame(&cache, &good, &settings, &host, 1, &mut recording).unwrap();
}
