//! What hosts rely on: devices of their own, nothing that blocks, faults that are told, the GPU's time.

use std::ops::ControlFlow;
use std::time::Instant;

use lumivox_renderer::recording::{Kernel, Payload};
use lumivox_renderer::{
    DeviceLimits, Film, LiveSettings, Recording, ResourceId, SceneCache, Step, View, ViewKind, ViewSettings,
    VoxelStore,
};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::{
    Gpu, GpuError, HeadlessError, Outcome, RenderRequest, Submission, render, wanted_limits, wgpu,
};

use crate::gpu;
use crate::live::Host;

/// A future that needs nobody else to get done, as all are but in browsers.
fn now<T>(future: impl Future<Output = T>) -> T {
    let mut future = std::pin::pin!(future);
    let mut context = std::task::Context::from_waker(std::task::Waker::noop());
    loop {
        if let std::task::Poll::Ready(result) = future.as_mut().poll(&mut context) {
            return result;
        }
    }
}

/// A device of the same adapter with WebGPU's default limits, and nothing beyond.
fn plain_device() -> Gpu {
    let wanted = std::env::var("LUMIVOX_GPU").unwrap_or_default().to_lowercase();
    let instance = wgpu::Instance::default();
    let adapters = now(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let is_wanted = |adapter: &wgpu::Adapter| adapter.get_info().name.to_lowercase().contains(&wanted);
    let adapter = adapters.into_iter().find(is_wanted).expect("GPU tests need a GPU");
    let limits = wgpu::Limits::default();
    assert!(limits.check_limits(&wanted_limits(&adapter)), "what is wanted is no less");
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits.clone(), ..Default::default() };
    let (device, queue) = now(adapter.request_device(&descriptor)).unwrap();
    assert_eq!(
        (device.features(), device.limits().max_storage_buffers_per_shader_stage),
        (Default::default(), 8)
    );
    Gpu::of_device(device, queue)
}

