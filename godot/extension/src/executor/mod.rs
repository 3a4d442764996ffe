//! Replays recordings on Godot's RenderingDevice. Everything here runs on the render thread, but for the [`workshop`] that
//! makes kernels, and for what is [made ahead](make_ahead).

mod packed;
mod pipelines;
mod resolved_depth;
mod spirv;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use godot::classes::rendering_device::{
    DataFormat, Limit, SamplerFilter, TextureType, TextureUsageBits, UniformType,
};
use godot::classes::{
    RdSamplerState, RdTextureFormat, RdTextureView, RdUniform, RenderingDevice, RenderingServer,
};
use godot::global::Error;
use godot::prelude::*;
use lumivox_renderer::recording::{BindingKind, Kernel, Payload, TextureFormat, TextureOrder};
use lumivox_renderer::{DeviceLimits, FineTexels, LoopTurns, Recording, ResourceId, Step};

pub use self::pipelines::workshop;
use self::pipelines::{Pipelines, is_software};
use self::resolved_depth::ResolvedDepth;

/// Uniform sets that are kept; more are made anew.
const MAX_UNIFORM_SETS: usize = 512;

/// Why a recording could not be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ExecuteError {
    /// A shader or pipeline cannot be made.
    #[error("the graphics driver cannot run Lumivox' kernel '{kernel}': {why}. Update the driver")]
    Kernel {
        /// Its entry point.
        kernel: &'static str,
        /// What went wrong.
        why: String,
    },
    /// A buffer or texture cannot be made.
    #[error("the GPU has no room for '{what}' ({megabytes} MB). Use smaller or fewer volumes")]
    Memory {
        /// What it holds.
        what: &'static str,
        /// Its size.
        megabytes: u64,
    },
    /// A step names what is not there.
    #[error("a fault in Lumivox: {0}")]
    Fault(String),
}

/// A texture that is not made before it is known whether it comes with its texels.
#[derive(Clone, Copy)]
struct Plan {
    label: &'static str,
    format: TextureFormat,
    size: [u32; 3],
}

enum Resource {
    Buffer(Rid, u64),
    Texture(Rid, Plan),
    Planned(Plan),
    /// The host's own.
    Lent(Rid),
}

/// Replays recordings. Owns what they make until it is freed.
#[derive(Default)]
pub struct Executor {
    resources: HashMap<ResourceId, Resource>,
    pipelines: Pipelines,
    sampler: Option<Rid>,
    /// Uniform buffers by size, and how many of each the recording under way has used.
    uniforms: HashMap<u32, (Vec<Rid>, usize)>,
    sets: HashMap<(Kernel, Vec<Rid>), Rid>,
    resolved_depth: ResolvedDepth,
}

/// Textures that are made and that no recording has met yet.
fn made_ahead() -> MutexGuard<'static, HashMap<ResourceId, Rid>> {
    static MADE: LazyLock<Mutex<HashMap<ResourceId, Rid>>> = LazyLock::new(Mutex::default);
    MADE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether there is a device. Held while a texture is made on another thread, which the engine does not wait for when it
/// ends.
static IS_OPEN: Mutex<bool> = Mutex::new(false);

/// The engine is up: textures may be made ahead until the executor [frees everything](Executor::free).
pub fn open() {
    *IS_OPEN.lock().unwrap_or_else(PoisonError::into_inner) = true;
}

/// Makes a texture that a recording will want, on whatever thread; false where it cannot be had. What
/// [`Preparation::run_with`](lumivox_renderer::Preparation::run_with) takes.
pub fn make_ahead(order: &TextureOrder) -> bool {
    let is_open = IS_OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    if !*is_open {
        return false;
    }
    let Some(mut device) = RenderingServer::singleton().get_rendering_device() else { return false };
    let TextureOrder { id, label, format, size } = *order;
    let made = create_texture(&mut device, Plan { label, format, size }, None);
    made.map(|texture| made_ahead().insert(id, texture)).is_ok()
}

