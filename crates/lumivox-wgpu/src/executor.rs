//! Replays recordings on a wgpu device.

use std::collections::HashMap;
use std::sync::mpsc;

use lumivox_renderer::recording::{BindingKind, Kernel, TextureFormat};
use lumivox_renderer::{DeviceLimits, Recording, ResourceId, Step};

use crate::error::GpuError;

#[derive(Debug)]
enum Resource {
    Buffer(wgpu::Buffer),
    Texture(wgpu::Texture, wgpu::TextureView),
}

#[derive(Debug)]
struct Pipeline {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

/// Bytes on their way back from the GPU.
#[derive(Debug)]
pub struct ReadBack {
    device: wgpu::Device,
    buffer: wgpu::Buffer,
    submission: Option<wgpu::SubmissionIndex>,
    mapped: mpsc::Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl ReadBack {
    /// Waits for the bytes.
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device is gone.
    pub fn wait(self) -> Result<Vec<u8>, GpuError> {
        let wait = wgpu::PollType::Wait { submission_index: self.submission, timeout: None };
        self.device.poll(wait).map_err(|e| GpuError::Lost(e.to_string()))?;
        match self.mapped.try_recv() {
            Ok(Ok(())) => Ok(self.buffer.slice(..).get_mapped_range().to_vec()),
            Ok(Err(e)) => Err(GpuError::Lost(e.to_string())),
            Err(e) => Err(GpuError::Lost(e.to_string())),
        }
    }
}

/// Replays recordings on a device; the host may own it.
#[derive(Debug)]
pub struct Executor {
    device: wgpu::Device,
    queue: wgpu::Queue,
    resources: HashMap<ResourceId, Resource>,
    pipelines: HashMap<Kernel, Pipeline>,
    sampler: wgpu::Sampler,
    uniforms: wgpu::Buffer,
}

/// Bytes of uniforms between two submissions.
const UNIFORM_BYTES: u64 = 1 << 16;

impl Executor {
    /// An executor for a device with 16-bit normalised textures.
    pub fn new(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("linear"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("uniforms"),
            size: UNIFORM_BYTES,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { device, queue, resources: HashMap::new(), pipelines: HashMap::new(), sampler, uniforms }
    }

    /// The device, for hosts that go on with its buffers.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// What the renderer needs to know of the device.
    pub fn limits(&self) -> DeviceLimits {
        let limits = self.device.limits();
        DeviceLimits {
            max_texture_3d: limits.max_texture_dimension_3d,
            max_texture_2d: limits.max_texture_dimension_2d,
            max_storage_binding: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
        }
    }

    /// The buffer of that name, for hosts that go on with it.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when there is none.
    pub fn buffer(&self, id: ResourceId) -> Result<&wgpu::Buffer, GpuError> {
        match self.resources.get(&id) {
            Some(Resource::Buffer(buffer)) => Ok(buffer),
            _ => Err(GpuError::Refused(format!("{id:?} is no buffer"))),
        }
    }

    /// Hands the recording to the GPU without waiting for it. The read-backs come in the order of their steps.
    ///
    /// # Errors
    /// [`GpuError`] when the device runs out of memory or refuses a step.
    pub fn execute(&mut self, recording: &Recording) -> Result<Vec<ReadBack>, GpuError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let replayed = self.replay(recording);
        // Scopes nest: the innermost is popped first.
        let internal = pollster::block_on(internal.pop());
        let validation = pollster::block_on(validation.pop());
        let memory = pollster::block_on(memory.pop());
        if let Some(error) = memory {
            return Err(GpuError::OutOfMemory(error.to_string()));
        }
        if let Some(error) = validation.or(internal) {
            return Err(GpuError::Refused(error.to_string()));
        }
        replayed
    }

    /// Drops every resource that `recording` makes: after an error nobody else will.
    pub fn discard(&mut self, recording: &Recording) {
        for step in &recording.steps {
            if let Step::CreateBuffer { id, .. } | Step::CreateTexture { id, .. } = step {
                self.resources.remove(id);
            }
        }
    }

    /// Waits until the GPU has done everything.
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device is gone.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::Wait { submission_index: None, timeout: None })
            .map(|_| ())
            .map_err(|e| GpuError::Lost(e.to_string()))
    }

