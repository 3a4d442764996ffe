//! The device, its resources, and the commands that wait to be submitted together.

mod commands;
mod cover;
mod read_back;

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, mpsc};

use self::commands::{Command, Views};
use self::read_back::Ticket;
use crate::formats::{self, extent, origin, view};
use crate::pipelines::{DrawState, Entry, Kernel, Program, Targets, binding_type};
use crate::spirv::{Kind, Module};

/// What goes to one variable. Shared with `Native.cs`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Bind {
    /// 0: the kernel or the vertex stage; 1: the fragment stage.
    pub stage: u32,
    pub binding: u32,
    /// A buffer's or a texture's handle; of a sampler its filter (0 point, 1 linear) and, from bit 2, how it goes on
    /// beyond the texture (0 repeat, 1 clamp, 2 mirror).
    pub handle: u32,
    /// The level of a texture that is written.
    pub level: u32,
    /// Where a constant buffer's range starts, and its bytes; 0 for all.
    pub offset: u64,
    pub size: u64,
}

/// Where a draw or a clear goes. Shared with `Native.cs`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Textures, or 0.
    pub color: u32,
    pub color_layer: u32,
    pub depth: u32,
    pub depth_layer: u32,
    /// x, y, width, height in pixels; none where the width is 0.
    pub viewport: [f32; 4],
}

/// A box of a texture. Shared with `Native.cs`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Region {
    pub texture: u32,
    pub level: u32,
    /// x, y, and z or the layer.
    pub origin: [u32; 3],
}

#[derive(Debug)]
enum Resource {
    Buffer(wgpu::Buffer),
    Texture(wgpu::Texture),
}

#[derive(Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pub name: String,
    pub limits: wgpu::Limits,
    pub features: wgpu::Features,
    /// Whether it computes on the CPU.
    in_software: bool,
    resources: HashMap<u32, Resource>,
    next: u32,
    kernels: Vec<Kernel>,
    programs: Vec<Program>,
    samplers: HashMap<u32, wgpu::Sampler>,
    covers: HashMap<(&'static str, Targets), wgpu::RenderPipeline>,
    commands: Vec<Command>,
    /// What the commands write, until they are submitted.
    arena: Vec<u8>,
    tickets: HashMap<u32, Ticket>,
    /// Tickets whose commands are not submitted.
    pending: Vec<u32>,
    pub submissions: u64,
    faults: Arc<Mutex<Vec<String>>>,
}

/// Rows of a texture in a buffer start at multiples of this.
const ROW: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

