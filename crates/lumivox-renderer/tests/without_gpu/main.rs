//! What the renderer records, seen without a GPU.

mod changes;
mod recordings;
mod scenes;
