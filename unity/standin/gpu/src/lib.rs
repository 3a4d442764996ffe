//! What the stand-in `UnityEngine` does its GPU work with: resources by number, kernels and programs of SPIR-V, commands
//! that are submitted together. `unity/standin/UnityEngine/StandIn/Native.cs` is its only caller.
//!
//! No call panics or fails across the border: what is wrong is noted as text, which `sg_fault` tells.

// Only C# calls these; each does what its namesake in `gpu.rs` does.
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments, missing_docs)]

mod formats;
mod gpu;
mod pipelines;
mod spirv;
#[cfg(test)]
mod tests;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, OnceLock, PoisonError};

use gpu::{Bind, Gpu, Region, Target};
use pipelines::DrawState;

static GPU: OnceLock<Result<Mutex<Gpu>, String>> = OnceLock::new();

/// Does something with the device; what goes wrong is noted, and the outcome is the default.
fn with<T: Default>(work: impl FnOnce(&mut Gpu) -> Result<T, String>) -> T {
    let Ok(gpu) = GPU.get_or_init(|| Gpu::open().map(Mutex::new)) else { return T::default() };
    let mut gpu = gpu.lock().unwrap_or_else(PoisonError::into_inner);
    let outcome = catch_unwind(AssertUnwindSafe(|| work(&mut gpu)));
    match outcome {
        Ok(Ok(value)) => value,
        Ok(Err(fault)) => {
            gpu.fault(fault);
            T::default()
        }
        Err(_) => {
            gpu.fault("the GPU library panicked; what it printed says where".into());
            T::default()
        }
    }
}

unsafe fn slice<'a, T>(data: *const T, count: usize) -> &'a [T] {
    // SAFETY: the caller says that there are so many.
    if count == 0 { &[] } else { unsafe { std::slice::from_raw_parts(data, count) } }
}

/// Copies text into a buffer of `capacity` bytes and says how long it is, whether or not it fits.
unsafe fn put(text: &str, to: *mut u8, capacity: u32) -> u32 {
    let length = text.len().min(capacity as usize);
    // SAFETY: the caller says that there is so much room.
    unsafe { std::ptr::copy_nonoverlapping(text.as_ptr(), to, length) };
    text.len() as u32
}

