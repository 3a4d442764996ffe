//! What hosts rely on: devices of their own, nothing that blocks, faults that are told, the GPU's time.

use std::ops::ControlFlow;
use std::time::Instant;

use lumivox_core::Camera;
use lumivox_renderer::recording::{Kernel, Payload};
use lumivox_renderer::{
    DeviceLimits, Film, FineTexels, LiveSettings, Recording, ResourceId, SceneCache, Step, View, ViewKind,
    ViewSettings, VoxelStore,
};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::{
    FilterTest, Gpu, GpuError, HeadlessError, Outcome, RenderRequest, Submission, render, wanted_limits, wgpu,
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
pub fn plain_device() -> Gpu {
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
    let mut gpu = Gpu::of_device(device, queue);
    let test = FilterTest::begin(gpu.executor.device(), gpu.executor.queue());
    gpu.executor.store_as(test.wait().unwrap());
    gpu
}

fn still(gpu: &mut Gpu, test: &TestScene, request: &RenderRequest) -> Film {
    let rendered =
        render(gpu, &test.scene, &test.camera, request, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(matches!(rendered.outcome, Outcome::Complete), "{:?}", rendered.outcome);
    rendered.film
}

/// What a host shows over black, in one frame.
fn picture(host: &mut Host, gpu: &mut Gpu, camera: &Camera) -> Vec<f32> {
    host.set_color(gpu, |_| [0.0, 0.0, 0.0, 1.0]);
    host.frame(gpu, camera, 1000);
    host.read_color(gpu)
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
        let settings = LiveSettings::new(SIZE, SIZE).with(|it| it.target_samples = 12);
        let (wanted, wanted_picture) = {
            let mut gpu = gpu();
            // Scans of 16 bits as that device stores them: other tests say what the difference is worth.
            let limits =
                gpu.executor.limits().with(|it| it.fine_texels = plain.executor.limits().fine_texels);
            let mut host = Host::within(limits, &mut gpu, &test, settings);
            host.converge(&mut gpu, &camera, 1000);
            (host.film(&mut gpu), picture(&mut host, &mut gpu, &camera))
        };
        let rendered = still(&mut plain, &test, &RenderRequest::new(SIZE, SIZE, 12));
        let far = difference(&rendered, &wanted, pixels);
        assert!(far < 1e-4, "{}: a still image differs by {far}", test.name);
        let mut host = Host::new(&mut plain, &test, settings);
        host.converge(&mut plain, &camera, 1000);
        let far = difference(&host.film(&mut plain), &wanted, pixels);
        assert!(far < 1e-4, "{}: a live view differs by {far}", test.name);
        let picture = picture(&mut host, &mut plain, &camera);
        assert!(picture.iter().any(|c| *c > 0.1), "{}: nothing is seen of it", test.name);
        let far = picture.iter().zip(&wanted_picture).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(far < 1e-2, "{}: a pixel of the picture differs by {far}", test.name);
    }
}

/// What the renderer takes for WebGPU's limits is what wgpu does.
#[test]
fn the_default_limits_are_known_by_both_names() {
    let (limits, known) = (wgpu::Limits::default(), DeviceLimits::webgpu_default());
    assert_eq!(known.max_texture_3d, limits.max_texture_dimension_3d);
    assert_eq!(known.max_texture_2d, limits.max_texture_dimension_2d);
    assert_eq!(known.max_storage_binding, limits.max_storage_buffer_binding_size);
    assert!(known.max_storage_binding <= limits.max_buffer_size && known.fine_texels == FineTexels::Halves);
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

/// Among commands of the host's own, of two recordings of which the second needs what the first left.
#[test]
fn a_host_submits_the_encoder_that_recordings_are_replayed_into() {
    let mut gpu = gpu();
    for test in [scenes::noise(), scenes::labels(), scenes::stage()] {
        let whole = traced(&gpu, &test);
        let wanted = gpu.executor.execute(&whole).unwrap().remove(0).wait().unwrap();
        let mut encoder = gpu.executor.device().create_command_encoder(&Default::default());
        let mut submission = gpu.executor.replay_into(&whole, &mut encoder).unwrap();
        gpu.executor.wait().unwrap();
        assert!(submission.read_backs[0].poll().is_none(), "{}: it came before it was asked for", test.name);
        assert_eq!(submission.time.is_some(), times_within_encoders(&gpu));
        gpu.executor.queue().submit([encoder.finish()]);
        now(submission.check()).unwrap();
        assert!(submission.read_backs.remove(0).wait().unwrap() == wanted, "{}: another film", test.name);
        if let Some(mut time) = submission.time {
            assert!(time.poll().expect("all is done") > 0.0);
        }

        // In two recordings, whose uniforms must not meet.
        let (first, second) = whole.steps.split_at(whole.steps.len() / 2);
        let mut encoder = gpu.executor.device().create_command_encoder(&Default::default());
        let mut read_backs = vec![];
        for steps in [first, second] {
            let recording = Recording { steps: steps.to_vec() };
            read_backs.append(&mut gpu.executor.replay_into(&recording, &mut encoder).unwrap().read_backs);
        }
        gpu.executor.queue().submit([encoder.finish()]);
        assert!(read_backs.remove(0).wait().unwrap() == wanted, "{}: another film of parts", test.name);
    }
}

fn times_within_encoders(gpu: &Gpu) -> bool {
    let has_timestamps = gpu.executor.device().features().contains(wgpu::Features::TIMESTAMP_QUERY);
    has_timestamps && !gpu.description.software
}

/// What a command before a write finds is what was there before, in buffers and in textures, with rows of any length.
#[test]
fn steps_keep_their_order_in_an_encoder_of_the_hosts() {
    let mut gpu = gpu();
    let [buffer, texture, copy] = [(); 3].map(|()| ResourceId::external());
    let textures = [texture, copy].map(|id| {
        let texture = gpu.executor.device().create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 16, height: 8, depth_or_array_layers: 4 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format: wgpu::TextureFormat::R8Unorm,
            usage: wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST
                | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        gpu.executor.lend_texture(id, &texture);
        texture
    });
    let write = |value: u32| Step::WriteBuffer { id: buffer, offset: 4, data: Payload::copy_of(&[value; 2]) };
    let read = Step::ReadBuffer { id: buffer, range: 0..16 };
    let size = [13, 5, 3];
    let texels = |first: u8| Payload::copy_of(&(0..13 * 5 * 3).map(|i| i as u8 ^ first).collect::<Vec<_>>());
    let fill = |first| Step::WriteTexture { id: texture, origin: [1, 2, 1], size, data: texels(first) };
    let copied = Step::CopyTexture { from: texture, to: copy, origin: [0; 3], size: [16, 8, 4] };
    let recordings = [
        vec![
            Step::CreateBuffer { id: buffer, label: "words", size: 16 },
            write(1),
            read.clone(),
            write(2),
            read.clone(),
            fill(0),
            copied,
            fill(255),
        ],
        vec![write(3), read.clone(), Step::ClearBuffer { id: buffer }, read.clone(), write(4), read],
    ];
    let mut encoder = gpu.executor.device().create_command_encoder(&Default::default());
    let mut read_backs = vec![];
    for steps in recordings {
        let mut submission = gpu.executor.replay_into(&Recording { steps }, &mut encoder).unwrap();
        now(submission.check()).unwrap();
        read_backs.append(&mut submission.read_backs);
    }
    gpu.executor.queue().submit([encoder.finish()]);
    let words = read_backs.into_iter().map(|read_back| {
        let bytes = read_back.wait().unwrap();
        bytes.chunks_exact(4).map(|word| word[0]).collect::<Vec<_>>()
    });
    let wanted = [[0, 1, 1, 0], [0, 2, 2, 0], [0, 3, 3, 0], [0; 4], [0, 4, 4, 0]];
    assert_eq!(words.collect::<Vec<_>>(), wanted.map(|words| words.to_vec()));
    for (texture, first) in textures.iter().zip([255, 0]) {
        let got = read_texels(&gpu, texture);
        let inside = |(x, y, z): (usize, usize, usize)| {
            let [x, y, z] = [x.wrapping_sub(1), y.wrapping_sub(2), z.wrapping_sub(1)];
            (x < 13 && y < 5 && z < 3).then(|| (z * 65 + y * 13 + x) as u8 ^ first)
        };
        for (i, got) in got.into_iter().enumerate() {
            let at = (i % 16, i / 16 % 8, i / 128);
            assert_eq!(got, inside(at).unwrap_or(0), "{at:?}");
        }
    }
    for id in [texture, copy, buffer] {
        gpu.executor.execute(&Recording { steps: vec![Step::Free { id }] }).unwrap();
    }
}

/// The texels of a texture of 16 x 8 x 4 bytes.
fn read_texels(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<u8> {
    let device = gpu.executor.device();
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 256 * 8 * 4,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(256), rows_per_image: Some(8) };
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        texture.size(),
    );
    gpu.executor.queue().submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.unwrap());
    gpu.executor.wait().unwrap();
    let rows = buffer.slice(..).get_mapped_range();
    rows.chunks_exact(256).flat_map(|row| row[..16].to_vec()).collect()
}

