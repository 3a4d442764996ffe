//! Makes a volume, gives it a look, and path-traces it to a PNG: `cargo run --release --example hello_volume`.

use std::ops::ControlFlow;
use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Ease, Medium, Modality, Scene, TransferFunction, Volume, Voxels, framing};
use lumivox_renderer::DisplaySettings;
use lumivox_wgpu::{Gpu, RenderRequest, render};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A volume is a grid of numbers with a place in the patient: here a gyroid, 64 voxels of 2 mm a side.
    let value = |i: usize| {
        let [x, y, z] = [i % 64, i / 64 % 64, i / 4096].map(|n| n as f32 * 0.3);
        x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
    };
    let voxels = Voxels::F32((0..64 * 64 * 64).map(value).collect());
    let place = DAffine3::from_scale(DVec3::splat(2.0));
    let volume = Volume::new([64; 3], voxels, [1.0, 0.0], place, Modality::Other)?;

    // A look maps values to opacity and colour; light does the rest.
    let look = TransferFunction::from_points(
        Ease::InOut,
        &[(0.4, 0.0), (0.7, 1.0)],
        &[(0.4, [0.9, 0.35, 0.2]), (1.2, [0.95, 0.8, 0.6])],
    )?;
    let scene = Scene::with_volume(Arc::new(volume), Medium { density_scale: 2.0, ..Medium::new(look) });
    let camera = framing::frame(&scene, 0.5, 0.4, 0.5, 1.0).camera();

    let mut gpu = Gpu::open(None)?;
    let request = RenderRequest::new(256, 256, 32);
    let rendered = render(&mut gpu, &scene, &camera, &request, &mut |_| ControlFlow::Continue(()))?;

    let pixels = DisplaySettings::default().pixels(&rendered.film, &scene.environment, &camera);
    let path = std::env::temp_dir().join("lumivox_hello_volume.png");
    let mut encoder = png::Encoder::new(std::fs::File::create(&path)?, 256, 256);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header()?.write_image_data(pixels.as_flattened())?;
    println!("{} on {}", path.display(), gpu.description.name);
    Ok(())
}