    fn replay(&mut self, recording: &Recording) -> Result<Vec<ReadBack>, GpuError> {
        let mut encoder = self.new_encoder();
        let mut encoded = false;
        let mut uniform_cursor = 0;
        let mut read_backs = vec![];
        for step in &recording.steps {
            // The queue's writes take effect before the commands of the next submission: submit what came before.
            let writes = matches!(step, Step::WriteBuffer { .. } | Step::WriteTexture { .. });
            let uniforms_full =
                matches!(step, Step::Dispatch { .. }) && uniform_cursor + 4096 > UNIFORM_BYTES;
            if encoded && (writes || uniforms_full) {
                self.queue.submit([std::mem::replace(&mut encoder, self.new_encoder()).finish()]);
                (encoded, uniform_cursor) = (false, 0);
            }
            match step {
                Step::CreateBuffer { id, label, size } => {
                    let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                        label: Some(label),
                        size: *size,
                        usage: wgpu::BufferUsages::STORAGE
                            | wgpu::BufferUsages::COPY_DST
                            | wgpu::BufferUsages::COPY_SRC,
                        mapped_at_creation: false,
                    });
                    self.resources.insert(*id, Resource::Buffer(buffer));
                }
                Step::CreateTexture { id, label, format, size } => {
                    let texture = self.create_texture(label, *format, *size);
                    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                    self.resources.insert(*id, Resource::Texture(texture, view));
                }
                Step::WriteBuffer { id, offset, data } => {
                    self.queue.write_buffer(self.buffer(*id)?, *offset, data.bytes());
                }
                Step::WriteTexture { id, origin, size, data } => {
                    let Some(Resource::Texture(texture, _)) = self.resources.get(id) else {
                        return Err(GpuError::Refused(format!("{id:?} is no texture")));
                    };
                    write_texture(&self.queue, texture, *origin, *size, data.bytes());
                    // An empty submission lets the staging memory of a large upload go as soon as it is copied.
                    self.queue.submit([]);
                }
                Step::ClearBuffer { id } => {
                    encoder.clear_buffer(self.buffer(*id)?, 0, None);
                    encoded = true;
                }
                Step::Dispatch { kernel, uniforms, resources, workgroups } => {
                    self.dispatch(
                        *kernel,
                        uniforms,
                        resources,
                        *workgroups,
                        &mut uniform_cursor,
                        &mut encoder,
                    );
                    encoded = true;
                }
                Step::ReadBuffer { id, range } => {
                    let size = range.end - range.start;
                    let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
                        label: Some("read back"),
                        size,
                        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                        mapped_at_creation: false,
                    });
                    encoder.copy_buffer_to_buffer(self.buffer(*id)?, range.start, &staging, 0, size);
                    encoded = true;
                    read_backs.push(staging);
                }
                Step::Free { id } => {
                    // Dropping is enough: wgpu keeps what submitted and encoded commands still need.
                    self.resources.remove(id);
                }
            }
        }
        let submission = Some(self.queue.submit([encoder.finish()]));
        let read_backs = read_backs
            .into_iter()
            .map(|buffer| {
                let (send, mapped) = mpsc::channel();
                buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
                    // Nobody listens any more where the read-back was dropped.
                    let _ = send.send(result);
                });
                ReadBack { device: self.device.clone(), buffer, submission: submission.clone(), mapped }
            })
            .collect();
        Ok(read_backs)
    }

    fn new_encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("recording") })
    }

    fn create_texture(&self, label: &str, format: TextureFormat, size: [u32; 3]) -> wgpu::Texture {
        let flat = size[2] == 0;
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: size[2].max(1) },
            mip_level_count: 1,
            sample_count: 1,
            dimension: if flat { wgpu::TextureDimension::D2 } else { wgpu::TextureDimension::D3 },
            format: match format {
                TextureFormat::R8Unorm => wgpu::TextureFormat::R8Unorm,
                TextureFormat::R16Unorm => wgpu::TextureFormat::R16Unorm,
                TextureFormat::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
            },
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    fn dispatch(
        &mut self,
        kernel: Kernel,
        uniforms: &[Vec<u8>],
        resources: &[ResourceId],
        [x, y]: [u32; 2],
        uniform_cursor: &mut u64,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        let pipeline = self.pipelines.entry(kernel).or_insert_with(|| create_pipeline(&self.device, kernel));
        let alignment = u64::from(self.device.limits().min_uniform_buffer_offset_alignment);
        let (mut uniforms, mut resources) = (uniforms.iter(), resources.iter());
        let mut entries = vec![];
        for (binding, kind) in (0..).zip(kernel.bindings()) {
            let resource = match kind {
                BindingKind::Uniform => {
                    let Some(bytes) = uniforms.next() else { continue };
                    let offset = *uniform_cursor;
                    self.queue.write_buffer(&self.uniforms, offset, bytes);
                    *uniform_cursor = (offset + bytes.len() as u64).next_multiple_of(alignment);
                    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: &self.uniforms,
                        offset,
                        size: wgpu::BufferSize::new(bytes.len() as u64),
                    })
                }
                BindingKind::LinearSampler => wgpu::BindingResource::Sampler(&self.sampler),
                _ => match resources.next().and_then(|id| self.resources.get(id)) {
                    Some(Resource::Buffer(buffer)) => buffer.as_entire_binding(),
                    Some(Resource::Texture(_, view)) => wgpu::BindingResource::TextureView(view),
                    // The device says which binding is missing.
                    None => continue,
                },
            };
            entries.push(wgpu::BindGroupEntry { binding, resource });
        }
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(kernel.entry_point()),
            layout: &pipeline.layout,
            entries: &entries,
        });
        let descriptor =
            wgpu::ComputePassDescriptor { label: Some(kernel.entry_point()), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(x, y, 1);
    }
}

fn write_texture(
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    [x, y, z]: [u32; 3],
    [width, height, depth]: [u32; 3],
    bytes: &[u8],
) {
    let texel = texture.format().block_copy_size(None).unwrap_or(1);
    queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x, y, z },
            aspect: wgpu::TextureAspect::All,
        },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * texel),
            rows_per_image: Some(height),
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: depth },
    );
}

fn create_pipeline(device: &wgpu::Device, kernel: Kernel) -> Pipeline {
    let label = Some(kernel.entry_point());
    let entries: Vec<_> = (0..)
        .zip(kernel.bindings())
        .map(|(binding, kind)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: binding_type(*kind),
            count: None,
        })
        .collect();
    let layout =
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Wgsl(kernel.wgsl().into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label,
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some(kernel.entry_point()),
        compilation_options: Default::default(),
        cache: None,
    });
    Pipeline { layout, pipeline }
}

fn binding_type(kind: BindingKind) -> wgpu::BindingType {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let texture = |filterable, view_dimension| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension,
        multisampled: false,
    };
    match kind {
        BindingKind::Uniform => buffer(wgpu::BufferBindingType::Uniform),
        BindingKind::StorageRead => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
        BindingKind::StorageReadWrite => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
        BindingKind::Texture3dFiltered => texture(true, wgpu::TextureViewDimension::D3),
        BindingKind::Texture2dLoaded => texture(false, wgpu::TextureViewDimension::D2),
        BindingKind::LinearSampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
    }
}
