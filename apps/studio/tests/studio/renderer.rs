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

/// A texture for a window of so many pixels.
pub fn target(state: &RenderState, [width, height]: [u32; 2]) -> wgpu::Texture {
    state.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("window"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: state.target_format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// The window's size in pixels.
fn size_of(context: &Context) -> [u32; 2] {
    let size = context.content_rect().size() * context.pixels_per_point();
    [size.x, size.y].map(|n| n.round() as u32)
}

/// Paints the window into a texture of its size.
pub fn paint(state: &RenderState, context: &Context, output: &FullOutput, target: &wgpu::TextureView) {
    let (device, queue) = (&state.device, &state.queue);
    let scale = context.pixels_per_point();
    let screen = ScreenDescriptor { pixels_per_point: scale, size_in_pixels: size_of(context) };
    let shapes = context.tessellate(output.shapes.clone(), scale);
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut painter = state.renderer.write();
    let uploads = painter.update_buffers(device, queue, &mut encoder, &shapes, &screen);
    let mut pass = encoder
        .begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
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
    queue.submit(uploads.into_iter().chain([encoder.finish()]));
}
