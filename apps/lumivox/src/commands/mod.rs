//! One module per command.

pub mod doctor;
pub mod import;
pub mod info;
pub mod manual;
pub mod phantom;
pub mod presets;
pub mod render;
pub mod scene;

use serde_json::{Value, json};

/// A failure, for programs.
pub fn error_object(message: &str, exit: u8) -> Value {
    json!({ "error": message, "exit_code": exit })
}
