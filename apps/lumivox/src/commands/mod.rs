//! One module per command.

pub mod doctor;
pub mod import;
pub mod info;
pub mod manual;
pub mod phantom;
pub mod presets;
pub mod render;
pub mod scene;
