//! The window's pixels.

use eframe::egui::{Context, FullOutput};
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;

use super::renderer::{paint, target};

/// The window's size in pixels, and red, green, blue and alpha of each; waits for it.
pub fn draw(state: &RenderState, context: &Context, output: &FullOutput) -> (u32, u32, Vec<u8>) {
    let (device, queue) = (&state.device, &state.queue);
    let size = context.content_rect().size() * context.pixels_per_point();
    let [width, height] = [size.x, size.y].map(|n| n.round() as u32);
    let target = target(state, [width, height]);
    paint(state, context, output, &target.create_view(&Default::default()));
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let copy = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(target.as_image_copy(), copy, target.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    device.poll(wgpu::PollType::Wait { submission_index: None, timeout: None }).unwrap();
    let bytes = buffer.slice(..).get_mapped_range();
    let is_bgra = state.target_format.remove_srgb_suffix() == wgpu::TextureFormat::Bgra8Unorm;
    let pixels = bytes.chunks_exact(row as usize).flat_map(|row| row[..4 * width as usize].chunks_exact(4));
    let rgba = pixels.flat_map(|p| if is_bgra { [p[2], p[1], p[0], p[3]] } else { [p[0], p[1], p[2], p[3]] });
    (width, height, rgba.collect())
}
