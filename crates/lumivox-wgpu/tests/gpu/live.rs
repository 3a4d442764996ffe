//! Live views: the same film as without a host, ended by its depth, blended over its colour.

use half::f16;
use lumivox_core::glam::{DVec2, DVec3};
use lumivox_core::{Camera, Environment, EnvironmentSource, Projection, Ray};
use lumivox_reference::medium::place;
use lumivox_reference::path::trace;
use lumivox_reference::rng::Rng;
use lumivox_renderer::{
    DeviceLimits, DistanceFog, Film, Fog, HeightFog, HostDepth, HostFrame, LiveSettings, LiveStatus,
    LiveView, LoopTurns, Recording, ResourceId, SceneCache,
};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::{Gpu, RenderRequest, wgpu};

use crate::{film, gpu};

const NEAR: f64 = 0.01;

/// Reversed depth without a far plane: `z = near / depth`, 0 where there is nothing.
const VIEW_DEPTH_FROM_NDC: [f64; 4] = [0.0, NEAR, 1.0, 0.0];

/// An engine in miniature: a colour and a depth texture, and a live view of a scene.
pub struct Host {
    cache: SceneCache,
    pub live: LiveView,
    settings: LiveSettings,
    color: wgpu::Texture,
    depth: wgpu::Texture,
    written: wgpu::Texture,
    names: [ResourceId; 3],
    fog: Option<Fog>,
    gives_depth: bool,
    pub jittered: bool,
}

impl Host {
    pub fn new(gpu: &mut Gpu, test: &TestScene, settings: LiveSettings) -> Self {
        let limits = gpu.executor.limits();
        Self::within(limits, gpu, test, settings)
    }

    /// On a device of other limits.
    fn within(limits: DeviceLimits, gpu: &mut Gpu, test: &TestScene, settings: LiveSettings) -> Self {
        let device = gpu.executor.device();
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d {
                    width: settings.size[0],
                    height: settings.size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            })
        };
        let target = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let color = texture(wgpu::TextureFormat::Rgba16Float, target);
        // What it reads is a plain texture of floats, as resolved depth is in engines; what it writes a depth buffer.
        let depth = texture(wgpu::TextureFormat::R32Float, wgpu::TextureUsages::TEXTURE_BINDING);
        let written = texture(wgpu::TextureFormat::Depth32Float, target);
        let names = [(); 3].map(|()| ResourceId::external());
        for (name, texture) in names.iter().zip([&color, &depth, &written]) {
            gpu.executor.lend_texture(*name, texture);
        }
        let mut cache = SceneCache::new(limits);
        let mut recording = Recording::new();
        cache.update(&test.scene, &mut recording).unwrap();
        let live = LiveView::new(&settings, &cache, &mut recording).unwrap();
        gpu.executor.execute(&recording).unwrap();
        Self {
            cache,
            live,
            settings,
            color,
            depth,
            written,
            names,
            fog: None,
            gives_depth: true,
            jittered: false,
        }
    }

    /// Draws "meshes": view depths of all pixels, 0 where there is none.
    pub fn set_depth(&self, gpu: &Gpu, depth: impl Fn([u32; 2]) -> f64) {
        let texels = self.texels(|at| {
            let d = depth(at);
            if d > 0.0 { (NEAR / d) as f32 } else { 0.0 }
        });
        self.upload(gpu, &self.depth, bytemuck::cast_slice(&texels), 4);
    }

    pub fn set_color(&self, gpu: &Gpu, color: impl Fn([u32; 2]) -> [f32; 4]) {
        let texels = self.texels(|at| color(at).map(|c| f16::from_f32(c).to_bits()));
        self.upload(gpu, &self.color, bytemuck::cast_slice(&texels), 8);
    }

    fn texels<T>(&self, value: impl Fn([u32; 2]) -> T) -> Vec<T> {
        let [width, height] = self.settings.size;
        (0..width * height).map(|i| value([i % width, i / width])).collect()
    }

    fn upload(&self, gpu: &Gpu, texture: &wgpu::Texture, bytes: &[u8], texel: u32) {
        let [width, height] = self.settings.size;
        gpu.executor.queue().write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * texel),
                rows_per_image: Some(height),
            },
            texture.size(),
        );
    }

    pub fn frame(&mut self, gpu: &mut Gpu, camera: &Camera, budget: u64) -> LiveStatus {
        let host = HostFrame {
            depth: self.gives_depth.then_some(HostDepth {
                texture: self.names[1],
                view_depth_from_ndc: VIEW_DEPTH_FROM_NDC,
                clear: 0.0,
                jittered: self.jittered,
            }),
            color_target: self.names[0],
            depth_target: Some(self.names[2]),
            fog: self.fog,
        };
        let mut recording = Recording::new();
        let status = self
            .live
            .record_frame(&self.cache, camera, &self.settings, &host, budget, &mut recording)
            .unwrap();
        for read_back in gpu.executor.execute(&recording).unwrap() {
            self.live.feedback(&read_back.wait().unwrap());
        }
        status
    }

    pub fn converge(&mut self, gpu: &mut Gpu, camera: &Camera, budget: u64) -> u64 {
        let (mut traced, mut idle) = (0, 0);
        for _ in 0..10_000 {
            let status = self.frame(gpu, camera, budget);
            traced += status.pixel_samples;
            // Feedback of the last frame may have opened the film again: only two idle frames are the end.
            idle = if status.converged && status.pixel_samples == 0 { idle + 1 } else { 0 };
            if idle == 2 {
                return traced;
            }
        }
        panic!("it never converges");
    }

    pub fn film(&self, gpu: &mut Gpu) -> Film {
        let mut recording = Recording::new();
        self.live.record_read_film(&mut recording);
        let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
        let [width, height] = self.live.film_size();
        let mut film = Film::new(width, height, false);
        film.insert([0, 0], [width, height], &bytes);
        film
    }

    pub fn read_color(&self, gpu: &Gpu) -> Vec<f32> {
        let bytes = self.read(gpu, &self.color, 8);
        bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect()
    }

    fn read_depth(&self, gpu: &Gpu) -> Vec<f32> {
        self.read(gpu, &self.written, 4).chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
    }

    fn read(&self, gpu: &Gpu, texture: &wgpu::Texture, texel: u32) -> Vec<u8> {
        let [width, height] = self.settings.size;
        let row = (width * texel).next_multiple_of(256);
        let device = gpu.executor.device();
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: Some(height) };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            texture.size(),
        );
        gpu.executor.queue().submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |result| result.unwrap());
        gpu.executor.wait().unwrap();
        let bytes = buffer.slice(..).get_mapped_range().to_vec();
        bytes.chunks_exact(row as usize).flat_map(|line| &line[..(width * texel) as usize]).copied().collect()
    }
}

