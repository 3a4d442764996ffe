//! The host's own part: a surface, a colour texture that the scan is drawn over, and how that gets on the screen.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use lumivox_wgpu::{Gpu, wgpu};
use winit::window::Window;

use crate::Fallible;

/// The window's surface, and what is drawn for it.
pub struct Screen {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    /// Scene-linear colour, which an engine would have drawn its meshes to.
    pub color: wgpu::Texture,
    backdrop: wgpu::RenderPipeline,
    tone_map: wgpu::RenderPipeline,
}

impl Screen {
    /// Of [`Screen::color`]: half floats hold lights many times as bright as white.
    pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

    /// A surface for the window, and a device that can show something on it.
    pub async fn open(window: Arc<Window>) -> Fallible<(Self, Gpu)> {
        let size = window.inner_size();
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(window)?;
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: Some(&surface),
            ..Default::default()
        };
        let adapter = instance.request_adapter(&options).await?;
        // Who has a device already gives that: `WANTED_FEATURES` and `wanted_limits` say what it should have.
        let gpu = Gpu::request_on(&adapter).await?;
        let device = gpu.executor.device();

        let can = surface.get_capabilities(&adapter);
        let format = can.formats.iter().find(|format| format.is_srgb()).or(can.formats.first());
        let config = wgpu::SurfaceConfiguration {
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | (can.usages & wgpu::TextureUsages::COPY_SRC),
            format: *format.ok_or("the GPU shows nothing in this window")?,
            width: size.width.max(1),
            height: size.height.max(1),
            present_mode: wgpu::PresentMode::AutoVsync,
            desired_maximum_frame_latency: 2,
            alpha_mode: wgpu::CompositeAlphaMode::Auto,
            view_formats: vec![],
        };
        surface.configure(device, &config);
        let shader = device.create_shader_module(wgpu::include_wgsl!("host.wgsl"));
        let screen = Self {
            color: color(device, [config.width, config.height]),
            backdrop: pipeline(device, &shader, "backdrop", Self::COLOR_FORMAT),
            tone_map: pipeline(device, &shader, "tone_map", config.format),
            surface,
            config,
        };
        Ok((screen, gpu))
    }

    /// Pixels across and down; what was asked for, if the desktop agrees.
    pub fn size(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    pub fn aspect(&self) -> f64 {
        f64::from(self.config.width) / f64::from(self.config.height)
    }

    pub fn resize(&mut self, device: &wgpu::Device, [width, height]: [u32; 2]) {
        (self.config.width, self.config.height) = (width, height);
        self.color = color(device, [width, height]);
        self.surface.configure(device, &self.config);
    }

    /// What is shown next, which waits for the screen; `None` where that has to be asked again.
    pub fn next(&self, device: &wgpu::Device) -> Fallible<Option<wgpu::SurfaceTexture>> {
        use wgpu::CurrentSurfaceTexture::{
            Lost, Occluded, Outdated, Suboptimal, Success, Timeout, Validation,
        };
        match self.surface.get_current_texture() {
            Success(texture) | Suboptimal(texture) => return Ok(Some(texture)),
            Outdated => self.surface.configure(device, &self.config),
            // Nobody looks: there is no haste.
            Timeout | Occluded => std::thread::sleep(Duration::from_millis(10)),
            Lost | Validation => return Err("the display takes no pictures any more".into()),
        }
        Ok(None)
    }

    /// What an engine would do before the scan is drawn.
    pub fn draw_backdrop(&self, gpu: &Gpu) {
        draw(gpu, &self.backdrop, None, &self.color);
    }

    /// And what it does after that.
    pub fn draw_picture(&self, gpu: &Gpu, surface: &wgpu::SurfaceTexture) {
        draw(gpu, &self.tone_map, Some(&self.color), &surface.texture);
    }

    /// Writes what is about to be shown as a PNG; waits for it.
    pub fn save(&self, gpu: &Gpu, surface: &wgpu::SurfaceTexture, file: &Path) -> Fallible {
        if !self.config.usage.contains(wgpu::TextureUsages::COPY_SRC) {
            return Err("this display does not let its picture be read".into());
        }
        let (width, height) = (self.config.width, self.config.height);
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let device = gpu.executor.device();
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("screenshot"),
            size: u64::from(row * height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: Some(height) };
        encoder.copy_texture_to_buffer(
            surface.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            surface.texture.size(),
        );
        gpu.executor.queue().submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        gpu.executor.wait()?;
        let is_bgra = self.config.format.remove_srgb_suffix() == wgpu::TextureFormat::Bgra8Unorm;
        let bytes = buffer.slice(..).get_mapped_range();
        let lines = bytes.chunks_exact(row as usize).map(|line| &line[..4 * width as usize]);
        let pixels = lines.flat_map(|line| line.chunks_exact(4));
        let rgb: Vec<u8> =
            pixels.flat_map(|p| if is_bgra { [p[2], p[1], p[0]] } else { [p[0], p[1], p[2]] }).collect();
        let mut encoder = png::Encoder::new(std::fs::File::create(file)?, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header()?.write_image_data(&rgb)?;
        Ok(())
    }
}

fn color(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("color"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: Screen::COLOR_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry_point: &str,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry_point),
        layout: None,
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("triangle"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn draw(gpu: &Gpu, pipeline: &wgpu::RenderPipeline, source: Option<&wgpu::Texture>, target: &wgpu::Texture) {
    let device = gpu.executor.device();
    let group = source.map(|source| {
        let view = source.create_view(&Default::default());
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&view),
            }],
        })
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &target.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    if let Some(group) = &group {
        pass.set_bind_group(0, group, &[]);
    }
    pass.draw(0..3, 0..1);
    drop(pass);
    gpu.executor.queue().submit([encoder.finish()]);
}
