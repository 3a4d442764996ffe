//! Pictures for files, traced between the page's frames.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use eframe::wgpu;
use lumivox_browser::pause;
use lumivox_core::PerspectiveCamera;
use lumivox_core::Scene;
use lumivox_core::color::{linear_from_srgb, srgb_from_linear};
use lumivox_core::document::{Backdrop, Display, SceneDocument};
use lumivox_viewport::{Pace, Picture, Viewport};
use lumivox_wgpu::Gpu;

use super::with_page;
use crate::darkroom::{self, DEFAULT_SAMPLES, Exported, Tile};
use crate::jobs::{Busy, Desk};

/// Renders what a document says, and keeps it.
///
/// # Errors
/// Why there is no picture.
pub(crate) async fn expose(
    document: &SceneDocument,
    scene: &Scene,
    camera: &PerspectiveCamera,
    file: &Path,
    desk: &Desk<Exported>,
) -> Result<(), String> {
    let size = document.film.size;
    let mut viewport = of_page(size)?;
    let (device, queue) = (viewport.gpu().executor.device().clone(), viewport.gpu().executor.queue().clone());
    if viewport.size() != size {
        return Err(format!(
            "a page's pictures have at most {} pixels a side",
            viewport.size()[0].max(viewport.size()[1])
        ));
    }
    let mut display = document.display;
    if display.background == Backdrop::Transparent {
        display.background = Backdrop::Color([0; 3]);
    }
    let draw = |viewport: &mut Viewport, display: &Display| {
        let samples = document.film.samples.unwrap_or(DEFAULT_SAMPLES);
        let seed = document.film.seed;
        viewport
            .frame(&Picture { scene, version: 1, camera, display, samples, seed })
            .map_err(|error| error.to_string())
    };
    loop {
        if desk.cancel().is_cancelled() {
            return Ok(());
        }
        let progress = draw(&mut viewport, &display)?;
        if progress.rests {
            break;
        }
        desk.report(Busy { stage: None, done: (progress.part * 1000.0) as u64, total: 1000 });
        pause().await;
    }
    let mut rgba = pixels(&device, &queue, viewport.texture()).await?;
    if document.display.background == Backdrop::Transparent {
        let white = Display { background: Backdrop::Color([255; 3]), ..display };
        draw(&mut viewport, &white)?;
        let on_white = pixels(&device, &queue, viewport.texture()).await?;
        take_off(&mut rgba, &on_white);
    }
    darkroom::keep(file, &darkroom::Picture { size, rgba })
}

/// A view on the page's device.
fn of_page(size: [u32; 2]) -> Result<Viewport, String> {
    let of_page = with_page(|page| page.device.clone().map(|device| (device, page.fine_texels))).flatten();
    let ((device, queue), fine_texels) = of_page.ok_or("there is no GPU")?;
    let mut gpu = Gpu::of_device(device, queue);
    if let Some(fine_texels) = fine_texels {
        gpu.executor.store_as(fine_texels);
    }
    let mut viewport = Viewport::new(gpu, size);
    // All of its pixels, whoever traces them.
    *viewport.pace_mut() = Pace::of(false);
    Ok(viewport)
}

/// What makes tiles of looks, between frames: kernels are made once for all of them.
pub(crate) struct TilePress {
    viewport: Viewport,
    made: u64,
}

impl TilePress {
    /// # Errors
    /// Where there is no GPU.
    pub(crate) fn new() -> Result<Self, String> {
        Ok(Self { viewport: of_page([darkroom::TILE; 2])?, made: 0 })
    }

    /// A picture of a scene, of so many samples; none where that was cancelled.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) async fn print(
        &mut self,
        document: &SceneDocument,
        scene: &Scene,
        samples: u32,
        desk: &Desk<Tile>,
    ) -> Result<Option<darkroom::Picture>, String> {
        let camera = document.camera.camera(scene, 1.0).ok_or("there is nothing to see")?;
        let mut display = document.display;
        if display.background == Backdrop::Transparent {
            display.background = Backdrop::Color([0; 3]);
        }
        self.made += 1;
        loop {
            if desk.cancel().is_cancelled() {
                return Ok(None);
            }
            let (version, seed) = (self.made, document.film.seed);
            let picture = Picture { scene, version, camera: &camera, display: &display, samples, seed };
            if self.viewport.frame(&picture).map_err(|error| error.to_string())?.rests {
                break;
            }
            pause().await;
        }
        let executor = &self.viewport.gpu().executor;
        let rgba = pixels(executor.device(), executor.queue(), self.viewport.texture()).await?;
        Ok(Some(darkroom::Picture { size: [darkroom::TILE; 2], rgba }))
    }
}

/// What a picture is without what is behind it, of the same picture on black and on white.
fn take_off(on_black: &mut [u8], on_white: &[u8]) {
    let linear: [f64; 256] = std::array::from_fn(|code| linear_from_srgb(code as f64 / 255.0));
    for (pixel, white) in on_black.chunks_exact_mut(4).zip(on_white.chunks_exact(4)) {
        let light = |pixel: &[u8], channel: usize| linear[usize::from(pixel[channel])];
        let through = (0..3).map(|c| light(white, c) - light(pixel, c)).sum::<f64>() / 3.0;
        let alpha = (1.0 - through).clamp(0.0, 1.0);
        for channel in 0..3 {
            let own = light(pixel, channel) / alpha.max(1.0 / 255.0);
            pixel[channel] = (srgb_from_linear(own.min(1.0)) * 255.0 + 0.5) as u8;
        }
        pixel[3] = (alpha * 255.0 + 0.5) as u8;
    }
}

/// What is in a texture of four bytes a pixel.
async fn pixels(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, String> {
    let (width, height) = (texture.width(), texture.height());
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        texture.size(),
    );
    queue.submit([encoder.finish()]);
    let mapped = Arc::new(OnceLock::new());
    let told = mapped.clone();
    buffer.map_async(wgpu::MapMode::Read, .., move |outcome| {
        let _ = told.set(outcome.is_ok());
    });
    let is_mapped = loop {
        if let Some(is_mapped) = mapped.get() {
            break *is_mapped;
        }
        pause().await;
    };
    if !is_mapped {
        return Err("the GPU does not give the picture back".to_owned());
    }
    let bytes = buffer.slice(..).get_mapped_range();
    Ok(bytes.chunks_exact(row as usize).flat_map(|line| &line[..4 * width as usize]).copied().collect())
}