fn still(gpu: &mut Gpu, test: &TestScene, request: &RenderRequest) -> Film {
    let rendered =
        render(gpu, &test.scene, &test.camera, request, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(matches!(rendered.outcome, Outcome::Complete), "{:?}", rendered.outcome);
    rendered.film
}

/// Mean difference of the radiance, over its mean.
fn difference(a: &Film, b: &Film, pixels: usize) -> f64 {
    let channels = |film: &Film| (0..pixels).flat_map(|i| film.radiance(i)).collect::<Vec<f64>>();
    let (a, b) = (channels(a), channels(b));
    let sum: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum();
    sum / b.iter().sum::<f64>()
}

#[test]
fn the_default_limits_of_webgpu_suffice() {
    const SIZE: u32 = 24;
    let pixels = (SIZE * SIZE) as usize;
    let mut plain = plain_device();
    for test in [scenes::homogeneous_cube(), scenes::noise()] {
        let camera = test.camera.with_aspect(1.0);
        let settings = LiveSettings { target_samples: 12, ..LiveSettings::new(SIZE, SIZE) };
        let (wanted, wanted_picture) = {
            let mut gpu = gpu();
            // Scans of 16 bits as that device stores them: other tests say what the difference is worth.
            let limits = DeviceLimits { unorm16: false, ..gpu.executor.limits() };
            let mut host = Host::within(limits, &mut gpu, &test, settings);
            host.converge(&mut gpu, &camera, 1000);
            (host.film(&mut gpu), host.read_color(&gpu))
        };
        let rendered = still(&mut plain, &test, &RenderRequest::new(SIZE, SIZE, 12));
        let far = difference(&rendered, &wanted, pixels);
        assert!(far < 1e-4, "{}: a still image differs by {far}", test.name);
        let mut host = Host::new(&mut plain, &test, settings);
        host.converge(&mut plain, &camera, 1000);
        let far = difference(&host.film(&mut plain), &wanted, pixels);
        assert!(far < 1e-4, "{}: a live view differs by {far}", test.name);
        let picture = host.read_color(&plain);
        assert!(picture.iter().any(|c| *c > 0.1), "{}: nothing is seen of it", test.name);
        let far = picture.iter().zip(&wanted_picture).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(far < 1e-2, "{}: a pixel of the picture differs by {far}", test.name);
    }
}

/// A recording that traces an image and reads it back.
fn traced(gpu: &Gpu, test: &TestScene) -> Recording {
    let mut cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
    let mut recording = Recording::new();
    cache.update(&test.scene, &mut recording).unwrap();
    let mut view = View::new(ViewSettings::new(32, 32), &cache, &mut recording).unwrap();
    view.record_samples(&cache, &test.camera, 8, u64::MAX, &mut recording);
    view.record_read_film(&mut recording);
    view.free(&mut recording);
    cache.free(&mut recording);
    recording
}

#[test]
fn nothing_has_to_be_waited_for() {
    let mut gpu = gpu();
    let recording = traced(&gpu, &scenes::noise());
    let waited = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
    let Submission { mut read_backs, .. } = gpu.executor.submit(&recording).unwrap();
    let (begin, mut polled) = (Instant::now(), None);
    while polled.is_none() {
        assert!(begin.elapsed().as_secs() < 60, "the bytes never come");
        polled = read_backs[0].poll();
    }
    assert!(polled.unwrap().unwrap() == waited);
    assert!(read_backs[0].poll().unwrap().unwrap() == waited, "asked again");
    assert!(read_backs.remove(0).wait().unwrap() == waited, "and waited for all the same");
}

#[test]
fn the_gpu_tells_what_a_submission_took() {
    let mut gpu = gpu();
    let has_timestamps = gpu.executor.device().features().contains(wgpu::Features::TIMESTAMP_QUERY);
    let test = scenes::noise();
    let mut cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
    let mut recording = Recording::new();
    cache.update(&test.scene, &mut recording).unwrap();
    let mut view = View::new(ViewSettings::new(128, 128), &cache, &mut recording).unwrap();
    gpu.executor.execute(&recording).unwrap();
    let mut host = Host::new(&mut gpu, &test, LiveSettings::new(64, 64));
    // Slots are used again.
    for target in 1..5 {
        // Something was drawn before: lavapipe takes times when it draws.
        host.frame(&mut gpu, &test.camera.with_aspect(1.0), 1000);
        gpu.executor.wait().unwrap();
        let mut recording = Recording::new();
        view.record_samples(&cache, &test.camera, 8 * target, u64::MAX, &mut recording);
        let begin = Instant::now();
        let submission = gpu.executor.submit(&recording).unwrap();
        assert_eq!(submission.time.is_some(), has_timestamps);
        let Some(mut time) = submission.time else { return };
        gpu.executor.wait().unwrap();
        let wall = begin.elapsed().as_secs_f64() * 1e3;
        let told = time.poll().expect("all is done");
        assert!(told > 0.0 && told < wall, "{told} ms of {wall} ms");
        // The first one waits for pipelines. A GPU is done too soon to tell more than the unit.
        let least = if gpu.description.software { 0.5 } else { 1e-3 };
        assert!(target == 1 || told > least * wall, "{told} ms of {wall} ms");
        assert_eq!(time.poll(), Some(told));
    }
    let nothing = gpu.executor.submit(&Recording::new()).unwrap();
    assert!(nothing.time.is_none(), "there is no pass to time");
    let mut freed = Recording::new();
    view.free(&mut freed);
    cache.free(&mut freed);
    gpu.executor.execute(&freed).unwrap();
}

#[test]
fn a_device_without_timestamps_tells_no_time() {
    let mut plain = plain_device();
    let recording = traced(&plain, &scenes::homogeneous_cube());
    let mut submission = plain.executor.submit(&recording).unwrap();
    assert!(submission.time.is_none());
    now(submission.check()).unwrap();
}

#[test]
fn a_refused_step_is_told_and_the_executor_goes_on() {
    let mut gpu = gpu();
    let id = ResourceId::external();
    let write = |offset| Step::WriteBuffer { id, offset, data: Payload::copy_of(&[7u32; 4]) };
    let recording = |offset| Recording {
        steps: vec![
            Step::CreateBuffer { id, label: "much too small", size: 16 },
            write(offset),
            Step::ReadBuffer { id, range: 0..16 },
        ],
    };
    let is_told = |result: Result<(), GpuError>| match result {
        Err(GpuError::Refused(what)) => {
            assert!(what.contains("write_buffer") && what.contains("overrun"), "{what}")
        }
        other => panic!("{other:?}"),
    };
    let mut submission = gpu.executor.submit(&recording(1 << 20)).unwrap();
    is_told(submission.poll_check().expect("it is known at once but in browsers"));
    is_told(now(submission.check()));
    is_told(gpu.executor.execute(&recording(1 << 20)).map(|_| ()));
    gpu.executor.discard(&recording(0));

    // What is not there is told by the executor itself.
    let nowhere = Recording { steps: vec![write(0)] };
    let Err(GpuError::Refused(what)) = gpu.executor.submit(&nowhere) else { panic!("it is taken") };
    assert!(what.contains("is no buffer"), "{what}");
    let (uniforms, resources) = (vec![vec![0; 16]], vec![id, id]);
    let dispatch = Step::Dispatch { kernel: Kernel::FilmCount, uniforms, resources, workgroups: [1, 1] };
    let Err(GpuError::Refused(what)) = gpu.executor.submit(&Recording { steps: vec![dispatch] }) else {
        panic!("it is taken")
    };
    assert!(what.contains("film_count") && what.contains(&format!("{id:?}")), "{what}");

    let mut submission = gpu.executor.submit(&recording(0)).unwrap();
    now(submission.check()).unwrap();
    assert_eq!(submission.read_backs.remove(0).wait().unwrap(), [7, 0, 0, 0].repeat(4));
    gpu.executor.discard(&recording(0));
}

#[test]
fn a_device_that_the_host_destroyed_is_told_as_lost() {
    let test = scenes::homogeneous_cube();
    let mut gpu = plain_device();
    gpu.executor.device().destroy();
    let request = RenderRequest::new(8, 8, 2);
    let rendered = render(&mut gpu, &test.scene, &test.camera, &request, &mut |_| ControlFlow::Continue(()));
    let Err(HeadlessError::Gpu(GpuError::Lost(why))) = rendered else { panic!("{rendered:?}") };
    assert!(!why.is_empty());
}

#[test]
fn prepared_draws_are_not_waited_for() {
    let test = scenes::homogeneous_cube();
    let mut gpu = plain_device();
    let cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
    let kernels = cache.kernels(&test.scene, ViewKind::Live);
    let [color, depth] = [wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::Depth32Float];
    assert!(!gpu.executor.is_prepared_to_draw(kernels.iter().copied(), color, 1));
    assert!(!gpu.executor.is_prepared_to_draw([Kernel::CompositeDepth], depth, 1));
    gpu.executor.prepare(kernels.iter().copied());
    for format in [color, depth] {
        gpu.executor.prepare_draws(kernels.iter().copied(), format, 1);
    }
    let is_prepared = |gpu: &Gpu| {
        gpu.executor.is_prepared(kernels.iter().copied())
            && [color, depth].iter().all(|f| gpu.executor.is_prepared_to_draw(kernels.iter().copied(), *f, 1))
    };
    while !is_prepared(&gpu) {
        std::thread::yield_now();
    }
    assert!(!gpu.executor.is_prepared_to_draw([Kernel::CompositeColor], color, 4), "another kind of target");
    let mut host = Host::new(&mut gpu, &test, LiveSettings::new(16, 16));
    host.frame(&mut gpu, &test.camera.with_aspect(1.0), u64::MAX);
    assert_eq!(gpu.executor.pipeline_waits(), 0);
}
