//! Path-traced scans on a web page's canvas: the WebAssembly of the npm package `lumivox`, see `README.md` beside it.
//!
//! A `Scan` is voxels with their place, from a program's arrays or read from files by a Worker; a `Canvas` shows a scene document
//! of such. What is easier said in the browser's own language (frames, the mouse, sizes, Workers) is in `package/lumivox.js`, which
//! people call.
#![cfg(target_family = "wasm")]

mod canvas;
mod read;
mod scan;
mod screen;

use wasm_bindgen::prelude::*;

pub use canvas::{Canvas, Told};
pub use read::read;
pub use scan::Scan;

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_namespace = console)]
    fn error(text: &str);
}

/// Before anything else, in a page and in its Workers.
#[wasm_bindgen(start)]
pub fn begin() {
    lumivox_browser::begin();
    // Only a fault of ours panics. Who called hears of it as `unreachable`; why is for programmers.
    std::panic::set_hook(Box::new(|panic| error(&panic.to_string())));
}

/// An error with words, as JavaScript throws it.
fn wrong(why: impl std::fmt::Display) -> JsError {
    JsError::new(&why.to_string())
}

/// The names of looks, and what each is for: JSON of pairs.
///
/// # Errors
/// Never.
#[wasm_bindgen]
pub fn presets() -> Result<String, JsError> {
    let all = lumivox_core::Preset::ALL.iter().map(|preset| (preset.name(), preset.description()));
    serde_json::to_string(&all.collect::<Vec<_>>()).map_err(wrong)
}