/// Bytes that a device binds at once, which Godot does not tell. Every Vulkan device binds 128 MiB, software and many GPUs of
/// phones no more; the drivers of desktops' GPUs bind 1 GiB and above.
fn storage_binding(vendor: &str, on_cpu: bool) -> u64 {
    let is_of_desktops =
        ["NVIDIA", "AMD", "Intel", "Apple"].iter().any(|name| vendor.eq_ignore_ascii_case(name));
    if is_of_desktops && !on_cpu { 1 << 30 } else { 128 << 20 }
}

impl Executor {
    /// What the renderer needs to know of the device.
    pub fn limits(device: &Gd<RenderingDevice>) -> DeviceLimits {
        let limit = |limit| device.limit_get(limit).min(u64::from(u32::MAX)) as u32;
        let on_cpu = is_software();
        let vendor = RenderingServer::singleton().get_video_adapter_vendor().to_string();
        DeviceLimits::webgpu_default().with(|it| {
            it.max_texture_3d = limit(Limit::MAX_TEXTURE_SIZE_3D);
            it.max_texture_bytes = match on_cpu {
                true => DeviceLimits::TEXTURE_BYTES_OF_SOFTWARE,
                false => DeviceLimits::TEXTURE_BYTES_OF_GPU,
            };
            if device
                .texture_is_format_supported_for_usage(DataFormat::R16_UNORM, TextureUsageBits::SAMPLING_BIT)
            {
                it.fine_texels = FineTexels::Norms;
            }
            it.one_pool = on_cpu;
            it.max_texture_2d = limit(Limit::MAX_TEXTURE_SIZE_2D);
            it.max_storage_binding = storage_binding(&vendor, on_cpu);
            it.max_samples_per_dispatch = match on_cpu {
                true => DeviceLimits::SAMPLES_OF_SOFTWARE,
                false => DeviceLimits::SAMPLES_OF_GPU,
            };
            // Godot does not tell how wide the vectors are.
            it.loop_turns = on_cpu.then(|| LoopTurns::of_software(16));
        })
    }

    /// Lends a texture of the host's under a name, until it is lent anew or [freed](Step::Free).
    pub fn lend(&mut self, id: ResourceId, texture: Rid) {
        self.resources.insert(id, Resource::Lent(texture));
    }

    /// Hands the recording to the device. The read-backs come in the order of their steps, frames later. The time from
    /// the first tracing step to the last is captured under `timed`.
    ///
    /// # Errors
    /// [`ExecuteError`] when the device refuses a step; those before it have happened.
    pub fn execute(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        recording: &Recording,
        timed: &str,
    ) -> Result<Vec<Receiver<Vec<u8>>>, ExecuteError> {
        for (_, used) in self.uniforms.values_mut() {
            *used = 0;
        }
        let traces = |step: &Step| matches!(step, Step::Dispatch { kernel: Kernel::PathTrace(_), .. });
        let first = recording.steps.iter().position(traces);
        let last = recording.steps.iter().rposition(traces);
        let mut read_backs = vec![];
        for (i, step) in recording.steps.iter().enumerate() {
            if Some(i) == first {
                device.capture_timestamp(&format!("{timed} begin"));
            }
            self.step(device, step, &mut read_backs)?;
            if Some(i) == last {
                device.capture_timestamp(&format!("{timed} end"));
            }
        }
        Ok(read_backs)
    }

    /// Stores the depth in a buffer, one for each pixel, in a lent texture that the host has resolved a depth to, where that
    /// can be stored to.
    ///
    /// # Errors
    /// [`ExecuteError`] when the driver does not.
    pub fn store_resolved_depth(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        picture: ResourceId,
        target: ResourceId,
    ) -> Result<(), ExecuteError> {
        let ((picture, _), target) = (self.buffer(picture)?, self.texture(device, target)?);
        let stored = self.resolved_depth.store(device, picture, target);
        stored.map_err(|(kernel, why)| ExecuteError::Kernel { kernel, why })
    }

