//! What a program in a browser has of it, where others ask their system: the clock, files that somebody gave, and a pause in which the
//! browser draws. What the Studio's page and the npm package share; elsewhere there is nothing here.
#![cfg(target_family = "wasm")]

mod clock;
mod device;
mod files;

pub use clock::{begin, pause};
pub use device::{best_texels, pace};
pub use files::give_files;
