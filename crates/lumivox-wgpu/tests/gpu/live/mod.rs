//! Live views: the same film as without a host, ended by its depth, blended over its colour.

mod behind;
mod changes;
mod depth;
mod films;
mod guides;
mod kept_light;
mod noise;
mod passes;
mod picture;
mod velocity;

use std::collections::HashMap;

use half::f16;
use lumivox_core::glam::DVec3;
use lumivox_core::{Camera, Scene};
use lumivox_renderer::live::{Grain, LiveImage};
use lumivox_renderer::{
    DeviceLimits, Film, Fog, HostDepth, HostFrame, HostVelocity, LiveSettings, LiveStatus, LiveView,
    Recording, ResourceId, SceneCache, Step, VoxelStore,
};
use lumivox_testing::scenes::TestScene;
use lumivox_wgpu::{Gpu, wgpu};

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
    velocity: wgpu::Texture,
    names: [ResourceId; 4],
    fog: Option<Fog>,
    gives_depth: bool,
    wants_velocity: bool,
    pub jittered: bool,
    /// Buffers that frames have made, by their labels: the last of each.
    made: HashMap<&'static str, (ResourceId, u64)>,
}

impl Host {
    pub fn new(gpu: &mut Gpu, test: &TestScene, settings: LiveSettings) -> Self {
        let limits = gpu.executor.limits();
        Self::within(limits, gpu, test, settings)
    }

    /// On a device of other limits.
    pub fn within(limits: DeviceLimits, gpu: &mut Gpu, test: &TestScene, settings: LiveSettings) -> Self {
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
        let velocity = texture(wgpu::TextureFormat::Rg16Float, target);
        let names = [(); 4].map(|()| ResourceId::external());
        for (name, texture) in names.iter().zip([&color, &depth, &written, &velocity]) {
            gpu.executor.lend_texture(*name, texture);
        }
        let mut cache = SceneCache::new(&VoxelStore::new(limits));
        cache.follow_light();
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
            velocity,
            names,
            fog: None,
            gives_depth: true,
            wants_velocity: false,
            jittered: false,
            made: HashMap::new(),
        }
    }

    /// Shows another scene from the next frame on.
    pub fn set_scene(&mut self, gpu: &mut Gpu, scene: &Scene) {
        let mut recording = Recording::new();
        self.cache.update(scene, &mut recording).unwrap();
        gpu.executor.execute(&recording).unwrap();
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

    fn host_depth(&self) -> HostDepth {
        HostDepth::new(self.names[1], VIEW_DEPTH_FROM_NDC, 0.0).with_jitter(self.jittered)
    }

    fn host_frame(&self) -> HostFrame {
        HostFrame::new(self.names[0])
            .with_depth(self.gives_depth.then(|| self.host_depth()))
            .with_depth_target(self.names[2])
            .with_velocity(self.wants_velocity.then(|| HostVelocity::new(self.names[3], [0.5; 2])))
            .with_fog(self.fog)
    }

    pub fn frame(&mut self, gpu: &mut Gpu, camera: &Camera, budget: u64) -> LiveStatus {
        let host = self.host_frame();
        let mut recording = Recording::new();
        let status = self
            .live
            .record_frame(&self.cache, camera, &self.settings, &host, budget, &mut recording)
            .unwrap();
        for step in &recording.steps {
            if let Step::CreateBuffer { id, label, size } = *step {
                self.made.insert(label, (id, size));
            }
        }
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
        self.live.record_read(LiveImage::Film(Grain::Fine), &mut recording);
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