#[test]
fn an_encoder_that_is_dropped_is_told_to_who_waits() {
    let mut gpu = gpu();
    let recording = traced(&gpu, &scenes::homogeneous_cube());
    let mut encoder = gpu.executor.device().create_command_encoder(&Default::default());
    let mut submission = gpu.executor.replay_into(&recording, &mut encoder).unwrap();
    drop(encoder);
    let Some(Err(GpuError::Lost(why))) = submission.read_backs[0].poll() else { panic!("it waits for ever") };
    assert!(why.contains("never submitted"), "{why}");
    assert!(submission.time.is_none_or(|mut time| time.poll() == Some(0.0)));

    let nowhere = Recording { steps: vec![Step::ClearBuffer { id: ResourceId::external() }] };
    let mut encoder = gpu.executor.device().create_command_encoder(&Default::default());
    let Err(GpuError::Refused(what)) = gpu.executor.replay_into(&nowhere, &mut encoder) else {
        panic!("it is taken")
    };
    assert!(what.contains("is no buffer"), "{what}");
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
    let kernels = cache.kernels(&test.scene, ViewKind::Live { guides: false, kept_light: true });
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
    // Of an image that is whole at once, and of one whose light is kept.
    let mut host = Host::new(&mut gpu, &test, LiveSettings::new(16, 16));
    for budget in [u64::MAX, 64] {
        let seen = test.camera.with_aspect(1.0 + 1.0 / budget as f64);
        let status = host.frame(&mut gpu, &seen, budget);
        assert_eq!(status.light_bytes > 0, budget == 64);
    }
    assert_eq!(gpu.executor.pipeline_waits(), 0);
}
