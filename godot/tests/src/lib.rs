//! Tests of the Godot addon in a real Godot; there is nothing else here.
//!
//! `tests/engine` describes scenes, has Godot build and show them (`project/` holds what runs there), and compares the
//! screenshots with what the renderer makes of the same scenes on wgpu. `GODOT` names the engine; `script/test` finds
//! or fetches one.
