//! What hosts do meanwhile: views of one world, windows that change, other cameras, fog, devices that get lost.

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Camera, Projection, Scene};
use lumivox_renderer::live::LiveImage;
use lumivox_renderer::{
    DeviceLimits, DistanceFog, Fog, HostFrame, LiveSettings, LiveView, LoopTurns, Recording, ResourceId,
    SceneCache, Step, VoxelStore,
};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::Gpu;

use super::{
    PIXELS, SIZE, around, brightness, error, luminance, mean, moving, orbit, settings, shown, still,
};
use crate::gpu;
use crate::live::{Host, NEAR};

/// How many times as bright a picture is, and its error over that of samples alone.
fn compare(
    gpu: &mut Gpu,
    test: &TestScene,
    camera: &Camera,
    picture: &[[f32; 4]],
    raw: &[[f32; 4]],
) -> [f64; 2] {
    let converged = still(gpu, test, camera, settings());
    [mean(picture) / mean(&converged), error(picture, &converged) / error(raw, &converged)]
}

/// Where its surfaces mirror another part of what is around, each has its own cells, and is as right as if it were alone.
#[test]
fn two_views_of_one_world_are_each_right() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let mut host = Host::new(&mut gpu, &test, settings());
    let other_side = |frame| {
        let camera = around(&test, frame);
        Camera { world_from_camera: DAffine3::from_rotation_y(2.0) * camera.world_from_camera, ..camera }
    };
    let mut recording = Recording::new();
    let mut second = LiveView::new(&settings(), &host.cache, &mut recording).unwrap();
    gpu.executor.execute(&recording).unwrap();
    for frame in 0..16 {
        orbit(&mut host, &mut gpu, &test, frame..frame + 1, PIXELS);
        std::mem::swap(&mut host.live, &mut second);
        host.frame(&mut gpu, &other_side(frame), PIXELS);
        std::mem::swap(&mut host.live, &mut second);
    }
    // The other's random numbers and cells are none of its business: it is as if it were alone, but for the order of sums.
    let alone = moving(&mut gpu, &test, 15, settings());
    let converged = still(&mut gpu, &test, &around(&test, 15), settings());
    let [first, alone] = [shown(&host, &mut gpu), alone].map(|picture| error(&picture, &converged));
    assert!((first / alone - 1.0).abs() < 0.05, "{first} {alone}");
    std::mem::swap(&mut host.live, &mut second);
    let converged = brightness(&mut gpu, &test, &other_side(15), settings());
    let ratio = mean(&shown(&host, &mut gpu)) / converged;
    assert!((ratio - 1.0).abs() < 0.05, "{ratio} times as bright");
    // One that goes takes nothing of the other along.
    std::mem::swap(&mut host.live, &mut second);
    let mut gone = Recording::new();
    second.free(&mut gone);
    gpu.executor.execute(&gone).unwrap();
    orbit(&mut host, &mut gpu, &test, 16..17, PIXELS);
    let converged = still(&mut gpu, &test, &around(&test, 16), settings());
    assert!(error(&shown(&host, &mut gpu), &converged) < 1.1 * alone);
}

/// Both eyes of a headset learn together: with as many paths as one they are both as near to the truth, and one that opens later
/// sees at once what the other has learnt.
#[test]
fn eyes_learn_together() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let mut host = Host::new(&mut gpu, &test, settings());
    let eye = |side: f64, frame| {
        let camera = around(&test, frame);
        let aside = DAffine3::from_rotation_y(0.05 * side);
        Camera { world_from_camera: aside * camera.world_from_camera, ..camera }
    };
    let view = |host: &Host, gpu: &mut Gpu| {
        let mut recording = Recording::new();
        let view = LiveView::new(&settings(), &host.cache, &mut recording).unwrap();
        gpu.executor.execute(&recording).unwrap();
        view
    };
    let mut second = view(&host, &mut gpu);
    let budget = PIXELS;
    let mut spent = [0; 2];
    for frame in 0..12 {
        for (side, spent) in [-1.0, 1.0].into_iter().zip(&mut spent) {
            *spent += host.frame(&mut gpu, &eye(side, frame), budget).pixel_samples;
            std::mem::swap(&mut host.live, &mut second);
        }
    }
    std::mem::swap(&mut host.live, &mut second);
    let truth = still(&mut gpu, &test, &eye(1.0, 11), settings());
    let together = error(&shown(&host, &mut gpu), &truth);
    let mut late = view(&host, &mut gpu);
    std::mem::swap(&mut host.live, &mut late);
    host.frame(&mut gpu, &eye(1.0, 11), budget);
    let late = error(&shown(&host, &mut gpu), &truth);
    let alone = |frames: std::ops::Range<usize>, gpu: &mut Gpu| {
        let mut host = Host::new(gpu, &test, settings());
        let spent: u64 = frames.map(|frame| host.frame(gpu, &eye(1.0, frame), budget).pixel_samples).sum();
        (error(&shown(&host, gpu), &truth), spent)
    };
    let ([(alone, of_one), (fresh, _)], of_both) =
        ([0..12, 11..12].map(|frames| alone(frames, &mut gpu)), spent[0] + spent[1]);
    println!("error together {together:.4}, alone {alone:.4}; late {late:.4}, fresh {fresh:.4}");
    assert!(together < 1.15 * alone, "{together} {alone}");
    assert!(of_both < of_one * 3 / 2, "{of_both} samples of both, {of_one} of one");
    assert!(late < 0.9 * fresh, "{late} {fresh}");
}

