//! An engine in miniature on the wgpu host.

use std::ptr::null;
use std::sync::MutexGuard;

use half::f16;
use lumivox_renderer::ResourceId;
use lumivox_unity::abi::*;
use lumivox_unity::stage::*;
use lumivox_unity::steps::LumivoxRecording;
use lumivox_wgpu::{Gpu, wgpu};

/// Frames in which a picture of a test is done.
const MOST_FRAMES: u32 = 4096;

const WORLD: u64 = 1;
const VIEW: u64 = 1;

/// The finished picture of what a view of the package's shows, by the wgpu host: over `color` (RGBA) and behind `depth`, in
/// rows as the view's projection has them, and as they were before volumes were drawn. Both are replaced. Returns the
/// samples of each pixel, or -1 where something is refused; `lumivox_last_error` says what.
///
/// # Safety
/// `stage` is a live handle; `color` points to 4 floats for each of the view's pixels, `depth` to one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_twin_picture(
    stage: *const LumivoxStage,
    view: u64,
    color: *mut f32,
    depth: *mut f32,
) -> i32 {
    // SAFETY: as the caller promises.
    let shown = unsafe { (*stage).shown_by(view) };
    let (scene, mut frame) = shown.expect("a view that was drawn");
    frame.at_once = 1;
    let pixels = frame.size[0] as usize * frame.size[1] as usize;
    // SAFETY: as the caller promises.
    let (color, depth) = unsafe {
        (std::slice::from_raw_parts_mut(color, 4 * pixels), std::slice::from_raw_parts_mut(depth, pixels))
    };
    let mut twin = Twin::new();
    // SAFETY: the stage lives as long as the twin.
    unsafe { (*twin.stage).set_scene(WORLD, scene) };
    for _ in 0..MOST_FRAMES {
        let textures = Textures::new(&twin.gpu, frame.size, color, depth);
        match twin.draw(&frame, &textures) {
            Some(status) if status.is_converged != 0 && status.awaits_feedback == 0 => {
                textures.read(&twin.gpu, color, depth);
                return status.samples as i32;
            }
            Some(_) => {}
            None => return -1,
        }
    }
    panic!("no end after {MOST_FRAMES} frames");
}

/// A stage of its own, on the device of all.
struct Twin {
    gpu: MutexGuard<'static, Gpu>,
    stage: *mut LumivoxStage,
}

impl Drop for Twin {
    fn drop(&mut self) {
        // What was made for it leaves the device, which stays.
        loop {
            // SAFETY: a live handle, and no views and worlds.
            let rest = unsafe { lumivox_stage_sweep(self.stage, null(), 0, null(), 0) };
            if rest.is_null() || self.replay(rest, 0).is_none() {
                break;
            }
        }
        // SAFETY: a live handle, freed once.
        unsafe { lumivox_stage_free(self.stage) };
    }
}

impl Twin {
    fn new() -> Self {
        let gpu = crate::gpu();
        // SAFETY: limits are there.
        let stage = unsafe { lumivox_stage_new(&crate::LIMITS) };
        assert!(!stage.is_null(), "there is a stage");
        Self { gpu, stage }
    }

    /// Draws a frame: the world, then the view. `None` where something is refused.
    fn draw(&mut self, frame: &LumivoxViewFrame, textures: &Textures) -> Option<LumivoxViewStatus> {
        let mut status = LumivoxViewStatus::default();
        // SAFETY: the stage lives as long as the twin, and the others are there.
        unsafe {
            lumivox_stage_begin_frame(self.stage);
            let world = lumivox_stage_record_world(self.stage, WORLD, frame.at_once);
            if !world.is_null() {
                self.replay(world, 0)?;
            }
            let view = lumivox_stage_record_view(self.stage, VIEW, WORLD, frame, &mut status);
            if view.is_null() {
                return None;
            }
            let names = [status.depth, status.color, status.written_depth].map(ResourceId);
            for (name, texture) in
                names.into_iter().zip([&textures.depth, &textures.color, &textures.written])
            {
                self.gpu.executor.lend_texture(name, texture);
            }
            self.replay(view, status.ticket)?;
            lumivox_stage_view_status(self.stage, VIEW, &mut status);
        }
        Some(status)
    }

    /// Replays a recording, waits for all that it brings back, and finishes it.
    fn replay(&mut self, recording: *mut LumivoxRecording, ticket: u64) -> Option<()> {
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
        (finished == 0).then_some(())
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
