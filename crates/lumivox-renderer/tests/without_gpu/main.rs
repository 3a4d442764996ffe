//! What the renderer records, seen without a GPU.

mod arrivals;
mod changes;
mod changing_light;
mod counts;
mod kept_light;
mod passes;
mod recordings;
mod scenes;
mod switches;
mod tables;
mod webgpu;