/// Dynamic resolution, and a window that is dragged: the cells stay.
#[test]
fn sizes_that_change_while_it_moves_leave_cells_as_they_are() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let mut host = Host::new(&mut gpu, &test, settings());
    orbit(&mut host, &mut gpu, &test, 0..20, PIXELS);
    let cells = host.made["kept light"];
    // A few hundredths of a turn change no mean.
    let converged = brightness(&mut gpu, &test, &around(&test, 23), settings());
    for (frame, scale) in (20..26).zip([0.5, 0.9, 0.7, 0.33, 1.0, 0.6]) {
        host.settings.resolution_scale = scale;
        orbit(&mut host, &mut gpu, &test, frame..frame + 1, PIXELS);
        let ratio = mean(&shown(&host, &mut gpu)) / converged;
        assert!((ratio - 1.0).abs() < 0.05, "{ratio} times as bright at {scale}");
    }
    host.settings.resolution_scale = 1.0;
    let mut small = Host::new(&mut gpu, &test, settings().with(|it| it.size = [40, 56]));
    std::mem::swap(&mut host.live, &mut small.live);
    std::mem::swap(&mut host.cache, &mut small.cache);
    let wide = |frame| {
        let camera = test.camera.with_aspect(40.0 / 56.0);
        let turn = DAffine3::from_rotation_y(0.01 * frame as f64);
        Camera { world_from_camera: turn * camera.world_from_camera, ..camera }
    };
    small.frame(&mut gpu, &wide(26), PIXELS / 4);
    let picture = shown(&small, &mut gpu);
    assert_eq!(picture.len(), 40 * 56);
    let mut reference = Host::new(
        &mut gpu,
        &test,
        small.settings.with(|it| {
            it.kept_light = false;
            it.target_samples = 256;
        }),
    );
    reference.converge(&mut gpu, &wide(26), 64 * PIXELS);
    let converged = shown(&reference, &mut gpu);
    let fresh = {
        let mut host = Host::new(&mut gpu, &test, small.settings);
        host.frame(&mut gpu, &wide(26), PIXELS / 4);
        shown(&host, &mut gpu)
    };
    let [kept, fresh] = [&picture, &fresh].map(|picture| error(picture, &converged));
    println!("error {kept:.4}, of cells that know nothing {fresh:.4}");
    assert!(kept < 0.7 * fresh, "{kept} {fresh}");
    assert!(!small.made.contains_key("kept light"), "its cells are new");
    assert_eq!(host.made["kept light"], cells);
}

/// As eyes that get used to the dark do it: what is known stays for a while, and is right whatever becomes of it.
#[test]
fn exposure_may_change_by_far() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let mut host = Host::new(&mut gpu, &test, settings());
    orbit(&mut host, &mut gpu, &test, 0..12, PIXELS);
    let mut frame = 12;
    for exposure in [30.0, 5e3, 1e-4, 0.0, 1.0] {
        host.settings.exposure = exposure;
        let frames = if exposure == 30.0 { 1 } else { 8 };
        orbit(&mut host, &mut gpu, &test, frame..frame + frames, PIXELS);
        frame += frames;
        let converged = brightness(&mut gpu, &test, &around(&test, frame - 1), settings());
        let ratio = mean(&shown(&host, &mut gpu)) / converged;
        println!("exposure {exposure}: {ratio:.4} times as bright");
        assert!((ratio - exposure).abs() <= 0.05 * exposure, "exposure {exposure}: {ratio} times as bright");
    }
}