fn assert_same(a: &Film, b: &Film, pixels: impl Iterator<Item = usize>) {
    for pixel in pixels {
        assert_eq!(a.samples(pixel), b.samples(pixel), "samples of pixel {pixel}");
        assert_eq!(a.alpha(pixel), b.alpha(pixel), "alpha of pixel {pixel}");
        let (x, y) = (a.radiance(pixel), b.radiance(pixel));
        // Sums are made in another order: equal but for the last bits.
        assert!((0..3).all(|i| (x[i] - y[i]).abs() <= 2e-5 * y[i].abs()), "pixel {pixel}: {x:?} {y:?}");
    }
}

#[test]
fn a_finished_live_film_is_the_headless_film() {
    let test = scenes::overlapping_volumes();
    let wanted = film(&test, &RenderRequest::new(24, 24, 12));
    let mut gpu = gpu();
    for budget in [u64::MAX, 1000, 40] {
        let settings = LiveSettings { target_samples: 12, ..LiveSettings::new(24, 24) };
        let mut host = Host::new(&mut gpu, &test, settings);
        host.converge(&mut gpu, &test.camera.with_aspect(1.0), budget);
        assert_same(&host.film(&mut gpu), &wanted, 0..24 * 24);
    }
}

/// Where a driver ends invocations after a few turns of their loops, a view has converged when every path has ended.
#[test]
fn a_live_film_does_not_depend_on_how_many_turns_loops_may_take() {
    let test = scenes::overlapping_volumes();
    let wanted = film(&test, &RenderRequest::new(24, 24, 6));
    let mut gpu = gpu();
    let limits = gpu.executor.limits();
    for shared in [150, 20] {
        let loop_turns = Some(LoopTurns { shared, alone: 65_000 });
        let settings = LiveSettings { target_samples: 6, ..LiveSettings::new(24, 24) };
        let mut host = Host::within(DeviceLimits { loop_turns, ..limits }, &mut gpu, &test, settings);
        host.converge(&mut gpu, &test.camera.with_aspect(1.0), 1000);
        assert_eq!(host.live.status().lost_pixels, 0);
        assert_same(&host.film(&mut gpu), &wanted, 0..24 * 24);
    }
    let loop_turns = Some(LoopTurns { shared: 3, alone: 3 });
    let settings = LiveSettings { target_samples: 6, ..LiveSettings::new(24, 24) };
    let mut host = Host::within(DeviceLimits { loop_turns, ..limits }, &mut gpu, &test, settings);
    host.converge(&mut gpu, &test.camera.with_aspect(1.0), 1000);
    assert!(host.live.status().lost_pixels > 0, "what is lost is said");
}

