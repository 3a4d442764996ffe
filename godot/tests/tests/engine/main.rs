//! The addon in a real Godot, under a display that nobody sees.
//!
//! Nothing here skips: without an engine or a display these tests fail, and say what to install.

mod case;
mod engine;
mod expected;
mod pictures;
