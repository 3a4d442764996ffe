//! Draws that cover a whole target, with pipelines of the stand-in's own: a scene's shapes, and copies.

use super::commands::Command;
use super::{Gpu, Target};
use crate::pipelines::Targets;

impl Gpu {
    /// Gives every pixel of a target its colour and depth: four floats and one each, row by row.
    pub fn fill(&mut self, target: &Target, width: u32, pixels: &[u8]) -> Result<(), String> {
        let (views, targets) = self.views(target)?;
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: pixels.len() as u64 + 16,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: true,
        });
        // Four words of the target's width, then the pixels.
        let words = [width.to_le_bytes(), [0; 4], [0; 4], [0; 4]].concat();
        buffer.slice(..16).get_mapped_range_mut().copy_from_slice(&words);
        buffer.slice(16..).get_mapped_range_mut().copy_from_slice(pixels);
        buffer.unmap();
        let pipeline = self.cover("fill", targets, true);
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        });
        self.commands.push(Command::Cover { pipeline, group, views });
        Ok(())
    }

    /// Draws a layer of a texture over all of a target, stretched, and upside down if asked to.
    pub fn blit(&mut self, from: u32, layer: u32, target: &Target, flip: bool) -> Result<(), String> {
        let texture = self.texture(from)?;
        let (views, targets) = self.views(target)?;
        let source = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            mip_level_count: Some(1),
            ..Default::default()
        });
        let pipeline = self.cover(if flip { "flipped" } else { "copied" }, targets, false);
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(&source),
            }],
        });
        self.commands.push(Command::Cover { pipeline, group, views });
        Ok(())
    }

    fn cover(&mut self, entry: &'static str, targets: Targets, writes_depth: bool) -> wgpu::RenderPipeline {
        let device = &self.device;
        let make = || {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("cover"),
                source: wgpu::ShaderSource::Wgsl(include_str!("../cover.wgsl").into()),
            });
            let target = targets.color.map(|format| wgpu::ColorTargetState {
                format,
                blend: None,
                write_mask: wgpu::ColorWrites::ALL,
            });
            let color = [target];
            let entry = match (entry, color.as_slice()) {
                ("fill", [None]) => "fill_depth",
                ("fill", _) if targets.depth.is_none() => "fill_color",
                (other, _) => other,
            };
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("cover"),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("corner"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: targets.depth.map(|format| wgpu::DepthStencilState {
                    format,
                    depth_write_enabled: Some(writes_depth),
                    depth_compare: Some(wgpu::CompareFunction::Always),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: Default::default(),
                    targets: if targets.color.is_some() { &color } else { &[] },
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        self.covers.entry((entry, targets)).or_insert_with(make).clone()
    }
}
