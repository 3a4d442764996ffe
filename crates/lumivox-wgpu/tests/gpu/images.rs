//! An image is a pure function of scene, size, seed and sample count; the display pass does what its twin says.

use std::num::NonZeroU32;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{
    Ease, Environment, Filter, Medium, Modality, PerspectiveCamera, Scene, SurfaceReflection,
    TransferFunction, Volume, VolumeInstance, Voxels,
};
use lumivox_renderer::recording::Payload;
use lumivox_renderer::{
    Background, DeviceLimits, DisplaySettings, Film, LoopTurns, Recording, RenderError, SceneCache, Step,
    ToneMap, View, ViewSettings, VoxelStore,
};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::{Gpu, GpuError, HeadlessRenderer, Outcome, RenderRequest, render};

use crate::{film, gpu};

/// Renders `test` in windows of at most `rows` rows with submissions of at most `budget` pixel samples.
fn film_in_pieces(test: &scenes::TestScene, size: u32, samples: u32, rows: u32, budget: u64) -> Film {
    let limits = gpu().executor.limits();
    film_within(limits, test, size, samples, rows, budget).unwrap()
}

/// The same on a device of other limits.
fn film_within(
    limits: DeviceLimits,
    test: &scenes::TestScene,
    size: u32,
    samples: u32,
    rows: u32,
    budget: u64,
) -> Result<Film, RenderError> {
    let mut gpu = gpu();
    let mut cache = SceneCache::new(&VoxelStore::new(limits));
    let mut recording = Recording::new();
    cache.update(&test.scene, &mut recording).unwrap();
    let mut film = Film::new(size, size, false);
    for y in (0..size).step_by(rows as usize) {
        let window_size = [size, rows.min(size - y)];
        let settings = ViewSettings::new(size, size).with(|it| {
            it.window_origin = [0, y];
            it.window_size = window_size;
        });
        let mut view = View::new(settings, &cache, &mut recording).unwrap();
        while view.record_samples(&cache, &test.camera, samples, budget, &mut recording) > 0 {
            gpu.executor.execute(&recording).unwrap();
            recording = Recording::new();
        }
        loop {
            view.record_count(&mut recording);
            let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
            view.counted(&bytes)?;
            recording = Recording::new();
            if !view.record_missing(&cache, &mut recording) {
                break;
            }
        }
        view.record_read_film(&mut recording);
        let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
        film.insert([0, y], window_size, &bytes);
        recording = Recording::new();
    }
    Ok(film)
}

#[test]
fn an_image_does_not_depend_on_windows_or_budget() {
    let test = scenes::overlapping_volumes();
    let whole = film_in_pieces(&test, 24, 8, 24, u64::MAX);
    for (rows, budget) in [(7, u64::MAX), (24, 1), (24, 200), (5, 333)] {
        let pieces = film_in_pieces(&test, 24, 8, rows, budget);
        for pixel in 0..24 * 24 {
            // Sums are made in another order: equal but for the last bits.
            let (a, b) = (whole.radiance(pixel), pieces.radiance(pixel));
            assert!((0..3).all(|i| (a[i] - b[i]).abs() <= 1e-5 * a[i].abs()), "{rows} {budget}: {a:?} {b:?}");
            assert_eq!(whole.alpha(pixel), pieces.alpha(pixel));
        }
    }
}

