//! A live view of a scene in a texture of the host's device, for programs with a user interface of their own.
//!
//! [`Viewport`] traces, tone-maps and paces: the host shows its texture and asks for frames until it [rests](PictureProgress::rests).
//! [`Profile`] and [`Gesture`] turn what a mouse does into an orbit of the camera; [`pick`] says what lies under a pixel. Nothing
//! here knows a window or a toolkit; clock and threads are `lumivox_core::host`'s, and nothing waits for the GPU, so that it fits
//! in a browser.
//!
//! The walk: scene and camera -> `Stage` -> recordings -> executor -> scene-linear colour -> [tone map](Viewport::texture).

mod controls;
mod display;
mod pace;
mod pick;
mod viewport;

pub use controls::{Button, Gesture, Held, Profile, SliceGesture, center_of, orbit_of};
pub use pace::Pace;
pub use pick::{Picked, pick};
pub use viewport::{Picture, PictureProgress, Viewport, ViewportError};