/// View depth of a plane that cuts obliquely through the scene, on the left two thirds of the image.
fn oblique(camera: &Camera, size: [u32; 2], at: [u32; 2]) -> f64 {
    let uv = [0, 1].map(|i| (f64::from(at[i]) + 0.5) / f64::from(size[i]));
    if uv[0] > 0.66 {
        return 0.0;
    }
    let ray = camera.ray(uv);
    let normal = DVec3::new(0.5, 0.2, 1.0).normalize();
    let t = -ray.origin.dot(normal) / ray.direction.dot(normal);
    let forward = -camera.world_from_camera.matrix3.z_axis;
    t * ray.direction.dot(forward)
}

/// Mean alpha and luminance over blocks of pixels agree with the independent reference, whose first collisions beyond
/// the host's surface count as none: what free flights that end there are.
fn compare_with_reference(test: &TestScene, camera: &Camera, samples: u32) {
    const SIZE: u32 = 24;
    const BLOCK: u32 = 6;
    let size = [SIZE, SIZE];
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: samples, ..LiveSettings::new(SIZE, SIZE) };
    let mut host = Host::new(&mut gpu, test, settings);
    host.set_depth(&gpu, |at| oblique(camera, size, at));
    host.converge(&mut gpu, camera, u64::MAX);
    let film = host.film(&mut gpu);
    drop(gpu);

    let media = place(&test.scene);
    // As every host sees it.
    let source = EnvironmentSource::Map(test.scene.environment.to_map());
    let environment = Environment { source, ..test.scene.environment };
    let forward = -camera.world_from_camera.matrix3.z_axis;
    let blocks = SIZE / BLOCK;
    let mut largest = 0.0f64;
    for block in 0..blocks * blocks {
        // Sums and squares of (alpha, luminance) of the reference, and the film's means.
        let (mut sum, mut square, mut ours, mut ours_variance) = (DVec2::ZERO, DVec2::ZERO, DVec2::ZERO, 0.0);
        let mut n = 0.0;
        for i in 0..BLOCK * BLOCK {
            let at = [block % blocks * BLOCK + i % BLOCK, block / blocks * BLOCK + i / BLOCK];
            let pixel = (at[1] * SIZE + at[0]) as usize;
            let limit = oblique(camera, size, at);
            for sample in 0..samples {
                let mut rng = Rng::new(77, pixel as u64, sample);
                let uv = [0, 1].map(|i| (f64::from(at[i]) + rng.uniform()) / f64::from(SIZE));
                let ray: Ray = camera.ray(uv);
                let path = trace(&media, &environment, &[], ray, &mut rng);
                let hit = path.first_hit.filter(|hit| {
                    limit == 0.0 || (hit.point - camera.world_from_camera.translation).dot(forward) < limit
                });
                let [r, g, b] = path.radiance;
                let value =
                    hit.map_or(DVec2::ZERO, |_| DVec2::new(1.0, 0.2126 * r + 0.7152 * g + 0.0722 * b));
                sum += value;
                square += value * value;
                n += 1.0;
            }
            let (luminance, variance) = film.luminance(pixel);
            ours += DVec2::new(film.alpha(pixel), luminance) / f64::from(BLOCK * BLOCK);
            ours_variance += variance / f64::from(BLOCK * BLOCK).powi(2);
        }
        let mean = sum / n;
        let variance = (square / n - mean * mean) / n;
        let z_alpha = (ours.x - mean.x) / (2.0 * variance.x).sqrt().max(1e-3);
        let z_light = (ours.y - mean.y) / (variance.y + ours_variance).sqrt().max(1e-4);
        largest = largest.max(z_alpha.abs()).max(z_light.abs());
        assert!(z_alpha.abs() < 4.5, "{}: block {block}: alpha {} and {}", test.name, ours.x, mean.x);
        assert!(z_light.abs() < 4.5, "{}: block {block}: light {} and {}", test.name, ours.y, mean.y);
    }
    println!("{}: largest z {largest:.2}", test.name);
}