    /// Waits until everything that was handed over is done and every read-back has come.
    pub fn finish(&self, device: &mut Gd<RenderingDevice>) {
        let buffer = self.resources.values().find_map(|resource| match resource {
            Resource::Buffer(buffer, _) => Some(*buffer),
            _ => None,
        });
        if let Some(buffer) = buffer {
            // To look at any buffer at once, the device ends all frames and delivers what was asked for in them.
            device.buffer_get_data_ex(buffer).size_bytes(4).done();
        }
    }

    /// Frees every resource that `recording` makes or would have freed: after an error nobody else will.
    pub fn discard(&mut self, device: &mut Gd<RenderingDevice>, recording: &Recording) {
        for step in &recording.steps {
            if let Step::CreateBuffer { id, .. } | Step::CreateTexture { id, .. } | Step::Free { id } = step {
                self.free_resource(device, *id);
            }
        }
    }

    /// Frees everything.
    pub fn free(&mut self, device: &mut Gd<RenderingDevice>) {
        self.free_sets(device);
        let ids: Vec<ResourceId> = self.resources.keys().copied().collect();
        for id in ids {
            self.free_resource(device, id);
        }
        for buffer in self.uniforms.drain().flat_map(|(_, (buffers, _))| buffers) {
            device.free_rid(buffer);
        }
        if let Some(sampler) = self.sampler.take() {
            device.free_rid(sampler);
        }
        *IS_OPEN.lock().unwrap_or_else(PoisonError::into_inner) = false;
        for texture in made_ahead().drain().map(|(_, texture)| texture) {
            device.free_rid(texture);
        }
        self.pipelines.free(device);
        self.resolved_depth.free(device);
        packed::free();
    }

    fn step(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        step: &Step,
        read_backs: &mut Vec<Receiver<Vec<u8>>>,
    ) -> Result<(), ExecuteError> {
        match step {
            Step::CreateBuffer { id, label, size } => {
                let no_room = || ExecuteError::Memory { what: label, megabytes: size >> 20 };
                let bytes = u32::try_from(*size).map_err(|_| no_room())?;
                let buffer = device.storage_buffer_create(bytes);
                if !buffer.is_valid() {
                    return Err(no_room());
                }
                device.set_resource_name(buffer, &format!("Lumivox {label}"));
                device.buffer_clear(buffer, 0, bytes);
                self.resources.insert(*id, Resource::Buffer(buffer, *size));
            }
            Step::CreateTexture { id, label, format, size } => {
                let plan = Plan { label, format: *format, size: *size };
                let resource = match made_ahead().remove(id) {
                    Some(texture) => Resource::Texture(texture, plan),
                    None => Resource::Planned(plan),
                };
                self.resources.insert(*id, resource);
            }
            Step::WriteBuffer { id, offset, data } => {
                let (buffer, _) = self.buffer(*id)?;
                let bytes = data.bytes();
                let packed = packed::copy_of(bytes);
                device.buffer_update(buffer, *offset as u32, bytes.len() as u32, &packed);
            }
            Step::WriteTexture { id, origin, size, data } => {
                self.write_texture(device, *id, *origin, *size, data)?;
            }
            Step::CopyTexture { from, to, origin, size } => {
                let (from, to) = (self.texture(device, *from)?, self.texture(device, *to)?);
                copy_texture(device, (from, *origin), (to, *origin), *size)?;
            }
            Step::ClearBuffer { id } => {
                let (buffer, size) = self.buffer(*id)?;
                device.buffer_clear(buffer, 0, size as u32);
            }
            Step::Dispatch { kernel, uniforms, resources, workgroups: [x, y] } => {
                let pipeline = self.pipelines.compute(*kernel)?;
                let set = self.uniform_set(device, *kernel, uniforms, resources)?;
                let list = device.compute_list_begin();
                device.compute_list_bind_compute_pipeline(list, pipeline);
                device.compute_list_bind_uniform_set(list, set, 0);
                device.compute_list_dispatch(list, *x, *y, 1);
                device.compute_list_end();
            }
            Step::Draw { kernel, uniforms, resources, target } => {
                let target = self.texture(device, *target)?;
                let (framebuffer, pipeline) = self.pipelines.draw(device, *kernel, target)?;
                let set = self.uniform_set(device, *kernel, uniforms, resources)?;
                let list = device.draw_list_begin(framebuffer);
                device.draw_list_bind_render_pipeline(list, pipeline);
                device.draw_list_bind_uniform_set(list, set, 0);
                device.draw_list_draw_ex(list, false, 1).procedural_vertex_count(3).done();
                device.draw_list_end();
            }
            Step::ReadBuffer { id, range } => read_backs.push(self.read_back(device, *id, range)?),
            Step::Free { id } => self.free_resource(device, *id),
        }
        Ok(())
    }

