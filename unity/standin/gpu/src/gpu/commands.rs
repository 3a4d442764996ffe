//! Commands that wait, and what they become in an encoder.

#[derive(Debug)]
pub(super) enum Command {
    WriteBuffer {
        buffer: wgpu::Buffer,
        offset: u64,
        data: u64,
        size: u64,
    },
    WriteTexture {
        texture: wgpu::Texture,
        level: u32,
        origin: wgpu::Origin3d,
        size: wgpu::Extent3d,
        data: u64,
        row: u32,
    },
    CopyBuffer {
        from: wgpu::Buffer,
        from_offset: u64,
        to: wgpu::Buffer,
        to_offset: u64,
        size: u64,
    },
    CopyTexture {
        from: (wgpu::Texture, u32, wgpu::Origin3d),
        to: (wgpu::Texture, u32, wgpu::Origin3d),
        size: wgpu::Extent3d,
    },
    Dispatch {
        pipeline: wgpu::ComputePipeline,
        group: wgpu::BindGroup,
        groups: [u32; 3],
    },
    Draw {
        pipeline: wgpu::RenderPipeline,
        groups: [wgpu::BindGroup; 2],
        views: Views,
        vertices: u32,
        instances: u32,
    },
    /// Draws all of a target with a pipeline of our own.
    Cover {
        pipeline: wgpu::RenderPipeline,
        group: wgpu::BindGroup,
        views: Views,
    },
    Clear {
        views: Views,
        color: Option<[f32; 4]>,
        depth: Option<f32>,
    },
    ReadBuffer {
        from: wgpu::Buffer,
        offset: u64,
        to: wgpu::Buffer,
        size: u64,
    },
    ReadTexture {
        from: wgpu::Texture,
        level: u32,
        origin: wgpu::Origin3d,
        size: wgpu::Extent3d,
        to: wgpu::Buffer,
        row: u32,
    },
}

#[derive(Debug)]
pub(super) struct Views {
    pub color: Option<wgpu::TextureView>,
    pub depth: Option<wgpu::TextureView>,
    pub viewport: [f32; 4],
}

/// Puts all of them into one encoder; dispatches that follow each other share a pass.
pub(super) fn encode(encoder: &mut wgpu::CommandEncoder, staging: &wgpu::Buffer, commands: &[Command]) {
    let mut rest = commands.iter().peekable();
    while let Some(command) = rest.next() {
        if let Command::Dispatch { .. } = command {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            let mut next = Some(command);
            while let Some(Command::Dispatch { pipeline, group, groups: [x, y, z] }) = next {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, group, &[]);
                pass.dispatch_workgroups(*x, *y, *z);
                next = rest.next_if(|command| matches!(command, Command::Dispatch { .. }));
            }
        } else {
            encode_one(encoder, staging, command);
        }
    }
}

fn part(
    (texture, mip_level, origin): (&wgpu::Texture, u32, wgpu::Origin3d),
) -> wgpu::TexelCopyTextureInfo<'_> {
    wgpu::TexelCopyTextureInfo { texture, mip_level, origin, aspect: wgpu::TextureAspect::All }
}

fn rows(buffer: &wgpu::Buffer, offset: u64, row: u32, height: u32) -> wgpu::TexelCopyBufferInfo<'_> {
    let layout =
        wgpu::TexelCopyBufferLayout { offset, bytes_per_row: Some(row), rows_per_image: Some(height) };
    wgpu::TexelCopyBufferInfo { buffer, layout }
}

/// Begins a pass over what is there, or over what it is cleared to.
fn pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    views: &'a Views,
    color: Option<[f32; 4]>,
    depth: Option<f32>,
) -> wgpu::RenderPass<'a> {
    let attachment = views.color.as_ref().map(|view| wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: color.map_or(wgpu::LoadOp::Load, |[r, g, b, a]| {
                wgpu::LoadOp::Clear(wgpu::Color { r: r.into(), g: g.into(), b: b.into(), a: a.into() })
            }),
            store: wgpu::StoreOp::Store,
        },
    });
    let depth_stencil_attachment = views.depth.as_ref().map(|view| wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: depth.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear),
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    });
    let attachments: &[_] = if attachment.is_some() { &[attachment] } else { &[] };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: attachments,
        depth_stencil_attachment,
        ..Default::default()
    })
}

fn encode_one(encoder: &mut wgpu::CommandEncoder, staging: &wgpu::Buffer, command: &Command) {
    match command {
        Command::WriteBuffer { buffer, offset, data, size } => {
            encoder.copy_buffer_to_buffer(staging, *data, buffer, *offset, *size);
        }
        Command::WriteTexture { texture, level, origin, size, data, row } => {
            encoder.copy_buffer_to_texture(
                rows(staging, *data, *row, size.height),
                part((texture, *level, *origin)),
                *size,
            );
        }
        Command::CopyBuffer { from, from_offset, to, to_offset, size } => {
            encoder.copy_buffer_to_buffer(from, *from_offset, to, *to_offset, *size);
        }
        Command::CopyTexture { from, to, size } => {
            encoder.copy_texture_to_texture(
                part((&from.0, from.1, from.2)),
                part((&to.0, to.1, to.2)),
                *size,
            );
        }
        Command::Draw { pipeline, groups, views, vertices, instances } => {
            let mut pass = pass(encoder, views, None, None);
            let [x, y, width, height] = views.viewport;
            if width > 0.0 {
                pass.set_viewport(x, y, width, height, 0.0, 1.0);
            }
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &groups[0], &[]);
            pass.set_bind_group(1, &groups[1], &[]);
            pass.draw(0..*vertices, 0..*instances);
        }
        Command::Cover { pipeline, group, views } => {
            let mut pass = pass(encoder, views, None, None);
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.draw(0..3, 0..1);
        }
        Command::Clear { views, color, depth } => drop(pass(encoder, views, *color, *depth)),
        Command::ReadBuffer { from, offset, to, size } => {
            encoder.copy_buffer_to_buffer(from, *offset, to, 0, *size)
        }
        Command::ReadTexture { from, level, origin, size, to, row } => {
            encoder.copy_texture_to_buffer(
                part((from, *level, *origin)),
                rows(to, 0, *row, size.height),
                *size,
            );
        }
        // Those go in passes of their own, several in each.
        Command::Dispatch { .. } => {}
    }
}
