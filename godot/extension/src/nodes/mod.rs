//! What stands in a scene.

mod clip_3d;
mod volume_3d;

pub use clip_3d::LumivoxClip3D;
pub use volume_3d::{LumivoxVolume3D, MAX_GRADIENT};