    fn buffer(&self, id: ResourceId) -> Result<(Rid, u64), ExecuteError> {
        match self.resources.get(&id) {
            Some(Resource::Buffer(buffer, size)) => Ok((*buffer, *size)),
            _ => Err(ExecuteError::Fault(format!("{id:?} is no buffer"))),
        }
    }

    /// A texture that exists by now.
    fn texture(&mut self, device: &mut Gd<RenderingDevice>, id: ResourceId) -> Result<Rid, ExecuteError> {
        match self.resources.get(&id) {
            Some(Resource::Texture(texture, _) | Resource::Lent(texture)) => Ok(*texture),
            Some(Resource::Planned(plan)) => {
                let plan = *plan;
                let texture = create_texture(device, plan, None)?;
                self.resources.insert(id, Resource::Texture(texture, plan));
                Ok(texture)
            }
            _ => Err(ExecuteError::Fault(format!("{id:?} is no texture"))),
        }
    }

    fn write_texture(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        id: ResourceId,
        origin: [u32; 3],
        size: [u32; 3],
        data: &Payload,
    ) -> Result<(), ExecuteError> {
        let (plan, planned) = match self.resources.get(&id) {
            Some(Resource::Planned(plan)) => (*plan, true),
            Some(Resource::Texture(_, plan)) => (*plan, false),
            _ => return Err(ExecuteError::Fault(format!("{id:?} is no texture of its own"))),
        };
        let [width, height, depth] = plan.size;
        if planned && origin == [0; 3] && size == [width, height, depth.max(1)] {
            let texture = create_texture(device, plan, Some(packed::copy_of(data.bytes())))?;
            self.resources.insert(id, Resource::Texture(texture, plan));
            return Ok(());
        }
        // The device uploads whole textures only: a box goes through one of its own.
        let texture = self.texture(device, id)?;
        let flat = depth == 0;
        let box_size = if flat { [size[0], size[1], 0] } else { size };
        let data = packed::copy_of(data.bytes());
        let staging = create_texture(device, Plan { size: box_size, ..plan }, Some(data))?;
        let copied = copy_texture(device, (staging, [0; 3]), (texture, origin), size);
        device.free_rid(staging);
        copied
    }

