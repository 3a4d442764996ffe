//! What stands in a scene.

mod clip_3d;
mod volume_3d;

pub use volume_3d::LumivoxVolume3D;
