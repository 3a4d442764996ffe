//! 8-bit sRGB pictures and the PNG files they live in.

use std::fs::File;
use std::io::{self, BufReader, BufWriter};
use std::path::Path;

/// An opaque picture of 8-bit sRGB pixels, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SrgbImage {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// `width * height` pixels.
    pub pixels: Vec<[u8; 3]>,
}

impl SrgbImage {
    /// A picture of linear RGB; what lies outside 0..1 is clipped, what is not a number is black.
    ///
    /// # Panics
    /// When there are not `width * height` pixels.
    pub fn from_linear(width: usize, height: usize, linear: &[[f64; 3]]) -> Self {
        assert_eq!(linear.len(), width * height, "one colour for every pixel");
        let encode = |c: f64| (srgb_from_linear(c.clamp(0.0, 1.0)) * 255.0).round() as u8;
        Self { width, height, pixels: linear.iter().map(|rgb| rgb.map(encode)).collect() }
    }

    /// The pixels as linear RGB.
    pub fn to_linear(&self) -> Vec<[f64; 3]> {
        self.pixels.iter().map(|p| p.map(|c| linear_from_srgb(f64::from(c) / 255.0))).collect()
    }

    /// Reads an opaque 8-bit PNG, grey or RGB.
    ///
    /// # Errors
    /// When the file cannot be read, or has transparency or 16-bit samples: a comparison would ignore them.
    pub fn read(path: &Path) -> io::Result<Self> {
        let mut reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
        let size = reader.output_buffer_size().ok_or_else(|| io::Error::other("the picture is too large"))?;
        let mut bytes = vec![0; size];
        let info = reader.next_frame(&mut bytes)?;
        bytes.truncate(info.buffer_size());
        let pixels = match (info.color_type, info.bit_depth) {
            (png::ColorType::Rgb, png::BitDepth::Eight) => bytes.as_chunks::<3>().0.to_vec(),
            (png::ColorType::Grayscale, png::BitDepth::Eight) => bytes.iter().map(|&g| [g; 3]).collect(),
            (color, depth) => {
                let found = format!("{} is {color:?} of {depth:?} bits, not opaque 8-bit", path.display());
                return Err(io::Error::other(found));
            }
        };
        Ok(Self { width: info.width as usize, height: info.height as usize, pixels })
    }

    /// Writes a PNG, and the folders that lead to it.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let (width, height) = (self.width as u32, self.height as u32);
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(())
    }
}

/// The sRGB code of a linear intensity in 0..1 (IEC 61966-2-1). Not the core's: what judges shares nothing with it.
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The linear intensity of an sRGB code in 0..1 (IEC 61966-2-1).
pub fn linear_from_srgb(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_survives_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/down/picture.png");
        let pixels = (0..12).map(|i| [i, 255 - i, 7 * i]).collect();
        let image = SrgbImage { width: 4, height: 3, pixels };
        image.write(&path).unwrap();
        assert_eq!(SrgbImage::read(&path).unwrap(), image);
    }

    #[test]
    fn codes_and_intensities_are_inverse() {
        let codes: Vec<[u8; 3]> = (0..=255).map(|i| [i; 3]).collect();
        let image = SrgbImage { width: 16, height: 16, pixels: codes };
        assert_eq!(SrgbImage::from_linear(16, 16, &image.to_linear()), image);
        assert_eq!(SrgbImage::from_linear(1, 1, &[[-1.0, 2.0, f64::NAN]]).pixels[0], [0, 255, 0]);
    }
}
