//! An engine in miniature on the wgpu host.

use std::ptr::null;

use half::f16;
use lumivox_renderer::ResourceId;
use lumivox_unity::abi::*;
use lumivox_unity::stage::*;
use lumivox_unity::steps::LumivoxRecording;
use lumivox_wgpu::{Gpu, wgpu};

/// A stage of its own, on a device of its own.
pub struct LumivoxTwin {
    gpu: Gpu,
    stage: *mut LumivoxStage,
}

/// A twin for a device of such limits.
///
/// # Safety
/// `limits` points to limits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_twin_new(limits: *const LumivoxDeviceLimits) -> *mut LumivoxTwin {
    let gpu = Gpu::open(None).expect("a Vulkan device");
    // SAFETY: as the caller promises.
    let stage = unsafe { lumivox_stage_new(limits) };
    assert!(!stage.is_null(), "there is a stage");
    Box::into_raw(Box::new(LumivoxTwin { gpu, stage }))
}

/// Frees a twin.
///
/// # Safety
/// `twin` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_twin_free(twin: *mut LumivoxTwin) {
    // SAFETY: as the caller promises.
    unsafe {
        let twin = Box::from_raw(twin);
        lumivox_stage_free(twin.stage);
    }
}

/// Its stage, for `lumivox_stage_set_world` and `lumivox_stage_view_status`.
///
/// # Safety
/// `twin` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_twin_stage(twin: *const LumivoxTwin) -> *mut LumivoxStage {
    // SAFETY: as the caller promises.
    unsafe { (*twin).stage }
}

/// Draws one frame of a view, as the package does: the world, then the view over `color` (RGBA, `size` of the frame) behind
/// `depth`, in rows as the frame's projection has them; both are replaced by what the frame leaves in them. -1 where
/// something is refused; `lumivox_last_error` says what.
///
/// # Safety
/// `twin` is a live handle, `frame` points to a frame, `color` to 4 floats a pixel, `depth` to one; `status` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_twin_draw(
    twin: *mut LumivoxTwin,
    view: u64,
    world: u64,
    frame: *const LumivoxViewFrame,
    color: *mut f32,
    depth: *mut f32,
    status: *mut LumivoxViewStatus,
) -> i32 {
    // SAFETY: as the caller promises.
    let (twin, frame) = unsafe { (&mut *twin, &*frame) };
    let [width, height] = frame.size;
    let pixels = width as usize * height as usize;
    // SAFETY: as the caller promises.
    let (color, depth) = unsafe {
        (std::slice::from_raw_parts_mut(color, 4 * pixels), std::slice::from_raw_parts_mut(depth, pixels))
    };
    // SAFETY: the stage lives as long as the twin.
    let recording = unsafe {
        lumivox_stage_begin_frame(twin.stage);
        lumivox_stage_record_world(twin.stage, world, frame.at_once)
    };
    if !recording.is_null() && twin.replay(recording, 0) != 0 {
        return -1;
    }
    // SAFETY: as the caller promises.
    let recording = unsafe { lumivox_stage_record_view(twin.stage, view, world, frame, status) };
    if recording.is_null() {
        return 0;
    }
    // SAFETY: as the caller promises; it was just written.
    let status = unsafe { &*status };
    let textures = Textures::new(&twin.gpu, frame.size, color, depth);
    let names = [status.depth, status.color, status.written_depth].map(ResourceId);
    for (name, texture) in names.into_iter().zip([&textures.depth, &textures.color, &textures.written]) {
        twin.gpu.executor.lend_texture(name, texture);
    }
    if twin.replay(recording, status.ticket) != 0 {
        return -1;
    }
    textures.read(&twin.gpu, color, depth);
    0
}

impl LumivoxTwin {
    /// Replays a recording, waits for all that it brings back, and finishes it.
    fn replay(&mut self, recording: *mut LumivoxRecording, ticket: u64) -> i32 {
        // SAFETY: a live handle, freed below.
        let steps = unsafe { (*recording).recording() };
        let done = self.gpu.executor.execute(steps).and_then(|read_backs| {
            read_backs.into_iter().map(|read_back| read_back.wait()).collect::<Result<Vec<_>, _>>()
        });
        let outcome = match done {
            Ok(_) => LumivoxOutcome::Executed,
            Err(_) => LumivoxOutcome::Failed,
        };
        // SAFETY: live handles; the recording is freed here.
        let finished = unsafe { lumivox_recording_finish(self.stage, recording, outcome as u32, null()) };
        for bytes in done.into_iter().flatten() {
            // SAFETY: the bytes are there.
            unsafe {
                lumivox_stage_feedback(self.stage, ticket, bytes.as_ptr().cast(), bytes.len() as u64);
            }
        }
        finished
    }
}

/// What a frame is drawn with.
struct Textures {
    color: wgpu::Texture,
    depth: wgpu::Texture,
    written: wgpu::Texture,
}

impl Textures {
    fn new(gpu: &Gpu, [width, height]: [u32; 2], color: &[f32], depth: &[f32]) -> Self {
        let device = gpu.executor.device();
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            })
        };
        let target = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let textures = Self {
            color: texture(wgpu::TextureFormat::Rgba16Float, target),
            depth: texture(wgpu::TextureFormat::R32Float, wgpu::TextureUsages::TEXTURE_BINDING),
            written: texture(wgpu::TextureFormat::Depth32Float, target),
        };
        let halves: Vec<u16> = color.iter().map(|c| f16::from_f32(*c).to_bits()).collect();
        let write = |texture: &wgpu::Texture, bytes: &[u8], texel: u32| {
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * texel),
                rows_per_image: Some(height),
            };
            gpu.executor.queue().write_texture(texture.as_image_copy(), bytes, layout, size);
        };
        write(&textures.color, bytemuck::cast_slice(&halves), 8);
        write(&textures.depth, bytemuck::cast_slice(depth), 4);
        // A depth buffer takes no writes: what nobody draws stays 0, as where the host drew nothing.
        textures
    }

    /// What is in the colour now, and in the depth where volumes wrote any.
    fn read(&self, gpu: &Gpu, color: &mut [f32], depth: &mut [f32]) {
        let halves: Vec<u16> = bytemuck::pod_collect_to_vec(&read_texture(gpu, &self.color, 8));
        color.iter_mut().zip(halves).for_each(|(to, half)| *to = f16::from_bits(half).to_f32());
        let written: Vec<f32> = bytemuck::pod_collect_to_vec(&read_texture(gpu, &self.written, 4));
        for (to, written) in depth.iter_mut().zip(written) {
            if written != 0.0 {
                *to = written;
            }
        }
    }
}

/// The texels of a texture, without padding.
fn read_texture(gpu: &Gpu, texture: &wgpu::Texture, texel: u32) -> Vec<u8> {
    let (device, queue) = (gpu.executor.device(), gpu.executor.queue());
    let (width, height) = (texture.width(), texture.height());
    let row = (width * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: Some(height) };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.expect("a buffer that can be mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device goes on");
    let bytes = buffer.slice(..).get_mapped_range();
    bytes.chunks(row as usize).flat_map(|line| line[..(width * texel) as usize].to_vec()).collect()
}
