//! The Studio as a page: served on this machine, and tried in a browser.

mod browser;
mod serve;
mod trial;

use std::path::Path;

pub use serve::serve;

/// Opens a page's folder in a browser that nobody sees, and does what a person would; pictures of it go to a folder.
pub fn test(folder: &Path, browser: &Path, scan: &Path, pictures: &Path) -> Result<(), String> {
    trial::run(folder, browser, scan, pictures)
}