/// A driver that ends invocations after a few turns of their loops changes no image: paths go on in later dispatches, and
/// where a single event takes too many, in dispatches of their own.
#[test]
fn an_image_does_not_depend_on_how_many_turns_loops_may_take() {
    let limits = gpu().executor.limits();
    let within = |test: &scenes::TestScene, shared, alone| {
        let limits = limits.with(|it| it.loop_turns = Some(LoopTurns { shared, alone }));
        film_within(limits, test, 16, 4, 16, u64::MAX)
    };
    for test in [scenes::overlapping_volumes(), scenes::crowd(), scenes::stage(), scenes::dense_furnace()] {
        let whole = within(&test, 1_000, 64_000).unwrap();
        assert_eq!(whole.min_samples(), 4, "{}", test.name);
        for shared in [150, 20] {
            let pieces = within(&test, shared, 64_000).unwrap();
            for pixel in 0..16 * 16 {
                let (a, b) = (whole.radiance(pixel), pieces.radiance(pixel));
                let close = (0..3).all(|i| (a[i] - b[i]).abs() <= 1e-5 * a[i].abs());
                assert!(close, "{} with {shared} turns, pixel {pixel}: {a:?} {b:?}", test.name);
                assert_eq!(whole.samples(pixel), pieces.samples(pixel), "{}", test.name);
                assert_eq!(whole.alpha(pixel), pieces.alpha(pixel), "{}", test.name);
            }
        }
        // An event that not even an invocation alone can finish is no image with less light, but an error.
        let refused = within(&test, 3, 3).unwrap_err();
        assert!(matches!(refused, RenderError::SamplesLost { .. }), "{refused}");
    }
}

/// Kernels that can do more than a scene needs make the same image of it.
#[test]
fn an_image_does_not_depend_on_how_many_kernels_there_are() {
    let limits = gpu().executor.limits();
    let few = limits.with(|it| it.few_kernels = true);
    for test in [
        scenes::noise(),
        scenes::peaky_environment(),
        scenes::crowd(),
        scenes::tricubic(),
        scenes::labels(),
        scenes::painted(),
    ] {
        let film = |limits| film_within(limits, &test, 24, 16, 24, u64::MAX).unwrap();
        let (own, common) = (film(limits), film(few));
        let lit = (0..24 * 24).filter(|&pixel| own.alpha(pixel) > 0.0).count();
        assert!(lit > 24, "{}: there is nothing to see", test.name);
        for pixel in 0..24 * 24 {
            // Compilers round otherwise in another kernel.
            let (a, b) = (own.radiance(pixel), common.radiance(pixel));
            let close = (0..3).all(|i| (a[i] - b[i]).abs() <= 1e-5 * a[i].abs());
            assert!(close, "{}, pixel {pixel}: {a:?} {b:?}", test.name);
            assert_eq!(own.alpha(pixel), common.alpha(pixel), "{}, pixel {pixel}", test.name);
        }
    }
}

/// Several invocations trace a pixel where an image is small. Their sums go through the film.
#[test]
fn the_sums_of_sharers_are_those_of_one() {
    let few = gpu().executor.limits().with(|it| {
        it.loop_turns = None;
        it.few_kernels = true;
    });
    // A width that leaves a part of the last workgroups outside. Passes of 8 samples have one invocation a pixel.
    let film = |most| {
        let limits = few.with(|it| it.max_samples_per_dispatch = most);
        film_within(limits, &scenes::homogeneous_cube(), 21, 64, 21, u64::MAX).unwrap()
    };
    let (one, four) = (film(1), film(64));
    assert!((0..21 * 21).filter(|&pixel| one.alpha(pixel) > 0.0).count() > 21, "there is nothing to see");
    for pixel in 0..21 * 21 {
        let (a, b) = (one.radiance(pixel), four.radiance(pixel));
        // Added up in another order.
        assert!((0..3).all(|i| (a[i] - b[i]).abs() <= 1e-4 * a[i].abs()), "pixel {pixel}: {a:?} {b:?}");
        assert!((one.alpha(pixel) - four.alpha(pixel)).abs() < 1e-6, "pixel {pixel}");
    }
}

