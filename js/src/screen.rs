//! A canvas as a GPU shows something on it.

use lumivox_wgpu::{Gpu, wgpu};
use wasm_bindgen::prelude::*;

use crate::wrong;

/// That of what a viewport shows: both are copied, not drawn.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// What is shown on a canvas.
pub struct Screen {
    surface: wgpu::Surface<'static>,
    size: [u32; 2],
}

impl Screen {
    /// A canvas of a page's or a Worker's, and a device that can show something on it.
    pub async fn open(canvas: JsValue) -> Result<(Self, Gpu), JsError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::BROWSER_WEBGPU;
        let instance = wgpu::Instance::new(descriptor);
        let (target, size) = match canvas.dyn_into::<web_sys::HtmlCanvasElement>() {
            Ok(canvas) => {
                let size = [canvas.width(), canvas.height()];
                (wgpu::SurfaceTarget::Canvas(canvas), size)
            }
            Err(other) => {
                let canvas: web_sys::OffscreenCanvas =
                    other.dyn_into().map_err(|_| wrong("a view needs a canvas, or an OffscreenCanvas"))?;
                let size = [canvas.width(), canvas.height()];
                (wgpu::SurfaceTarget::OffscreenCanvas(canvas), size)
            }
        };
        let surface = instance.create_surface(target).map_err(wrong)?;
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: Some(&surface),
            ..Default::default()
        };
        let adapter = instance.request_adapter(&options).await.map_err(wrong)?;
        let gpu = Gpu::request_on(&adapter).await.map_err(wrong)?;
        let mut screen = Self { surface, size: [0; 2] };
        screen.resize(gpu.executor.device(), size);
        Ok((screen, gpu))
    }

    /// Gives the canvas so many pixels.
    pub fn resize(&mut self, device: &wgpu::Device, [width, height]: [u32; 2]) {
        self.size = [width, height].map(|n| n.clamp(1, device.limits().max_texture_dimension_2d));
        self.surface.configure(
            device,
            &wgpu::SurfaceConfiguration {
                usage: wgpu::TextureUsages::COPY_DST,
                format: FORMAT,
                width: self.size[0],
                height: self.size[1],
                present_mode: wgpu::PresentMode::AutoVsync,
                desired_maximum_frame_latency: 2,
                alpha_mode: wgpu::CompositeAlphaMode::Opaque,
                view_formats: vec![],
            },
        );
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Shows a texture of the canvas' size when the browser draws next.
    pub fn show(&self, gpu: &Gpu, shown: &wgpu::Texture) -> Result<(), JsError> {
        let surface = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(surface)
            | wgpu::CurrentSurfaceTexture::Suboptimal(surface) => surface,
            _ => return Err(wrong("the canvas takes no pictures any more")),
        };
        let device = gpu.executor.device();
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_texture(
            shown.as_image_copy(),
            surface.texture.as_image_copy(),
            surface.texture.size(),
        );
        gpu.executor.queue().submit([encoder.finish()]);
        surface.present();
        Ok(())
    }
}
