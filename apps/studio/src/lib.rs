//! Lumivox Studio: drop a scan, see the anatomy.
//!
//! [`App`] and its panels show a [`State`](state::State) of plain data; what people want is an [`Action`](state::Action). The state's
//! heart is a scene document with one stack of commands ([`session`], [`history`]): saving, undo and exchange with every other host
//! follow from that. Long work is in [`jobs`], begun by [`errands`]: on threads, or in a page's Worker. Files, dialogs and settings
//! are the host's: `native` or `web`.

pub mod app;
#[cfg_attr(target_family = "wasm", path = "web/archive.rs")]
pub mod archive;
pub mod arrivals;
pub mod darkroom;
#[cfg_attr(target_family = "wasm", path = "web/errands.rs")]
pub mod errands;
#[cfg_attr(target_family = "wasm", path = "web/files.rs")]
pub mod files;
mod grid;
pub mod history;
pub mod jobs;
pub mod leaders;
mod live;
pub mod measuring;
#[cfg(not(target_family = "wasm"))]
pub mod native;
pub mod opening;
pub mod overlay;
mod panels;
pub mod parcel;
pub mod rescue;
pub mod session;
pub mod settings;
pub mod sharing;
pub mod slices;
pub mod state;
pub mod theme;
#[cfg(not(target_family = "wasm"))]
pub mod turntable;
#[cfg(target_family = "wasm")]
pub mod web;
pub mod words;

use std::sync::Arc;

use eframe::{egui_wgpu, wgpu};

pub use app::{App, Chooser, Launch};

/// The device that the interface opens, for the renderer to draw on, too.
pub fn gpu_options() -> egui_wgpu::WgpuConfiguration {
    let mut setup = egui_wgpu::WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = wgpu::Backends::PRIMARY;
    setup.power_preference = wgpu::PowerPreference::HighPerformance;
    #[cfg(not(target_family = "wasm"))]
    {
        setup.native_adapter_selector = Some(Arc::new(native::choose_adapter));
    }
    setup.device_descriptor = Arc::new(|adapter| wgpu::DeviceDescriptor {
        label: Some("lumivox-studio"),
        required_features: adapter.features() & lumivox_wgpu::WANTED_FEATURES,
        required_limits: lumivox_wgpu::wanted_limits(adapter),
        memory_hints: wgpu::MemoryHints::MemoryUsage,
        ..Default::default()
    });
    egui_wgpu::WgpuConfiguration { wgpu_setup: egui_wgpu::WgpuSetup::CreateNew(setup), ..Default::default() }
}
