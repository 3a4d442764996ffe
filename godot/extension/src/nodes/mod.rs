//! What stands in a scene.

mod volume_3d;

pub use volume_3d::LumivoxVolume3D;
