//! What draws the window in tests: eframe's own painter, on the device that the program gets.

use eframe::egui::{Context, FullOutput, TexturesDelta};
use eframe::egui_wgpu::{RenderState, RendererOptions, ScreenDescriptor};
use eframe::wgpu;
use egui_kittest::TestRenderer;

/// A device, and the painter's textures on it.
pub struct Painter(RenderState);

impl Painter {
    pub fn new() -> Self {
        let options = lumivox_studio::gpu_options();
        let instance = pollster::block_on(options.wgpu_setup.new_instance());
        let state = RenderState::create(&options, &instance, None, RendererOptions::PREDICTABLE);
        Self(
            pollster::block_on(state)
                .expect("a GPU or software Vulkan (Debian: apt-get install mesa-vulkan-drivers)"),
        )
    }
}

impl TestRenderer for Painter {
    fn setup_eframe(&self, context: &mut eframe::CreationContext<'_>, _: &mut eframe::Frame) {
        context.wgpu_render_state = Some(self.0.clone());
    }

    fn handle_delta(&mut self, delta: &TexturesDelta) {
        let mut painter = self.0.renderer.write();
        for (id, image) in &delta.set {
            painter.update_texture(&self.0.device, &self.0.queue, *id, image);
        }
    }
}

/// The window's size in pixels, and red, green, blue and alpha of each; waits for it.
pub fn draw(state: &RenderState, context: &Context, output: &FullOutput) -> (u32, u32, Vec<u8>) {
    let (device, queue) = (&state.device, &state.queue);
    let scale = context.pixels_per_point();
    let size = context.content_rect().size() * scale;
    let [width, height] = [size.x, size.y].map(|n| n.round() as u32);
    let screen = ScreenDescriptor { pixels_per_point: scale, size_in_pixels: [width, height] };
    let shapes = context.tessellate(output.shapes.clone(), scale);
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("window"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: state.target_format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut painter = state.renderer.write();
    let uploads = painter.update_buffers(device, queue, &mut encoder, &shapes, &screen);
    let mut pass = encoder
        .begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.create_view(&Default::default()),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        })
        .forget_lifetime();
    painter.render(&mut pass, &shapes, &screen);
    drop(pass);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let copy = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(target.as_image_copy(), copy, target.size());
    queue.submit(uploads.into_iter().chain([encoder.finish()]));
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    device.poll(wgpu::PollType::Wait { submission_index: None, timeout: None }).unwrap();
    let bytes = buffer.slice(..).get_mapped_range();
    let is_bgra = state.target_format.remove_srgb_suffix() == wgpu::TextureFormat::Bgra8Unorm;
    let pixels = bytes.chunks_exact(row as usize).flat_map(|row| row[..4 * width as usize].chunks_exact(4));
    let rgba = pixels.flat_map(|p| if is_bgra { [p[2], p[1], p[0], p[3]] } else { [p[0], p[1], p[2], p[3]] });
    (width, height, rgba.collect())
}
