//! Replays recordings on a wgpu device.

use std::collections::HashMap;
use std::sync::Arc;

use lumivox_renderer::recording::{BindingKind, Kernel, KernelKind, TextureOrder};
use lumivox_renderer::stage::Workbench;
use lumivox_renderer::{DeviceLimits, FineTexels, LoopTurns, Recording, ResourceId, Step, Workshop};

use crate::commands::{Commands, UNIFORM_BYTES};
use crate::error::GpuError;
use crate::pipelines::{self, DrawKey, Pipeline, Uniforms};
use crate::submission::{self, Faults, ReadBack, Scopes, Submission};
use crate::textures::{self, MadeAhead, TextureMaker};
use crate::timing::{Timer, Timing};

#[derive(Debug)]
enum Resource {
    Buffer(wgpu::Buffer),
    Texture(wgpu::Texture, wgpu::TextureView),
}

/// Replays recordings on a device; the host may own it.
#[derive(Debug)]
pub struct Executor {
    device: wgpu::Device,
    queue: wgpu::Queue,
    resources: HashMap<ResourceId, Resource>,
    made_ahead: MadeAhead,
    dispatches: Workshop<Arc<Pipeline<wgpu::ComputePipeline>>>,
    draws: Workshop<Arc<Pipeline<wgpu::RenderPipeline>>, DrawKey>,
    timer: Option<Timer>,
    sampler: wgpu::Sampler,
    uniforms: wgpu::Buffer,
    kind_of_uniforms: Uniforms,
    fine_texels: FineTexels,
}

impl Executor {
    /// An executor for a device; one with 16-bit normalised textures keeps 16-bit scans as they are, [others](Self::store_as) may.
    pub fn new(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("linear"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let kind_of_uniforms = Uniforms::on(&device);
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("uniforms"),
            size: UNIFORM_BYTES,
            usage: kind_of_uniforms.usage() | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let fine_texels = match device.features().contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM) {
            true => FineTexels::Norms,
            false => FineTexels::Halves,
        };
        Self {
            fine_texels,
            dispatches: pipelines::dispatches(device.clone(), kind_of_uniforms),
            draws: pipelines::draws(device.clone(), kind_of_uniforms),
            timer: Timer::new(&device, &queue),
            device,
            queue,
            resources: HashMap::new(),
            made_ahead: MadeAhead::default(),
            sampler,
            uniforms,
            kind_of_uniforms,
        }
    }

    /// Stores voxels of more than 8 bits as a [`FilterTest`](crate::FilterTest) says that the device does best: before its
    /// [limits](Self::limits) are asked for. Without 16-bit norms they are half floats else.
    pub fn store_as(&mut self, fine_texels: FineTexels) {
        self.fine_texels = fine_texels;
    }

