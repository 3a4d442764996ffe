//! What panoramas of any format are held to.

use std::path::Path;

use crate::error::ImportError;

/// Wider panoramas are refused: they are damaged, or of no more use than smaller ones.
pub(crate) const WIDEST: usize = 16384;

/// Refuses sizes that no panorama has.
pub(crate) fn check_size(path: &Path, width: usize, height: usize) -> Result<(), ImportError> {
    let size = format!("is {width} x {height}");
    if width == 0 || height == 0 || width > WIDEST || height > WIDEST {
        return Err(ImportError::Field {
            path: path.to_owned(),
            field: "the image size".to_owned(),
            problem: size,
            remedy: format!("Use a panorama at most {WIDEST} texels wide"),
        });
    }
    // A little leeway for panoramas cut by hand.
    if width * 10 < height * 18 || width * 10 > height * 22 {
        return Err(ImportError::Field {
            path: path.to_owned(),
            field: "the image size".to_owned(),
            problem: format!("{size}, not twice as wide as high"),
            remedy: "Use an equirectangular panorama, not a cube map or a light probe".to_owned(),
        });
    }
    Ok(())
}

/// An error of a file that is not whole.
pub(crate) fn damaged(path: &Path, field: &str, problem: String) -> ImportError {
    ImportError::Field {
        path: path.to_owned(),
        field: field.to_owned(),
        problem,
        remedy: "Copy or export the file again".to_owned(),
    }
}
