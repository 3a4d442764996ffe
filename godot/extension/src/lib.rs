//! Lumivox in Godot: scans as resources, volumes as nodes, path traced on the engine's own RenderingDevice.
//!
//! The walk of a frame: `server` gathers the worlds that hold volumes on the main thread (`world`) and leaves them
//! in `shared`, with what their `effect::LumivoxEffect` asks for; the singleton is called on the render thread, in the
//! effect's place, while the engine draws a viewport, and `render` traces into its colour with the steps that
//! `executor` replays. Nothing but plain Rust and RIDs crosses between the threads.

mod codecs;
mod convert;
mod effect;
mod executor;
mod host_view;
mod importer;
mod kept_paths;
mod load_options;
mod nodes;
mod render;
mod resources;
mod scene_file;
mod server;
mod shared;
mod warm_up;
mod world;

use godot::init::InitStage;
use godot::prelude::*;

struct LumivoxExtension;

#[gdextension]
unsafe impl ExtensionLibrary for LumivoxExtension {
    fn on_stage_init(stage: InitStage) {
        if stage == InitStage::MainLoop {
            codecs::start();
            server::start();
        }
    }

    fn on_main_loop_frame() {
        importer::deliver();
        server::deliver();
        server::settle_if_idle();
    }

    fn on_stage_deinit(stage: InitStage) {
        if stage == InitStage::MainLoop {
            importer::stop_all();
            server::stop();
        }
    }
}