    /// The device, for hosts that go on with its buffers.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue, for hosts that have work of their own on the device.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// What the renderer needs to know of the device.
    pub fn limits(&self) -> DeviceLimits {
        let (limits, adapter) = (self.device.limits(), self.device.adapter_info());
        let in_software = adapter.device_type == wgpu::DeviceType::Cpu;
        DeviceLimits::webgpu_default().with(|it| {
            it.max_texture_3d = limits.max_texture_dimension_3d;
            it.max_texture_bytes = match in_software {
                true => DeviceLimits::TEXTURE_BYTES_OF_SOFTWARE,
                false => DeviceLimits::TEXTURE_BYTES_OF_GPU,
            };
            it.fine_texels = self.fine_texels;
            it.one_pool = in_software;
            it.max_texture_2d = limits.max_texture_dimension_2d;
            it.max_storage_binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
            it.max_samples_per_dispatch = match in_software {
                true => DeviceLimits::SAMPLES_OF_SOFTWARE,
                false => DeviceLimits::SAMPLES_OF_GPU,
            };
            it.loop_turns = in_software.then(|| LoopTurns::of_software(adapter.subgroup_max_size));
        })
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

    /// Lends a texture of the host's own under a name from [`ResourceId::external`], until the name is lent anew or
    /// [freed](Step::Free). Depth buffers that are read need `TEXTURE_BINDING`, targets `RENDER_ATTACHMENT`.
    pub fn lend_texture(&mut self, id: ResourceId, texture: &wgpu::Texture) {
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.resources.insert(id, Resource::Texture(texture.clone(), view));
    }

    /// What makes large textures ahead of the recordings that want them, on other threads.
    pub fn texture_maker(&self) -> TextureMaker {
        TextureMaker::new(self.device.clone(), self.made_ahead.clone())
    }

    /// Has the pipelines of kernels made on other threads, before a recording wants them. What is drawn is left out: see
    /// [`prepare_draws`](Self::prepare_draws). [`SceneCache::kernels`](lumivox_renderer::SceneCache::kernels) names those
    /// that a scene needs, [`Features`](lumivox_renderer::Features) those that scenes may need.
    pub fn prepare(&self, kernels: impl IntoIterator<Item = Kernel>) {
        self.dispatches.prepare(kernels.into_iter().filter(|kernel| kernel.kind() == KernelKind::Compute));
    }

    /// Whether a recording with these kernels waits for none of their pipelines; as to what is drawn, see
    /// [`is_prepared_to_draw`](Self::is_prepared_to_draw).
    pub fn is_prepared(&self, kernels: impl IntoIterator<Item = Kernel>) -> bool {
        kernels
            .into_iter()
            .all(|kernel| kernel.kind() != KernelKind::Compute || self.dispatches.is_ready(kernel))
    }

    /// Has the pipelines made with which those of the kernels that are drawn onto such a target draw, on other threads:
    /// onto colour or, where the format is one of depth, into that. Each kind of target has its own.
    pub fn prepare_draws(
        &self,
        kernels: impl IntoIterator<Item = Kernel>,
        format: wgpu::TextureFormat,
        samples: u32,
    ) {
        self.draws.prepare(pipelines::draw_keys(kernels, format, samples));
    }

    /// Whether a recording that draws these kernels onto such a target waits for none of their pipelines.
    pub fn is_prepared_to_draw(
        &self,
        kernels: impl IntoIterator<Item = Kernel>,
        format: wgpu::TextureFormat,
        samples: u32,
    ) -> bool {
        pipelines::draw_keys(kernels, format, samples).all(|key| self.draws.is_ready(key))
    }

    /// How often a recording had to wait for a pipeline, or to make it.
    pub fn pipeline_waits(&self) -> u64 {
        self.dispatches.waits() + self.draws.waits()
    }

    /// Hands the recording to the GPU. Nothing is waited for: whether the device took it, its bytes and its time are
    /// known [later](Submission).
    ///
    /// # Errors
    /// [`GpuError::Refused`] when a step names what is not there, or a kernel's pipeline cannot be made.
    pub fn submit(&mut self, recording: &Recording) -> Result<Submission, GpuError> {
        let scopes = Scopes::push(&self.device);
        let timer = self.timer.clone();
        let replayed = self.replay_and_submit(recording, timer.as_ref());
        let faults = scopes.pop();
        replayed.map(|submission| Submission { faults, ..submission })
    }

    /// Hands the recording to the GPU and asks whether the device takes it, for which it blocks in browsers: there,
    /// [`submit`](Self::submit) has to do. What the GPU does is not waited for. The read-backs come in the order of their
    /// steps.
    ///
    /// # Errors
    /// [`GpuError`] when the device runs out of memory or refuses a step.
    pub fn execute(&mut self, recording: &Recording) -> Result<Vec<ReadBack>, GpuError> {
        let scopes = Scopes::push(&self.device);
        let replayed = self.replay_and_submit(recording, None);
        pollster::block_on(scopes.pop())?;
        Ok(replayed?.read_backs)
    }

    /// Drops every resource that `recording` makes or would have freed: after an error nobody else will.
    pub fn discard(&mut self, recording: &Recording) {
        for step in &recording.steps {
            if let Step::CreateBuffer { id, .. } | Step::CreateTexture { id, .. } | Step::Free { id } = step {
                self.free(*id);
            }
        }
    }

    fn free(&mut self, id: ResourceId) {
        // Dropping is enough: wgpu keeps what submitted and encoded commands still need.
        self.resources.remove(&id);
        self.made_ahead.take(id);
    }

    /// Waits until the GPU has done everything. Has no effect in browsers.
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device is gone.
    pub fn wait(&self) -> Result<(), GpuError> {
        submission::poll(&self.device, wgpu::PollType::Wait { submission_index: None, timeout: None })
    }

    /// Replays a recording into an encoder of the host's, among commands of its own: nothing is done before the host submits
    /// it. What came back of it is there some time after that, read-backs and the time by the GPU; in software no time is told.
    ///
    /// Encoders have to be submitted in the order in which recordings were replayed into them, and before a later recording is
    /// [submitted](Self::submit) or [executed](Self::execute).
    ///
    /// [`Submission::check`] tells of what was made for it and uploaded. A command that the device refuses is the encoder's own
    /// fault, which wgpu tells where the host finishes it.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when a step names what is not there, or a kernel's pipeline cannot be made. The encoder holds the
    /// steps before it then, which may be submitted or dropped; what the recording made should be [discarded](Self::discard).
    pub fn replay_into(
        &mut self,
        recording: &Recording,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<Submission, GpuError> {
        let scopes = Scopes::push(&self.device);
        // What others bind meanwhile is not overwritten.
        let uniforms = self.create_buffer(
            "uniforms",
            self.uniform_bytes(recording).max(16),
            self.kind_of_uniforms.usage() | wgpu::BufferUsages::COPY_DST,
        );
        let timer = self.timer.as_ref().filter(|timer| timer.times_within_an_encoder());
        let timing = self.timing(recording, timer);
        let mut commands = Commands::lent(encoder, uniforms, timing);
        let replayed = self.replay(recording, &mut commands);
        let faults = scopes.pop();
        let returned = replayed?;
        let read_back = |buffer| ReadBack::on_submit(self.device.clone(), buffer, commands.encoder());
        let read_backs = returned.into_iter().map(read_back).collect();
        let (_, timing) = commands.submit(&self.queue);
        let time = timing.map(|timing| timing.on_submit(&self.device, encoder));
        Ok(Submission { read_backs, time, faults })
    }

    fn replay_and_submit(
        &mut self,
        recording: &Recording,
        timer: Option<&Timer>,
    ) -> Result<Submission, GpuError> {
        let timing = self.timing(recording, timer);
        let mut commands = Commands::own(&self.device, self.uniforms.clone(), timing);
        let returned = self.replay(recording, &mut commands)?;
        let (submission, timing) = commands.submit(&self.queue);
        let read_back = |buffer| ReadBack::new(self.device.clone(), buffer, submission.clone());
        let read_backs = returned.into_iter().map(read_back).collect();
        let time = timing.map(|timing| timing.submitted(&self.device));
        Ok(Submission { read_backs, time, faults: Faults::default() })
    }

    /// What times a recording, where there is something to time.
    fn timing(&self, recording: &Recording, timer: Option<&Timer>) -> Option<Timing> {
        let is_pass = |step: &&Step| matches!(step, Step::Dispatch { .. } | Step::Draw { .. });
        let passes = recording.steps.iter().filter(is_pass).count();
        timer.filter(|_| passes > 0).map(|timer| timer.begin(&self.device, &self.queue, passes))
    }

    /// Bytes that the uniforms of a recording take.
    fn uniform_bytes(&self, recording: &Recording) -> u64 {
        let alignment = self.kind_of_uniforms.alignment(&self.device.limits());
        let of_step = |step: &Step| match step {
            Step::Dispatch { uniforms, .. } | Step::Draw { uniforms, .. } => {
                uniforms.iter().map(|bytes| (bytes.len() as u64).next_multiple_of(alignment)).sum()
            }
            _ => 0,
        };
        recording.steps.iter().map(of_step).sum()
    }

    /// Returns the buffers to which read-backs are copied.
    fn replay(
        &mut self,
        recording: &Recording,
        commands: &mut Commands<'_>,
    ) -> Result<Vec<wgpu::Buffer>, GpuError> {
        let (device, queue) = (self.device.clone(), self.queue.clone());
        let gpu = (&device, &queue);
        let mut returned = vec![];
        for step in &recording.steps {
            commands.prepare_for(step, &device, &queue);
            match step {
                Step::CreateBuffer { id, label, size } => {
                    let usage = wgpu::BufferUsages::STORAGE
                        | wgpu::BufferUsages::COPY_DST
                        | wgpu::BufferUsages::COPY_SRC;
                    let buffer = self.create_buffer(label, *size, usage);
                    self.resources.insert(*id, Resource::Buffer(buffer));
                }
                Step::CreateTexture { id, label, format, size } => {
                    let order = TextureOrder { id: *id, label, format: *format, size: *size };
                    let made = self.made_ahead.take(*id);
                    let texture = made.unwrap_or_else(|| textures::create(&self.device, &order));
                    self.lend_texture(*id, &texture);
                }
                Step::WriteBuffer { id, offset, data } => {
                    commands.write_buffer(gpu, *id, self.buffer(*id)?, *offset, data.bytes());
                }
                Step::WriteTexture { id, origin, size, data } => {
                    let (texture, _) = self.texture(*id)?;
                    commands.write_texture(gpu, *id, texture, *origin, *size, data.bytes());
                }
                Step::CopyTexture { from, to, origin: [x, y, z], size } => {
                    let origin = wgpu::Origin3d { x: *x, y: *y, z: *z };
                    let [from, to] = [self.texture(*from)?, self.texture(*to)?]
                        .map(|(texture, _)| wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() });
                    let [width, height, depth_or_array_layers] = *size;
                    let size = wgpu::Extent3d { width, height, depth_or_array_layers };
                    commands.encoder().copy_texture_to_texture(from, to, size);
                }
                Step::ClearBuffer { id } => commands.encoder().clear_buffer(self.buffer(*id)?, 0, None),
                Step::Dispatch { kernel, uniforms, resources, workgroups } => {
                    self.dispatch(*kernel, uniforms, resources, *workgroups, commands)?;
                }
                Step::Draw { kernel, uniforms, resources, target } => {
                    let (texture, view) = self.texture(*target)?;
                    let target = (texture.clone(), view.clone());
                    self.draw(*kernel, uniforms, resources, target, commands)?;
                }
                Step::ReadBuffer { id, range } => {
                    let size = range.end - range.start;
                    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
                    let staging = self.create_buffer("read back", size, usage);
                    let from = self.buffer(*id)?;
                    commands.encoder().copy_buffer_to_buffer(from, range.start, &staging, 0, size);
                    returned.push(staging);
                }
                Step::Free { id } => self.free(*id),
            }
        }
        Ok(returned)
    }

    fn texture(&self, id: ResourceId) -> Result<(&wgpu::Texture, &wgpu::TextureView), GpuError> {
        match self.resources.get(&id) {
            Some(Resource::Texture(texture, view)) => Ok((texture, view)),
            _ => Err(GpuError::Refused(format!("{id:?} is no texture"))),
        }
    }

    fn create_buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let label = Some(label);
        self.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
    }