/// What clusters build on: parts of an image, traced by whoever, are those of the whole to the last bit.
#[test]
fn parts_of_fixed_passes_add_up_to_the_whole_to_the_last_bit() {
    let mut gpu = gpu();
    let mut renderer = HeadlessRenderer::new(&gpu);
    for (test, guides) in
        [(scenes::noise(), true), (scenes::peaky_environment(), false), (scenes::crowd(), false)]
    {
        let whole = RenderRequest::new(20, 18, 14).with(|it| {
            it.guides = guides;
            it.pass_samples = NonZeroU32::new(4);
        });
        let mut planes = |request: RenderRequest| {
            let go_on = &mut |_: &_| ControlFlow::Continue(());
            let rendered = renderer.render(&mut gpu, &test.scene, &test.camera, &request, go_on).unwrap();
            assert!(matches!(rendered.outcome, Outcome::Complete));
            rendered.film.planes().to_vec()
        };
        let film = planes(whole);
        assert!(film[1].iter().all(|moments| moments[2] == 14.0), "{}", test.name);
        assert!(film[0].iter().any(|light| light[1] > 0.0), "{}: there is nothing to see", test.name);
        // A window anywhere.
        for [origin, size] in [[[0, 0], [20, 5]], [[7, 5], [6, 13]], [[19, 17], [1, 1]]] {
            let part = planes(whole.with(|it| it.window = Some([origin, size])));
            for (plane, part) in film.iter().zip(&part) {
                for y in 0..size[1] as usize {
                    let row = (origin[1] as usize + y) * 20 + origin[0] as usize;
                    let width = size[0] as usize;
                    assert_eq!(plane[row..row + width], part[y * width..][..width], "{}", test.name);
                }
            }
        }
        // A pass each, added in order; the last is not whole.
        let mut sums = vec![vec![[0.0f32; 4]; 20 * 18]; film.len()];
        for (first_sample, samples) in [(0, 4), (4, 8), (8, 12), (12, 14)] {
            let part = planes(whole.with(|it| {
                it.first_sample = first_sample;
                it.samples = samples;
            }));
            assert!(part[1].iter().all(|m| m[2] == (samples - first_sample) as f32), "{}", test.name);
            for (sum, more) in sums.iter_mut().flatten().flatten().zip(part.iter().flatten().flatten()) {
                *sum += more;
            }
        }
        assert!(sums == film, "{}: passes do not add up", test.name);
    }
    renderer.free(&mut gpu);
}

/// An image that is looked at in between is the one that is not.
#[test]
fn an_image_rendered_little_by_little_is_the_whole_one() {
    let (mut gpu, test) = (gpu(), scenes::noise());
    let request = RenderRequest::new(16, 16, 8).with(|it| it.pass_samples = NonZeroU32::new(2));
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let whole = render(&mut gpu, &test.scene, &test.camera, &request, go_on).unwrap();
    let mut renderer = HeadlessRenderer::new(&gpu);
    let mut still = renderer.begin(&mut gpu, &test.scene, &test.camera, &request).unwrap();
    for samples in [2, 4, 8, 8, 99] {
        let outcome = still.trace_to(&mut gpu, &renderer, samples, go_on);
        assert!(matches!(outcome, Outcome::Complete));
        assert_eq!(still.film().min_samples(), samples.min(8));
    }
    assert!(still.end(&mut gpu).film == whole.film);
    renderer.free(&mut gpu);
}

/// Found where a scan had been in a pool with another: its filter rounded otherwise, and a few paths went elsewhere.
#[test]
fn an_image_does_not_depend_on_those_before_it() {
    let mut gpu = gpu();
    let request = RenderRequest::new(16, 16, 4).with(|it| it.pass_samples = NonZeroU32::new(4));
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let (first, second) = (scenes::crowd(), scenes::noise());
    let fresh = render(&mut gpu, &second.scene, &second.camera, &request, go_on).unwrap().film;
    let mut renderer = HeadlessRenderer::new(&gpu);
    for test in [&first, &second, &second, &first, &second] {
        let film = renderer.render(&mut gpu, &test.scene, &test.camera, &request, go_on).unwrap().film;
        assert!(test.name != second.name || film == fresh, "{}", test.name);
    }
    // The same scan through another filter is another texture.
    let mut smooth = second.scene.clone();
    smooth.volumes[0].medium.filter = Filter::Smooth;
    renderer.render(&mut gpu, &smooth, &second.camera, &request, go_on).unwrap();
    let film = renderer.render(&mut gpu, &second.scene, &second.camera, &request, go_on).unwrap().film;
    assert!(film == fresh, "after another filter");
    renderer.free(&mut gpu);
}

