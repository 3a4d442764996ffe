//! Golden images: a finished picture against the one in the repository.

use std::path::Path;

use crate::failures;
use crate::flip::flip;
use crate::png_io::SrgbImage;

/// Set this variable to `1` to write golden images instead of comparing with them. Look at them before committing.
pub const UPDATE_SWITCH: &str = "LUMIVOX_UPDATE_GOLDEN";

/// Why a picture is not its golden image.
#[derive(Debug)]
pub enum Mismatch {
    /// There is no golden image, or it cannot be read.
    Missing(std::io::Error),
    /// The sizes differ: golden, then actual.
    Size([usize; 2], [usize; 2]),
    /// It looks different.
    Differs {
        /// Mean FLIP difference.
        mean: f64,
        /// Largest FLIP difference.
        max: f64,
    },
}

/// Compares a picture with the golden image at `path`; the mean FLIP difference may be up to `threshold`.
///
/// # Errors
/// [`Mismatch`] when they do not match.
pub fn compare(path: &Path, image: &SrgbImage, threshold: f64) -> Result<(), Mismatch> {
    let golden = SrgbImage::read(path).map_err(Mismatch::Missing)?;
    let (expected, actual) = ([golden.width, golden.height], [image.width, image.height]);
    if expected != actual {
        return Err(Mismatch::Size(expected, actual));
    }
    let map = flip(&golden, image);
    let (mean, max) = (map.mean(), map.max());
    if mean <= threshold { Ok(()) } else { Err(Mismatch::Differs { mean, max }) }
}

/// [`compare`], or under [`UPDATE_SWITCH`] writes the golden image.
///
/// # Panics
/// When they do not match; the message says by how much, where both pictures and their difference are, and how to
/// accept the new one.
pub fn assert_golden(path: &Path, image: &SrgbImage, threshold: f64) {
    if std::env::var_os(UPDATE_SWITCH).is_some_and(|v| v == "1") {
        image.write(path).unwrap_or_else(|e| panic!("cannot write {}: {e}", path.display()));
        return;
    }
    let Err(mismatch) = compare(path, image, threshold) else { return };
    let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = failures::folder(&name);
    let written = write_pictures(&folder, path, image);
    let reason = match mismatch {
        Mismatch::Missing(error) => format!("there is no golden image ({error})"),
        Mismatch::Size([w, h], [x, y]) => format!("the golden image is {w} x {h}, this one {x} x {y}"),
        Mismatch::Differs { mean, max } => {
            format!("mean FLIP {mean:.4} is above {threshold:.4} (largest {max:.4})")
        }
    };
    let pictures = match written {
        Ok(()) => format!("see {}", folder.display()),
        Err(error) => format!("no pictures: {error}"),
    };
    panic!(
        "{}: {reason}; {pictures}. To accept the new picture, run again with {UPDATE_SWITCH}=1",
        path.display()
    );
}

fn write_pictures(folder: &Path, golden: &Path, image: &SrgbImage) -> std::io::Result<()> {
    image.write(&folder.join("image.png"))?;
    if let Ok(golden) = SrgbImage::read(golden) {
        golden.write(&folder.join("reference.png"))?;
        if (golden.width, golden.height) == (image.width, image.height) {
            flip(&golden, image).to_image().write(&folder.join("error.png"))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_golden_image_matches_itself_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("selftest-of-golden.png");
        let gray =
            |level: u8, width: usize| SrgbImage { width, height: 8, pixels: vec![[level; 3]; 8 * width] };
        assert!(matches!(compare(&path, &gray(100, 8), 0.01), Err(Mismatch::Missing(_))));
        gray(100, 8).write(&path).unwrap();
        assert!(compare(&path, &gray(100, 8), 0.0).is_ok());
        assert!(compare(&path, &gray(101, 8), 0.05).is_ok());
        assert!(matches!(compare(&path, &gray(200, 8), 0.05), Err(Mismatch::Differs { .. })));
        assert!(matches!(compare(&path, &gray(100, 9), 0.02), Err(Mismatch::Size(..))));

        let panic = std::panic::catch_unwind(|| assert_golden(&path, &gray(200, 8), 0.05)).unwrap_err();
        let message = panic.downcast_ref::<String>().unwrap();
        assert!(message.contains(UPDATE_SWITCH) && message.contains("lumivox-failures"), "{message}");
        std::fs::remove_dir_all(failures::folder("selftest-of-golden")).unwrap();
    }
}