    fn dispatch(
        &mut self,
        kernel: Kernel,
        uniforms: &[Vec<u8>],
        resources: &[ResourceId],
        [x, y]: [u32; 2],
        commands: &mut Commands<'_>,
    ) -> Result<(), GpuError> {
        let pipeline = self.dispatches.get(kernel).map_err(GpuError::Refused)?;
        let group = self.bind(kernel, &pipeline.layout, uniforms, resources, commands)?;
        let label = Some(kernel.entry_point());
        let (encoder, timing) = commands.encoder_and_timing();
        let timestamp_writes = timing.and_then(Timing::next_compute);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(x, y, 1);
        Ok(())
    }

    fn draw(
        &mut self,
        kernel: Kernel,
        uniforms: &[Vec<u8>],
        resources: &[ResourceId],
        (target, view): (wgpu::Texture, wgpu::TextureView),
        commands: &mut Commands<'_>,
    ) -> Result<(), GpuError> {
        let key = DrawKey { kernel, format: target.format(), samples: target.sample_count() };
        let pipeline = self.draws.get(key).map_err(GpuError::Refused)?;
        let group = self.bind(kernel, &pipeline.layout, uniforms, resources, commands)?;
        // What the host has drawn stays, under what is drawn now.
        let color = [Some(wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        })];
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view: &view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        };
        let draws_color = kernel.kind() != KernelKind::DrawDepth;
        let (encoder, timing) = commands.encoder_and_timing();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(kernel.entry_point()),
            color_attachments: if draws_color { &color } else { &[] },
            depth_stencil_attachment: (!draws_color).then_some(depth),
            timestamp_writes: timing.and_then(Timing::next_render),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }

    /// A kernel's bindings, its uniforms written to where they are bound from.
    fn bind(
        &self,
        kernel: Kernel,
        layout: &wgpu::BindGroupLayout,
        uniforms: &[Vec<u8>],
        resources: &[ResourceId],
        commands: &mut Commands<'_>,
    ) -> Result<wgpu::BindGroup, GpuError> {
        let alignment = self.kind_of_uniforms.alignment(&self.device.limits());
        let uniform_buffer = commands.uniforms.clone();
        let (mut uniforms, mut resources) = (uniforms.iter(), resources.iter());
        let mut entries = vec![];
        for (binding, kind) in (0..).zip(kernel.bindings()) {
            let resource = match kind {
                BindingKind::Uniform => {
                    let Some(bytes) = uniforms.next() else { continue };
                    let offset = commands.uniform_cursor;
                    self.queue.write_buffer(&uniform_buffer, offset, bytes);
                    commands.uniform_cursor = (offset + bytes.len() as u64).next_multiple_of(alignment);
                    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: &uniform_buffer,
                        offset,
                        size: wgpu::BufferSize::new(bytes.len() as u64),
                    })
                }
                BindingKind::LinearSampler => wgpu::BindingResource::Sampler(&self.sampler),
                _ => {
                    // The device says which binding is missing.
                    let Some(id) = resources.next() else { continue };
                    match self.resources.get(id) {
                        Some(Resource::Buffer(buffer)) => buffer.as_entire_binding(),
                        Some(Resource::Texture(_, view)) => wgpu::BindingResource::TextureView(view),
                        None => {
                            let name = kernel.entry_point();
                            return Err(GpuError::Refused(format!(
                                "{id:?}, which {name} binds, is not there"
                            )));
                        }
                    }
                }
            };
            entries.push(wgpu::BindGroupEntry { binding, resource });
        }
        let label = Some(kernel.entry_point());
        Ok(self.device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout, entries: &entries }))
    }
}

/// For a host whose views a [stage](lumivox_renderer::stage) keeps. Kernels that draw are made for a target's format:
/// [`prepare_draws`](Executor::prepare_draws) has to be asked for those.
impl Workbench for Executor {
    fn are_ready(&self, kernels: &[Kernel]) -> bool {
        self.prepare(kernels.iter().copied());
        self.is_prepared(kernels.iter().copied())
    }

    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send> {
        let maker = Executor::texture_maker(self);
        Box::new(move |order| maker.make(order))
    }
}