    fn uniform_set(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        kernel: Kernel,
        uniforms: &[Vec<u8>],
        resources: &[ResourceId],
    ) -> Result<Rid, ExecuteError> {
        let (mut uniforms, mut resources) = (uniforms.iter(), resources.iter());
        let mut next = || {
            let missing = || ExecuteError::Fault(format!("a binding of {kernel:?} is missing"));
            resources.next().copied().ok_or_else(missing)
        };
        let mut bound = vec![];
        for kind in kernel.bindings() {
            let rid = match kind {
                BindingKind::Uniform => {
                    let bytes = uniforms.next().map_or(&[][..], |bytes| bytes);
                    self.uniform_buffer(device, bytes)?
                }
                BindingKind::LinearSampler => self.linear_sampler(device),
                BindingKind::StorageRead | BindingKind::StorageReadWrite => self.buffer(next()?)?.0,
                BindingKind::Texture3d | BindingKind::Texture2dLoaded => {
                    let id = next()?;
                    self.texture(device, id)?
                }
            };
            bound.push(rid);
        }
        let key = (kernel, bound);
        if let Some(set) = self.sets.get(&key) {
            // A set goes with whatever it binds.
            if device.uniform_set_is_valid(*set) {
                return Ok(*set);
            }
            self.sets.remove(&key);
        }
        if self.sets.len() >= MAX_UNIFORM_SETS {
            self.free_sets(device);
        }
        let mut list = Array::<Gd<RdUniform>>::new();
        for (binding, (kind, rid)) in (0..).zip(kernel.bindings().iter().zip(&key.1)) {
            let mut uniform = RdUniform::new_gd();
            uniform.set_uniform_type(uniform_type(*kind));
            uniform.set_binding(binding);
            uniform.add_id(*rid);
            list.push(&uniform);
        }
        let shader = self.pipelines.shader(kernel)?;
        let set = device.uniform_set_create(&list, shader, 0);
        if !set.is_valid() {
            let why = "its buffers and textures cannot be bound".to_owned();
            return Err(ExecuteError::Kernel { kernel: kernel.entry_point(), why });
        }
        self.sets.insert(key, set);
        Ok(set)
    }

    /// A uniform buffer with these contents. Updates and dispatches happen in order, so that a buffer can be used again
    /// in the next recording.
    fn uniform_buffer(
        &mut self,
        device: &mut Gd<RenderingDevice>,
        bytes: &[u8],
    ) -> Result<Rid, ExecuteError> {
        let size = (bytes.len() as u32).next_multiple_of(16).max(16);
        let packed = PackedByteArray::from(bytes);
        let (buffers, used) = self.uniforms.entry(size).or_default();
        if *used == buffers.len() {
            let buffer = match is_software() {
                true => device.storage_buffer_create(size),
                false => device.uniform_buffer_create(size),
            };
            if !buffer.is_valid() {
                return Err(ExecuteError::Memory { what: "uniforms", megabytes: 0 });
            }
            buffers.push(buffer);
        }
        let buffer = buffers[*used];
        *used += 1;
        device.buffer_update(buffer, 0, bytes.len() as u32, &packed);
        Ok(buffer)
    }

    fn linear_sampler(&mut self, device: &mut Gd<RenderingDevice>) -> Rid {
        *self.sampler.get_or_insert_with(|| {
            let mut state = RdSamplerState::new_gd();
            state.set_min_filter(SamplerFilter::LINEAR);
            state.set_mag_filter(SamplerFilter::LINEAR);
            device.sampler_create(&state)
        })
    }

    fn read_back(
        &self,
        device: &mut Gd<RenderingDevice>,
        id: ResourceId,
        range: &Range<u64>,
    ) -> Result<Receiver<Vec<u8>>, ExecuteError> {
        let (buffer, _) = self.buffer(id)?;
        let (send, receive) = channel();
        let arrived = Callable::from_sync_fn("lumivox_read_back", move |arguments: &[&Variant]| {
            if let Some(Ok(bytes)) = arguments.first().map(|bytes| bytes.try_to::<PackedByteArray>()) {
                // Nobody listens any more where the view is gone.
                let _ = send.send(bytes.to_vec());
            }
        });
        device
            .buffer_get_data_async_ex(buffer, &arrived)
            .offset_bytes(range.start as u32)
            .size_bytes((range.end - range.start) as u32)
            .done();
        Ok(receive)
    }