#[test]
fn parallel_views_are_as_right_as_others() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let parallel = |frame| Camera {
        projection: Projection::Orthographic { extents: [-0.02, 0.02, -0.02, 0.02] },
        ..around(&test, frame)
    };
    let mut pictures = [true, false].map(|kept_light| {
        let mut host = Host::new(&mut gpu, &test, settings().with(|it| it.kept_light = kept_light));
        for frame in 0..24 {
            host.frame(&mut gpu, &parallel(frame), PIXELS);
        }
        shown(&host, &mut gpu)
    });
    let [kept, raw] = &mut pictures;
    let [ratio, error] = compare(&mut gpu, &test, &parallel(23), kept, raw);
    println!("{ratio:.3} times as bright, {error:.2} times the error of samples alone");
    assert!((ratio - 1.0).abs() < 0.05 && error < 0.7, "{ratio} {error}");
}

/// Fog and depth of the host, as they are over a film.
#[test]
fn fog_and_meshes_are_over_kept_light_as_over_films() {
    let mut gpu = gpu();
    let test = scenes::noise();
    let distance = test.camera.world_from_camera.translation.distance(DVec3::ZERO);
    let fog = Fog {
        color: [0.1, 0.2, 0.4],
        by_distance: DistanceFog::Exponential { density: 0.8 / distance },
        by_height: None,
    };
    let colors = |gpu: &mut Gpu, kept_light: bool, frame: usize| {
        let settings = settings().with(|it| {
            it.kept_light = kept_light;
            it.target_samples = 256;
        });
        let mut host = Host::new(gpu, &test, settings);
        host.fog = Some(fog);
        // A slanted plane through the middle.
        host.set_depth(
            gpu,
            |[x, _]| if x < SIZE / 2 { distance * (0.9 + 0.2 * f64::from(x) / 24.0) } else { 0.0 },
        );
        if kept_light {
            for frame in 0..frame {
                host.frame(gpu, &around(&test, frame), PIXELS);
            }
        }
        host.set_color(gpu, |_| [0.0, 0.0, 0.0, 1.0]);
        if kept_light {
            host.frame(gpu, &around(&test, frame), PIXELS);
        } else {
            host.converge(gpu, &around(&test, frame), 64 * PIXELS);
            host.set_color(gpu, |_| [0.0, 0.0, 0.0, 1.0]);
            host.frame(gpu, &around(&test, frame), PIXELS);
        }
        let depth = host.read_depth(gpu);
        let color: Vec<[f32; 4]> =
            host.read_color(gpu).chunks_exact(4).map(|p| std::array::from_fn(|i| p[i])).collect();
        (color, depth)
    };
    let (kept, kept_depth) = colors(&mut gpu, true, 12);
    let (film, film_depth) = colors(&mut gpu, false, 12);
    for half in [0..SIZE / 2, SIZE / 2..SIZE] {
        let of = |picture: &[[f32; 4]]| {
            let pixels = (0..SIZE).flat_map(|y| half.clone().map(move |x| (y * SIZE + x) as usize));
            pixels.map(|i| luminance(&picture[i])).sum::<f64>()
        };
        let ratio = of(&kept) / of(&film);
        println!("{half:?}: {ratio:.3} times as bright");
        assert!(of(&film) > 1.0 && (ratio - 1.0).abs() < 0.06, "{ratio} times as bright");
    }
    // Where both see something: view depths are means over it.
    let both = kept_depth.iter().zip(&film_depth).filter(|(a, b)| **a > 0.0 && **b > 0.0);
    let differences: Vec<f64> =
        both.map(|(a, b)| NEAR * (1.0 / f64::from(*a) - 1.0 / f64::from(*b))).collect();
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    println!("{} pixels, depths differ by {:.5} of {distance:.3}", differences.len(), mean);
    assert!(differences.len() > 200 && mean.abs() < 0.02 * distance, "{mean}");
}

