//! Textures, made where a recording wants them or ahead of that, on another thread.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lumivox_renderer::ResourceId;
use lumivox_renderer::recording::{TextureFormat, TextureOrder};

use crate::submission::at_once;

/// Bytes from which on it takes longer than a frame may be late to fill a texture with zeros.
const LARGE_BYTES: u64 = 16 << 20;

/// Textures that are made and that no recording has met yet.
#[derive(Clone, Debug, Default)]
pub(crate) struct MadeAhead(Arc<Mutex<HashMap<ResourceId, wgpu::Texture>>>);

impl MadeAhead {
    pub fn take(&self, id: ResourceId) -> Option<wgpu::Texture> {
        self.lock().remove(&id)
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<ResourceId, wgpu::Texture>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Makes large textures for an [`Executor`](crate::Executor), on any thread; clones make them for the same.
#[derive(Clone, Debug)]
pub struct TextureMaker {
    device: wgpu::Device,
    made: MadeAhead,
}

impl TextureMaker {
    pub(crate) fn new(device: wgpu::Device, made: MadeAhead) -> Self {
        Self { device, made }
    }

    /// Makes a texture that a recording will want; false where there is no memory for it. What
    /// [`Preparation::run_with`](lumivox_renderer::Preparation::run_with) takes.
    pub fn make(&self, order: &TextureOrder) -> bool {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let texture = create(&self.device, order);
        // In browsers that is told later: the recording that takes it finds out.
        if at_once(Box::pin(scope.pop())).flatten().is_some() {
            return false;
        }
        self.made.lock().insert(order.id, texture);
        true
    }
}

/// A texture of the renderer's. Errors go to the device's scopes.
pub(crate) fn create(device: &wgpu::Device, order: &TextureOrder) -> wgpu::Texture {
    let [width, height, depth] = order.size;
    let flat = depth == 0;
    let descriptor = wgpu::TextureDescriptor {
        label: Some(order.label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: depth.max(1) },
        mip_level_count: 1,
        sample_count: 1,
        dimension: if flat { wgpu::TextureDimension::D2 } else { wgpu::TextureDimension::D3 },
        format: match order.format {
            TextureFormat::R8Unorm => wgpu::TextureFormat::R8Unorm,
            TextureFormat::R16Unorm => wgpu::TextureFormat::R16Unorm,
            TextureFormat::Rg8Unorm => wgpu::TextureFormat::Rg8Unorm,
            TextureFormat::R16Float => wgpu::TextureFormat::R16Float,
            TextureFormat::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
        },
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    };
    let bytes = [width, height, depth].iter().map(|&n| u64::from(n)).product::<u64>()
        * order.format.bytes_per_texel() as u64;
    // What is no number would be one in a filter that reaches an edge, with a weight of nothing: floats are filled.
    let may_hold_anything =
        matches!(order.format, TextureFormat::R8Unorm | TextureFormat::R16Unorm | TextureFormat::Rg8Unorm);
    let unfilled =
        if bytes >= LARGE_BYTES && may_hold_anything { create_unfilled(device, &descriptor) } else { None };
    unfilled.unwrap_or_else(|| device.create_texture(&descriptor))
}

/// A texture that wgpu does not fill with zeros when it is bound first, which takes 9 ms for 300 MB on an H200; `None`
/// where that cannot be had, for want of memory too.
#[cfg(not(any(target_vendor = "apple", target_family = "wasm")))]
fn create_unfilled(device: &wgpu::Device, descriptor: &wgpu::TextureDescriptor<'_>) -> Option<wgpu::Texture> {
    use wgpu::hal::{self, Device as _, api::Vulkan};

    // SAFETY: nothing of the device is destroyed or kept.
    let raw = unsafe { device.as_hal::<Vulkan>() }?;
    let hal_descriptor = hal::TextureDescriptor {
        label: descriptor.label,
        size: descriptor.size,
        mip_level_count: descriptor.mip_level_count,
        sample_count: descriptor.sample_count,
        dimension: descriptor.dimension,
        format: descriptor.format,
        usage: wgpu::TextureUses::RESOURCE | wgpu::TextureUses::COPY_DST | wgpu::TextureUses::COPY_SRC,
        memory_flags: hal::MemoryFlags::empty(),
        view_formats: vec![],
    };
    // SAFETY: the renderer keeps to the limits that the executor told it, as to size, and to formats that can be
    // filtered and copied.
    let texture = unsafe { raw.create_texture(&hal_descriptor) }.ok()?;
    drop(raw);
    // SAFETY: it was made on this device, as described. It holds whatever was in its memory, and that is never seen:
    // kernels read bricks of voxels alone that were written whole before, and a copy into a larger texture takes what it
    // finds where no brick is.
    Some(unsafe { device.create_texture_from_hal::<Vulkan>(texture, descriptor) })
}

#[cfg(any(target_vendor = "apple", target_family = "wasm"))]
fn create_unfilled(_: &wgpu::Device, _: &wgpu::TextureDescriptor<'_>) -> Option<wgpu::Texture> {
    None
}