#[test]
fn gpus_are_opened_by_their_place_in_the_list() {
    let listed = Gpu::list();
    let usable = listed.iter().position(|gpu| gpu.unsuitable.is_none()).unwrap();
    assert_eq!(Gpu::open_at(usable).unwrap().description.name, listed[usable].name);
    let error = Gpu::open_at(listed.len()).unwrap_err();
    assert!(
        error.to_string().starts_with(&format!("there is no GPU {}. There are: 0 ", listed.len())),
        "{error}"
    );
}

/// A driver that is there may fail at the first kernel all the same: the doctor said that all was well.
#[test]
fn gpus_are_tried_with_a_scan() {
    let usable = Gpu::list().iter().position(|gpu| gpu.unsuitable.is_none()).expect("one that works");
    let mut gpu = Gpu::open_at(usable).unwrap();
    let made = gpu.executor.pipeline_waits();
    gpu.try_out().unwrap();
    assert!(gpu.executor.pipeline_waits() > made, "it needs kernels");
    gpu.executor.device().destroy();
    let error = gpu.try_out().unwrap_err();
    assert!(error.to_string().contains("cannot be used: it fails at a first kernel"), "{error}");
}

#[test]
fn the_same_seed_gives_the_same_image_and_another_does_not() {
    let test = scenes::surface_reflection();
    let request = RenderRequest::new(16, 16, 4);
    assert_eq!(film(&test, &request), film(&test, &request));
    assert_ne!(film(&test, &request), film(&test, &request.with(|it| it.seed = 1)));
}

