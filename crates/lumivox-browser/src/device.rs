//! What a page's GPU is like: nothing waits for it, so that it is asked between the browser's turns.

use lumivox_renderer::FineTexels;
use lumivox_viewport::Pace;
use lumivox_wgpu::{FilterTest, GpuError, wgpu};

use crate::pause;

/// How a device stores voxels of more than 8 bits best.
///
/// # Errors
/// [`GpuError::Lost`] when the device is gone.
pub async fn best_texels(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<FineTexels, GpuError> {
    let mut test = FilterTest::begin(device, queue);
    loop {
        match test.poll() {
            Some(found) => return found,
            None => pause().await,
        }
    }
}

/// How much of a frame's time goes into tracing. A browser that has a processor do a GPU's work does it slowly, and each of its frames
/// costs much whatever is traced in it: there are fewer and longer ones, of a coarser film.
pub fn pace(software: bool) -> Pace {
    let usual = Pace::of(software);
    if software { Pace { resting: 1000.0, most_pixels: 1 << 14, ..usual } } else { usual }
}