#[test]
fn the_hosts_depth_ends_primary_rays_as_in_the_reference() {
    let test = scenes::overlapping_volumes();
    compare_with_reference(&test, &test.camera.with_aspect(1.0), 48);
}

#[test]
fn an_eye_of_a_headset_and_a_parallel_view_see_what_the_reference_sees() {
    let test = scenes::overlapping_volumes();
    let half = (test.camera.vertical_fov / 2.0).tan();
    let world_from_camera = test.camera.world_from_camera;
    let tangents = [-1.4 * half, 0.7 * half, -0.8 * half, 1.1 * half];
    compare_with_reference(
        &test,
        &Camera { world_from_camera, projection: Projection::Perspective { tangents } },
        32,
    );
    let reach = half * world_from_camera.translation.length();
    let extents = [-0.9 * reach, 1.1 * reach, -reach, reach];
    compare_with_reference(
        &test,
        &Camera { world_from_camera, projection: Projection::Orthographic { extents } },
        32,
    );
}

#[test]
fn where_the_hosts_depth_changes_pixels_start_over_and_no_others() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 8, ..LiveSettings::new(24, 24) };
    let distance = camera.world_from_camera.translation.length();
    let mesh = |left: u32| move |at: [u32; 2]| if (left..left + 8).contains(&at[0]) { distance } else { 0.0 };

    let mut host = Host::new(&mut gpu, &test, settings);
    host.set_depth(&gpu, mesh(4));
    host.converge(&mut gpu, &camera, 3000);
    host.set_depth(&gpu, mesh(6));
    // Two columns were left, two were entered: four of 24, eight samples each.
    let traced = host.converge(&mut gpu, &camera, 3000);
    assert_eq!(traced, 4 * 24 * 8);
    let moved = host.film(&mut gpu);

    let mut fresh = Host::new(&mut gpu, &test, settings);
    fresh.set_depth(&gpu, mesh(6));
    fresh.converge(&mut gpu, &camera, u64::MAX);
    assert_same(&moved, &fresh.film(&mut gpu), 0..24 * 24);
}

/// Whether only the host's depth changed the GPU alone knows: a host that draws on demand asks once more before it rests.
#[test]
fn a_mesh_that_moved_once_wakes_a_host_that_idles() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 12, ..LiveSettings::new(24, 24) };
    let distance = camera.world_from_camera.translation.length();
    let mesh = |left: u32| move |at: [u32; 2]| if (left..left + 8).contains(&at[0]) { distance } else { 0.0 };
    let mut host = Host::new(&mut gpu, &test, settings);
    host.set_depth(&gpu, mesh(4));
    host.converge(&mut gpu, &camera, u64::MAX);

    host.set_depth(&gpu, mesh(10));
    // The one frame that the move draws.
    let mut status = host.frame(&mut gpu, &camera, 3000);
    while !status.converged || status.awaits_feedback {
        if !status.converged {
            host.frame(&mut gpu, &camera, 3000);
        }
        // `frame` has handed over all that came back.
        status = host.live.status();
    }
    let film = host.film(&mut gpu);
    let lacking = (0..24 * 24).filter(|&pixel| film.samples(pixel) < 12.0).count();
    assert_eq!(lacking, 0, "pixels are short of samples, and nobody draws them");
}

/// Under jitter a depth of the neighbourhood passes for none changed; that of another camera must not.
#[test]
fn a_camera_that_moves_under_jitter_leaves_no_ends_of_rays_behind() {
    let test = scenes::noise();
    let before = test.camera.with_aspect(1.0);
    let mut after = before;
    // About a third of a pixel.
    after.world_from_camera.translation.x +=
        0.3 * 2.0 * before.world_from_camera.translation.length() * (test.camera.vertical_fov / 2.0).tan()
            / 24.0;
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 8, ..LiveSettings::new(24, 24) };
    for budget in [u64::MAX, 300] {
        let mut moved = Host::new(&mut gpu, &test, settings);
        moved.jittered = true;
        moved.set_depth(&gpu, |at| oblique(&before, [24, 24], at));
        moved.converge(&mut gpu, &before, budget);
        moved.set_depth(&gpu, |at| oblique(&after, [24, 24], at));
        moved.converge(&mut gpu, &after, budget);
        let mut fresh = Host::new(&mut gpu, &test, settings);
        fresh.set_depth(&gpu, |at| oblique(&after, [24, 24], at));
        fresh.converge(&mut gpu, &after, u64::MAX);
        assert_same(&moved.film(&mut gpu), &fresh.film(&mut gpu), 0..24 * 24);
    }
}

