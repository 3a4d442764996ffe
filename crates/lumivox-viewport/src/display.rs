//! From the scene-linear picture to the texture that a host shows: background, exposure, curve. The same pixels as the command's,
//! to the rounding of half floats.

use std::sync::Arc;

use lumivox_core::document::{Backdrop, Display, Tone};
use lumivox_core::{Environment, EnvironmentSource, PerspectiveCamera};
use lumivox_shaders::constants;
use lumivox_wgpu::wgpu;

/// Of the texture that is shown: encoded as sRGB, which its format does not say, for toolkits that blend so.
pub const SHOWN_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Of what volumes are drawn on: half floats hold lights many times as bright as white.
pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The twin of `Display` in `display.wgsl`; a test compares pixels.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Uniforms {
    forward: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    behind: [f32; 4],
    exposure_scale: f32,
    inverse_gamma: f32,
    tone_operator: u32,
    backdrop: u32,
    rotation: [f32; 2],
    strength: f32,
    padding: f32,
}

/// The pass, and a map of the environment, which it may show.
pub struct DisplayPass {
    pipeline: wgpu::RenderPipeline,
    uniforms: wgpu::Buffer,
    /// What light it shows.
    shown: Option<EnvironmentSource>,
    surroundings: wgpu::TextureView,
}

impl DisplayPass {
    pub fn new(device: &wgpu::Device) -> Self {
        let source = lumivox_shaders::tone_map_wgsl() + "\n" + include_str!("display.wgsl");
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("display"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("display"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("triangle"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("display"),
                compilation_options: Default::default(),
                targets: &[Some(SHOWN_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("display"),
            size: size_of::<Uniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let nothing = texture(device, "surroundings", [1, 1], MAP_FORMAT, MAP_USAGE);
        Self { pipeline, uniforms, shown: None, surroundings: nothing.create_view(&Default::default()) }
    }

    /// Draws `color` as `display` says to `shown`, of the same size.
    pub fn draw(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        color: &wgpu::Texture,
        shown: &wgpu::Texture,
        display: &Display,
        (environment, camera): (&Environment, &PerspectiveCamera),
    ) {
        if display.background == Backdrop::Environment {
            self.take_map(device, queue, environment);
        }
        let aspect = f64::from(color.width()) / f64::from(color.height());
        let half = (camera.vertical_fov / 2.0).tan();
        let axes = camera.world_from_camera.matrix3;
        let row = |v: lumivox_core::glam::DVec3| [v.x as f32, v.y as f32, v.z as f32, 0.0];
        let (backdrop, behind) = match display.background {
            Backdrop::Transparent => (0, [0; 3]),
            Backdrop::Color(color) => (1, color),
            Backdrop::Environment => (2, [0; 3]),
        };
        let [r, g, b] = behind.map(|code| f32::from(code) / 255.0);
        let (sin, cos) = environment.rotation.sin_cos();
        let uniforms = Uniforms {
            forward: row(-axes.z_axis),
            right: row(axes.x_axis * half * aspect),
            up: row(axes.y_axis * half),
            behind: [r, g, b, 1.0],
            exposure_scale: display.exposure.exp2() as f32,
            inverse_gamma: (1.0 / display.gamma.max(0.05)) as f32,
            tone_operator: match display.tone {
                Tone::Plain => constants::TONE_PLAIN,
                Tone::Agx => constants::TONE_AGX,
                Tone::Aces => constants::TONE_ACES,
            },
            backdrop,
            rotation: [sin as f32, cos as f32],
            strength: environment.strength as f32,
            padding: 0.0,
        };
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        let picture = color.create_view(&Default::default());
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("display"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.uniforms.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&picture) },
                wgpu::BindGroupEntry {
                    binding: 2,
                    resource: wgpu::BindingResource::TextureView(&self.surroundings),
                },
            ],
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = clear(&mut encoder, shown);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        queue.submit([encoder.finish()]);
    }

    /// Brings the environment's map to the device, unless it is there.
    fn take_map(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, environment: &Environment) {
        let is_known = self.shown.as_ref().is_some_and(|known| match (known, &environment.source) {
            // Texel by texel would take longer than to bring it.
            (EnvironmentSource::Map(known), EnvironmentSource::Map(map)) => Arc::ptr_eq(known, map),
            (known, source) => known == source,
        });
        if is_known {
            return;
        }
        let map = environment.to_map();
        let size = [map.width as u32, map.height as u32];
        let at = texture(device, "surroundings", size, MAP_FORMAT, MAP_USAGE);
        let texels: Vec<[f32; 4]> = map.texels.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
        queue.write_texture(
            at.as_image_copy(),
            bytemuck::cast_slice(&texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(16 * size[0]),
                rows_per_image: None,
            },
            at.size(),
        );
        self.surroundings = at.create_view(&Default::default());
        self.shown = Some(environment.source.clone());
    }
}

const MAP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
const MAP_USAGE: wgpu::TextureUsages =
    wgpu::TextureUsages::TEXTURE_BINDING.union(wgpu::TextureUsages::COPY_DST);

/// Begins a pass over a texture that is cleared to nothing.
pub fn clear<'a>(encoder: &'a mut wgpu::CommandEncoder, target: &wgpu::Texture) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &target.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    })
}

pub fn texture(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}
