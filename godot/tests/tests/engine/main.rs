//! The addon in a real Godot, under a display that nobody sees.
//!
//! Nothing here skips: without an engine, a display or a simulated headset these tests fail, and say what to install.
//! Scans of real patients are not in the repository; where they are absent, that is printed.

mod antialiasing;
mod beside_unity;
mod case;
mod codecs;
mod demo;
mod editor;
mod editor_controls;
mod effects;
mod engine;
mod expected;
mod export;
mod film;
mod first_import;
mod folders;
mod functions;
mod installed;
mod interpolation;
mod lights;
mod many;
mod motion;
mod node;
mod pictures;
mod refraction;
mod runtime_import;
mod scans;
mod scene_files;
mod script;
mod shown;
mod skies;
mod stalls;
mod warnings;
mod xr;