#[test]
fn a_host_that_gives_no_depth_any_more_ends_no_rays() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let wanted = film(&test, &RenderRequest::new(24, 24, 8));
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 8, ..LiveSettings::new(24, 24) };
    let mut host = Host::new(&mut gpu, &test, settings);
    let distance = camera.world_from_camera.translation.length();
    host.set_depth(&gpu, |_| distance);
    host.converge(&mut gpu, &camera, u64::MAX);
    host.gives_depth = false;
    host.converge(&mut gpu, &camera, u64::MAX);
    assert_same(&host.film(&mut gpu), &wanted, 0..24 * 24);
}

#[test]
fn the_picture_is_light_over_the_hosts_colour() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 40, exposure: 2.0, ..LiveSettings::new(24, 24) };
    let mut host = Host::new(&mut gpu, &test, settings);
    host.converge(&mut gpu, &camera, u64::MAX);
    let behind = |at: [u32; 2]| [at[0] as f32 / 24.0, 0.5, 3.0, 1.0];
    host.set_color(&gpu, behind);
    host.frame(&mut gpu, &camera, u64::MAX);
    let (film, shown) = (host.film(&mut gpu), host.read_color(&gpu));
    for pixel in 0..24 * 24 {
        let host_color = behind([pixel as u32 % 24, pixel as u32 / 24]);
        let (light, alpha) = (film.radiance(pixel), film.alpha(pixel));
        for i in 0..3 {
            let wanted = 2.0 * light[i] + (1.0 - alpha) * f64::from(host_color[i]);
            let got = f64::from(shown[pixel * 4 + i]);
            assert!((got - wanted).abs() < 2e-3 * (1.0 + wanted), "pixel {pixel}: {got} is not {wanted}");
        }
    }
}

#[test]
fn fog_hides_volumes_by_distance_and_by_height() {
    let test = scenes::noise();
    let centred = test.camera.with_aspect(1.0);
    let world_from_camera = centred.world_from_camera;
    let distance = world_from_camera.translation.length();
    let half = (test.camera.vertical_fov / 2.0).tan();
    let tangents = [-1.3 * half, 0.8 * half, -0.7 * half, 1.1 * half];
    let extents = [-0.9, 1.1, -1.0, 0.8].map(|x| x * half * distance);
    let cameras = [
        Camera { world_from_camera, projection: Projection::Perspective { tangents } },
        Camera { world_from_camera, projection: Projection::Orthographic { extents } },
    ];
    let far = DistanceFog::Exponential { density: 0.5 / distance };
    let near = DistanceFog::Between { begin: 0.9 * distance, end: 1.2 * distance, curve: 1.5, density: 0.8 };
    let low = HeightFog { height: 0.2 * distance, density: 3.0 / distance };
    let color = [0.2, 0.7, 1.5];
    let fogs = [
        Fog { color, by_distance: far, by_height: None },
        Fog { color, by_distance: near, by_height: None },
        Fog { color, by_distance: far, by_height: Some(low) },
    ];
    let mut gpu = gpu();
    for (camera, fog) in cameras.iter().flat_map(|camera| fogs.map(|fog| (camera, fog))) {
        let settings = LiveSettings { target_samples: 8, ..LiveSettings::new(24, 24) };
        let mut host = Host::new(&mut gpu, &test, settings);
        host.converge(&mut gpu, camera, u64::MAX);
        host.fog = Some(fog);
        host.set_color(&gpu, |_| [0.0; 4]);
        // The film is done: fog starts nothing over.
        assert_eq!(host.frame(&mut gpu, camera, u64::MAX).pixel_samples, 0);
        let (film, shown) = (host.film(&mut gpu), host.read_color(&gpu));
        let (mut least, mut most) = (1.0f64, 0.0f64);
        for pixel in (0..24 * 24).filter(|&pixel| film.alpha(pixel) > 0.0) {
            let uv = [pixel % 24, pixel / 24].map(|x| (x as f64 + 0.5) / 24.0);
            let ray = camera.ray(uv);
            let t = film.depth(pixel) / ray.direction.dot(-world_from_camera.matrix3.z_axis);
            let point = ray.origin + t * ray.direction;
            let amount = fog.amount(point.distance(world_from_camera.translation), point.y);
            (least, most) = (least.min(amount), most.max(amount));
            let (light, alpha) = (film.radiance(pixel), film.alpha(pixel));
            for i in 0..3 {
                let wanted = (1.0 - amount) * light[i] + amount * alpha * color[i];
                let got = f64::from(shown[pixel * 4 + i]);
                assert!((got - wanted).abs() < 2e-3 * (1.0 + wanted), "{fog:?}: {pixel}: {got}, {wanted}");
            }
        }
        assert!(most > 0.2 && least < most, "{fog:?} hides {least} to {most}");
    }
}

