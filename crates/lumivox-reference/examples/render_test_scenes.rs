//! Renders every test scene with the reference and prints how fast: `cargo run --release --example
//! render_test_scenes -- <folder> [samples] [size]`.

use std::path::PathBuf;
use std::time::Instant;

use lumivox_reference::{ReferenceSettings, render};
use lumivox_testing::{png_io::SrgbImage, scenes};

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().unwrap_or_else(|| "reference-images".into()));
    let mut number = |default| arguments.next().and_then(|a| a.parse().ok()).unwrap_or(default);
    let (samples, size) = (number(64), number(96));
    let settings =
        ReferenceSettings { width: size as usize, height: size as usize, samples, ..Default::default() };
    for test in scenes::all() {
        let start = Instant::now();
        let image = render(&test.scene, &test.camera, &settings);
        let rate = f64::from(size * size * samples) / start.elapsed().as_secs_f64() / 1e6;
        let [red, ..] = image.mean_radiance();
        println!(
            "{:20} {rate:6.2} million samples/s, mean alpha {:.3}, mean red {:.4} +- {:.4}",
            test.name,
            image.mean_alpha().0,
            red.0,
            red.1
        );
        // Over black: the radiance is premultiplied.
        let picture = SrgbImage::from_linear(image.width, image.height, &image.radiance);
        picture.write(&folder.join(format!("{}.png", test.name)))?;
    }
    Ok(())
}
