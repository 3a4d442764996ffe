//! Scene files: what a viewport shows is written down, and a file becomes nodes. The files themselves are the core's
//! `document` and `lumivox-scene`; numbers that nodes would round are kept beside them, so that a scene that is opened and
//! saved unchanged is the same.

use std::path::Path;

mod nodes;
mod open;
mod save;

pub use nodes::packed;
pub use open::{OpenedScene, open};
pub use save::save;

/// How the names of scene files end in engines.
pub const SCENE_EXTENSION: &str = "lumivox";

/// Metadata of a camera: world from camera and its angle in radians, as a scene file has them. It holds as long as the node's
/// own are those.
const EXACT_CAMERA: &str = "lumivox_camera";

/// What a scene of a file is called: as the file is, without its ending.
pub fn name_of(file: &Path) -> String {
    file.file_stem().map_or_else(|| "Scene".to_owned(), |stem| stem.to_string_lossy().into_owned())
}
