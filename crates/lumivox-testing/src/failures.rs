//! Pictures of what went wrong, in a folder that the failing assertion names.

use std::io;
use std::path::{Path, PathBuf};

use crate::png_io::SrgbImage;

/// The folder for a failing test's pictures: `lumivox-failures/<test>` in Cargo's target folder.
pub fn folder(test: &str) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from).unwrap_or_else(|| {
        let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2);
        workspace.expect("this crate lies in crates/").join("target")
    });
    // Tests are named by what they test; a name must not climb out of the folder.
    let name = test.replace(|c: char| !c.is_ascii_alphanumeric() && c != '-' && c != '_', "_");
    target.join("lumivox-failures").join(name)
}

/// Two images that should have been alike, and how likely each value's difference is. All have `channels` (1 or 3)
/// values per pixel.
#[derive(Clone, Copy, Debug)]
pub struct Difference<'a> {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Values per pixel: 1 or 3.
    pub channels: usize,
    /// The image under test.
    pub image: &'a [f64],
    /// What it should be.
    pub reference: &'a [f64],
    /// p-value of every difference; rejected ones (under `threshold`) are painted red.
    pub p_values: &'a [f64],
    /// The p-value under which a difference is rejected.
    pub threshold: f64,
}

impl Difference<'_> {
    /// Writes `image.png`, `reference.png` (both as bright as shows the reference best), `error.png` (the largest
    /// difference is white) and `p_value.png` into [`folder`]`(test)`, and returns it.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, test: &str) -> io::Result<PathBuf> {
        let folder = folder(test);
        let error: Vec<f64> = self.image.iter().zip(self.reference).map(|(a, b)| (a - b).abs()).collect();
        // A sun in a few pixels must not leave the rest black.
        let mut sorted: Vec<f64> = self.reference.iter().map(|v| v.abs()).collect();
        sorted.sort_by(f64::total_cmp);
        let white = sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(1.0);
        let largest = error.iter().copied().filter(|e| e.is_finite()).fold(0.0, f64::max);
        self.picture(self.image, white).write(&folder.join("image.png"))?;
        self.picture(self.reference, white).write(&folder.join("reference.png"))?;
        self.picture(&error, largest).write(&folder.join("error.png"))?;
        let p_values: Vec<[f64; 3]> = self
            .p_values
            .chunks(self.channels)
            .map(|p| {
                let p = p.iter().copied().fold(1.0, f64::min);
                if p < self.threshold { [1.0, 0.0, 0.0] } else { [p; 3] }
            })
            .collect();
        SrgbImage::from_linear(self.width, self.height, &p_values).write(&folder.join("p_value.png"))?;
        Ok(folder)
    }

    fn picture(&self, values: &[f64], white: f64) -> SrgbImage {
        let scale = if white > 0.0 { 1.0 / white } else { 1.0 };
        let pixels: Vec<[f64; 3]> = values
            .chunks(self.channels)
            .map(|v| std::array::from_fn(|i| v[i.min(self.channels - 1)] * scale))
            .collect();
        SrgbImage::from_linear(self.width, self.height, &pixels)
    }
}
