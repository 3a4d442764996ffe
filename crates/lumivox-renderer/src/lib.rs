//! Turns a scene, a camera and a budget into a [`Recording`]: what a host has to do on its GPU, in order.
//!
//! This crate owns no device and knows no graphics API, window or engine. The host keeps a [`VoxelStore`] per device, a
//! [`SceneCache`] per scene and a [`View`] per camera, asks them to record, and replays the recording with its executor
//! (`lumivox-wgpu` is one). The walk: [`SceneCache::update`] puts volumes, tables, majorants and light on the GPU;
//! [`View::record_samples`] traces; [`View::record_display`] or [`View::record_read_film`] brings the image out.
//! An engine keeps a [`LiveView`] instead: it traces within a frame's budget and draws over the engine's own image.
//!
//! Nothing that takes long has to happen in a frame: [`SceneCache::kernels`] names the kernels that a scene will want, a
//! [`Workshop`] makes them on threads of its own, and a [`Preparation`] computes what an update would have to.

mod denoise;
mod derived;
pub mod display;
mod error;
mod features;
pub mod film;
mod frame;
mod ids;
mod limits;
pub mod live;
mod noise_end;
pub mod pacing;
pub mod recording;
mod scene_cache;
pub mod stage;
mod store;
mod unfinished;
mod view;
mod workshop;

pub use display::{Background, DisplaySettings, ToneMap};
pub use error::RenderError;
pub use features::{Features, ViewKind};
pub use film::Film;
pub use limits::{DeviceLimits, FineTexels, LoopTurns};
pub use live::{
    DistanceFog, Fog, HeightFog, HostDepth, HostFrame, HostVelocity, LiveSettings, LiveStatus, LiveView,
};
pub use lumivox_shaders::layout::FilmCount;
pub use noise_end::NoiseEnd;
pub use recording::{Recording, ResourceId, Step};
pub use scene_cache::{CellSize, EnvironmentSampling, Preparation, SceneCache};
pub use store::{Resolution, VoxelStore, prepare_volume};
pub use view::{View, ViewSettings};
pub use workshop::Workshop;

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