#[test]
fn the_first_frame_shows_everything_however_small_the_budget() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 64, ..LiveSettings::new(64, 64) };
    let mut host = Host::new(&mut gpu, &test, settings);
    host.converge(&mut gpu, &camera, u64::MAX);
    let done = host.film(&mut gpu);

    let mut host = Host::new(&mut gpu, &test, settings);
    host.set_color(&gpu, |_| [0.0; 4]);
    host.frame(&mut gpu, &camera, 300);
    let shown = host.read_color(&gpu);
    let (mut seen, mut wanted) = (0.0, 0.0);
    for pixel in 0..64 * 64 {
        seen += f64::from(shown[pixel * 4 + 3]);
        wanted += done.alpha(pixel);
    }
    assert!((seen / wanted - 1.0).abs() < 0.15, "{seen} of {wanted}");
}

/// Several invocations share a coarse pixel's samples: they are those of a headless film of its size.
#[test]
fn a_coarse_film_is_a_small_headless_one() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut before = camera;
    before.world_from_camera.translation.x += 1e-3;
    // Of 32 x 32 pixels; a budget that is not much larger than the last keeps it so coarse. Two, two and four
    // invocations share a pixel.
    for samples in [2, 3, 4] {
        let small = film(&test, &RenderRequest::new(32, 32, samples));
        let mut gpu = gpu();
        let settings = LiveSettings { target_samples: 64, ..LiveSettings::new(128, 128) };
        let mut host = Host::new(&mut gpu, &test, settings);
        host.frame(&mut gpu, &before, 2 * 32 * 32);
        let status = host.frame(&mut gpu, &camera, 32 * 32 * u64::from(samples));
        assert_eq!(status.pixel_samples, 32 * 32 * u64::from(samples));
        let mut recording = Recording::new();
        assert_eq!(host.live.record_read_coarse_film(&mut recording), Some([32, 32]));
        let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
        let mut coarse = Film::new(32, 32, false);
        coarse.insert([0, 0], [32, 32], &bytes);
        assert_same(&coarse, &small, 0..32 * 32);
    }
}

/// A mesh that moves in every frame keeps pixels starting over; none of them may be a hole for a single frame.
#[test]
fn a_moving_mesh_tears_no_holes() {
    let mut test = scenes::noise();
    test.scene.volumes[0].medium.density_scale = 50.0;
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 64, ..LiveSettings::new(96, 96) };
    let mut host = Host::new(&mut gpu, &test, settings);
    host.converge(&mut gpu, &camera, u64::MAX);
    let done = host.film(&mut gpu);
    for budget in [600, 2400, 20_000] {
        let mut host = Host::new(&mut gpu, &test, settings);
        for frame in 0..40 {
            // Far behind the volume: it hides nothing, and makes pixels start over all the same.
            let mesh = |at: [u32; 2]| if (2 * frame..2 * frame + 16).contains(&at[0]) { 100.0 } else { 0.0 };
            host.set_depth(&gpu, mesh);
            host.set_color(&gpu, |_| [0.0; 4]);
            host.frame(&mut gpu, &camera, budget);
            let shown = host.read_color(&gpu);
            // Coarse films are blurred at the volume's outline.
            for row in 28..68 {
                let pixels = row * 96..(row + 1) * 96;
                let wanted: f64 = pixels.clone().map(|p| done.alpha(p)).sum();
                let seen: f64 = pixels.map(|p| f64::from(shown[p * 4 + 3])).sum();
                let share = seen / wanted;
                assert!(share > 0.75, "budget {budget}, frame {frame}, row {row}: {share} of the volume");
            }
        }
    }
}