    fn free_resource(&mut self, device: &mut Gd<RenderingDevice>, id: ResourceId) {
        match self.resources.remove(&id) {
            Some(Resource::Buffer(rid, _) | Resource::Texture(rid, _)) => device.free_rid(rid),
            Some(Resource::Planned(_) | Resource::Lent(_)) => {}
            None => {
                if let Some(texture) = made_ahead().remove(&id) {
                    device.free_rid(texture);
                }
            }
        }
    }

    fn free_sets(&mut self, device: &mut Gd<RenderingDevice>) {
        for (_, set) in self.sets.drain() {
            if device.uniform_set_is_valid(set) {
                device.free_rid(set);
            }
        }
    }
}

fn uniform_type(kind: BindingKind) -> UniformType {
    match kind {
        BindingKind::Uniform if is_software() => UniformType::STORAGE_BUFFER,
        BindingKind::Uniform => UniformType::UNIFORM_BUFFER,
        BindingKind::StorageRead | BindingKind::StorageReadWrite => UniformType::STORAGE_BUFFER,
        BindingKind::Texture3d | BindingKind::Texture2dLoaded => UniformType::TEXTURE,
        BindingKind::LinearSampler => UniformType::SAMPLER,
    }
}

/// Copies the first box of a texture into another.
fn copy_texture(
    device: &mut Gd<RenderingDevice>,
    (from, from_origin): (Rid, [u32; 3]),
    (to, to_origin): (Rid, [u32; 3]),
    size: [u32; 3],
) -> Result<(), ExecuteError> {
    let at = |v: [u32; 3]| Vector3::new(v[0] as f32, v[1] as f32, v[2] as f32);
    match device.texture_copy(from, to, at(from_origin), at(to_origin), at(size), 0, 0, 0, 0) {
        Error::OK => Ok(()),
        error => Err(ExecuteError::Fault(format!("a texture cannot be written: {error:?}"))),
    }
}

fn create_texture(
    device: &mut Gd<RenderingDevice>,
    plan: Plan,
    data: Option<PackedByteArray>,
) -> Result<Rid, ExecuteError> {
    let [width, height, depth] = plan.size;
    let mut format = RdTextureFormat::new_gd();
    format.set_texture_type(if depth == 0 { TextureType::TYPE_2D } else { TextureType::TYPE_3D });
    format.set_format(match plan.format {
        TextureFormat::R8Unorm => DataFormat::R8_UNORM,
        TextureFormat::R16Unorm => DataFormat::R16_UNORM,
        TextureFormat::Rg8Unorm => DataFormat::R8G8_UNORM,
        TextureFormat::R16Float => DataFormat::R16_SFLOAT,
        TextureFormat::Rgba32Float => DataFormat::R32G32B32A32_SFLOAT,
    });
    format.set_width(width);
    format.set_height(height);
    format.set_depth(depth.max(1));
    format.set_usage_bits(
        TextureUsageBits::SAMPLING_BIT
            | TextureUsageBits::CAN_COPY_TO_BIT
            | TextureUsageBits::CAN_COPY_FROM_BIT
            | TextureUsageBits::CAN_UPDATE_BIT,
    );
    let mut layers = Array::<PackedByteArray>::new();
    if let Some(data) = data {
        layers.push(&data);
    }
    let view = RdTextureView::new_gd();
    let texture = device.texture_create_ex(&format, &view).data(&layers).done();
    if texture.is_valid() {
        device.set_resource_name(texture, &format!("Lumivox {}", plan.label));
        return Ok(texture);
    }
    let texels: u64 = plan.size.iter().map(|&n| u64::from(n.max(1))).product();
    let megabytes = (texels * plan.format.bytes_per_texel() as u64) >> 20;
    Err(ExecuteError::Memory { what: plan.label, megabytes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_known_to_bind_much_does() {
        assert_eq!(storage_binding("NVIDIA", false), 1 << 30);
        for (vendor, on_cpu) in [("Qualcomm", false), ("ARM", false), ("Unknown", false), ("Intel", true)] {
            assert_eq!(storage_binding(vendor, on_cpu), 128 << 20, "{vendor}");
        }
    }
}