/// The device is gone, and with it all that was learnt: view and cells are made anew on another.
#[test]
fn cells_are_made_anew_on_another_device() {
    let test = scenes::noise();
    let name = std::env::var("LUMIVOX_GPU").ok();
    let mut lost = Gpu::open(name.as_deref()).unwrap();
    let mut host = Host::new(&mut lost, &test, settings());
    orbit(&mut host, &mut lost, &test, 0..2, PIXELS);
    let before = host.made.clone();
    lost.executor.device().destroy();
    let mut recording = Recording::new();
    let host_frame = host.host_frame();
    let status = host.live.record_frame(
        &host.cache,
        &around(&test, 2),
        &settings(),
        &host_frame,
        PIXELS,
        &mut recording,
    );
    assert!(status.is_ok() && lost.executor.execute(&recording).is_err());

    let mut gpu = gpu();
    let mut host = Host::new(&mut gpu, &test, settings());
    orbit(&mut host, &mut gpu, &test, 0..12, PIXELS);
    for name in ["kept light", "points of light", "picture of kept light"] {
        assert_ne!(host.made[name], before[name], "{name}");
    }
    let ratio = mean(&shown(&host, &mut gpu)) / brightness(&mut gpu, &test, &around(&test, 11), settings());
    assert!((ratio - 1.0).abs() < 0.05, "{ratio} times as bright");
}

/// As many as there are numbers, and one more: then they are shown as without.
#[test]
fn as_many_volumes_are_lit_as_there_are_numbers() {
    let test = scenes::noise();
    let one = &test.scene.volumes[0];
    let mut limits = DeviceLimits::webgpu_default();
    limits.max_storage_binding = 1 << 30;
    let mut cache = SceneCache::new(&VoxelStore::new(limits));
    let mut view = None;
    for (count, is_kept) in [(4096u32, true), (4097, false), (4096, true)] {
        let volumes = (0..count).map(|i| {
            let mut volume = one.clone();
            volume.world_from_patient =
                DAffine3::from_translation(DVec3::X * f64::from(i)) * one.world_from_patient;
            volume
        });
        let scene = Scene { volumes: volumes.collect(), ..test.scene.clone() };
        let mut recording = Recording::new();
        cache.update(&scene, &mut recording).unwrap();
        let view = view.get_or_insert_with(|| LiveView::new(&settings(), &cache, &mut recording).unwrap());
        let host = HostFrame::new(ResourceId::external());
        view.record_frame(&cache, &around(&test, count as usize), &settings(), &host, PIXELS, &mut recording)
            .unwrap();
        assert_eq!(view.image(LiveImage::KeptLight).is_some(), is_kept, "{count}");
        let marches = recording.steps.iter().any(|step| {
            matches!(step, Step::Dispatch { kernel: lumivox_shaders::Kernel::LightMarch(_), .. })
        });
        assert_eq!(marches, is_kept, "{count}");
    }
}

/// A host that asks for all that there is gets no more than cells can learn of, and one whose budget goes up and down nothing
/// new each time; where paths are put aside there is room for fewer.
#[test]
fn any_budget_will_do() {
    let test = scenes::noise();
    let mut limits = DeviceLimits::webgpu_default();
    for loop_turns in [None, Some(LoopTurns::of_software(8))] {
        limits.loop_turns = loop_turns;
        let mut cache = SceneCache::new(&VoxelStore::new(limits));
        let mut recording = Recording::new();
        cache.update(&test.scene, &mut recording).unwrap();
        let settings = LiveSettings::new(1600, 900).with(|it| it.kept_light = true);
        let mut view = LiveView::new(&settings, &cache, &mut recording).unwrap();
        let host = HostFrame::new(ResourceId::external());
        // The first buys nearly the whole film; for one that buys all of it no light is kept.
        let most = 1600 * 900 * 500;
        for (frame, budget) in
            [most, u64::MAX, 1, 0, 5_000_000, 300_000, 900_000, 2_000_000].into_iter().enumerate()
        {
            let mut recording = Recording::new();
            let camera = around(&test, frame);
            let status =
                view.record_frame(&cache, &camera, &settings, &host, budget, &mut recording).unwrap();
            assert!(status.pixel_samples <= budget.max(1600 * 900 * 600), "{}", status.pixel_samples);
            let films = recording
                .steps
                .iter()
                .filter(|step| matches!(step, Step::CreateBuffer { label: "live film", .. }));
            assert!(frame == 0 || films.count() == 0, "frame {frame}");
        }
    }
}