impl Gpu {
    /// Opens the first Vulkan device, or one in hardware where there is one.
    ///
    /// # Errors
    /// Text that says what is missing.
    pub fn open() -> Result<Self, String> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::VULKAN;
        let instance = wgpu::Instance::new(descriptor);
        let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
        adapters.sort_by_key(|adapter| adapter.get_info().device_type == wgpu::DeviceType::Cpu);
        let adapter =
            adapters.into_iter().next().ok_or("there is no Vulkan driver: install mesa-vulkan-drivers")?;
        let needed = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM
            | wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES
            | wgpu::Features::PASSTHROUGH_SHADERS;
        let optional = wgpu::Features::FLOAT32_FILTERABLE | wgpu::Features::RG11B10UFLOAT_RENDERABLE;
        let missing = needed - adapter.features();
        if !missing.is_empty() {
            return Err(format!("{} lacks {missing:?}", adapter.get_info().name));
        }
        let features = needed | (optional & adapter.features());
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("stand-in"),
            required_features: features,
            required_limits: adapter.limits(),
            // SAFETY: kernels go to the driver as their compiler made them.
            experimental_features: unsafe { wgpu::ExperimentalFeatures::enabled() },
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| error.to_string())?;
        let faults = Arc::new(Mutex::new(Vec::new()));
        let heard = faults.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            heard.lock().unwrap_or_else(PoisonError::into_inner).push(error.to_string());
        }));
        Ok(Self {
            name: adapter.get_info().name,
            in_software: adapter.get_info().device_type == wgpu::DeviceType::Cpu,
            limits: device.limits(),
            features,
            device,
            queue,
            resources: HashMap::new(),
            next: 1,
            kernels: Vec::new(),
            programs: Vec::new(),
            samplers: HashMap::new(),
            covers: HashMap::new(),
            commands: Vec::new(),
            arena: Vec::new(),
            tickets: HashMap::new(),
            pending: Vec::new(),
            submissions: 0,
            faults,
        })
    }

    /// Notes what went wrong.
    pub fn fault(&self, text: String) {
        self.faults.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    }

    /// What went wrong, the oldest first; each is told once.
    pub fn next_fault(&self) -> Option<String> {
        let mut faults = self.faults.lock().unwrap_or_else(PoisonError::into_inner);
        if faults.is_empty() { None } else { Some(faults.remove(0)) }
    }

    fn insert(&mut self, resource: Resource) -> u32 {
        let handle = self.next;
        self.next += 1;
        self.resources.insert(handle, resource);
        handle
    }

    /// A buffer full of rubbish: what an engine makes is not cleared.
    pub fn create_buffer(&mut self, size: u64, constant: bool) -> Result<u32, String> {
        if size > self.limits.max_buffer_size {
            return Err(format!("a buffer of {size} bytes is more than the device has"));
        }
        use wgpu::BufferUsages as Usages;
        let kind = match constant {
            true if self.in_software => Usages::UNIFORM | Usages::STORAGE,
            true => Usages::UNIFORM,
            false => Usages::STORAGE | Usages::INDIRECT,
        };
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: kind | Usages::COPY_SRC | Usages::COPY_DST,
            mapped_at_creation: true,
        });
        buffer.slice(..).get_mapped_range_mut().copy_from_slice(&vec![0xcd; size as usize]);
        buffer.unmap();
        Ok(self.insert(Resource::Buffer(buffer)))
    }

    /// A texture of `dimension` 2 (with layers), 3 or 4 (a cube), which may be written by kernels or be drawn to.
    pub fn create_texture(
        &mut self,
        format: u32,
        dimension: u32,
        size: [u32; 3],
        levels: u32,
        storage: bool,
        target: bool,
    ) -> Result<u32, String> {
        let format = formats::format(format)
            .ok_or_else(|| format!("the stand-in has no textures of GraphicsFormat {format}"))?;
        use wgpu::TextureUsages as Usages;
        let mut usage = Usages::TEXTURE_BINDING | Usages::COPY_SRC | Usages::COPY_DST;
        if storage {
            usage |= Usages::STORAGE_BINDING;
        }
        if target {
            usage |= Usages::RENDER_ATTACHMENT;
        }
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: size[2] },
            mip_level_count: levels,
            sample_count: 1,
            dimension: if dimension == 3 { wgpu::TextureDimension::D3 } else { wgpu::TextureDimension::D2 },
            format,
            usage,
            view_formats: &[],
        });
        Ok(self.insert(Resource::Texture(texture)))
    }

    pub fn free(&mut self, handle: u32) -> Result<(), String> {
        self.resources.remove(&handle).map(drop).ok_or_else(|| format!("resource {handle} is freed twice"))
    }

    pub fn live(&self) -> usize {
        self.resources.len()
    }

    fn buffer(&self, handle: u32) -> Result<wgpu::Buffer, String> {
        match self.resources.get(&handle) {
            Some(Resource::Buffer(buffer)) => Ok(buffer.clone()),
            Some(Resource::Texture(_)) => Err(format!("resource {handle} is a texture, not a buffer")),
            None => Err(format!("buffer {handle} is used after it was freed")),
        }
    }

    fn texture(&self, handle: u32) -> Result<wgpu::Texture, String> {
        match self.resources.get(&handle) {
            Some(Resource::Texture(texture)) => Ok(texture.clone()),
            Some(Resource::Buffer(_)) => Err(format!("resource {handle} is a buffer, not a texture")),
            None => Err(format!("texture {handle} is used after it was freed")),
        }
    }

    pub fn write_buffer(&mut self, buffer: u32, offset: u64, data: &[u8]) -> Result<(), String> {
        let buffer = self.buffer(buffer)?;
        if offset + data.len() as u64 > buffer.size()
            || !offset.is_multiple_of(4)
            || !data.len().is_multiple_of(4)
        {
            return Err(format!(
                "{} bytes do not go to byte {offset} of a buffer of {}",
                data.len(),
                buffer.size()
            ));
        }
        let at = self.arena.len() as u64;
        self.arena.extend_from_slice(data);
        self.commands.push(Command::WriteBuffer { buffer, offset, data: at, size: data.len() as u64 });
        Ok(())
    }

    pub fn write_texture(&mut self, to: Region, size: [u32; 3], data: &[u8]) -> Result<(), String> {
        let texture = self.texture(to.texture)?;
        let tight = (size[0] * formats::texel_bytes(texture.format())) as usize;
        let rows = (size[1] * size[2]) as usize;
        if data.len() != tight * rows {
            return Err(format!("{} bytes are given for {rows} rows of {tight}", data.len()));
        }
        let row = (tight as u32).next_multiple_of(ROW);
        self.arena.resize(self.arena.len().next_multiple_of(16), 0);
        let at = self.arena.len();
        self.arena.resize(at + row as usize * rows, 0);
        for (index, bytes) in data.chunks_exact(tight.max(1)).enumerate() {
            let start = at + index * row as usize;
            self.arena[start..start + tight].copy_from_slice(bytes);
        }
        self.commands.push(Command::WriteTexture {
            texture,
            level: to.level,
            origin: origin(to.origin),
            size: extent(size),
            data: at as u64,
            row,
        });
        Ok(())
    }

    pub fn copy_buffer(&mut self, from: (u32, u64), to: (u32, u64), size: u64) -> Result<(), String> {
        let (source, destination) = (self.buffer(from.0)?, self.buffer(to.0)?);
        self.commands.push(Command::CopyBuffer {
            from: source,
            from_offset: from.1,
            to: destination,
            to_offset: to.1,
            size,
        });
        Ok(())
    }

    pub fn copy_texture(&mut self, from: Region, to: Region, size: [u32; 3]) -> Result<(), String> {
        let (source, destination) = (self.texture(from.texture)?, self.texture(to.texture)?);
        self.commands.push(Command::CopyTexture {
            from: (source, from.level, origin(from.origin)),
            to: (destination, to.level, origin(to.origin)),
            size: extent(size),
        });
        Ok(())
    }

    pub fn create_kernel(&mut self, words: Vec<u32>) -> Result<u32, String> {
        let mut module = Module::read(words, 0)?;
        let is_buffer = |kind| matches!(kind, Kind::Constant | Kind::Buffer { .. });
        let buffers = module.variables.iter().filter(|variable| is_buffer(variable.kind)).count();
        if self.in_software && buffers <= self.limits.max_storage_buffers_per_shader_stage as usize {
            module.put_constants_into_storage()?;
        }
        self.kernels.push(Kernel::new(&self.device, module));
        Ok(self.kernels.len() as u32 - 1)
    }

    pub fn create_program(&mut self, vertex: Vec<u32>, fragment: Vec<u32>) -> Result<u32, String> {
        let modules = [Module::read(vertex, 0)?, Module::read(fragment, 1)?];
        self.programs.push(Program::new(&self.device, modules));
        Ok(self.programs.len() as u32 - 1)
    }

    pub fn describe_kernel(&self, kernel: u32) -> Option<String> {
        Some(self.kernels.get(kernel as usize)?.module.describe())
    }

    pub fn describe_program(&self, program: u32, stage: usize) -> Option<String> {
        Some(self.programs.get(program as usize)?.modules.get(stage)?.describe())
    }

    /// What a stage's variables are bound with, and the layout that follows from it.
    fn bound(
        &mut self,
        module: &Module,
        stage: u32,
        binds: &[Bind],
    ) -> Result<(Vec<Entry>, Vec<Bound>), String> {
        let (mut entries, mut bound) = (Vec::new(), Vec::new());
        for variable in &module.variables {
            let bind = binds.iter().find(|bind| bind.stage == stage && bind.binding == variable.binding);
            let bind = bind.ok_or_else(|| format!("{} binds nothing to {}", module.entry, variable.name))?;
            let mut format = None;
            bound.push(match variable.kind {
                Kind::Sampler => Bound::Sampler(self.sampler(bind.handle)),
                Kind::Constant | Kind::Buffer { .. } => {
                    let buffer =
                        self.buffer(bind.handle).map_err(|error| format!("{}: {error}", variable.name))?;
                    Bound::Buffer(buffer, bind.offset, bind.size)
                }
                Kind::Texture(shape) | Kind::Image(shape) => {
                    let texture =
                        self.texture(bind.handle).map_err(|error| format!("{}: {error}", variable.name))?;
                    format = Some(texture.format());
                    let written = matches!(variable.kind, Kind::Image(_));
                    Bound::Texture(view(&texture, shape, written.then_some(bind.level)))
                }
            });
            entries
                .push((variable.binding, binding_type(variable.kind, format, module.constants_in_storage)));
        }
        Ok((entries, bound))
    }

    fn group(&self, layout: &wgpu::BindGroupLayout, entries: &[Entry], bound: &[Bound]) -> wgpu::BindGroup {
        let entries: Vec<_> = entries
            .iter()
            .zip(bound)
            .map(|((binding, _), bound)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: match bound {
                    Bound::Buffer(buffer, offset, size) => {
                        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                            buffer,
                            offset: *offset,
                            size: std::num::NonZeroU64::new(*size),
                        })
                    }
                    Bound::Texture(view) => wgpu::BindingResource::TextureView(view),
                    Bound::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
                },
            })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    fn sampler(&mut self, number: u32) -> wgpu::Sampler {
        let device = &self.device;
        let make = || {
            let filter = if number & 3 == 0 { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear };
            let address = match number >> 2 {
                0 => wgpu::AddressMode::Repeat,
                1 => wgpu::AddressMode::ClampToEdge,
                _ => wgpu::AddressMode::MirrorRepeat,
            };
            device.create_sampler(&wgpu::SamplerDescriptor {
                address_mode_u: address,
                address_mode_v: address,
                address_mode_w: address,
                mag_filter: filter,
                min_filter: filter,
                ..Default::default()
            })
        };
        self.samplers.entry(number).or_insert_with(make).clone()
    }

    pub fn dispatch(&mut self, kernel: u32, binds: &[Bind], groups: [u32; 3]) -> Result<(), String> {
        let module = self.kernels.get(kernel as usize).ok_or("there is no such kernel")?.module.clone();
        let (entries, bound) = self.bound(&module, 0, binds)?;
        let (pipeline, layout) =
            self.kernels[kernel as usize].pipeline(&self.device, entries.clone()).clone();
        let group = self.group(&layout, &entries, &bound);
        self.commands.push(Command::Dispatch { pipeline, group, groups });
        Ok(())
    }

    fn views(&self, target: &Target) -> Result<(Views, Targets), String> {
        let of =
            |handle: u32, layer: u32| -> Result<Option<(wgpu::TextureView, wgpu::TextureFormat)>, String> {
                if handle == 0 {
                    return Ok(None);
                }
                let texture = self.texture(handle)?;
                let view = texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2),
                    base_mip_level: 0,
                    mip_level_count: Some(1),
                    base_array_layer: layer,
                    array_layer_count: Some(1),
                    ..Default::default()
                });
                Ok(Some((view, texture.format())))
            };
        let (color, depth) = (of(target.color, target.color_layer)?, of(target.depth, target.depth_layer)?);
        let targets = Targets {
            color: color.as_ref().map(|color| color.1),
            depth: depth.as_ref().map(|depth| depth.1),
        };
        Ok((
            Views { color: color.map(|c| c.0), depth: depth.map(|d| d.0), viewport: target.viewport },
            targets,
        ))
    }

    pub fn draw(
        &mut self,
        program: u32,
        target: &Target,
        state: DrawState,
        binds: &[Bind],
        vertices: u32,
        instances: u32,
    ) -> Result<(), String> {
        let modules = self.programs.get(program as usize).ok_or("there is no such program")?.modules.clone();
        let (views, targets) = self.views(target)?;
        let (vertex_entries, vertex_bound) = self.bound(&modules[0], 0, binds)?;
        let (fragment_entries, fragment_bound) = self.bound(&modules[1], 1, binds)?;
        let entries = [vertex_entries.clone(), fragment_entries.clone()];
        let (pipeline, layouts) =
            self.programs[program as usize].pipeline(&self.device, state, targets, entries)?.clone();
        let groups = [
            self.group(&layouts[0], &vertex_entries, &vertex_bound),
            self.group(&layouts[1], &fragment_entries, &fragment_bound),
        ];
        self.commands.push(Command::Draw { pipeline, groups, views, vertices, instances });
        Ok(())
    }

    pub fn clear(
        &mut self,
        target: &Target,
        color: Option<[f32; 4]>,
        depth: Option<f32>,
    ) -> Result<(), String> {
        let (views, _) = self.views(target)?;
        self.commands.push(Command::Clear { views, color, depth });
        Ok(())
    }

    /// Hands all that was recorded to the device, as one submission.
    pub fn submit(&mut self) {
        if self.commands.is_empty() {
            return;
        }
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: (self.arena.len() as u64).next_multiple_of(16).max(16),
            usage: wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: true,
        });
        if !self.arena.is_empty() {
            staging.slice(..self.arena.len() as u64).get_mapped_range_mut().copy_from_slice(&self.arena);
        }
        staging.unmap();
        self.arena.clear();
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let commands = std::mem::take(&mut self.commands);
        commands::encode(&mut encoder, &staging, &commands);
        self.queue.submit([encoder.finish()]);
        self.submissions += 1;
        for number in self.pending.drain(..) {
            if let Some(ticket) = self.tickets.get_mut(&number) {
                let (tell, arrived) = mpsc::channel();
                // Nobody may be waiting any more.
                ticket.buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| drop(tell.send(result)));
                ticket.arrived = Some(arrived);
            }
        }
    }
}

#[derive(Debug)]
enum Bound {
    Buffer(wgpu::Buffer, u64, u64),
    Texture(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}