/// However few samples are asked for, a finished picture is the same whether a coarse film went before it or not.
#[test]
fn a_finished_picture_does_not_show_what_was_before() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 4, ..LiveSettings::new(32, 32) };
    let mut picture = |budget| {
        let mut host = Host::new(&mut gpu, &test, settings);
        host.converge(&mut gpu, &camera, budget);
        host.set_color(&gpu, |_| [0.0; 4]);
        host.frame(&mut gpu, &camera, budget);
        host.read_color(&gpu)
    };
    let (at_once, slowly) = (picture(u64::MAX), picture(200));
    assert!(difference(&at_once, &slowly) < 1e-3, "{}", difference(&at_once, &slowly));
}

#[test]
fn a_small_film_does_not_leak_over_the_hosts_edges() {
    let mut test = scenes::noise();
    test.scene.volumes[0].medium.density_scale = 50.0;
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 32, resolution_scale: 0.5, ..LiveSettings::new(48, 48) };
    let mut host = Host::new(&mut gpu, &test, settings);
    // A mesh in front of everything, its edge in the middle of a pixel of the film.
    host.set_depth(&gpu, |at| if at[0] < 25 { 0.02 } else { 0.0 });
    host.converge(&mut gpu, &camera, u64::MAX);
    host.set_color(&gpu, |_| [0.0; 4]);
    host.frame(&mut gpu, &camera, u64::MAX);
    let shown = host.read_color(&gpu);
    let alpha = |x: usize| shown[(24 * 48 + x) * 4 + 3];
    assert!(alpha(23) < 0.02 && alpha(27) > 0.8, "{} {} {} {}", alpha(23), alpha(24), alpha(25), alpha(27));
}

/// The depth that is written is the mean depth of the first hits, where the volume hides more than it shows.
#[test]
fn what_is_drawn_later_meets_the_volumes_depth() {
    let test = scenes::noise();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let settings = LiveSettings { target_samples: 40, ..LiveSettings::new(24, 24) };
    let mut host = Host::new(&mut gpu, &test, settings);
    host.converge(&mut gpu, &camera, u64::MAX);
    let (film, written) = (host.film(&mut gpu), host.read_depth(&gpu));
    let (mut opaque, mut clear) = (0, 0);
    for (pixel, z) in written.into_iter().enumerate() {
        let z = f64::from(z);
        if film.alpha(pixel) < 0.5 {
            clear += 1;
            assert_eq!(z, 0.0, "pixel {pixel} is not touched");
        } else {
            opaque += 1;
            let (depth, wanted) = (NEAR / z, film.depth(pixel));
            assert!((depth - wanted).abs() < 1e-4 * wanted, "pixel {pixel}: {depth} is not {wanted}");
        }
    }
    assert!(opaque > 20 && clear > 20, "{opaque} {clear}");
}

/// Root mean square difference of colours.
fn difference(a: &[f32], b: &[f32]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (squares / a.len() as f64).sqrt()
}

#[test]
fn the_denoiser_takes_noise_away_and_leaves_what_has_converged() {
    let test = scenes::overlapping_volumes();
    let camera = test.camera.with_aspect(1.0);
    let mut gpu = gpu();
    let mut picture = |samples, seed, denoise| {
        let settings = LiveSettings { target_samples: samples, seed, denoise, ..LiveSettings::new(64, 64) };
        let mut host = Host::new(&mut gpu, &test, settings);
        host.converge(&mut gpu, &camera, u64::MAX);
        host.set_color(&gpu, |_| [0.0; 4]);
        host.frame(&mut gpu, &camera, u64::MAX);
        host.read_color(&gpu)
    };
    let truth = picture(2048, 0, false);
    let (noisy, filtered) = (picture(4, 1, false), picture(4, 1, true));
    let (before, after) = (difference(&noisy, &truth), difference(&filtered, &truth));
    println!("error of 4 samples: {before:.4} before, {after:.4} after");
    assert!(after < 0.5 * before, "{before} becomes {after}");
    let (fine, kept) = (picture(512, 1, false), picture(512, 1, true));
    let (before, after) = (difference(&fine, &truth), difference(&kept, &truth));
    println!("error of 512 samples: {before:.4} before, {after:.4} after");
    assert!(after < 1.01 * before, "{before} becomes {after}");
}