#[test]
fn a_stopped_render_keeps_what_it_has() {
    let test = scenes::noise();
    let mut calls = 0;
    let request = RenderRequest::new(64, 64, 100_000);
    let rendered = render(&mut gpu(), &test.scene, &test.camera, &request, &mut |_| {
        calls += 1;
        if calls == 6 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .unwrap();
    assert!(matches!(rendered.outcome, Outcome::Stopped));
    assert!(rendered.film.min_samples() > 0);
    assert!((0..64 * 64).any(|p| rendered.film.radiance(p)[1] > 0.0));
}

/// Where paths are put aside, too: were the pixels with the long ones left behind, an image would be too dark.
#[test]
fn a_render_out_of_time_gives_all_pixels_of_a_row_as_much() {
    let test = scenes::dense_furnace();
    let time = Some(Duration::from_millis(1));
    let request = RenderRequest::new(32, 32, 100_000).with(|it| it.time = time);
    let rendered =
        render(&mut gpu(), &test.scene, &test.camera, &request, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(matches!(rendered.outcome, Outcome::TimeUp), "{:?}", rendered.outcome);
    assert!(rendered.film.min_samples() > 0 && rendered.unfinished == 0);
    for row in 0..32 {
        let samples: Vec<f32> = (0..32).map(|x| rendered.film.samples(row * 32 + x)).collect();
        assert!(samples.iter().all(|n| *n == samples[0]), "row {row}: {samples:?}");
    }
}

/// The end by noise is the film's: the same request is the same image, and the noise is as small as asked for.
#[test]
fn a_render_ends_by_its_noise() {
    let mut gpu = gpu();
    let test = scenes::overlapping_volumes();
    let request = RenderRequest::new(20, 16, 4096).with(|it| it.noise = Some(0.1));
    let mut film = || {
        let rendered =
            render(&mut gpu, &test.scene, &test.camera, &request, &mut |_| ControlFlow::Continue(()));
        let rendered = rendered.unwrap();
        assert!(matches!(rendered.outcome, Outcome::Complete), "{:?}", rendered.outcome);
        rendered.film
    };
    let first = film();
    let (noise, samples) = (first.noise().unwrap(), first.min_samples());
    assert!(noise <= 0.1 && (16..2048).contains(&samples), "{noise} after {samples}");
    assert_eq!(film().min_samples(), samples);
}

#[test]
fn a_lost_device_leaves_the_image_so_far() {
    let name = std::env::var("LUMIVOX_GPU").ok();
    let mut own = Gpu::open(name.as_deref()).unwrap();
    let device = own.executor.device().clone();
    let test = scenes::noise();
    let request = RenderRequest::new(64, 64, 1_000_000);
    let mut looked = false;
    let rendered = render(&mut own, &test.scene, &test.camera, &request, &mut |progress| {
        // Once the film has been looked at, there is something to keep.
        looked |= progress.noise.is_some();
        if looked {
            device.destroy();
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(matches!(rendered.outcome, Outcome::Failed(GpuError::Lost(_))), "{:?}", rendered.outcome);
    assert!(rendered.film.min_samples() > 0);
    assert!((0..64 * 64).any(|p| rendered.film.radiance(p)[1] > 0.0));
}

#[test]
fn the_display_pass_is_its_cpu_twin() {
    let test = scenes::peaky_environment();
    let mut gpu = gpu();
    let mut cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
    let mut recording = Recording::new();
    cache.update(&test.scene, &mut recording).unwrap();
    let mut view = View::new(ViewSettings::new(24, 24), &cache, &mut recording).unwrap();
    view.record_samples(&cache, &test.camera, 16, u64::MAX, &mut recording);
    view.record_read_film(&mut recording);
    let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
    let mut film = Film::new(24, 24, false);
    film.insert([0, 0], [24, 24], &bytes);
    for background in [Background::Transparent, Background::Color([0.2, 0.3, 0.4]), Background::Environment] {
        for tone_map in [ToneMap::Plain, ToneMap::Agx, ToneMap::Aces] {
            let settings = DisplaySettings { background, tone_map, exposure_ev: 0.7, gamma: 1.2 };
            let mut recording = Recording::new();
            let id = view.record_display(&cache, &settings, &mut recording);
            recording.push(Step::ReadBuffer { id, range: 0..24 * 24 * 4 });
            let shown = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
            let twin = settings.pixels(&film, &test.scene.environment, &test.camera);
            let twin = Payload::copy_of(twin.as_flattened());
            for (i, (&gpu, &cpu)) in shown.iter().zip(twin.bytes()).enumerate() {
                assert!(gpu.abs_diff(cpu) <= 1, "{background:?} {tone_map:?} byte {i}: {gpu} and {cpu}");
            }
        }
    }
}

#[test]
fn empty_scenes_and_impossible_sizes_are_no_accident() {
    let mut test = scenes::noise();
    let refused = render(&mut gpu(), &test.scene, &test.camera, &RenderRequest::new(0, 16, 1), &mut |_| {
        ControlFlow::Continue(())
    });
    assert!(refused.unwrap_err().to_string().contains("at least one pixel"));
    test.scene.volumes.clear();
    let film = film(&test, &RenderRequest::new(8, 8, 2));
    assert!((0..64).all(|p| film.alpha(p) == 0.0));
}

/// Many volumes are found in a hierarchy of boxes: none may be missed.
#[test]
fn many_volumes_are_the_sum_of_few() {
    let one = scenes::noise();
    let mut many = scenes::noise();
    // Copies so far away that hardly a ray meets them, in all directions.
    let instance = one.scene.volumes[0].clone();
    many.scene.volumes.clear();
    for i in 0..40 {
        let mut copy = instance.clone();
        if i != 20 {
            let angle = f64::from(i);
            let place = DVec3::new(angle.cos(), 0.2 * f64::from(i % 5) - 0.4, angle.sin()) * 40.0;
            copy.world_from_patient = DAffine3::from_translation(place) * copy.world_from_patient;
        }
        many.scene.volumes.push(copy);
    }
    // The near one decides where the device's origin is; the image is the same but for rounding.
    let request = RenderRequest::new(24, 24, 256);
    let (a, b) = (film(&one, &request), film(&many, &request));
    let mean = |film: &Film| (0..24 * 24).map(|p| film.alpha(p)).sum::<f64>() / (24.0 * 24.0);
    let differing = (0..24 * 24).filter(|&p| (a.alpha(p) - b.alpha(p)).abs() > 0.08).count();
    assert!((mean(&a) - mean(&b)).abs() < 2e-3, "{} and {}", mean(&a), mean(&b));
    assert!(differing < 12, "{differing} pixels differ");
}

/// The same voxels within one brick, and in the middle of a volume whose bricks meet there: the walk and all that it reads
/// are the same but for rounding, which now and then sends a path elsewhere.
#[test]
fn filters_read_across_bricks_as_within_one() {
    const INNER: usize = 24;
    const MARGIN: usize = 16;
    let picture = |filter, margin: usize| {
        let n = INNER + 2 * margin;
        let along = |i: usize| i.clamp(margin, margin + INNER - 1) - margin;
        let value = |i: usize| {
            let inner = (along(i / (n * n)) * INNER + along(i / n % n)) * INNER + along(i % n);
            // Nothing alike in neighbours.
            ((inner * 7919 + inner / INNER * 104_729) % 60_000) as u16
        };
        let voxels = Voxels::U16((0..n * n * n).map(value).collect());
        let volume = Volume::new([n; 3], voxels, [1.0 / 60_000.0, 0.0], DAffine3::IDENTITY, Modality::Other);
        let knots = [(0.4, 0.0), (1.0, 0.6)];
        let function =
            TransferFunction::from_points(Ease::Linear, &knots, &[(0.0, [0.9, 0.6, 0.3])]).unwrap();
        let surface = SurfaceReflection { strength: 0.7, gradient_per_mm: 0.2, ..SurfaceReflection::OFF };
        let medium = Medium { filter, surface, max_bounces: 2, ..Medium::new(function) };
        let mut instance = VolumeInstance::centered(Arc::new(volume.unwrap()), medium);
        instance.clip_box = [margin, margin + INNER].map(|at| DVec3::splat(at as f64 / n as f64));
        let scene =
            Scene { volumes: vec![instance], environment: Environment::uniform(1.0), ..Scene::default() };
        let eye = DVec3::new(0.03, 0.02, 0.05);
        let camera = PerspectiveCamera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.5);
        let request = RenderRequest::new(32, 32, 1).with(|it| {
            it.cell_size = Some(8);
            it.guides = true;
        });
        film(&TestScene { name: "bricks", scene, camera }, &request)
    };
    for filter in [Filter::Nearest, Filter::Trilinear, Filter::Tricubic] {
        let [one, many] = [0, MARGIN].map(|margin| picture(filter, margin));
        let hits: Vec<usize> = (0..1024).filter(|&p| one.alpha(p) > 0.0).collect();
        assert!(hits.len() > 300, "{filter:?}: only {} pixels to see", hits.len());
        let close = |a: f64, b: f64| (a - b).abs() < 2e-3 * a.abs().max(0.1);
        let same = |p: usize| {
            let normals = one.normal(p).zip(many.normal(p)).expect("asked for");
            close(one.depth(p), many.depth(p))
                && close(one.luminance(p).0, many.luminance(p).0)
                && (0..3).all(|i| (normals.0[i] - normals.1[i]).abs() < 0.02)
        };
        let other = hits.iter().filter(|&&p| !same(p)).count() as f64 / hits.len() as f64;
        assert!(other < 0.04, "{filter:?}: {other} of the pixels differ");
    }
}

/// Voxels that the GPU gets averaged, and those of a volume that was averaged before: one picture, of many bricks. Both stay
/// what they are where one scene shows the same volume in both ways.
#[test]
fn a_smooth_volume_is_one_of_its_voxels_means() {
    let dims = [70, 35, 33];
    let sample = |[x, y, z]: [usize; 3]| ((x * 7919 + y * 104_729 + z * 1_299_709) % 60_000) as u32;
    let [nx, ny, nz] = dims;
    let place = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)];
    let mean = |at: [usize; 3]| {
        let around = |axis: usize| {
            let near = move |step: usize| (at[axis] + step).clamp(2, dims[axis] + 1) - 2;
            [-1, 4, 10, 4, -1].into_iter().enumerate().map(move |(step, weight)| (near(step), weight))
        };
        let (mut sum, mut least, mut most) = (2048, i64::MAX, 0);
        for (z, of_z) in around(2) {
            for (y, of_y) in around(1) {
                for (x, of_x) in around(0) {
                    let value = i64::from(sample([x, y, z]));
                    sum += of_x * of_y * of_z * value;
                    // The outermost of five weigh less than nothing.
                    if of_x.min(of_y).min(of_z) > 0 {
                        (least, most) = (least.min(value), most.max(value));
                    }
                }
            }
        }
        (sum >> 12).clamp(least, most) as u32
    };
    let volume = |value: &dyn Fn([usize; 3]) -> u32| {
        let voxels = Voxels::U16((0..nx * ny * nz).map(|i| value(place(i)) as u16).collect());
        let scale = [1.0 / 60_000.0, 0.0];
        Arc::new(Volume::new(dims, voxels, scale, DAffine3::IDENTITY, Modality::Other).unwrap())
    };
    let (raw, averaged) = (volume(&sample), volume(&mean));
    let picture = |shown: [(&Arc<Volume>, Filter); 2]| {
        let instance = |(i, (volume, filter)): (usize, (&Arc<Volume>, Filter))| {
            let function =
                TransferFunction::from_points(Ease::Linear, &[(0.4, 0.0), (0.7, 0.6)], &[(0.0, [0.9; 3])]);
            let surface = SurfaceReflection { strength: 0.7, gradient_per_mm: 0.2, ..SurfaceReflection::OFF };
            let medium = Medium { filter, surface, max_bounces: 2, ..Medium::new(function.unwrap()) };
            let mut instance = VolumeInstance::centered(volume.clone(), medium);
            let shift = DAffine3::from_translation(DVec3::Y * (i as f64 - 0.5) * 0.04);
            instance.world_from_patient = shift * instance.world_from_patient;
            instance
        };
        let volumes = shown.into_iter().enumerate().map(instance).collect();
        let scene = Scene { volumes, environment: Environment::uniform(1.0), ..Scene::default() };
        let eye = DVec3::new(0.05, 0.03, 0.12);
        let camera = PerspectiveCamera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.9);
        film(&TestScene { name: "smooth", scene, camera }, &RenderRequest::new(48, 48, 1))
    };
    let smooth = picture([(&raw, Filter::Smooth), (&raw, Filter::Trilinear)]);
    let linear = picture([(&averaged, Filter::Trilinear), (&raw, Filter::Trilinear)]);
    let raw = picture([(&raw, Filter::Trilinear), (&raw, Filter::Trilinear)]);
    let hits: Vec<usize> = (0..48 * 48).filter(|&p| linear.alpha(p) > 0.0).collect();
    assert!(hits.len() > 400, "only {} pixels to see", hits.len());
    let differ = |other: &Film| {
        let differs = |&&p: &&usize| (linear.luminance(p).0 - other.luminance(p).0).abs() > 1e-3;
        hits.iter().filter(differs).count() as f64 / hits.len() as f64
    };
    assert!(differ(&smooth) < 0.01, "{} of the pixels differ", differ(&smooth));
    assert!(differ(&raw) > 0.1, "it makes no difference: {}", differ(&raw));
}