/// Opens the device: 0, or the length of the text that says why there is none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_open(text: *mut u8, capacity: u32) -> u32 {
    match GPU.get_or_init(|| Gpu::open().map(Mutex::new)) {
        Ok(_) => 0,
        // SAFETY: as the caller says.
        Err(error) => unsafe { put(error, text, capacity) },
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_name(text: *mut u8, capacity: u32) -> u32 {
    // SAFETY: as the caller says.
    with(|gpu| Ok(unsafe { put(&gpu.name, text, capacity) }))
}

/// Numbers of the device: 0 largest side in 2D, 1 in 3D, 2 bytes of a storage binding, 3 bytes of a buffer, 4 threads of
/// a group, 5 resources alive, 6 submissions so far, 7 whether 32-bit floats are filtered.
#[unsafe(no_mangle)]
pub extern "C" fn sg_number(which: u32) -> u64 {
    with(|gpu| {
        Ok(match which {
            0 => gpu.limits.max_texture_dimension_2d.into(),
            1 => gpu.limits.max_texture_dimension_3d.into(),
            2 => gpu.limits.max_storage_buffer_binding_size,
            3 => gpu.limits.max_buffer_size,
            4 => gpu.limits.max_compute_invocations_per_workgroup.into(),
            5 => gpu.live() as u64,
            6 => gpu.submissions,
            7 => gpu.features.contains(wgpu::Features::FLOAT32_FILTERABLE).into(),
            _ => return Err(format!("there is no number {which}")),
        })
    })
}

/// The oldest fault that was not told: its length, or 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_fault(text: *mut u8, capacity: u32) -> u32 {
    // SAFETY: as the caller says.
    with(|gpu| Ok(gpu.next_fault().map_or(0, |fault| unsafe { put(&fault, text, capacity) })))
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_create_buffer(size: u64, constant: u32) -> u32 {
    with(|gpu| gpu.create_buffer(size, constant != 0))
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_create_texture(
    format: u32,
    dimension: u32,
    width: u32,
    height: u32,
    depth: u32,
    levels: u32,
    storage: u32,
    target: u32,
) -> u32 {
    with(|gpu| {
        gpu.create_texture(format, dimension, [width, height, depth], levels, storage != 0, target != 0)
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_free(handle: u32) {
    with(|gpu| gpu.free(handle));
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_write_buffer(buffer: u32, offset: u64, data: *const u8, length: u64) {
    // SAFETY: as the caller says.
    with(|gpu| gpu.write_buffer(buffer, offset, unsafe { slice(data, length as usize) }));
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_write_texture(
    to: Region,
    width: u32,
    height: u32,
    depth: u32,
    data: *const u8,
    length: u64,
) {
    // SAFETY: as the caller says.
    with(|gpu| gpu.write_texture(to, [width, height, depth], unsafe { slice(data, length as usize) }));
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_copy_buffer(from: u32, from_offset: u64, to: u32, to_offset: u64, size: u64) {
    with(|gpu| gpu.copy_buffer((from, from_offset), (to, to_offset), size));
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_copy_texture(from: Region, to: Region, width: u32, height: u32, depth: u32) {
    with(|gpu| gpu.copy_texture(from, to, [width, height, depth]));
}

/// Makes a kernel of SPIR-V: its number and one more, or 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_create_kernel(words: *const u32, count: u64) -> u32 {
    // SAFETY: as the caller says.
    with(|gpu| Ok(gpu.create_kernel(unsafe { slice(words, count as usize) }.to_vec())? + 1))
}

/// Makes a program of two stages: its number and one more, or 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_create_program(
    vertex: *const u32,
    vertex_count: u64,
    fragment: *const u32,
    fragment_count: u64,
) -> u32 {
    // SAFETY: as the caller says.
    let (vertex, fragment) =
        unsafe { (slice(vertex, vertex_count as usize), slice(fragment, fragment_count as usize)) };
    with(|gpu| Ok(gpu.create_program(vertex.to_vec(), fragment.to_vec())? + 1))
}

/// What a kernel (`stage` 2) or a program's stage (0, 1) binds, as lines of text: their length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_describe(number: u32, stage: u32, text: *mut u8, capacity: u32) -> u32 {
    with(|gpu| {
        let number = number.wrapping_sub(1);
        let found = if stage == 2 {
            gpu.describe_kernel(number)
        } else {
            gpu.describe_program(number, stage as usize)
        };
        // SAFETY: as the caller says.
        Ok(unsafe { put(&found.ok_or("there is no such kernel or program")?, text, capacity) })
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_dispatch(kernel: u32, binds: *const Bind, count: u32, x: u32, y: u32, z: u32) {
    // SAFETY: as the caller says.
    with(|gpu| gpu.dispatch(kernel.wrapping_sub(1), unsafe { slice(binds, count as usize) }, [x, y, z]));
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_draw(
    program: u32,
    target: Target,
    state: DrawState,
    binds: *const Bind,
    count: u32,
    vertices: u32,
    instances: u32,
) {
    with(|gpu| {
        // SAFETY: as the caller says.
        let binds = unsafe { slice(binds, count as usize) };
        gpu.draw(program.wrapping_sub(1), &target, state, binds, vertices, instances)
    });
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_clear(
    target: Target,
    color: u32,
    r: f32,
    g: f32,
    b: f32,
    a: f32,
    depth: u32,
    value: f32,
) {
    with(|gpu| gpu.clear(&target, (color != 0).then_some([r, g, b, a]), (depth != 0).then_some(value)));
}

/// Gives every pixel of a target its colour and depth: five floats each, row by row.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_fill(target: Target, width: u32, pixels: *const u8, length: u64) {
    // SAFETY: as the caller says.
    with(|gpu| gpu.fill(&target, width, unsafe { slice(pixels, length as usize) }));
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_blit(from: u32, layer: u32, target: Target, flip: u32) {
    with(|gpu| gpu.blit(from, layer, &target, flip != 0));
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_read_buffer(from: u32, offset: u64, size: u64) -> u32 {
    with(|gpu| gpu.read_buffer(from, offset, size))
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_read_texture(from: Region, width: u32, height: u32, depth: u32) -> u32 {
    with(|gpu| gpu.read_texture(from, [width, height, depth]))
}

#[unsafe(no_mangle)]
pub extern "C" fn sg_submit() {
    with(|gpu| {
        gpu.submit();
        Ok(())
    });
}

/// Waits for a read-back's bytes: 1, or 0 where there are none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sg_collect(ticket: u32, data: *mut u8, length: u64) -> u32 {
    with(|gpu| {
        // SAFETY: as the caller says.
        let bytes = if length == 0 {
            &mut []
        } else {
            unsafe { std::slice::from_raw_parts_mut(data, length as usize) }
        };
        gpu.collect(ticket, bytes)?;
        Ok(1)
    })
}
